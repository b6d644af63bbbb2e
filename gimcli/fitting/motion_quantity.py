"""Coordinates of points and directions of members of the designs of a family, with exact derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.float_tables import FloatTables, spans
from gimcli.families.sensitivity import position_derivatives
from gimcli.fitting.quantity import QuantityRates
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.dispatch import choose
from gimcli.progress import Notify
from gimcli.structure.checks import farthest

SECONDS = 5.0
"""A fit takes longer than the compilation of the derivatives."""

X, Y, ANGLE = range(3)


class Component(NamedTuple):
    """A coordinate of a node or point, or the direction of a member from its first node to its second."""

    kind: int  # X, Y or ANGLE
    name: str  # of the node or point, or of the member


class _Carried(NamedTuple):
    """A point of a member: its place follows from two nodes of the member."""

    first: int  # places in the array of the nodes
    far: int
    point: int  # row in `FloatTables.points`
    origin: int  # rows of the two nodes in `FloatTables.shapes`
    end: int


class MotionQuantity:
    """Components of the motion of a family; coordinates in the file's unit of length, angles in rad."""

    def __init__(self, family: Family, components: Sequence[Component], notify: Notify | None = None) -> None:
        self.family, self.components, self.notify = family, tuple(components), notify
        mechanism = family.mechanism
        needed = [node for one in components for node in _nodes(mechanism, one)]
        self.nodes = list(dict.fromkeys(needed))
        self._places = [_place(mechanism, self.nodes, one) for one in components]
        self._run = choose("on", SECONDS, notify, ("differentiate_all",))

    def values(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the values (designs, rows, components); NaN where a position cannot be assembled."""
        if not len(designs):
            return np.empty((0, inputs.shape[1], len(self.components)))
        found = self._solved(designs, inputs)
        z, tables = found.z[:, self.nodes], self.family.tables(designs)
        return np.stack([self._value(one, place, z, tables) for one, place in self._parts], axis=-1)

    def rates(self, designs: FloatArray, inputs: FloatArray) -> QuantityRates:
        """Return the values and their derivatives by the dimensions (file's units) and by the input."""
        if not len(designs):
            nothing = self.values(designs, inputs)
            return QuantityRates(nothing, np.empty((*nothing.shape, len(self.family.names))), nothing)
        found = self._solved(designs, inputs)
        tables, tangents = self.family.tables(designs), self.family.tangents(designs)
        slopes = self._slopes(found, tables, tangents)
        z = found.z[:, self.nodes]
        with np.errstate(all="ignore"):
            values = [self._value(one, place, z, tables) for one, place in self._parts]
            rates = [self._rate(one, place, z, slopes, tables, tangents) for one, place in self._parts]
        by_all = np.stack(rates, axis=-1)  # (designs, dimensions + 1, rows, components)
        return QuantityRates(np.stack(values, axis=-1), np.moveaxis(by_all[:, :-1], 1, -1), by_all[:, -1])

    def _solved(self, designs: FloatArray, inputs: FloatArray) -> Designs:
        return self.family.solve(designs, inputs=np.ascontiguousarray(inputs[:, None]), notify=self.notify)

    @property
    def _parts(self) -> Any:
        return zip(self.components, self._places, strict=True)

    def _slopes(self, found: Designs, tables: FloatTables, tangents: FloatTables) -> ComplexArray:
        """Return the derivatives of the nodes (designs, dimensions + 1, nodes, rows), normal frame."""
        inputs, numbers, changes = found.inputs, tables, tangents
        slopes, _ = position_derivatives(
            self.family.mechanism, numbers, changes, found.z, inputs, self._run, nodes=self.nodes
        )
        return slopes

    def _value(self, one: Component, place: Any, z: ComplexArray, tables: FloatTables) -> FloatArray:
        """Return the values (designs, rows) of a component."""
        if one.kind == ANGLE:
            return np.asarray(np.angle(z[:, place[1]] - z[:, place[0]]))
        found = z[:, place] if isinstance(place, int) else _carried(z, place, _ratio(tables, place)[:, None])
        file = self.family.mechanism.to_file(found)
        return np.asarray(file.real if one.kind == X else file.imag)

    def _rate(
        self, one: Component, place: Any, z: ComplexArray, slopes: ComplexArray, tables: FloatTables,
        tangents: FloatTables,
    ) -> FloatArray:  # fmt: skip
        """Return the derivatives (designs, dimensions + 1, rows) of a component."""
        if one.kind == ANGLE:
            first, second = place
            arm, change = z[:, second] - z[:, first], slopes[:, :, second] - slopes[:, :, first]
            return np.asarray((change / arm[:, None]).imag)
        if isinstance(place, int):
            found = slopes[:, :, place]
        else:
            found = _carried(slopes.swapaxes(1, 2), place, _ratio(tables, place)[:, None, None])
            arm = z[:, place.far] - z[:, place.first]
            found[:, :-1] += _ratio_rates(tables, tangents, place)[..., None] * arm[:, None]
        found = found * self.family.mechanism.scale
        return np.asarray(found.real if one.kind == X else found.imag)


def _carried(z: ComplexArray, place: _Carried, ratio: ComplexArray) -> ComplexArray:
    """Return a point (designs, ...) of a member from its nodes z (designs, nodes, ...)."""
    return np.asarray(z[:, place.first] + (z[:, place.far] - z[:, place.first]) * ratio)


def _ratio(tables: FloatTables, place: _Carried) -> ComplexArray:
    """Return the place of a point (designs,) on the vector from the first to the far node of its member."""
    local, origin, end = _locals(tables, place)
    return np.asarray((local - origin) / (end - origin))


def _ratio_rates(tables: FloatTables, tangents: FloatTables, place: _Carried) -> ComplexArray:
    """Return the derivatives (designs, dimensions) of that place."""
    _, origin, end = _locals(tables, place)
    local_rate, origin_rate, end_rate = _locals(tangents, place)
    ratio = _ratio(tables, place)[:, None]
    return np.asarray((local_rate - origin_rate - ratio * (end_rate - origin_rate)) / (end - origin)[:, None])


def _locals(tables: FloatTables, place: _Carried) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return the point and the two nodes in the frame of their member; any leading axes."""
    points, shapes = tables.points, tables.shapes
    found = (points[..., place.point, :], shapes[..., place.origin, :], shapes[..., place.end, :])
    point, origin, end = (part[..., 0] + 1j * part[..., 1] for part in found)
    return point, origin, end


def _member(mechanism: Mechanism, name: str) -> int:
    return next(k for k, member in enumerate(mechanism.members) if member.name == name)


def _nodes(mechanism: Mechanism, one: Component) -> tuple[int, ...]:
    """Return the nodes that determine a component."""
    if one.kind == ANGLE:
        return mechanism.members[_member(mechanism, one.name)].nodes[:2]
    if one.name in mechanism.nodes:
        return (mechanism.nodes.index(one.name),)
    member = mechanism.members[next(p.member for p in mechanism.points if p.name == one.name)]
    return member.nodes[0], member.nodes[farthest(member)]


def _place(mechanism: Mechanism, nodes: list[int], one: Component) -> int | tuple[int, int] | _Carried:
    """Return where a component is found among some nodes and in the tables of a family."""
    own = [nodes.index(node) for node in _nodes(mechanism, one)]
    if one.kind == ANGLE:
        return own[0], own[1]
    if len(own) == 1:
        return own[0]
    point = next(k for k, p in enumerate(mechanism.points) if p.name == one.name)
    index = mechanism.points[point].member
    begin = int(spans(mechanism)[index])
    return _Carried(own[0], own[1], point, begin, begin + farthest(mechanism.members[index]))
