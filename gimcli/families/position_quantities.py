"""Coordinates and angles at positions of the designs of a family, and their exact derivatives.

Each quantity is a function of places and of arrows between them; their derivatives follow by the chain rule from those
of the nodes and of the numbers of the plan.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gimcli.canonical import phase, principal
from gimcli.errors import UsageError
from gimcli.families.float_tables import FloatTables, spans
from gimcli.mechanism import FRAME, HEIGHT, ComplexArray, FloatArray, Mechanism
from gimcli.positions.program import plan_program
from gimcli.quantities import naming
from gimcli.quantities.state import ForceLine
from gimcli.quantities.transmission import KIND as TRANSMISSION, Transmission
from gimcli.structure.checks import checks
from gimcli.structure.plan import make_plan


class PositionState(NamedTuple):
    """Positions of designs in the normal frame."""

    z: ComplexArray  # (designs, nodes, rows)
    tables: FloatTables  # (designs, ...)


class PositionSlopes(NamedTuple):
    """Derivatives of the positions of designs by dimensions (file's units), and inputs after them."""

    z: ComplexArray  # (designs, dimensions + inputs, nodes, rows)
    tables: FloatTables  # (designs, dimensions + inputs, ...); those by inputs are 0


# -- places and arrows -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class NodePlace:
    """The place of a node."""

    node: int

    def value(self, at: PositionState) -> ComplexArray:
        """Return the place (designs, rows)."""
        return np.asarray(at.z[:, self.node])

    def slope(self, at: PositionState, by: PositionSlopes) -> ComplexArray:
        """Return its derivatives (designs, dimensions, rows)."""
        return np.asarray(by.z[:, :, self.node])


@dataclass(frozen=True)
class FramePlace:
    """The place of a point of the frame."""

    point: int  # row in `FloatTables.points`

    def value(self, at: PositionState) -> ComplexArray:
        """Return the place (designs, 1)."""
        return _complex(at.tables.points[:, self.point])[:, None]

    def slope(self, at: PositionState, by: PositionSlopes) -> ComplexArray:
        """Return its derivatives (designs, dimensions, rows)."""
        own = _complex(by.tables.points[:, :, self.point])[:, :, None]
        return np.asarray(np.broadcast_to(own, (*own.shape[:2], by.z.shape[3])))


@dataclass(frozen=True)
class MemberPlace:
    """The place of a point of a moving member: first + (far - first) times a constant ratio."""

    first: int  # nodes of the member
    far: int
    point: int  # row in `FloatTables.points`
    origin: int  # rows of the two nodes in `FloatTables.shapes`
    end: int

    def value(self, at: PositionState) -> ComplexArray:
        """Return the place (designs, rows)."""
        ratio = self._ratio(at.tables)[0][:, None]
        return np.asarray(at.z[:, self.first] + (at.z[:, self.far] - at.z[:, self.first]) * ratio)

    def slope(self, at: PositionState, by: PositionSlopes) -> ComplexArray:
        """Return its derivatives (designs, dimensions, rows)."""
        ratio, length = (part[:, None] for part in self._ratio(at.tables))
        point, origin, end = self._local(by.tables)
        change = ((point - origin) - ratio * (end - origin)) / length
        arm, first = at.z[:, self.far] - at.z[:, self.first], by.z[:, :, self.first]
        return np.asarray(first + (by.z[:, :, self.far] - first) * ratio[..., None] + change[..., None] * arm[:, None])

    def _ratio(self, tables: FloatTables) -> tuple[ComplexArray, ComplexArray]:
        """Return the ratio and the vector between the two nodes in the frame of the member (designs,)."""
        point, origin, end = self._local(tables)
        return (point - origin) / (end - origin), end - origin

    def _local(self, tables: FloatTables) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return the point and the two nodes in the frame of the member; any leading axes."""
        shapes = tables.shapes
        return (
            _complex(tables.points[..., self.point, :]), _complex(shapes[..., self.origin, :]),
            _complex(shapes[..., self.end, :]),
        )  # fmt: skip


Place = NodePlace | FramePlace | MemberPlace


@dataclass(frozen=True)
class NodeArrow:
    """The vector from one node to another."""

    tail: int
    head: int

    def value(self, at: PositionState) -> ComplexArray:
        """Return the vector (designs, rows)."""
        return np.asarray(at.z[:, self.head] - at.z[:, self.tail])

    def turning(self, at: PositionState, by: PositionSlopes) -> FloatArray:
        """Return the derivatives (designs, dimensions, rows) of its direction [rad]."""
        change = by.z[:, :, self.head] - by.z[:, :, self.tail]
        return np.asarray((change / self.value(at)[:, None]).imag)


@dataclass(frozen=True)
class GuideNormal:
    """The normal of a guide: a factor of the plan times the vector between two nodes, or times 1 on the frame."""

    vector: int  # row in `FloatTables.vz`
    base: NodeArrow | None

    def value(self, at: PositionState) -> ComplexArray:
        """Return the vector (designs, rows)."""
        factor = _complex(at.tables.vz[:, self.vector])[:, None]
        return np.asarray(factor * (np.ones(at.z.shape[2]) if self.base is None else self.base.value(at)))

    def turning(self, at: PositionState, by: PositionSlopes) -> FloatArray:
        """Return the derivatives (designs, dimensions, rows) of its direction [rad]."""
        factor = _complex(at.tables.vz[:, self.vector])[:, None]
        own = (_complex(by.tables.vz[:, :, self.vector]) / factor).imag[..., None]
        rows = np.zeros(at.z.shape[2]) if self.base is None else self.base.turning(at, by)
        return np.asarray(own + rows)


Arrow = NodeArrow | GuideNormal


# -- quantities --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PositionQuantity(ABC):
    """A quantity of a position, in the file's units."""

    mechanism: Mechanism
    name: str

    @property
    @abstractmethod
    def unit(self) -> str:
        """The unit."""

    @abstractmethod
    def values(self, at: PositionState) -> FloatArray:
        """Return the values (designs, rows)."""

    @abstractmethod
    def slopes(self, at: PositionState, by: PositionSlopes) -> FloatArray:
        """Return the derivatives (designs, dimensions + inputs, rows)."""

    def difference(self, values: FloatArray, nominal: FloatArray) -> FloatArray:
        """Return values minus nominal ones."""
        return values - nominal


@dataclass(frozen=True)
class Coordinate(PositionQuantity):
    """A coordinate of a node or point."""

    place: Place
    axis: str  # "x" or "y"

    @property
    def unit(self) -> str:
        """The unit."""
        return self.mechanism.length_unit

    def values(self, at: PositionState) -> FloatArray:
        """Return the values (designs, rows)."""
        z = self.mechanism.to_file(np.asarray(np.broadcast_to(self.place.value(at), (len(at.z), at.z.shape[2]))))
        return z.real if self.axis == "x" else z.imag

    def slopes(self, at: PositionState, by: PositionSlopes) -> FloatArray:
        """Return the derivatives (designs, dimensions + inputs, rows)."""
        found = self.mechanism.scale * self.place.slope(at, by)
        return np.asarray(found.real if self.axis == "x" else found.imag)


@dataclass(frozen=True)
class PositionAngle(PositionQuantity):
    """The direction of an arrow, or its angle from another one; -180 to 180 degrees."""

    arrow: Arrow | None  # None: the +x axis
    other: Arrow | None = None

    @property
    def unit(self) -> str:
        """The unit."""
        return self.mechanism.angle_unit

    @property
    def turn(self) -> float:
        """A full turn."""
        return 360.0 if self.unit == "deg" else 2.0 * np.pi

    def values(self, at: PositionState) -> FloatArray:
        """Return the values (designs, rows)."""
        return self.directions(at) * (self.turn / (2.0 * np.pi))

    def slopes(self, at: PositionState, by: PositionSlopes) -> FloatArray:
        """Return the derivatives (designs, dimensions + inputs, rows)."""
        return self.turning(at, by) * (self.turn / (2.0 * np.pi))

    def directions(self, at: PositionState) -> FloatArray:
        """Return the values [rad]."""
        first, second = (1.0 + 0.0j if one is None else one.value(at) for one in (self.arrow, self.other))
        return np.asarray(np.broadcast_to(phase(first * np.conj(second)), (len(at.z), at.z.shape[2])))

    def turning(self, at: PositionState, by: PositionSlopes) -> FloatArray:
        """Return the derivatives [rad]."""
        zero = np.zeros((len(by.z), by.z.shape[1], by.z.shape[3]))
        first, second = (zero if one is None else one.turning(at, by) for one in (self.arrow, self.other))
        return first - second

    def difference(self, values: FloatArray, nominal: FloatArray) -> FloatArray:
        """Return values minus nominal ones, at most half a turn."""
        return np.asarray(principal(values - nominal, self.turn))


@dataclass(frozen=True)
class TransmissionAngle(PositionAngle):
    """The angle between two arrows, 0 to 180 degrees."""

    def values(self, at: PositionState) -> FloatArray:
        """Return the values (designs, rows)."""
        return np.abs(super().values(at))

    def slopes(self, at: PositionState, by: PositionSlopes) -> FloatArray:
        """Return the derivatives (designs, dimensions + inputs, rows)."""
        return super().slopes(at, by) * np.sign(super().values(at))[:, None]


# -- names -------------------------------------------------------------------------------------------------


class QuantityFinder:
    """Finds the quantities of a text such as P, P.x, rocker, rocker.angle, angle:A/B or transmission."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.members = {member.name: member for member in mechanism.members[FRAME + 1 :]}

    @cached_property
    def points(self) -> list[str]:
        """Names of nodes and points."""
        return [*self.mechanism.nodes, *(p.name for p in self.mechanism.points)]

    def knows(self, text: str) -> bool:
        """Return whether a text names a node, point or member, or a coordinate or the direction of one."""
        name, _, last = text.rpartition(".")
        return text in self.points or text in self.members or (name in self.points and last in ("x", "y"))

    def find(self, text: str) -> list[PositionQuantity]:
        """Return the quantities; raise UsageError for other texts."""
        name, _, last = text.rpartition(".")
        if text in self.points:
            return [self._coordinate(text, axis) for axis in "xy"]
        if last in ("x", "y") and name in self.points:
            return [self._coordinate(name, last)]
        if text in self.members or (last == "angle" and name in self.members):
            return [self._direction(text if text in self.members else name)]
        kind, _, names = text.partition(":")
        if kind == "transmission":
            parts = names.split("/") if names else []
            return [self._transmission(one) for one in TRANSMISSION.make(self.mechanism, text, parts)]
        if kind == "angle" and names:
            return [self._relative(text, names.split("/"))]
        known = [*self.points, *self.members, "transmission", *(f"{p}.{axis}" for p in self.points for axis in "xy")]
        raise UsageError(
            f"of '{text}': expected a node or point such as {self.mechanism.traced[0]}, its coordinate, a member,"
            f" transmission or angle:A/B; {naming.guess(text, known)}"
        )

    def _coordinate(self, name: str, axis: str) -> Coordinate:
        return Coordinate(self.mechanism, f"{name}.{axis}", _place(self.mechanism, name), axis)

    def _arrow(self, index: int) -> NodeArrow | None:
        """Return the arrow from the first to the second node of a member; None for the frame."""
        return None if index == FRAME else NodeArrow(*self.mechanism.members[index].nodes[:2])

    def _direction(self, name: str) -> PositionAngle:
        index = self.mechanism.members.index(self.members[name])
        return PositionAngle(self.mechanism, f"{name}.angle", self._arrow(index))

    def _relative(self, text: str, names: Sequence[str]) -> PositionAngle:
        naming.refuse_count(text, names, (1, 2), "angle:MEMBER[/MEMBER]")
        arrows = [self._arrow(naming.member(self.mechanism, text, name)) for name in names]
        return PositionAngle(self.mechanism, text, *arrows)

    def _transmission(self, measure: object) -> TransmissionAngle:
        assert isinstance(measure, Transmission)
        joint = measure.joint
        first, second = (self._line(joint.node, line) for line in (joint.first, joint.second))
        return TransmissionAngle(self.mechanism, measure.heads[0].name, second, first)

    def _line(self, joint: int, line: ForceLine) -> Arrow:
        if line.slide is None:
            return NodeArrow(joint, line.node)
        own = checks(self.mechanism)
        slide = line.slide
        check = next(k for k, c in enumerate(own) if c.kind == HEIGHT and (c.name, c.p) == (slide.name, slide.node))
        tables = plan_program(self.mechanism, make_plan(self.mechanism)).tables
        vector = int(tables.ci[check][3])
        u, v = tables.vi[vector][:2]
        return GuideNormal(vector, NodeArrow(int(u), int(v)) if u >= 0 else None)


def _place(mechanism: Mechanism, name: str) -> Place:
    """Return the place of a node or point."""
    if name in mechanism.nodes:
        return NodePlace(mechanism.nodes.index(name))
    row = next(k for k, p in enumerate(mechanism.points) if p.name == name)
    index = mechanism.points[row].member
    if index == FRAME:
        return FramePlace(row)
    member, begin = mechanism.members[index], int(spans(mechanism)[index])
    far = member.base
    return MemberPlace(member.nodes[0], member.nodes[far], row, begin, begin + far)


def _complex(pairs: FloatArray) -> ComplexArray:
    return np.asarray(pairs[..., 0] + 1j * pairs[..., 1])
