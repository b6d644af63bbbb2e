"""Dual numbers: a value with its derivatives by the dimensions; numpy's functions of object arrays call their methods.

Source: Griewank & Walther, Evaluating Derivatives, 2008, chapter 3 (forward mode).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import FloatArray


def _function(value: Callable[[Any], Any], slope: Callable[[Any], Any]) -> Callable[[Dual], Dual]:
    """Return a function of dual numbers from a function of numbers and its derivative."""
    return lambda x: x._of(value(x.value), slope(x.value))


class Dual:
    """A number and its derivatives (dimensions,); NaN or infinite where they are not defined."""

    __slots__ = ("slopes", "value")

    def __init__(self, value: float, slopes: FloatArray) -> None:
        self.value, self.slopes = np.float64(value), slopes  # numpy's numbers: a division by 0 is no error

    def _of(self, value: float, slope: float) -> Dual:
        """Return a function of this number from its value and its derivative."""
        return Dual(value, slope * self.slopes)

    def __add__(self, other: Any) -> Dual:
        own = _dual(other, self)
        return Dual(self.value + own.value, self.slopes + own.slopes)

    def __mul__(self, other: Any) -> Dual:
        own = _dual(other, self)
        return Dual(self.value * own.value, self.slopes * own.value + self.value * own.slopes)

    def __truediv__(self, other: Any) -> Dual:
        own = _dual(other, self)
        ratio = self.value / own.value
        return Dual(ratio, (self.slopes - ratio * own.slopes) / own.value)

    def __pow__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return (other * self.log()).exp()
        return self._of(self.value**other, other * self.value ** (other - 1.0) if other else 0.0)

    def __neg__(self) -> Dual:
        return self._of(-self.value, -1.0)

    def __sub__(self, other: Any) -> Dual:
        return self + -_dual(other, self)

    def __rsub__(self, other: Any) -> Dual:
        return _dual(other, self) - self

    def __rtruediv__(self, other: Any) -> Dual:
        return _dual(other, self) / self

    def __rpow__(self, other: float) -> Dual:
        return _dual(other, self) ** self

    def __abs__(self) -> Dual:
        return self._of(abs(self.value), np.sign(self.value))

    __radd__, __rmul__ = __add__, __mul__

    def __le__(self, other: Any) -> bool:
        return bool(self.value <= _dual(other, self).value)

    def __ge__(self, other: Any) -> bool:
        return bool(self.value >= _dual(other, self).value)

    sqrt = _function(np.sqrt, lambda x: 0.5 / np.sqrt(x))
    exp = _function(np.exp, np.exp)
    log = _function(np.log, lambda x: 1.0 / x)
    sin = _function(np.sin, np.cos)
    cos = _function(np.cos, lambda x: -np.sin(x))
    arctan = _function(np.arctan, lambda x: 1.0 / (1.0 + x**2))
    arcsin = _function(np.arcsin, lambda x: 1.0 / np.sqrt(1.0 - x**2))

    def tan(self) -> Dual:
        """Return the tangent."""
        return self.sin() / self.cos()

    def arccos(self) -> Dual:
        """Return the angle [rad] with this cosine."""
        return 0.5 * math.pi - self.arcsin()

    def arctan2(self, other: Any) -> Dual:
        """Return the angle [rad] of the vector (other, self)."""
        own = _dual(other, self)
        slopes = (own.value * self.slopes - self.value * own.slopes) / (self.value**2 + own.value**2)
        return Dual(np.arctan2(self.value, own.value), slopes)

    def hypot(self, other: Any) -> Dual:
        """Return the length of the vector (self, other)."""
        return (self * self + _dual(other, self) ** 2).sqrt()

    def radians(self) -> Dual:
        """Return an angle in rad."""
        return self * (math.pi / 180.0)

    def degrees(self) -> Dual:
        """Return an angle in degrees."""
        return self * (180.0 / math.pi)


def _dual(other: Any, like: Dual) -> Dual:
    """Return a number as a dual number; a constant has no derivatives."""
    return other if isinstance(other, Dual) else Dual(float(other), np.zeros_like(like.slopes))


def duals(values: FloatArray, slopes: FloatArray) -> NDArray[np.object_]:
    """Return an array of dual numbers from values (rows,) and derivatives (dimensions, rows)."""
    found = np.empty(len(values), dtype=object)
    for k, value in enumerate(values):
        found[k] = Dual(value, slopes[:, k])
    return found
