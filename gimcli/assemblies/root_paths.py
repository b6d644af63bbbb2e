"""Paths of roots from one linkage of a family to another, all paths in parallel.

The coefficients vary linearly in t; a predictor of fourth order (Runge-Kutta) and two Newton-Raphson corrections
follow dw/dt = -J^-1 dH/dt, each path with its own step. Source: A. Sommese and C. Wampler,
The numerical solution of systems of polynomials, 2005.

A generic linkage of a topology with all its complex roots, from which paths to other linkages start.

A random point and random parameters, projected so that the loops close, give one root. The others are found along
triangles in the space of parameters (monodromy), which permute the roots transitively: the pairs of linkage and root
are a vector bundle over the roots. Source: T. Duff et al., Solving polynomial systems via homotopy continuation and
monodromy, IMA J. Numer. Anal. 39 (2019).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gimcli.assemblies.certificate import distinct, each_of, prove
from gimcli.assemblies.constants import SEARCH, TrackingConstants
from gimcli.assemblies.loops import LoopFamily, factors, values, values_and_jacobian
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray
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
    stacked = family.stacked.reshape(family.loops, 1 + n + q, -1)
    halves = []
    for part in (0, 1):
        closing = np.einsum("k,lkp->lp", ab[part], stacked)  # the loops close if this times p is 0
        p = _normal(generator, stacked.shape[2])
        p = p - np.linalg.pinv(closing) @ (closing @ p)
        halves.append(p / np.linalg.norm(p) * np.sqrt(len(p)))
    return family.member(halves[0], halves[1]), w[None, :]


def random_member(family: LoopFamily, generator: np.random.Generator) -> ComplexArray:
    """Return coefficients of a random complex linkage."""
    count = family.stacked.shape[1]
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
