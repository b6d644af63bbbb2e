"""Measures along a circuit, through limits of the input, compared with closed forms and geometry."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bundled import MODELS
from typer.testing import CliRunner

from gimcli import UsageError, load
from gimcli.branching.resampling import circuit_motion
from gimcli.branching.singular_positions import drawn_circuit
from gimcli.cli import app
from gimcli.continuation.curve import PositionCurve
from gimcli.rates.path_derivatives import ArclengthDerivatives

CHEBYSHEV = MODELS / "chebyshev.yaml"
"""Frame 4, crossed rockers 5, coupler 2: O2 = 0, O4 = 4; the input oscillates between two limits."""


def traced(path: Path, folder: Path, *options: object) -> tuple[dict[str, Any], dict[str, np.ndarray[Any, Any]]]:
    """Return the report and the columns of a trace."""
    done = CliRunner().invoke(app, ["trace", str(path), "-o", str(folder), "--no-png", "--json", *map(str, options)])
    assert done.exit_code == 0, done.output
    with (folder / f"{path.stem}.csv").open(newline="") as handle:
        rows = list(csv.DictReader(handle))
    numbers = [k for k in rows[0] if k != "status"]
    return json.loads(done.stdout), {k: np.array([float(row[k] or "nan") for row in rows]) for k in numbers}


def joints(columns: dict[str, np.ndarray[Any, Any]]) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return A and B of the Chebyshev linkage: P is the middle of its coupler."""
    a = 5.0 * np.exp(1j * np.radians(columns["motor"]))
    return a, 2.0 * (columns["P.x"] + 1j * columns["P.y"]) - a


