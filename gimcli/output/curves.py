"""Simplify traced curves for drawing: no repeated points, no piece drawn over another."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from gimcli.connected import unlike
from gimcli.mechanism import ComplexArray, FloatArray

MOST_PIECES = 12
"""A curve with more reversals is drawn without change."""

MOST_LAPS = 6
"""Largest number of laps that are recognised. Only one is drawn: dashes drawn twice would look like a full line."""

TOGETHER = 0.1
"""Curves overlap if a larger part of one is on the other."""

TESTED = 60
"""Approximate number of points of a piece that are compared with other pieces."""


def drawn_runs(curve: ComplexArray, point: float) -> list[ComplexArray]:
    """Return the pieces of a curve between its gaps; `point` is a typographic point in data units."""
    runs = [_one_lap(run, 0.5 * point) for run in pieces(curve)]
    return [part for run in runs for part in _once(thinned(run, 0.3 * point), 0.5 * point)]


def thinned(curve: ComplexArray, cell: float) -> ComplexArray:
    """Return a long curve without the points that are in the same cell as the previous point."""
    if len(curve) < 2000:
        return curve
    column, row = np.floor(curve.real / cell), np.floor(curve.imag / cell)
    gap = ~np.isfinite(curve)
    column[gap], row[gap] = np.inf, np.inf
    keep = np.concatenate(([True], (np.diff(gap) | (column[1:] != column[:-1]) | (row[1:] != row[:-1]))))
    keep[-1] = True
    return curve[keep]


def pieces(curve: ComplexArray, cuts: Iterable[int] = ()) -> list[ComplexArray]:
    """Return the pieces of a curve between its gaps and before the rows `cuts` that do not continue the row before."""
    gaps = np.flatnonzero(~np.isfinite(curve))
    pieces = np.split(curve, sorted({*gaps.tolist(), *(gaps + 1).tolist(), *cuts}))
    return [piece for piece in pieces if len(piece) and np.all(np.isfinite(piece))]


def _one_lap(run: ComplexArray, near: float) -> ComplexArray:
    """Return the first lap of a curve that repeats itself with equal steps; otherwise the curve."""
    for laps in range(MOST_LAPS, 1, -1):
        lap, rest = divmod(len(run) - 1, laps)
        if lap > 2 and not rest and np.max(np.abs(run[lap:] - run[:-lap])) < near:
            return run[: lap + 1]
    return run


def _once(run: ComplexArray, near: float) -> list[ComplexArray]:
    """Return the pieces between reversals, without those that retrace a longer piece, so that dashes stay visible."""
    step = np.diff(run)
    turn = step[1:] * step[:-1].conjugate()
    reversals = 1 + np.flatnonzero(turn.real < -0.9 * np.abs(turn))
    if len(reversals) == 0 or len(reversals) > MOST_PIECES:
        return [run]
    ends = [0, *reversals.tolist(), len(run) - 1]
    pieces = [run[a : b + 1] for a, b in pairwise(ends) if b > a]
    pieces.sort(key=lambda piece: -float(np.sum(np.abs(np.diff(piece)))))
    return unlike(pieces, lambda piece, other: _share(other, piece, near) == 1.0)


def _share(path: ComplexArray, curve: ComplexArray, near: float) -> float:
    """Return the part of the points of a curve that are less than `near` from a path."""
    points = curve[:: max(1, len(curve) // TESTED)]
    return float(np.mean(_distances(points, path[:: max(1, len(path) // 400)]) < near))


def same_path(one: ComplexArray, other: ComplexArray, near: float) -> bool:
    """Return whether two curves are at most `near` apart everywhere."""
    return _share(one, other, near) == _share(other, one, near) == 1.0


def overlap(path: ComplexArray, other: ComplexArray, near: float) -> bool:
    """Return whether two curves are less than `near` apart over a part of the second one."""
    return _share(path, other, near) > TOGETHER


def _distances(points: ComplexArray, path: ComplexArray) -> FloatArray:
    """Return the distance of each point from a polyline."""
    span = np.diff(path)
    span = np.where(span == 0, 1e-300, span)
    along = np.clip(((points[:, None] - path[:-1]) / span).real, 0.0, 1.0)
    return np.asarray(np.min(np.abs(points[:, None] - path[:-1] - along * span), axis=1))
