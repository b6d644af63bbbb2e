"""Levenberg-Marquardt of many designs at once, with bounds and with an unknown input of each target.

Each target depends on its own input only, so the inputs are eliminated from the normal equations (Schur complement).
Dimensions at a bound towards which the error decreases are held there. A step that puts the targets out of order, or
that cannot be assembled, is rejected like one that increases the error.
Sources: Marquardt, J. SIAM 11 (1963) 431, for the scaling of the damping; Kanzow, Yamashita & Fukushima, J. Comput.
Appl. Math. 172 (2004) 375, for projected steps.

Dimensions are not determined by targets if a change of these, with other inputs, leaves all differences.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gimcli.fitting.motion_quantity import MotionQuantity, QuantityRates
from gimcli.fitting.targets import FREE, GIVEN, Targets
from gimcli.mechanism import FloatArray
from gimcli.progress import WorkLimit

FLAT = 1e-8
"""Singular values below this, relative to the greatest, are zero; dimensions are relative to their bounds."""

PART = 1e-3
"""Least component of a dimension in a direction without effect."""


def undetermined(problem: FitProblem, best: Trials, design: FloatArray, names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the dimensions that the targets do not determine at a design (dimensions,) of some trials."""
    at = best[np.flatnonzero((best.designs == design).all(axis=1))[:1]]
    rates = problem.quantity.rates(at.designs, problem.inputs(at.designs, at.own))
    weights, limits = problem.targets.weights, problem.targets.range
    by_input = (rates.by_input * weights)[0]
    inner = (problem.least < design) & (design < problem.most)
    columns = [(rates.by_dimension[0] * weights[:, None] * (problem.upper - problem.lower)).reshape(-1, len(design))]
    if problem.targets.timing == FREE:
        slope = np.sum(by_input * problem.targets.residuals(rates.values)[0], axis=1)
        held = np.abs(slope) > FLAT * np.sum(by_input**2, axis=1)  # at an end of the law, and would move on
        inside = limits.turning | ((at.own[0] > limits.low) & (at.own[0] < limits.high)) | ~held
        own = np.eye(len(by_input))[:, None] * (by_input * inside[:, None])[..., None]
        columns.append(own.reshape(-1, len(by_input)))
    elif problem.targets.timing != GIVEN:
        columns.append(by_input.reshape(-1, 1))
    matrix = np.concatenate(columns, axis=1)
    _, values, vectors = np.linalg.svd(matrix, full_matrices=True)
    rank = int(np.sum(values > FLAT * values.max(initial=0.0)))
    flat = np.max(np.abs(vectors[rank:, : len(design)]), axis=0, initial=0.0)
    return tuple(name for name, part, free in zip(names, flat, inner, strict=True) if part > PART and free)


@dataclass(frozen=True)
class MarquardtConstants:
    """Constants of the damping."""

    first: float = 1e-2  # damping of the first step, relative to the diagonal of the normal matrix
    less: float = 0.2  # factor after an accepted step
    more: float = 3.0  # factor after a rejected step
    least: float = 1e-14
    most: float = 1e12
    floor: float = 1e-12  # least diagonal element, relative to the greatest
    gain: float = 1e-11  # relative decrease of the error by a step with little damping, below which a fit has settled
    stuck: float = 1e9  # damping from which on a fit does not change
    longest: float = 0.5  # longest step of an input [rad, or length in the normal frame]


CONSTANTS = MarquardtConstants()

EXACT = 1e-27
"""An error below this, relative to the sum of squares of the targets about their mean, is zero."""


