"""Short arcs through singular positions, against closed forms, also where the input determines only half the digits."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mpmath
import numpy as np
import pytest

from gimcli import Mechanism, load
from gimcli.continuation.arc import ArcPassage, make_arc
from gimcli.continuation.branches import departure
from gimcli.continuation.curve import PositionCurve
from gimcli.motion.motion_curve import fold_beside

SLIDER = """\
units: {{length: unit}}
nodes: {{O: [0, 0], T: [5, 0], A: [{ax!r}, {ay!r}], B: [{b!r}, 0]}}
ground: [O, T]
links: {{crank: {{nodes: [O, A], length: {r!r}}}, rod: {{nodes: [A, B], length: {l!r}}}}}
prismatic: {{s: {{node: B, guide: [O, T]}}}}
actuators: {{m: {{type: linear, node: B, guide: [O, T]}}}}
"""


def slider(folder: Path, r: float, l: float, b: float, side: float = 1.0) -> Mechanism:
    """Return a slider-crank, driven by its slider and drawn at travel b."""
    ax = (b * b + r * r - l * l) / (2.0 * b)
    (folder / "m.yaml").write_text(SLIDER.format(r=r, l=l, b=b, ax=ax, ay=side * math.sqrt(max(r * r - ax * ax, 0.0))))
    return load(folder / "m.yaml")


def crank_pin(r: float, l: float, b: float) -> complex:
    """Return A, above the guide, at travel b, computed with 40 digits."""
    with mpmath.workdps(40):
        r, l, b = (mpmath.mpf(v) for v in (r, l, b))
        x = (b * b + r * r - l * l) / (2 * b)
        return complex(x, mpmath.sqrt(max(r * r - x * x, mpmath.mpf(0))))


def limit_arc(mechanism: Mechanism) -> ArcPassage:
    """Return the passage towards the limit near the drawn position, with A above the guide."""
    curve = PositionCurve(mechanism)
    start = departure(curve, mechanism.drawn, float(mechanism.actuators[0].drawn))
    fold = fold_beside(curve, start.place, 0.05)
    assert fold is not None
    arc = make_arc(curve, fold.p, fold.tangent)
    assert arc is not None
    assert arc.limit
    up = fold.tangent[2 * curve.system.free.index(mechanism.nodes.index("A")) + 1]
    return replace(arc, side=math.copysign(1.0, up))


@pytest.mark.parametrize("short", [1e-4, 1e-6, 1e-8, 1e-9])
def test_rows_near_a_limit_are_as_accurate_as_the_input_allows(short: float, tmp_path: Path) -> None:
    """Crank 2, rod 5: the limit is 7. A rounding error e of the travel moves A by about e / sqrt(7 - travel)."""
    mechanism = slider(tmp_path, 2.0, 5.0, 7.0 - 1e-3)
    passage, scale = limit_arc(mechanism), mechanism.scale
    b = 7.0 - short
    row = passage.at(b / scale)
    found = complex(mechanism.to_file(row.x + 1j * row.y)[mechanism.nodes.index("A")])
    assert abs(found - crank_pin(2.0, 5.0, b)) <= 4.0 * row.error * scale + 4e-15
    assert row.error <= 1e-15 / math.sqrt(short)


def test_the_limit_itself_is_exact(tmp_path: Path) -> None:
    """Crank 2, rod 5 in line: A is (2, 0) to all digits, not to half of them; also just beyond the limit."""
    mechanism = slider(tmp_path, 2.0, 5.0, 7.0 - 1e-3)
    passage, scale = limit_arc(mechanism), mechanism.scale
    assert passage.centre * scale == pytest.approx(7.0, abs=2e-15)
    assert passage.inwards
    for b in (7.0, 7.0 + 1e-13):
        row = passage.at(b / scale)
        z = mechanism.to_file(row.x + 1j * row.y)
        assert abs(z[mechanism.nodes.index("A")] - 2.0) < 1e-14
        assert row.error == 0.0


def test_the_two_sides_of_a_limit_are_mirror_images(tmp_path: Path) -> None:
    mechanism = slider(tmp_path, 2.0, 5.0, 7.0 - 1e-3)
    passage = limit_arc(mechanism)
    other = passage.other_side().mirrored()
    for s in np.linspace(*passage.ends, 7)[:-1].tolist():
        one, two = passage.at(s), other.at(s)
        assert np.abs((one.x + 1j * one.y) - (two.x - 1j * two.y)).max() < 1e-13


@pytest.mark.parametrize("branch", [0, 1])
def test_both_branches_of_a_parallelogram_have_arcs(branch: int, tmp_path: Path) -> None:
    """1-3-1-3 drawn flat at 0: the follower is parallel to the crank, or is the other solution, twice as fast."""
    (tmp_path / "m.yaml").write_text(
        "units: {length: unit}\nnodes: {O2: [0, 0], O4: [3, 0], A: [1, 0], B: [4, 0]}\nground: [O2, O4]\n"
        "links: {crank: [O2, A], coupler: [A, B], follower: [O4, B]}\n"
        "actuators: {m: {type: rotary, pivot: O2, arm: A}}\n"
    )
    mechanism = load(tmp_path / "m.yaml")
    curve = PositionCurve(mechanism)
    start = departure(curve, mechanism.drawn, 0.0)
    assert start.met is not None
    assert len(start.directions) == 2
    arc = make_arc(curve, start.met.p, start.directions[branch], start.met)
    assert arc is not None
    assert not arc.limit
    for q in (0.0, 1e-12, 1e-9, -1e-6, 1e-3, -4e-3):
        z = mechanism.to_file(curve.nodes(arc.position(arc.distance(q, 1.0))))
        a = complex(math.cos(q), math.sin(q))
        mirror = (a - 3.0) / abs(a - 3.0)
        expected = 3.0 + (a if branch == 0 else mirror**2 * a.conjugate())
        assert abs(z[mechanism.nodes.index("B")] - expected) < 5e-14
