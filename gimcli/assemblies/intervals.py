"""Interval branch and prune: all real solutions of planar loops, proved to be all.

Boxes that cover every angle and the slides' reach are contracted by scalar equations, then, when narrow, by
Krawczyk's image, and halved. A box ends empty, inside a box that provably holds exactly one solution, or, when it
is too narrow to go on or a limit is met, undecided. Widest boxes come first, so that a continuum of solutions is
covered evenly and does not hide the isolated ones. Nothing is dropped without a proof for the coefficients as
rounded to double: rounding is bounded by eps terms (see the parts), not by directed rounding.
Source: Merlet, Solving the forward kinematics of a Gough-type parallel manipulator with interval analysis, 2004.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

from gimcli.assemblies.contraction import contract
from gimcli.assemblies.cosine_rows import EPS, CosineRows, RowConstants, cosine_rows
from gimcli.assemblies.isolated_roots import BoolArray, IsolatedRoots, centred
from gimcli.assemblies.krawczyk import Coefficients, image, local, narrow
from gimcli.assemblies.slide_bounds import proved_reach
from gimcli.mechanism import ComplexArray, FloatArray, IntArray


@dataclass(frozen=True)
class IntervalConstants:
    """What the user decides: how long to search, and how close two solutions may be."""

    seconds: float = 60.0
    boxes: int = 2_000_000  # at the most, worked on
    narrowest: float = 1e-8  # rad, and of a slide's unit length: a box no wider is undecided
    batch: int = 20_000
    unbounded: float = 100.0  # times its unit length: reach of a slide for which no bound follows from the lengths


@dataclass(frozen=True)
class SearchConstants:
    """What the algorithm fixes."""

    seam: float = 0.7  # rad: where the circle is cut open, off the axes that drawn positions like
    cut: float = 0.487  # of the widest side: off the middle, where solutions of symmetric mechanisms lie
    narrow: float = 1.5  # rad: boxes no wider are contracted by Krawczyk's image
    gain: float = 0.6  # a box whose widest side shrank to this is contracted again before it is cut
    inflation: float = 1.5  # of a box, so that a solution on its border is inside
    floor: float = 4.0  # times the rounding of the loops: no box is tested smaller
    sweeps: int = 2


CONSTANTS = SearchConstants()


@dataclass(frozen=True, eq=False)
class Enclosures:
    """Real solutions, each proved to exist, and the boxes about which nothing is proved.

    Angles [rad] in [-pi, pi] come before slides; `unknowns` columns each.
    """

    roots: FloatArray  # (R, n + q)
    radius: FloatArray  # (R, n + q) half-widths that hold the solution
    unique: FloatArray  # (R, n + q) half-widths that hold no other solution
    undecided: FloatArray = field(repr=False)  # (K, 2, n + q) bounds of boxes; the same solution may be in several
    boxes: int  # worked on
    seconds: float
    limit: str  # "" or what ended the search: "seconds", "boxes"
    angles: int  # n
    reach: FloatArray  # (q,) searched
    everywhere: bool  # no slide can leave the reach searched, whatever the angles

    @property
    def complete(self) -> bool:
        """Whether there provably is no other real solution within reach."""
        return len(self.undecided) == 0


def real_roots(
    C0: ComplexArray, C: ComplexArray, U: ComplexArray, rail: IntArray, reach: FloatArray | float | None = None,
    constants: IntervalConstants | None = None,
) -> Enclosures:  # fmt: skip
    """Return all real solutions of C0 + Σ C_c θ_c + Σ U_q s_q θ_rail(q) = 0, |θ| = 1, |s| <= reach.

    Shapes (L,), (L, n), (L, q), (q,) with n + q = 2 L; `rail` -1 is the frame. `reach` is one length or one for each
    slide; None, or what cannot be reached anyway, becomes the bound that follows from the lengths, where there is
    one. Raises ValueError where shapes do not fit or a number is not finite.
    """
    loops, constants = Coefficients(*_checked(C0, C, U, rail)), constants or IntervalConstants()
    asked = np.broadcast_to(np.inf if reach is None else np.asarray(reach, dtype=float), loops.rail.shape)
    if not (asked > 0.0).all() or (reach is not None and not np.isfinite(asked).all()):
        raise ValueError(f"reach {asked}: give positive finite lengths")
    proved = proved_reach(loops)
    searched = np.minimum(asked, proved)
    searched = np.where(np.isfinite(searched), searched, constants.unbounded * units(loops))
    return _BoxSearch(loops, searched, bool((searched >= proved).all()), constants).run()


def units(loops: Coefficients) -> FloatArray:
    """Return the length that makes as much of a loop as one radian, for every slide (q,)."""
    size = np.abs(np.column_stack([loops.C0, loops.C])).max(initial=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = size / np.abs(loops.U).max(axis=0, initial=0.0)
    return np.asarray(np.where(np.isfinite(unit) & (unit > 0.0), unit, 1.0))


def _checked(
    C0: ComplexArray, C: ComplexArray, U: ComplexArray, rail: IntArray
) -> tuple[ComplexArray, ComplexArray, ComplexArray, IntArray]:
    """Return the arrays in their types; U and rail may be empty lists."""
    C0, C, rail = np.asarray(C0, complex), np.asarray(C, complex), np.asarray(rail, dtype=np.int64)
    U = np.asarray(U, complex).reshape(len(C0), len(rail))
    if C.shape[1] + len(rail) != 2 * len(C0) or len(C) != len(C0):
        raise ValueError(f"{len(C0)} loops for {C.shape[1]} angles and {len(rail)} slides: twice the loops are needed")
    if not all(np.isfinite(a).all() for a in (C0, C, U)) or not ((rail >= -1) & (rail < C.shape[1])).all():
        raise ValueError("coefficients must be finite and rails -1 or an angle's column")
    return C0, C, U, rail


class _BoxSearch:
    """The boxes still to be worked on and what was found; boxes are columns (d, B)."""

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
        """Work until nothing is waiting or a limit is met."""
        begin, limit = time.monotonic(), ""
        while self.waiting and not limit:
            low, high = self._next()
            self.boxes += low.shape[1]
            self._work(low, high)
            if self.waiting and self.boxes >= self.constants.boxes:
                limit = "boxes"
            elif self.waiting and time.monotonic() - begin >= self.constants.seconds:
                limit = "seconds"
        return self._result(time.monotonic() - begin, limit)

    def _next(self) -> tuple[FloatArray, FloatArray]:
        """Take up to a batch of the boxes that have waited longest."""
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
        """Contract boxes, settle those that can be, and let the rest wait, cut where they hardly shrank."""
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
        """Return angles as they are and slides on a scale on which far ones are wider: asinh of s over its unit."""
        return np.concatenate([x[: self.n], np.arcsinh(x[self.n :] / self.unit[self.n :, None])])

    def _krawczyk(self, low: FloatArray, high: FloatArray, before: FloatArray) -> tuple[FloatArray, ...]:
        """Settle or contract the narrow boxes; drop the empty ones and those inside a settled box."""
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
        """Cut boxes across their widest side and let both parts wait."""
        every, start = np.arange(low.shape[1]), self._even(low)
        span = self._even(high) - start
        side = np.argmax(span, axis=0)
        at = (start + CONSTANTS.cut * span)[side, every]
        at = np.where(side < self.n, at, self.unit[side] * np.sinh(np.where(side < self.n, 0.0, at)))
        at = np.clip(at, low[side, every], high[side, every])
        first, second = high.copy(), low.copy()
        first[side, every] = second[side, every] = at
        self._wait(np.hstack([low, second]), np.hstack([first, high]))

    def _result(self, seconds: float, limit: str) -> Enclosures:
        """Put what was found and what is left together."""
        left = [*self.left, *self.waiting]
        undecided = np.stack([np.hstack([b[i] for b in left]).T for i in (0, 1)], axis=1) if left else None
        if undecided is None:
            undecided = np.zeros((0, 2, len(self.unit)))
        found = self.found.inside(self.reach)
        return Enclosures(*found, undecided, self.boxes, seconds, limit, self.n, self.reach, self.everywhere)


def _keep(mask: BoolArray, *arrays: FloatArray) -> tuple[FloatArray, ...]:
    """Return the boxes of a mask."""
    return arrays if mask.all() else tuple(a[..., mask] for a in arrays)
