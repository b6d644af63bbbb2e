"""Quantities of positions of the designs of a family, with exact derivatives, as a fit compares them.

Over laws that differ from design to design, inputs are parts of the nominal law.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from gimcli.calculus.dual import Dual, variables
from gimcli.families.design_state import DesignState
from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.mechanism import FloatArray
from gimcli.positions.dispatch import choose
from gimcli.progress import Notify
from gimcli.quantities.quantity import Item


class QuantityRates(NamedTuple):
    """Values of a quantity and their exact derivatives; NaN where a position cannot be assembled."""

    values: FloatArray  # (designs, rows, components)
    by_dimension: FloatArray  # (designs, rows, components, dimensions)
    by_input: FloatArray  # (designs, rows, components)


class FittedQuantity(Protocol):
    """A quantity with one or more components: coordinates in the file's unit, or angles in rad.

    Designs (designs, dimensions) are in the file's units; inputs (designs, rows) in rad or in the normal frame.
    """

    def values(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the values (designs, rows, components); NaN where a position cannot be assembled."""

    def rates(self, designs: FloatArray, inputs: FloatArray) -> QuantityRates:
        """Return the values and their derivatives."""


ENDS = np.array([0.0, 1.0])
"""Normalised times of the ends of a law."""


def varied_ends(family: Family, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return both ends of the law (designs, 2) of the nominal design, and of those with one dimension at a bound."""
    designs = np.tile(family.nominal, (1 + 2 * len(lower), 1))
    every = np.arange(len(lower))
    designs[1 + every, every], designs[1 + len(lower) + every, every] = lower, upper
    return np.asarray(family.law_inputs(ENDS, family.tables(designs))[:, family.mechanism.drivers[0]])


class LawQuantity:
    """A quantity at inputs that stand for the same part of the law of each design.

    Input u of the nominal law, from a to b, is for a design whose law goes from c to d: c + (u - a) (d - c) / (b - a).
    """

    def __init__(self, quantity: MotionQuantity) -> None:
        self.quantity, self.family, self.driver = quantity, quantity.family, quantity.driver
        tables = self.family.tables(self.family.nominal[None])
        self.ends: FloatArray = self.family.law_inputs(ENDS, tables)[0, self.driver]

    def inputs(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the inputs (designs, rows) of designs for inputs (designs, rows) of the nominal law."""
        ends = self.family.tables(designs).laws[:, self.driver]
        part = self._part(inputs)
        return np.asarray(ends[:, :1] * (1.0 - part) + ends[:, 1:] * part)

    def values(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the values (designs, rows, components); NaN where a position cannot be assembled."""
        return self.quantity.values(designs, self.inputs(designs, inputs) if len(designs) else inputs)

    def rates(self, designs: FloatArray, inputs: FloatArray) -> QuantityRates:
        """Return the values and their derivatives by the dimensions and by the input of the nominal law."""
        if not len(designs):
            return self.quantity.rates(designs, inputs)
        found = self.quantity.rates(designs, self.inputs(designs, inputs))
        laws: Any = self.family.tables(variables(designs)).laws
        ends, slopes = laws.value[:, self.driver], np.moveaxis(laws.slopes[:, :, self.driver], 0, 1)
        part = self._part(inputs)[..., None]
        moved = slopes[:, None, :, 0] * (1.0 - part) + slopes[:, None, :, 1] * part  # (designs, rows, dimensions)
        ratio = ((ends[:, 1] - ends[:, 0]) / (self.ends[1] - self.ends[0]))[:, None, None]
        by_dimension = found.by_dimension + found.by_input[..., None] * moved[:, :, None]
        return QuantityRates(found.values, by_dimension, found.by_input * ratio)

    def _part(self, inputs: FloatArray) -> FloatArray:
        return np.asarray((inputs - self.ends[0]) / (self.ends[1] - self.ends[0]))


SECONDS = 5.0
"""A fit takes longer than the compilation of the derivatives."""


class MotionQuantity:
    """Columns of the motion of a family; in the file's units, but angles in rad."""

    def __init__(self, family: Family, items: Sequence[Item], notify: Notify | None = None) -> None:
        self.family, self.items, self.notify = family, tuple(items), notify
        self.driver = family.mechanism.drivers[0]
        units = [np.pi / 180.0 if one.quantity.circular and one.head.unit == "deg" else 1.0 for one in items]
        self._units = np.array(units)
        self._run = choose("on", SECONDS, notify, ("play_designs",))

    def values(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the values (designs, rows, columns); NaN where a position cannot be assembled."""
        if not len(designs):
            return np.empty((0, inputs.shape[1], len(self.items)))
        found = self._solved(designs, inputs)
        at = DesignState(self.family, designs, found.z, found.tables)
        return np.asarray(np.moveaxis(at.values(self.items), 0, -1) * self._units)

    def rates(self, designs: FloatArray, inputs: FloatArray) -> QuantityRates:
        """Return the values and their derivatives by the dimensions (file's units) and by the input."""
        if not len(designs):
            nothing = self.values(designs, inputs)
            return QuantityRates(nothing, np.empty((*nothing.shape, len(self.family.names))), nothing)
        found, mechanism = self._solved(designs, inputs), self.family.mechanism
        moving = variables(designs, 1)
        if mechanism.couplings:
            own = Dual(inputs, np.eye(1, len(moving.slopes), len(moving.slopes) - 1).T[..., None])
            z, _ = self.family.slopes.moving(designs, found.z, self._every(moving, own), self._run)
        else:
            by, _ = self.family.slopes(designs, found.z, found.inputs, self._run)
            z = Dual(found.z, np.moveaxis(by, 1, 0))
        at = DesignState(self.family, designs, z, self.family.tables(moving))
        values = np.moveaxis(at.values(self.items), 0, -1) * self._units
        rates = np.moveaxis(at.slopes(self.items), 0, -1) * self._units  # (designs, dimensions + input, rows, columns)
        return QuantityRates(values, np.moveaxis(rates[:, :-1], 1, -1), rates[:, -1])

    def _solved(self, designs: FloatArray, inputs: FloatArray) -> Designs:
        every = np.ascontiguousarray(self._every(designs, inputs))
        return self.family.solve(designs, inputs=every, notify=self.notify)

    def _every(self, designs: Any, inputs: Any) -> Any:
        """Return all inputs (designs, actuators, rows) for that of the driver (designs, rows)."""
        coupled = self.family.mechanism.couplings
        return self.family.couplings.all_inputs(designs, inputs, self.driver) if coupled else inputs[:, None]
