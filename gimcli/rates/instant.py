"""Velocities and accelerations at one position, by the actuators' laws or by unit rates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Input, Mechanism
from gimcli.numerics.roots import bisected
from gimcli.rates.derivatives import MotionRates, rates_of_inputs

EQUAL = 1e-12
"""A law has a value if the difference is at most this, relative to the largest value of the law."""


@dataclass(frozen=True)
class Instant:
    """Derivatives by the real time at one position, and the rates of the inputs."""

    mechanism: Mechanism
    rates: MotionRates
    time: FloatArray  # (actuators,) normalised time at which the law has the value; NaN: a unit rate is used
    given: FloatArray  # (4, actuators) inputs and their derivatives: rad or normal lengths, by s

    @property
    def singular(self) -> bool:
        """Return whether the position is singular: the equations do not determine the velocities."""
        return not bool(np.all(np.isfinite(self.rates.nodes)))

    def of_points(self, order: int) -> Mapping[str, complex]:
        """Return velocity (order 1) or acceleration (2) of all nodes and points [file's length unit, s]."""
        names = [*self.mechanism.nodes, *(p.name for p in self.mechanism.points)]
        return {name: complex(self.rates.point(name)[order, 0]) * self.mechanism.scale for name in names}

    def of_members(self, order: int) -> Mapping[str, float]:
        """Return omega (order 1) or alpha (2) of all moving members [file's angle unit, s]."""
        unit = 180.0 / np.pi if self.mechanism.angle_unit == "deg" else 1.0
        members = enumerate(self.mechanism.members[FRAME + 1 :], start=FRAME + 1)
        return {m.name: float(self.rates.angular(k)[order - 1, 0] * unit) for k, m in members}


def instant(mechanism: Mechanism, inputs: FloatArray, z: ComplexArray) -> Instant:
    """Return the velocities and accelerations at a position z (nodes,) with inputs (actuators,).

    An input has the rate of its law at the first time at which the law has the value of the input. If the law never
    has it, the rate is one unit of the file (deg, rad or length) per second, without acceleration.
    """
    time, given = law_state(mechanism, inputs, z)
    return Instant(mechanism, rates_of_inputs(mechanism, z[:, None], given[:3, :, None]), time, given)


def law_state(mechanism: Mechanism, inputs: FloatArray, z: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return normalised times (actuators,), and inputs with three derivatives (4, actuators), as in an `Instant`."""
    time, given = np.full(len(inputs), np.nan), np.zeros((4, len(inputs)))
    given[0] = inputs
    for k in mechanism.drivers:
        actuator = mechanism.actuators[k]
        time[k] = law_time(actuator, float(inputs[k]))
        if np.isnan(time[k]):
            given[1, k] = unit_rate(mechanism, actuator)
        else:
            given[1:, k] = [float(actuator.law(time[k : k + 1], n)[0]) / mechanism.duration**n for n in (1, 2, 3)]
    if mechanism.couplings:
        _drive_followers(mechanism, z, given)
    return time, given


def _drive_followers(mechanism: Mechanism, z: ComplexArray, given: FloatArray) -> None:
    """Set the derivatives of the followers by those of the drivers, in place."""
    drivers = list(mechanism.drivers)
    given[1:] = [mechanism.following @ rates[drivers] for rates in given[1:]]
    if mechanism.complete is None:
        return
    from gimcli.structure.system import system_of  # imported late: few mechanisms have such gears

    system = system_of(mechanism)
    found = system.derivatives(system.coordinates(z, given[0]), given)
    given[1:, system.followers] = system.following(found[1:])


def unit_rate(mechanism: Mechanism, actuator: Input) -> float:
    """Return one unit of the file per second, in rad/s or normal lengths/s."""
    if not actuator.rotary:
        return 1.0 / mechanism.scale
    return np.pi / 180.0 if mechanism.angle_unit == "deg" else 1.0


def law_time(actuator: Input, value: float) -> float:
    """Return the first normalised time at which a law has a value, an angle up to full turns; NaN if it never has."""
    t = np.unique(np.append(actuator.law.stops(), [0.0, 1.0]))
    values = actuator.law(t)
    if actuator.rotary:
        low, high = float(np.min(values)), float(np.max(values))
        turned = value + math.tau * math.ceil((low - value) / math.tau - EQUAL)
        value = value if low <= value <= high or turned > high + EQUAL * math.tau else turned
    off = values - value
    near = EQUAL * max(1.0, float(np.max(np.abs(off + value))))
    hit = np.flatnonzero((np.abs(off) <= near) | np.append(off[1:] * off[:-1] < 0.0, False))
    if not len(hit):
        return float("nan")
    k = int(hit[0])
    if abs(off[k]) <= near:
        return float(t[k])
    _, first = bisected(lambda time: (actuator.law(time) - value) * off[k] <= 0.0, t[k : k + 1], t[k + 1 : k + 2])
    return float(first[0])
