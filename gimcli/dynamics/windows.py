"""Windows about change points: slabs in the independent variables in which the branch is interpolated.

Positions before a change point give a polynomial that predicts a position behind it; any number of blocks may change
their configuration there. A window is accepted if the positions on both sides determine those inside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from gimcli.kernels import influence
from gimcli.kernels.influence import Chart, InfluencePosition, InfluenceScratch
from gimcli.kernels.windows import FLOOR, NODES, Windows, interpolate
from gimcli.mechanism import BoolArray, FloatArray, IntArray
from gimcli.positions.newton import Run
from gimcli.structure.terms import Terms

REACHES = (4.0, 3.0, 2.2, 1.6)
"""Distances of the farthest position from the middle, in half widths of the window, in the order of trial."""

WEAK, BEYOND = 0.03, 1.2
"""Determinant (unit gradients) below which a change point is searched: above it accelerations are accurate to 1e-11.
BEYOND times WEAK is the determinant at the edges of a window."""

CLOSE, ALONG = 10.0, 0.3
"""Determinant relative to WEAK below which other blocks count; least part of a direction along their sheets."""

FAR = 1.0
"""Greatest distance of a change point: a determinant that hardly changes has none."""

NEAR = 2.0
"""Distance in half widths within which another change point is included in the window."""

BACK, MOST = 0.01, 0.5
"""Step before the search for a change point; greatest half width."""

SLOPED = 0.1
"""Step for slopes of determinants, relative to the distance of the change point."""

PREDICTED, BENT = 1e-4, 1e-2
"""Greatest error of a predicted position, and of its slopes relative to the greatest slope."""

FITS, EXACT = 1e-12, 3e-14
"""Greatest residual in a window (equations scaled to about 1); residual below which no better window is searched."""

INSIDE = 9
"""Number of positions in a window at which the residual is computed."""

KEPT = 8
"""Most windows that are kept; those nearest to the motion."""


def no_windows(size: int, variables: int, blocks: int) -> Windows:
    """Return empty arrays of windows for `size` independent variables."""
    return Windows(
        np.zeros((0, size)), np.zeros((0, size)), np.zeros(0), np.zeros(0), np.zeros((0, 2, NODES)),
        np.zeros((0, 2, NODES)), np.zeros((0, 2, variables)), np.zeros((0, 2, size, variables)),
        np.zeros((0, 2, blocks)), np.zeros((size + 3, variables)), np.zeros(size),
    )  # fmt: skip


def one_window(
    centre: FloatArray, normal: FloatArray, half: float, spread: FloatArray, edges: Sequence[InfluencePosition],
    weakest: float,
) -> Windows:  # fmt: skip
    """Return the window |(s - centre) . normal| <= half, interpolated from positions `spread` before and behind it."""
    offsets = np.array([-spread, spread])
    apart = offsets.ravel()[:, None] - offsets.ravel()[None, :] + np.eye(2 * NODES)
    v, b, sign = (np.array([parts]) for parts in zip(*edges, strict=True))
    own = no_windows(len(centre), v.shape[2], sign.shape[2])
    return own._replace(
        centre=centre[None], normal=normal[None], half=np.array([half]), weakest=np.array([weakest]),
        offsets=offsets[None], weights=(1.0 / np.prod(apart, axis=1)).reshape(1, 2, NODES), v=v, b=b, sign=sign,
    )  # fmt: skip


def with_window(windows: Windows, found: Windows, here: FloatArray) -> Windows:
    """Return windows with another one added in front; those farthest from the motion at `here` (k,) are dropped."""
    kept = np.argsort(np.linalg.norm(windows.centre - here, axis=1))[: KEPT - 1]
    both = [np.concatenate([new, old[kept]]) for old, new in zip(windows[:-2], found, strict=False)]
    return Windows(*both, *windows[len(both) :])  # the last two are scratch


def _normals(slopes: FloatArray) -> list[FloatArray]:
    """Return directions (k,) to try: across the first sheet, that along the others, and across all of them."""
    if not len(slopes):
        return []
    units = -slopes / np.linalg.norm(slopes, axis=1)[:, None]
    total = np.zeros(slopes.shape[1])
    for unit in units:
        total += unit if unit @ total >= 0.0 else -unit
    others = units[1:]
    along = units[0] - np.linalg.lstsq(others.T, units[0], rcond=None)[0] @ others if len(others) else 0.0 * units[0]
    size = float(np.linalg.norm(along))
    return [units[0], *([along / size] if size > ALONG else []), total / np.linalg.norm(total)]


def _sides(here: FloatArray, gains: FloatArray) -> tuple[float, float]:
    """Return the least and greatest distance of the window along its normal.

    Determinants have the values `here`, and the slopes `gains` along the normal.
    """
    with np.errstate(divide="ignore"):
        middles, halves = -here / gains, BEYOND * WEAK / np.abs(gains)
    near = np.abs(middles - middles[0]) <= NEAR * halves[0]
    middles, halves = middles[near], halves[near]
    return float(np.min(middles - halves)), float(np.max(middles + halves))


@dataclass(frozen=True)
class WindowSearch:
    """Searches for windows on the branch of a position."""

    run: Run
    terms: Terms
    chart: Chart
    own: list[int]  # (k,) the independent variables
    base: InfluencePosition
    room: InfluenceScratch

    def find(self, last: InfluencePosition, at: InfluencePosition, together: bool) -> Windows | None:
        """Return the window about the change point near the position `at`, reached from `last`; None if there is none.

        With `together` it must contain the change points of all weak blocks, also those on crossing sheets.
        """
        start = self.before(copied(last), copied(at))
        weak, slopes = self.slopes(start)
        normals = _normals(slopes)
        for normal in normals[:0:-1] if together else normals:
            best = self.best(start, normal, *_sides(np.abs(start.sign[weak]), slopes @ normal))
            if best is not None:
                return best
        return None

    @cached_property
    def turning(self) -> BoolArray:
        """Whether the determinant of each block varies (blocks,)."""
        return np.asarray(self.chart.blocks[:, 0] != influence.LINEAR)

    def to(self, place: InfluencePosition, target: FloatArray) -> InfluencePosition | None:
        """Return the position at a target (k,), followed from another position; None if it is not reached."""
        last, found = copied(place), copied(place)
        there = self.run(influence.follow)(self.chart, last, found, target, np.zeros(len(target)), self.room)
        return found if there else None

    def weakest(self, place: InfluencePosition) -> float:
        """Return the least absolute determinant of the blocks at a position."""
        return float(np.min(np.abs(place.sign[self.turning])))

    def before(self, last: InfluencePosition, near: InfluencePosition) -> InfluencePosition:
        """Return a position on the same branch shortly before a weak one."""
        target = near.v[self.own]
        while self.weakest(last) > WEAK and np.max(np.abs(target - last.v[self.own])) > BACK:
            middle = self.to(last, 0.5 * (last.v[self.own] + target))
            if middle is None or self.weakest(middle) < WEAK:
                target = 0.5 * (last.v[self.own] + target)
            else:
                last = middle
        return last

    def slopes(self, start: InfluencePosition) -> tuple[IntArray, FloatArray]:
        """Return the weak blocks, the weakest first, and the slopes of their determinants (blocks, k)."""
        here = np.abs(start.sign)
        weak = np.flatnonzero(self.turning & (here < CLOSE * max(WEAK, self.weakest(start))))
        weak = weak[np.argsort(here[weak])]
        step = min(BACK, SLOPED * self.weakest(start))
        slopes = np.zeros((len(weak), len(self.own)))
        for k, shift in enumerate(step * np.eye(len(self.own))):
            there = [self.to(start, start.v[self.own] + side * shift) for side in (1.0, -1.0)]
            one, other = (start if place is None else place for place in there)
            if one is not other:
                apart = one.v[self.own[k]] - other.v[self.own[k]]
                slopes[:, k] = (np.abs(one.sign) - np.abs(other.sign))[weak] / apart
        near = here[weak] < FAR * np.linalg.norm(slopes, axis=1)
        return weak[near], slopes[near]

    def best(self, start: InfluencePosition, normal: FloatArray, low: float, high: float) -> Windows | None:
        """Return the window between two distances from a position that has the least residual inside."""
        half, centre = 0.5 * (high - low), start.v[self.own] + 0.5 * (low + high) * normal
        best: tuple[float, Windows] | None = None
        for reach in REACHES if half < MOST else ():
            found = self.window(start, centre, normal, half, reach * half)
            if found is not None and (best is None or found[0] < best[0]):
                best = found
            if best is not None and best[0] <= EXACT:
                break
        return None if best is None else best[1]

    def window(
        self, start: InfluencePosition, centre: FloatArray, normal: FloatArray, half: float, reach: float
    ) -> tuple[float, Windows] | None:
        """Return the residual in a window and the window, interpolated from positions up to the distance `reach`."""
        spread = half + (reach - half) * 0.5 * (1.0 - np.cos(np.pi * np.arange(NODES) / (NODES - 1)))
        near = self._along(start, centre, normal, -spread)
        if near is None:
            return None
        first = self._predicted(near, centre, normal, half, reach)
        far = None if first is None else self._along(first, centre, normal, spread)
        if far is None:
            return None
        edges = (near[0], far[0])
        found = one_window(centre, normal, half, spread, edges, min(map(self.weakest, edges)))
        error = self._residual(found)
        return (error, found) if error <= FITS else None

    def _along(
        self, start: InfluencePosition, centre: FloatArray, normal: FloatArray, offsets: FloatArray
    ) -> list[InfluencePosition] | None:
        places: list[InfluencePosition] = []
        for offset in offsets:
            found = self.to(places[-1] if places else start, centre + offset * normal)
            if found is None or self.weakest(found) < FLOOR * WEAK:
                return None
            places.append(found)
        return places

    def _predicted(
        self, near: Sequence[InfluencePosition], centre: FloatArray, normal: FloatArray, half: float, reach: float
    ) -> InfluencePosition | None:
        """Return the position behind a change point predicted from others; None if no block changes its sign."""
        x = half / reach
        factors = self._fitted(near, centre, normal, reach)
        slopes = np.asarray(chebyshev.chebval(x, chebyshev.chebder(factors))) / reach
        v, unknown = near[0].v.copy(), self.chart.unknown  # fixed nodes keep their exact coordinates
        v[unknown] = np.asarray(chebyshev.chebval(x, factors))[unknown]
        v[self.own] = centre + half * normal
        found = InfluencePosition(v.copy(), np.zeros_like(near[0].b), np.zeros(len(near[0].sign)))
        self.run(influence.set_signs)(self.chart, found, self.room)
        if np.all(found.sign * near[0].sign > 0.0):
            return None
        if not self.run(influence.settle)(self.chart, found, np.zeros(len(self.own)), self.room):
            return None
        size = max(1.0, float(np.max(np.abs(slopes))))
        straight = np.max(np.abs(found.v - v)) <= PREDICTED and np.max(np.abs(normal @ found.b - slopes)) <= BENT * size
        return found if straight else None

    def _fitted(
        self, places: Sequence[InfluencePosition], centre: FloatArray, normal: FloatArray, reach: float
    ) -> FloatArray:
        """Return Chebyshev coefficients (degrees, variables) fitted to positions along a line and their slopes."""
        x, degree = np.array([(place.v[self.own] - centre) @ normal / reach for place in places]), 2 * NODES - 1
        slopes = chebyshev.chebder(np.eye(degree + 1))  # of each polynomial
        table = np.vstack([chebyshev.chebvander(x, degree), chebyshev.chebvander(x, degree - 1) @ slopes])
        right = np.vstack([[place.v for place in places], [reach * normal @ place.b for place in places]])
        return np.asarray(np.linalg.lstsq(table, right, rcond=None)[0])

    def _residual(self, window: Windows) -> float:
        """Return the greatest residual in a window."""
        size = len(self.own)
        last, found, error = copied(self.base), copied(self.base), 0.0
        for offset in np.linspace(-window.half[0], window.half[0], INSIDE):
            target = window.centre[0] + offset * window.normal[0]
            there = self.run(interpolate)(self.chart, window, 0, target, np.zeros(size), last, found, self.room)
            if not there:
                return np.inf
            error = max(error, float(np.max(np.abs(self.terms.arrays.values(found.v)))))
        return error


def copied(place: InfluencePosition) -> InfluencePosition:
    """Return a copy of a position."""
    return InfluencePosition(place.v.copy(), place.b.copy(), place.sign.copy())
