"""Damped Gauss-Newton method for many independent starts of a nonlinear system at once.

Source: Levenberg-Marquardt with a damping proportional to the squared residual, which keeps the quadratic
convergence of Gauss-Newton also if the equations are dependent or fewer than the unknowns
(Yamashita & Fukushima 2001).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import BoolArray, FloatArray
from gimcli.structure.system import Equations


@dataclass(frozen=True)
class GaussNewtonConstants:
    """Constants of the method."""

    iterations: int = 60  # greatest number
    closeness: float = 1e-13  # norm of the residual at which a row is solved
    arrived: float = 1e-10  # a row that no longer improves is solved if its residual is below this
    damping: float = 0.1  # initial factor of the squared residual
    most: float = 1e9  # greatest damping of a row
    longest: float = 0.5  # greatest step, in the normal frame
    ease: float = 0.25  # factor of the damping after a step that reduces the residual
    brake: float = 8.0  # factor of the damping after any other step
    floor: float = 1e-15  # added to the diagonal, for equations with zero derivatives


def settle(
    equations: Equations, x: FloatArray, constants: GaussNewtonConstants | None = None
) -> tuple[FloatArray, BoolArray]:
    """Solve from starts x (rows, n); return the solutions (rows, n), and whether each row converged (rows,)."""
    constants = constants or GaussNewtonConstants()
    x, damping, going = x.copy(), np.full(len(x), constants.damping), np.arange(len(x))
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
    step = -(np.swapaxes(slopes, 1, 2) @ np.linalg.solve(gram, values[..., None]))[..., 0]
    length = np.linalg.norm(step, axis=1)
    return np.asarray(step * np.minimum(1.0, constants.longest / np.maximum(length, 1e-300))[:, None])
