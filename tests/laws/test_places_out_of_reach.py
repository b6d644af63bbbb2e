"""A node that is drawn farther away than its links can reach, as by a mistake, changes no verdict."""

import math

import numpy as np
import pytest

import gimcli
from gimcli import shipped

MISTYPED = {
    "crank_rocker": [
        ("[143.19, 67.34]", "[3e10, 80]"),
        ("[30.64, 25.71]", "[3e10, 80]"),
        ("[30.64, 25.71]", "[-5e4, 9e6]"),
    ],
    "swing": [("A: [0, 0.5]", "A: [0, 360]"), ("B: [1.2, 0.5]", "B: [1e8, 0.5]")],
}


@pytest.mark.few(2)
@pytest.mark.parametrize(("model", "old", "new"), [(m, *change) for m, found in MISTYPED.items() for change in found])
def test_a_node_out_of_reach(model, old, new):
    text = shipped.path_of(model).read_text(encoding="utf-8")
    assert old in text
    right, far = gimcli.loads(text, shipped.folder()), gimcli.loads(text.replace(old, new), shipped.folder())
    assert far.size * far.scale < 4 * right.size * right.scale
    a, b = gimcli.circuits(right), gimcli.circuits(far)
    assert b.complete == a.complete
    for name in a:
        if a[name].dtype.kind == "f":
            assert b[name] == pytest.approx(a[name], abs=1e-6), name


RACK = """
nodes: {{O: [0, 0], A: [1, 0], S: [{start}, 2], T: [3, 2], U: [6, 2], V: [9, 2]}}
ground: [O, S, V]
links: {{pinion: [O, A], rack: [T, U]}}
prismatic: {{slide: {{nodes: [T, U], guide: [S, V]}}}}
gears: {{teeth: {{type: rack, members: [pinion, rack], pivots: [O], radii: [2]}}}}
actuators: {{motor: {{pivot: O, arm: A, law: {{by: 90}}}}}}
"""


@pytest.mark.parametrize("start", [-1.0, -1e4, -1e9, -1e12, -1e18, -1e60])
def test_a_rack_on_a_line_from_a_far_node(start):
    """The rack above the pinion moves by the radius times the angle, against the sense of the turn."""
    rows = gimcli.trace(gimcli.loads(RACK.format(start=start)), 9)
    assert rows.complete
    assert rows["T.x"] == pytest.approx(3.0 - 2.0 * np.linspace(0.0, math.pi / 2, 10), abs=1e-12)
