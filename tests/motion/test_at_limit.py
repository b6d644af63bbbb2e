"""Motions at the limit of their input, and the choice of branches: rows against closed forms."""

from __future__ import annotations

import cmath
import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from bundled import MODELS
from four_bars import cosines, four_bar, four_bar_text
from typer.testing import CliRunner

import gimcli
from gimcli import UsageError, load
from gimcli.cli import app
from gimcli.model.source import read_source
from gimcli.motion.motion import Motion, trace
from gimcli.status import Status

ROCKER = (4.0, 1.5, 2.0, 4.0)
"""A triple rocker: the input has limits where coupler and follower are in line, 3.5 long or folded to 0.5."""
STRETCHED = math.degrees(math.acos(cosines(*ROCKER)[0]))
FOLDED = math.degrees(math.acos(cosines(*ROCKER)[1]))


def rocker(folder: Path, start: float, end: float) -> Path:
    """Write a triple rocker with a law, drawn at its start."""
    path = folder / "rocker.yaml"
    law = f", law: {{from: {start}, to: {end}}}"
    path.write_text(four_bar_text(*ROCKER, math.radians(start), law=law))
    return path


def side(motion: Motion) -> np.ndarray[Any, Any]:
    """Return the side (rows,), 1 or -1, of the line from A to O4 on which B is."""
    o4, a, b = (motion.z[motion.mechanism.nodes.index(n)] for n in ("O4", "A", "B"))
    return np.sign(((b - a) * (o4 - a).conjugate()).imag)


def invoke(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(a) for a in arguments])


def report(*arguments: object, code: int = 0) -> Any:
    done = invoke(*arguments, "--json")
    assert done.exit_code == code, done.output
    return json.loads(done.stdout)


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as handle:
        return list(csv.DictReader(handle))


def test_reverse_continues_on_the_other_side(tmp_path: Path) -> None:
    """Behind the limit the input is mirrored at it, and B is on the other side of the line A-O4."""
    mechanism = load(rocker(tmp_path, 20.0, 80.0))
    motion = trace(mechanism, 60, at_limit="reverse")
    assert motion.solved == 61
    law = 20.0 + np.arange(61.0)
    angle = np.degrees(motion.inputs[0])
    before = law < STRETCHED
    assert angle[before] == pytest.approx(law[before], abs=1e-10)
    assert angle[~before] == pytest.approx(2.0 * STRETCHED - law[~before], abs=1e-9)
    assert set(side(motion)[before]) == {1.0}
    assert set(side(motion)[~before]) == {-1.0}
    assert np.nanmax(motion.residual) < 1e-13


def test_reverse_repeats_the_swing(tmp_path: Path) -> None:
    """The input of a double rocker swings between acos(4/5) and acos(-1/5); after two swings it is back."""
    text = (MODELS / "chebyshev.yaml").read_text()
    low, high = math.degrees(math.acos(0.8)), math.degrees(math.acos(-0.2))
    (tmp_path / "m.yaml").write_text(
        text.replace("{from: 38, to: 100}", f"{{from: 60, to: {60 + 6 * (high - low)!r}}}")
    )
    motion = trace(load(tmp_path / "m.yaml"), 300, at_limit="reverse")
    assert motion.solved == 301
    angle = np.degrees(motion.inputs[0])
    assert angle.max() <= high + 1e-9
    assert angle.min() >= low - 1e-9
    wave = np.abs((np.linspace(60, 60 + 6 * (high - low), 301) - high) % (2 * (high - low)) - (high - low)) + low
    assert angle == pytest.approx(wave, abs=1e-9)
    assert len(motion.turned_back) == 6
    at = [60.0 + t * 6.0 * (high - low) for t, _ in motion.turned_back]
    assert at == pytest.approx([high + k * (high - low) for k in range(6)], abs=1e-10)
    events = gimcli.trace(motion.mechanism, 300, at_limit="reverse").events
    limits = [event["at"]["motor"] for event in events if event["kind"] == "limit"]
    assert limits == pytest.approx([high, low] * 3, abs=1e-10)
    equal = motion.z[:, [0, 100, 200, 300]]  # two swings are a third of the law
    assert np.abs(equal - equal[:, :1]).max() < 1e-12


