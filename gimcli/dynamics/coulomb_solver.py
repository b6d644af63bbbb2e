"""Reactions with dry friction: x = known + sum of sense_k phi_k reach_k, where phi_k = max |w . x| of pair k.

The friction forces phi are the unknowns of the iteration, one for each pair. Where T, the matrix of phi_j(reach_k), has
a spectral radius below 1, the equations contract: they have exactly one solution for any directions of sliding. This is
proved by v = (I - T)^-1 1 > 0 (a nonsingular M-matrix; Berman & Plemmons 1994, chapter 6). The iteration, a Newton step
where it reduces the error and a step of the contraction otherwise, then converges. Elsewhere Newton's method runs from
many starts, and the number of different solutions is the outcome: no proof that there are no others. The outcome of
each row is a `FrictionStatus`, with the message that the user reads.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from gimcli.connected import unlike
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray
from gimcli.status import Status


class FrictionStatus(IntEnum):
    """What dry friction leaves of the forces in one row; a later one prevails."""

    SLIDING = 0, "sliding", "all pairs with dry friction slide"
    STANDSTILL = (
        1,
        "standstill",
        "a pair with dry friction does not slide there, so its friction is not determined; forces that depend on it are"
        " empty, INPUT.effort.least and .greatest are limits of the effort; with another number of steps the rows are"
        " elsewhere",
    )
    SEVERAL = 2, Status.SEVERAL_SOLUTIONS.word, Status.SEVERAL_SOLUTIONS.text, Status.SEVERAL_SOLUTIONS
    NO_SOLUTION = 3, Status.NO_SOLUTION.word, Status.NO_SOLUTION.text, Status.NO_SOLUTION
    NOT_CONVERGED = (
        4,
        Status.NOT_CONVERGED.word,
        "the iteration for dry friction did not converge: use another number of steps",
        Status.NOT_CONVERGED,
    )

    word: str  # in the status column
    text: str  # a message with the correction
    status: Status  # of a row without forces; OK where there are forces, or limits of them

    def __new__(cls, value: int, word: str, text: str, status: Status = Status.OK) -> FrictionStatus:
        """Make a member with its word, message and status."""
        own = int.__new__(cls, value)
        own._value_, own.word, own.text, own.status = value, word, text, status
        return own


SELF_LOCKING = "self-locking"
"""Word in the column `friction.state` for a row in which friction holds the mechanism against its loads."""


CLOSE = 1e-13
"""Error of the friction forces at the end of the iteration, relative to the largest."""
FOUND = 1e-10
"""Error below which the end of an iteration is a solution; several solutions differ by more than its square root."""
MOST_STEPS = 400
"""Most steps of the contraction; Newton steps converge in a few."""
MOST_NEWTON = 30
"""Most Newton steps from a start; quadratic convergence takes about six."""
SHARES = (1.0, 0.4, 0.1)
"""Parts of a Newton step that are tried."""
STARTS = 64
"""Starts where the equations do not contract."""


@dataclass(frozen=True)
class FrictionSystem:
    """The equations of rows: reactions without friction, and the reactions to a unit friction of each pair."""

    known: FloatArray  # (rows, unknowns)
    reach: FloatArray  # (rows, unknowns, pairs)
    forms: ComplexArray  # (FORMS, pairs, unknowns) the vectors w

    def rows(self, chosen: NDArray[np.intp]) -> FrictionSystem:
        """Return some of the rows."""
        return FrictionSystem(self.known[chosen], self.reach[chosen], self.forms)

    def friction(self, x: FloatArray) -> FloatArray:
        """Return the limit of the friction of each pair for reactions (rows, unknowns): (rows, pairs)."""
        return np.asarray(np.max(np.abs(np.einsum("gkn,rn->rgk", self.forms, x)), axis=1))


def solve_friction(system: FrictionSystem, senses: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the reactions for directions of sliding `senses` (rows, pairs), 1 or -1 each.

    They are the least and the greatest over the solutions that were found (rows, unknowns), NaN without a solution;
    and the FrictionStatus (rows,).
    """
    gain = np.einsum("gjn,rnk->rgjk", system.forms, system.reach) * senses[:, None, None, :]
    reduced = _Reduced(np.einsum("gjn,rn->rgj", system.forms, system.known), gain)
    good = np.all(np.isfinite(system.known), axis=1) & np.all(np.isfinite(system.reach), axis=(1, 2))
    weights = _contraction_weights(reduced.gains, good)
    proved = np.all(weights > 0.0, axis=1)
    found, codes = np.full((2, *system.known.shape), np.nan), np.zeros(len(senses), dtype=np.int64)
    sure, rest = np.flatnonzero(good & proved), np.flatnonzero(good & ~proved)
    if len(sure):
        phi, codes[sure] = _contracted(reduced.rows(sure), weights[sure])
        found[:, sure] = system.known[sure] + np.einsum("rnk,rk->rn", system.reach[sure], senses[sure] * phi)
    for row, ends in zip(rest, _searched(reduced.rows(rest)) if len(rest) else (), strict=True):
        codes[row] = _COUNTED[min(len(ends), 2)]
        if len(ends):
            x = system.known[row] + (senses[row] * ends) @ system.reach[row].T
            found[:, row] = x.min(axis=0), x.max(axis=0)
    return found[0], found[1], codes


