"""Velocities, accelerations and jerks along a motion, from the constraint equations and the derivatives of the laws.

The equations are differentiated exactly in `plan_rates`, not by finite differences.

At one position they are those of the actuators' laws, or of unit rates.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from gimcli.kernels import tape as kernels
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Input, Mechanism, Point
from gimcli.motion.motion import Motion
from gimcli.numerics.along import bisected
from gimcli.positions.dispatch import choose, plain
from gimcli.positions.newton import Run
from gimcli.progress import Notify
from gimcli.rates.plan_rates import Differentiated, carrier
from gimcli.rates.slots import POSITION, Slot
from gimcli.structure.derived import derived
from gimcli.structure.plan import make_plan
from gimcli.structure.steps import Plan

PLAIN = 3e-8
"""Approximate time of one operation per row without compilation [s]."""


class Differentiator:
    """A differentiated plan: given slots of given points, and of all members except the frame.

    Points are nodes or points by name, or points of members without a name. Slot 0, the position, is included if
    `position` is true.
    """

    def __init__(
        self, mechanism: Mechanism, plan: Plan, slots: Sequence[Slot], points: Sequence[str | Point],
        position: bool = True,
    ) -> None:  # fmt: skip
        skipped = 0 if position else 1
        found = Differentiated(mechanism, plan, [POSITION, *slots])
        for number, point in enumerate(points):
            found.write_point(number, point, skipped)
        for number, member in enumerate(mechanism.members[FRAME + 1 :]):
            found.write_angle(number, member)
        self.tape = found.tape
        self.w, self.heads, self.factors = found.tape.arrays()
        self.points = len(slots) + 1 - skipped, len(points)
        self.angles = len(slots), len(mechanism.members) - 1
        groups = [(sum(e.rows for e in g.equations), 2 * len(g.base)) for g in plan.coupled]
        self.operations = len(self.heads) + sum(m * n * (n + len(slots)) for m, n in groups)

    def plain_seconds(self, rows: int) -> float:
        """Return the estimated time of a number of rows without compilation [s]."""
        return rows * PLAIN * self.operations

    def __call__(self, z: ComplexArray, given: FloatArray, run: Run) -> tuple[ComplexArray, FloatArray]:
        """Return points (slots, points, rows) and angles of members (slots - 1, members, rows).

        z (nodes, rows), given (., actuators, rows). Rows without a position or with singular gradients are NaN.
        """
        rows = z.shape[1]
        points, angles = np.empty((*self.points, rows), dtype=complex), np.empty((*self.angles, rows))
        z, given = np.ascontiguousarray(z), np.ascontiguousarray(given)
        with np.errstate(all="ignore"):
            run(kernels.play)(self.w, self.heads, self.factors, parts(z), given, parts(points), angles)
        return points, angles


def parts(z: ComplexArray) -> FloatArray:
    """Return a view with real and imaginary parts as the last axis."""
    return z.view(float).reshape(*z.shape, 2)


ORDERS = (Slot(given=1), Slot((1, 1, 1), given=2, order=2), Slot((1, 2, 3), given=3, order=3))
"""Velocity, acceleration, jerk."""


@dataclass(frozen=True)
class MotionRates:
    """Derivatives by the real time [s], in the normal frame; NaN in rows that are not solved or singular."""

    mechanism: Mechanism = field(repr=False)
    order: int
    nodes: ComplexArray = field(repr=False)  # (order + 1, nodes, rows): position, velocity, acceleration ...
    angles: FloatArray = field(repr=False)  # (order, members, rows) omega, alpha ... of all members but the frame

    def point(self, name: str) -> ComplexArray:
        """Return position, velocity ... of a node or point (order + 1, rows)."""
        u, v, z = carrier(self.mechanism, name)
        first = self.nodes[:, u]
        if u != v:
            return np.asarray(first + z * (self.nodes[:, v] - first))
        shift = np.zeros((self.order + 1, 1), dtype=complex)
        shift[0] = z
        return np.asarray(first + shift)

    def angular(self, index: int) -> FloatArray:
        """Return omega, alpha ... of a member (order, rows) [rad/s, rad/s^2 ...]."""
        if index == FRAME:
            return np.zeros((self.order, self.nodes.shape[2]))
        return np.asarray(self.angles[:, index - 1])


def rates(mechanism: Mechanism, time: FloatArray, z: ComplexArray, order: int) -> MotionRates:
    """Differentiate positions z (nodes, rows) at normalised times (rows,) up to an order of at most 3."""
    return rates_of_inputs(mechanism, z, law_rates(mechanism, time, order))


def rates_of_inputs(mechanism: Mechanism, z: ComplexArray, given: FloatArray) -> MotionRates:
    """Differentiate positions z (nodes, rows) for given inputs and derivatives (order + 1, actuators, rows)."""
    order = len(given) - 1
    return MotionRates(mechanism, order, *_all_nodes(mechanism, order)(z, given, plain))


@derived
def _all_nodes(mechanism: Mechanism, order: int) -> Differentiator:
    return Differentiator(mechanism, make_plan(mechanism), ORDERS[:order], mechanism.nodes)


def law_rates(mechanism: Mechanism, time: FloatArray, order: int, inputs: FloatArray | None = None) -> FloatArray:
    """Return inputs and their derivatives by the real time (order + 1, actuators, rows), from the laws.

    `inputs` (actuators, rows) replaces the values of the laws.
    """
    given = np.empty((order + 1, len(mechanism.actuators), len(time)))
    if inputs is not None:
        given[0] = inputs
    for k in range(0 if inputs is None else 1, order + 1):
        for a, actuator in enumerate(mechanism.actuators):
            np.divide(actuator.law(time, k), mechanism.duration**k, out=given[k, a])
    return given


class TracedRates:
    """Computes the derivatives of traced points and of all members along a motion in pieces."""

    def __init__(
        self, mechanism: Mechanism, names: Sequence[str], order: int, rows: int = 0, jit: str = "off",
        notify: Notify | None = None,
    ) -> None:  # fmt: skip
        self.mechanism, self.names, self.order = mechanism, tuple(names), order
        self._made = Differentiator(mechanism, make_plan(mechanism), ORDERS[:order], names, position=False)
        run = choose(jit, self._made.plain_seconds(rows), notify, ("play",))
        self._differentiate = partial(self._made, run=run)

    def __call__(self, motion: Motion) -> tuple[ComplexArray, FloatArray]:
        """Return velocity, acceleration ... of points (order, points, rows) and of members (order, members, rows)."""
        return self._differentiate(motion.z, law_rates(self.mechanism, motion.time, self.order, motion.inputs))


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
        drive_followers(mechanism, z[:, None], given[..., None])
    return time, given


def drive_followers(mechanism: Mechanism, z: ComplexArray, given: FloatArray) -> None:
    """Set the derivatives (orders, actuators, rows) of the followers by those of the drivers, in place.

    z (nodes, rows); `given` begins with the inputs themselves.
    """
    given[1:] = mechanism.following @ given[1:, list(mechanism.drivers)]
    if mechanism.complete is None:
        return
    from gimcli.structure.system import system_of  # imported late: few mechanisms have such gears

    system = system_of(mechanism)
    x = np.array([system.coordinates(*row) for row in zip(z.T, given[0].T, strict=True)])
    found = system.derivatives(x, np.moveaxis(given, 1, 2))
    given[1:, system.followers] = np.moveaxis(system.following(found[1:]), 1, 2)


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
