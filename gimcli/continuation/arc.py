"""A short arc of a curve through a singular position: a limit of the input, or a position where branches meet.

As a point of the curve a limit is regular, and so is every other position on a branch near a meeting of branches. The
arc is the polynomial through positions at equal distances along the tangent. It gives the position at a parameter to
full accuracy, even if the parameter alone determines a node to only half the digits. A mechanism that is too large for
the curve of its motion passes a meeting of branches by interpolation between rows on both sides (leap).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np

from gimcli.continuation.arclength import ArclengthConstants, all_beside
from gimcli.continuation.bifurcation import Crossing
from gimcli.continuation.curve import PositionCurve
from gimcli.mechanism import BoolArray, FloatArray
from gimcli.numerics.along import bisected, lagrange
from gimcli.positions.inputs import BEYOND
from gimcli.positions.position import Row

EPS = float(np.finfo(float).eps)

AT_LIMIT = 8.0 * EPS
"""Distance from a limit, relative to the parameter, below which an input is at the limit."""

NODES = 4
"""Number of positions on each side of the singular one."""

STEPS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)
"""Distances between the positions, in the normal frame, tried in this order."""

FIT, LOOSEST = 1e-13, 1e-11
"""Error of the polynomial halfway between the outermost positions: below FIT no other distance is tried; above LOOSEST
the arc is rejected (LOOSEST allows for greater rounding errors where many branches meet)."""

CORRECTIONS = ArclengthConstants(corrections=12, rounding=1e-11, pull=0.2, bend=math.acos(0.9))


@dataclass(frozen=True)
class ArcPassage:
    """A motion along an arc, with the increasing coordinate s = sense * parameter / span (as on a leg of the laws).

    The arc has positions at distances from the singular one along its unit tangent. "Outwards" is the sense of the
    parameter towards a limit. At a limit the motion is on one side of the arc. assembled: returns the row of the plan
    at a position and coordinate, or None if the plan cannot assemble it.
    """

    curve: PositionCurve = field(repr=False)
    distances: FloatArray = field(repr=False)  # (2 NODES + 1,)
    p: FloatArray = field(repr=False)  # (n + 1, 2 NODES + 1)
    met: Crossing | None  # the meeting of branches there; None: the parameter reverses there
    sense: float = 1.0
    assembled: Callable[[FloatArray, float], Row | None] = field(repr=False, default=lambda p, at: None)
    side: float = 1.0  # of a limit: + along the tangent

    @property
    def limit(self) -> bool:
        """Whether the parameter reverses at the singular position."""
        return self.met is None

    @property
    def q(self) -> float:
        """The parameter of the singular position."""
        return float(self.p[-1, NODES])

    @property
    def inwards(self) -> bool:
        """Whether the motion approaches a limit."""
        return self.limit and self.outwards(self.side) == self.sense

    @property
    def centre(self) -> float:
        """The coordinate s of the singular position."""
        return self._place(self.q)

    @property
    def ends(self) -> tuple[float, float]:
        """The first and the last coordinate of the arc."""
        low, high = sorted((self._outer(-1.0), self._outer(1.0)))
        if not self.limit:
            return low, high
        outer, room = self._outer(self.side), BEYOND * max(1.0, abs(self.centre))
        return (outer, self.centre + room) if self.inwards else (self.centre - room, outer)

    @property
    def exit(self) -> Row | None:
        """The row of the plan at the last coordinate; None if the motion approaches a limit."""
        if self.inwards:
            return None
        ahead = self.side if self.limit else math.copysign(1.0, self._outer(1.0) - self._outer(-1.0))
        return self.assembled(self.end(ahead), self._outer(ahead))

    def position(self, distance: float) -> FloatArray:
        """Return the position and parameter (n + 1,) at a distance."""
        return np.asarray(self.p @ lagrange(self.distances.tolist(), distance))

    def end(self, side: float) -> FloatArray:
        """Return the last position and parameter (n + 1,) on a side (1 or -1) of the arc."""
        return np.asarray(self.p[:, -1 if side > 0.0 else 0])

    def outwards(self, side: float) -> float:
        """Return the sense of the parameter, 1 or -1, towards the limit on a side of the arc."""
        return math.copysign(1.0, self.q - float(self.end(side)[-1]))

    def distance(self, q: float, side: float) -> float:
        """Return the distance at which the parameter is q, on one side of a limit (+ along the tangent)."""
        nonzero = self.distances[self.distances != 0.0]
        rise = np.delete(self.p[-1], NODES) - self.q
        if self.limit and self.outwards(side) * (q - self.q) >= -AT_LIMIT * max(1.0, abs(q)):
            return 0.0
        power = 2 if self.limit else 1
        slopes = (rise / nonzero**power).tolist()  # q - q0 = d^power slope(d)
        d = last = 0.0
        for _ in range(CORRECTIONS.corrections):
            weights = lagrange(nonzero.tolist(), d)
            part = (q - self.q) / sum(w * v for w, v in zip(weights, slopes, strict=True))
            d = side * math.sqrt(max(0.0, part)) if self.limit else part
            if abs(d - last) <= EPS * abs(d):
                break
            last = d
        return float(d)

    def error(self, distance: float) -> float:
        """Return the error of the position at a distance that is caused by rounding of the parameter."""
        if not self.limit or not distance:
            return 0.0
        slope = abs(float(self.position(distance)[-1]) - self.q) * 2.0 / abs(distance)
        return 2.0 * EPS * max(1.0, abs(self.q)) / max(slope, EPS)

    def at(self, time: float) -> Row:
        """Return the row at a coordinate."""
        distance = self.distance(self.sense * time * self.curve.span, self.side)
        z = self.curve.nodes(self.position(distance))
        return Row(time, z.real.copy(), z.imag.copy(), np.empty(0), self.error(distance))

    def mirrored(self) -> ArcPassage:
        """Return the motion in the opposite direction, with coordinates of the opposite sign."""
        return replace(self, sense=-self.sense)

    def other_side(self) -> ArcPassage:
        """Return the motion on the other side of a limit, with the input reversed."""
        return replace(self, sense=-self.sense, side=-self.side)

    def shifted(self, change: float) -> ArcPassage:
        """Return the same motion with the parameter increased by whole turns."""
        p = self.p.copy()
        p[-1] += change
        return replace(self, p=p)

    def _outer(self, side: float) -> float:
        return self._place(float(self.end(side)[-1]))

    def _place(self, q: float) -> float:
        return self.sense * q / self.curve.span


def make_arc(
    curve: PositionCurve, p: FloatArray, tangent: FloatArray, met: Crossing | None = None
) -> ArcPassage | None:
    """Return the arc through a singular position p (n + 1,) along a unit tangent (n + 1,); None if none is accurate.

    met: the meeting of branches at p; None if p is a limit.
    """
    best, least = None, LOOSEST
    for step in STEPS:
        arc = _tried(curve, p, tangent, met, step)
        if arc is None:
            continue
        halfway = step * (NODES - 0.5)
        checks, good = _beside(curve, p, tangent, np.array([-halfway, halfway]))
        gaps = [
            float(np.linalg.norm(one - arc.position(d))) for d, one in zip((-halfway, halfway), checks, strict=True)
        ]
        miss = max(gaps) if good.all() else math.inf
        if miss < least:
            best, least = arc, miss
        if miss <= FIT:
            break
    return best


def _tried(
    curve: PositionCurve, p: FloatArray, tangent: FloatArray, met: Crossing | None, step: float
) -> ArcPassage | None:
    """Return the arc with a distance `step`; None if it leaves the curve."""
    distances = step * np.arange(-NODES, NODES + 1.0)
    found, good = _beside(curve, p, tangent, distances)
    found[NODES], good[NODES] = p, True
    return ArcPassage(curve, distances, found.T, met) if good.all() else None


def _beside(
    curve: PositionCurve, p: FloatArray, tangent: FloatArray, distances: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return positions (rows, n + 1) at distances along the tangent of a singular one, and whether they are near."""
    ahead = np.tile(tangent, (len(distances), 1))
    found, _, good = all_beside(curve, ahead, p + distances[:, None] * ahead, distances, CORRECTIONS)
    return found, good


