"""`gim workspace`: files, JSON, grids, and resuming after an interruption."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bundled import MODELS
from typer.testing import CliRunner

from gimcli import GimError, load
from gimcli.cli import app
from gimcli.families.grid import carried_by, input_grid
from gimcli.kernels import jit
from gimcli.motion.scatter import Scatterer, scattered
from gimcli.motion.solve import solve
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options


def run(*arguments: str) -> str:
    result = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_a_region_is_reported_as_json_and_written(tmp_path: Path) -> None:
    report = json.loads(run("workspace", str(MODELS / "five_bar.yaml"), "-p", "P", "-o", str(tmp_path), "--json"))
    assert report["complete"]
    assert report["area"] == pytest.approx(286.3368073193336, rel=1e-7)  # two lenses of circles, see test_workspace
    assert report["bounds"]["x"] == pytest.approx([-9.0, 9.0], abs=1e-7)  # arms of length 11 around -2 and 2
    assert report["bounds"]["y"] == pytest.approx([-np.sqrt(117.0), np.sqrt(117.0)], abs=1e-7)
    assert (report["regions"], report["holes"], report["barriers"]) == (1, 2, 0)
    with Path(report["csv"]).open(newline="") as handle:
        rows = list(csv.DictReader(handle))
    z = np.array([complex(float(r["x"]), float(r["y"])) for r in rows])
    kinds = np.array([r["kind"] for r in rows])
    for kind, radius in (("outer", 11.0), ("hole", 1.0)):
        off = np.abs(np.abs(z[kinds == kind, None] - np.array([-2.0, 2.0])) - radius).min(axis=1)
        assert off.max() < 1e-12
    assert Path(report["png"]).read_bytes().startswith(b"\x89PNG")
    assert len(rows) == sum(curve["points"] for curve in report["curves"])


def test_paths_are_reported_as_json_and_written(tmp_path: Path) -> None:
    report = json.loads(
        run("workspace", str(MODELS / "elliptic_trammel.yaml"), "-o", str(tmp_path), "--json", "--no-png")
    )
    (path,) = report["paths"]
    assert report["point"] == "P"
    assert report["png"] is None
    assert path["bounds"]["x"] == pytest.approx([-3.5, 3.5], abs=1e-8)
    assert path["inputs"]["motor"]["full_turn"]
    rows = np.genfromtxt(report["csv"], delimiter=",", names=True)
    assert np.abs((rows["x"] / 3.5) ** 2 + rows["y"] ** 2 - 1.0).max() < 1e-12
    assert np.ptp(rows["motor"]) == pytest.approx(360.0, abs=1e-6)


def test_a_fixed_orientation_is_an_option(tmp_path: Path) -> None:
    model = str(MODELS / "platform_3rpr.yaml")
    text = run("workspace", model, "-p", "M", "--orientation", "platform=17", "-o", str(tmp_path), "--no-png")
    assert "ram_1 = 16" in text


def grid_of(stem: str, point: str, count: int) -> Scatterer:
    mechanism = load(MODELS / f"{stem}.yaml")
    return Scatterer(mechanism, carried_by(mechanism, point), input_grid(mechanism, count))


def whole(job: Scatterer, workers: int | None = None) -> np.ndarray:
    parts = dict(scattered(job, range(job.parts), workers))
    return np.concatenate([parts[k] for k in range(job.parts)], axis=1)


def test_the_grid_of_a_five_bar_is_the_intersection_of_two_circles() -> None:
    """Both intersections of the circles of the distal links, by a formula; NaN where the circles do not intersect."""
    job = grid_of("five_bar", "P", 24)
    z = whole(job) * job.mechanism.scale + job.mechanism.origin
    u = job.grid.values(0, job.grid.rows)
    a, b = -2.0 + 5.0 * np.exp(1j * u[0]), 2.0 + 5.0 * np.exp(1j * u[1])
    d = np.abs(b - a)
    height = np.sqrt(np.maximum(36.0 - 0.25 * d**2, 0.0))
    meets = d <= 12.0
    for side in (1.0, -1.0):
        exact = 0.5 * (a + b) + 1j * side * height * (b - a) / d
        gap = np.abs(z - exact).min(axis=0)
        assert np.all(gap[meets] < 1e-12)
    assert np.array_equal(np.isfinite(z).all(axis=0), meets)
    assert 0.5 < meets.mean() < 1.0


def test_grid_is_the_same_compiled_and_plain_and_on_several_threads() -> None:
    job = grid_of("five_bar", "P", 190)  # two parts
    job.run = jit.compiled
    first = whole(job, 1)
    assert job.parts == 2
    assert np.array_equal(first, whole(job, 3), equal_nan=True)
    small = grid_of("five_bar", "P", 12)
    small.run = jit.compiled
    again = whole(small)
    small.run = plain
    assert np.array_equal(again, whole(small), equal_nan=True)


@pytest.mark.parametrize(("stem", "point"), [("gim_fig11", "A"), ("scotch_yoke", ""), ("hart_a_frame", "")])
def test_a_grid_contains_the_position_that_solve_finds(stem: str, point: str) -> None:
    """For a coupled mechanism and for closed forms, compared with single positions on the drawn branch."""
    job = grid_of(stem, point or load(MODELS / f"{stem}.yaml").traced[0], 7)
    z = whole(job, 2)
    values = job.grid.values(0, job.grid.rows)
    assert job.closed == (stem != "gim_fig11")
    compared = 0
    for k in range(0, job.grid.rows, 3):
        single = solve(job.mechanism, values[:, k], Options())
        if single.status.value == 0:
            (u, v, factor), found = job.on, single.z
            place = found[u] + factor * (found[v] - found[u])
            assert np.nanmin(np.abs(z[:, k] - place)) < 1e-9
            compared += 1
    assert compared >= 2


@pytest.mark.soak
def test_an_interrupted_grid_is_resumed(tmp_path: Path) -> None:
    """A run is stopped after one part; the next run solves the missing parts and gives the same positions."""
    model = MODELS / "five_bar.yaml"
    command = ["workspace", str(model), "--grid", "260", "--no-png", "--json"]
    report = json.loads(run(*command, "-o", str(tmp_path / "whole")))
    assert report["grid"]["parts"] == 3
    script = (
        "import sys, gimcli.output.parts as parts\n"
        "put = parts.Parts.put\n"
        "def stop(self, number, values):\n"
        "    put(self, number, values)\n"
        "    raise KeyboardInterrupt\n"
        "parts.Parts.put = stop\n"
        f"sys.argv = ['gim', *{[*command, '-o', str(tmp_path / 'part')]!r}]\n"
        "from gimcli.cli import main; main()\n"
    )
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, check=False).returncode != 0
    folder = tmp_path / "part" / "five_bar.workspace.parts"
    assert len(list(folder.glob("part-*.npy"))) == 1
    assert not (tmp_path / "part" / "five_bar.workspace.npz").exists()
    with pytest.raises(GimError, match=r"belongs to another run \(differs in grid\)"):
        run("workspace", str(model), "--grid", "261", "--resume", "-o", str(tmp_path / "part"))
    other = tmp_path / "five_bar.yaml"
    other.write_text(model.read_text().replace("length: 6", "length: 6.5"))
    with pytest.raises(GimError, match="differs in model"):
        run("workspace", str(other), "--grid", "260", "--resume", "-o", str(tmp_path / "part"))
    again = json.loads(run(*command, "--resume", "-o", str(tmp_path / "part")))
    assert again["grid"]["resumed_parts"] == 1
    assert not folder.exists()
    with np.load(report["npz"]) as first, np.load(again["npz"]) as second:
        assert set(first.files) == {"x", "y", "input_motor_1", "input_motor_2"}
        assert first["x"].shape == (2, 260, 260)
        assert all(np.array_equal(first[name], second[name], equal_nan=True) for name in first.files)


def test_a_folder_with_other_files_is_not_changed(tmp_path: Path) -> None:
    folder = tmp_path / "five_bar.workspace.parts"
    folder.mkdir()
    (folder / "thesis.txt").write_text("mine")
    with pytest.raises(GimError, match="do not belong to this run"):
        run("workspace", str(MODELS / "five_bar.yaml"), "--grid", "5", "--no-png", "-o", str(tmp_path))
    assert (folder / "thesis.txt").read_text() == "mine"


@pytest.mark.few(1)
@pytest.mark.parametrize("picture", ["--png", "--no-png"])
def test_ranges_that_only_touch_leave_a_single_position(tmp_path: Path, picture: str) -> None:
    """A plate of fixed orientation on two linear actuators of at most 4: their circles for A are tangent in (4, 0)."""
    model = tmp_path / "touching.yaml"
    model.write_text("""
