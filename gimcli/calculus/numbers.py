"""What numbers made from the table of rules share, and functions for plain numbers and such numbers."""

from __future__ import annotations

import cmath
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Any

import numpy as np

from gimcli.calculus.rules import NAMES, RULES

STEPPED = frozenset((
    np.less, np.less_equal, np.greater, np.greater_equal, np.equal, np.not_equal, np.isfinite, np.isnan, np.sign,
    np.floor, np.ceil, np.rint,
))  # fmt: skip
"""Functions that change only in steps: their results have no derivatives."""


def _operator(name: str) -> tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any]]:
    """Return an operator that applies an operation, and the one with the operands exchanged."""
    return lambda self, other: self.apply(name, self, other), lambda self, other: self.apply(name, other, self)


def _comparison(compare: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Return an operator that compares values."""
    return lambda self, other: compare(self.value, nominal(other))


class RuleNumber:
    """A number whose operations follow the table of rules; comparisons use its value."""

    value: Any
    apply: Callable[..., Any]
    """The result of an operation of the table on such numbers and plain ones: apply(name, operand, ...)."""
    through: Callable[..., Any]
    """A function of the number with the attribute `slope`, its derivative; not all kinds of numbers have it."""

    __add__, __radd__ = _operator("add")
    __sub__, __rsub__ = _operator("subtract")
    __mul__, __rmul__ = _operator("multiply")
    __truediv__, __rtruediv__ = _operator("divide")
    __pow__, __rpow__ = _operator("power")

    def __neg__(self) -> Any:
        return self.apply("negative", self)

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return self.apply("abs", self)

    def conjugate(self) -> Any:
        """Return the complex conjugate."""
        return self.apply("conjugate", self)

    @property
    def real(self) -> Any:
        """The real part."""
        return self.apply("real", self)

    @property
    def imag(self) -> Any:
        """The imaginary part."""
        return self.apply("imag", self)

    __eq__, __ne__ = _comparison(operator.eq), _comparison(operator.ne)
    __lt__, __le__ = _comparison(operator.lt), _comparison(operator.le)
    __gt__, __ge__ = _comparison(operator.gt), _comparison(operator.ge)

    def __hash__(self) -> int:
        return hash(self.value)


class ArrayNumber(RuleNumber):
    """A number whose value is an array; numpy's functions of the table apply to it."""

    @property
    def dtype(self) -> Any:
        """The type of its values."""
        return np.asarray(self.value).dtype

    def __array_ufunc__(self, ufunc: Any, method: str, *operands: Any, **options: Any) -> Any:
        if method == "__call__" and not options and ufunc in NAMES:
            return self.apply(NAMES[ufunc], *operands)
        if method == "__call__" and ufunc in STEPPED:
            return ufunc(*map(nominal, operands), **options)
        return NotImplemented

    def __array_function__(self, function: Any, types: Any, arguments: Sequence[Any], options: Any) -> Any:
        return self.apply(NAMES[function], *arguments) if function in NAMES else NotImplemented

    def __array__(self, *given: Any, **options: Any) -> Any:
        raise TypeError("an array would drop the derivatives; use `nominal`")


def nominal(number: Any) -> Any:
    """Return a plain number, or the value of another one."""
    return number.value if isinstance(number, RuleNumber) else number


def scalar(number: Any) -> Any:
    """Return a Python complex, or the number if it is not plain, or an array with a number for each row."""
    return number if isinstance(number, RuleNumber) or getattr(number, "ndim", False) else complex(number)


def applied(name: str, *operands: Any) -> Any:
    """Return the result of an operation of the table on plain numbers, arrays or others."""
    return _function(name, RULES[name].value)(*operands)


def phase(number: Any) -> Any:
    """Return the angle of a complex number [rad]."""
    return number.apply("phase", number) if isinstance(number, RuleNumber) else cmath.phase(number)


def places(pairs: Sequence[Sequence[Any]]) -> Any:
    """Return coordinate pairs as an array of complex numbers, of objects if any is not plain."""
    return array(
        [x + 1j * y if isinstance(x, RuleNumber) or isinstance(y, RuleNumber) else complex(x, y) for x, y in pairs]
    )


def array(numbers: Sequence[Any]) -> Any:
    """Return an array of complex numbers, of objects if any is not plain."""
    if any(isinstance(number, RuleNumber) for number in numbers):
        found = np.empty(len(numbers), dtype=object)
        found[:] = numbers
        return found
    return np.array(numbers, dtype=complex)


def _function(name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of plain numbers and of others."""

    def function(*operands: Any) -> Any:
        for one in operands:
            if isinstance(one, RuleNumber) and (found := one.apply(name, *operands)) is not NotImplemented:
                return found
        return plain(*operands)

    return function


def _folded(pair: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *operands: reduce(pair, operands)


FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    **{name: _function(name, getattr(math, name)) for name in (
        "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "hypot", "radians", "degrees",
    )},
    "abs": abs,
    "min": _folded(_function("minimum", min)),
    "max": _folded(_function("maximum", max)),
}  # fmt: skip
"""The functions of arithmetic in a model file, for plain numbers and others."""
