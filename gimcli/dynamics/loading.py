"""Forces on each body along a motion (inertia, gravity, loads, springs, dampers, friction), and their power.

Forces are in N and positions in the normal frame, so moments are in N times the length unit of the normal frame. The
numbers are arrays over the rows, plain or dual, or numbers of a tape. Powers and energies are computed when they are
asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.calculus.numbers import RuleNumber
from gimcli.dynamic_data import NO_NODE, AppliedLoad, Inertia, RotorInertia, SpringForce
from gimcli.dynamics.kinematic_history import Course, Turns, reading, turning
from gimcli.dynamics.load_arrays import friction_pairs, is_vector, moving_loads
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.statics import Reaction, Statics, direction
from gimcli.kernels import laws
from gimcli.kernels.equilibrium import PUSH
from gimcli.mechanism import FRAME
from gimcli.structure.carried import carried, measured, unit_of
from gimcli.structure.steps import NONE

POWERS = ("load", "gravity", "spring", "damping")
"""Kinds of applied forces; the power of each kind is a column of the table."""

quiet = np.errstate(all="ignore")


class LoadedPart:
    """A mass or a load on a moving member, or on the pin of a node: the force at its point and the couple.

    Of a mass these are the weight less the inertia force, and less the inertia couple.
    """

    turns = False  # whether it is a torque on its member
    force: Any = 0.0  # (rows,) N
    couple: Any = 0.0  # (rows,) N x length

    def __init__(self, loading: Loading, part: Inertia | AppliedLoad, local: complex) -> None:
        self.part, self.local = part, local
        self.mechanism, self.course, self.metre = loading.statics.mechanism, loading.course, loading.metre

    def place(self, nodes: Any) -> Any:
        """Return the position of its point at positions of the nodes, or the velocity at velocities."""
        at_node = self.part.node != NO_NODE
        return nodes[self.part.node] if at_node else carried(self.mechanism, nodes, self.part.member, self.local)

    def point(self, order: int = 0) -> Any:
        """Return position, velocity or acceleration of the point (rows,)."""
        return self.place(self.course.nodes[order])

    def turning(self, order: int) -> Any:
        """Return omega or alpha of its member (order 1 or 2) (rows,)."""
        return turning(self.mechanism, self.course, self.part.member)[order - 1] if self.part.node == NO_NODE else 0.0

    @property
    def rate(self) -> Any:
        """The velocity of its point, or of a torque omega (rows,)."""
        return self.turning(1) if self.turns else self.point(1)


class MassPart(LoadedPart):
    """A mass with its weight."""

    kind = "gravity"

    def __init__(self, loading: Loading, part: Inertia) -> None:
        super().__init__(loading, part, part.centre)
        self.mass, self.moment = part.mass, part.moment
        self.weight = part.mass * self.mechanism.dynamics.gravity
        self.work = self.weight * self.metre

    @cached_property
    @quiet
    def force(self) -> Any:
        """The weight less the inertia force (rows,) [N]."""
        return self.weight - self.mass * self.metre * self.point(2)

    @cached_property
    @quiet
    def couple(self) -> Any:
        """Less the inertia couple (rows,) [N x length]."""
        return -self.moment / self.metre * self.turning(2)

    def height(self, pole: complex) -> Any:
        """Return the potential energy [J] (rows,), 0 at the pole."""
        return -((self.point() - pole).conjugate() * self.work).real

    @property
    def kinetic(self) -> Any:
        """The kinetic energy (rows,) [J]."""
        speed, omega = self.point(1), self.turning(1)
        return 0.5 * self.mass * self.metre**2 * (speed.conjugate() * speed).real + 0.5 * self.moment * omega**2

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
        self.turns = isinstance(part.torque, RuleNumber) or bool(np.any(part.torque))
        if self.turns:
            self.work = factor * part.torque
            self.couple = self.work / self.metre
        else:
            follows = part.follows
            unit = unit_of(self.mechanism, self.course.nodes[0], part.member) if follows else 1.0
            self.force = unit * part.force * factor
            self.work = self.force * self.metre


@dataclass(frozen=True)
class KnownEffort:
    """The effort of a spring, a damper or viscous friction, in the place of an unknown of the equations."""

    kind: str  # of POWERS
    reaction: Reaction
    effort: Any  # (rows,) N, or N x length; for a vector N by length
    amount: Any  # (rows,) N, or N m: the effort of a vector by its length
    work: Any  # (rows,) J per unit of its reading, of a vector complex
    rate: Any  # (rows,) of its reading
    potential: Any = 0.0  # (rows,) J


class Loading:
    """Forces and moments on the bodies, their power and energies."""

    def __init__(self, statics: Statics, course: Course, turns: Turns | None = None) -> None:
        """Take a motion; `turns` continues the angles of springs from one piece to the next."""
        self.statics, self.course = statics, course
        self.mechanism, self.dynamics = statics.mechanism, statics.mechanism.dynamics
        self.metre = require_action(self.mechanism)
        self.turns = Turns() if turns is None else turns

    @cached_property
    def gauges(self) -> list[tuple[Any, Any]]:
        """Value and rate (rows,) of each gauge."""
        found = []
        for number, gauge in enumerate(self.mechanism.gauges):
            value, rate = reading(self.mechanism, gauge, self.course)
            found.append((self.turns.followed(number, value, gauge.drawn) if gauge.rotary else value, rate))
        return found

    def unit(self, rotary: bool) -> Any:
        """Return the unit of a reading: 1 for an angle, else that of lengths [m]."""
        return 1.0 if rotary else self.metre

    @cached_property
    @quiet
    def masses(self) -> list[MassPart]:
        """The masses; the frame does not move."""
        return [MassPart(self, inertia) for inertia in self.dynamics.inertias if inertia.member != FRAME]

    @cached_property
    @quiet
    def loads(self) -> list[LoadPart]:
        """The loads on members that move."""
        return [LoadPart(self, load) for load in moving_loads(self.mechanism)]

    @cached_property
    @quiet
    def parts(self) -> list[LoadedPart]:
        """The masses and the loads."""
        return [*self.masses, *self.loads]

    @cached_property
    @quiet
    def efforts(self) -> list[KnownEffort]:
        """The efforts of springs, dampers, and viscous friction."""
        return [*map(self._spring, self.dynamics.springs), *self._viscous()]

    def _spring(self, spring: SpringForce) -> KnownEffort:
        gauge, reaction = self.mechanism.gauges[spring.gauge], self.statics.gauges[spring.gauge]
        value, rate = self.gauges[spring.gauge]
        unit = self.unit(gauge.rotary)
        potential, work, stiffness = laws.spring(spring.law, value, unit)
        if not is_vector(self.mechanism, spring):
            return KnownEffort("spring", reaction, work / self.metre, work / unit, work, rate, potential)
        # k (a - b), which is 0 where the ends meet
        arm, speed = (self.course.nodes[k][gauge.nodes[1]] - self.course.nodes[k][gauge.node] for k in range(2))
        work, pull = -stiffness * arm, -stiffness / self.metre
        potential = -0.5 * (work.conjugate() * arm).real
        return KnownEffort("spring", replace(reaction, kind=PUSH), pull, pull * value, work, speed, potential)

    def _viscous(self) -> Iterator[KnownEffort]:
        """Yield the efforts of dampers and of viscous friction."""
        gauges = self.mechanism.gauges
        found = [
            (
                self.statics.gauges[own.gauge],
                own.damping,
                self.gauges[own.gauge][1],
                self.unit(gauges[own.gauge].rotary),
            )
            for own in self.dynamics.dampers
        ]
        found += [
            (
                pair.reaction(self.statics),
                pair.friction.damping,
                pair.rate(self.mechanism, self.course),
                self.unit(pair.friction.slide == NONE),
            )
            for pair in friction_pairs(self.mechanism)
        ]
        for reaction, damping, rate, unit in found:
            work = laws.damper(damping, rate, unit)
            yield KnownEffort("damping", reaction, work / self.metre, work / unit, work, rate)

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
        return self._total(part.force for part in self.parts) + 0.0j

    @cached_property
    @quiet
    def support_moment(self) -> Any:
        """The moment on the frame about the normal frame's origin (rows,) [N x length]."""
        pole = self.statics.pole
        return self._total(((part.point() - pole).conjugate() * part.force).imag + part.couple for part in self.parts)

    @cached_property
    @quiet
    def power(self) -> dict[str, Any]:
        """The power (rows,) [W] of every kind in POWERS."""
        acting: list[Any] = [*self.parts, *self.efforts]
        return {
            kind: self._total((own.rate.conjugate() * own.work).real for own in acting if own.kind == kind)
            for kind in POWERS
        }

    @cached_property
    @quiet
    def kinetic(self) -> Any:
        """The kinetic energy (rows,) [J]."""
        return self._total(one.kinetic for one in (*self.masses, *self.rotors.values()))

    @cached_property
    @quiet
    def kinetic_rate(self) -> Any:
        """The rate of the kinetic energy, from the accelerations (rows,) [W]."""
        return self._total(one.kinetic_rate for one in (*self.masses, *self.rotors.values()))

    @cached_property
    @quiet
    def potential(self) -> Any:
        """The potential energy of gravity and springs (rows,) [J]."""
        heights = [mass.height(self.statics.pole) for mass in self.masses]
        return self._total([*heights, *(own.potential for own in self.efforts)])

    def _total(self, numbers: Iterable[Any]) -> Any:
        """Return the sum of some numbers (rows,)."""
        return sum(numbers, 0.0 * self.course.time)

    @cached_property
    @quiet
    def rotors(self) -> dict[int, Any]:
        """The rotors (`TurningRotor`) by the numbers of their actuators."""
        return {rotor.actuator: TurningRotor(self, rotor) for rotor in self.dynamics.rotors}


class TurningRotor:
    """The rotor of the motor of an actuator; its effort (rows,) [N m or N] is one that the members do not bear."""

    def __init__(self, loading: Loading, rotor: RotorInertia) -> None:
        actuator = loading.mechanism.actuators[rotor.actuator]
        _, rate, half = measured(loading.mechanism, actuator, loading.course.series).c
        torque = rotor.reflected * 2.0 * half
        self.effort = torque if actuator.rotary else torque / loading.metre
        self.kinetic = 0.5 * rotor.reflected * rate**2
        self.kinetic_rate = torque * rate
