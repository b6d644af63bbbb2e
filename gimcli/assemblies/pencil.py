"""All roots of a group by one generalised eigenvalue problem.

One angle x = theta_h is hidden. The unknown vector contains theta^-T and s_q theta^-T for sets T of the other
angles in a window of sizes. theta^-S times a combination of the loops that eliminates the angles outside S (for f)
or inside S (for g) is square-free and linear in x, so that (M0 + x M1) v = 0. Null vectors replace the minors of
Dixon's determinant, which are zero for sparse topologies. Source: C. Wampler, Solving the kinematics
of planar mechanisms by Dixon determinant and a complex-plane formulation, J. Mech. Des. 123 (2001).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache, lru_cache
from itertools import combinations

import numpy as np

from gimcli.assemblies.constants import SEARCH
from gimcli.assemblies.loops import GROUND, LoopFamily
from gimcli.mechanism import ComplexArray, IntArray

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
    from gimcli.assemblies.root_paths import random_member

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