BEFORE = 4
"""Number of rows on each side of the meeting."""


@dataclass(frozen=True)
class Leap:
    """An interpolation polynomial through rows on both sides of a meeting of branches; used like an `ArcPassage`."""

    centre: float
    rows: list[Row]
    limit: Literal[False] = False
    inwards: Literal[False] = False
    met = None

    @property
    def ends(self) -> tuple[float, float]:
        """The first and the last time of the interval."""
        return self.rows[0].time, self.rows[-1].time

    @property
    def exit(self) -> Row:
        """The last row."""
        return self.rows[-1]

    def at(self, time: float) -> Row:
        """Return the interpolated position."""
        return extrapolated(self.rows, time)

    def mirrored(self) -> Leap:
        """Return the same passage in the opposite direction, with times of the opposite sign."""
        return Leap(-self.centre, [Row(-row.time, row.x, row.y, row.g, row.error) for row in reversed(self.rows)])

    def centred(self) -> Leap:
        """Return the same passage with its centre where a measure changes its sign, if one does."""
        low, high = self.rows[BEFORE - 1 : BEFORE + 1]
        flips = np.flatnonzero(low.g * high.g < 0.0)
        if not len(flips):
            return self
        k = flips[0]
        return Leap(bisected(lambda time: not self.at(time).g[k] * low.g[k] > 0.0, low.time, high.time)[1], self.rows)


Gap: TypeAlias = ArcPassage | Leap
"""An interval around a singular position that a motion passes without solving its rows."""


def extrapolated(rows: list[Row], time: float) -> Row:
    """Return the value at a time of the polynomial through some rows."""
    weights = lagrange([row.time for row in rows], time)
    x, y, g = (np.asarray(sum(w * getattr(row, part) for w, row in zip(weights, rows, strict=True))) for part in "xyg")
    return Row(time, x, y, g)
