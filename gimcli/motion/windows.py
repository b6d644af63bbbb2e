"""Windows about change points: polynomials of the input through places on both sides of the branch followed.

Places before the point give a polynomial that predicts the one beyond, on whichever sides the blocks are there: any
number of them may change at once. From there the branch is followed on, and a polynomial through both halves is
kept where it satisfies all equations within the window.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import chebyshev

from gimcli.kernels import influence
from gimcli.kernels.influence import Place
from gimcli.kernels.windows import Windows
from gimcli.mechanism import FloatArray
from gimcli.structure.chart import residuals

if TYPE_CHECKING:
    from gimcli.motion.reducer import Reducer

NODES, DEGREE = 7, 21
"""Places on either side, each with its slopes; degree of the polynomials through both."""

REACHES = (4.0, 3.0, 2.2, 1.6)
"""Half width of the polynomials' interval beside that of the window, tried in this order."""

WEAK, BEYOND = 0.03, 1.2
"""Determinant (unit gradients) below which a change point is looked for: beyond, accelerations are known to 1e-11; it
is less than that within a window, and somewhat beyond."""

BACK, MOST = 0.01, 0.5
"""Step by which the distance of the change point is estimated; greatest half width."""

PREDICTED, BENT = 1e-4, 1e-2
"""Greatest error of a predicted place beyond, and of its slopes, relative to the greatest."""

FITS, EXACT = 1e-12, 3e-14
"""Greatest residual within a window, of equations about 1 in size; below the latter no better one is looked for."""

INSIDE = 9
"""Places of a window at which the equations are asked."""

KEPT = 8
"""Windows that are kept, those nearest to the motion."""


@dataclass(frozen=True)
class Window:
    """One window."""

    bounds: tuple[float, float]
    centre: float
    half: float  # of the polynomials' interval
    factors: FloatArray  # (degrees, variables)
    edges: tuple[Place, Place]
    residual: float  # greatest within

    @property
    def weakest(self) -> float:
        """The least determinant at the edges."""
        return float(min(np.min(np.abs(edge.sign)) for edge in self.edges))


def no_windows(variables: int, blocks: int) -> Windows:
    """Return none."""
    return Windows(
        np.zeros((0, 2)), np.zeros((0, 2)), np.zeros((0, DEGREE + 1, variables)), np.zeros((0, 2, variables)),
        np.zeros((0, 2, variables)), np.zeros((0, 2, blocks)),
    )  # fmt: skip


def with_window(windows: Windows, found: Window, here: float) -> Windows:
    """Return windows with another one; the farthest from where the motion is are dropped."""
    new = (
        np.array(found.bounds), np.array([found.centre, found.half]), found.factors,
        np.array([edge.v for edge in found.edges]), np.array([edge.b[0] for edge in found.edges]),
        np.array([edge.sign for edge in found.edges]),
    )  # fmt: skip
    kept = np.argsort(np.abs(windows.scale[:, 0] - here))[: KEPT - 1]
    return Windows(*(np.concatenate([old[kept], one[None]]) for old, one in zip(windows, new, strict=True)))


def window_at(reducer: Reducer, block: int) -> Window | None:
    """Return the window about the change point near `reducer.at`, where a block is weak; None where there is none."""
    start, walk = copied(reducer.at), _Walk(reducer)
    own, determinant = reducer.own[0], abs(start.sign[block])
    beside = [place for step in (BACK, -BACK) if (place := walk.to(start, start.v[own] + step)) is not None]
    if not beside:
        return None
    away = max(beside, key=lambda place: abs(place.sign[block]))
    gain = abs(away.sign[block]) - determinant
    if not gain > 0.0:
        return None
    side = float(np.sign(away.v[own] - start.v[own]))  # from the change point to here
    distance, half = BACK * determinant / gain, BEYOND * BACK * WEAK / gain
    if not max(distance, half) < MOST:
        return None
    centre = start.v[own] - side * distance
    best: Window | None = None
    for reach in REACHES:
        found = walk.window(start, centre, side, half, reach * half)
        if found is not None and (best is None or found.residual < best.residual):
            best = found
        if best is not None and best.residual <= EXACT:
            break
    return best


