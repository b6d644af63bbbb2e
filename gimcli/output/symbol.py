"""Symbols as strokes: lines and areas in typographic points, and where they are on a mechanism.

Pictures and pages place the same strokes. A point of a stroke is at

    start + share span + (points pt + lengths) along exp(i share turn),

with start, span, along and turn of the symbol's seat, and pt the length of a typographic point in the file's unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import FRAME, ComplexArray
from gimcli.output.anchors import Anchor, Anchors
from gimcli.output.style import Fill, Pen

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

    @property
    def name(self) -> str:
        """The name of the member, pair, actuator, gear, ..."""
        return self.part.partition(":")[2]

    def paths(self, stroke: Stroke, places: Anchors, z: ComplexArray, point: float) -> list[ComplexArray]:
        """Return the lines or the outline of one of its strokes, for positions of the nodes (nodes,)."""
        if self.seat is None:
            return [places.line(self.corners, z)]
        return stroke.paths(self.seat.axes(places, z), point)
