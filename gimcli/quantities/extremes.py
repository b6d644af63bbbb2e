"""Greatest and least values of quantities along a motion, refined between its rows.

A quantity is a formula over a state in dual numbers, which have its exact derivative by the time. Where the derivative
changes its sign between two rows, the zero is found on solved positions by the Illinois method.
Source: Dowell & Jarratt, A modified regula falsi method, BIT 11 (1971) 168-174.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.canonical import phase
from gimcli.mechanism import FloatArray
from gimcli.numerics.along import Bracket, search_together
from gimcli.quantities.state import State
from gimcli.rates.derivatives import MotionRates


@dataclass(frozen=True)
class ExtremesConstants:
    """Constants of the search."""

    iterations: int = 12  # most iterations of the Illinois method
    exact: float = 1e-13  # change of the time, 0..1, below which the time of an extreme is exact
    close: float = 1e-12  # change of the value, relative to the quantity's range, below which a value is exact
    zero: float = 1e-11  # derivative, relative to the greatest one, below which it is 0
    most: int = 24  # most brackets of the greatest, and of the least, value
    same: float = 1e-6  # bounds, relative to the range, that are equal if they differ by less
    constant: float = 1e-10  # range, relative to the greatest value, below which a quantity is constant


SEARCH = ExtremesConstants()


class RateRows(State):
    """Rows of a motion in dual numbers with the derivatives by the real time."""

    def __init__(self, time: FloatArray, rates: MotionRates) -> None:
        """Take increasing normalised times (rows,), and one derivative more than formulas ask for."""
        super().__init__(rates.mechanism)
        self.time, self.rates = time, rates

    def node(self, node: int, order: int = 0) -> Any:
        """Return the place of a node, or a derivative of it (rows,)."""
        return Dual(self.rates.nodes[order, node], self.rates.nodes[order + 1, node][None])

    def turning(self, member: int, order: int) -> Any:
        """Return omega or alpha of a member (rows,)."""
        found = self.rates.angular(member)
        return Dual(found[order - 1], found[order][None])

    def counted(self, member: int) -> Any:
        """Return the direction of a member (rows,) in (-pi, pi] rad."""
        first, second = self.mechanism.members[member].nodes[:2]
        arm = self.rates.nodes[0, second] - self.rates.nodes[0, first]
        return Dual(phase(arm), self.rates.angular(member)[:1])


@dataclass(frozen=True)
class Sought:
    """A quantity of a motion whose extremes are sought, as a formula; its derivative by the time comes with it.

    `least`: whether the least value is searched too, not only the greatest, and both times as exactly as the values.
    """

    formula: Callable[[RateRows], Any] = field(repr=False)
    least: bool = False

    def of(self, rows: RateRows) -> FloatArray:
        """Return values and derivatives by the time 0..1 (2, rows); NaN where they are not determined."""
        with np.errstate(all="ignore"):
            found = self.formula(rows)
        return np.array([found.value, found.slopes[0] * rows.mechanism.duration])


@dataclass(frozen=True)
class Extreme:
    """An extreme value and the normalised time at which it occurs."""

    value: float
    time: float


@dataclass
class ExtremeBracket(Bracket):
    """Two times between which the derivative of a quantity changes its sign, and the best time so far."""

    quantity: int = 0
    sense: float = 1.0  # 1.0: maximum, -1.0: minimum
    close: float = 0.0  # change of the value below which it is exact; 0: the time must be exact
    value: float = math.nan
    time: float = math.nan
    shift: float = math.inf  # change of the time by one more iteration

    def next(self) -> float | None:
        """Return the time of the next iteration; None if the time, or the value, is exact."""
        return None if self.shift <= SEARCH.exact else self.guess()

    def take(self, time: float, found: FloatArray) -> None:
        """Use the value and the derivative by the time 0..1 (2,) at a new time."""
        value, slope = found.tolist()
        self.shift = 0.0
        if math.isfinite(value + slope):
            self.value, self.time = value, time
            if slope != 0.0:
                self.replace(time, slope)
                self.shift = abs(self.guess() - time)
        if abs(slope) * self.shift <= self.close:
            self.shift = 0.0


Solve = Callable[[FloatArray], RateRows]
"""Returns rows at increasing times."""


@dataclass(frozen=True)
class Extremes:
    """The least and the greatest value of a quantity, and how often its derivative changes its sign."""

    least: Extreme
    greatest: Extreme
    reversals: int


def extremes(rows: RateRows, quantities: Sequence[Sought], solve: Solve, periodic: bool) -> list[Extremes | None]:
    """Return the extremes of each quantity; None where it has no values.

    `solve` returns rows at further times. `periodic`: the last row repeats the first one, so that the ends are no
    extremes of their own.
    """
    at_rows = [quantity.of(rows) for quantity in quantities]
    brackets = [_brackets(k, rows, f, df, periodic) for k, (f, df) in enumerate(at_rows)]
    best = [_promising(rows, f, own, q.least) for (f, _), own, q in zip(at_rows, brackets, quantities, strict=True)]

    def evaluate(time: FloatArray) -> Callable[[int], FloatArray]:
        found = solve(time)
        return cache(lambda number: quantities[number].of(found))

    search_together([b for own in best for b in own], evaluate, SEARCH.iterations)
    return [_found(rows, f, best[k], len(brackets[k])) for k, (f, _) in enumerate(at_rows)]


def _promising(rows: RateRows, f: FloatArray, own: list[ExtremeBracket], least: bool) -> list[ExtremeBracket]:
    """Return the brackets that may contain the greatest or the least value: a slope limits what lies between rows.

    In motions that repeat, only the first ones of many are kept.
    """
    span, found = _span(f), list[ExtremeBracket]()
    near = SEARCH.same * span
    for sense in (1.0, -1.0) if own and least else (1.0,) if own else ():
        kept: list[tuple[float, float, ExtremeBracket]] = []
        for bracket in (b for b in own if b.sense == sense):
            rise = (bracket.ends[1] - bracket.ends[0]) * max(map(abs, bracket.values))
            highest = max(sense * f[np.searchsorted(rows.time, bracket.ends)]) + rise
            if highest >= np.nanmax(sense * f):
                kept.append((-round(highest / near) if near else 0, bracket.ends[0], bracket))
        found += [bracket for *_, bracket in sorted(kept, key=lambda one: one[:2])[: SEARCH.most]]
    for bracket in () if least else found:
        bracket.close = SEARCH.close * span
    return found


def _span(f: FloatArray) -> float:
    finite = f[np.isfinite(f)]
    return float(np.ptp(finite)) if len(finite) else 0.0


def _found(rows: RateRows, f: FloatArray, own: list[ExtremeBracket], reversals: int) -> Extremes | None:
    good = np.flatnonzero(np.isfinite(f))
    if not len(good):
        return None
    inner = [b for b in own if math.isfinite(b.value)]

    def best(sense: float) -> Extreme:
        k = int(good[np.argmax(sense * f[good])])
        row = Extreme(float(f[k]), float(rows.time[k]))
        most = max([sense * row.value, *(sense * b.value for b in inner)])
        equal = [b for b in inner if sense * b.value >= most - SEARCH.constant * abs(most)]  # the first of equal ones
        return min((Extreme(b.value, b.time) for b in equal), key=lambda one: one.time, default=row)

    return Extremes(best(-1.0), best(1.0), reversals)


def _brackets(number: int, rows: RateRows, f: FloatArray, df: FloatArray, periodic: bool) -> list[ExtremeBracket]:
    """Return the brackets of the extremes of a quantity between its rows."""
    good = np.flatnonzero(np.isfinite(f) & np.isfinite(df))
    if len(good) < 2 or _span(f) <= SEARCH.constant * np.max(np.abs(f[good])):
        return []
    slope = df[good]
    sign = _filled(np.where(np.abs(slope) <= SEARCH.zero * np.max(np.abs(slope)), 0.0, np.sign(slope)), periodic)
    return [
        ExtremeBracket(rows.time[good[[k, k + 1]]].tolist(), slope[[k, k + 1]].tolist(), -1, number, float(sign[k]))
        for k in np.flatnonzero(sign[:-1] * sign[1:] < 0.0).tolist()
    ]


def _filled(sign: FloatArray, periodic: bool) -> FloatArray:
    """Return signs with that of the row before where the derivative is 0, so that each extreme is counted once."""
    known = np.flatnonzero(sign)
    before = np.searchsorted(known, np.arange(len(sign)), side="right") - 1  # -1: the last one
    return sign[known[before if periodic else np.maximum(before, 0)]] if len(known) else sign
