"""Convergence of the sweeps: fit of eq. (3) of Petuya et al. 2004, E_n = C1 exp(-C2 n), to the errors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.gim.sequence import radius_of
from gimcli.gim.sweeper import Sweeper
from gimcli.mechanism import FloatArray
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options
from gimcli.positions.position import Position

FLOOR = 1e-13
"""Errors below this are rounding errors and are not used in the fit."""


@dataclass(frozen=True)
class ErrorLaw:
    """Errors of the sweeps, and the exponential function fitted to the later half of them."""

    errors: FloatArray  # (sweeps + 1, 2) eqs (1) and (2) [rad]
    c1: float
    c2: float
    radius: float  # spectral radius of the sweep at the solution

    @property
    def rate(self) -> float:
        """Factor by which one sweep reduces the error."""
        return math.exp(-self.c2)


def fit_history(position: Position) -> ErrorLaw:
    """Fit eq. (3) to the errors of a position that was found by sweeps with a history."""
    assert position.history is not None
    errors = position.history.copy()
    errors[:, 1] = in_radians(errors[:, 1])
    c1, c2 = fit(errors.max(axis=1))
    return ErrorLaw(errors, c1, c2, radius_at(position))


def in_radians(sines: FloatArray) -> FloatArray:
    """Return angles [rad] from the measure of the kernel: |sine|, or 2 - |sine| for angles above 90 deg."""
    near = np.arcsin(np.clip(sines, 0.0, 1.0))
    far = math.pi - np.arcsin(np.clip(2.0 - sines, 0.0, 1.0))
    return np.asarray(np.where(sines <= 1.0, near, far))


def fit(worst: FloatArray) -> tuple[float, float]:
    """Return C1 and C2 by linear regression of the logarithms of the later half of the errors (NaN if too few)."""
    use = np.flatnonzero((worst > FLOOR) & np.isfinite(worst))
    use = use[len(use) // 2 :] if len(use) > 4 else use[1:]
    if len(use) < 2:
        return float("nan"), float("nan")
    slope, height = np.polyfit(use, np.log(worst[use]), 1)
    return float(math.exp(height)), float(-slope)


def radius_at(position: Position) -> float:
    """Return the spectral radius, at a position, of the sequence by which it was found."""
    sweeper = Sweeper(position.mechanism, position.options or Options(method="gim"), plain)
    return radius_of(sweeper.moves, tuple(sweeper.free), position.z)
