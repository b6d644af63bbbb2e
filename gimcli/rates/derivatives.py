"""Velocities, accelerations and jerks along a motion, from the constraint equations and the derivatives of the laws.

The equations are differentiated exactly in `plan_rates`, not by finite differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from gimcli.kernels import tape as kernels
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism, Point
from gimcli.motion.motion import Motion
from gimcli.positions.dispatch import choose, plain
from gimcli.positions.newton import Run
from gimcli.progress import Notify
from gimcli.rates.plan_rates import Differentiated, carrier
from gimcli.rates.slots import POSITION, Slot
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


def rates(
    mechanism: Mechanism, time: FloatArray, z: ComplexArray, order: int, plan: Plan | None = None, run: Run = plain
) -> MotionRates:
    """Differentiate positions z (nodes, rows) at normalised times (rows,) up to an order of at most 3."""
    return rates_of_inputs(mechanism, z, law_rates(mechanism, time, order), plan, run)


def rates_of_inputs(
    mechanism: Mechanism, z: ComplexArray, given: FloatArray, plan: Plan | None = None, run: Run = plain
) -> MotionRates:
    """Differentiate positions z (nodes, rows) for given inputs and derivatives (order + 1, actuators, rows)."""
    order = len(given) - 1
    made = Differentiator(mechanism, plan or make_plan(mechanism), ORDERS[:order], mechanism.nodes)
    return MotionRates(mechanism, order, *made(z, given, run))


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
