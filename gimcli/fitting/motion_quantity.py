"""Coordinates of points and directions of members of the designs of a family, with exact derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.float_tables import FloatTables, with_inputs
from gimcli.families.position_quantities import (
    PositionAngle,
    PositionQuantity,
    PositionSlopes,
    PositionState,
    QuantityFinder,
)
from gimcli.families.sensitivity import position_derivatives
from gimcli.fitting.quantity import QuantityRates
from gimcli.mechanism import FloatArray
from gimcli.positions.dispatch import choose
from gimcli.progress import Notify

SECONDS = 5.0
"""A fit takes longer than the compilation of the derivatives."""

X, Y, ANGLE = range(3)


class Component(NamedTuple):
    """A coordinate of a node or point, or the direction of a member from its first node to its second."""

    kind: int  # X, Y or ANGLE
    name: str  # of the node or point, or of the member


class MotionQuantity:
    """Components of the motion of a family; coordinates in the file's unit of length, angles in rad."""

    def __init__(self, family: Family, components: Sequence[Component], notify: Notify | None = None) -> None:
        self.family, self.components, self.notify = family, tuple(components), notify
        finder = QuantityFinder(family.mechanism)
        self._parts = [finder.find(f"{one.name}.{('x', 'y', 'angle')[one.kind]}")[0] for one in components]
        self._run = choose("on", SECONDS, notify, ("differentiate_all",))

    def values(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the values (designs, rows, components); NaN where a position cannot be assembled."""
        if not len(designs):
            return np.empty((0, inputs.shape[1], len(self.components)))
        at = PositionState(self._solved(designs, inputs).z, self.family.tables(designs))
        return np.stack([_value(part, at) for part in self._parts], axis=-1)

    def rates(self, designs: FloatArray, inputs: FloatArray) -> QuantityRates:
        """Return the values and their derivatives by the dimensions (file's units) and by the input."""
        if not len(designs):
            nothing = self.values(designs, inputs)
            return QuantityRates(nothing, np.empty((*nothing.shape, len(self.family.names))), nothing)
        found = self._solved(designs, inputs)
        at = PositionState(found.z, self.family.tables(designs))
        by = self._slopes(found, at.tables, self.family.tangents(designs))
        with np.errstate(all="ignore"):
            values = np.stack([_value(part, at) for part in self._parts], axis=-1)
            rates = np.stack([_rate(part, at, by) for part in self._parts], axis=-1)
        return QuantityRates(values, np.moveaxis(rates[:, :-1], 1, -1), rates[:, -1])  # the input is last

    def _solved(self, designs: FloatArray, inputs: FloatArray) -> Designs:
        return self.family.solve(designs, inputs=np.ascontiguousarray(inputs[:, None]), notify=self.notify)

    def _slopes(self, found: Designs, numbers: FloatTables, changes: FloatTables) -> PositionSlopes:
        """Return the derivatives by the dimensions and by the input."""
        z, _ = position_derivatives(self.family.mechanism, numbers, changes, found.z, found.inputs, self._run)
        return PositionSlopes(z, FloatTables(*(with_inputs(table, 1) for table in changes)))


def _value(part: PositionQuantity, at: PositionState) -> FloatArray:
    return part.directions(at) if isinstance(part, PositionAngle) else part.values(at)


def _rate(part: PositionQuantity, at: PositionState, by: PositionSlopes) -> FloatArray:
    return part.turning(at, by) if isinstance(part, PositionAngle) else part.slopes(at, by)