_COUNTED = (FrictionStatus.NO_SOLUTION, FrictionStatus.SLIDING, FrictionStatus.SEVERAL)
"""Status by the number of solutions: none, one, several."""


@dataclass(frozen=True)
class _Reduced:
    """phi = max |base + gain (phi)|: the equations in the friction forces alone."""

    base: ComplexArray  # (rows, FORMS, pairs)
    gain: ComplexArray  # (rows, FORMS, pairs, pairs), with the directions of sliding

    @property
    def gains(self) -> FloatArray:
        """The matrix T (rows, pairs, pairs)."""
        return np.asarray(np.max(np.abs(self.gain), axis=1))

    def rows(self, chosen: NDArray[np.intp]) -> _Reduced:
        """Return some of the rows."""
        return _Reduced(self.base[chosen], self.gain[chosen])

    def limits(self, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the limits of friction for friction forces phi (rows, pairs), and their derivatives by phi."""
        force = self.base + np.einsum("rgjk,rk->rgj", self.gain, phi)
        size = np.abs(force)
        which = np.argmax(size, axis=1)[:, None, :]
        own, largest = np.take_along_axis(force, which, 1)[:, 0], np.take_along_axis(size, which, 1)[:, 0]
        unit = np.divide(own, largest, out=np.zeros_like(own), where=largest > 0.0)  # 0: friction of an unloaded pair
        gain = np.take_along_axis(self.gain, which[..., None], 1)[:, 0]
        return largest, (unit.conj()[..., None] * gain).real

    def newton(self, phi: FloatArray, value: FloatArray, slope: FloatArray) -> FloatArray:
        """Return the next iterate of Newton's method."""
        return phi - _solved(np.eye(phi.shape[1]) - slope, phi - value)


def _contraction_weights(gains: FloatArray, good: BoolArray) -> FloatArray:
    """Return v = (I - T)^-1 1 (rows, pairs); the equations contract where all are positive."""
    usable = np.where(good[:, None, None], gains, np.inf)
    matrix = np.eye(gains.shape[1]) - np.where(np.isfinite(usable), usable, 2.0)
    return np.nan_to_num(_solved(matrix, np.ones(gains.shape[:2])), nan=-1.0)


def _contracted(reduced: _Reduced, weights: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the only solution of each row, where the equations contract."""
    phi = reduced.limits(np.zeros(weights.shape))[0]
    value, slope = reduced.limits(phi)
    error = np.max(np.abs(phi - value) / weights, axis=1)
    for _ in range(MOST_STEPS):
        if np.all(np.abs(phi - value) <= CLOSE * np.max(phi, axis=1, keepdims=True)):
            break
        trial = reduced.newton(phi, value, slope)
        quick = np.max(np.abs(trial - reduced.limits(trial)[0]) / weights, axis=1) < 0.5 * error
        phi = np.where(quick[:, None], trial, value)
        value, slope = reduced.limits(phi)
        error = np.max(np.abs(phi - value) / weights, axis=1)
    wrong = np.any(np.abs(phi - value) > FOUND * np.max(phi, axis=1, keepdims=True), axis=1)
    return phi, np.where(wrong, int(FrictionStatus.NOT_CONVERGED), int(FrictionStatus.SLIDING))


def _searched(reduced: _Reduced) -> list[FloatArray]:
    """Return the different solutions (found, pairs) of each row from many starts."""
    rows, pairs = len(reduced.base), reduced.base.shape[2]
    first = reduced.limits(np.zeros((rows, pairs)))[0]
    starts = np.concatenate([first[:, None], _starts(reduced)], axis=1)
    count = starts.shape[1]
    ends, solved = _newton_ends(reduced.rows(np.repeat(np.arange(rows), count)), starts.reshape(-1, pairs))
    ends, solved = ends.reshape(rows, count, pairs), solved.reshape(rows, count)
    idle = ~np.any(first, axis=1)  # without forces there is no friction
    return [np.zeros((1, pairs)) if idle[k] else _different(ends[k][solved[k]]) for k in range(rows)]


def _starts(reduced: _Reduced) -> FloatArray:
    """Return starts (rows, STARTS, pairs): friction forces for given directions of the reactions of all pairs.

    With given directions the equations are linear. The first starts have all combinations of signs, so that those of
    sliding pairs, whose reactions have only two directions, are complete for a few pairs.
    """
    rows, forms, pairs = reduced.base.shape
    random = np.random.default_rng(1)
    number = np.arange(STARTS)[:, None]
    bits = np.where(number < 2**pairs, number >> np.arange(pairs), random.integers(0, 2, (STARTS, pairs))) & 1
    signs = 1.0 - 2.0 * bits
    turned = np.any(reduced.gain.imag != 0.0, axis=(0, 1, 3)) | np.any(reduced.base.imag != 0.0, axis=(0, 1))
    units = signs * np.exp(1j * np.pi * np.where(turned, random.uniform(0.0, 1.0, (STARTS, pairs)), 0.0))
    several = np.any(reduced.gain[:, -1] != 0.0, axis=(0, 2))  # pairs with a second vector w
    which = np.where(several, random.integers(0, forms, (STARTS, pairs)), 0)
    own = np.arange(pairs)
    base, gain = reduced.base[:, which, own], reduced.gain[:, which, own]
    matrix = np.eye(pairs) - (units.conj()[..., None] * gain).real
    found = _solved(matrix.reshape(-1, pairs, pairs), (units.conj() * base).real.reshape(-1, pairs))
    return np.abs(np.nan_to_num(found, posinf=0.0, neginf=0.0)).reshape(rows, STARTS, pairs)


def _different(ends: FloatArray) -> FloatArray:
    """Return the solutions that differ by more than the error of the iteration (found, pairs)."""
    kept = unlike(ends, lambda end, other: not np.max(np.abs(end - other)) > np.sqrt(FOUND) * np.max(end))
    return np.array(kept).reshape(-1, ends.shape[1])


def _newton_ends(reduced: _Reduced, phi: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return where Newton's method with shortened steps ends from starts (starts, pairs), and which ends solve."""
    phi, solved = phi.copy(), np.zeros(len(phi), dtype=bool)
    active = np.arange(len(phi))
    for _ in range(MOST_NEWTON):
        own = reduced.rows(active)
        value, slope = own.limits(phi[active])
        size = np.max(np.abs(phi[active]), axis=1)
        done = np.max(np.abs(phi[active] - value), axis=1) <= CLOSE * size
        solved[active[done]] = np.all(phi[active[done]] >= -FOUND * size[done, None], axis=1)
        left = ~done & np.all(np.isfinite(phi[active]), axis=1)
        if not left.any():
            break
        own, active = own.rows(np.flatnonzero(left)), active[left]
        phi[active] = _shortened(own, phi[active], value[left], slope[left])
    return phi, solved


def _shortened(reduced: _Reduced, phi: FloatArray, value: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the first of the Newton steps, whole and shortened, that reduces the error, else the best of them."""
    step, error = reduced.newton(phi, value, slope) - phi, np.linalg.norm(phi - value, axis=1)
    best, least = phi.copy(), np.full(len(phi), np.inf)
    for share in SHARES:
        trial = phi + share * step
        own = np.linalg.norm(trial - reduced.limits(trial)[0], axis=1)
        better = (own < least) & ~(least < 0.9 * error)
        best[better], least[better] = trial[better], own[better]
    return best


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solutions (rows, n) of linear equations; NaN where a matrix (rows, n, n) is singular."""
    with np.errstate(all="ignore"):
        try:
            return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
        except np.linalg.LinAlgError:
            found = np.full(right.shape, np.nan)
            for k in np.flatnonzero(np.linalg.det(matrix)):
                found[k] = np.linalg.solve(matrix[k], right[k])
            return found
