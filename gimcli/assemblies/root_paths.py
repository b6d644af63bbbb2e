"""Paths of roots from one linkage of a family to another, all paths in parallel.

The coefficients vary linearly in t; a predictor of fourth order (Runge-Kutta) and two Newton-Raphson corrections
follow dw/dt = -J^-1 dH/dt, each path with its own step. Source: A. Sommese and C. Wampler,
The numerical solution of systems of polynomials, 2005.

A generic linkage of a topology with all its complex roots, from which paths to other linkages start.

A random point and random parameters, projected so that the loops close, give one root. The others are found along
triangles in the space of parameters (monodromy), which permute the roots transitively: the pairs of linkage and root
are a vector bundle over the roots. Source: T. Duff et al., Solving polynomial systems via homotopy continuation and
monodromy, IMA J. Numer. Anal. 39 (2019).

All roots of a group by one generalised eigenvalue problem.

One angle x = theta_h is hidden. The unknown vector contains theta^-T and s_q theta^-T for sets T of the other
angles in a window of sizes. theta^-S times a combination of the loops that eliminates the angles outside S (for f)
or inside S (for g) is square-free and linear in x, so that (M0 + x M1) v = 0. Null vectors replace the minors of
Dixon's determinant, which are zero for sparse topologies. Source: C. Wampler, Solving the kinematics
of planar mechanisms by Dixon determinant and a complex-plane formulation, J. Mech. Des. 123 (2001).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from itertools import combinations, pairwise

import numpy as np

from gimcli.assemblies.certificate import distinct, each_of, prove
from gimcli.assemblies.constants import SEARCH, TrackingConstants
from gimcli.assemblies.loops import GROUND, LoopFamily, factors, values, values_and_jacobian
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray
from gimcli.progress import Progress, no_progress, spend

TOGETHER = 20
"""Number of paths whose steps take as long as a position of a curve."""


@dataclass(frozen=True)
class Tracked:
    """The ends of paths."""

    w: ComplexArray  # (roots, n + q) at t = 1, or where the path stopped
    arrived: BoolArray  # (roots,) whether t = 1 was reached
    time: FloatArray  # (roots,) t in 0..1 that was reached
    rate: ComplexArray  # (roots, n + q) dw/dt at the last step


def solve_each(J: ComplexArray, right: ComplexArray) -> ComplexArray:
    """Return J^-1 right for stacks (roots, m, m) and (roots, m); NaN if J is exactly singular."""
    return each_of(np.linalg.solve, right[..., None], J, right[..., None])[..., 0]


def corrected(family: LoopFamily, H: ComplexArray, w: ComplexArray, times: int) -> ComplexArray:
    """Return points after some Newton-Raphson corrections; one H for all, or one for each point."""
    with np.errstate(all="ignore"):
        for _ in range(times):
            value, J = values_and_jacobian(family, H, w)
            w = w - solve_each(J, value)
    return w


def track(
    family: LoopFamily, start: ComplexArray, end: ComplexArray, w: ComplexArray, constants: TrackingConstants
) -> Tracked:
    """Follow roots w (roots, n + q) of coefficients `start` to those of `end`."""
    count = len(w)
    w, change = w.copy(), end - start
    t, h = np.zeros(count), np.full(count, constants.first)
    rate = np.zeros_like(w)
    steps = np.zeros(count, dtype=int)
    active = np.arange(count)
    with np.errstate(all="ignore"):
        while len(active) and not spend(1 + len(active) // TOGETHER):
            now, step = w[active], np.minimum(h[active], 1.0 - t[active])
            guess, rate[active] = _predicted(family, start, change, now, t[active], step)
            there = t[active] + step
            accepted, moved, next_w = _corrected(family, start, change, guess, there, constants)
            factor = constants.safety * (constants.aim * constants.correction / np.maximum(moved, 1e-300)) ** 0.2
            factor = np.clip(np.where(np.isfinite(factor), factor, 0.0), constants.slowest, constants.fastest)
            h[active] = step * np.where(accepted, factor, np.minimum(factor, constants.slowest))
            steps[active] += 1
            good = active[accepted]
            w[good], t[good] = next_w[accepted], there[accepted]
            far = np.max(np.abs(w[active, : family.angles].real), axis=1, initial=0.0) > constants.far
            stuck = (h[active] < constants.shortest) | (steps[active] > constants.most) | far
            active = active[~((t[active] >= 1.0) | stuck)]
    return Tracked(w, t >= 1.0, t, rate)


def _at(start: ComplexArray, change: ComplexArray, t: FloatArray) -> ComplexArray:
    return np.asarray(start + t[:, None, None, None] * change)


def _slope(
    family: LoopFamily, start: ComplexArray, change: ComplexArray, w: ComplexArray, t: FloatArray
) -> ComplexArray:
    _, J = values_and_jacobian(family, _at(start, change, t), w)
    return -solve_each(J, values(family, change, w))


def _predicted(
    family: LoopFamily, start: ComplexArray, change: ComplexArray, w: ComplexArray, t: FloatArray, h: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return the predicted points of the paths, and dw/dt at the present points."""
    step = h[:, None]
    a = _slope(family, start, change, w, t)
    b = _slope(family, start, change, w + 0.5 * step * a, t + 0.5 * h)
    c = _slope(family, start, change, w + 0.5 * step * b, t + 0.5 * h)
    d = _slope(family, start, change, w + step * c, t + h)
    return w + step / 6.0 * (a + 2.0 * b + 2.0 * c + d), a


