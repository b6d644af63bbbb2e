"""Graphs as data: curves of columns, their axes, and marks of events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray

ORDINARY, EQUAL, POLAR = "ordinary", "equal", "polar"
"""Forms of a graph: two axes; both axes with one scale, as for a path or a hodograph; radius over an angle."""


@dataclass(frozen=True)
class Axis:
    """Name and unit of an axis; no unit: its curves have different ones."""

    name: str
    unit: str = ""


@dataclass(frozen=True)
class Curve:
    """Values over values; NaN leaves a gap."""

    name: str
    x: FloatArray  # (rows,)
    y: FloatArray  # (rows,)

    @property
    def places(self) -> ComplexArray:
        """The places x + iy (rows,)."""
        z = np.array(self.x, dtype=np.complex128)
        z.imag = self.y  # a value may be infinite
        return z


@dataclass(frozen=True)
class PlaceMark:
    """A place on a curve, and the text beside it."""

    place: complex
    text: str
    normal: complex = 0.0j  # of the curve; 0: not known


@dataclass(frozen=True)
class CurveGraph:
    """Curves in the units of their axes. In a polar graph x is the angle [rad] and y the radius."""

    across: Axis
    up: Axis
    curves: Sequence[Curve]
    form: str = ORDINARY
    verticals: Sequence[tuple[float, str]] = ()  # abscissa of an event and its word, such as "limit"
    events: Mapping[str, Sequence[complex]] = field(default_factory=dict)  # points on the curves by kind of event
    origin: bool = False  # the origin is shown
    marks: Sequence[PlaceMark] = ()
