"""What a fit compares with its targets, as a function of the dimensions and of the input."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from gimcli.mechanism import FloatArray


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
