"""The strokes of what exerts forces: springs, dampers, applied loads, centres of mass."""

from __future__ import annotations

import numpy as np

from gimcli.output.style import CENTRE, CENTRE_FILL, LOAD, LOAD_HEAD, SPRING
from gimcli.output.symbol import Stroke, Strokes
from gimcli.output.symbols import arrow

COIL, TURNS = 4.5, 8
"""Half width [pt] and number of turns of a spring."""

LANE = 15.0
"""Distance of elements that are side by side [pt]."""

STEM = 0.2
"""Straight part of a spring or a damper at either end, relative to its length."""

CUP, PISTON = 5.0, 3.4
"""Half width [pt] of a damper's cylinder and of its piston."""

SPIRAL, OUTER = 6.0, 13.0
"""Inner and outer radius of a torsional spring [pt]."""

LEAST_TURN = {"spring": 3.0 * np.pi, "damper": np.pi / 3.0}
"""Least angle of a torsional spring or damper from its reference to its arm, in the middle of the motion [rad]."""

LONGEST, SHORTEST = 34.0, 14.0
"""Length of the arrow of the largest force and of a very small one [pt]."""

TORQUE = 13.0
"""Radius of the arc of a torque [pt]."""

CENTRE_RADIUS = 3.6
"""Radius of the symbol of a centre of mass [pt]."""


def _leads(lane: float) -> Strokes:
    """Return the lines from the ends of an element to its places on a lane."""
    return tuple(Stroke(SPRING, (0j, 1j * lane * LANE), end) for end in (0.0, 1.0)) if lane else ()


def spring(lane: float = 0.0) -> Strokes:
    """Return a helical spring between two places; its turns stretch with it."""
    turns = (np.arange(2 * TURNS) + 0.5) / (2 * TURNS)
    share = np.concatenate(([0.0, STEM], STEM + (1 - 2 * STEM) * turns, [1 - STEM, 1.0]))
    height = np.concatenate(([0.0, 0.0], [COIL, -COIL] * TURNS, [0.0, 0.0]))
    return *_leads(lane), Stroke(SPRING, 1j * (height + lane * LANE), share)


def damper(lane: float = 0.0) -> Strokes:
    """Return a dashpot between two places: the cylinder is fixed to the first, the piston to the second."""
    bottom, mouth, piston, middle = STEM, 0.62, 0.5, lane * LANE
    cup = 1j * (middle + np.array([CUP, CUP, -CUP, -CUP]))
    return (
        *_leads(lane), Stroke(SPRING, (1j * middle, 1j * middle), (0.0, bottom)),
        Stroke(SPRING, cup, (mouth, bottom, bottom, mouth)), Stroke(SPRING, (1j * middle, 1j * middle), (piston, 1.0)),
        Stroke(SPRING, (1j * (middle - PISTON), 1j * (middle + PISTON)), piston),
    )  # fmt: skip


def torsion_spring(lane: float = 0.0) -> Strokes:
    """Return a spiral spring about a pivot, from the direction of the reference to that of the arm."""
    share = np.linspace(0.0, 1.0, 90)
    return (Stroke(SPRING, OUTER + (SPIRAL - OUTER) * share + abs(lane) * LANE, share),)


def torsion_damper(lane: float = 0.0) -> Strokes:
    """Return a torsional damper: an arc with a cylinder and a piston about a pivot, from the reference to the arm."""
    radius = OUTER + 3.0 + abs(lane) * LANE

    def arc(start: float, end: float, away: float = 0.0) -> Stroke:
        share = np.linspace(start, end, 30)
        return Stroke(SPRING, np.full(30, radius + away), share)

    walls = [Stroke(SPRING, (radius - half, radius + half), at) for half, at in ((CUP, 0.3), (PISTON, 0.55))]
    return arc(0.0, 0.3), arc(0.3, 0.7, CUP), arc(0.3, 0.7, -CUP), arc(0.55, 1.0), *walls


def force(size: float) -> Strokes:
    """Return a force as an arrow from its point; `size` is relative to the largest force."""
    return arrow(np.array([0.0, SHORTEST + (LONGEST - SHORTEST) * min(1.0, size)]), LOAD, LOAD_HEAD, 7.0)


def torque(sense: float) -> Strokes:
    """Return a torque as an arc with an arrowhead, counter-clockwise if `sense` is positive."""
    return arrow(TORQUE * 1j * np.exp(1j * sense * np.linspace(-2.2, 2.2, 40)), LOAD, LOAD_HEAD, 7.0)


def centre_of_mass() -> Strokes:
    """Return the circle with two black quarters."""
    circle = CENTRE_RADIUS * np.exp(1j * np.linspace(0.0, 2 * np.pi, 33))
    quarters = [Stroke(CENTRE_FILL, np.append(circle[k : k + 9], 0.0)) for k in (0, 16)]
    return Stroke(CENTRE, circle), *quarters


STRAIGHT = {"spring": spring, "damper": damper}
"""Symbols between two places."""

TORSIONAL = {"spring": torsion_spring, "damper": torsion_damper}
"""Symbols about a pivot."""
