"""Pseudo-arclength continuation of a curve of solutions, also through folds.

A curve G(p) = 0 of m >= n equations in n + 1 unknowns is followed by predictor steps along its tangent and
corrections perpendicular to it (Moore-Penrose). Source: Allgower & Georg, Introduction to Numerical Continuation
Methods, 2003, chapters 2 to 6 and 8.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from gimcli.mechanism import BoolArray, FloatArray
from gimcli.numerics.along import Part, hermite, hermite_slope, root
from gimcli.numerics.follower import Follower
from gimcli.progress import spend

WEAK = 1e4
"""Condition number above which steps are computed by SVD: normal equations square it and leave 8 digits."""


class Implicit(Protocol):
    """A curve of solutions; redundant equations must be consistent with the others."""

    def linearised(self, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return G (..., m) and G_p (..., m, n + 1) at p (..., n + 1)."""

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return G_p (..., m, n + 1)."""


@dataclass(frozen=True)
class ArclengthConstants:
    """Constants of the continuation; lengths are those of the space of p."""

    first: float = 1e-2  # first step
    longest: float = 5e-2  # greatest step
    shortest: float = 1e-9  # least step
    bend: float = 0.12  # rad: greatest angle between successive tangents
    pull: float = 0.05  # greatest correction, relative to the step
    growth: float = 1.6  # factor from one step to the next
    corrections: int = 6  # greatest number
    closeness: float = 1e-14  # converged if a correction is below this
    rounding: float = 1e-11  # also converged if corrections below this no longer decrease
    noise: float = 0.0  # correction that rounding may cause near a singular position
    rank: float = 1e-10  # singular values below this fraction of the greatest are 0
    points: int = 100_000  # greatest number


@dataclass(frozen=True)
class CurvePoint:
    """A point of the curve with its unit tangent, Jacobian and singular values."""

    p: FloatArray  # (n + 1,)
    tangent: FloatArray  # (n + 1,)
    jacobian: FloatArray  # (m, n + 1)
    values: FloatArray  # (n,) singular values, in descending order
    left: FloatArray  # (m, n) left singular vectors

    @property
    def regular(self) -> float:
        """Ratio of least to greatest singular value; 0 if branches meet."""
        return float(self.values[-1] / self.values[0])

    @property
    def rate(self) -> float:
        """The derivative of the last unknown, the parameter, by the arc length."""
        return float(self.tangent[-1])

    def orientation(self, left: FloatArray) -> float:
        """Return the determinant of the Jacobian, projected by `left` (m, n), with the tangent as last row.

        Its sign changes between neighbours (with the same `left`) if an odd number of branches cross between them.
        """
        return float(np.linalg.det(np.vstack([left.T @ self.jacobian, self.tangent])))


def place(system: Implicit, p: FloatArray, along: FloatArray) -> CurvePoint:
    """Return the point p of the curve with the tangent in the sense of a vector `along` (n + 1,)."""
    jacobian = system.jacobian(p)
    left, values, across = np.linalg.svd(jacobian, full_matrices=True)
    n = len(p) - 1
    tangent = across[-1] * (1.0 if across[-1] @ along >= 0.0 else -1.0)
    return CurvePoint(p, tangent, jacobian, values[:n], left[:, :n])


def tangents(system: Implicit, p: FloatArray, along: FloatArray) -> FloatArray:
    """Return the unit tangents (rows, n + 1) at points p (rows, n + 1), in the sense of vectors along (rows, n + 1)."""
    across = np.linalg.svd(system.jacobian(p), full_matrices=True)[2][:, -1]
    return across * np.where(np.einsum("rn,rn->r", across, along) >= 0.0, 1.0, -1.0)[:, None]


def correct(
    system: Implicit, p: FloatArray, constants: ArclengthConstants, normal: FloatArray | None = None, freedoms: int = 1
) -> FloatArray | None:
    """Return the solution closest to p (n + 1,), or that in the plane through p with a `normal`; None if none is found.

    freedoms: dimension of the set of solutions, 1 for a curve.
    """
    p, last = p.copy(), np.inf
    for _ in range(constants.corrections):
        step = _step(system, p, constants, normal, freedoms)
        p += step
        size = math.sqrt(step @ step)
        if size <= constants.closeness:
            return p
        if not size <= 2.0 * last:
            last = last if math.isfinite(size) else np.inf
            break
        last = size
    return p if last <= constants.rounding else None


def corrected(
    system: Implicit, p: FloatArray, constants: ArclengthConstants, normals: FloatArray | None = None,
    freedoms: int = 1,
) -> tuple[FloatArray, BoolArray]:  # fmt: skip
    """Return the solutions (rows, n + 1) closest to points p (rows, n + 1), and whether each was found (rows,).

    normals: (rows, n + 1) of planes through the points. The other arguments and the rules are those of `correct`.
    """
    p, going, last, size = p.copy(), np.arange(len(p)), np.full(len(p), np.inf), np.full(len(p), np.inf)
    for _ in range(constants.corrections if len(p) else 0):
        step = _step(system, p[going], constants, None if normals is None else normals[going], freedoms)
        p[going] += step
        size[going] = np.linalg.norm(step, axis=1)
        going = going[(size[going] > constants.closeness) & (size[going] <= 2.0 * last[going])]
        if not len(going):
            break
        last[going] = size[going]
    return p, (size <= constants.closeness) | (last <= constants.rounding) & np.isfinite(size)


def _step(
    system: Implicit, p: FloatArray, constants: ArclengthConstants, normal: FloatArray | None, freedoms: int
) -> FloatArray:
    """Return the least-norm least-squares step (..., n + 1) at p (..., n + 1), of a limited rank; NaN if there is none.

    The rank is limited because, off the curve, redundant equations seem to be independent.
    """
    g, table = system.linearised(p)
    rank = p.shape[-1] - freedoms
    if normal is not None:
        g, rank = np.concatenate([g, np.zeros((*g.shape[:-1], 1))], axis=-1), p.shape[-1]
        table = np.concatenate([table, normal[..., None, :]], axis=-2)
    step, strong = np.full(p.shape, np.nan), np.zeros(p.shape[:-1], dtype=bool)
    if table.shape[-2] == rank:
        with suppress(np.linalg.LinAlgError):  # one of them is singular
            step, strong = _plain(table, -g)
    if not strong.all():
        weak = np.isfinite(table).all(axis=(-2, -1)) & np.isfinite(g).all(axis=-1) & ~strong
        left, values, right = np.linalg.svd(table[weak], full_matrices=False)
        kept = (values > constants.rank * values[:, :1]) & (np.arange(values.shape[1]) < rank)
        parts = (-g[weak][:, None] @ left)[:, 0] / np.where(kept, values, np.inf)
        step[~strong] = np.nan
        step[weak] = (parts[:, None] @ right)[:, 0]
    return step


def _plain(table: FloatArray, wanted: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return the least-norm steps by normal equations, and whether these are well-conditioned (...,)."""
    gram = table @ np.swapaxes(table, -2, -1)
    pull = np.linalg.solve(gram, wanted[..., None])
    across = np.swapaxes(pull, -2, -1)
    step = across @ table
    gain = (across @ pull)[..., 0, 0] * gram.trace(axis1=-2, axis2=-1)
    return step[..., 0, :], gain <= WEAK**2 * (step @ np.swapaxes(step, -2, -1))[..., 0, 0]


