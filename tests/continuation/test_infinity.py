"""Curves that go to infinity are reported with the input that they approach, and need no more steps than others."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from gimcli import load
from gimcli.branching.singular_positions import drawn_circuit
from gimcli.cli import app
from gimcli.continuation.circuit import Ended

ARM = """\
nodes: {{O: [0, 0], A: [{ax!r}, {ay!r}], X: [2, 0], Y: [2, 1], P: [2, {py!r}]}}
ground: [O, X, Y]
links: {{arm: [O, A]}}
prismatic: {{s: {{node: P, guide: [O, A]}}, v: {{node: P, guide: [X, Y]}}}}
actuators: {{m: {{type: rotary, pivot: O, arm: A{law}}}}}
trace: [P]
"""


def arm(folder: Path, angle: float = 0.3, law: str = "") -> Path:
    """Write an arm with a slot; the pin in the slot slides on the rail x = 2: y = 2 tan(angle)."""
    path = folder / "arm.yaml"
    path.write_text(ARM.format(ax=math.cos(angle), ay=math.sin(angle), py=2.0 * math.tan(angle), law=law))
    return path


def report(*arguments: object, code: int = 0) -> Any:
    done = CliRunner().invoke(app, [*map(str, arguments), "--json"])
    assert done.exit_code == code, done.output
    return json.loads(done.stdout)


def test_the_circuit_is_an_open_interval(tmp_path: Path) -> None:
    circuit = drawn_circuit(load(arm(tmp_path)), 1e-10)
    assert circuit.ended == Ended.INFINITE
    assert circuit.infinite == pytest.approx((-math.pi / 2.0, math.pi / 2.0), abs=1e-11)
    assert len(circuit.places) < 1000  # equal steps would need 8000


def test_circuits_and_singularities_report_it(tmp_path: Path) -> None:
    path = arm(tmp_path)
    got = report("circuits", path)
    assert got["complete"]
    intervals = sorted(c["interval"]["m"] for c in got["curves"])
    assert np.array(intervals) == pytest.approx(np.array([[-90.0, 90.0], [90.0, 270.0]]), abs=1e-8)
    assert {c["ended"] for c in got["curves"]} == {"runs to infinity"}
    (only,) = report("singularities", path)["circuits"]
    assert only["ended"] == "runs to infinity"
    assert only["interval"]["m"] == pytest.approx([-90.0, 90.0], abs=1e-8)


@pytest.mark.parametrize(("law", "end"), [("{from: 10, to: 180}", 90.0), ("{from: 10, to: -91}", -90.0)])
def test_a_trace_ends_where_the_pin_is_infinitely_far(law: str, end: float, tmp_path: Path) -> None:
    path = arm(tmp_path, law=f", law: {law}")
    got = report("trace", path, "-n", 340, "--no-png", "-o", tmp_path, code=5)
    (event,) = got["events"]
    assert event["at"]["m"] == pytest.approx(end, abs=1e-8)
    assert event["interval"]["m"] == pytest.approx([-90.0, 90.0], abs=1e-8)
    table = np.genfromtxt(tmp_path / "arm.csv", delimiter=",", names=True, dtype=None, encoding=None)
    good = table["status"] == "ok"
    m = np.radians(table["m"])
    assert np.array_equal(good, np.abs(table["m"]) < 90.0)
    assert table["Py"][good] == pytest.approx(2.0 * np.tan(m[good]), rel=1e-13)


def test_rows_along_the_circuit_are_not_far_away(tmp_path: Path) -> None:
    report("trace", arm(tmp_path), "--circuit", "-n", 50, "--no-png", "-o", tmp_path)
    table = np.genfromtxt(tmp_path / "arm.csv", delimiter=",", names=True, dtype=None, encoding=None)
    assert np.abs(table["Py"]).max() < 100.0
    assert table["Py"] == pytest.approx(2.0 * np.tan(np.radians(table["m"])), rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("gap", [1.0, 0.1, 0.03])
def test_a_circuit_that_goes_far_but_not_to_infinity_is_closed(gap: float, tmp_path: Path) -> None:
    """A crank of 1 swings a slot about S, at a distance of 2 from its pivot, by 30 deg; the rail is at 30 deg + gap.

    The pin of slot and rail is at most 1 / sin(gap) from S.
    """
    rail = math.radians(30.0 + gap)
    along = complex(math.cos(rail), math.sin(rail))
    foot = -1j * along  # of the perpendicular from S
    pin = foot + along * math.tan(math.pi / 2.0 - rail)  # on the slot, which is drawn horizontally
    places = {"X": foot, "Y": foot + along, "P": pin}
    nodes = ", ".join(f"{n}: [{z.real!r}, {z.imag!r}]" for n, z in places.items())
    (tmp_path / "m.yaml").write_text(
        f"units: {{length: unit}}\nnodes: {{O: [2, 0], C: [3, 0], S: [0, 0], E: [1, 0], {nodes}}}\n"
        "ground: [O, S, X, Y]\nlinks: {crank: [O, C], slot: [S, E]}\n"
        "prismatic: {in: {node: C, guide: [S, E]}, pin: {node: P, guide: [S, E]}, rail: {node: P, guide: [X, Y]}}\n"
        "actuators: {m: {type: rotary, pivot: O, arm: C}}\ntrace: [P]\n"
    )
    circuit = drawn_circuit(load(tmp_path / "m.yaml"), 1e-10)
    assert circuit.closed
    z = circuit.mechanism.to_file(circuit.curve.nodes(circuit.p))
    farthest = np.abs(z[circuit.mechanism.nodes.index("P")]).max()
    assert farthest == pytest.approx(1.0 / math.sin(math.radians(gap)), rel=0.2)  # sampled at the points of the curve
    assert len(circuit.places) < 2000
