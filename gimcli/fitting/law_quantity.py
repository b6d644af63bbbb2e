"""A quantity over laws that differ from design to design: inputs are parts of the nominal law."""

from __future__ import annotations

import numpy as np

from gimcli.families.family import Family
from gimcli.fitting.motion_quantity import MotionQuantity
from gimcli.fitting.quantity import QuantityRates
from gimcli.mechanism import FloatArray

ENDS = np.array([0.0, 1.0])
"""Normalised times of the ends of a law."""


def varied_ends(family: Family, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return both ends of the law (designs, 2) of the nominal design, and of those with one dimension at a bound."""
    designs = np.tile(family.nominal, (1 + 2 * len(lower), 1))
    every = np.arange(len(lower))
    designs[1 + every, every], designs[1 + len(lower) + every, every] = lower, upper
    return family.law_inputs(ENDS, family.tables(designs))[:, 0]


class LawQuantity:
    """A quantity at inputs that stand for the same part of the law of each design.

    Input u of the nominal law, from a to b, is for a design whose law goes from c to d: c + (u - a) (d - c) / (b - a).
    """

    def __init__(self, quantity: MotionQuantity) -> None:
        self.quantity, self.family = quantity, quantity.family
        self.ends: FloatArray = self.family.law_inputs(ENDS, self.family.tables(self.family.nominal[None]))[0, 0]

    def inputs(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the inputs (designs, rows) of designs for inputs (designs, rows) of the nominal law."""
        ends = self.family.tables(designs).laws[:, 0]
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
        ends, slopes = self.family.tables(designs).laws[:, 0], self.family.tangents(designs).laws[:, :, 0]
        part = self._part(inputs)[..., None]
        moved = slopes[:, None, :, 0] * (1.0 - part) + slopes[:, None, :, 1] * part  # (designs, rows, dimensions)
        ratio = ((ends[:, 1] - ends[:, 0]) / (self.ends[1] - self.ends[0]))[:, None, None]
        by_dimension = found.by_dimension + found.by_input[..., None] * moved[:, :, None]
        return QuantityRates(found.values, by_dimension, found.by_input * ratio)

    def _part(self, inputs: FloatArray) -> FloatArray:
        return np.asarray((inputs - self.ends[0]) / (self.ends[1] - self.ends[0]))
