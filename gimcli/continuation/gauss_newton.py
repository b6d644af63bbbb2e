"""Many independent starts of a nonlinear system at once: least change, damped where it bends.

Source: Levenberg-Marquardt with a damping proportional to the squared residual, which keeps the quadratic
convergence of Gauss-Newton where the equations are dependent or fewer than the unknowns
(Yamashita & Fukushima 2001).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import FloatArray, IntArray

Equations = Callable[[FloatArray, IntArray], tuple[FloatArray, FloatArray]]
"""Residuals (rows, m) and their derivatives (rows, m, n) at x (rows, n); which of all rows they are (rows,)."""


@dataclass(frozen=True)
class GaussNewtonConstants:
    """Constants of the method."""

    iterations: int = 60
    closeness: float = 1e-13  # norm of the residual at which a row stands
    arrived: float = 1e-10  # below it a row that moves no more has arrived
    damping: float = 0.1  # first, of the squared residual
    most: float = 1e9  # damping at which a row is given up
    longest: float = 0.5  # step, mechanisms being about 1 in size
    ease: float = 0.25
    brake: float = 8.0
    floor: float = 1e-15  # of the diagonal: an equation that does not count has none


def settle(
    equations: Equations, x: FloatArray, constants: GaussNewtonConstants | None = None
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return x (rows, n) moved onto the solutions, and which rows got there."""
    constants = constants or GaussNewtonConstants()
    x, count = x.copy(), len(x)
    error, damping = np.full(count, np.inf), np.full(count, constants.damping)
    going = np.arange(count)
    if not count:
        return x, np.zeros(0, dtype=bool)
    values, slopes = equations(x, going)
    error = np.linalg.norm(values, axis=1)
    for _ in range(constants.iterations):
        going = np.flatnonzero((error > constants.closeness) & (damping < constants.most))
        if not len(going):
            break
        step = _step(values[going], slopes[going], damping[going], constants)
        tried = x[going] + step
        new, table = equations(tried, going)
        size = np.linalg.norm(new, axis=1)
        better = size < error[going]
        damping[going] *= np.where(better, constants.ease, constants.brake)
        took = going[better]
        x[took], error[took] = tried[better], size[better]
        values[took], slopes[took] = new[better], table[better]
    return x, np.asarray(error <= constants.arrived)


def _step(values: FloatArray, slopes: FloatArray, damping: FloatArray, constants: GaussNewtonConstants) -> FloatArray:
    """Return the damped step of least length (rows, n)."""
    gram = slopes @ np.swapaxes(slopes, 1, 2)
    trace = np.trace(gram, axis1=1, axis2=2)
    ridge = damping * np.minimum(np.sum(values**2, axis=1), 1.0) + constants.floor * trace + np.finfo(float).tiny
    gram += ridge[:, None, None] * np.eye(gram.shape[1])
    pull = np.linalg.solve(gram, values[..., None])
    step = -(np.swapaxes(slopes, 1, 2) @ pull)[..., 0]
    length = np.linalg.norm(step, axis=1)
    return np.asarray(step * np.minimum(1.0, constants.longest / np.maximum(length, 1e-300))[:, None])
