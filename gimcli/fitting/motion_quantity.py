"""Quantities of positions of the designs of a family, with exact derivatives, as a fit compares them.

Over laws that differ from design to design, inputs are parts of the nominal law.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

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


ENDS = np.array([0.0, 1.0])
"""Normalised times of the ends of a law."""


def varied_ends(family: Family, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return both ends of the law (designs, 2) of the nominal design, and of those with one dimension at a bound."""
    designs = np.tile(family.nominal, (1 + 2 * len(lower), 1))
    every = np.arange(len(lower))
    designs[1 + every, every], designs[1 + len(lower) + every, every] = lower, upper
    return np.asarray(family.law_inputs(ENDS, family.tables(designs))[:, family.mechanism.drivers[0]])


SECONDS = 5.0
"""A fit takes longer than the compilation of the derivatives."""


class MotionQuantity:
    """Columns of the motion of a family; in the file's units, but angles in rad.

    Designs (designs, dimensions) are in the file's units; inputs (designs, rows) in rad or in the normal frame. With
    `along_law` input u of the nominal law, from a to b, stands for the same part of the law of each design: for one
    whose law goes from c to d it is c + (u - a) (d - c) / (b - a).
    """

    def __init__(
        self, family: Family, items: Sequence[Item], notify: Notify | None = None, along_law: bool = False
    ) -> None:  # fmt: skip
        self.family, self.items, self.notify = family, tuple(items), notify
        self.driver = family.mechanism.drivers[0]
        units = [np.pi / 180.0 if one.quantity.circular and one.head.unit == "deg" else 1.0 for one in items]
        self._units = np.array(units)
        self._run = choose("on", SECONDS, notify, ("play_designs",))
        self._law = family.law_inputs(ENDS, family.tables(family.nominal[None]))[0, self.driver] if along_law else None

    def inputs(self, designs: Any, inputs: Any) -> Any:
        """Return the inputs (designs, rows) in the laws of designs for some of the nominal law, plain or dual."""
        if self._law is None or not len(designs):
            return inputs
        ends = self.family.tables(designs).laws[:, self.driver]
        part = (inputs - self._law[0]) / (self._law[1] - self._law[0])
        return ends[:, :1] * (1.0 - part) + ends[:, 1:] * part

    def values(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the values (designs, rows, columns); NaN where a position cannot be assembled."""
        if not len(designs):
            return np.empty((0, inputs.shape[1], len(self.items)))
        found = self._solved(designs, self._every(designs, inputs))
        at = DesignState(self.family, designs, found.z, found.tables)
        return np.asarray(np.moveaxis(at.values(self.items), 0, -1) * self._units)

    def rates(self, designs: FloatArray, inputs: FloatArray) -> QuantityRates:
        """Return the values and their derivatives by the dimensions (file's units) and by the input."""
        if not len(designs):
            nothing = self.values(designs, inputs)
            return QuantityRates(nothing, np.empty((*nothing.shape, len(self.family.names))), nothing)
        moving = variables(designs, 1)
        own = Dual(inputs, np.eye(1, len(moving.slopes), len(moving.slopes) - 1).T[..., None])
        every = self._every(moving, own)
        found = self._solved(designs, every.value)
        if self.family.linked:
            slopes = every.slopes.copy()
            for d, design in enumerate(found.designs):
                given = Dual(found.inputs[d : d + 1], slopes[:, d : d + 1])
                slopes[:, d] = self.family.linked_slopes(design, found.z[d], given, self._run).slopes[:, 0]
            every = Dual(found.inputs, slopes)
        z, _ = self.family.slopes.moving(designs, found.z, every, self._run)
        at = DesignState(self.family, designs, z, self.family.tables(moving))
        values = np.moveaxis(at.values(self.items), 0, -1) * self._units
        rates = np.moveaxis(at.slopes(self.items), 0, -1) * self._units  # (designs, dimensions + input, rows, columns)
        return QuantityRates(values, np.moveaxis(rates[:, :-1], 1, -1), rates[:, -1])

    def _solved(self, designs: FloatArray, every: FloatArray) -> Designs:
        return self.family.solve(designs, inputs=np.ascontiguousarray(every), notify=self.notify)

    def _every(self, designs: Any, inputs: Any) -> Any:
        """Return all inputs (designs, actuators, rows) for that of the driver (designs, rows), plain or dual."""
        own, coupled = self.inputs(designs, inputs), self.family.mechanism.couplings
        return self.family.couplings.all_inputs(designs, own, self.driver) if coupled else own[:, None]
