"""Values along a curve: cubics between points, and places at which a value is 0 or greatest, or a condition begins.

Source: Dowell & Jarratt, A modified regula falsi method, BIT 11 (1971) 168-174 (the Illinois method).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Place = TypeVar("Place", float, FloatArray)
Point = TypeVar("Point")

Part = float | FloatArray
"""Fraction of the interval, 0..1; for several cubics an array that can be multiplied with their points."""


def hermite(here: FloatArray, low: FloatArray, there: FloatArray, high: FloatArray, t: Part) -> FloatArray:
    """Return the cubic at t, for given end points (here, there) and derivatives by t at them (low, high)."""
    p = (1.0 + 2.0 * t) * (1.0 - t) ** 2 * here + t**2 * (3.0 - 2.0 * t) * there
    return p + t * (1.0 - t) ** 2 * low - t**2 * (1.0 - t) * high


def hermite_slope(here: FloatArray, low: FloatArray, there: FloatArray, high: FloatArray, t: Part) -> FloatArray:
    """Return the derivative by t of the same cubic."""
    return 6.0 * t * (1.0 - t) * (there - here) + (1.0 - t) * (1.0 - 3.0 * t) * low + t * (3.0 * t - 2.0) * high


def lagrange(nodes: Sequence[float], time: float) -> list[float]:
    """Return the weights, at a time, of the values at `nodes` in the interpolation polynomial."""
    return [math.prod((time - b) / (a - b) for b in nodes if b != a) for a in nodes]


HALVINGS = 60
"""Most bisections: more than the binary digits of a number."""


def bisected(holds: Callable[[Place], Any], low: Place, high: Place) -> tuple[Place, Place]:
    """Return the last place at which a condition does not hold and the first at which it does, to rounding.

    It does not hold at `low` and holds at `high`; arrays are pairs of their own. `low` may be above `high`.
    """
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if np.all((middle == low) | (middle == high)):
            break
        there = holds(middle)
        low, high = (cast("Place", np.where(there, *ends)[()]) for ends in ((low, middle), (middle, high)))
    return low, high


def sign_changes(value: Callable[[FloatArray], FloatArray], grid: FloatArray) -> FloatArray:
    """Return the places (roots,) between those of a grid (rows,) at which a value changes its sign, to rounding."""
    at = value(grid)
    k = np.flatnonzero(at[:-1] * at[1:] < 0.0)
    return bisected(lambda place: value(place) * at[k] <= 0.0, grid[k], grid[k + 1])[1] if len(k) else grid[k]


@dataclass
class Bracket:
    """Two places, the lower one first, between which a value changes its sign: they are moved towards it by trials."""

    ends: list[float]
    values: list[float]  # at the ends; that of an end that stays is halved by the Illinois method
    last: int = -1  # the end that was replaced last
    width: float = field(default=math.inf, init=False)  # at the last of each three trials
    trials: int = field(default=0, init=False)

    @property
    def middle(self) -> float:
        """The middle of the interval."""
        return 0.5 * (self.ends[0] + self.ends[1])

    def guess(self) -> float:
        """Return the place at which the value, taken as linear between the ends, is 0."""
        (a, b), (one, other) = self.ends, self.values
        zero = a + (b - a) * one / (one - other) if one != other else self.middle
        return min(max(zero, a), b)  # outside only by rounding errors

    def trial(self) -> float:
        """Return the place of the next trial: the guess, or the middle where three guesses did not halve the interval.

        After many trials it is always the middle.
        """
        before, self.trials = self.width, self.trials + 1
        if self.trials % 3 == 0:
            self.width = self.ends[1] - self.ends[0]
        halved = self.trials % 3 > 0 or self.width <= 0.5 * before
        return self.guess() if halved and self.trials <= HALVINGS // 2 else self.middle

    def replace(self, place: float, value: float) -> None:
        """Use the value at a new place as that of an end."""
        side = 0 if (value > 0.0) == (self.values[0] > 0.0) else 1
        self.ends[side], self.values[side] = place, value
        if side == self.last:
            self.values[1 - side] *= 0.5
        self.last = side


def root(
    at: Callable[[float], Point], value: Callable[[Point], float], low: tuple[float, Point],
    high: tuple[float, Point], close: float,
) -> Point:  # fmt: skip
    """Return the point between two points, given with their places, at which a value changes its sign.

    at: the point at a place. It ends when one more trial would move the place by at most `close`.
    """
    return roots(lambda _, places: [at(place) for place in places], value, [(low, high)], close)[0]


def roots(
    at: Callable[[list[int], list[float]], Sequence[Point]], value: Callable[[Point], float],
    ends: Sequence[tuple[tuple[float, Point], tuple[float, Point]]], close: float,
) -> list[Point]:  # fmt: skip
    """Return the points at which a value changes its sign, each between two points, searched side by side.

    at: the points at places, for the numbers of their searches. ends, close: as in `root`, for each search.
    """
    brackets = [Bracket([low[0], high[0]], [value(low[1]), value(high[1])]) for low, high in ends]
    points, going = [high[1] for _, high in ends], list(range(len(ends)))
    for _ in range(2 * HALVINGS):
        places = [brackets[k].trial() for k in going]
        for k, place, point in zip(going, places, at(going, places) if going else (), strict=True):
            brackets[k].replace(place, value(point))
            points[k] = point
        going = [k for k, place in zip(going, places, strict=True) if abs(brackets[k].guess() - place) > close]
    return points


class Search(Protocol):
    """A search along a curve by trials at places."""

    quantity: int  # number of the quantity that it concerns

    def next(self) -> float | None:
        """Return the place of the next trial; None if there is none."""

    def take(self, place: float, found: Any) -> None:
        """Use what was found at a place."""


def search_together(
    searches: Sequence[Search], evaluate: Callable[[FloatArray], Callable[[int], FloatArray]], rounds: int
) -> None:
    """Continue all searches to their ends, or for a number of rounds, each with one evaluation at increasing places.

    evaluate: returns the function of the number of a quantity that returns what is found (..., places).
    """
    for _ in range(rounds):
        todo = [(one, place) for one in searches if (place := one.next()) is not None]
        if not todo:
            break
        places = np.unique([place for _, place in todo])
        found = evaluate(places)
        for one, place in todo:
            one.take(place, found(one.quantity)[..., np.searchsorted(places, place)])