class _Walk:
    def __init__(self, reducer: Reducer) -> None:
        self.reducer, self.own = reducer, reducer.own[0]

    def to(self, place: Place, target: float) -> Place | None:
        """Return the place at a target, followed from another."""
        reducer, last, found = self.reducer, copied(place), copied(place)
        follow = reducer.run(influence.follow)
        there = follow(reducer.chart, last, found, np.array([target]), np.zeros(1), reducer.room)
        return found if there else None

    def window(self, start: Place, centre: float, side: float, half: float, reach: float) -> Window | None:
        """Return the window of a half width, from places as far as a reach."""
        spread = half + (reach - half) * 0.5 * (1.0 - np.cos(np.pi * np.arange(NODES) / (NODES - 1)))
        near = self._along(start, centre + side * spread)
        if near is None:
            return None
        predicted = self._fitted(near, centre, reach, 2 * NODES - 1)
        first = self._predicted(predicted, centre, -side * half, reach, near[0])
        far = None if first is None else self._along(first, centre - side * spread)
        if far is None:
            return None
        factors = self._fitted([*near, *far], centre, reach, DEGREE)
        inside = chebyshev.chebval(np.linspace(-half / reach, half / reach, INSIDE), factors)
        error = max(float(np.max(np.abs(residuals(self.reducer.terms, v)))) for v in inside.T)
        if not error <= FITS:
            return None
        edges = (far[0], near[0]) if side > 0.0 else (near[0], far[0])
        return Window((centre - half, centre + half), centre, reach, factors, edges, error)

    def _along(self, start: Place, targets: FloatArray) -> list[Place] | None:
        places: list[Place] = []
        for target in targets:
            found = self.to(places[-1] if places else start, float(target))
            if found is None:
                return None
            places.append(found)
        return places

    def _predicted(self, factors: FloatArray, centre: float, way: float, reach: float, near: Place) -> Place | None:
        """Return the place beyond a change point that continues a polynomial; None where no block changes its side."""
        reducer, x = self.reducer, way / reach
        v = np.asarray(chebyshev.chebval(x, factors))
        slopes = np.asarray(chebyshev.chebval(x, chebyshev.chebder(factors))) / reach
        v[self.own] = centre + way
        found = Place(v.copy(), np.zeros((1, len(v))), np.zeros(len(near.sign)))
        reducer.run(influence.stand)(reducer.chart, found, reducer.room)
        if np.all(found.sign * near.sign > 0.0):
            return None
        if not reducer.run(influence.settle)(reducer.chart, found, np.zeros(1), reducer.room):
            return None
        size = max(1.0, float(np.max(np.abs(slopes))))
        straight = np.max(np.abs(found.v - v)) <= PREDICTED and np.max(np.abs(found.b[0] - slopes)) <= BENT * size
        return found if straight else None

    def _fitted(self, places: list[Place], centre: float, reach: float, degree: int) -> FloatArray:
        """Return Chebyshev factors (degree + 1, variables) that fit places and their slopes best."""
        x = np.array([(place.v[self.own] - centre) / reach for place in places])
        slopes = chebyshev.chebder(np.eye(degree + 1))  # of each polynomial
        table = np.vstack([chebyshev.chebvander(x, degree), chebyshev.chebvander(x, degree - 1) @ slopes])
        right = np.vstack([[place.v for place in places], [reach * place.b[0] for place in places]])
        moving = [self.own, *self.reducer.chart.unknown]
        factors = np.zeros((degree + 1, right.shape[1]))
        factors[0] = places[0].v  # what stands still keeps all its digits
        factors[:, moving] = np.linalg.lstsq(table, right[:, moving], rcond=None)[0]
        return factors


def copied(place: Place) -> Place:
    """Return a copy of a place."""
    return Place(place.v.copy(), place.b.copy(), place.sign.copy())
