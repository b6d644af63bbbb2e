"""Symbols of what exerts forces: springs, dampers, applied loads, centres of mass. `pt` is one typographic point."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import ComplexArray
from gimcli.output.picture import Picture
from gimcli.output.style import CENTRE, CENTRE_FILL, LOAD, LOAD_HEAD, SPRING
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

WOUND = 3.5 * np.pi
"""Angle of a spiral spring whose arm lies on its reference [rad]."""

LONGEST, SHORTEST = 34.0, 14.0
"""Length of the arrow of the largest force and of a very small one [pt]."""

TORQUE = 13.0
"""Radius of the arc of a torque [pt]."""

CENTRE_RADIUS = 3.6
"""Radius of the symbol of a centre of mass [pt]."""


def _aside(picture: Picture, first: complex, second: complex, lane: float) -> tuple[complex, complex, complex] | None:
    """Return the ends moved sideways and the direction (unit); draw lines to the true ends. None if they coincide."""
    if first == second:
        return None
    along = (second - first) / abs(second - first)
    shift = 1j * along * lane * LANE * picture.frame.point
    if lane:
        picture.stroke(SPRING, [first, first + shift], [second, second + shift])
    return first + shift, second + shift, along


def spring(picture: Picture, first: complex, second: complex, lane: float = 0.0) -> None:
    """Draw a helical spring between two places; its turns stretch with it."""
    placed = _aside(picture, first, second, lane)
    if placed is None:
        return
    start, end, along = placed
    turns = (np.arange(2 * TURNS) + 0.5) / (2 * TURNS)
    at = np.concatenate(([0.0, STEM], STEM + (1 - 2 * STEM) * turns, [1 - STEM, 1.0]))
    height = np.concatenate(([0.0, 0.0], [1.0, -1.0] * TURNS, [0.0, 0.0]))
    picture.stroke(SPRING, start + at * (end - start) + 1j * along * height * COIL * picture.frame.point)


def damper(picture: Picture, first: complex, second: complex, lane: float = 0.0) -> None:
    """Draw a dashpot between two places: the cylinder is fixed to the first, the piston to the second."""
    placed = _aside(picture, first, second, lane)
    if placed is None:
        return
    start, end, along = placed
    pt, span = picture.frame.point, end - start
    bottom, mouth, piston = start + STEM * span, start + 0.62 * span, start + 0.5 * span
    cup, half = 1j * along * CUP * pt, 1j * along * PISTON * pt
    picture.stroke(SPRING, [start, bottom], [mouth + cup, bottom + cup, bottom - cup, mouth - cup])
    picture.stroke(SPRING, [piston, end], [piston - half, piston + half])


def torsion_spring(picture: Picture, pivot: complex, reference: complex, arm: complex, lane: float = 0.0) -> None:
    """Draw a spiral spring about a pivot, from the direction of the reference to that of the arm."""
    pt = picture.frame.point
    first = np.angle(reference)
    turn = np.linspace(0.0, WOUND + np.angle(arm / reference), 90)
    radius = (SPIRAL + (OUTER - SPIRAL) * (1 - turn / turn[-1]) + abs(lane) * LANE) * pt
    picture.stroke(SPRING, pivot + radius * np.exp(1j * (first + turn)))


def torsion_damper(picture: Picture, pivot: complex, reference: complex, arm: complex, lane: float = 0.0) -> None:
    """Draw a torsional damper: an arc with a piston about a pivot."""
    pt = picture.frame.point
    first, turn = np.angle(reference), 1.4 * np.pi + 0.3 * np.angle(arm / reference)
    radius, cup = (OUTER + 3.0 + abs(lane) * LANE) * pt, CUP * pt

    def arc(start: float, end: float, away: float = 0.0) -> ComplexArray:
        turned = first + turn * np.linspace(start, end, 30)
        return np.asarray(pivot + (radius + away) * np.exp(1j * turned))

    bottom = arc(0.3, 0.7, cup), arc(0.3, 0.7, -cup)
    picture.stroke(SPRING, arc(0.0, 0.3), *bottom, [bottom[0][0], bottom[1][0]], arc(0.55, 1.0))
    middle = complex(arc(0.55, 0.56)[0])
    along = (middle - pivot) / abs(middle - pivot)
    picture.stroke(SPRING, [middle - along * PISTON * pt, middle + along * PISTON * pt])


def force(picture: Picture, at: complex, size: complex) -> None:
    """Draw a force as an arrow from its point; |size| is relative to the largest force."""
    if not size:
        return
    length = (SHORTEST + (LONGEST - SHORTEST) * min(1.0, abs(size))) * picture.frame.point
    along = size / abs(size)
    arrow(picture, np.array([at, at + along * length]), LOAD, LOAD_HEAD, 7.0)


def torque(picture: Picture, at: complex, sense: float) -> None:
    """Draw a torque as an arc with an arrowhead, counter-clockwise if `sense` is positive."""
    turn = np.linspace(-2.2, 2.2, 40) * (1.0 if sense >= 0 else -1.0)
    arrow(picture, at + TORQUE * picture.frame.point * np.exp(1j * (np.pi / 2 + turn)), LOAD, LOAD_HEAD, 7.0)


def centre_of_mass(picture: Picture, at: complex) -> None:
    """Draw the circle with two black quarters."""
    radius = CENTRE_RADIUS * picture.frame.point
    circle = at + radius * np.exp(1j * np.linspace(0.0, 2 * np.pi, 33))
    picture.area(CENTRE, circle)
    for quarter in (0, 2):
        picture.area(CENTRE_FILL, np.append(circle[8 * quarter : 8 * quarter + 9], at))


STRAIGHT = {"spring": spring, "damper": damper}
"""Symbols between two places."""

TORSIONAL = {"spring": torsion_spring, "damper": torsion_damper}
"""Symbols about a pivot."""
