"""The symbols of textbook drawings as strokes, lines and areas in typographic points, and where they are.

Pivots, blocks, guides, cylinders and the arrows of the inputs; springs, dampers, applied loads, centres of mass.
Pictures and pages place the same strokes. A point of a stroke is at

    start + share span + (points pt + lengths) along exp(i share turn),

with start, span, along and turn of the symbol's seat, and pt the length of a typographic point in the file's unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import FRAME, ComplexArray
from gimcli.output.anchors import Anchor, Anchors
from gimcli.output.style import (
    ARROW,
    BLOCK,
    CENTRE,
    CENTRE_FILL,
    CYLINDER,
    GROUND,
    HATCH,
    HEAD,
    LIGHT,
    LOAD,
    LOAD_HEAD,
    ROD,
    SPRING,
    SUPPORT,
    THIN,
    Fill,
    Mark,
    Pen,
)  # fmt: skip

SPACING = 4.2
"""Approximate distance of the strokes of a hatching [pt]."""

Points = NDArray[Any] | Sequence[complex] | complex


class Axes(NamedTuple):
    """A seat at one position of the mechanism."""

    start: complex
    span: complex
    along: complex  # unit; 0 for a symbol between two places that coincide
    turn: float  # rad


@dataclass(frozen=True)
class Seat:
    """Where a symbol is: it begins at an anchor, and extends to another one or turns about the first one."""

    at: Anchor
    to: Anchor | None = None
    along: complex = 0j  # its x axis, in the coordinate system of `member`; 0: towards `to`
    member: int = FRAME
    arm: Anchor | None = None  # if given, the symbol turns about `at` from the direction of `to` to that of `arm`
    turn: float = 0.0  # rad, in the middle of the motion; at most half a turn away from that of each position

    @property
    def places(self) -> tuple[Anchor, ...]:
        """The anchors that determine it."""
        return tuple(anchor for anchor in (self.at, self.to, self.arm) if anchor is not None)

    def axes(self, places: Anchors, z: ComplexArray) -> Axes:
        """Return the seat at positions of the nodes (nodes,)."""
        start = complex(places.place(self.at, z))
        span = complex(places.place(self.to, z)) - start if self.to else 0j
        along = span / (abs(span) or 1.0)
        if self.arm:
            angle = np.angle((complex(places.place(self.arm, z)) - start) / (along or 1.0) * np.exp(-1j * self.turn))
            return Axes(start, 0j, along, self.turn + float(angle))
        return Axes(start, span, complex(self.along * places.turn(self.member, z)) if self.along else along, 0.0)


@dataclass(frozen=True)
class Stroke:
    """A line or an area of a symbol; x is along the symbol, y to its left."""

    style: Pen | Fill
    points: Points = 0j  # (points,) pt
    share: NDArray[Any] | Sequence[float] | float = 0.0  # (points,) part of the span, or of the turn
    lengths: Points = 0j  # (points,) in the file's unit
    slant: complex = 0j  # pt; not 0: in place of a line from one point to another, the strokes of a hatching along it

    def paths(self, axes: Axes, point: float) -> list[ComplexArray]:
        """Return the lines, or the outline of the area; `point` is a typographic point in the file's unit."""
        share, size = np.asarray(self.share), np.asarray(self.points) * point + np.asarray(self.lengths)
        path = axes.start + share * axes.span + size * axes.along * np.exp(1j * share * axes.turn)
        if not self.slant:
            return [path]
        first, span = path[0], path[1] - path[0]
        count = max(2, round(abs(span) / (SPACING * point)))
        feet = first + span * (np.arange(count) + 0.8) / count
        return [np.array([foot, foot + self.slant * axes.along * point]) for foot in feet.tolist()]


Strokes = tuple[Stroke, ...]


@dataclass(frozen=True)
class Symbol:
    """A part of the drawing: strokes on a seat, or lines and areas through anchors."""

    part: str  # such as "spring:coil"
    strokes: Strokes
    seat: Seat | None = None
    corners: tuple[Anchor, ...] = ()  # without a seat
    fixed: bool = False  # nothing of it moves
    radius: float = 0.0  # of a pitch circle about its seat; lengths in the file's unit
    aside: complex = 0j  # direction in which it leaves no space for names beside its node

    @property
    def name(self) -> str:
        """The name of the member, pair, actuator, gear, ..."""
        return self.part.partition(":")[2]

    @property
    def ends(self) -> tuple[Anchor, ...]:
        """Its corners, or the places of its seat: one, two, or three about a pivot."""
        return self.corners or (self.seat.places if self.seat else ())

    @property
    def filled(self) -> bool:
        """Whether it is an area."""
        return isinstance(self.strokes[0].style, Fill)

    @property
    def light(self) -> Symbol:
        """The symbol in a light pose: only strokes that have a light style."""
        return replace(
            self, strokes=tuple(replace(one, style=LIGHT[one.style]) for one in self.strokes if one.style in LIGHT)
        )

    def paths(self, stroke: Stroke, places: Anchors, z: ComplexArray, point: float) -> list[ComplexArray]:
        """Return the lines or the outline of one of its strokes, for positions of the nodes (nodes,)."""
        if self.seat is None:
            return [places.line(self.corners, z)]
        return stroke.paths(self.seat.axes(places, z), point)


