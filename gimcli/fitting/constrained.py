"""Least errors or goals under conditions: sequential quadratic programming from a given design.

Gradients are exact; conditions and goals are extremes over a motion, which have no derivative where another row becomes
the extreme. Those of quantities without exact derivatives are differences, computed for all dimensions in one call.
Source: Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28 (1988): SLSQP of SciPy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from gimcli.fitting.conditions import DesignQuantities
from gimcli.fitting.least_squares import EXACT, FitProblem, Trials, joined, trials
from gimcli.fitting.starts import moves
from gimcli.fitting.targets import FREE, GIVEN, TURN
from gimcli.language.expression import Expression
from gimcli.mechanism import FloatArray
from gimcli.quantities.state import ApartError


@dataclass(frozen=True)
class ConstrainedConstants:
    """Constants of the optimisation; unknowns are relative to their bounds, inputs in rad or normal lengths."""

    steps: int = 200
    unit: float = 1e-6  # least unit of errors, relative to the sum of squares of the targets about their mean
    accuracy: float = 1e-13  # of the error, relative to that of the start
    difference: float = 1e-6  # step of differences
    most: int = 15  # trials that are moved
    alike: float = 1e-3  # relative difference of errors of the same minimum
    beyond: float = 1e3  # value in place of one that is not defined, relative to that of the start


CONSTANTS = ConstrainedConstants()

TINY = float(np.finfo(float).tiny)


class Rated(NamedTuple):
    """A function of unknowns with its slopes, which are asked for after the values, if at all."""

    values: Callable[[FloatArray], Any]
    slopes: Callable[[FloatArray], FloatArray]


def constrained_fit(problem: FitProblem, quantities: DesignQuantities, start: Trials) -> Trials:
    """Return the trial with the least error that satisfies the inequalities, from one trial; none if it fails."""
    span, dimensions = problem.upper - problem.lower, len(problem.lower)
    scale = np.concatenate((span, np.ones(start.own.shape[1])))
    base = np.concatenate((problem.lower, np.zeros(start.own.shape[1])))

    def error(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        at = base + scale * x
        value, gradient = _error(problem, at[None, :dimensions], at[None, dimensions:])
        return np.array([value]), gradient[None] * scale

    margins = _rated(quantities, quantities.margins, problem.lower, problem.upper)
    conditions = [_inequality(margins)]
    if problem.targets.timing == FREE and start.sense[0]:
        conditions.append(_inequality(_order(problem, dimensions, float(start.sense[0]))))
    first = (np.concatenate((start.designs[0], start.own[0])) - base) / scale
    limits = problem.targets.range
    ends = (limits.low, limits.high) if problem.targets.timing == FREE and not limits.turning else (None, None)
    unit = CONSTANTS.unit / EXACT * problem.zero
    found = base + scale * _least(
        _remembered(error), conditions, first, np.where(problem.periodic, np.inf, 1.0), unit, ends
    )
    return trials(problem, found[None, :dimensions], found[None, dimensions:], start.sense)


def constrained_goal(
    quantities: DesignQuantities, design: FloatArray, lower: FloatArray, upper: FloatArray
) -> FloatArray:
    """Return the design (dimensions,) with the least goal that satisfies the inequalities, from one design."""
    span = upper - lower
    goal = _rated(quantities, quantities.goals, lower, upper)
    margins = [_inequality(_rated(quantities, quantities.margins, lower, upper))] if quantities.margins else []
    return np.asarray(lower + span * _least(goal, margins, (design - lower) / span, np.ones(len(span)), TINY))


def under_conditions(problem: FitProblem, quantities: DesignQuantities, found: Trials) -> Trials:
    """Return the trials that satisfy all conditions, sorted; better ones that do not are moved until they do."""
    held = quantities.hold(found.designs)
    good, others = found[held], found[~held].best(len(found))
    parts, last, limit = [good], -np.inf, float(np.min(good.error, initial=np.inf))
    for k in range(len(others)) if quantities.margins else ():
        if others.error[k] >= limit or len(parts) > CONSTANTS.most or problem.stop():
            break
        if others.error[k] > last * (1.0 + CONSTANTS.alike) + problem.zero:
            last = float(others.error[k])
            parts.append(constrained_fit(problem, quantities, others[k : k + 1]))
    moved = joined(parts[1:]) if len(parts) > 1 else found[:0]
    moved = moved[quantities.hold(moved.designs) & moves(problem, moved.designs)]
    return joined([good, moved]).best(len(found))


def _rated(
    quantities: DesignQuantities, expressions: Sequence[Expression], lower: FloatArray, upper: FloatArray
) -> Rated:
    """Return numbers of designs as a function of unknowns, the first of which are dimensions relative to the bounds."""
    span, dimensions = upper - lower, len(lower)

    def values(x: FloatArray) -> FloatArray:
        return np.asarray(quantities.numbers(expressions, (lower + span * x[:dimensions])[None])[0])

    def slopes(x: FloatArray) -> FloatArray:
        design = lower + span * x[:dimensions]
        found, defined = np.full((len(expressions), dimensions), np.nan), np.isfinite(values(x))
        with suppress(ApartError):
            found = quantities.slopes(expressions, design)
        if not np.isfinite(found[defined]).all():  # of measures along the path, or at a dead point in some row
            found = _differences(partial(quantities.numbers, expressions), design, lower, upper)
        return np.pad(found * span, ((0, 0), (0, len(x) - dimensions)))

    return Rated(values, slopes)


def _remembered(function: Callable[[FloatArray], tuple[FloatArray, FloatArray]]) -> Rated:
    """Return a function that has values and slopes together."""
    found = lru_cache(1)(lambda key: function(np.frombuffer(key)))
    return Rated(lambda x: found(x.tobytes())[0], lambda x: found(x.tobytes())[1])


def _least(
    function: Rated,
    conditions: list[dict[str, Any]],
    first: FloatArray,
    most: FloatArray,
    unit: float,
    ends: tuple[float | None, float | None] = (None, None),
) -> FloatArray:
    """Return the unknowns with the least value of a function.

    `most`: the first unknowns are between 0 and these, or free where these are infinite; the others are between
    `ends`. `unit`: least unit of the values, in which they are compared.
    """
    from scipy.optimize import minimize

    unit, dimensions = max(abs(float(function.values(first)[0])), unit, TINY), len(most)

    def scaled(x: FloatArray) -> float:
        found = float(function.values(x)[0])
        return found / unit if np.isfinite(found) else CONSTANTS.beyond

    bounds = [(0.0, 1.0) if np.isfinite(m) else (None, None) for m in most] + [ends] * (len(first) - dimensions)
    options = {"maxiter": CONSTANTS.steps, "ftol": CONSTANTS.accuracy}
    found = minimize(
        scaled, first, jac=lambda x: np.nan_to_num(function.slopes(x)[0], posinf=0.0, neginf=0.0) / unit,
        bounds=bounds, constraints=conditions, method="SLSQP", options=options,
    )  # fmt: skip
    x = np.asarray(found.x, dtype=float)
    x[:dimensions] = np.where(np.isfinite(most), np.clip(x[:dimensions], 0.0, 1.0), x[:dimensions])
    return np.asarray(x)


def _inequality(function: Rated) -> dict[str, Any]:
    """Return a condition of SciPy: the values of a function are not negative."""
    return {
        "type": "ineq",
        "fun": lambda x: np.nan_to_num(function.values(x), nan=-CONSTANTS.beyond),
        "jac": lambda x: np.nan_to_num(function.slopes(x), posinf=0.0, neginf=0.0),
    }


def _order(problem: FitProblem, dimensions: int, sense: float) -> Rated:
    """Return the condition that the inputs of the targets follow each other in a sense, within one turn."""
    count = len(problem.targets.values)
    matrix = sense * (np.eye(count, k=1) - np.eye(count))[:-1]
    constant = np.zeros(count - 1)
    if problem.targets.range.turning:
        matrix = np.concatenate((matrix, -matrix.sum(axis=0, keepdims=True)))
        constant = np.append(constant, TURN)
    slopes = np.concatenate((np.zeros((len(matrix), dimensions)), matrix), axis=1)
    return Rated(lambda x: np.asarray(matrix @ x[dimensions:] + constant), lambda x: slopes)


def _error(problem: FitProblem, design: FloatArray, own: FloatArray) -> tuple[float, FloatArray]:
    """Return the sum of squares of one design, and its gradient by the dimensions and the unknown inputs."""
    rates = problem.quantity.rates(design, problem.inputs(design, own))
    weights, residual = problem.targets.weights, problem.targets.residuals(rates.values)
    weighted = 2.0 * residual * weights
    by_dimension = np.einsum("nmc,nmci->i", weighted, rates.by_dimension)
    by_input = np.einsum("nmc,nmc->m", weighted, rates.by_input)
    timing = problem.targets.timing
    by_own = by_input if timing == FREE else by_input[:0] if timing == GIVEN else by_input.sum(keepdims=True)
    return float(np.sum(residual**2)), np.concatenate((by_dimension, by_own))


def _differences(
    function: Callable[[FloatArray], FloatArray], design: FloatArray, lower: FloatArray, upper: FloatArray
) -> FloatArray:
    """Return the slopes (values, dimensions) of a function of designs, by differences."""
    step = CONSTANTS.difference * (upper - lower)
    step = np.where(design + step > upper, -step, step)
    values = function(np.concatenate((design[None], design + np.diag(step))))
    return np.asarray(((values[1:] - values[0]) / step[:, None]).T)
