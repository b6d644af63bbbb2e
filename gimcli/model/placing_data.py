"""What a model gives for the positions of its nodes: shapes of members, lines of sliding, inputs at the start.

Numbers are in the file's units, angles in rad; they may be recorded numbers (see `gimcli.calculus.recorded`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from gimcli.calculus.numbers import nominal, places
from gimcli.model.laws import ended
from gimcli.model.schema import Actuator, Element, Law, Link, Model
from gimcli.model.tables import read_table
from gimcli.model.units import RADIANS

TINY = 1e-300


Shape = Mapping[str, Any]
"""The coordinates of the nodes of a member in a frame of its own; or two nodes of known distance."""


@dataclass(frozen=True)
class GivenLine:
    """A line that is known from a guide, and the nodes on it.

    It is parallel to the guide, to its left at the distance `offset`; or `square` to it, at the travel `offset`.
    """

    name: str  # of the sliding pair, or of the actuator
    nodes: tuple[str, ...]
    guide: tuple[str, str]
    offset: Any
    square: bool = False

    def line(self, at: Mapping[str, Any]) -> Line:
        """Return the line from the positions of the guide."""
        first, second = (at[name] for name in self.guide)
        along = unit(second - first)
        if self.square:
            return first + along * self.offset, 1j * along
        return first + 1j * along * self.offset, along


@dataclass(frozen=True)
class PlacingData:
    """All that is known before nodes are placed; `order` is the order of the nodes in the file."""

    order: tuple[str, ...]
    shapes: Mapping[str, Shape]
    """Those of members, and then the distances that linear actuators drive."""
    lines: tuple[GivenLine, ...]
    """Those of sliding pairs, and then those of travels that actuators drive."""
    angles: Mapping[str, tuple[Actuator, Any]]
    """Those that rotary actuators drive [rad], from the ray pivot -> reference or +x to the ray pivot -> arm."""
    missing: Mapping[str, Link | Element]
    """Members without `length` or `shape`."""


def placing_data(model: Model, folder: Path) -> PlacingData:
    """Return what a model gives; parts that name undeclared nodes are left out."""
    known = set(model.nodes)
    parts = {name: part for name, part in model.members.items() if known.issuperset(part.nodes)}
    shapes = {name: shape for name, part in parts.items() if (shape := _shape(part)) is not None}
    inputs = {name: (a, _start(a, folder)) for name, a in model.actuators.items() if known.issuperset(a.named)}
    lines = (
        *(GivenLine(name, tuple(pair.sliding), (pair.guide[0], pair.guide[1]), pair.offset)
          for name, pair in model.prismatic.items() if known.issuperset((*pair.sliding, *pair.guide))),
        *(GivenLine(name, (a.node,), (a.guide[0], a.guide[1]), value, square=True)
          for name, (a, value) in inputs.items()
          if a.node is not None and a.guide is not None and value is not None),
    )  # fmt: skip
    missing = {name: part for name, part in parts.items() if name not in shapes}
    shapes |= {name: {a.nodes[0]: 0.0j, a.nodes[1]: value} for name, (a, value) in inputs.items()
               if a.nodes is not None and value is not None}  # fmt: skip
    return PlacingData(
        tuple(model.nodes), {name: _with_sliders(shape, lines) for name, shape in shapes.items()}, lines,
        {name: (a, (value or 0.0) * RADIANS[model.units.angle]) for name, (a, value) in inputs.items()
         if a.pivot is not None and a.arm is not None},
        missing,
    )  # fmt: skip


def _shape(part: Link | Element) -> Shape | None:
    """Return the shape of a member, None if it is not given."""
    if isinstance(part, Link):
        return None if part.length is None else {part.nodes[0]: 0.0j, part.nodes[1]: part.length}
    if part.shape is None or not set(part.nodes) <= set(part.shape):
        return None
    return dict(zip(part.nodes, places([part.shape[n] for n in part.nodes]).tolist(), strict=True))


def _with_sliders(shape: Shape, lines: tuple[GivenLine, ...]) -> Shape:
    """Return a shape with the nodes whose line and travel on it are known."""
    local = dict(shape)
    for travel, slot in product((one for one in lines if one.square), (one for one in lines if not one.square)):
        node = travel.nodes[0]
        if node in slot.nodes and node not in local and {*travel.guide, *slot.guide} <= set(shape):
            met = meeting(slot.line(shape), travel.line(shape))
            local |= {} if met is None else {node: met}
    return local


def starts_by_value(law: Law) -> bool:
    """Return whether a law gives its first value, so that it does not begin at that of the coordinates."""
    return law.profile.table is not None or law.from_ is not None or (bool(law.profile.polynomial) and not ended(law))


def _start(actuator: Actuator, folder: Path) -> Any:
    """Return the value of an input at the start of its law (file's unit); None if it is that of the coordinates."""
    law = actuator.law
    if law is None or not starts_by_value(law):
        return actuator.start
    if law.profile.table is not None:
        try:
            return read_table(folder / law.profile.table)[1][0]
        except ValueError:
            return None  # an error of the file, which is recorded with the law
    return law.from_ if law.from_ is not None else (law.profile.polynomial or [0.0])[0]


# -- lines ----------------------------------------------------------------------------------

Line = tuple[Any, Any]
"""A point of a line and its direction, a complex number of modulus 1."""


def unit(z: Any) -> Any:
    """Return the direction of a vector; 1 for a vector of length 0."""
    return z / abs(z) if abs(nominal(z)) > TINY else 1.0 + 0.0j


def height(line: Line, z: Any) -> Any:
    """Return the distance of a point from a line, positive to its left."""
    point, along = line
    return (along.conjugate() * (z - point)).imag


def meeting(one: Line, other: Line) -> Any:
    """Return the point of intersection of two lines; None if they are parallel."""
    slope = (other[1].conjugate() * one[1]).imag
    return None if abs(nominal(slope)) < 1e-12 else one[0] - one[1] * (height(other, one[0]) / slope)
