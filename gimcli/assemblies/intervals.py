"""Interval branch and prune: all real solutions of planar loops, with a proof of completeness.

The travels of slides are bounded by the lengths alone: a combination l of the loops with l . U_q = 1 that eliminates
all other slides gives |s_q| <= |l . C0| + Σ |l . C_c| for all angles. For a rail on the frame real and imaginary parts
can be combined separately, so that one loop bounds two slides on different rails of the frame. There is no bound if
rails can become parallel.

Boxes that cover all angles and the reach of the slides are contracted by scalar equations, narrow boxes also by the
Krawczyk operator, and bisected. A box is finally empty, inside a box with exactly one solution, or undecided (too
narrow, or a limit is reached). The boxes that have waited longest are processed first, so that a continuum of
solutions is covered evenly and isolated solutions are still found. Every removal is proved for the coefficients
rounded to doubles: rounding is bounded by terms of eps, not by directed rounding.
Source: Merlet, Solving the forward kinematics of a Gough-type parallel manipulator with interval analysis, 2004.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gimcli.assemblies.cosine_rows import EPS, CosineRows, RowConstants, contract, cosine_rows
from gimcli.assemblies.krawczyk import IsolatedRoots, centred, image, local, narrow
from gimcli.assemblies.loops import GROUND, Coefficients
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray
from gimcli.progress import spend


@dataclass(frozen=True)
class ReachConstants:
    """Tolerances of the elimination."""

    leak: float = 1e-9  # largest remaining coefficient of an eliminated slide; its effect is included
    margin: float = 1e-6  # relative margin of a bound, greater than the effects of leaks and rounding


REACH = ReachConstants()


def proved_reach(loops: Coefficients) -> FloatArray:
    """Return a bound of |s| for every slide (q,); infinite if none is known."""
    q = loops.U.shape[1]
    pairs = [_bound(loops, slide) for slide in range(q)]
    bound, leak = np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs]).reshape(q, q)
    with np.errstate(invalid="ignore"):
        leaks = np.where(leak > 0.0, leak * bound, 0.0).sum(axis=1)
    sure = np.isfinite(bound) & (leaks <= 0.5 * REACH.margin * bound) & (leak.sum(axis=1) < REACH.margin)
    size = np.abs(loops.C0).sum() + np.abs(loops.C).sum()
    floor = REACH.margin * size / np.maximum(np.abs(loops.U).max(axis=0, initial=0.0), np.finfo(float).tiny)
    return np.asarray(np.where(sure, bound * (1.0 + REACH.margin) + floor, np.inf))


def _bound(loops: Coefficients, slide: int) -> tuple[float, FloatArray]:
    """Return the bound of one slide, and the remaining coefficients of the other slides in its combination."""
    q = loops.U.shape[1]
    combination = _combination(loops, slide)
    through = combination @ loops.U
    leak = np.where(loops.rail == GROUND, np.abs(through.real), np.abs(through))
    if loops.rail[slide] != GROUND:
        leak = np.abs(through)
    own = abs(through[slide].real if loops.rail[slide] == GROUND else through[slide])
    leak[slide] = 0.0
    size = np.abs(combination) @ np.abs(loops.U)
    if not own > 0.5 or np.any(leak > REACH.leak * np.maximum(size, 1.0)):
        return np.inf, np.zeros(q)
    return float(np.abs(combination @ loops.C0) + np.abs(combination @ loops.C).sum()) / own, leak / own


def _combination(loops: Coefficients, slide: int) -> ComplexArray:
    """Return l (L,) with l . U_slide = 1 and 0 for the others, in the least-squares sense.

    For a rail on the frame only the real part of l . f is used.
    """
    if loops.rail[slide] != GROUND:
        return np.asarray(np.linalg.pinv(loops.U)[slide])
    count = len(loops.C0)
    columns, target = [], []
    for other in range(loops.U.shape[1]):
        turns = (1.0,) if loops.rail[other] == GROUND else (1.0, 1j)
        for turn in turns:
            column = loops.U[:, other] * turn
            columns.append(np.concatenate([column.real, -column.imag]))
            target.append(1.0 if other == slide else 0.0)
    y = np.linalg.pinv(np.array(columns)) @ np.array(target)
    return np.asarray(y[:count] + 1j * y[count:])


BATCH = 300
"""Work of a batch of boxes, in positions of a curve."""


@dataclass(frozen=True)
class IntervalConstants:
    """Limits of the search, chosen by the user."""

    boxes: int = 2_000_000  # largest number of processed boxes
    narrowest: float = 1e-8  # width [rad, unit lengths of a slide] below which a box is undecided
    batch: int = 20_000  # boxes processed in one call
    unbounded: float = 100.0  # reach of a slide in unit lengths if no bound follows from the lengths


@dataclass(frozen=True)
class SearchConstants:
    """Constants of the algorithm."""

    seam: float = 0.7  # [rad] angle at which the circle is cut; solutions are often on the axes
    cut: float = 0.487  # fraction of the widest side; not 0.5, where solutions of symmetric mechanisms are
    narrow: float = 1.5  # rad: width below which boxes are contracted by the Krawczyk operator
    gain: float = 0.6  # a box whose widest side shrinks to this fraction is contracted again before bisection
    inflation: float = 1.5  # factor of a box, so that a solution on its border is inside
    floor: float = 4.0  # least size of a tested box, relative to the rounding of the loops
    sweeps: int = 2  # contractions of a box per call


CONSTANTS = SearchConstants()


@dataclass(frozen=True, eq=False)
class Enclosures:
    """Real solutions, each proved to exist, and undecided boxes.

    The columns are the angles [rad] in [-pi, pi], then the slides.
    """

    roots: FloatArray  # (R, n + q)
    radius: FloatArray  # (R, n + q) half-widths of boxes that contain the solution
    unique: FloatArray  # (R, n + q) half-widths of boxes that contain no other solution
    undecided: FloatArray = field(repr=False)  # (K, 2, n + q) bounds of boxes; the same solution may be in several
    boxes: int  # number of processed boxes
    everywhere: bool  # no slide can leave the searched range, for any angles

    @property
    def complete(self) -> bool:
        """Whether it is proved that there is no other real solution within the reach."""
        return len(self.undecided) == 0


def real_roots(
    loops: Coefficients, reach: FloatArray | float = np.inf, constants: IntervalConstants | None = None
) -> Enclosures:
    """Return all real solutions of loops, with |θ| = 1 and |s| <= reach.

    `reach` is one length, or one for each slide; if it is greater than the bound from the lengths, that bound is used.
    """
    constants, proved = constants or IntervalConstants(), proved_reach(loops)
    searched = np.minimum(reach, proved)
    searched = np.where(np.isfinite(searched), searched, constants.unbounded * units(loops))
    return _BoxSearch(loops, searched, bool((searched >= proved).all()), constants).run()


def units(loops: Coefficients) -> FloatArray:
    """Return for every slide (q,) the unit length, which changes a loop as much as one radian."""
    size = np.abs(np.column_stack([loops.C0, loops.C])).max(initial=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = size / np.abs(loops.U).max(axis=0, initial=0.0)
    return np.asarray(np.where(np.isfinite(unit) & (unit > 0.0), unit, 1.0))


class _BoxSearch:
    """The search: waiting boxes and solutions found; boxes are columns (d, B)."""

    def __init__(self, loops: Coefficients, reach: FloatArray, everywhere: bool, constants: IntervalConstants) -> None:
        self.loops, self.reach, self.everywhere, self.constants = loops, reach, everywhere, constants
        self.n = loops.C.shape[1]
        self.rows: CosineRows = cosine_rows(loops.C0, loops.C, loops.U, loops.rail, reach, RowConstants())
        self.unit = np.concatenate([np.ones(self.n), units(loops)])
        edge = np.concatenate([np.full(self.n, np.pi * (1 + 4 * EPS)), reach])
        shift = np.concatenate([np.full(self.n, CONSTANTS.seam), np.zeros(len(reach))])
        self.waiting = [((shift - edge)[:, None], (shift + edge)[:, None])]
        self.left: list[tuple[FloatArray, FloatArray]] = []
        self.found = IsolatedRoots(loops, self.unit)
        self.boxes = 0

    def run(self) -> Enclosures:
        """Process boxes until none is waiting or a limit is reached; return the solutions and the undecided boxes."""
        while self.waiting:
            low, high = self._next()
            self.boxes += low.shape[1]
            self._work(low, high)
            if self.boxes >= self.constants.boxes or spend(BATCH):
                break
        left = [(np.zeros((len(self.unit), 0)),) * 2, *self.left, *self.waiting]
        undecided = np.stack([np.hstack(bounds).T for bounds in zip(*left, strict=True)], axis=1)
        return Enclosures(*self.found.inside(self.reach), undecided, self.boxes, self.everywhere)

    def _next(self) -> tuple[FloatArray, FloatArray]:
        """Remove a batch of waiting boxes, the oldest first."""
        taken, count = [], 0
        while self.waiting and count < self.constants.batch:
            low, high = self.waiting.pop(0)
            room = self.constants.batch - count
            if low.shape[1] > room:
                self.waiting.insert(0, (low[:, room:], high[:, room:]))
            taken.append((low[:, :room], high[:, :room]))
            count += taken[-1][0].shape[1]
        return np.hstack([t[0] for t in taken]), np.hstack([t[1] for t in taken])

    def _work(self, low: FloatArray, high: FloatArray) -> None:
        """Contract boxes, decide those that can be decided, and queue the others, bisected if they hardly shrank."""
        before = self._widest(low, high)
        for _ in range(CONSTANTS.sweeps):
            low, high = contract(self.rows, low, high)
            low, high, before = _keep(np.all(low <= high, axis=0), low, high, before)
        low, high, before = self._krawczyk(low, high, before)
        widest = self._widest(low, high)
        shrunk = widest <= CONSTANTS.gain * before
        self._wait(low[:, shrunk], high[:, shrunk])
        stuck = ~shrunk & (widest <= self.constants.narrowest)
        if stuck.any():
            self.left.append((low[:, stuck], high[:, stuck]))
        self._cut(low[:, ~shrunk & ~stuck], high[:, ~shrunk & ~stuck])

    def _widest(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the widest side of every box."""
        return np.asarray((self._even(high) - self._even(low)).max(axis=0))

    def _even(self, x: FloatArray) -> FloatArray:
        """Return angles unchanged, and asinh(s / unit) of slides, so that distant boxes are wider."""
        return np.concatenate([x[: self.n], np.arcsinh(x[self.n :] / self.unit[self.n :, None])])

    def _krawczyk(self, low: FloatArray, high: FloatArray, before: FloatArray) -> tuple[FloatArray, ...]:
        """Decide or contract the narrow boxes; remove empty ones and those inside the box of a known solution."""
        small = np.nonzero(self._widest(low, high) <= CONSTANTS.narrow)[0]
        if not len(small):
            return low, high, before
        keep = np.ones(low.shape[1], dtype=bool)
        bounds_low, bounds_high = low[:, small].T, high[:, small].T
        middle, half = centred(bounds_low, bounds_high)
        at = local(self.loops, middle)
        wide = CONSTANTS.inflation * half + CONSTANTS.floor * at.error
        unique = np.all(image(at, wide) < wide, axis=1)
        settled = np.zeros(len(small), dtype=bool)
        settled[unique] = self.found.add(middle[unique], wide[unique])
        new_low, new_high = narrow(at, middle, half)
        low[:, small], high[:, small] = new_low.T, new_high.T
        keep[small] = ~settled & np.all(new_low <= new_high, axis=1) & ~self.found.holds(bounds_low, bounds_high)
        return _keep(keep, low, high, before)

    def _wait(self, low: FloatArray, high: FloatArray) -> None:
        if low.shape[1]:
            self.waiting.append((low, high))

    def _cut(self, low: FloatArray, high: FloatArray) -> None:
        """Bisect boxes across their widest side and queue both parts."""
        every, start = np.arange(low.shape[1]), self._even(low)
        span = self._even(high) - start
        side = np.argmax(span, axis=0)
        at = (start + CONSTANTS.cut * span)[side, every]
        at = np.where(side < self.n, at, self.unit[side] * np.sinh(np.where(side < self.n, 0.0, at)))
        at = np.clip(at, low[side, every], high[side, every])
        first, second = high.copy(), low.copy()
        first[side, every] = second[side, every] = at
        self._wait(np.hstack([low, second]), np.hstack([first, high]))


def _keep(mask: BoolArray, *arrays: FloatArray) -> tuple[FloatArray, ...]:
    """Return the boxes that a mask selects."""
    return arrays if mask.all() else tuple(a[..., mask] for a in arrays)
