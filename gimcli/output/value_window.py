"""The part of the values that a graph shows: a pole does not determine the axis, a finite peak does.

A pole is a place where a curve goes to infinity: a limit or change point, or a gap, towards which the values grow as a
negative power of the distance in rows; or a place between two rows where the reciprocal of the curve, or of its
magnitude, passes through zero on a straight line. The values that rise towards a pole are set aside; where the others
are much closer together than all values, the window ends a little beyond them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from gimcli.mechanism import BoolArray, FloatArray

BESIDE = 0.1
"""Largest part of the rows of a curve that is set aside on each side of a pole."""

SPIKE, BEYOND = 4.0, 0.4
"""The window is cut where all values spread over more than SPIKE times the others; it ends BEYOND of these further."""

LEAST_POWER, KEPT = 0.3, 0.8
"""Towards a pole values grow at least as distance^-LEAST_POWER, with a power that does not fall below KEPT of that of
the rows before: at a limit of an input rates grow as distance^(-1/2)."""

POWERS = (1.0, 3.0)
"""Orders of poles with a change of sign."""

SIGNED, UNSIGNED = 2.0, 1.2
"""Largest ratio of the differences of the reciprocal on both sides of a pole to their median: with a change of sign,
and without, where a finite peak is similar."""

ROUNDING = 1e-9
"""A spread of the others below this, relative to their largest, is rounding: all values are shown."""

LEAST = 8
"""With fewer finite values all are shown."""


def value_window(curves: Iterable[FloatArray], events: Sequence[FloatArray] = ()) -> tuple[float, float]:
    """Return the least and the greatest value that are shown; (0, 1) if there is none.

    `events` are rows, with fractions between them, of limits and change points (for each curve, or none).
    """
    every = list(curves)
    rows = events or [np.zeros(0)] * len(every)
    spans = [span for span in map(_span, every, rows) if span is not None]
    if not spans:
        return 0.0, 1.0
    whole = min(s[0] for s in spans), max(s[1] for s in spans)
    inner = min(s[2] for s in spans), max(s[3] for s in spans)
    spread = inner[1] - inner[0]
    if spread <= ROUNDING * max(map(abs, inner)) or whole[1] - whole[0] <= SPIKE * spread:
        return whole
    return max(whole[0], inner[0] - BEYOND * spread), min(whole[1], inner[1] + BEYOND * spread)


def _span(values: FloatArray, events: FloatArray) -> tuple[float, float, float, float] | None:
    """Return the range of a curve, and the range without the values that rise to poles; None without finite values."""
    y = values[np.isfinite(values)]
    if not len(y):
        return None
    low, high = float(y.min()), float(y.max())
    calm = y if len(y) < LEAST else values[np.isfinite(values) & ~_rises(values, events, int(BESIDE * len(y)))]
    return (low, high, low, high) if len(calm) < LEAST else (low, high, float(calm.min()), float(calm.max()))


def _rises(values: FloatArray, events: FloatArray, most: int) -> BoolArray:
    """Return for every row whether the curve rises there to a pole at most `most` rows away."""
    found, size = np.zeros(len(values), dtype=bool), np.abs(values)
    crossed = _crossed(values)
    for pole in np.unique([*crossed, *events, *_gaps(values)]):
        for side in (-1, 1):
            rows = np.arange(len(values))
            rows = rows[rows <= pole][::-1] if side < 0 else rows[rows >= pole]
            rows = rows[np.isfinite(values[rows])][: most + 1]
            if len(rows) > 3 and (pole in crossed or _diverges(size[rows], np.abs(rows - pole))):
                falls = (np.diff(size[rows]) < 0.0) & (np.diff(rows) == side)
                found[rows[: int(np.argmin(np.append(falls, False))) + 1][:most]] = True
    return found


def _diverges(size: FloatArray, away: FloatArray) -> bool:
    """Return whether magnitudes, the nearest first, grow towards a place as a power of the distances in rows."""
    start = int(away[0] < ROUNDING)  # a row on the event
    y, distance = size[start : start + 3], away[start : start + 3]
    if len(y) < 3 or not y[0] > y[1] > y[2] > 0.0:
        return False
    near, far = -np.diff(np.log(y)) / np.diff(np.log(distance))
    return bool(near >= LEAST_POWER and near >= KEPT * far)


def _gaps(values: FloatArray) -> FloatArray:
    """Return the middle of every gap between values, and the row beside the first and the last value."""
    known = np.flatnonzero(np.isfinite(values))
    before, after = known[:-1], known[1:]
    ends = [known[0] - 1] * bool(known[0]) + [known[-1] + 1] * bool(known[-1] + 1 < len(values))
    return np.asarray(np.append(0.5 * (before + after)[after - before > 1], ends), dtype=np.float64)


def _crossed(values: FloatArray) -> FloatArray:
    """Return the places between two rows where the reciprocal passes through zero on a straight line (poles,)."""
    near = np.lib.stride_tricks.sliding_window_view(values, min(6, len(values)))
    if near.shape[1] < 6:
        return np.zeros(0)
    change = np.array([1, 1, 1, -1, -1, -1])
    with np.errstate(all="ignore"):
        found = np.zeros(len(near), dtype=bool)
        for power in POWERS:
            found |= _straight(np.sign(near) * np.abs(near) ** (-1.0 / power), SIGNED)
        found |= _straight(change / np.abs(near), UNSIGNED)
    return np.asarray(np.flatnonzero(found) + 2.5, dtype=np.float64)


def _straight(rows: FloatArray, most: float) -> BoolArray:
    """Return whether values (places, 6) change sign in the middle only, with differences within a ratio `most`."""
    steps = np.diff(rows) * np.sign(rows[:, 5:] - rows[:, :1])
    middle = np.median(steps, axis=1, keepdims=True)
    alike = np.all((steps * most >= middle) & (steps <= most * middle) & (middle > 0.0), axis=1)
    return np.asarray(alike & (rows[:, 2] * rows[:, 3] < 0.0))
