"""The part of the values that a graph shows: a spike at a limit of an input does not determine the axis.

Values near a pole are set aside: next to rows without a value, to a limit or change point, to a jump between large
values of different sign, and to one or two values far from all others. Where the others are much closer together than
all values, the window ends a little beyond them. A peak of several rows is no pole: it is shown.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import FloatArray

BESIDE = 0.1
"""Part of the rows of a curve that is set aside on each side of a pole."""

SPIKE, BEYOND = 4.0, 0.4
"""The window is cut where all values spread over more than SPIKE times the others; it ends BEYOND of these further."""

JUMP = 0.3
"""Least jump at a pole, relative to the range."""

HALF, NARROW = 0.5, 2
"""Values above HALF of the largest deviation from the median are at a pole if at most NARROW follow one another."""

ROUNDING = 1e-9
"""A spread below this, relative to the largest value, is rounding: all values are shown."""

LEAST = 8
"""With fewer finite values all are shown."""


def value_window(curves: Iterable[FloatArray], events: Sequence[FloatArray] = ()) -> tuple[float, float]:
    """Return the least and the greatest value that are shown; (0, 1) if there is none.

    `events` are rows (for each curve, or none) that are next to a limit or a change point.
    """
    every = list(curves)
    rows = events or [np.zeros(0)] * len(every)
    spans = [span for span in map(_span, every, rows) if span is not None]
    if not spans:
        return 0.0, 1.0
    whole = min(s[0] for s in spans), max(s[1] for s in spans)
    inner = min(s[2] for s in spans), max(s[3] for s in spans)
    spread = inner[1] - inner[0]
    if spread <= ROUNDING * max(map(abs, whole)) or whole[1] - whole[0] <= SPIKE * spread:
        return whole
    return max(whole[0], inner[0] - BEYOND * spread), min(whole[1], inner[1] + BEYOND * spread)


def _span(values: FloatArray, events: FloatArray) -> tuple[float, float, float, float] | None:
    """Return the range of a curve, and the range without the values near poles; None if it has no finite value."""
    finite = np.isfinite(values)
    y = values[finite]
    if not len(y):
        return None
    low, high = float(y.min()), float(y.max())
    poles = ~finite
    poles[events.astype(np.int64)] = True
    poles[np.flatnonzero(finite)[_poles(y)]] = True
    calm = values[finite & ~_beside(poles, int(BESIDE * len(y)))]
    if len(y) < LEAST or len(calm) < LEAST:
        return low, high, low, high
    return low, high, float(calm.min()), float(calm.max())


def _poles(y: FloatArray) -> NDArray[np.bool_]:
    """Return for each value whether it is at a jump between large values of different sign, or far above the others."""
    found = np.zeros(len(y), dtype=bool)
    if len(y) < LEAST:
        return found
    size, away = np.abs(y), np.abs(y - np.median(y))
    high = np.concatenate([[False], away >= HALF * away.max(), [False]])
    starts, ends = (np.flatnonzero(high[1:] & ~high[:-1]), np.flatnonzero(high[:-1] & ~high[1:]))
    for start, end in zip(starts, ends, strict=True):
        found[start:end] = end - start <= NARROW
    jump = (y[1:-2] * y[2:-1] < 0.0) & (size[1:-2] > size[:-3]) & (size[2:-1] > size[3:])
    jump &= np.abs(y[2:-1] - y[1:-2]) > JUMP * np.ptp(y)
    found[1:-2] |= jump
    found[2:-1] |= jump
    return found


def _beside(poles: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Return for every row whether there is a pole at most `reach` rows from it."""
    total = np.concatenate([[0], np.cumsum(poles)])
    rows = np.arange(len(poles))
    return np.asarray(total[np.minimum(rows + reach + 1, len(poles))] > total[np.maximum(rows - reach, 0)])