def beside(
    system: Implicit, tangent: FloatArray, guess: FloatArray, distance: float, constants: ArclengthConstants,
    normal: FloatArray | None = None,
) -> CurvePoint | None:  # fmt: skip
    """Return the point near a guess (n + 1,) at some distance from another point along its unit tangent (n + 1,).

    None if the curve turns, or the guess has to be corrected, too much. normal: as in `correct`.
    """
    found = correct(system, guess, constants, normal)
    if found is None or not np.linalg.norm(found - guess) <= constants.pull * abs(distance) + constants.noise:
        return None
    there = place(system, found, tangent)
    return there if there.tangent @ tangent >= np.cos(constants.bend) else None


def all_beside(
    system: Implicit, ahead: FloatArray, guess: FloatArray, distances: FloatArray, constants: ArclengthConstants
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return points (rows, n + 1) in the planes through guesses across unit tangents `ahead` of others (rows, n + 1).

    Then the unit tangents there, and whether each was found (rows,); the rules are those of `beside`.
    """
    found, good = corrected(system, guess, constants, ahead)
    good &= np.linalg.norm(found - guess, axis=1) <= constants.pull * np.abs(distances) + constants.noise
    there = ahead.copy()
    there[good] = tangents(system, found[good], ahead[good])
    return found, there, good & (np.einsum("rn,rn->r", there, ahead) >= np.cos(constants.bend))


class ArclengthFollower(Follower[FloatArray, CurvePoint]):
    """Follows a curve from a point along its tangent; `places` are the points so far. The caller ends closed curves."""

    def __init__(self, system: Implicit, start: CurvePoint, constants: ArclengthConstants) -> None:
        self.system, self.constants, self.places = system, constants, [start]
        self.step, self.shortest = constants.first, constants.shortest

    def predict(self) -> FloatArray:
        """Return the point (n + 1,) after a step along the tangent."""
        here = self.places[-1]
        return here.p + self.step * here.tangent

    def correct(self, guess: FloatArray) -> CurvePoint | None:
        """Return the point near a predicted one; None if the curve turns, or the point is moved, too much."""
        return beside(self.system, self.places[-1].tangent, guess, self.step, self.constants)

    def accept(self, there: CurvePoint) -> bool:
        """Add a point; the next step is longer if the tangent turned little in the last one."""
        turned = 1.0 - float(there.tangent @ self.places[-1].tangent)  # about half the square of the angle
        if turned < 0.25 * (1.0 - math.cos(self.constants.bend)):
            self.step = min(self.step * self.constants.growth, self.longest(there))
        self.places.append(there)
        return True

    def longest(self, there: CurvePoint) -> float:
        """Return the greatest step from a point."""
        return self.constants.longest


def walk(system: Implicit, start: CurvePoint, constants: ArclengthConstants) -> Iterator[CurvePoint]:
    """Yield the points after `start` along its tangent, until no step succeeds."""
    follower = ArclengthFollower(system, start, constants)
    while len(follower.places) <= constants.points and follower.go():
        yield follower.places[-1]
        if spend(1):
            return


def cubic(
    here: FloatArray, tangent: FloatArray, there: FloatArray, other: FloatArray, part: Part
) -> tuple[FloatArray, FloatArray]:
    """Return the cubic through two points with unit tangents (..., n + 1) and its derivative, at a fraction (0..1)."""
    h = np.linalg.norm(there - here, axis=-1, keepdims=True)
    ends = here, h * tangent, there, h * other
    return hermite(*ends, part), hermite_slope(*ends, part)


def point_between(
    system: Implicit, here: CurvePoint, there: CurvePoint, part: float, constants: ArclengthConstants
) -> CurvePoint:
    """Return the point at a fraction (0..1) between two neighbours; that of the cubic where corrections fail."""
    guess, along = cubic(here.p, here.tangent, there.p, there.tangent, part)
    exact = correct(system, guess, constants, along / np.linalg.norm(along))
    return place(system, guess if exact is None else exact, along)


def between(
    system: Implicit, here: CurvePoint, there: CurvePoint, test: Callable[[CurvePoint], float],
    constants: ArclengthConstants,
) -> CurvePoint | None:  # fmt: skip
    """Return the point between two neighbours at which a test changes its sign; None if it does not.

    At a crossing of branches the point is not exact, as corrections fail there.
    """
    if not test(here) * test(there) < 0.0:
        return None
    at = partial(point_between, system, here, there, constants=constants)
    return root(at, test, (0.0, here), (1.0, there), constants.closeness)
