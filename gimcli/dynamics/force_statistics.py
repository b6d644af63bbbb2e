"""Mean, root mean square, least and greatest value of every effort and reaction over a motion in pieces.

Least and greatest values of quantities over the rows of a motion in pieces, and their refinement between rows.

Where a row and both rows beside it are known, the extreme is searched between them by successive parabolic
interpolation within the bracket. Source: Brent, Algorithms for Minimization without Derivatives, 1973, section 3.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gimcli.canonical import first_greatest
from gimcli.dynamics.force_motion import BearingLoad, RowIntegrals, Work, bearing_load, powers, turning_pins
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.statics import Statics
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.numerics.along import search_together
from gimcli.rates.derivatives import law_rates
from gimcli.table import Column, Table

EQUAL = 1e-9
"""Relative difference of values that are equal: the first row is taken."""

ROUNDS = 8
"""Most evaluations of each extreme."""

POLE = 2.0
"""A value between rows that differs from its row by more than this multiple of the rows' values is next to a pole."""

EXACT = 1e-6
"""Change of the time, relative to a step, below which an extreme is exact: its value to the square of it."""


class RowExtreme:
    """The best row of a quantity, or a better time near it: three times with the best value at the one in the middle.

    sense: 1.0 of the greatest value, -1.0 of the least. Times are in steps; the values of the rows beside may be NaN.
    """

    def __init__(self, quantity: int, sense: float, value: float, row: float, beside: tuple[float, float]) -> None:
        self.quantity, self.sense, self.value, self.time, self.row = quantity, sense, value, row, (row, value)
        self.beside = beside
        self.times = [row - 1.0, row, row + 1.0]
        self.heights = [sense * v for v in (beside[0], value, beside[1])]

    def next(self) -> float | None:
        """Return the top of the parabola through the three values, within them; None if it is exact or unknown."""
        (a, b, c), (fa, fb, fc) = self.times, self.heights
        left, right = (b - a) * (fb - fc), (b - c) * (fb - fa)
        if left == right:
            return None
        top = b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right)
        top = min(max(top, a + 0.01 * (b - a)), c - 0.01 * (c - b))
        return top if abs(top - b) > EXACT else None  # NaN: a value is missing

    def take(self, time: float, found: FloatArray) -> None:
        """Use the value at a new time; a missing one ends the search."""
        value, at = float(found), 2 if time > self.times[1] else 1
        height = self.sense * value if math.isfinite(value) else math.nan
        better = height > self.heights[1]
        if better:
            self.time, self.value = time, value
        self.times.insert(at, time)
        self.heights.insert(at, height)
        drop = 0 if better == (at == 2) else 3
        del self.times[drop], self.heights[drop]

    def leave_pole(self) -> None:
        """Return to the row if the values grow without bound between it and the rows beside it."""
        if abs(self.value - self.row[1]) > POLE * max(map(abs, (self.row[1], *self.beside))):
            self.time, self.value = self.row


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


def refined(extremes: list[RowExtreme], evaluate: Callable[[FloatArray], FloatArray], constant: BoolArray) -> None:
    """Move extremes to better times between rows; those of the quantities that are `constant` stay.

    evaluate: returns the quantities (quantities, times) at increasing times, in steps.
    """
    open_ones = [one for one in extremes if np.all(np.isfinite(one.beside)) and not constant[one.quantity]]
    search_together(open_ones, lambda times: evaluate(times).__getitem__, ROUNDS)
    for one in open_ones:
        one.leave_pole()


UNITS = ("N", "N m")
"""Units of the columns of efforts, reactions and moments."""

BOUNDS = (".least", ".greatest")
"""Ends of the names of columns that are limits of an effort, not an effort."""

CLOSED, SAME = 1e-9, 1e-6
"""Difference of the last position and its rates from the first ones, and of the forces, of a motion that repeats."""

AMOUNTS_AT = Callable[[FloatArray], dict[str, Column]]


@dataclass(frozen=True)
class Extremum:
    """A least or greatest value, and where it occurs."""

    value: float
    time: float  # s
    inputs: dict[str, float]  # file's units


@dataclass(frozen=True)
class Statistic:
    """One effort, reaction (its magnitude) or moment over the determined rows."""

    unit: str
    mean: float
    rms: float
    least: Extremum
    greatest: Extremum
    part: float  # of the time of the motion over which the mean is taken, 0..1

    @property
    def peak(self) -> Extremum:
        """The value with the greatest magnitude, the first one of two that are equal."""
        ends = sorted((self.greatest, self.least), key=lambda one: one.time)
        return ends[first_greatest(np.abs([one.value for one in ends]))]


@dataclass(frozen=True)
class ForceSummary:
    """What a motion says about the sizes of drives and bearings."""

    statistics: dict[str, Statistic]
    work: dict[str, Work]  # of each actuator, and of each kind of force
    bearings: dict[str, BearingLoad]
    closed: bool  # whether the motion repeats itself, so that means are those of a period