def _corrected(
    family: LoopFamily, start: ComplexArray, change: ComplexArray, w: ComplexArray, t: FloatArray,
    constants: TrackingConstants,
) -> tuple[BoolArray, FloatArray, ComplexArray]:  # fmt: skip
    """Return whether two corrections converge, the size of the first, and the points."""
    H = _at(start, change, t)
    value, J = values_and_jacobian(family, H, w)
    first = solve_each(J, value)
    w = w - first
    value, J = values_and_jacobian(family, H, w)
    second = solve_each(J, value)
    reach = np.ones(w.shape)
    reach[:, family.angles :] = np.maximum(np.abs(w[:, family.angles :]), 1.0)  # a slide may pass near infinity
    moved, left = (np.max(np.abs(d) / reach, axis=1, initial=0.0) for d in (first, second))
    accepted = (moved < constants.correction) & (left < np.maximum(constants.contraction * moved, constants.settled))
    return accepted, moved, w - second


@dataclass(frozen=True)
class Generic:
    """A linkage with random complex dimensions and its roots."""

    H: ComplexArray  # (2, L, 1 + n + q)
    w: ComplexArray  # (roots, n + q)


def generic_member(family: LoopFamily, generator: np.random.Generator) -> tuple[ComplexArray, ComplexArray]:
    """Return coefficients of a random complex linkage and one root (1, n + q) of it."""
    n, q = family.angles, family.slides
    w = np.concatenate([_normal(generator, n).real * 0.5 + 1j * generator.uniform(-np.pi, np.pi, n),
                        _normal(generator, q)])  # fmt: skip
    ab, _ = factors(family, w)
    halves = []
    for part in (0, 1):
        closing = np.einsum("k,lkp->lp", ab[part], family.table)  # the loops close if this times p is 0
        p = _normal(generator, family.table.shape[2])
        p = p - np.linalg.pinv(closing) @ (closing @ p)
        halves.append(p / np.linalg.norm(p) * np.sqrt(len(p)))
    return family.member(halves[0], halves[1]), w[None, :]


def random_member(family: LoopFamily, generator: np.random.Generator) -> ComplexArray:
    """Return coefficients of a random complex linkage."""
    count = family.table.shape[2]
    return family.member(_normal(generator, count), _normal(generator, count))


def _normal(generator: np.random.Generator, count: int) -> ComplexArray:
    return np.asarray((generator.standard_normal(count) + 1j * generator.standard_normal(count)) / np.sqrt(2.0))


def generic_start(family: LoopFamily, seed: int, count: int | None, progress: Progress = no_progress) -> Generic:
    """Return a generic linkage with `count` roots, or with all roots that monodromy finds."""
    generator = np.random.default_rng([seed, 20041])
    H, w = generic_member(family, generator)
    idle = 0
    for _ in range(SEARCH.monodromy):
        if len(w) == count or ((count is None or family.rails_shared) and idle >= SEARCH.idle):
            break
        found = _round_trip(family, H, w, generator)
        idle = 0 if len(found) > len(w) else idle + 1
        w = found
        progress(len(w), count or 2 * len(w))
    return Generic(H, w)


