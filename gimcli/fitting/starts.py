"""Starts of a fit: random designs and orders of their targets, with the linear dimensions solved exactly.

Positions are linear in some dimensions, such as the place of the frame or of a coupler point. For a given design and
given inputs the best values of these follow from one linear least-squares problem, so only the others are drawn at
random (variable projection, Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimcli.fitting.least_squares import FitProblem, Trials, trials
from gimcli.fitting.motion_quantity import MotionQuantity
from gimcli.fitting.targets import FREE, GIVEN, TURN
from gimcli.mechanism import FloatArray


@dataclass(frozen=True)
class StartConstants:
    """Constants of the random starts."""

    rows: int = 72  # positions of a design, between which the inputs of the targets are chosen
    choices: int = 48  # choices of inputs for each design
    evenness: float = 2.0  # parameter of the Dirichlet distribution of the steps between targets
    wide: float = 10.0  # bounds of a greater ratio are also sampled on a logarithmic scale
    decades: float = 1e-3  # least value of a logarithmic sample relative to the upper bound
    part: float = 0.1  # change of a dimension, relative to its bounds, that shows whether positions are linear in it
    alike: float = 1e-7  # relative difference of equal derivatives
    ridge: float = 1e-9  # relative to the trace: linear dimensions without effect keep their values


CONSTANTS = StartConstants()


def linear_dimensions(
    quantity: MotionQuantity, nominal: FloatArray, lower: FloatArray, upper: FloatArray, inputs: FloatArray
) -> NDArray[np.int64]:
    """Return the places of dimensions in which a quantity is linear together: no derivative depends on another."""
    changes = np.diag(CONSTANTS.part * (upper - lower))
    designs = np.concatenate((nominal[None], nominal + changes))
    slopes = quantity.rates(designs, np.tile(inputs, (len(designs), 1))).by_dimension
    size = np.max(np.abs(slopes[0]), axis=(0, 1))
    with np.errstate(invalid="ignore"):
        same = np.max(np.abs(slopes[1:] - slopes[0]), axis=(1, 2)) <= CONSTANTS.alike * size  # (changed, derivative)
    chosen: list[int] = []
    for k in np.flatnonzero((lower < upper) & (size > 0.0)).tolist():
        if all(same[k, j] and same[j, k] for j in (*chosen, k)):
            chosen.append(k)
    return np.array(chosen, dtype=np.int64)


def periodic_dimensions(
    quantity: MotionQuantity, nominal: FloatArray, lower: FloatArray, upper: FloatArray, inputs: FloatArray
) -> NDArray[np.bool_]:
    """Return which dimensions (dimensions,) have the same effect at both bounds: directions that turn fully.

    A fit may pass their bounds.
    """
    count = len(nominal)
    designs = np.tile(nominal, (2, count, 1))
    designs[0, range(count), range(count)], designs[1, range(count), range(count)] = lower, upper
    ends = quantity.values(designs.reshape(2 * count, count), np.tile(inputs, (2 * count, 1)))
    one, other = ends[:count], ends[count:]
    with np.errstate(invalid="ignore"):
        same = np.max(np.abs(one - other), axis=(1, 2)) <= CONSTANTS.alike * np.max(np.abs(one), axis=(1, 2))
    return np.asarray(same & (lower < upper))


def random_designs(lower: FloatArray, upper: FloatArray, count: int, generator: np.random.Generator) -> FloatArray:
    """Return designs (count, dimensions) within bounds; half of them have lengths of a wide range on a log scale."""
    designs = generator.uniform(lower, upper, (count, len(lower)))
    least = np.maximum(lower, CONSTANTS.decades * upper)
    wide = (lower >= 0.0) & (upper > CONSTANTS.wide * lower) & (upper > 0.0)
    logarithmic = np.exp(generator.uniform(np.log(least[wide]), np.log(upper[wide]), (count, int(wide.sum()))))
    half = generator.random(count) < 0.5
    designs[np.ix_(half, wide)] = logarithmic[half]
    return np.asarray(designs)


def starts(
    problem: FitProblem, designs: FloatArray, linear: NDArray[np.int64], generator: np.random.Generator
) -> Trials:
    """Return the best of several choices of inputs for each design; designs that cannot be assembled are left out."""
    if problem.whole:
        designs = designs[moves(problem, designs)]
    if problem.admits is not None:
        designs = designs[problem.admits(designs)]
    targets = problem.targets
    grid = targets.inputs if targets.timing == GIVEN else targets.range.grid(CONSTANTS.rows)
    rates = problem.quantity.rates(designs, np.tile(grid, (len(designs), 1)))
    if targets.timing == FREE:
        reached = np.cumprod(np.isfinite(rates.values).all(axis=2), axis=1).sum(axis=1)
        places, sense = _free_places(problem, reached, generator)
    elif targets.timing == GIVEN:
        places = np.zeros((len(designs), 1, len(grid)), dtype=np.int64) + np.arange(len(grid))
        sense = np.zeros((len(designs), 1))
    else:
        places, sense = _shifted_places(problem, len(designs), generator)
    fitted, errors = _linear_fits(problem, designs, rates.values, rates.by_dimension[..., linear], linear, places)
    every, best = np.arange(len(designs)), np.argmin(errors, axis=1)
    own = _own_inputs(problem, grid[places[every, best]], sense[every, best])
    good = np.isfinite(errors[every, best])
    senses = sense[every, best][good] * targets.in_order
    return trials(problem, fitted[every, best][good], own[good], senses)


def _own_inputs(problem: FitProblem, inputs: FloatArray, sense: FloatArray) -> FloatArray:
    """Return the unknown inputs (designs, unknown inputs) for which the targets have some inputs."""
    targets = problem.targets
    if targets.timing == FREE:
        return _unwrapped(inputs, sense) if targets.range.turning else inputs
    return np.zeros((len(inputs), 0)) if targets.timing == GIVEN else inputs[:, :1] - targets.inputs[0]


def moves(problem: FitProblem, designs: FloatArray) -> NDArray[np.bool_]:
    """Return which designs (designs,) can be assembled at all inputs of the range."""
    grid = problem.targets.range.grid(CONSTANTS.rows)
    found = problem.quantity.values(designs, np.tile(grid, (len(designs), 1)))
    return np.asarray(np.isfinite(found).all(axis=(1, 2)))


def _free_places(
    problem: FitProblem, reached: NDArray[np.int64], generator: np.random.Generator
) -> tuple[NDArray[np.int64], FloatArray]:
    """Return ordered places (designs, choices, targets) on the reached rows of the grid, and their senses."""
    count, targets = len(reached), len(problem.targets.values)
    shape = (count, CONSTANTS.choices)
    sense = np.where(generator.random(shape) < 0.5, 1.0, -1.0)
    gaps = generator.dirichlet(np.full(targets + 1, CONSTANTS.evenness), shape)
    along = np.cumsum(gaps, axis=2)[..., :targets]
    turns = (reached == CONSTANTS.rows) & problem.targets.range.turning
    whole = generator.random(shape)[..., None] + sense[..., None] * along
    arc = np.where(sense[..., None] > 0.0, along, 1.0 - along)
    fraction = np.where(turns[:, None, None], whole % 1.0, arc)
    last = np.where(turns, CONSTANTS.rows, np.maximum(reached, 1))[:, None, None]
    return np.minimum((fraction * last).astype(np.int64), last - 1), sense


def _shifted_places(
    problem: FitProblem, count: int, generator: np.random.Generator
) -> tuple[NDArray[np.int64], FloatArray]:
    """Return places (designs, choices, targets) whose inputs have the given differences."""
    limits, steps = problem.targets.range, problem.targets.inputs - problem.targets.inputs[0]
    low, high = (limits.low, limits.high) if limits.turning else (limits.low - steps.min(), limits.high - steps.max())
    first = generator.uniform(min(low, high), high, (count, CONSTANTS.choices, 1))
    return limits.nearest(first + steps, CONSTANTS.rows), np.zeros((count, CONSTANTS.choices))


def _unwrapped(inputs: FloatArray, sense: FloatArray) -> FloatArray:
    """Return inputs (designs, targets) with whole turns added, so that they follow each other in a sense."""
    steps = np.diff(inputs, axis=1) * sense[:, None] % TURN * sense[:, None]
    return np.concatenate((inputs[:, :1], inputs[:, :1] + np.cumsum(steps, axis=1)), axis=1)


def _linear_fits(
    problem: FitProblem, designs: FloatArray, values: FloatArray, slopes: FloatArray, linear: NDArray[np.int64],
    places: NDArray[np.int64],
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return the designs (designs, choices, dimensions) with the best linear dimensions, and their errors."""
    every = np.arange(len(designs))[:, None, None]
    residual = problem.targets.residuals(values[every, places])
    count, choices, rows = (*residual.shape[:2], residual.shape[2] * residual.shape[3])
    flat = residual.reshape(count, choices, rows)
    fitted = np.repeat(designs[:, None], choices, axis=1)
    if len(linear):
        matrix = (slopes * problem.targets.weights[:, None])[every, places].reshape(count, choices, rows, len(linear))
        normal = np.einsum("nkri,nkrj->nkij", matrix, matrix)
        normal += CONSTANTS.ridge * np.trace(normal, axis1=2, axis2=3)[..., None, None] * np.eye(len(linear))
        right = -np.einsum("nkri,nkr->nki", matrix, flat)
        good = np.isfinite(normal).all(axis=(2, 3)) & (normal[..., 0, 0] > 0.0) & np.isfinite(right).all(axis=2)
        normal[~good], right[~good] = np.eye(len(linear)), 0.0
        change = np.linalg.solve(normal, right[..., None])[..., 0]
        moved = np.clip(fitted[..., linear] + change, problem.least[linear], problem.most[linear])
        flat = flat + np.einsum("nkri,nki->nkr", matrix, moved - fitted[..., linear])
        fitted[..., linear] = moved
    errors = np.einsum("nkr,nkr->nk", flat, flat)
    return fitted, np.where(np.isfinite(errors), errors, np.inf)
