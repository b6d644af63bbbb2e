"""Quantities of positions of the designs of a family, with exact derivatives, as a fit compares them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.float_tables import FloatTables, with_inputs
from gimcli.families.position_state import PositionState, dual_state
from gimcli.families.sensitivity import position_derivatives
from gimcli.fitting.quantity import QuantityRates
from gimcli.mechanism import FloatArray
from gimcli.positions.dispatch import choose
from gimcli.progress import Notify
from gimcli.quantities.quantity import Item

SECONDS = 5.0
"""A fit takes longer than the compilation of the derivatives."""


class MotionQuantity:
    """Columns of the motion of a family; in the file's units, but angles in rad."""

    def __init__(self, family: Family, items: Sequence[Item], notify: Notify | None = None) -> None:
        self.family, self.items, self.notify = family, tuple(items), notify
        units = [np.pi / 180.0 if one.quantity.circular and one.head.unit == "deg" else 1.0 for one in items]
        self._units = np.array(units)
        self._run = choose("on", SECONDS, notify, ("differentiate_all",))

    def values(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the values (designs, rows, columns); NaN where a position cannot be assembled."""
        if not len(designs):
            return np.empty((0, inputs.shape[1], len(self.items)))
        at = PositionState(self.family.mechanism, self._solved(designs, inputs).z, self.family.tables(designs))
        return np.asarray(np.moveaxis(at.values(self.items), 0, -1) * self._units)

    def rates(self, designs: FloatArray, inputs: FloatArray) -> QuantityRates:
        """Return the values and their derivatives by the dimensions (file's units) and by the input."""
        if not len(designs):
            nothing = self.values(designs, inputs)
            return QuantityRates(nothing, np.empty((*nothing.shape, len(self.family.names))), nothing)
        found, mechanism = self._solved(designs, inputs), self.family.mechanism
        tables, tangents = self.family.tables(designs), self.family.tangents(designs)
        by, _ = position_derivatives(mechanism, tables, tangents, found.z, found.inputs, self._run)
        at = dual_state(mechanism, found.z, tables, by, FloatTables(*(with_inputs(table, 1) for table in tangents)))
        values = np.moveaxis(at.values(self.items), 0, -1) * self._units
        rates = np.moveaxis(at.slopes(self.items), 0, -1) * self._units  # (designs, dimensions + input, rows, columns)
        return QuantityRates(values, np.moveaxis(rates[:, :-1], 1, -1), rates[:, -1])

    def _solved(self, designs: FloatArray, inputs: FloatArray) -> Designs:
        return self.family.solve(designs, inputs=np.ascontiguousarray(inputs[:, None]), notify=self.notify)
