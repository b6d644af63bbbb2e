"""Paths of a point along curves of critical positions: cubics between exact points, cut at their intersections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gimcli.continuation.arclength import correct, place
from gimcli.mechanism import FloatArray, IntArray
from gimcli.reach.critical_curves import WALK, CriticalCurve, CriticalPoint, cut, point_between

GAUSS = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)]), np.array([5.0, 8.0, 5.0]) / 18.0
"""Gauss nodes and weights on 0..1, exact for polynomials of fifth degree."""

Cut = tuple[int, float]
"""The number of a piece between two knots, and the parameter 0..1 in it."""


@dataclass(frozen=True, eq=False)
class PathArc:
    """The path y = Y x + y0 of a point along a branch, as cubics between the knots of the branch."""

    branch: CriticalCurve
    table: FloatArray  # Y (2, n)
    shift: FloatArray  # y0 (2,)
    inside: float = 0.0  # side of the reachable points next to the path: +1 left, -1 right, 0 unknown
    held: tuple[tuple[int, float], ...] = ()  # actuators at an end of their range, as in the stratum
    alone: bool = False  # one more input is at an end of its range along the whole path

    @property
    def closed(self) -> bool:
        """Return whether the branch has no ends."""
        return self.branch.closed

    @cached_property
    def y(self) -> FloatArray:
        """Points (knots, 2)."""
        return np.asarray(self.branch.x @ self.table.T + self.shift)

    @cached_property
    def hull(self) -> FloatArray:
        """Control points (pieces, 4, 2) of the cubics."""
        return np.asarray(self.branch.cubics @ self.table.T + self.shift)

    @cached_property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corners (pieces, 2) about the cubics."""
        return self.hull.min(axis=1), self.hull.max(axis=1)

    def at(self, piece: np.ndarray | int, t: FloatArray | float) -> FloatArray:
        """Return points (..., 2) of pieces at parameters t in 0..1."""
        return _cubic(self.hull[piece], t)

    def slope(self, piece: np.ndarray | int, t: FloatArray | float) -> FloatArray:
        """Return derivatives (..., 2) by t of pieces at parameters t."""
        return _cubic_slope(self.hull[piece], t)

    def dense(self, parts: int = 4) -> FloatArray:
        """Return points (rows, 2) of the path, `parts` per piece."""
        grid = np.arange(parts) / parts
        piece = np.repeat(np.arange(len(self.hull)), parts)
        return np.concatenate([self.at(piece, np.tile(grid, len(self.hull))), self.y[-1:]])

    @cached_property
    def lengths(self) -> FloatArray:
        """Lengths (pieces,) of the path."""
        every = np.arange(len(self.hull))
        return np.asarray(sum(w * np.linalg.norm(self.slope(every, t), axis=1) for t, w in zip(*GAUSS, strict=True)))

    @cached_property
    def length(self) -> float:
        """Length of the path."""
        return float(self.lengths.sum())

    @property
    def moment(self) -> float:
        """The integral of (x dy - y dx) / 2 along the path."""
        every, total = np.arange(len(self.hull)), 0.0
        for t, w in zip(*GAUSS, strict=True):
            y, slope = self.at(every, t), self.slope(every, t)
            total += 0.5 * w * float(np.sum(y[:, 0] * slope[:, 1] - y[:, 1] * slope[:, 0]))
        return total

    @property
    def extremes(self) -> FloatArray:
        """Points (rows, 2) that include those with extreme x or y."""
        first, second, third = np.moveaxis(np.diff(self.hull, axis=1), 1, 0)  # control points of the derivative
        a, b, c = first - 2.0 * second + third, 2.0 * (second - first), first
        root = np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))
        lean = -0.5 * (b + np.where(b >= 0.0, root, -root))
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = [np.where(np.isfinite(t), np.clip(t, 0.0, 1.0), 0.0) for t in (lean / a, c / lean)]
        every = np.arange(len(self.hull))
        return np.concatenate([self.y, *(self.at(every, t[:, k]) for t in parts for k in (0, 1))])

    @property
    def coarse(self) -> PathArc:
        """The path with every second knot."""
        knots = self.branch.knots
        return replace(self, branch=replace(self.branch, knots=(*knots[:-1:2], knots[-1])))

    def halfway(self, part: float = 0.5) -> Cut:
        """Return the cut at a fraction `part` of the length."""
        ends = np.cumsum(self.lengths)
        goal = part * ends[-1]
        k = min(int(np.searchsorted(ends, goal)), len(ends) - 1)
        return k, float(np.clip(1.0 - (ends[k] - goal) / max(self.lengths[k], 1e-300), 0.0, 1.0))

    @property
    def middle(self) -> CriticalPoint:
        """A position between the ends: the middle knot, or between the only two."""
        knots = self.branch.knots
        return knots[len(knots) // 2] if len(knots) > 2 else self.knot((0, 0.5))

    def knot(self, cut: Cut) -> CriticalPoint:
        """Return the corrected position at a cut, which may be a knot."""
        k, t = cut
        here, there = self.branch.knots[k : k + 2]
        if t <= 0.0 or t >= 1.0:
            return here if t <= 0.0 else there
        guess = point_between(here, there, t)
        towards = there.p - here.p
        towards = towards / max(float(np.linalg.norm(towards)), 1e-300)
        p = correct(self.branch.curve, guess, WALK, towards)
        if p is None:
            return CriticalPoint(guess, towards)
        found = place(self.branch.curve, p, towards)
        return CriticalPoint(p, found.tangent if found.regular > WALK.rank else towards)

    def cut(self, cuts: Sequence[Cut]) -> list[PathArc]:
        """Return the paths between cuts."""
        ordered = sorted(cuts)
        pieces = cut(self.branch, lambda k: (self.knot(at) for at in ordered if at[0] == k))
        return [replace(self, branch=piece) for piece in pieces]


@dataclass(frozen=True)
class Meeting:
    """Constants for intersections of paths, relative to the mechanism's size (about 1)."""

    same: float = 1e-6  # distance below which points are the same
    parallel: float = 1e-5  # sine of the angle below which paths touch instead of cross
    rounds: int = 10  # Newton iterations
    exact: float = 1e-12  # greatest distance of the paths at a crossing
    least: float = 1e-7  # length below which a path is a point


MEETING = Meeting()


def footpoints(arc: PathArc, z: FloatArray) -> list[Cut | None]:
    """Return for points (rows, 2) the cut at which a path passes at less than `same`; None where it does not."""
    low, high = arc.boxes
    near = np.all((low <= z[:, None] + MEETING.same) & (high >= z[:, None] - MEETING.same), axis=2)
    found: list[Cut | None] = [None] * len(z)
    row, piece = np.nonzero(near)
    if len(row):
        gap, t = feet(arc.hull[piece], z[row])
        for k in np.argsort(gap, kind="stable")[::-1]:  # the nearest comes last
            if gap[k] < MEETING.same:
                found[row[k]] = int(piece[k]), float(t[k])
    return found


class PathIndex:
    """The cubics of many paths with their boxes, for distances of points and for crossings."""

    def __init__(self, arcs: Sequence[PathArc]) -> None:
        counts = [len(arc.hull) for arc in arcs]
        self.hull = np.concatenate([arc.hull for arc in arcs])
        self.owner = np.repeat(np.arange(len(arcs)), counts)
        self.first = np.cumsum([0, *counts])
        self.closed = np.array([arc.closed for arc in arcs])
        self.low, self.high = self.hull.min(axis=1), self.hull.max(axis=1)

    def room(self, z: FloatArray, but: IntArray, most: float) -> FloatArray:
        """Return the distances of points (rows, 2) from the nearest path except path `but`, at most `most`."""
        pairs = [self._near(place, own, most) for place, own in zip(z, but.tolist(), strict=True)]
        row, near = np.repeat(np.arange(len(z)), [len(found) for found in pairs]), np.concatenate(pairs)
        room = np.full(len(z), most)
        np.minimum.at(room, row, feet(self.hull[near], z[row])[0])
        return room

    def _near(self, z: FloatArray, but: int, most: float) -> IntArray:
        """Return the cubics, except those of path `but`, whose boxes are within `most` of a point (2,)."""
        close = np.flatnonzero(np.all((self.low < z + most) & (self.high > z - most), axis=1))
        return np.asarray(close[self.owner[close] != but])

    def crossings(self) -> Iterator[tuple[int, Cut]]:
        """Yield path and cut of every crossing of paths with others or themselves."""
        i, j = np.concatenate([self._overlapping(k) for k in range(len(self.closed))], axis=1)
        a, b, t, u = self.hull[i], self.hull[j], np.full(len(i), 0.5), np.full(len(i), 0.5)
        for _ in range(MEETING.rounds):
            gap = _cubic(a, t) - _cubic(b, u)
            p, q = _cubic_slope(a, t), -_cubic_slope(b, u)
            det = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
            safe = np.where(np.abs(det) > np.finfo(float).tiny, det, np.inf)
            t = np.clip(t - (gap[:, 0] * q[:, 1] - gap[:, 1] * q[:, 0]) / safe, -0.5, 1.5)
            u = np.clip(u - (p[:, 0] * gap[:, 1] - p[:, 1] * gap[:, 0]) / safe, -0.5, 1.5)
        gap = np.linalg.norm(_cubic(a, t) - _cubic(b, u), axis=1)
        p, q = _cubic_slope(a, t), _cubic_slope(b, u)
        sine = np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
        sine /= np.maximum(np.linalg.norm(p, axis=1) * np.linalg.norm(q, axis=1), np.finfo(float).tiny)
        good = (gap < MEETING.exact) & (sine > MEETING.parallel)
        good &= (t >= 0.0) & (t < 1.0) & (u >= 0.0) & (u < 1.0)
        for k in np.flatnonzero(good):
            for piece, part in ((i[k], t[k]), (j[k], u[k])):
                owner = int(self.owner[piece])
                yield owner, (int(piece - self.first[owner]), float(part))

    def _overlapping(self, k: int) -> IntArray:
        """Return pairs (2, pairs) of cubics with overlapping boxes, one of path k, the other later."""
        first, end = self.first[k], self.first[k + 1]
        low, high = self.low[first:end], self.high[first:end]
        later = np.all((self.low[first:] <= high.max(axis=0)) & (self.high[first:] >= low.min(axis=0)), axis=1)
        others = first + np.flatnonzero(later)
        i, j = np.nonzero(np.all((low[:, None] <= self.high[others]) & (high[:, None] >= self.low[others]), axis=2))
        i, j = first + i, others[j]
        neighbours = self.closed[k] & (i == first) & (j == end - 1)
        keep = (j >= end) | ((j > i + 1) & ~neighbours)
        return np.array([i[keep], j[keep]])


def feet(hull: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the distances (rows,) of points (rows, n) from cubics (rows, 4, n), and the parameters of the feet."""
    t = np.full(len(hull), 0.5)
    for _ in range(MEETING.rounds):
        slope = _cubic_slope(hull, t)
        square = np.maximum(np.sum(slope**2, axis=1), np.finfo(float).tiny)
        t = np.clip(t - np.sum((_cubic(hull, t) - z) * slope, axis=1) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(_cubic(hull, t) - z, axis=1)), t


def _cubic(hull: FloatArray, t: FloatArray | float) -> FloatArray:
    """Return points (..., 2) of cubics given by control points (..., 4, 2)."""
    a, b, c, d = (hull[..., k, :] for k in range(4))
    t, s = np.asarray(t)[..., None], 1.0 - np.asarray(t)[..., None]
    return np.asarray(s**3 * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t**3 * d)


def _cubic_slope(hull: FloatArray, t: FloatArray | float) -> FloatArray:
    """Return derivatives (..., 2) by t of cubics given by control points (..., 4, 2)."""
    a, b, c, d = (hull[..., k, :] for k in range(4))
    t, s = np.asarray(t)[..., None], 1.0 - np.asarray(t)[..., None]
    return np.asarray(3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c)))
