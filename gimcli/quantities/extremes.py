"""Greatest and least values of quantities along a motion, refined between its rows.

A quantity is a formula over a state in dual numbers, which have its exact derivative by the time. Where the derivative
changes its sign between two rows, the zero is found on solved positions: first that of the cubic through both rows,
then by the Illinois method.
Source: Dowell & Jarratt, A modified regula falsi method, BIT 11 (1971) 168-174.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.canonical import phase
from gimcli.mechanism import FloatArray
from gimcli.numerics.roots import Bracket
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

    def of(self, rows: RateRows) -> tuple[FloatArray, FloatArray]:
        """Return values and derivatives (rows,); NaN where they are not determined."""
        with np.errstate(all="ignore"):
            found = self.formula(rows)
        return found.value, found.slopes[0]


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
    value: float = math.nan
    time: float = math.nan
    change: float = math.inf  # estimated change of the value by one more iteration
    shift: float = math.inf  # change of the time by one more iteration

    def done(self, exact_time: bool, span: float) -> bool:
        """Return whether the time, or only the value, is exact."""
        return self.shift <= SEARCH.exact or (not exact_time and self.change <= SEARCH.close * span)

    def add(self, time: float, value: float, slope: float, duration: float) -> None:
        """Use the value and the derivative at a new time."""
        if not math.isfinite(value + slope):
            self.change = self.shift = 0.0
            return
        self.value, self.time = value, time
        if slope == 0.0:
            self.change = self.shift = 0.0
            return
        self.take(time, slope)
        self.shift = abs(self.guess() - time)
        self.change = abs(slope) * self.shift * duration


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
    _refine(rows, quantities, [b for own in best for b in own], solve, [_span(f) for f, _ in at_rows])
    return [_found(rows, f, best[k], len(brackets[k])) for k, (f, _) in enumerate(at_rows)]


def _promising(rows: RateRows, f: FloatArray, own: list[ExtremeBracket], least: bool) -> list[ExtremeBracket]:
    """Return the brackets that may contain the greatest or the least value: a slope limits what lies between rows.

    In motions that repeat, only the first ones of many are kept.
    """
    kept: list[tuple[float, ExtremeBracket]] = []
    most = {sense: float(np.nanmax(sense * f)) for sense in (1.0, -1.0)} if own else {}
    for bracket in own if least else [b for b in own if b.sense > 0.0]:
        k, m = np.searchsorted(rows.time, bracket.ends)
        rise = (bracket.ends[1] - bracket.ends[0]) * rows.mechanism.duration * max(map(abs, bracket.values))
        highest = max(bracket.sense * f[[k, m]]) + rise
        if highest >= most[bracket.sense]:
            kept.append((highest, bracket))
    near = SEARCH.same * _span(f)
    return [
        bracket
        for sense in (1.0, -1.0)
        for _, bracket in sorted(
            (one for one in kept if one[1].sense == sense),
            key=lambda one: (-round(one[0] / near) if near else 0, one[1].ends[0]),
        )[: SEARCH.most]
    ]


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
    sign = np.where(np.abs(slope) <= SEARCH.zero * np.max(np.abs(slope)), 0.0, np.sign(slope))
    _fill_zeros(sign, periodic)
    return [
        ExtremeBracket(rows.time[good[[k, k + 1]]].tolist(), slope[[k, k + 1]].tolist(), -1, number, float(sign[k]))
        for k in np.flatnonzero(sign[:-1] * sign[1:] < 0.0).tolist()
    ]


def _fill_zeros(sign: FloatArray, periodic: bool) -> None:
    """Give rows with a derivative of 0 the sign of the row before, so that each extreme is counted once."""
    nonzero = np.flatnonzero(sign)
    before = float(sign[nonzero[-1]] if periodic else sign[nonzero[0]]) if len(nonzero) else 0.0
    for k in range(len(sign)):
        if sign[k] == 0.0:
            sign[k] = before
        before = float(sign[k])


def _refine(
    rows: RateRows, quantities: Sequence[Sought], brackets: list[ExtremeBracket], solve: Solve, spans: list[float]
) -> None:
    """Refine all brackets together, by few solutions of many times; `spans`: ranges of the quantities."""
    duration = rows.mechanism.duration
    for _ in range(SEARCH.iterations):
        todo = [b for b in brackets if not b.done(quantities[b.quantity].least, spans[b.quantity])]
        if not todo:
            return
        guesses = np.array([b.guess() for b in todo])
        times = np.unique(guesses)
        found = solve(times)
        index = np.searchsorted(times, guesses)
        for number in {b.quantity for b in todo}:
            f, df = quantities[number].of(found)
            for k, bracket in enumerate(todo):
                if bracket.quantity == number:
                    bracket.add(float(guesses[k]), float(f[index[k]]), float(df[index[k]]), duration)
