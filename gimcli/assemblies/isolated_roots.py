"""Proved solutions: refined, without duplicates, each with the largest known box without another solution.

Two proofs are of the same solution if the enclosure of one is inside the unique box of the other. A pair that can
neither be identified nor separated is undecided and not counted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.assemblies.cosine_rows import EPS
from gimcli.assemblies.krawczyk import image, local
from gimcli.assemblies.loops import Coefficients
from gimcli.canonical import TURN
from gimcli.mechanism import BoolArray, FloatArray


@dataclass(frozen=True)
class IsolatedRootConstants:
    """Constants of the refinement."""

    newton: int = 4  # Newton-Raphson corrections
    largest: float = 1.0  # rad: first half-width tried for the unique box
    rungs: int = 50  # number of half-widths tried, each half of the previous one
    smallest: float = 3.0  # half-width of the enclosure relative to Newton's last correction and its rounding
    turn: float = 16 * EPS  # rad: rounding of a subtracted turn
    widen: float = 1 + 8 * EPS  # factor of half-widths against rounding


CONSTANTS = IsolatedRootConstants()


def centred(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return middles and half-widths of boxes, rounded outwards."""
    middle = 0.5 * (low + high)
    return middle, np.maximum(high - middle, middle - low) * CONSTANTS.widen


def wrap(x: FloatArray, n: int) -> FloatArray:
    """Return points (..., d) with their first n coordinates, the angles, in [-pi, pi]."""
    wrapped = np.array(x, dtype=float)
    wrapped[..., :n] -= TURN * np.round(wrapped[..., :n] / TURN)
    return wrapped


class IsolatedRoots:
    """Proved solutions (R, d), angles first, with half-widths `radius` of enclosures and `unique` of unique boxes."""

    def __init__(self, loops: Coefficients, unit: FloatArray) -> None:
        self.loops, self.unit, self.n = loops, unit, loops.C.shape[1]
        self.roots, self.radius, self.unique = (np.zeros((0, len(unit))) for _ in range(3))

    def add(self, middle: FloatArray, half: FloatArray) -> BoolArray:
        """Add boxes (B, d) that contain exactly one solution each; return which solutions are now listed."""
        known = np.zeros(len(middle), dtype=bool)
        tried = np.zeros(len(middle), dtype=bool)
        while True:
            known |= np.any(np.all(self._apart(middle) + self.radius <= half[:, None], axis=2), axis=1)
            open_ = np.nonzero(~known & ~tried)[0]
            if not len(open_):
                return known
            tried[open_[0]] = True
            known[open_[0]] = self._refine(middle[open_[0]], half[open_[0]])

    def holds(self, low: FloatArray, high: FloatArray) -> BoolArray:
        """Return which boxes (B, d) are inside the unique box of a solution."""
        middle, half = centred(low, high)
        return np.asarray(np.any(np.all(self._apart(middle) + half[:, None] <= self.unique, axis=2), axis=1))

    def _apart(self, x: FloatArray) -> FloatArray:
        """Return distances (B, R, d) of points from the solutions, those of angles modulo a turn."""
        return np.abs(wrap(x[:, None] - self.roots, self.n)) * CONSTANTS.widen

    def _refine(self, middle: FloatArray, half: FloatArray) -> bool:
        """Enclose the solution of a box tightly; return whether it is now listed."""
        x = middle[None]
        for _ in range(CONSTANTS.newton):
            x = x - local(self.loops, x).value
        at = local(self.loops, x)
        radius = CONSTANTS.smallest * (np.abs(at.value) + at.error)
        enclosed = np.all(image(at, radius) < radius) and np.all(np.abs(x - middle) + radius <= half)
        if not enclosed:
            return False
        near = np.all(self._apart(x)[0] <= self.radius + radius, axis=1)
        if near.any():  # the same solution if inside the unique box, otherwise undecided
            return bool(np.any(np.all((self._apart(x)[0] + radius <= self.unique)[near], axis=1)))
        self._append(x[0], radius[0])
        return True

    def _append(self, x: FloatArray, radius: FloatArray) -> None:
        """Store a new solution with the largest box that is proved to contain no other."""
        rungs = CONSTANTS.largest * 0.5 ** np.arange(CONSTANTS.rungs)[:, None] * self.unit
        rungs = rungs[(rungs >= radius).all(axis=1)]
        at = local(self.loops, np.repeat(x[None], len(rungs), axis=0))
        proved = np.nonzero((image(at, rungs) < rungs).all(axis=1))[0]
        unique = rungs[proved[0]] if len(proved) else radius
        self.roots = np.vstack([self.roots, wrap(x, self.n)])
        self.radius = np.vstack([self.radius, radius + CONSTANTS.turn])
        self.unique = np.vstack([self.unique, unique - CONSTANTS.turn])

    def inside(self, reach: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the solutions whose slides may be within the reach, with radius and unique box."""
        within = (np.abs(self.roots[:, self.n :]) - self.radius[:, self.n :] <= reach).all(axis=1)
        order = np.lexsort(self.roots[within].T[::-1])
        return self.roots[within][order], self.radius[within][order], self.unique[within][order]
