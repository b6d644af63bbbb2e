"""Test which of several positions at the same input are on a circuit, in one pass over its points."""

from __future__ import annotations

import math

import numpy as np

from gimcli.continuation import gauss_newton
from gimcli.continuation.circuit import Circuit
from gimcli.continuation.hermite import hermite
from gimcli.mechanism import BoolArray, FloatArray, IntArray

SETTLING = gauss_newton.GaussNewtonConstants(iterations=8)
"""The cubic between two points deviates from the circuit by some 1e-5 at most, so few iterations suffice."""


SAME, NEAR = 1e-7, 0.5
"""Distance within which a position is on a circuit; distance, in steps, within which it is tested exactly."""


class Visits:
    """The points of a circuit as arrays. turning: its parameter is an angle with a period."""

    def __init__(self, circuit: Circuit, turning: bool) -> None:
        self.curve = circuit.curve
        self.p = circuit.p.T
        self.tangent = np.array([here.tangent for here in circuit.places])
        self.step = np.linalg.norm(np.diff(self.p, axis=0), axis=1)
        self.marks = np.concatenate([[0.0], np.cumsum(self.step)])
        around = abs(float(self.p[-1, -1] - self.p[0, -1]))
        closes = circuit.closed and around > SAME
        self.period = circuit.curve.period if turning else around if closes else math.inf

    def locations(self, x: FloatArray, q: float) -> FloatArray:
        """Return the locations (0..1) on the circuit of positions x (rows, n) at parameter q; NaN if not on it."""
        found = np.full(len(x), np.nan)
        k = self._passing(q)
        part = self._parts(k, q)
        apart, near = self._near(self._between(k, part)[:, :-1], x, self.step[k])
        asked = near.any(axis=1)
        if not asked.any():
            return found
        k, part, apart, near = k[asked], part[asked], apart[asked], near[asked]
        hit = near & self._meets(k, part, x, q)
        best = np.argmin(np.where(hit, apart, np.inf), axis=0)
        on = hit.any(axis=0)
        found[on] = ((self.marks[k] + part * self.step[k]) / self.marks[-1])[best[on]]
        return found

    def _near(self, guess: FloatArray, x: FloatArray, step: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the distances of guesses (steps, n) from positions (rows, n), and whether they may be the same."""
        apart = np.linalg.norm(guess[:, None] - x, axis=2)
        return apart, apart <= (NEAR * step + SAME)[:, None]

    def _meets(self, k: IntArray, part: FloatArray, x: FloatArray, q: float) -> BoolArray:
        """Return (steps, rows) whether the exact point of some steps at the parameter is at positions (rows, n)."""
        guess = self._between(k, part)[:, :-1]
        form = self.curve.system.quadric(self.curve.inputs(q))
        exact, good = gauss_newton.settle(lambda at, _: (form.value(at), form.slope(at)), guess, SETTLING)
        corrected = np.where(good[:, None], exact, guess)
        room = np.where(good, SAME, NEAR * self.step[k])
        return np.asarray(np.linalg.norm(corrected[:, None] - x, axis=2) <= room[:, None])

    def _passing(self, q: float) -> IntArray:
        """Return the steps in which the parameter passes a value, or comes close to it, as at a fold."""
        change = np.diff(self.p[:, -1])
        near = self._away(self.p[:-1, -1], q)
        ahead = near + change
        passed = (near > 0.0) != (ahead > 0.0)
        close = np.minimum(np.abs(near), np.abs(ahead)) <= np.abs(change)
        return np.flatnonzero(passed | close)

    def _parts(self, k: IntArray, q: float) -> FloatArray:
        """Return the fractions of some steps at which the parameter has a value."""
        near, change = self._away(self.p[k, -1], q), self.p[k + 1, -1] - self.p[k, -1]
        return np.asarray(np.clip(np.where(change == 0.0, 0.0, -near / np.where(change == 0.0, 1.0, change)), 0.0, 1.0))

    def _away(self, q: FloatArray, wanted: float) -> FloatArray:
        """Return the differences of parameters from one, modulo the period."""
        change = q - wanted
        return change - self.period * np.round(change / self.period) if math.isfinite(self.period) else change

    def _between(self, k: IntArray, part: FloatArray) -> FloatArray:
        """Return points (steps, n + 1) on the cubics between the points before and after some steps."""
        h, n = self.step[k, None], k + 1
        return hermite(self.p[k], h * self.tangent[k], self.p[n], h * self.tangent[n], part[:, None])