nodes: {O: [0, 0], Q: [10, 0], A: [3, 0], B: [5, 0]}
ground: [O, Q]
links: {plate: [A, B]}
actuators:
  ram_1: {type: linear, nodes: [O, A], law: {from: 2, to: 4}}
  ram_2: {type: linear, nodes: [Q, B], law: {from: 2, to: 4}}
  ram_3: {type: linear, nodes: [O, B], law: {from: 2, to: 9}}
""")
    arguments = ("workspace", str(model), "-p", "A", "--orientation", "plate=0", "-o", str(tmp_path), picture)
    report = json.loads(run(*arguments, "--json"))
    assert report["complete"]
    assert (report["area"], report["regions"], report["curves"]) == (0.0, 0, [])
    assert np.allclose([report["bounds"]["x"], report["bounds"]["y"]], [[4.0, 4.0], [0.0, 0.0]], atol=1e-5)
    assert "nan" not in run(*arguments)
    if report["png"]:
        assert Path(report["png"]).read_bytes().startswith(b"\x89PNG")


def test_a_list_of_paths_that_may_be_incomplete_is_reported(tmp_path: Path) -> None:
    """The equations of the inversor are dependent, so its list of configurations is not proved complete."""
    arguments = ["workspace", str(MODELS / "peaucellier.yaml"), "-p", "Q", "--all", "-o", str(tmp_path), "--no-png"]
    done = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert done.exit_code == 5
    assert "there may be more paths" in done.stdout
    assert "there may be more" not in run(
        "workspace", str(MODELS / "watt_1.yaml"), "--all", "-o", str(tmp_path), "--no-png"
    )
