"""The flywheel that keeps the speed of a machine within bounds over a cycle, from its reduced inertia and torque.

The driving torque is constant, the mean over the cycle. Then T(q) = T_0 + E(q) = (J(q) + J_F) w^2 / 2, E being the work
since the beginning of the cycle. The speed reaches its bounds w (1 +- delta / 2) but does not exceed them if

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
from gimcli.numerics.roots import bisected

TURN = 1e-9
"""Greatest difference of a cycle from whole turns, in turns."""


@dataclass(frozen=True)
class Flywheel:
    """A flywheel and the data that it was computed from."""

    inertia: float  # kg m^2, on the input's shaft; 0: no flywheel is needed
    speed: float  # rad/s, mean of the greatest and the least speed
    fluctuation: float  # coefficient of speed fluctuation, (greatest - least) / mean speed
    torque: float  # N m, constant driving torque
    work: float  # J, greatest minus least E over the cycle
    without: float  # coefficient of speed fluctuation without a flywheel; NaN if the machine would stop


def flywheel(found: Reduction, speed: float, fluctuation: float) -> Flywheel:
    """Return the flywheel for a mean speed [rad/s] and a coefficient of speed fluctuation.

    Raises UsageError unless the reduction covers whole turns and all its rows are solved.
    """
    _refuse(found, speed, fluctuation)
    drive, work = cycle_work(found)
    inertia = _needed(found.inertia, work, speed, fluctuation)
    return Flywheel(
        max(0.0, inertia), speed, fluctuation, drive, float(np.ptp(work)), _without(found.inertia, work, speed)
    )


def cycle_work(found: Reduction) -> tuple[float, FloatArray]:
    """Return the constant driving torque [N m] of a cycle, and the work [J] of all forces since its beginning (rows,).

    The integral is the trapezoidal rule with the end correction of Euler and Maclaurin.
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
    """Return the fluctuation without a flywheel: the required inertia decreases with the fluctuation to 0 there."""
    most = 2.0 - TURN
    if _needed(inertia, work, speed, most) > 0.0:
        return math.nan
    if not _needed(inertia, work, speed, TURN) > 0.0:
        return 0.0
    return bisected(lambda delta: not _needed(inertia, work, speed, delta) > 0.0, TURN, most)[1]


def _refuse(found: Reduction, speed: float, fluctuation: float) -> None:
    actuator = found.mechanism.actuators[found.actuator]
    turns = abs(float(found.q[-1] - found.q[0])) / (2.0 * math.pi)
    whole = actuator.rotary and turns > 0.5 and abs(turns - round(turns)) < TURN
    if not whole or found.solved < len(found.q):
        raise UsageError(
            f"a flywheel needs a rotary input that makes whole turns: the law of '{actuator.name}' must cover whole"
            " turns, and all positions must be assembled"
        )
    if not speed > 0.0 or not 0.0 < fluctuation < 2.0:
        raise UsageError(
            f"expected a speed above 0 and a fluctuation above 0 and below 2, got {30.0 * speed / math.pi:g} rev/min"
            f" and {fluctuation:g}"
        )
