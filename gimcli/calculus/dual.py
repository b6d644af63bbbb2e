"""Dual numbers: arrays of values with their derivatives along some tangents (forward mode)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gimcli.calculus.numbers import ArrayNumber, nominal
from gimcli.calculus.rules import RULES

LINEAR = frozenset((
    np.sum, np.mean, np.cumsum, np.diff, np.stack, np.concatenate, np.broadcast_to, np.take_along_axis, np.squeeze,
    np.reshape, np.moveaxis, np.expand_dims,
))  # fmt: skip
"""Functions of arrays that are linear in their dual arguments."""

BY_VALUE = frozenset((np.shape, np.ndim, np.isrealobj, np.iscomplexobj, np.argmin, np.argmax, np.argsort, np.round))
"""Functions of arrays whose results have no derivatives."""


class Dual(ArrayNumber):
    """Values of any shape, real or complex, with their derivatives along some tangents.

    A tangent is a dimension, an input, the time, or any other direction in which the values change. The axis of the
    tangents is the first one of `slopes`, so that the other axes are those of `value`: Dual(value, slopes) with value
    (designs, rows) and slopes (tangents, designs, rows). Shapes of operands are broadcast as those of their values.

    Operators, comparisons (by value), indexing, and numpy's functions of `RULES`, `LINEAR` and `BY_VALUE` and np.unwrap
    apply; least and greatest values (np.fmin.reduce, ...) have the derivatives of the element that has this value.
    Plain numbers and arrays are constants: what is computed from them alone stays plain. Other functions of numpy raise
    TypeError. Derivatives that are not defined are NaN or infinite.
    """

    __slots__ = ("slopes", "value")

    def __init__(self, value: Any, slopes: Any) -> None:
        self.value, self.slopes = np.asarray(value), np.asarray(slopes)
        if self.slopes.shape[1:] != self.value.shape:
            self.slopes = np.broadcast_to(self.slopes, (len(self.slopes), *self.value.shape))

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the values."""
        return np.shape(self.value)

    @property
    def ndim(self) -> int:
        """The number of axes of the values."""
        return np.ndim(self.value)

    def __len__(self) -> int:
        return len(self.value)

    def __getitem__(self, key: Any) -> Dual:
        return Dual(self.value[key], self.slopes[(slice(None), *(key if isinstance(key, tuple) else (key,)))])

    def apply(self, name: str, *operands: Any) -> Dual:
        """Return the result of an operation of the table."""
        rule, plain = RULES[name], [one.value if isinstance(one, Dual) else one for one in operands]
        value = rule.value(*plain)
        slopes = [one.aligned(value.ndim) if isinstance(one, Dual) else None for one in operands]
        return Dual(value, rule.slope(value, plain, slopes))

    def through(self, function: Any) -> Dual:
        """Return a function of the numbers, whose `slope` is its derivative."""
        return Dual(function(self.value), function.slope(self.value) * self.slopes)

    def aligned(self, axes: int) -> Any:
        """Return the slopes with as many axes after the first one as given, for broadcasting."""
        missing = axes - self.value.ndim
        return self.slopes.reshape(len(self.slopes), *[1] * missing, *self.value.shape) if missing else self.slopes

    def sum(self, **options: Any) -> Any:
        """Return the sum over an axis, as np.sum does."""
        return np.sum(self, **options)

    def __array_ufunc__(self, ufunc: Any, method: str, *operands: Any, **options: Any) -> Any:
        if method == "reduce" and ufunc in (np.fmin, np.fmax, np.minimum, np.maximum):
            return self._extreme(ufunc, **options)
        return super().__array_ufunc__(ufunc, method, *operands, **options)

    def _extreme(self, ufunc: Any, axis: int = 0, keepdims: bool = False) -> Any:
        """Return the elements along an axis that have the extreme value."""
        place = np.argmax(self.value == ufunc.reduce(self.value, axis=axis, keepdims=True), axis=axis, keepdims=True)
        found = _along(np.take_along_axis, self, place, axis)
        return found if keepdims else _along(np.squeeze, found, axis)

    def __array_function__(self, function: Any, types: Any, arguments: Sequence[Any], options: Any) -> Any:
        if function in BY_VALUE:
            return function(*map(nominal, arguments), **options)
        if function is np.unwrap:
            return Dual(np.unwrap(self.value, *arguments[1:], **options), self.slopes)
        if function in LINEAR:
            return _along(function, *arguments, **options)
        return super().__array_function__(function, types, arguments, options)


def variables(values: Any, more: int = 0) -> Dual:
    """Return values (rows, variables) as dual numbers: the tangents are the variables, and `more` of something else."""
    return Dual(values, np.eye(values.shape[1] + more, values.shape[1])[:, None])


def first_of(number: Any, tangents: int) -> tuple[float, Any]:
    """Return the first element of a number, dual or plain, and its derivatives (tangents,)."""
    slopes = number.slopes.reshape(tangents, -1)[:, 0] if isinstance(number, Dual) else np.zeros(tangents)
    return float(np.ravel(nominal(number))[0]), slopes


def _along(function: Callable[..., Any], first: Any, *given: Any, **options: Any) -> Dual:
    """Return a linear function of a dual number, or of a list with some: that of the values, and along each tangent."""
    several = isinstance(first, (list, tuple))
    parts = first if several else [first]
    count = next(len(one.slopes) for one in parts if isinstance(one, Dual))
    rates = ([one.slopes[k] if isinstance(one, Dual) else np.zeros_like(one) for one in parts] for k in range(count))
    value, *slopes = (
        function(own if several else own[0], *given, **options) for own in ([nominal(one) for one in parts], *rates)
    )
    return Dual(value, np.reshape(slopes, (count, *np.shape(value))))