class ForceStatistics:
    """Accumulates the rows of a motion of a given number of steps."""

    def __init__(self, statics: Statics, steps: int) -> None:
        self.mechanism: Mechanism = statics.mechanism
        self.steps = steps
        self._step = self.mechanism.duration / steps
        self.units: dict[str, str] = {}
        self.names: tuple[tuple[str, ...], tuple[str, ...]] = (), ()  # of powers and of bearings
        self._ends: list[tuple[ComplexArray, FloatArray]] = []  # positions and amounts of the first and the last row

    def add(self, table: Table, motion: Motion, forces: Forces) -> None:
        """Add the next piece: its rows, motion and forces."""
        found = amounts(table, forces.bounded)
        values = np.array([amount.values for amount in found.values()])
        work, bearings = powers(forces), turning_pins(forces)
        integrands = np.concatenate([values, values**2, [*work.values()], *bearings.values()])
        if not self._ends:
            self.units = {name: amount.unit for name, amount in found.items()}
            self.names, signed = (tuple(work), tuple(bearings)), len(integrands) - 2 * len(found)
            self._sums, self._extremes = RowIntegrals(len(integrands), signed), ExtremeRows(len(found))
            self._ends.append((motion.z[:, 0], values[:, 0]))
        self._ends[1:] = [(motion.z[:, -1], values[:, -1])]
        self._sums.add(integrands)
        self._extremes.add(values)

    def summary(self, at: AMOUNTS_AT, inputs: Callable[[FloatArray], FloatArray]) -> ForceSummary:
        """Return everything, after the last rows.

        `at` returns the amounts at increasing normalised times, `inputs` the inputs there (actuators, times) in the
        file's units; extremes are refined between the rows with them.
        """
        closed, count = self._closed(), len(self.units)
        self._sums.finish(closed)
        extremes = self._extremes.finish(closed)
        refined(extremes, lambda steps: self._evaluated(at, steps), self._constant(extremes))
        places = self._places(extremes, inputs)
        with np.errstate(invalid="ignore", divide="ignore"):
            means = self._sums.net / self._sums.steps
        statistics = {
            name: Statistic(
                unit, float(means[k]), float(np.sqrt(max(means[count + k], 0.0))), places[k, -1.0], places[k, 1.0],
                float(self._sums.steps[k] / self.steps),
            )
            for k, (name, unit) in enumerate(self.units.items())
            if (k, 1.0) in places
        }  # fmt: skip
        positive, net, first = self._sums.positive, self._sums.net[2 * count :], len(self.names[0])
        work = {
            name: Work(float(up * self._step), float((whole - up) * self._step))
            for name, up, whole in zip(self.names[0], positive, net, strict=False)
        }
        sizes = np.stack([2.0 * positive - net, self._sums.steps[2 * count :]])[:, first:]
        bearings = {
            name: bearing_load(np.append(sizes[0, 3 * k : 3 * k + 3], sizes[1, 3 * k]), self._step)
            for k, name in enumerate(self.names[1])
        }
        return ForceSummary(statistics, work, bearings, closed)

    def _closed(self) -> bool:
        """Return whether the last row repeats the first one, and the laws continue in the same way there."""
        (first, before), (last, after) = self._ends
        if not np.max(self.mechanism.apart(last, first), initial=0.0) <= CLOSED * self.mechanism.size:
            return False
        rates = law_rates(self.mechanism, np.array([0.0, 1.0]), 3)[1:]
        least = CLOSED * np.max(np.abs(rates), axis=(1, 2), initial=0.0)[:, None]
        known = np.isfinite(before) & np.isfinite(after)
        near = np.abs(after - before)[known] <= SAME * np.max(np.abs([before[known], after[known]]), initial=0.0)
        return bool(np.all(np.abs(rates[..., 1] - rates[..., 0]) <= least) and np.all(near))

    def _constant(self, extremes: list[RowExtreme]) -> BoolArray:
        """Return for each quantity whether it is the same in all rows (quantities,)."""
        ends = np.zeros((2, len(self.units)))
        for one in extremes:
            ends[int(one.sense > 0.0), one.quantity] = one.value
        return np.asarray(ends[1] - ends[0] <= EQUAL * np.max(np.abs(ends), axis=0))

    def _evaluated(self, at: AMOUNTS_AT, steps: FloatArray) -> FloatArray:
        """Return the quantities (quantities, times) at times in steps; those before the start are of the last cycle."""
        times = (steps % self.steps) / self.steps
        order = np.argsort(times)
        found = at(times[order])
        result = np.empty((len(self.units), len(steps)))
        result[:, order] = [found[name].values for name in self.units]
        return result

    def _places(
        self, extremes: list[RowExtreme], inputs: Callable[[FloatArray], FloatArray]
    ) -> dict[tuple[int, float], Extremum]:
        """Return the extremes by quantity and sense."""
        times = np.array([one.time % self.steps if one.time < 0.0 else one.time for one in extremes]) / self.steps
        names = [actuator.name for actuator in self.mechanism.actuators]
        return {
            (one.quantity, one.sense): Extremum(
                one.value, float(time) * self.mechanism.duration, dict(zip(names, map(float, own), strict=True))
            )
            for one, time, own in zip(extremes, times, inputs(times).T, strict=True)
        }


def amounts(table: Table, bounded: BoolArray) -> dict[str, Column]:
    """Return the forces and moments of a table by name, of a pin force the magnitude; NaN in rows not bounded."""
    own = (column for column in table.columns if column.unit in UNITS and not column.name.endswith(BOUNDS))
    found, columns = {}, {column.name: column for column in own}
    for name, column in columns.items():
        if name.endswith(".fx"):
            y = columns[f"{name[:-1]}y"].values
            found[name[:-3]] = Column(name[:-3], np.where(bounded, np.abs(column.values + 1j * y), np.nan), column.unit)
        elif not name.endswith(".fy"):
            found[name] = Column(name, np.where(bounded, column.values, np.nan), column.unit)
    return found