def circle_through(z: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return the signed curvature of the circle through every row and its neighbours."""
    a, b, c = z[:-2], z[1:-1], z[2:]
    return np.asarray(2.0 * ((b - a).conjugate() * (c - a)).imag / (abs(b - a) * abs(c - b) * abs(c - a)))


def test_instant_centre_of_a_whole_circuit(tmp_path: Path) -> None:
    """It is the intersection of the lines of the rockers, also at the limits of the input (Kennedy)."""
    report, columns = traced(CHEBYSHEV, tmp_path, "--circuit", "-n", 240, "-m", "centre:frame/coupler")
    a, b = joints(columns)
    arm = b - 4.0
    meet = a * (4.0 * arm.conjugate()).imag / (a * arm.conjugate()).imag
    actual = columns["centre:frame/coupler.x"] + 1j * columns["centre:frame/coupler.y"]
    assert np.abs(actual - meet).max() < 1e-12 * np.abs(meet).max()
    assert sum(event["kind"] == "limit" for event in report["events"]) == 2
    assert report["measures"]["centre:frame/coupler"]["columns"]["centre:frame/coupler.x"]["empty"] == 0


def test_the_curvature_of_the_path_of_a_rockers_end(tmp_path: Path) -> None:
    """A and B move back and forth on circles of radius 5; the sign depends on the direction."""
    text = CHEBYSHEV.read_text().replace("trace: [P]", "trace: [P, A, B]")
    (tmp_path / "m.yaml").write_text(text)
    _, columns = traced(tmp_path / "m.yaml", tmp_path, "--circuit", "-n", 300, "-m", "curvature:B", "-m", "curvature:A")
    for name in "AB":
        actual = columns[f"curvature:{name}.curvature"]
        path = columns[f"{name}.x"] + 1j * columns[f"{name}.y"]
        assert np.abs(actual) == pytest.approx(np.full(301, 0.2), abs=1e-7)  # 1e-9 except where B is at rest
        sense = (np.conj(path - (0.0 if name == "A" else 4.0)) * np.gradient(path)).imag
        clear = np.abs(sense) > 0.1 * np.abs(sense).max()
        assert np.array_equal(np.sign(actual[clear]), np.sign(sense[clear]))
        assert {-1.0, 1.0} == set(np.sign(actual[clear]))
        centre = columns[f"curvature:{name}.centre.x"] + 1j * columns[f"curvature:{name}.centre.y"]
        assert np.abs(centre - (0.0 if name == "A" else 4.0)).max() < 1e-6


def test_the_signed_area_of_a_motion_back_and_forth_is_zero(tmp_path: Path) -> None:
    """Both ends of the coupler retrace arcs: the signed area returns to 0, with an error of fourth order."""
    ends = []
    for steps in (240, 480):
        _, columns = traced(CHEBYSHEV, tmp_path, "--circuit", "-n", steps, "-m", "area:coupler")
        ends.append(abs(columns["area:coupler.signed"][-1]))
        assert np.abs(columns["area:coupler.signed"]).max() > 1.0
    assert ends[1] < 1e-6
    assert ends[1] < ends[0] / 8.0


@pytest.mark.parametrize("how", [["--circuit"], ["--at-limit", "reverse"]], ids=" ".join)
def test_the_sign_of_the_curvature_agrees_with_the_path(how: list[str], tmp_path: Path) -> None:
    """Also beyond a limit; compared with the circle through three rows."""
    (tmp_path / "m.yaml").write_text(CHEBYSHEV.read_text().replace("{from: 38, to: 100}", "{from: 60, to: 200}"))
    _, columns = traced(tmp_path / "m.yaml", tmp_path, *how, "-n", 1000, "-m", "curvature:P")
    actual, path = columns["curvature:P.curvature"][1:-1], columns["P.x"] + 1j * columns["P.y"]
    steps = np.abs(np.diff(path))
    even = np.abs(np.log(steps[1:] / steps[:-1])) < 0.1  # near the limit of the input
    clear = even & (np.abs(actual) > 0.1) & (np.abs(actual) < 1.0)
    assert np.count_nonzero(clear) > 200
    assert np.abs(circle_through(path) - actual)[clear].max() < 0.02


def test_both_branches_are_measured(tmp_path: Path) -> None:
    """The coupler of a parallelogram translates; on the other branch its centre is the intersection of the cranks."""
    report, columns = traced(MODELS / "parallelogram.yaml", tmp_path, "--all-branches", "-m", "centre:frame/coupler")
    there = np.isfinite(columns["centre:frame/coupler.x"])
    assert not there[columns["branch"] == 1].any()
    assert np.count_nonzero(there[columns["branch"] == 2]) > 300
    assert [set(c["measures"]) for c in report["circuits"]] == [{"centre:frame/coupler"}] * 2


def test_rates_by_time_are_rejected_for_a_circuit(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["trace", str(CHEBYSHEV), "--circuit", "--plot", "velocity", "-o", str(tmp_path)])
    assert isinstance(done.exception, UsageError)
    assert "law" in str(done.exception)


@pytest.mark.parametrize("name", ["chebyshev", "scissor_lift", "gim_fig11", "floating_hexagon", "excavator"])
def test_third_derivatives_agree_with_differences_of_the_second(name: str) -> None:
    """Central differences along the direction, of second order; for rotary, linear and several inputs."""
    curve = PositionCurve(load(MODELS / f"{name}.yaml"))
    rng = np.random.default_rng(3)
    p = np.append(rng.normal(size=curve.system.n), 0.4 * curve.span)
    v = np.append(rng.normal(size=curve.system.n), 0.1 * curve.span)
    exact, errors = curve.third(p, v), []
    for h in (1e-2, 5e-3):
        ahead, behind = (curve.jacobian_along(p + s * h * v, v) @ v for s in (1.0, -1.0))
        errors.append(float(np.abs((ahead - behind) / (2.0 * h) - exact).max()))
    scale = max(1.0, float(np.abs(exact).max()))
    assert errors[1] < 1e-3 * scale
    assert errors[1] < 0.3 * errors[0] or errors[0] < 1e-9 * scale


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["double_butterfly", "stephenson_2", "stephenson_3_far"])
def test_derivatives_by_the_arc_length(name: str) -> None:
    """The third agrees with differences of the second, also for coupled groups and at limits of the input."""
    circuit = drawn_circuit(load(MODELS / f"{name}.yaml"), 1e-10)
    errors = []
    for rows in (401, 801):
        derivatives = ArclengthDerivatives(circuit_motion(circuit, rows, 1e-10))
        nodes, s = derivatives.along_to(3).nodes, derivatives.clock
        actual = (nodes[2][:, 2:] - nodes[2][:, :-2]) / (s[2:] - s[:-2])
        errors.append(float(np.quantile(np.abs(actual - nodes[3][:, 1:-1]), 0.5)))
    assert errors[1] < 0.3 * errors[0]


def test_velocities_on_a_chosen_branch(tmp_path: Path) -> None:
    """A parallelogram that takes the crossed branch at its flat position; differences of rows, of second order."""
    text = (MODELS / "parallelogram.yaml").read_text()
    (tmp_path / "m.yaml").write_text(text.replace("{from: 5, to: 170}", "{from: 5, to: 300}"))
    errors = []
    for steps in (360, 720):
        _, columns = traced(tmp_path / "m.yaml", tmp_path, "--branch", 2, "-n", steps, "-d", 1)
        z, v = (columns[f"M.{a}x"] + 1j * columns[f"M.{a}y"] for a in ("", "v"))
        actual = (z[2:] - z[:-2]) / (2.0 * columns["time"][1])
        errors.append(float(np.nanquantile(np.abs(actual - v[1:-1]), 0.9)))
        assert np.count_nonzero(np.isnan(v)) < 4
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 1e-3 * np.nanmax(np.abs(v))
    assert np.ptp(np.abs(v[columns["motor"] > 181.0])) > 0.5, "M leaves its circle"
