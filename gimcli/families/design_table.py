"""The designs of a family, a table of which any rows are computed without the others; and samples of designs.

Points of the unit cube are computed from their numbers. Sources: Salmon et al., Parallel random numbers: as easy as 1,
2, 3, SC 2011 (Philox, counters in place of a state); Black & Rogaway, Ciphers with arbitrary finite domains, CT-RSA
2002 (permutation of any length by a Feistel network); McKay, Beckman & Conover, Technometrics 21 (1979) 239-245 (Latin
hypercube); Sobol' points by scipy.stats.qmc.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.errors import UsageError, refuse
from gimcli.families.variation import MOST_VALUES, Distribution, ListedValues, Varied, varied
from gimcli.mechanism import FloatArray

Words = NDArray[np.uint64]

BLOCK = 1024
"""Number of random points that one counter gives."""

ROUNDS = 6
"""Rounds of the permutation."""


def random_points(first: int, last: int, size: int, count: int, seed: int) -> FloatArray:
    """Return independent random points `first` to `last` - 1 of a sample (points, size)."""
    blocks = [_block(number, size, seed) for number in range(first // BLOCK, -(-last // BLOCK))]
    start = first // BLOCK * BLOCK
    return np.concatenate(blocks)[first - start : last - start]


def latin_points(first: int, last: int, size: int, count: int, seed: int) -> FloatArray:
    """Return points of a Latin hypercube: each of `count` equal parts of every dimension has one point."""
    inside = random_points(first, last, size, count, seed)
    numbers = np.arange(first, last, dtype=np.uint64)
    strata = np.stack([permuted(numbers, count, seed, axis) for axis in range(size)], axis=1)
    return np.asarray((strata + inside) / count)


def sobol_points(first: int, last: int, size: int, count: int, seed: int) -> FloatArray:
    """Return scrambled Sobol' points."""
    from scipy.stats import qmc

    sampler = qmc.Sobol(size, scramble=True, seed=np.random.default_rng(seed))
    if first:
        sampler.fast_forward(first)
        return np.asarray(sampler.random(last - first))
    return np.asarray(sampler.random_base2((last - 1).bit_length()))[:last]


POINTS: dict[str, Callable[[int, int, int, int, int], FloatArray]] = {
    "random": random_points, "latin": latin_points, "sobol": sobol_points,
}  # fmt: skip
"""The kinds of samples: functions of the first number, the last + 1, the dimensions, the size of the sample, seed."""


def _block(number: int, size: int, seed: int) -> FloatArray:
    return np.random.Generator(np.random.Philox(key=seed, counter=[0, 0, number, 0])).random((BLOCK, size))


def permuted(numbers: Words, count: int, seed: int, axis: int) -> Words:
    """Return the places of numbers below `count` in a permutation that depends on the seed and the axis."""
    half = max(1, (max(count - 1, 1).bit_length() + 1) // 2)
    keys = np.random.Generator(np.random.Philox(key=seed, counter=[0, 0, axis, 1])).integers(
        0, 2**63, ROUNDS, dtype=np.uint64
    )
    found = _exchanged(numbers, half, keys)
    while (outside := found >= count).any():  # the network permutes more numbers than there are
        found[outside] = _exchanged(found[outside], half, keys)
    return found


def _exchanged(numbers: Words, half: int, keys: Words) -> Words:
    """Return a permutation of the numbers of 2 `half` bits."""
    shift, mask = np.uint64(half), np.uint64(2**half - 1)
    left, right = numbers >> shift, numbers & mask
    for key in keys:
        left, right = right, left ^ (_mixed(right ^ key) & mask)
    return np.asarray((left << shift) | right)


def _mixed(words: Words) -> Words:
    """Return words with their bits mixed (the finalizer of splitmix64: Steele, Lea & Flood, OOPSLA 2014)."""
    words = (words ^ (words >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    words = (words ^ (words >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(words ^ (words >> np.uint64(31)))


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
        return () if self.points or self.in_order else tuple(len(v.values) for v in self.listed)

    @property
    def listed(self) -> list[ListedValues]:
        """The dimensions with listed values."""
        return [v for v in self.varied.variations if isinstance(v, ListedValues)]

    def rows(self, first: int, last: int) -> FloatArray:
        """Return the designs `first` to `last` - 1 (designs, dimensions) [file's units]."""
        if not self.points:
            numbers = np.arange(first, min(last, self.count))
            places = [numbers] * len(self.names) if self.in_order else np.unravel_index(numbers, self.shape)
            return np.stack([v.values[at] for v, at in zip(self.listed, places, strict=True)], axis=1)
        share = POINTS[self.points](first, last, len(self.names), self.count, self.seed)
        share = np.clip(share, LEAST_SHARE, 1.0 - LEAST_SHARE)
        drawn = (v for v in self.varied.variations if isinstance(v, Distribution))
        return np.stack([one.at(share[:, k]) for k, one in enumerate(drawn)], axis=1)


def design_table(own: Varied, samples: int | None = None, points: str = "random", seed: int = 0) -> DesignTable:
    """Return the table of the designs; raise UsageError where the options do not fit the variations."""
    first, listed = own.variations[0], own.listed
    refuse(
        (points not in POINTS, f"points: expected one of {', '.join(POINTS)}, got '{points}'"),
        (not 0 <= seed < 2**63, f"seed: expected a whole number from 0 to 2^63 - 1, got {seed}"),
        (
            listed and samples is not None,
            f"samples: '{first.name}' has listed values, which are all combined; give a distribution such as"
            f" {first.name}=uniform(LOW,HIGH), or remove samples",
        ),
        (
            not listed and samples is None,
            f"vary {first.name}={first.text}: a distribution needs the number of samples (samples)",
        ),
        (
            not listed and (samples or 0) < 1,
            f"samples: expected a whole number from 1 to {MOST_VALUES}, got {samples}",
        ),
    )
    if listed:
        return _bounded(DesignTable(own, math.prod(DesignTable(own, 0).shape)))
    return _bounded(DesignTable(own, samples or 0, points, seed))


def _bounded(table: DesignTable) -> DesignTable:
    if table.count > MOST_VALUES:
        raise UsageError(f"vary: {table.count} designs, at most {MOST_VALUES} are possible: give fewer values")
    return table


def listed_designs(columns: Mapping[str, Any]) -> DesignTable:
    """Return the table of designs that are given by the values of each dimension, one after another."""
    own = varied({name: np.atleast_1d(values) for name, values in columns.items()})
    counts = {name: np.size(values) for name, values in columns.items()}
    refuse((len(set(counts.values())) > 1, f"vary: each dimension needs a value for each design, got {counts}"))
    return _bounded(DesignTable(own, next(iter(counts.values())), in_order=True))
