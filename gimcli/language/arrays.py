"""The functions of expressions for arrays: columns (designs, rows), of several columns (columns, designs, rows).

A number of each design is a column of one row. NaN stands for a value that is not defined.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, reduce
from typing import Any

import numpy as np

from gimcli.language.expression import FUNCTIONS, REDUCES


def least(rows: Any) -> Any:
    """Return the least value of each design that is defined (designs, 1)."""
    found = np.fmin.reduce(rows, axis=-1, keepdims=True)
    return np.fmin.reduce(found, axis=0) if found.ndim > 2 else found


def greatest(rows: Any) -> Any:
    """Return the greatest value of each design that is defined (designs, 1)."""
    found = np.fmax.reduce(rows, axis=-1, keepdims=True)
    return np.fmax.reduce(found, axis=0) if found.ndim > 2 else found


def mean(rows: Any) -> Any:
    """Return the mean of the rows that have a value (designs, 1)."""
    good = np.isfinite(rows)
    return np.where(good, rows, 0.0).sum(axis=-1, keepdims=True) / good.sum(axis=-1, keepdims=True)


def _taken(values: Any, place: Any, good: Any) -> Any:
    """Return values at a place of each design (designs, 1); NaN for designs without a value that is defined."""
    found = np.take_along_axis(np.broadcast_to(values, good.shape), place, -1)
    return np.where(good.any(axis=-1, keepdims=True), found, np.nan)


def first(rows: Any) -> Any:
    """Return the value in the first row that has one (designs, 1)."""
    good = np.isfinite(rows)
    return _taken(rows, np.argmax(good, axis=-1, keepdims=True), good)


def last(rows: Any) -> Any:
    """Return the value in the last row that has one (designs, 1)."""
    good = np.isfinite(rows)
    return _taken(rows, rows.shape[-1] - 1 - np.argmax(good[..., ::-1], axis=-1, keepdims=True), good)


def at_least(rows: Any, across: Any, sign: float = 1.0) -> Any:
    """Return where in `across` the least value is, with sign -1 the greatest (designs, 1)."""
    good = np.isfinite(rows)
    return _taken(across, np.argmin(np.where(good, sign * rows, np.inf), axis=-1, keepdims=True), good)


def integral(rows: Any, across: Any) -> Any:
    """Return the integral over `across` by the trapezoidal rule; steps without a value add nothing (designs, 1)."""
    steps = 0.5 * (rows[..., 1:] + rows[..., :-1]) * np.diff(across, axis=-1)
    return np.where(np.isfinite(steps), steps, 0.0).sum(axis=-1, keepdims=True)


def compared(sign: str, one: Any, two: Any) -> Any:
    """Return a comparison: 1 for true, 0 for false, NaN where a side is not defined."""
    return np.where(np.isfinite(one) & np.isfinite(two), SIGNS[sign](one, two), np.nan)


def joint(decides: float, one: Any, two: Any) -> Any:
    """Return two conditions joined by `and` (0 decides) or `or` (1 decides), by Kleene's logic.

    A side that decides alone needs no other.
    """
    return np.where((one == decides) | (two == decides), decides, one * two)


SIGNS: dict[str, Callable[[Any, Any], Any]] = {
    "<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "==": np.equal, "!=": np.not_equal,
}  # fmt: skip

ARRAYS: dict[str, Callable[..., Any]] = {
    **{name: getattr(np, name.replace("a", "arc", 1) if name[0] == "a" and name != "abs" else name)
       for name, count in FUNCTIONS.items() if count},
    "min": lambda *given: reduce(np.minimum, given), "max": lambda *given: reduce(np.maximum, given),
    "/": np.divide, "**": np.power,
    "hypot of columns": lambda pair: np.hypot(*pair),
    "min of rows": least, "max of rows": greatest, "range of rows": lambda rows: greatest(rows) - least(rows),
    "mean of rows": mean, "rms of rows": lambda rows: np.sqrt(mean(rows**2)), "first of rows": first,
    "last of rows": last, "argmin of rows": at_least, "argmax of rows": partial(at_least, sign=-1.0),
    "integral of rows": integral,
    "not": lambda given: 1.0 - given, "and": partial(joint, 0.0), "or": partial(joint, 1.0),
    **{sign: partial(compared, sign) for sign in SIGNS},
    "text ==": lambda one, two: np.equal(one, two) + 0.0, "text !=": lambda one, two: np.not_equal(one, two) + 0.0,
}  # fmt: skip
"""The functions by name."""


def strict(lacks: Callable[[Any], Any]) -> dict[str, Callable[..., Any]]:
    """Return the functions; those of rows are NaN where `lacks`: it returns of rows whether one is missing (..., 1)."""

    def checked(function: Callable[..., Any], rows: Any, *across: Any) -> Any:
        found, missing = function(rows, *across), lacks(rows)
        return np.where(missing if np.ndim(missing) == np.ndim(found) else missing.any(axis=0), np.nan, found)

    return {name: partial(checked, own) if name.endswith(REDUCES) else own for name, own in ARRAYS.items()}
