"""The designs of a family, a table of which any rows are computed without the others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.families.sampling import POINTS
from gimcli.families.variation import MOST_VALUES, ListedValues, Varied, varied
from gimcli.mechanism import FloatArray

LEAST_SHARE = 2.0**-54
"""Smallest share at which a distribution is evaluated: a normal one is infinite at 0."""


@dataclass(frozen=True)
class DesignTable:
    """All combinations of listed values, the last dimension first, a list of designs, or a sample of distributions."""

    varied: Varied
    count: int
    points: str = ""  # kind of the sample; "" for combinations
    seed: int = 0
    in_order: bool = False  # the values of each dimension are those of the designs, one after another

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the varied dimensions."""
        return self.varied.names

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each dimension; () for a sample or a list."""
        if self.points or self.in_order:
            return ()
        return tuple(len(v.values) for v in self.varied.variations if isinstance(v, ListedValues))

    def rows(self, first: int, last: int) -> FloatArray:
        """Return the designs `first` to `last` - 1 (designs, dimensions) [file's units]."""
        if self.in_order:
            own = [v.values[first:last] for v in self.varied.variations if isinstance(v, ListedValues)]
            return np.stack(own, axis=1)
        if not self.points:
            places = np.unravel_index(np.arange(first, last), self.shape)
            listed = [v.values for v in self.varied.variations if isinstance(v, ListedValues)]
            return np.stack([values[at] for values, at in zip(listed, places, strict=True)], axis=1)
        share = POINTS[self.points](first, last, len(self.names), self.count, self.seed)
        share = np.clip(share, LEAST_SHARE, 1.0 - LEAST_SHARE)
        drawn = [v for v in self.varied.variations if not isinstance(v, ListedValues)]
        return np.stack([one.at(share[:, k]) for k, one in enumerate(drawn)], axis=1)


def design_table(own: Varied, samples: int | None = None, points: str = "random", seed: int = 0) -> DesignTable:
    """Return the table of the designs; raise UsageError where the options do not fit the variations."""
    if points not in POINTS:
        raise UsageError(f"points: expected one of {', '.join(POINTS)}, got '{points}'")
    if not 0 <= seed < 2**63:
        raise UsageError(f"seed: expected a whole number from 0 to 2^63 - 1, got {seed}")
    first = own.variations[0]
    if own.listed:
        if samples is not None:
            raise UsageError(
                f"samples: '{first.name}' has listed values, which are all combined; give a distribution such as"
                f" {first.name}=uniform(LOW,HIGH), or remove samples"
            )
        count = math.prod(len(v.values) for v in own.variations if isinstance(v, ListedValues))
        return _bounded(DesignTable(own, count))
    if samples is None:
        raise UsageError(f"vary {first.name}={first.text}: a distribution needs the number of samples (samples)")
    if samples < 1:
        raise UsageError(f"samples: expected a whole number from 1 to {MOST_VALUES}, got {samples}")
    return _bounded(DesignTable(own, samples, points, seed))


def _bounded(table: DesignTable) -> DesignTable:
    if table.count > MOST_VALUES:
        raise UsageError(f"vary: {table.count} designs, at most {MOST_VALUES} are possible: give fewer values")
    return table


def listed_designs(columns: Mapping[str, Any]) -> DesignTable:
    """Return the table of designs that are given by the values of each dimension, one after another."""
    own = varied({name: np.atleast_1d(values) for name, values in columns.items()})
    counts = {name: np.size(values) for name, values in columns.items()}
    if len(set(counts.values())) > 1:
        raise UsageError(f"vary: each dimension needs a value for each design, got {counts}")
    return _bounded(DesignTable(own, next(iter(counts.values())), in_order=True))
