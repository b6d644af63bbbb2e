"""Velocities, accelerations and jerks along a motion, from the constraint equations and the derivatives of the laws.

The equations are differentiated exactly in `plan_rates`, not by finite differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.positions.dispatch import choose, plain
from gimcli.positions.newton import Run
from gimcli.progress import Notify
from gimcli.rates.differentiator import Differentiator
from gimcli.rates.plan_rates import carrier
from gimcli.rates.slots import Slot
from gimcli.structure.plan import make_plan
from gimcli.structure.steps import Plan

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