def test_a_law_that_returns_repeats_its_positions(tmp_path: Path) -> None:
    """Beyond the limit and back: every position occurs twice."""
    path = rocker(tmp_path, 20.0, 80.0)
    path.write_text(path.read_text().replace("{from: 20.0, to: 80.0}", "{polynomial: [20, 240, -240]}"))
    motion = trace(load(path), 40, at_limit="reverse")
    assert motion.solved == 41
    assert (side(motion) < 0.0).any()
    assert np.abs(motion.z - motion.z[:, ::-1]).max() < 1e-10


def test_skip_solves_rows_that_are_reachable_again(tmp_path: Path) -> None:
    """One turn: rows between the limits, and a turn later, on the same side; the mirrored arc is another circuit."""
    mechanism = load(rocker(tmp_path, 20.0, 380.0))
    motion = trace(mechanism, 360, at_limit="skip")
    law = 20.0 + np.arange(361.0)
    assert np.array_equal(motion.good, (law < STRETCHED) | (law > 360.0 + FOLDED))
    assert set(side(motion)[motion.good]) == {1.0}
    assert np.abs(motion.z[:, -1] - motion.z[:, 0]).max() < 1e-12
    assert np.degrees(motion.inputs[0]) == pytest.approx(law)
    assert {Status(int(c)) for c in motion.codes[~motion.good]} == {Status.LIMIT}


def test_skip_does_not_jump_to_the_other_end_of_an_arc_longer_than_a_turn(tmp_path: Path) -> None:
    """The other end of the arc may have the angle of the limit plus a turn: that is another position."""
    text = (MODELS / "double_butterfly_symmetric.yaml").read_text()
    (tmp_path / "m.yaml").write_text(text.replace("{from: -100, to: 20}", "{from: -100, to: -220}"))
    motion = trace(load(tmp_path / "m.yaml"), 120, at_limit="skip")
    assert motion.limit is not None
    assert np.array_equal(motion.good, motion.time < motion.limit)
    assert motion.solved > 2
    assert np.abs(np.diff(motion.z[:, motion.good], axis=1)).max() < 0.2  # of a size of about 1


def test_stop_is_the_default(tmp_path: Path) -> None:
    mechanism = load(rocker(tmp_path, 20.0, 80.0))
    one, other = trace(mechanism, 60), trace(mechanism, 60, at_limit="stop")
    assert np.array_equal(one.z, other.z, equal_nan=True)
    assert one.limit == other.limit
    assert one.solved == int(np.sum(20.0 + np.arange(61.0) < STRETCHED))


def test_several_inputs_reverse_together(tmp_path: Path) -> None:
    """Three motors driven beyond the platform's limit: all return along their laws, in another configuration."""
    text = (MODELS / "platform_3rrr.yaml").read_text()
    for old, new in (("to: 60}", "to: -60}"), ("to: -150}", "to: -50}"), ("to: -50}\n\npoints", "to: -150}\n\npoints")):
        text = text.replace(old, new, 1)
    (tmp_path / "m.yaml").write_text(text)
    mechanism = load(tmp_path / "m.yaml")
    stopped, motion = (trace(mechanism, 40, at_limit=how) for how in ("stop", "reverse"))
    assert stopped.limit is not None
    assert motion.solved == 41
    limit, time = stopped.limit, motion.time
    assert limit is not None
    back = np.where(time > limit, 2.0 * limit - time, time)
    for k, actuator in enumerate(mechanism.actuators):
        assert motion.inputs[k] == pytest.approx(actuator.law(back), abs=1e-9)
    k = int(np.argmax(time > limit))
    assert np.abs(motion.z[:, k] - motion.z[:, k - 1]).max() > 1e-3


def test_skip_solves_rows_of_several_inputs_that_are_reachable_again(tmp_path: Path) -> None:
    """Three motors beyond the platform's limit and back: the last rows equal the first, those between are empty."""
    data = read_source(MODELS / "platform_3rrr.yaml").data
    for actuator, end in zip(data["actuators"].values(), (-60.0, -50.0, -150.0), strict=True):
        start = float(actuator["law"]["from"])
        actuator["law"] = {"polynomial": [start, 4.0 * (end - start), 4.0 * (start - end)]}
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    mechanism = load(tmp_path / "m.yaml")
    stopped, motion = (trace(mechanism, 24, at_limit=how) for how in ("stop", "skip"))
    reached = int(stopped.good.sum())
    assert 0 < reached < 12
    assert motion.good.tolist() == [min(k, 24 - k) < reached for k in range(25)]
    assert np.abs(motion.z[:, :reached] - motion.z[:, ::-1][:, :reached]).max() < 1e-9
    assert np.nanmax(motion.residual) < 1e-10


