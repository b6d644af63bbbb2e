"""All roots of one coupled group, and the level of proof that no root is missing.

The pencil is tried first if the topology has one, then paths from generic linkages, until as many different roots are
proved as the topology has. If that number is unknown, intervals prove the real roots first. For special dimensions
with fewer roots the paths show what happens to the others: they go to infinity or coincide in a multiple root. The
proof depends only on the count and the certificates.

The two configurations of a dyad in closed form, for many dyads at once.

RRR: C0 + C1 theta_1 + C2 theta_2 = 0, a triangle; RRP: |C0 + U s| = |C1|; RPR: |C1 + U s| = |C0|; PRP: linear.
The roots are complex if the dyad cannot be assembled.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gimcli.assemblies.certificate import Proven, distances, distinct, mirror_distance, prove
from gimcli.assemblies.constants import SEARCH
from gimcli.assemblies.loops import GROUND, Coefficients, LoopFamily
from gimcli.assemblies.root_paths import Tracked, candidates, corrected, pencil_of, track
from gimcli.assemblies.start_cache import known_count, known_start
from gimcli.connected import unlike
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray
from gimcli.progress import Progress, no_progress, spend

REACHED, REALS, AGREED, OPEN = 1, 2, 3, 4
"""Levels: all complex roots found; the real roots proved complete; two searches agree; undecided."""


@dataclass(frozen=True)
class Roots:
    """The proved roots without duplicates, and the results for the others."""

    proven: Proven
    count: int | None  # roots of a generic member; None if the count takes too long
    level: int  # REACHED, REALS, AGREED or OPEN
    doubtful: ComplexArray  # (candidates, n + q) multiple roots, or points of a curve of roots
    infinite: int = 0  # number of roots at infinity

    @property
    def missing(self) -> int:
        """Number of roots of the generic count that are neither proved nor at infinity."""
        return max(0, (self.count or len(self.proven.w)) - len(self.proven.w) - self.infinite)


def all_roots(
    family: LoopFamily, H: ComplexArray, progress: Progress = no_progress, near: Roots | None = None
) -> Roots:
    """Return the roots of a group's loops, those of real coefficients H (2, L, 1 + n + q).

    `progress` is called with the numbers of known and of all roots while a generic linkage is searched. `near` are the
    roots of almost the same loops: if only intervals proved those, intervals are tried before the paths.
    """
    count = known_count(family)
    proven = _by_pencil(family, H)
    if count is not None and _whole(proven, count):
        return Roots(proven, count, REACHED, proven.w[:0])
    if count is None or (near is not None and near.level == REALS):  # paths take longest and prove nothing here
        real = _by_intervals(family, H, Roots(proven, count, OPEN, proven.w[:0]))
        if real.level == REALS:
            return real
    found = _by_paths(family, H, count, proven, progress)
    return found if found.level == REACHED else _by_intervals(family, H, found)


def _whole(proven: Proven, count: int) -> bool:
    """Return whether all roots are found and each is proved real or not real."""
    return len(proven.w) == count and bool((proven.real | proven.complex).all())


def _by_pencil(family: LoopFamily, H: ComplexArray) -> Proven:
    pencil = pencil_of(family)
    w = np.zeros((0, family.angles + family.slides), dtype=complex)
    if pencil is not None:
        found = candidates(pencil, H)
        w = corrected(family, H, found, SEARCH.polish)
        w = w[np.isfinite(w).all(axis=1) & (np.max(np.abs(w - found), axis=1, initial=0.0) < SEARCH.moved)]
    return _sound(family, H, w)


def _sound(family: LoopFamily, H: ComplexArray, w: ComplexArray) -> Proven:
    """Return the different proved roots among some points."""
    w = w[np.isfinite(w).all(axis=1) & (np.abs(w[:, : family.angles].real) < SEARCH.tracking.far).all(axis=1)]
    proven = prove(family, H, w)
    return distinct(family, proven.take(proven.residual < SEARCH.residual))


def _by_paths(family: LoopFamily, H: ComplexArray, count: int | None, proven: Proven, progress: Progress) -> Roots:
    """Return the union of the roots proved by paths from independent generic linkages."""
    ends: list[_Ends] = []
    for seed in range(SEARCH.starts):
        start = known_start(family, seed, progress)
        found = _tracked(family, start.H, H, start.w)
        ends.append(found)
        proven = distinct(family, proven.joined(found.proven))
        if count is not None and _whole(proven, count):
            return Roots(proven, count, REACHED, proven.w[:0])
        if spend() or (len(ends) > 1 and _same(ends[-1], ends[-2])):
            break
    last = min(ends, key=lambda e: (len(e.doubtful), e.lost, -len(e.proven.w)))
    agreed = any(_same(a, b) for a, b in pairwise(ends))
    decided = bool((proven.real | proven.complex).all())
    settled = agreed and decided and len(last.doubtful) == 0 and last.lost == 0 and len(last.proven.w) == len(proven.w)
    if family.rails_shared and settled:
        count = None
    settled &= count is None or len(proven.w) + last.infinite == count
    return Roots(proven, count, AGREED if settled else OPEN, last.doubtful, last.infinite)


def _by_intervals(family: LoopFamily, H: ComplexArray, found: Roots) -> Roots:
    """Return the roots, the real ones proved complete if intervals succeed; they cannot decide multiple roots."""
    from gimcli.assemblies.intervals import IntervalConstants, real_roots

    half, n = H[0], family.angles
    if (mirror_distance(family, found.doubtful) < SEARCH.real).any():
        return found
    loops = Coefficients(half[:, 0], half[:, 1 : 1 + n], half[:, 1 + n :], family.rail)
    boxes = real_roots(loops, constants=IntervalConstants(boxes=SEARCH.boxes))
    proved = boxes.complete and boxes.everywhere
    if len(boxes.roots) == 0:
        return replace(found, level=REALS) if proved and not found.proven.real.any() else found
    w = np.concatenate([1j * boxes.roots[:, :n], boxes.roots[:, n:].astype(complex)], axis=1)
    proven = distinct(family, found.proven.joined(_sound(family, H, w)))
    whole = proved and int(proven.real.sum()) == len(boxes.roots)
    return replace(found, proven=proven, level=REALS if whole else found.level)


@dataclass(frozen=True)
class _Ends:
    """The ends of the paths of one start."""

    proven: Proven
    doubtful: ComplexArray
    infinite: int  # paths that go to infinity
    lost: int  # paths that stopped for an unknown reason


def _same(a: _Ends, b: _Ends) -> bool:
    return len(a.proven.w) == len(b.proven.w) and a.infinite == b.infinite and a.lost == b.lost


def _tracked(family: LoopFamily, start: ComplexArray, H: ComplexArray, w: ComplexArray) -> _Ends:
    """Follow all roots of a start; repeat coinciding and lost paths with smaller steps."""
    tracking = SEARCH.tracking
    done = track(family, start, H, w, tracking)
    point = corrected(family, H, done.w, SEARCH.polish // 2)
    for tighter in SEARCH.tighter:
        again = ~_alone(family, H, done, point)
        if not again.any():
            break
        finer = track(family, start, H, w[again], replace(tracking, correction=tracking.correction * tighter))
        for name in ("w", "arrived", "time", "rate"):
            getattr(done, name)[again] = getattr(finer, name)
        point[again] = corrected(family, H, finer.w, SEARCH.polish // 2)
    return _judged(family, H, done, point, _alone(family, H, done, point))


def _alone(family: LoopFamily, H: ComplexArray, done: Tracked, point: ComplexArray) -> BoolArray:
    """Return which paths arrived at a proved root at which no other path arrived."""
    safe = np.where(np.isfinite(point).all(axis=1, keepdims=True), point, 0.0)
    proven = prove(family, H, safe)
    good = np.asarray(done.arrived & np.isfinite(point).all(axis=1), dtype=bool)
    good = np.asarray(good & proven.sure & (proven.residual < SEARCH.residual), dtype=bool)
    gap = distances(family, safe, safe)
    np.fill_diagonal(gap, np.inf)
    close = (gap <= SEARCH.near) & good[:, None] & good[None, :]
    close &= gap <= proven.small[:, None] + proven.small[None, :]
    return np.asarray(good & ~close.any(axis=1))


def _judged(family: LoopFamily, H: ComplexArray, done: Tracked, point: ComplexArray, alone: BoolArray) -> _Ends:
    """Classify paths: roots at infinity, multiple roots, and lost paths."""
    proven = _sound(family, H, point[np.isfinite(point).all(axis=1) & (done.arrived | alone)])
    left = np.flatnonzero(~alone)
    infinite = _diverging(family, done)[left]
    rest = left[~infinite]
    near = point[rest]
    with np.errstate(all="ignore"):
        near = near[np.isfinite(near).all(axis=1)]
        near = near[prove(family, H, near).residual < SEARCH.residual] if len(near) else near
    if len(near) and len(proven.w):  # paths that coincide with a proved root
        near = near[np.min(distances(family, near, proven.w), axis=1) > SEARCH.near]
    gap = distances(family, near, near)
    doubtful = near[unlike(range(len(near)), lambda k, j: bool(gap[k, j] < SEARCH.near))]  # one of each cluster
    return _Ends(proven, doubtful, int(infinite.sum()), len(rest) - len(near))


def _diverging(family: LoopFamily, done: Tracked) -> BoolArray:
    """Return which paths go to infinity: with t = 1 - e^-tau log theta and log s become linear in tau."""
    n = family.angles
    with np.errstate(all="ignore"):
        slope = np.abs(done.rate * (1.0 - done.time)[:, None])
        slope[:, n:] /= np.maximum(np.abs(done.w[:, n:]), 1.0)
        far = np.max(np.abs(done.w[:, :n].real), axis=1, initial=0.0) > SEARCH.tracking.far
        straight = np.max(np.where(np.isfinite(slope), slope, 0.0), axis=1, initial=0.0) > SEARCH.slope
    late = done.time > SEARCH.late
    return np.asarray(~done.arrived & np.asarray(far | (straight & late)))


MARGIN = 1e-12
"""Gap of a triangle, relative to its sides, above which it has no real configuration; smaller gaps are rounding."""

CLOSED = 1
"""Newton corrections after a closed form; one removes the error of cancellation."""


@dataclass(frozen=True)
class DyadRoots:
    """Both roots of some dyads, in the order of signs + and -; a PRP has one root."""

    proven: Proven  # (dyads roots) rows, grouped by dyad
    each: int  # number of roots of a dyad
    apart: BoolArray  # (dyads,) whether it cannot be assembled, by more than rounding
    free: BoolArray  # (dyads,) whether it is folded and can rotate freely


def dyad_roots(family: LoopFamily, H: ComplexArray) -> DyadRoots:
    """Return the roots of dyads H (dyads, 2, 1, 1 + n + q)."""
    c = H[:, 0, 0]
    with np.errstate(all="ignore"):
        if family.angles == 0:
            w, gap, size = _double_slide(c, H[:, 1, 0]), np.full(len(c), np.inf), np.ones(len(c))
            free = np.zeros(len(c), dtype=bool)
        else:
            w, gap, size, free = _triangle(c) if family.angles == 2 else _slide(c, int(family.rail[0]))
        each = w.shape[1]
        rows, repeated = w.reshape(len(c) * each, w.shape[2]), np.repeat(H, each, axis=0)
        better = corrected(family, repeated, rows, CLOSED)
        rows = np.where((np.abs(better - rows) < MARGIN**0.5).all(axis=1)[:, None], better, rows)
    return DyadRoots(prove(family, repeated, rows), each, gap < -MARGIN * size, free)


def _triangle(c: ComplexArray) -> tuple[ComplexArray, FloatArray, FloatArray, BoolArray]:
    """Return the roots of triangles (dyads, 2, 2), their gaps, their sizes, and which of them can rotate freely."""
    a, b, d = np.abs(c[:, 0]), np.abs(c[:, 1]), np.abs(c[:, 2])
    size = a + b + d
    gap = np.minimum(np.minimum(a + b - d, b + d - a), d + a - b)
    area = _root(size * (a + b - d) * (b + d - a) * (d + a - b))  # 4 times the triangle's
    middle = (d - b) * (d + b) - a * a
    sign = np.array([1.0, -1.0])
    first = (middle[:, None] + 1j * sign * area[:, None]) / (2.0 * c[:, 1] * c[:, 0].conj())[:, None]
    second = -(c[:, :1] + c[:, 1:2] * first) / c[:, 2:]
    real = (gap >= 0.0)[:, None]
    w = np.stack([_log(first, real), _log(second, real)], axis=2)
    return w, gap, size, a < MARGIN * size


def _slide(c: ComplexArray, rail: int) -> tuple[ComplexArray, FloatArray, FloatArray, BoolArray]:
    """Return the roots of dyads with one slide (dyads, 2, 2), and the other values as for triangles."""
    carrier, arm = (c[:, 0], c[:, 1]) if rail == GROUND else (c[:, 1], c[:, 0])
    u = c[:, 2]
    seen = carrier * u.conj() / np.abs(u)
    reach = np.abs(arm)
    gap = reach - np.abs(seen.imag)
    half = _root((reach - seen.imag) * (reach + seen.imag))
    s = (-seen.real[:, None] + np.array([1.0, -1.0]) * half[:, None]) / np.abs(u)[:, None]
    line = carrier[:, None] + u[:, None] * s
    turn = -line / arm[:, None] if rail == GROUND else -arm[:, None] / line
    size = np.abs(carrier) + reach + np.finfo(float).tiny
    w = np.stack([_log(turn, (gap >= 0.0)[:, None]), s], axis=2)
    free = reach < MARGIN * size
    return w, gap, size, free & (rail != GROUND) & (np.abs(seen.imag) < MARGIN * size)


def _double_slide(f: ComplexArray, g: ComplexArray) -> ComplexArray:
    """Return the root of dyads with two slides (dyads, 1, 2)."""
    determinant = f[:, 1] * g[:, 2] - f[:, 2] * g[:, 1]
    first = (f[:, 2] * g[:, 0] - f[:, 0] * g[:, 2]) / determinant
    second = (f[:, 0] * g[:, 1] - f[:, 1] * g[:, 0]) / determinant
    return np.stack([first, second], axis=1)[:, None, :]


def _root(x: FloatArray) -> ComplexArray:
    return np.asarray(np.sqrt(x.astype(complex)))


def _log(z: ComplexArray, real: BoolArray) -> ComplexArray:
    """Return the logarithm, exactly imaginary for real roots."""
    w = np.log(z)
    return np.where(real, 1j * w.imag, w)
