"""Quantities with their first and second derivatives along k directions in which a mechanism can move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[Any]
"""Real or complex values; the last axis has the positions (rows)."""


@dataclass(frozen=True)
class Jet:
    """A quantity in some positions, with its derivatives along k directions."""

    value: Values  # (rows,)
    first: Values  # (k, rows)
    second: Values  # (k, k, rows)

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.value + other.value, self.first + other.first, self.second + other.second)

    def __sub__(self, other: Jet) -> Jet:
        return Jet(self.value - other.value, self.first - other.first, self.second - other.second)

    def __mul__(self, other: Jet | complex) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value * other, self.first * other, self.second * other)
        mixed = self.first[:, None] * other.first[None, :]
        second = self.second * other.value + self.value * other.second + mixed + mixed.transpose(1, 0, 2)
        return Jet(self.value * other.value, self.first * other.value + self.value * other.first, second)

    def conjugate(self) -> Jet:
        """Return the complex conjugate."""
        return Jet(self.value.conj(), self.first.conj(), self.second.conj())

    @property
    def real(self) -> Jet:
        """The real part."""
        return Jet(self.value.real, self.first.real, self.second.real)

    @property
    def imag(self) -> Jet:
        """The imaginary part."""
        return Jet(self.value.imag, self.first.imag, self.second.imag)

    def through(self, value: Values, slope: Values, bend: Values) -> Jet:
        """Return a function of the quantity, from the function's value and its first and second derivative (rows,)."""
        second = slope * self.second + bend * (self.first[:, None] * self.first[None, :])
        return Jet(value, slope * self.first, second)

    def plus(self, constant: Values | float) -> Jet:
        """Return the quantity with another value and the same derivatives."""
        return Jet(self.value + constant, self.first, self.second)


def constant(value: complex, like: Jet) -> Jet:
    """Return a constant as a jet of the same shape."""
    return Jet(np.full(like.value.shape, value), 0.0 * like.first, 0.0 * like.second)