@pytest.mark.few(3)
@pytest.mark.parametrize("name", ["stephenson_2", "hart_a_frame", "double_butterfly", "ten_bar", "chebyshev"])
def test_a_limit_is_exact(name: str, tmp_path: Path) -> None:
    """At the reported limit the Jacobian F_x is singular; the reference is the fold found by continuation."""
    from gimcli.branching.singular_positions import drawn_circuit
    from gimcli.branching.singularities import limits

    text = (MODELS / f"{name}.yaml").read_text()
    (tmp_path / "m.yaml").write_text(text)
    mechanism = load(tmp_path / "m.yaml")
    ends = sorted(float(s.p[-1]) for s in limits(drawn_circuit(mechanism, 1e-10)))
    start = float(mechanism.actuators[0].law(np.zeros(1))[0])
    above = [e for e in ends if e > start]
    unit, scale = (math.degrees(1.0), 1.0) if mechanism.actuators[0].rotary else (mechanism.scale, 1.0)
    head, _, tail = text.partition("law: {from: ")
    begin, _, rest = tail.partition(", to: ")
    rest = rest.partition("}")[2]
    (tmp_path / "m.yaml").write_text(f"{head}law: {{from: {begin}, to: {float(begin) + 400.0}}}{rest}")
    motion = trace(load(tmp_path / "m.yaml"), 100)
    assert motion.limit is not None
    limit = (float(begin) + 400.0 * motion.limit) / unit * scale
    assert min(abs(limit - e) for e in above) < 1e-12


def test_a_limit_agrees_with_the_law_of_cosines(tmp_path: Path) -> None:
    got = report("trace", rocker(tmp_path, 20.0, 200.0), "-n", 90, "--no-png", "-o", tmp_path, code=5)
    (event,) = got["events"]
    assert event["kind"] == "limit"
    assert event["at"]["motor"] == pytest.approx(STRETCHED, abs=1e-11)
    assert got["reachable"]["motor"][0] == pytest.approx([20.0, STRETCHED], abs=1e-11)
    assert event["interval"]["motor"] == pytest.approx([FOLDED, STRETCHED], abs=1e-11)


@pytest.mark.few(1)
@pytest.mark.parametrize("steps", [3, 20, 97])
def test_a_change_point_is_exact(steps: int, tmp_path: Path) -> None:
    text = (MODELS / "double_butterfly_symmetric.yaml").read_text()
    (tmp_path / "m.yaml").write_text(text.replace("{from: -100, to: 20}", "{from: -100, to: 60}"))
    motion = trace(load(tmp_path / "m.yaml"), steps)
    (time,) = motion.bridged
    from gimcli.branching.singular_positions import survey
    from gimcli.status import CHANGE

    wanted = [math.degrees(f.what.p[-1]) for f in survey(load(tmp_path / "m.yaml")).found if f.what.kind == CHANGE]
    assert min(abs(-100.0 + 160.0 * time - w) for w in wanted) < 1e-11


def test_a_branch_is_taken_at_the_first_change_point(tmp_path: Path) -> None:
    """1-3-1-3 from 5 deg: parallel up to 180 deg, then crossed: B is the other intersection of its two circles."""
    path = tmp_path / "m.yaml"
    path.write_text((MODELS / "parallelogram.yaml").read_text().replace("{from: 5, to: 170}", "{from: 5, to: 365}"))
    mechanism = load(path)
    straight, motion = trace(mechanism, 72), trace(mechanism, 72, branch=2)
    assert motion.solved == 73
    b = mechanism.to_file(motion.z[mechanism.nodes.index("B")])
    angle = 5.0 + 5.0 * np.arange(73)
    for k in range(73):
        a = cmath.rect(1.0, math.radians(angle[k]))
        parallel = 3.0 + a
        mirror = (a - 3.0) / abs(a - 3.0)
        crossed = 3.0 + mirror**2 * (parallel - 3.0).conjugate()  # mirrored in the line A-O4
        assert abs(b[k] - (parallel if angle[k] <= 180.0 else crossed)) < 1e-12
    assert np.abs(straight.z[:, 36:] - motion.z[:, 36:]).max() > 0.1
    assert motion.bridged == pytest.approx([175.0 / 360.0, 355.0 / 360.0], abs=1e-14)


