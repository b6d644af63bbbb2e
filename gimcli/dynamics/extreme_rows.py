"""Least and greatest values of quantities over the rows of a motion in pieces, and their refinement between rows.

Where a row and both rows beside it are known, the extreme is searched between them by successive parabolic
interpolation within the bracket. Source: Brent, Algorithms for Minimization without Derivatives, 1973, section 3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import BoolArray, FloatArray

EQUAL = 1e-9
"""Relative difference of values that are equal: the first row is taken."""

ROUNDS = 8
"""Most evaluations of each extreme."""

POLE = 2.0
"""A value between rows that differs from its row by more than this multiple of the rows' values is next to a pole."""

EXACT = 1e-6
"""Change of the time, relative to a step, below which an extreme is exact: its value to the square of it."""


@dataclass
class RowExtreme:
    """The best row of a quantity, or a better time near it."""

    quantity: int
    sense: float  # 1.0: greatest, -1.0: least
    value: float
    time: float  # in steps
    beside: tuple[float, float]  # values of the rows beside it; NaN: not known


class ExtremeRows:
    """Finds the least and the greatest of the rows (quantities, rows) that come in pieces; NaN: the row is missing."""

    def __init__(self, quantities: int) -> None:
        self._best = np.full((2, 4, quantities), np.nan)  # greatest, least: value, row, values beside it
        self._first = self._last = np.zeros((quantities, 0))
        self.rows = 0

    def add(self, values: FloatArray) -> None:
        """Add the next rows."""
        if self._first.shape[1] < 2:
            self._first = np.concatenate([self._first, values[:, :2]], axis=1)[:, :2]
        block = np.concatenate([self._last, values], axis=1)
        before = self.rows - self._last.shape[1]
        self.rows += values.shape[1]
        if block.shape[1] > 2:
            self._take(block, before + 1)
        self._last = block[:, -2:]

    def finish(self, closed: bool) -> list[RowExtreme]:
        """Return the extremes of all quantities that have values; `closed`: the last row repeats the first one."""
        gap = np.full((len(self._last), 1), np.nan)
        if self.rows > 1:
            wraps = closed and self.rows > 2
            self._take(np.concatenate([self._last[:, :1] if wraps else gap, self._first[:, :2]], axis=1), 0)
            if not wraps:
                self._take(np.concatenate([self._last, gap], axis=1), self.rows - 1)
        elif self.rows:
            self._take(np.concatenate([gap, self._first, gap], axis=1), 0)
        return [
            RowExtreme(k, 1.0 - 2.0 * s, float(value), float(row), (float(left), float(right)))
            for s in range(2)
            for k, (value, row, left, right) in enumerate(self._best[s].T)
            if np.isfinite(value)
        ]

    def _take(self, block: FloatArray, first: int) -> None:
        """Compare the inner columns of a block, the first of which is row `first`."""
        own = np.arange(len(block))
        for best, sense in zip(self._best, (1.0, -1.0), strict=True):
            inner = np.where(np.isfinite(block[:, 1:-1]), sense * block[:, 1:-1], -np.inf)
            most = inner.max(axis=1)
            k = np.argmax(inner >= (most - EQUAL * np.abs(most))[:, None], axis=1)
            better = (most > -np.inf) & ~(most <= sense * best[0] + EQUAL * np.abs(best[0]))
            found = np.stack([block[own, k + 1], first + k, block[own, k], block[own, k + 2]])
            earlier = (most > -np.inf) & (first + k < best[1]) & (most >= sense * best[0] - EQUAL * np.abs(best[0]))
            best[:, better | earlier] = found[:, better | earlier]


Evaluate = Callable[[FloatArray], FloatArray]
"""Returns the quantities (quantities, times) at increasing times, in steps."""


def refined(extremes: list[RowExtreme], evaluate: Evaluate, constant: BoolArray) -> None:
    """Move extremes to better times between rows; those of the quantities that are `constant` stay."""
    begun = [_Bracket(one) for one in extremes if np.all(np.isfinite(one.beside)) and not constant[one.quantity]]
    todo = begun
    for _ in range(ROUNDS):
        guesses = [bracket.guess() for bracket in todo]
        open_ones = [(b, t) for b, t in zip(todo, guesses, strict=True) if abs(t - b.times[1]) > EXACT]
        if not open_ones:
            break
        times = np.unique([time for _, time in open_ones])
        values = evaluate(times)
        for bracket, time in open_ones:
            bracket.take(time, float(values[bracket.own.quantity, np.searchsorted(times, time)]))
        todo = [bracket for bracket, _ in open_ones if not bracket.lost]
    for bracket in begun:
        bracket.leave_pole()


class _Bracket:
    """Three times with the best value at the one in the middle."""

    def __init__(self, own: RowExtreme) -> None:
        self.own, self.lost, self.row = own, False, (own.time, own.value)
        self.times = [own.time - 1.0, own.time, own.time + 1.0]
        self.heights = [own.sense * v for v in (own.beside[0], own.value, own.beside[1])]

    def guess(self) -> float:
        """Return the top of the parabola through the three values, within the bracket."""
        (a, b, c), (fa, fb, fc) = self.times, self.heights
        left, right = (b - a) * (fb - fc), (b - c) * (fb - fa)
        if left == right:
            return b
        top = b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right)
        return min(max(top, a + 0.01 * (b - a)), c - 0.01 * (c - b))

    def leave_pole(self) -> None:
        """Return to the row if the values grow without bound between it and the rows beside it."""
        if abs(self.own.value - self.row[1]) > POLE * max(map(abs, (self.row[1], *self.own.beside))):
            self.own.time, self.own.value = self.row

    def take(self, time: float, value: float) -> None:
        """Use the value at a new time; a missing one ends the search."""
        if not np.isfinite(value):
            self.lost = True
            return
        height, after = self.own.sense * value, time > self.times[1]
        if height > self.heights[1]:
            self.own.time, self.own.value = time, value
            drop = 0 if after else 2
        else:
            drop = 2 if after else 0
        del self.times[drop], self.heights[drop]
        at = int(np.searchsorted(self.times, time))
        self.times.insert(at, time)
        self.heights.insert(at, height)
