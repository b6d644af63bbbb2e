"""Velocities and accelerations at one position, by the actuators' laws or by unit rates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Input, Mechanism
from gimcli.rates.derivatives import MotionRates
from gimcli.rates.path_derivatives import rates_along

SAMPLES = 4097
"""Times at which a law is evaluated in the search for a value."""

HALVINGS = 60
"""Bisections of the interval found: more than the digits of a double."""

EQUAL = 1e-12
"""A law has a value if the difference is at most this, relative to the largest value of the law."""


@dataclass(frozen=True)
class Instant:
    """Derivatives by the real time at one position, and the rates of the inputs."""

    mechanism: Mechanism
    rates: MotionRates
    time: FloatArray  # (actuators,) normalised time at which the law has the value; NaN: a unit rate is used
    input_rate: FloatArray  # (actuators,) rad/s or normal lengths/s
    input_acceleration: FloatArray  # (actuators,) rad/s^2 or normal lengths/s^2

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
    count = len(mechanism.actuators)
    time, first, second = np.full(count, np.nan), np.zeros(count), np.zeros(count)
    for k in mechanism.drivers:
        actuator = mechanism.actuators[k]
        time[k] = law_time(actuator, float(inputs[k]))
        if np.isnan(time[k]):
            first[k] = unit_rate(mechanism, actuator)
        else:
            first[k] = float(actuator.law(time[k : k + 1], 1)[0]) / mechanism.duration
            second[k] = float(actuator.law(time[k : k + 1], 2)[0]) / mechanism.duration**2
    if mechanism.couplings:
        first, second = _of_followers(mechanism, inputs, z, first, second)
    rates = rates_along(mechanism, inputs[:, None], z[:, None], first[:, None], second[:, None], 2)
    return Instant(mechanism, rates, time, first, second)


def _of_followers(
    mechanism: Mechanism, inputs: FloatArray, z: ComplexArray, first: FloatArray, second: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return rates and accelerations of all inputs (actuators,) for those of the drivers."""
    if mechanism.complete is None:
        drivers = list(mechanism.drivers)
        return mechanism.following @ first[drivers], mechanism.following @ second[drivers]
    from gimcli.structure.linked_equations import linked_equations  # imported late: few mechanisms have such gears

    equations = linked_equations(mechanism)
    found = equations.derivatives(equations.point(z, inputs), np.array([inputs, first, second])[:, :, None])
    first, second = first.copy(), second.copy()
    for rates, own in zip((first, second), found[1:, equations.n :, 0], strict=True):
        rates[:] = equations.linear(rates)
        rates[equations.followers] = own
    return first, second


def unit_rate(mechanism: Mechanism, actuator: Input) -> float:
    """Return one unit of the file per second, in rad/s or normal lengths/s."""
    if not actuator.rotary:
        return 1.0 / mechanism.scale
    return np.pi / 180.0 if mechanism.angle_unit == "deg" else 1.0


def law_time(actuator: Input, value: float) -> float:
    """Return the first normalised time at which a law has a value, an angle up to full turns; NaN if it never has."""
    t = np.linspace(0.0, 1.0, SAMPLES)
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
    low, high = float(t[k]), float(t[k + 1])
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        same = (float(actuator.law(np.array([middle]))[0]) - value > 0.0) == (off[k] > 0.0)
        low, high = (middle, high) if same else (low, middle)
    return (low + high) / 2.0
