"""The spread of quantities that follows from tolerances of dimensions: to first order, and by random designs.

With derivatives s and tolerances t, to first order: worst case sum |s| t, root of the sum of squares (RSS)
sqrt(sum (s t)^2), standard deviation sqrt(sum (s sd)^2). Source: Chase & Parkinson, A survey of research in the
application of tolerance analysis to the design of mechanical assemblies, Res. Eng. Design 3 (1991) 23-37.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.mechanism import FloatArray
from gimcli.progress import Notify, Progress, no_progress

DEVIATIONS = {"normal": 1.0 / 3.0, "uniform": 1.0 / math.sqrt(3.0)}
"""Standard deviation of a dimension, relative to its tolerance: the tolerance is three of them, or the half width."""

PLACES = 1 << 22
"""Positions of nodes that are solved in one call."""


class FirstOrderSpread(NamedTuple):
    """Spread of quantities to first order (quantities, columns), in the file's units."""

    worst: FloatArray  # all dimensions at the end of their tolerance
    rss: FloatArray
    deviation: FloatArray  # standard deviation


class SampledSpread(NamedTuple):
    """Spread of quantities over random designs (quantities, columns), as differences from the nominal design."""

    samples: int
    solved: FloatArray  # (columns,) designs with a position
    mean: FloatArray
    mean_error: FloatArray  # standard error
    deviation: FloatArray  # standard deviation
    deviation_error: FloatArray  # standard error
    least: FloatArray
    greatest: FloatArray


def first_order_spread(slopes: FloatArray, tolerances: FloatArray, distribution: str) -> FirstOrderSpread:
    """Return the spread from derivatives (quantities, dimensions, columns) and tolerances (dimensions,)."""
    effects = np.abs(slopes) * tolerances[:, None]
    rss = np.sqrt(np.sum(effects**2, axis=1))
    return FirstOrderSpread(effects.sum(axis=1), rss, DEVIATIONS[distribution] * rss)


def drawn(seed: int, count: int, tolerances: FloatArray, distribution: str) -> FloatArray:
    """Return random differences from the nominal dimensions (count, dimensions); independent."""
    random = np.random.default_rng(seed)
    size = (count, len(tolerances))
    if distribution == "normal":
        return random.standard_normal(size) * (DEVIATIONS["normal"] * tolerances)
    return random.uniform(-1.0, 1.0, size) * tolerances


def sampled_spread(
    family: Family, inputs: FloatArray, changes: FloatArray, measure: Callable[[Designs], FloatArray],
    notify: Notify | None = None, progress: Progress = no_progress,
) -> SampledSpread:  # fmt: skip
    """Return the spread over designs whose dimensions differ by `changes` (designs, dimensions) from the nominal ones.

    inputs (actuators, rows) in the normal frame, the same for all designs. `measure` returns the differences of the
    quantities (quantities, designs, columns) from the nominal design; NaN where a design has no position.
    """
    sums: FloatArray | None = None
    ends: list[FloatArray] = []
    size = max(1, PLACES // (inputs.shape[1] * len(family.mechanism.nodes)))
    for begin in range(0, len(changes), size):
        part = changes[begin : begin + size]
        found = family.solve(family.nominal + part, inputs=inputs, notify=notify)
        away = measure(found)
        known = np.isfinite(away)
        clean = np.where(known, away, 0.0)
        own = np.stack([known.sum(axis=1), *((clean**k).sum(axis=1) for k in (1, 2, 3, 4))])
        sums = own if sums is None else sums + own
        ends += [np.fmin.reduce(away, axis=1), np.fmax.reduce(away, axis=1)]
        progress(begin + len(part), len(changes))
    assert sums is not None
    return _spread(len(changes), sums, np.fmin.reduce(ends[::2]), np.fmax.reduce(ends[1::2]))


def _spread(samples: int, sums: FloatArray, least: FloatArray, greatest: FloatArray) -> SampledSpread:
    """Return the spread from the sums of the powers 0 to 4 of differences (5, quantities, columns)."""
    with np.errstate(all="ignore"):
        n = sums[0]
        mean, second, third, fourth = sums[1:] / n
        variance = (second - mean**2) * n / (n - 1.0)
        central = fourth - 4.0 * mean * third + 6.0 * mean**2 * second - 3.0 * mean**4
        deviation = np.sqrt(np.maximum(variance, 0.0))
        error = np.sqrt(np.maximum(central - variance**2, 0.0) / n) / (2.0 * deviation)
        return SampledSpread(samples, n.min(axis=0), mean, deviation / np.sqrt(n), deviation, error, least, greatest)
