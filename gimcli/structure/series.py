"""Truncated power series in one variable, for derivatives of any order along a motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Coefficients = NDArray[Any]


class Series:
    """The series c[0] + c[1] t + c[2] t^2 + ...; the coefficients (orders, ...) are real or complex."""

    def __init__(self, c: Coefficients) -> None:
        self.c = c

    def __add__(self, other: Any) -> Series:
        if isinstance(other, Series):
            return Series(self.c + other.c)
        total = self.c + 0.0 * other
        total[0] = total[0] + other
        return Series(total)

    __radd__ = __add__

    def __neg__(self) -> Series:
        return Series(-self.c)

    def __sub__(self, other: Any) -> Series:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Series:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Series:
        if not isinstance(other, Series):
            return Series(self.c * other)
        orders = len(self.c)
        return Series(np.array([sum(self.c[j] * other.c[k - j] for j in range(k + 1)) for k in range(orders)]))

    __rmul__ = __mul__

    def __truediv__(self, other: complex) -> Series:
        return Series(self.c / other)

    def conjugate(self) -> Series:
        """Return the complex conjugate; the variable is real."""
        return Series(np.conjugate(self.c))

    @property
    def real(self) -> Series:
        """The real part."""
        return Series(self.c.real)

    @property
    def imag(self) -> Series:
        """The imaginary part."""
        return Series(self.c.imag)

    def log(self) -> Series:
        """Return the logarithm; its recurrence follows from f' = (log f)' f."""
        found = [np.log(self.c[0] + 0.0j)]
        for k in range(1, len(self.c)):
            rest = sum((j * found[j] * self.c[k - j] for j in range(1, k)), start=0.0 * self.c[0])
            found.append((self.c[k] - rest / k) / self.c[0])
        return Series(np.array(found))

    def exp(self) -> Series:
        """Return the exponential; its recurrence follows from (exp f)' = f' exp f."""
        found = [np.exp(self.c[0])]
        for k in range(1, len(self.c)):
            found.append(sum(j * self.c[j] * found[k - j] for j in range(1, k + 1)) / k)
        return Series(np.array(found))
