"""The flywheel that keeps a machine's speed within bounds over a cycle, from its reduced inertia and torque.

At a constant driving torque, that of the cycle's mean, T(q) = T_0 + E(q) = (J(q) + J_F) w^2 / 2 with E the work since
the cycle's begin. The greatest and the least speed w (1 +- delta / 2) are each met somewhere and nowhere passed:

    J_F = (max of (w_min^2 J / 2 - E) - min of (w_max^2 J / 2 - E)) / (w^2 delta)

Source: Wittenbauer, Graphische Dynamik, 1923 (the diagram of J over E); VDI 2149-1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.dynamics.reduction import Reduction
from gimcli.errors import UsageError
from gimcli.mechanism import FloatArray

TURN = 1e-9
"""Part of a turn by which a cycle may miss whole turns."""


@dataclass(frozen=True)
class Flywheel:
    """A flywheel and what it is for."""

    inertia: float  # kg m2, on the input's shaft; 0: none is needed
    speed: float  # rad/s, mean of the greatest and the least
    fluctuation: float  # (greatest - least) / mean
    torque: float  # N m, of the drive: constant
    work: float  # J, greatest change of E over the cycle
    without: float  # coefficient of speed fluctuation without a flywheel; NaN where the machine would stop


def flywheel(found: Reduction, speed: float, fluctuation: float) -> Flywheel:
    """Return the flywheel for a mean speed [rad/s] and a coefficient of speed fluctuation."""
    _refuse(found, speed, fluctuation)
    drive, work = cycle_work(found)
    inertia = _needed(found.inertia, work, speed, fluctuation)
    return Flywheel(
        max(0.0, inertia), speed, fluctuation, drive, float(np.ptp(work)), _without(found.inertia, work, speed)
    )


def cycle_work(found: Reduction) -> tuple[float, FloatArray]:
    """Return the constant driving torque [N m] of a cycle, and the work [J] of everything since its begin (rows,).

    The integral is Euler & Maclaurin's: trapezia corrected by the slopes at their ends.
    """
    step, tau, slope = np.diff(found.q), found.torque, found.torque_slope
    parts = 0.5 * step * (tau[:-1] + tau[1:])
    if np.all(np.isfinite(slope)):
        parts += step**2 / 12.0 * (slope[:-1] - slope[1:])
    work = np.concatenate(([0.0], np.cumsum(parts)))
    drive = -float(work[-1] / (found.q[-1] - found.q[0]))
    return drive, np.asarray(work + drive * (found.q - found.q[0]))


def _needed(inertia: FloatArray, work: FloatArray, speed: float, fluctuation: float) -> float:
    least, greatest = (0.5 * (speed * (1.0 + s * fluctuation / 2.0)) ** 2 for s in (-1.0, 1.0))
    return float(np.max(least * inertia - work) - np.min(greatest * inertia - work)) / (speed**2 * fluctuation)


def _without(inertia: FloatArray, work: FloatArray, speed: float) -> float:
    """Return the fluctuation for which no flywheel is needed: more need ever less."""
    from scipy.optimize import brentq

    most = 2.0 - TURN
    if _needed(inertia, work, speed, most) > 0.0:
        return math.nan
    if not _needed(inertia, work, speed, TURN) > 0.0:
        return 0.0
    return float(brentq(lambda delta: _needed(inertia, work, speed, delta), TURN, most))


def _refuse(found: Reduction, speed: float, fluctuation: float) -> None:
    actuator = found.mechanism.actuators[found.actuator]
    turns = abs(float(found.q[-1] - found.q[0])) / (2.0 * math.pi)
    whole = actuator.rotary and turns > 0.5 and abs(turns - round(turns)) < TURN
    if not whole or found.solved < len(found.q):
        raise UsageError(
            f"a flywheel is for an input that turns: let the law of '{actuator.name}' run over whole turns, all of them"
            " within reach"
        )
    if not speed > 0.0 or not 0.0 < fluctuation < 2.0:
        raise UsageError(f"speed {speed:g} and fluctuation {fluctuation:g}: above 0, the fluctuation below 2")