BLOCK_LENGTH, BLOCK_HEIGHT = 20.0, 12.0
"""Size of a sliding block [pt]."""

OVERHANG = BLOCK_LENGTH / 2 + 12.0
"""Length of a guide beyond the place of its block [pt]."""

PIVOT_HEIGHT, PIVOT_HALF = 11.0, 7.0
"""Triangle of a fixed pivot [pt]."""

SLANT = 4.0
"""Size of the strokes of a hatching along and across the line [pt]."""

OUTLINES = {
    "o": (np.exp(2j * np.pi * np.arange(24) / 24),),
    "D": (np.sqrt(2.0) * np.exp(0.5j * np.pi * np.arange(4)),),
    "x": (np.array([-1 - 1j, 1 + 1j]), np.array([-1 + 1j, 1 - 1j])),
}
"""Outlines or lines of marks of the size 2, by matplotlib's names of their shapes."""


def hatching(first: complex, second: complex, away: complex, share: tuple[float, float] = (0.0, 0.0)) -> Strokes:
    """Return a ground line in the direction of x with slanting strokes on the side `away` (unit)."""
    line = (first, second)
    return Stroke(GROUND, line, share), Stroke(HATCH, line, share, slant=(away - 1.0) * SLANT)


def fixed_pivot(upward: bool = False) -> Strokes:
    """Return the triangle, ground line and hatching of a pivot on the frame; x is horizontal."""
    down = 1j if upward else -1j
    foot = down * PIVOT_HEIGHT
    triangle = Stroke(SUPPORT, (0j, foot - PIVOT_HALF, foot + PIVOT_HALF))
    return triangle, *hatching(foot - 1.5 * PIVOT_HALF, foot + 1.5 * PIVOT_HALF, down)


def bar(fill: Fill, shares: tuple[float, float], beyond: float, height: float) -> Stroke:
    """Return a rectangle between two parts of the span that extends by `beyond` [pt] at both ends."""
    end, half, (first, second) = beyond, 0.5j * height, shares
    return Stroke(fill, (-end - half, end - half, end + half, half - end), (first, second, second, first))


def block(fill: Fill = BLOCK) -> Stroke:
    """Return a sliding block that covers one or two nodes."""
    return bar(fill, (0.0, 1.0), BLOCK_LENGTH / 2, BLOCK_HEIGHT)


def frame_guide(away: complex) -> Strokes:
    """Return the hatched line on which a block rests; `away` is the side of the hatching (i or -i)."""
    beside = away * BLOCK_HEIGHT / 2
    return hatching(beside - OVERHANG, beside + OVERHANG, away, (0.0, 1.0))


def moving_guide() -> Strokes:
    """Return the guide of a block that slides on a moving member."""
    return (Stroke(THIN, (-OVERHANG, OVERHANG), (0.0, 1.0)),)


def cylinder() -> Strokes:
    """Return a cylinder from the first place and its rod to the second one, with the piston."""
    piston = Stroke(ARROW, (-4.0 - 2.6j, -4.0 + 2.6j), 0.6)
    return Stroke(ROD, share=(0.0, 1.0)), bar(CYLINDER, (0.14, 0.6), 0.0, 8.0), piston


NECK, ARROWHEAD = 0.6, np.array([0.0, -1.0 + 0.32j, -1.0 - 0.32j])
"""End of the line behind the tip, and outline of an arrowhead of size 1 along x."""


def arrow_lines(path: NDArray[Any], size: float) -> tuple[ComplexArray, ComplexArray]:
    """Return a polyline that ends inside its arrowhead of a size, and the outline of the arrowhead."""
    along = path[-1] - path[-2]
    along = along / abs(along) if along else 1.0 + 0.0j
    return np.append(path[:-1], path[-1] - NECK * along * size), path[-1] + along * size * ARROWHEAD


def arrow(path: NDArray[Any], pen: Pen = ARROW, fill: Fill = HEAD, size: float = 6.0) -> Strokes:
    """Return a polyline [pt] with an arrowhead at its end."""
    line, tip = arrow_lines(path, size)
    return Stroke(pen, line), Stroke(fill, tip)


def turning_arrow(sense: float) -> Strokes:
    """Return the arc of a rotary input about the direction of x."""
    return arrow(15.0 * np.exp(1j * sense * np.radians(np.linspace(-52.0, 52.0, 25))))


def travel_arrow(aside: float, sense: float) -> Strokes:
    """Return the straight arrow of a driven sliding pair, to the left (1) or to the right (-1) of its block."""
    return arrow(1j * aside * (BLOCK_HEIGHT / 2 + 5.0) + sense * np.linspace(-9.0, 11.0, 8))


def mark_strokes(mark: Mark) -> Strokes:
    """Return a mark as strokes."""
    lines = [0.5 * mark.size * outline for outline in OUTLINES[mark.shape]]
    if len(lines) > 1:
        return tuple(Stroke(Pen(mark.width, mark.edge, layer=mark.layer), line) for line in lines)
    return (Stroke(Fill(mark.face, mark.edge, mark.width, mark.layer), lines[0]),)


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
