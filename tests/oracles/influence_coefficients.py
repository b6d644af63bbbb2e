"""Influence coefficients: motion of nodes, points and members per unit rate of each input, and their derivatives.

With inputs q and their rates q', for points z and angles phi of members,

    z'   = B q'                 B (points, actuators) complex, first-order coefficients
    z''  = B q'' + bias         bias: the acceleration at q'' = 0, quadratic in q'
    B'   = dB/dq along q'       second-order coefficients times q'; B' q' = bias

and the same with real numbers for the angles. They follow exactly from the steps of the plan, without differences.
They are NaN where the equations determine no velocity. Lengths are those of the normal frame, angles are in rad, inputs
are in the order of `Mechanism.actuators`.

One position takes a few microseconds, compiled (`run=gimcli.kernels.jit.compiled`):

    influence = Influence(mechanism, plan, points=("A", Point("centre of mass", member, local)), run=jit.compiled)
    now = influence.at(z, q)                  # z (nodes,) as solved at q (actuators,)
    now.points, now.angles                    # (points, actuators), (members, actuators)
    now = influence.at(z, q, rates)
    now.points_bias, now.angles_bias          # (points,), (members,)
    now.points_change, now.angles_change      # (points, actuators), (members, actuators)

The arrays of `at` are views of memory that the next call overwrites. `over` does many rows in one call; rows are the
last axis of all arrays. Other kernels may call `gimcli.kernels.tape.play` with `arguments`.

Source: Eksergian, Dynamical analysis of machines, 1930; Benedict & Tesar, Model formulation of complex mechanisms
with multiple inputs, J. Mech. Design 100 (1978) 747-761 (kinematic influence coefficients).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np

from gimcli import Mechanism, UsageError
from gimcli.kernels import tape as kernels
from gimcli.mechanism import ComplexArray, FloatArray, Point
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run
from gimcli.rates.derivatives import Differentiator, parts
from gimcli.rates.slots import Slot
from gimcli.structure.plan import make_plan
from gimcli.structure.steps import Plan


@dataclass(frozen=True)
class First:
    """First-order coefficients."""

    points: ComplexArray  # (points, actuators[, rows]) B
    angles: FloatArray  # (members, actuators[, rows]); members but the frame, in the mechanism's order


@dataclass(frozen=True)
class Second(First):
    """First-order coefficients, and velocities, accelerations and derivatives at given input rates."""

    points_rate: ComplexArray  # (points[, rows]) velocities B q'
    angles_rate: FloatArray  # (members[, rows])
    points_bias: ComplexArray  # (points[, rows]) accelerations at q'' = 0
    angles_bias: FloatArray  # (members[, rows])
    points_change: ComplexArray  # (points, actuators[, rows]) dB/dq along q'
    angles_change: FloatArray  # (members, actuators[, rows])


def first_slots(actuators: int) -> list[Slot]:
    """Return a slot for each actuator at unit rate."""
    return [Slot(unit=a) for a in range(actuators)]


def second_slots(actuators: int) -> list[Slot]:
    """Return slots for these, for the velocity, the bias, and the derivatives of the coefficients of each actuator."""
    v = actuators + 1
    change = [Slot((1 + a, v, 1), order=2) for a in range(actuators)]
    return [*first_slots(actuators), Slot(given=1), Slot((v, v, 1), order=2), *change]


class Influence:
    """The influence coefficients of a mechanism, for all nodes or for some points."""

    def __init__(
        self, mechanism: Mechanism, plan: Plan | None = None, points: Sequence[str | Point] | None = None,
        run: Run = plain,
    ) -> None:  # fmt: skip
        self.mechanism, self.run = mechanism, run
        self.actuators = len(mechanism.actuators)
        if self.actuators == 0:
            raise UsageError(f"{mechanism.name} has no actuator: nothing has an influence; add one")
        plan, points = plan or make_plan(mechanism), mechanism.nodes if points is None else points
        slots = first_slots(self.actuators), second_slots(self.actuators)
        self._made = [Differentiator(mechanism, plan, some, points, position=False) for some in slots]
        self._rooms = [_Room(made, mechanism) for made in self._made]
        self._play = run(kernels.play)

    @overload
    def over(self, z: ComplexArray, inputs: FloatArray, rates: None = None) -> First: ...

    @overload
    def over(self, z: ComplexArray, inputs: FloatArray, rates: FloatArray) -> Second: ...

    def over(self, z: ComplexArray, inputs: FloatArray, rates: FloatArray | None = None) -> First:
        """Return the coefficients in many rows: z (nodes, rows), inputs and rates (actuators, rows).

        With rates the result is a `Second`.
        """
        given = inputs[None] if rates is None else np.stack([inputs, rates])
        return _coefficients(*self._made[rates is not None](z, given, self.run), self.actuators)

    @overload
    def at(self, z: ComplexArray, inputs: FloatArray, rates: None = None) -> First: ...

    @overload
    def at(self, z: ComplexArray, inputs: FloatArray, rates: FloatArray) -> Second: ...

    def at(self, z: ComplexArray, inputs: FloatArray, rates: FloatArray | None = None) -> First:
        """Return the coefficients at one position z (nodes,), inputs and rates (actuators,), as views."""
        room = self._rooms[rates is not None]
        room.z[:, 0] = z
        room.given[0, :, 0] = inputs
        if rates is not None:
            room.given[1, :, 0] = rates
        if self.run is plain:
            with np.errstate(all="ignore"):
                self._play(*room.arguments)
        else:
            self._play(*room.arguments)
        return room.coefficients

    def arguments(self, second: bool = False) -> tuple[Any, ...]:
        """Return the arguments of `kernels.tape.play` for one position; its results are in the arrays of `at`."""
        return self._rooms[second].arguments


class _Room:
    """Memory for one position."""

    def __init__(self, made: Differentiator, mechanism: Mechanism) -> None:
        self.z = np.zeros((len(mechanism.nodes), 1), dtype=complex)
        self.given = np.zeros((2, len(mechanism.actuators), 1))
        points, angles = np.zeros((*made.points, 1), dtype=complex), np.zeros((*made.angles, 1))
        self.arguments = (made.w, made.heads, made.factors, parts(self.z), self.given, parts(points), angles)
        self.coefficients = _coefficients(points[..., 0], angles[..., 0], len(mechanism.actuators))


def _coefficients(points: ComplexArray, angles: FloatArray, n: int) -> First:
    """Return arrays whose first axis is the slots as coefficients."""
    first = points[:n].swapaxes(0, 1), angles[:n].swapaxes(0, 1)
    if len(points) == n:
        return First(*first)
    change = points[n + 2 :].swapaxes(0, 1), angles[n + 2 :].swapaxes(0, 1)
    return Second(*first, points[n], angles[n], points[n + 1], angles[n + 1], *change)
