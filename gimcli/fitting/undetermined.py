"""Dimensions that targets do not determine: a change of these, with other inputs, leaves all differences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.fitting.least_squares import FitProblem, Trials
from gimcli.fitting.targets import FREE, GIVEN
from gimcli.mechanism import FloatArray

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
