"""Forces on each body along a motion (inertia, gravity, loads, springs, dampers, friction), and their power.

Forces are in N and positions in the normal frame, so moments are in N times the length unit of the normal frame. The
numbers are arrays over the rows, or dual numbers with the derivatives by the dimensions. Powers and energies are
computed when they are asked for.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.numbers import RuleNumber
from gimcli.dynamic_data import NO_NODE, AppliedLoad, DampingForce, Inertia, RotorInertia, SpringForce
from gimcli.dynamics.kinematic_history import Course, Turns, reading, turning
from gimcli.dynamics.load_arrays import friction_pairs, is_vector, moving_loads
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.statics import Reaction, Statics, direction
from gimcli.kernels.equilibrium import COUPLE, PUSH
from gimcli.mechanism import FRAME, FloatArray
from gimcli.structure.carried import carried, measured, unit_of
from gimcli.structure.steps import NONE

POWERS = ("load", "gravity", "spring", "damping")
"""Kinds of applied forces; the power of each kind is a column of the table."""

quiet = np.errstate(all="ignore")


class LoadedPart:
    """A mass or a load on a moving member, or on the pin of a node: the force at its point and the couple.

    Of a mass these are the weight less the inertia force, and less the inertia couple.
    """

    kind: str  # of POWERS
    force: Any = 0.0  # (rows,) N
    couple: Any = 0.0  # (rows,) N x length

    def __init__(self, loading: Loading, part: Inertia | AppliedLoad, local: complex) -> None:
        self.part, self.local = part, local
        self.mechanism, self.course, self.metre = loading.statics.mechanism, loading.course, loading.metre

    def point(self, order: int = 0) -> Any:
        """Return position, velocity or acceleration of the point (rows,)."""
        nodes = self.course.nodes[order]
        at_node = self.part.node != NO_NODE
        return nodes[self.part.node] if at_node else carried(self.mechanism, nodes, self.part.member, self.local)

    def turning(self, order: int) -> Any:
        """Return omega or alpha of its member (order 1 or 2) (rows,)."""
        return turning(self.mechanism, self.course, self.part.member)[order - 1] if self.part.node == NO_NODE else 0.0

    def body(self, statics: Statics) -> int:
        """Return the body on which it acts; the pin of a node belongs to its first member."""
        at_node = self.part.node != NO_NODE
        return statics.body_of_pin[self.part.node] if at_node else statics.body_of_member[self.part.member]

    @property
    def power(self) -> Any:
        """The power of its applied force [W] (rows,)."""
        return self.metre * (self.point(1).conjugate() * self.force).real + self.metre * self.couple * self.turning(1)


class MassPart(LoadedPart):
    """A mass with its weight."""

    kind = "gravity"

    def __init__(self, loading: Loading, part: Inertia) -> None:
        super().__init__(loading, part, part.centre)
        self.mass, self.moment = part.mass, part.moment
        self.weight = part.mass * self.mechanism.dynamics.gravity
        self.force = self.weight - self.mass * self.metre * self.point(2)
        self.couple = -self.moment / self.metre * self.turning(2)

    @property
    def power(self) -> Any:
        """The power of the weight [W] (rows,)."""
        return self.metre * (self.point(1).conjugate() * self.weight).real

    def height(self, pole: complex) -> Any:
        """Return the potential energy [J] (rows,), 0 at the pole."""
        return -self.metre * ((self.point() - pole).conjugate() * self.weight).real

    @property
    def kinetic(self) -> Any:
        """The kinetic energy [J] (rows,)."""
        speed, omega = self.point(1), self.turning(1)
        return 0.5 * self.mass * self.metre**2 * abs(speed) ** 2 + 0.5 * self.moment * omega**2

    @property
    def kinetic_rate(self) -> Any:
        """The rate of the kinetic energy, from the accelerations [W] (rows,)."""
        inertial = self.mass * self.metre * self.point(2)
        spin = self.moment * self.turning(1) * self.turning(2)
        return self.metre * (self.point(1).conjugate() * inertial).real + spin


class LoadPart(LoadedPart):
    """A force or a torque of the file."""

    kind = "load"

    def __init__(self, loading: Loading, part: AppliedLoad) -> None:
        super().__init__(loading, part, part.point)
        factor = part.factor(self.course.time, self.course.inputs)
        if isinstance(part.torque, RuleNumber) or np.any(part.torque):
            self.couple = factor * part.torque / self.metre
        else:
            follows = part.follows
            unit = unit_of(self.mechanism, self.course.nodes[0], part.member) if follows else 1.0
            self.force = unit * part.force * factor


class KnownEffort(NamedTuple):
    """The effort of a spring, a damper or viscous friction, in the place of an unknown of the equations."""

    kind: str  # of POWERS
    reaction: Reaction
    effort: Any  # (rows,) N, or N x length; for a vector N by length
    amount: Any  # (rows,) N, or N m: the effort of a vector by its length
    power: Any  # (rows,) W
    potential: Any = 0.0  # (rows,) J


class Loading:
    """Forces and moments on the bodies, their power and energies."""

    def __init__(self, statics: Statics, course: Course, turns: Turns | None = None) -> None:
        """Take a motion; `turns` continues the angles of springs from one piece to the next."""
        self.statics, self.course = statics, course
        self.mechanism, self.dynamics = statics.mechanism, statics.mechanism.dynamics
        self.metre = require_action(self.mechanism)
        self.gauges: list[tuple[FloatArray, FloatArray]] = []  # (rows,) value and rate of each gauge
        turns = Turns() if turns is None else turns
        for number, gauge in enumerate(self.mechanism.gauges):
            value, rate, _ = reading(self.mechanism, gauge, course)
            self.gauges.append((turns.followed(number, value, gauge.drawn) if gauge.rotary else value, rate))

    @cached_property
    @quiet
    def masses(self) -> list[MassPart]:
        """The masses; the frame does not move."""
        return [MassPart(self, inertia) for inertia in self.dynamics.inertias if inertia.member != FRAME]

    @cached_property
    @quiet
    def parts(self) -> list[LoadedPart]:
        """The masses and the loads."""
        return [*self.masses, *(LoadPart(self, load) for load in moving_loads(self.mechanism))]

    @cached_property
    @quiet
    def efforts(self) -> list[KnownEffort]:
        """The efforts of springs, dampers, and viscous friction."""
        return [*map(self._spring, self.dynamics.springs), *map(self._damper, self.dynamics.dampers), *self._friction()]

    def _spring(self, spring: SpringForce) -> KnownEffort:
        gauge, reaction = self.mechanism.gauges[spring.gauge], self.statics.gauges[spring.gauge]
        value, rate = self.gauges[spring.gauge]
        if is_vector(self.mechanism, spring):  # k (a - b), which is 0 where the ends meet
            arm, speed = (self.course.nodes[k, gauge.nodes[1]] - self.course.nodes[k, gauge.node] for k in range(2))
            stiffness = spring.stiffness * self.metre**2
            power = -stiffness * (speed.conjugate() * arm).real
            vector = replace(reaction, kind=PUSH)
            pull = -spring.stiffness * self.metre
            return KnownEffort("spring", vector, pull, pull * value, power, 0.5 * stiffness * abs(arm) ** 2)
        metre = 1.0 if gauge.rotary else self.metre
        stretch = metre * (value - spring.free)
        effort = -spring.stiffness * stretch
        return KnownEffort(
            "spring", reaction, self._entered(reaction, effort), effort, effort * metre * rate, -0.5 * effort * stretch
        )

    def _damper(self, damper: DampingForce) -> KnownEffort:
        gauge, reaction = self.mechanism.gauges[damper.gauge], self.statics.gauges[damper.gauge]
        rate = self.gauges[damper.gauge][1] * (1.0 if gauge.rotary else self.metre)
        return self._damped(reaction, damper.damping, rate)

    def _friction(self) -> list[KnownEffort]:
        found = []
        for pair in friction_pairs(self.mechanism):
            rate = pair.rate(self.mechanism, self.course) * (1.0 if pair.slide == NONE else self.metre)
            found.append(self._damped(pair.reaction(self.statics), pair.friction.damping, rate))
        return found

    def _damped(self, reaction: Reaction, damping: float, rate: FloatArray) -> KnownEffort:
        """Return a viscous effort at a rate in rad/s or m/s."""
        effort = -damping * rate
        return KnownEffort("damping", reaction, self._entered(reaction, effort), effort, effort * rate)

    def _entered(self, reaction: Reaction, effort: Any) -> Any:
        """Return an effort [N m or N] in the unit of the equations."""
        return effort / self.metre if reaction.kind == COUPLE else effort

    @cached_property
    @quiet
    def pins(self) -> dict[int, Any]:
        """The forces applied to the pins of nodes (rows,) [N], by node."""
        found: dict[int, Any] = {}
        for part in self.parts:
            if part.part.node != NO_NODE:
                found[part.part.node] = found.get(part.part.node, 0.0) + part.force
        for own in self.efforts:
            for node, sense in own.reaction.ends if own.reaction.on_pin else ():
                found[node] = found.get(node, 0.0) + sense * own.effort * direction(own.reaction, self.course.nodes[0])
        return found

    @cached_property
    @quiet
    def support(self) -> Any:
        """The force on the frame, from external and inertia forces (rows,) [N]."""
        return sum((part.force for part in self.parts), 0.0j * self.course.time)

    @cached_property
    @quiet
    def support_moment(self) -> Any:
        """The moment on the frame about the normal frame's origin (rows,) [N x length]."""
        pole, zero = self.statics.pole, 0.0 * self.course.time
        arms = (((part.point() - pole).conjugate() * part.force).imag + part.couple for part in self.parts)
        return sum(arms, zero)

    @cached_property
    @quiet
    def power(self) -> dict[str, Any]:
        """The power (rows,) [W] of every kind in POWERS."""
        zero = 0.0 * self.course.time
        acting: list[LoadedPart | KnownEffort] = [*self.parts, *self.efforts]
        return {kind: sum((own.power for own in acting if own.kind == kind), zero) for kind in POWERS}

    @cached_property
    @quiet
    def kinetic(self) -> Any:
        """The kinetic energy (rows,) [J]."""
        own = [one.kinetic for one in self.masses] + [one.kinetic for one in self._turning_rotors]
        return sum(own, 0.0 * self.course.time)

    @cached_property
    @quiet
    def kinetic_rate(self) -> Any:
        """The rate of the kinetic energy, from the accelerations (rows,) [W]."""
        own = [one.kinetic_rate for one in self.masses] + [one.kinetic_rate for one in self._turning_rotors]
        return sum(own, 0.0 * self.course.time)

    @cached_property
    @quiet
    def potential(self) -> Any:
        """The potential energy of gravity and springs (rows,) [J]."""
        heights = sum((mass.height(self.statics.pole) for mass in self.masses), 0.0 * self.course.time)
        return sum((own.potential for own in self.efforts), heights)

    @cached_property
    def rotors(self) -> dict[int, Any]:
        """The effort that the rotor of each actuator needs (rows,) [N m or N], which the members do not bear."""
        return {rotor.actuator: rotor.effort for rotor in self._turning_rotors}

    @cached_property
    @quiet
    def _turning_rotors(self) -> list[TurningRotor]:
        return [TurningRotor(self, rotor) for rotor in self.dynamics.rotors]


class TurningRotor:
    """The rotor of the motor of an actuator."""

    def __init__(self, loading: Loading, rotor: RotorInertia) -> None:
        actuator = loading.mechanism.actuators[rotor.actuator]
        _, rate, half = measured(loading.mechanism, actuator, loading.course.series).c
        self.actuator, torque = rotor.actuator, rotor.reflected * 2.0 * half
        self.effort = torque if actuator.rotary else torque / loading.metre
        self.kinetic = 0.5 * rotor.reflected * rate**2
        self.kinetic_rate = torque * rate
