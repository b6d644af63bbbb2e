"""Paths of roots from one linkage of a family to another, all paths in parallel.

The coefficients vary linearly in t; a predictor of fourth order (Runge-Kutta) and two Newton-Raphson corrections
follow dw/dt = -J^-1 dH/dt, each path with its own step. Source: A. Sommese and C. Wampler,
The numerical solution of systems of polynomials, 2005.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.assemblies.certificate import each_of
from gimcli.assemblies.constants import TrackingConstants
from gimcli.assemblies.loops import LoopFamily, values, values_and_jacobian
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray
from gimcli.progress import spend

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
