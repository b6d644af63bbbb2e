"""Pseudo-arclength continuation of a curve of solutions, through folds, and what is met on the way.

A curve G(p) = 0 of m >= n equations in n + 1 unknowns is followed by predictor steps along its tangent and
corrections perpendicular to it (Moore-Penrose). Source: Allgower & Georg, Introduction to Numerical Continuation
Methods, 2003, chapters 2 to 6 and 8.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gimcli.mechanism import FloatArray

WEAK = 1e4
"""Greatest over least singular value from which steps are found by singular values: squared, that leaves 8 digits."""


class Implicit(Protocol):
    """A curve of solutions; surplus equations must agree with the others."""

    def residual(self, p: FloatArray) -> FloatArray:
        """Return G (m,) at p (n + 1,)."""
        ...

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return G_p (m, n + 1)."""
        ...


@dataclass(frozen=True)
class ArclengthConstants:
    """Constants of the continuation; lengths are those of the space of p."""

    first: float = 1e-2  # step
    longest: float = 5e-2
    shortest: float = 1e-9
    bend: float = 0.12  # rad: greatest angle between tangents that follow each other
    pull: float = 0.05  # greatest correction, as part of the step
    growth: float = 1.6
    corrections: int = 6
    closeness: float = 1e-14  # size of the last correction
    rounding: float = 1e-11  # below it corrections that end to shrink have arrived
    noise: float = 0.0  # correction that rounding alone may cause beside a singular position
    rank: float = 1e-10  # of singular values over the greatest: below it the tangent is not determined
    points: int = 100_000  # at most


@dataclass(frozen=True)
class CurvePoint:
    """A point of the curve with its unit tangent and what its Jacobian says."""

    p: FloatArray  # (n + 1,)
    tangent: FloatArray  # (n + 1,)
    jacobian: FloatArray  # (m, n + 1)
    values: FloatArray  # (n,) singular values, falling
    left: FloatArray  # (m, n) left singular vectors

    @property
    def regular(self) -> float:
        """Least over greatest singular value: 0 where branches meet."""
        return float(self.values[-1] / self.values[0])

    def orientation(self, left: FloatArray) -> float:
        """Return the determinant of the equations, combined by `left` (m, n), over the tangent.

        Between neighbours, with the same `left`, it changes its sign where an odd number of branches cross.
        """
        return float(np.linalg.det(np.vstack([left.T @ self.jacobian, self.tangent])))


def place(system: Implicit, p: FloatArray, along: FloatArray) -> CurvePoint:
    """Return a point with the tangent that runs along a vector (n + 1,)."""
    jacobian = system.jacobian(p)
    left, values, across = np.linalg.svd(jacobian, full_matrices=True)
    n = len(p) - 1
    tangent = across[-1] * (1.0 if across[-1] @ along >= 0.0 else -1.0)
    return CurvePoint(p, tangent, jacobian, values[:n], left[:, :n])


def correct(
    system: Implicit, p: FloatArray, constants: ArclengthConstants, normal: FloatArray | None = None
) -> FloatArray | None:
    """Return the solution next to p: the nearest, or that in the plane through p across `normal`; None without one."""
    p, last = p.copy(), np.inf
    for _ in range(constants.corrections):
        g, table = system.residual(p), system.jacobian(p)
        if normal is not None:
            g, table = np.append(g, 0.0), np.vstack([table, normal])
        if not (np.isfinite(g).all() and np.isfinite(table).all()):
            return None
        step = _least(table, -g, len(p) if normal is not None else len(p) - 1, constants.rank)
        p += step
        size = float(np.linalg.norm(step))
        if size <= constants.closeness:
            return p
        if size > 2.0 * last:
            break
        last = size
    return p if last <= constants.rounding else None


def _least(table: FloatArray, wanted: FloatArray, rank: int, lost: float) -> FloatArray:
    """Return the least step of some rank that does most; beside the curve surplus equations seem to hold one more."""
    if len(table) == rank:
        step = _plain(table, wanted)
        if step is not None:
            return step
    left, values, right = np.linalg.svd(table, full_matrices=False)
    values = values[: min(rank, int(np.sum(values > lost * values[0])))]
    kept = len(values)
    return np.asarray(right[:kept].T @ ((left[:, :kept].T @ wanted) / values))


def _plain(table: FloatArray, wanted: FloatArray) -> FloatArray | None:
    """Return the least step by its normal equations; None where a weak direction has a part in it, or rank is lost."""
    try:
        pull = np.linalg.solve(table @ table.T, wanted)
    except np.linalg.LinAlgError:
        return None
    step = np.asarray(pull @ table)
    strong = float(np.vdot(pull, pull) * np.vdot(table, table)) <= WEAK**2 * float(step @ step)
    return step if strong else None


def advance(system: Implicit, here: CurvePoint, step: float, constants: ArclengthConstants) -> CurvePoint | None:
    """Return the place a step along the tangent; None where it bends or has to be pulled too much."""
    ahead = here.p + step * here.tangent
    found = correct(system, ahead, constants)
    if found is None or not np.linalg.norm(found - ahead) <= constants.pull * abs(step) + constants.noise:
        return None
    there = place(system, found, here.tangent)
    return there if there.tangent @ here.tangent >= np.cos(constants.bend) else None


def walk(system: Implicit, start: CurvePoint, constants: ArclengthConstants) -> Iterator[CurvePoint]:
    """Yield the places after `start` along its tangent, until no step can be made; the caller ends a closed curve."""
    here, step = start, constants.first
    for _ in range(constants.points):
        there = advance(system, here, step, constants)
        while there is None:
            step *= 0.5
            if step < constants.shortest:
                return
            there = advance(system, here, step, constants)
        yield there
        step = grown(step, here, there, constants, constants.longest)
        here = there


def grown(step: float, here: CurvePoint, there: CurvePoint, constants: ArclengthConstants, longest: float) -> float:
    """Return the next step: a longer one where the last bent little."""
    bent = 1.0 - float(there.tangent @ here.tangent)  # about half the angle's square
    return min(step * constants.growth, longest) if bent < 0.25 * (1.0 - math.cos(constants.bend)) else step


def pinned(
    system: Implicit, here: CurvePoint, step: float, test: Callable[[CurvePoint], float], constants: ArclengthConstants
) -> tuple[float, CurvePoint] | None:
    """Find where a test changes its sign on the step from `here`; return how far along the tangent, and the place.

    None where the curve cannot be determined there to the last digit (at a crossing of branches: extrapolate).
    """
    from scipy.optimize import brentq

    known: dict[float, tuple[CurvePoint, float]] = {}

    def at(s: float) -> tuple[CurvePoint, float]:
        if s not in known:  # the ends are tested once: a place corrected anew may have the other sign
            found = correct(system, here.p + s * here.tangent, constants, here.tangent)
            there = here if found is None else place(system, found, here.tangent)
            known[s] = there, test(there)
        return known[s]

    known[0.0] = here, test(here)
    if not at(0.0)[1] * at(step)[1] < 0.0:
        return None
    s = float(brentq(lambda t: at(t)[1], 0.0, step, xtol=constants.closeness))
    return s, at(s)[0]