def test_a_branch_that_does_not_exist_is_an_error(tmp_path: Path) -> None:
    text, rocking = (MODELS / "parallelogram.yaml").read_text(), load(MODELS / "crank_rocker.yaml")
    (tmp_path / "m.yaml").write_text(text.replace("{from: 5, to: 170}", "{from: 5, to: 190}"))
    parallelogram = load(tmp_path / "m.yaml")
    with pytest.raises(UsageError):
        trace(rocking, 20, branch=2)
    with pytest.raises(UsageError):
        trace(parallelogram, 20, branch=3)
    text = (MODELS / "double_butterfly_symmetric.yaml").read_text()
    (tmp_path / "butterfly.yaml").write_text(text.replace("{from: -100, to: 20}", "{from: -100, to: -103}"))
    butterfly = load(tmp_path / "butterfly.yaml")
    with pytest.raises(UsageError):
        trace(butterfly, 20, branch=2)
    kite = four_bar(tmp_path, 1.0, 3.0, 2.0, 4.0, 1.0)
    assert trace(kite, 20, branch=2).solved == 21


@pytest.mark.usefixtures("unrendered")
def test_the_circuit_keeps_the_columns(tmp_path: Path) -> None:
    got = report("trace", MODELS / "chebyshev.yaml", "--circuit", "-n", 50, "-o", tmp_path)
    rows = rows_of(tmp_path / "chebyshev.csv")
    assert list(rows[0]) == ["step", "time", "motor", "P.x", "P.y", "residual", "sweeps", "status"]
    assert [float(r["time"]) for r in rows] == pytest.approx([k / 50 for k in range(51)])
    assert {r["status"] for r in rows} == {"ok"}
    assert (rows[0]["P.x"], rows[0]["status"]) == (rows[-1]["P.x"], "ok") or float(rows[0]["P.x"]) == pytest.approx(
        float(rows[-1]["P.x"]), abs=1e-12
    )
    ends = [math.degrees(math.acos(c)) for c in (0.8, -0.2)]
    assert got["reachable"]["motor"] == [pytest.approx(ends, abs=1e-11)]
    assert [e["kind"] for e in got["events"]] == ["limit", "limit"]
    assert (tmp_path / "chebyshev.png").is_file()


def test_all_branches_have_a_column(tmp_path: Path) -> None:
    got = report("trace", MODELS / "parallelogram.yaml", "--all-branches", "-n", 40, "--no-png", "-o", tmp_path)
    rows = rows_of(tmp_path / "parallelogram.csv")
    assert list(rows[0])[-1] == "branch"
    assert [r["branch"] for r in rows] == ["1"] * 41 + ["2"] * 41
    assert [c["turns"] for c in got["circuits"]] == [1, 1]
    assert got["solved"] == 82
    for row in rows[:41]:  # parallel: M is a crank's length from 1.5, 0
        assert abs(complex(float(row["M.x"]), float(row["M.y"])) - 1.5) == pytest.approx(1.0, abs=1e-12)
    assert any(abs(complex(float(r["M.x"]), float(r["M.y"])) - 1.5) < 0.5 for r in rows[41:])
    only = report(
        "trace", MODELS / "parallelogram.yaml", "--circuit", "--branch", 2, "-n", 40, "--no-png", "-o", tmp_path
    )
    assert [c["branch"] for c in only["circuits"]] == [2]
    assert [r["M.x"] for r in rows_of(tmp_path / "parallelogram.csv")] == [r["M.x"] for r in rows[41:]]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--circuit", "--method", "gim"],
        ["--circuit", "--derivatives", "1"],
        ["--circuit", "--at-limit", "skip"],
        ["--all-branches", "--branch", "2"],
        ["--at-limit", "reverse", "--derivatives", "1"],
        ["--branch", "2", "--method", "gim"],
        ["--circuit", "--branch", "9"],
        ["--branch", "2"],  # its law ends before the flat position
    ],
)
def test_options_that_exclude_each_other_are_an_error(arguments: list[str], tmp_path: Path) -> None:
    done = invoke("trace", MODELS / "parallelogram.yaml", *arguments, "-o", tmp_path)
    assert isinstance(done.exception, UsageError)
    assert list(tmp_path.iterdir()) == []