def _round_trip(family: LoopFamily, H: ComplexArray, w: ComplexArray, generator: np.random.Generator) -> ComplexArray:
    """Follow the roots around a triangle of linkages; return all known roots with the new ones."""
    corners = [H, random_member(family, generator), random_member(family, generator), H]
    tracking = replace(SEARCH.tracking, correction=SEARCH.tracking.correction * SEARCH.tighter[0])
    there = w
    for start, end in pairwise(corners):
        done = track(family, start, end, there, tracking)
        there = done.w[done.arrived]
    there = corrected(family, H, there, SEARCH.polish)
    both = np.concatenate([w, there[np.isfinite(there).all(axis=1)]])
    return distinct(family, prove(family, H, both)).w


NULL = 1e-10
"""Singular value relative to the largest below which a combination eliminates the columns (rounding)."""

SEED = 20010901

Monomial = tuple[frozenset[int], int]
"""The set T, and the number of the slide or -1."""


@dataclass(frozen=True)
class Job:
    """The rows for one set S: the half (f or g), the eliminated columns, and the monomials of the others."""

    half: int  # 0 for f, 1 for g
    eliminated: IntArray
    columns: tuple[IntArray, IntArray]  # columns of the coefficients of x^0 and of x
    places: tuple[IntArray, IntArray]  # numbers of their monomials