@dataclass(frozen=True, eq=False)
class FitProblem:
    """A quantity, its targets, and the bounds of the dimensions."""

    quantity: MotionQuantity
    targets: Targets
    lower: FloatArray  # (dimensions,)
    upper: FloatArray  # (dimensions,)
    periodic: NDArray[np.bool_]  # (dimensions,) directions, which may pass their bounds: these are a full turn apart
    whole: bool = True  # only designs that move through the whole range of the input
    admits: Callable[[FloatArray], NDArray[np.bool_]] | None = None  # which designs may be starts; None: all
    stop: Callable[[], bool] = WorkLimit().spend  # whether the search shall end

    @property
    def least(self) -> FloatArray:
        """The least values (dimensions,) during the fit."""
        return np.where(self.periodic, -np.inf, self.lower)

    @property
    def most(self) -> FloatArray:
        """The greatest values (dimensions,) during the fit."""
        return np.where(self.periodic, np.inf, self.upper)

    def within(self, designs: FloatArray) -> FloatArray:
        """Return designs (designs, dimensions) with the full turns removed that directions have made."""
        turn = np.where(self.periodic, self.upper - self.lower, 1.0)
        return np.where(self.periodic, self.lower + (designs - self.lower) % turn, designs)

    def inputs(self, designs: FloatArray, own: FloatArray) -> FloatArray:
        """Return the input (designs, targets) of each target; `own` (designs, unknown inputs) are added to given ones.

        The unknown inputs are those of the targets (timing "free"), one shift of all (timing "step"), or none.
        """
        given = np.broadcast_to(self.targets.inputs, (len(designs), len(self.targets.values)))
        return own if self.targets.timing == FREE else given if self.targets.timing == GIVEN else given + own

    def errors(self, designs: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the sum of squares (designs,), without its constant; infinity where a position is missing."""
        return self.squares(self.quantity.values(designs, inputs))

    def squares(self, values: FloatArray) -> FloatArray:
        """Return the sum of squares (designs,) of some values; infinity where a position is missing."""
        found = self.targets.residuals(values)
        with np.errstate(all="ignore"):
            error = np.einsum("nmc,nmc->n", found, found)
        return np.where(np.isfinite(error), error, np.inf)

    @cached_property
    def zero(self) -> float:
        """The error below which a fit is exact to rounding."""
        spread = (self.targets.values - self.targets.values.mean(axis=0)) * self.targets.weights
        with np.errstate(over="ignore"):
            return EXACT * float(np.sum(spread**2))


@dataclass(frozen=True, eq=False)
class Trials:
    """Designs that are being fitted."""

    designs: FloatArray  # (designs, dimensions) file's units
    own: FloatArray  # (designs, unknown inputs): one of each target, one shift, or none
    sense: FloatArray  # (designs,) +1 or -1: whether the inputs of the targets increase or decrease; 0: any order
    error: FloatArray  # (designs,) sum of squares
    damping: FloatArray  # (designs,)

    def __len__(self) -> int:
        return len(self.designs)

    def __getitem__(self, chosen: NDArray[np.int64] | NDArray[np.bool_] | slice) -> Trials:
        return Trials(*(part[chosen] for part in vars(self).values()))

    def best(self, count: int) -> Trials:
        """Return the trials with the least errors, sorted."""
        return self[np.argsort(self.error, kind="stable")[:count]]


def joined(parts: list[Trials]) -> Trials:
    """Return the trials of several lists as one."""
    return Trials(*(np.concatenate(column) for column in zip(*(vars(part).values() for part in parts), strict=True)))


def trials(problem: FitProblem, designs: FloatArray, own: FloatArray, sense: FloatArray) -> Trials:
    """Return trials with their errors; those that cannot be assembled are left out."""
    error = problem.errors(designs, problem.inputs(designs, own))
    return Trials(designs, own, sense, error, np.full(len(designs), CONSTANTS.first))[np.isfinite(error)]


def refined(problem: FitProblem, start: Trials, iterations: int) -> Trials:
    """Improve all trials by a number of steps; those that no longer change are left as they are."""
    at, done = start, [start[:0]]
    rates = problem.quantity.rates(at.designs, problem.inputs(at.designs, at.own))
    with np.errstate(all="ignore"):
        for _ in range(iterations):
            if not len(at) or problem.stop():
                break
            at, rates, settled = _stepped(problem, at, rates)
            if settled.any():
                done.append(at[settled])
                at, rates = at[~settled], QuantityRates(*(part[~settled] for part in rates))
    return joined([*done, at])


def _stepped(problem: FitProblem, at: Trials, rates: QuantityRates) -> tuple[Trials, QuantityRates, NDArray[np.bool_]]:
    """Return the trials after one step where this decreases the error, their rates, and which are settled."""
    designs, own = _step(problem, at, rates)
    inputs = problem.inputs(designs, own)
    new = problem.quantity.rates(designs, inputs)
    error = problem.squares(new.values)
    if problem.targets.timing == FREE:
        error = np.where((at.sense == 0.0) | problem.targets.ordered(inputs, at.sense), error, np.inf)
    good = error < at.error
    damping = np.clip(at.damping * np.where(good, CONSTANTS.less, CONSTANTS.more), CONSTANTS.least, CONSTANTS.most)
    small = good & (at.error - error <= CONSTANTS.gain * at.error) & (damping < CONSTANTS.first)
    after = replace(
        at, designs=np.where(good[:, None], designs, at.designs), own=np.where(good[:, None], own, at.own),
        error=np.where(good, error, at.error), damping=damping,
    )  # fmt: skip
    kept = (np.where(good.reshape(-1, *[1] * (n.ndim - 1)), n, o) for n, o in zip(new, rates, strict=True))
    return after, QuantityRates(*kept), small | (damping >= CONSTANTS.stuck) | (after.error <= problem.zero)


def _step(problem: FitProblem, at: Trials, rates: QuantityRates) -> tuple[FloatArray, FloatArray]:
    """Return the designs and the unknown inputs after one step."""
    targets, place, lower, upper = problem.targets, at.designs, problem.least, problem.most
    residual, by_input = targets.residuals(rates.values), rates.by_input * targets.weights
    jacobian = rates.by_dimension * targets.weights[:, None]
    if targets.timing not in (FREE, GIVEN):  # the shift is one more dimension, without bounds
        jacobian = np.concatenate((jacobian, by_input[..., None]), axis=-1)
        place = np.concatenate((place, at.own), axis=1)
        lower, upper = np.append(lower, -np.inf), np.append(upper, np.inf)
    gradient = np.einsum("nmci,nmc->ni", jacobian, residual)
    held = ((place <= lower) & (gradient > 0.0)) | ((place >= upper) & (gradient < 0.0))
    flat = jacobian.reshape(len(at), -1, place.shape[1])
    matrix = flat.transpose(0, 2, 1) @ flat
    diagonal = np.einsum("nii->ni", matrix)
    added = at.damping[:, None] * (diagonal + CONSTANTS.floor * diagonal.max(axis=1, keepdims=True))
    if targets.timing != FREE:
        moved = np.clip(place + _solved(matrix, added, -gradient, held), lower, upper)
        return moved[:, : at.designs.shape[1]], moved[:, at.designs.shape[1] :]
    slope = np.einsum("nmc,nmc->nm", by_input, residual)
    if not targets.range.turning:  # inputs at an end of the law, beyond which the error decreases, are held
        beyond = ((at.own <= targets.range.low) & (slope > 0.0)) | ((at.own >= targets.range.high) & (slope < 0.0))
        by_input, slope = np.where(beyond[..., None], 0.0, by_input), np.where(beyond, 0.0, slope)
    own = np.einsum("nmc,nmc->nm", by_input, by_input) * (1.0 + at.damping[:, None]) + np.finfo(float).tiny
    mixed = np.einsum("nmci,nmc->nmi", jacobian, by_input)
    reduced = matrix - mixed.transpose(0, 2, 1) @ (mixed / own[..., None])
    right = np.einsum("nmi,nm->ni", mixed, slope / own) - gradient
    moved = np.clip(place + _solved(reduced, added, right, held), lower, upper)
    change = (-slope - np.einsum("nmi,ni->nm", mixed, moved - place)) / own
    inputs = at.own + np.clip(change, -CONSTANTS.longest, CONSTANTS.longest)
    return moved, inputs if targets.range.turning else np.clip(inputs, targets.range.low, targets.range.high)


def _solved(matrix: FloatArray, added: FloatArray, right: FloatArray, held: NDArray[np.bool_]) -> FloatArray:
    """Return the solutions of normal equations with damping `added`; held unknowns do not change."""
    diagonal = np.arange(matrix.shape[1])
    free = np.logical_not(held)
    matrix = matrix * np.einsum("ni,nj->nij", free, free)
    matrix[:, diagonal, diagonal] += added + held
    good = np.asarray(np.isfinite(matrix).all(axis=(1, 2)) & (matrix[:, diagonal, diagonal] > 0.0).all(axis=1))
    matrix[~good] = np.eye(matrix.shape[1])
    try:
        found = np.linalg.solve(matrix, (right * free)[..., None])[..., 0]
    except np.linalg.LinAlgError:  # singular to rounding: a little more damping
        matrix[:, diagonal, diagonal] *= 1.0 + 1e-9
        found = np.linalg.solve(matrix, (right * free)[..., None])[..., 0]
    return np.where(good[:, None] & np.isfinite(found), found, 0.0)
