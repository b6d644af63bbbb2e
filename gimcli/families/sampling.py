"""Points of the unit cube by their numbers, so that any part of a sample is computed without the rest.

Sources: Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC 2011 (Philox, counters in place of a state);
Black & Rogaway, Ciphers with arbitrary finite domains, CT-RSA 2002 (permutation of any length by a Feistel network);
McKay, Beckman & Conover, Technometrics 21 (1979) 239-245 (Latin hypercube); Sobol' points by scipy.stats.qmc.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

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