@dataclass(frozen=True)
class Pencil:
    """The hidden angle, the monomials (`basis`) and the rows (`jobs`)."""

    hidden: int  # number of the hidden angle
    family: LoopFamily = field(repr=False)
    basis: dict[Monomial, int] = field(repr=False)
    jobs: tuple[Job, ...] = field(repr=False)

    def matrices(self, H: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return M0 and M1 (rows, monomials) for coefficients H (2, L, 1 + n + q)."""
        size = len(self.basis)
        blocks: tuple[list[ComplexArray], list[ComplexArray]] = ([], [])
        for job in self.jobs:
            half = H[job.half]
            rows = _left_null(half[:, job.eliminated]) @ half
            for power in (0, 1):
                block = np.zeros((len(rows), size), dtype=complex)
                block[:, job.places[power]] = rows[:, job.columns[power]]
                blocks[power].append(block)
        return np.concatenate(blocks[0]), np.concatenate(blocks[1])


def _left_null(table: ComplexArray) -> ComplexArray:
    """Return a basis (rows, L) of the left null space of a table (L, columns)."""
    if table.shape[1] == 0:
        return np.eye(table.shape[0], dtype=complex)
    u, s, _ = np.linalg.svd(table)
    rank = int(np.sum(s > NULL * max(float(s[0]), 1e-300)))
    return np.asarray(u[:, rank:].conj().T)


def candidates(pencil: Pencil, H: ComplexArray) -> ComplexArray:
    """Return candidates for roots (candidates, n + q), to be corrected and proved."""
    from scipy.linalg import eig

    m0, m1 = pencil.matrices(H)
    size = len(pencil.basis)
    none = np.zeros((0, H.shape[2] - 1), dtype=complex)
    if len(m0) < size or not (np.isfinite(m0).all() and np.isfinite(m1).all()):
        return none
    if len(m0) > size:
        mixed = _mixing(len(m0), size)
        m0, m1 = mixed @ m0, mixed @ m1
    with np.errstate(all="ignore"):
        try:
            x, v = eig(m0, -m1, check_finite=False)
        except np.linalg.LinAlgError:
            return none
        w = _recovered(pencil, x, v)
        fits = np.isfinite(w).all(axis=1) & (np.abs(w) < np.inf).all(axis=1)
    return np.asarray(w[fits])


@lru_cache(16)
def _mixing(rows: int, size: int) -> ComplexArray:
    generator = np.random.default_rng(SEED)
    table = generator.standard_normal((rows, size)) + 1j * generator.standard_normal((rows, size))
    return np.asarray(np.linalg.qr(table)[0].conj().T)


def _recovered(pencil: Pencil, x: ComplexArray, v: ComplexArray) -> ComplexArray:
    """Return w from the hidden angle x (k,) and vectors v (monomials, k), by ratios of the largest entries."""
    n, q = pencil.family.angles, pencil.family.slides
    basis, weight = pencil.basis, np.abs(v)
    w = np.empty((len(x), n + q), dtype=complex)
    w[:, pencil.hidden] = np.log(x)
    pure = [(t, k) for (t, slide), k in basis.items() if slide < 0]
    every = np.arange(len(x))
    for j in range(n):
        if j != pencil.hidden:
            pairs = np.array([(k, basis[(t | {j}, -1)]) for t, k in pure if j not in t and (t | {j}, -1) in basis])
            best = np.argmax(np.minimum(weight[pairs[:, 0]], weight[pairs[:, 1]]), axis=0)
            w[:, j] = np.log(v[pairs[best, 0], every] / v[pairs[best, 1], every])
    for s in range(q):
        pairs = np.array([(basis[(t, s)], k) for t, k in pure])
        best = np.argmax(weight[pairs[:, 1]], axis=0)
        w[:, n + s] = v[pairs[best, 0], every] / v[pairs[best, 1], every]
    return w


def _pencil(family: LoopFamily, hidden: int, low: int, high: int) -> Pencil | None:
    """Return the pencil of a hidden angle and a window of sizes; None if it has no rows."""
    others = [j for j in range(family.angles) if j != hidden]
    sets = [frozenset(s) for size in range(low, high + 1) for s in combinations(others, size)]
    monomials: list[Monomial] = [(s, q) for q in range(-1, family.slides) for s in sets]
    basis = {m: k for k, m in enumerate(monomials)}
    jobs = [_job(family, hidden, basis, s, half, (low, high)) for s in sets for half in (0, 1)]
    return Pencil(hidden, family, basis, tuple(jobs))


def _job(
    family: LoopFamily, hidden: int, basis: dict[Monomial, int], s: frozenset[int], half: int, window: tuple[int, int]
) -> Job:
    n, edge = family.angles, len(s) == window[half]
    eliminated: list[int] = []
    columns: tuple[list[int], list[int]] = ([], [])
    places: tuple[list[int], list[int]] = ([], [])

    def put(power: int, column: int, monomial: Monomial) -> None:
        columns[power].append(column)
        places[power].append(basis[monomial])

    carriers = [(1 + c, c, -1) for c in range(n)] + [(1 + n + q, int(m), q) for q, m in enumerate(family.rail)]
    for column, carrier, slide in [(0, GROUND, -1), *carriers]:
        if carrier == GROUND:  # g is multiplied by x
            put(half, column, (s, slide))
        elif carrier == hidden:
            put(1 - half, column, (s, slide))
        elif edge or (carrier in s) == (half == 1):
            eliminated.append(column)
        else:
            put(half, column, (s - {carrier} if half == 0 else s | {carrier}, slide))
    return Job(half, np.array(eliminated, dtype=int), _pair(columns), _pair(places))


def _pair(lists: tuple[list[int], list[int]]) -> tuple[IntArray, IntArray]:
    return np.array(lists[0], dtype=int), np.array(lists[1], dtype=int)


@cache
def pencil_of(family: LoopFamily) -> Pencil | None:
    """Return a pencil that has full rank for a random member of the family, None if there is none."""
    if family.loops > SEARCH.pencil_loops or family.angles == 0:
        return None
    H = random_member(family, np.random.default_rng(SEED))
    L, n = family.loops, family.angles
    rails = sorted({int(m) for m in family.rail if m != GROUND})
    windows = [(L - 1, L)] if not family.slides else [
        (low, high) for width in (1, 2, 3) for low in range(n - width) if (high := low + width) < n
    ]  # fmt: skip
    for hidden in rails or range(n):
        for low, high in windows:
            pencil = _pencil(family, hidden, low, high)
            if pencil is not None and len(pencil.basis) <= SEARCH.pencil_unknowns and _full(pencil, H):
                return pencil
    return None


def _full(pencil: Pencil, H: ComplexArray) -> bool:
    """Return whether the pencil has full column rank at a random x."""
    m0, m1 = pencil.matrices(H)
    if len(m0) < len(pencil.basis):
        return False
    s = np.linalg.svd(m0 + np.exp(1j) * 0.9 * m1, compute_uv=False)
    return bool(s[-1] > NULL * s[0])
