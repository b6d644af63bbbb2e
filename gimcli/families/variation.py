"""What a varied dimension may be: listed values, or a distribution."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gimcli.errors import UsageError, refuse
from gimcli.mechanism import FloatArray

MOST_VALUES = 10_000_000
"""Largest number of values of one dimension, and of designs."""

FORM = "expected values such as 10:20:21 (21 values from 10 to 20) or 3,4,5, or uniform(10,20) or normal(40,0.05)"

FARTHEST = 10.0
"""Distance from the mean, in standard deviations, that no sample of a normal distribution reaches."""

NUMBER = re.compile(r"\s*[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?\s*")
CALL = re.compile(r"\s*(uniform|normal)\s*\(([^(),]*),([^(),]*)\)\s*")


@dataclass(frozen=True, eq=False)
class ListedValues:
    """Values of a dimension [file's unit], all of which are combined with those of the other dimensions."""

    name: str
    values: FloatArray  # (values,)

    @property
    def text(self) -> str:
        """The values in words, for reports."""
        first, last = (f"{v:.6g}" for v in self.values[[0, -1]])
        return f"{len(self.values)} values, {first} to {last}" if len(self.values) > 1 else first


@dataclass(frozen=True)
class Distribution:
    """A dimension that is distributed: "uniform" between two values, or "normal" with mean and standard deviation."""

    name: str
    kind: str
    first: float  # file's unit
    second: float

    def at(self, share: FloatArray) -> FloatArray:
        """Return the values below which a share of all values is (designs,)."""
        if self.kind == "uniform":
            return self.first + (self.second - self.first) * share
        from scipy.special import ndtri

        return np.asarray(self.first + self.second * ndtri(share))

    @property
    def text(self) -> str:
        """The distribution as it is written."""
        return f"{self.kind}({self.first:g},{self.second:g})"


Variation = ListedValues | Distribution


@dataclass(frozen=True)
class Varied:
    """The varied dimensions, all listed or all distributed."""

    variations: tuple[Variation, ...]
    names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(v.name for v in self.variations))
        refuse((not self.variations, "vary: name at least one dimension, such as crank.length=30:50:21"))
        kinds = {isinstance(v, ListedValues) for v in self.variations}
        if len(kinds) > 1:
            listed = next(v.name for v in self.variations if isinstance(v, ListedValues))
            drawn = next(v for v in self.variations if not isinstance(v, ListedValues))
            raise UsageError(
                f"vary: '{listed}' has listed values and '{drawn.name}' a distribution, {drawn.text}: listed values are"
                " combined, distributions are sampled; give all dimensions one or the other"
            )

    @property
    def listed(self) -> bool:
        """Whether all dimensions have listed values."""
        return isinstance(self.variations[0], ListedValues)


def varied(vary: Mapping[str, Any]) -> Varied:
    """Return the variations of dimensions by name: texts such as "10:20:21", or arrays of values."""
    return Varied(tuple(variation(name, given) for name, given in vary.items()))


def variation(name: str, given: str | float | Sequence[float] | FloatArray) -> Variation:
    """Return the variation of a dimension from its text or its values; raise UsageError if it is neither."""
    where = f"vary {name}={given}" if isinstance(given, str) else f"vary {name}"
    if not isinstance(given, str):
        return ListedValues(name, _checked(where, _array(where, given)))
    call = CALL.fullmatch(given)
    if call is not None:
        return _distribution(name, where, call)
    words: Any = [_number(where, word) for word in given.split(",")] if ":" not in given else _spaced(where, given)
    return ListedValues(name, _checked(where, np.asarray(words)))


def _distribution(name: str, where: str, call: re.Match[str]) -> Distribution:
    first, second = (_number(where, call[k]) for k in (2, 3))
    normal = call[1] == "normal"
    refuse(
        (normal and second <= 0.0, f"{where}: expected a standard deviation above 0, got {second:g}"),
        (not normal and second <= first, f"{where}: expected the smaller value first: uniform(LOW,HIGH)"),
    )
    _refuse_beyond(where, abs(first) + FARTHEST * second if normal else second - first)
    return Distribution(name, call[1], first, second)


def _refuse_beyond(where: str, size: float) -> None:
    if not math.isfinite(size):
        raise UsageError(f"{where}: the values are too large; use another unit of length, or smaller values")


def _spaced(where: str, given: str) -> FloatArray:
    """Return the values of FIRST:LAST:COUNT."""
    words = given.split(":")
    refuse((len(words) != 3, f"{where}: {FORM}"))
    count = _number(where, words[2])
    if count != int(count) or not 2 <= count <= MOST_VALUES:
        raise UsageError(f"{where}: expected a number of values from 2 to {MOST_VALUES}, got {words[2]}")
    first, last = _number(where, words[0]), _number(where, words[1])
    _refuse_beyond(where, last - first)
    return np.linspace(first, last, int(count))


def _array(where: str, given: Any) -> FloatArray:
    try:
        return np.atleast_1d(np.asarray(given, dtype=np.float64))
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"{where}: {FORM}, or an array of values") from None


def _checked(where: str, values: FloatArray) -> FloatArray:
    if values.ndim != 1 or not 1 <= len(values) <= MOST_VALUES or not np.isfinite(values).all():
        raise UsageError(f"{where}: expected 1 to {MOST_VALUES} finite values in a row")
    return values


def _number(where: str, word: str) -> float:
    value = float(word) if NUMBER.fullmatch(word) else math.nan
    if not math.isfinite(value):
        raise UsageError(f"{where}: {FORM}; '{word.strip()}' is not a finite number")
    return value
