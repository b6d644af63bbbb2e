"""Forces on each body along a motion (inertia, gravity, loads, springs, dampers, friction), and their power.

Forces are in N and positions in the normal frame, so moments are in N times the length unit of the normal frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gimcli.dynamic_data import NO_NODE, AppliedLoad, Inertia, RotorInertia
from gimcli.dynamics.kinematic_history import (
    Course,
    Turns,
    reading,
    travel_along,
    turning,
)
from gimcli.dynamics.load_arrays import is_vector
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.statics import Statics
from gimcli.mechanism import FRAME, SPAN, ComplexArray, FloatArray, Input
from gimcli.structure.carried import carried, measured, unit_of
from gimcli.structure.steps import NONE

POWERS = ("load", "gravity", "spring", "damping")
"""Kinds of applied forces; the power of each kind is a column of the table."""


@dataclass
class Loading:
    """Forces and moments on the bodies, their power and energies."""

    force: ComplexArray  # (bodies, rows) N, applied
    moment: FloatArray  # (bodies, rows) N x length, about each body's node
    inertia_force: ComplexArray  # (bodies, rows) N, mass times acceleration
    inertia_moment: FloatArray  # (bodies, rows) N x length
    pins: dict[int, ComplexArray]  # (rows,) N applied to a node's pin, by node
    support: ComplexArray  # (rows,) N on the frame, from external and inertia forces
    support_moment: FloatArray  # (rows,) N x length, about the normal frame's origin
    power: dict[str, FloatArray]  # (rows,) W, of every kind in POWERS
    kinetic: FloatArray  # (rows,) J
    kinetic_rate: FloatArray  # (rows,) W, from the accelerations
    potential: FloatArray  # (rows,) J, of gravity and springs
    gauges: dict[int, tuple[FloatArray, FloatArray]] = field(default_factory=dict)  # (rows,) value and rate
    rotors: dict[int, FloatArray] = field(default_factory=dict)  # (rows,) N m or N, effort that a rotor needs, by input


def loading(statics: Statics, course: Course, turns: Turns | None = None) -> Loading:
    """Return the forces along a motion; `turns` continues the angles of springs from one piece to the next."""
    return _Loader(statics, course, turns if turns is not None else Turns()).run()


class _Loader:
    def __init__(self, statics: Statics, course: Course, turns: Turns) -> None:
        self.statics, self.course, self.turns = statics, course, turns
        self.mechanism = statics.mechanism
        self.dynamics = self.mechanism.dynamics
        self.metre = require_action(self.mechanism)
        rows, bodies = len(course.time), len(statics.bodies)
        zero = np.zeros(rows)
        self.found = Loading(
            np.zeros((bodies, rows), dtype=complex), np.zeros((bodies, rows)), np.zeros((bodies, rows), dtype=complex),
            np.zeros((bodies, rows)), {}, zero.astype(complex), zero.copy(), {kind: zero.copy() for kind in POWERS},
            zero.copy(), zero.copy(), zero.copy(),
        )  # fmt: skip

    def run(self) -> Loading:
        with np.errstate(all="ignore"):
            for inertia in self.dynamics.inertias:
                if inertia.member != FRAME:  # the frame does not move
                    self._inertia(inertia)
            for load in self.dynamics.loads:
                if load.member != FRAME:
                    self._load(load)
            for number in range(len(self.mechanism.gauges)):
                self._gauge(number)
            self._friction()
            for rotor in self.dynamics.rotors:
                self._rotor(rotor)
        return self.found

    # -- forces on a body -----------------------------------------------------------------------

    def _arm(self, body: int, place: ComplexArray) -> ComplexArray:
        return np.asarray(place - self.course.nodes[0, self.statics.bodies[body].node])

    def _push(self, body: int, place: ComplexArray, force: ComplexArray) -> None:
        """Apply a force to a body; nothing is stored for the frame."""
        if body != NONE:
            self.found.force[body] += force
            self.found.moment[body] += (self._arm(body, place).conj() * force).imag

    def _twist(self, member: int, torque: FloatArray) -> None:
        if member != FRAME:
            self.found.moment[self.statics.body_of_member[member]] += torque / self.metre

    def _outside(self, place: ComplexArray, force: ComplexArray) -> None:
        """Add an external or inertia force to the force on the frame."""
        self.found.support += force
        self.found.support_moment += ((place - self.statics.pole).conj() * force).imag

    def _act(self, part: Inertia | AppliedLoad, place: ComplexArray, force: ComplexArray) -> None:
        """Apply a force to the member of a part at a point, or to the pin of its node."""
        if part.node != NO_NODE:
            self._pin(part.node, force)
        else:
            self._push(self.statics.body_of_member[part.member], place, force)

    def _body(self, part: Inertia) -> int:
        """Return the body with a mass; the pin of a node belongs to its first member."""
        statics = self.statics
        return statics.body_of_member[part.member] if part.node == NO_NODE else statics.body_of_pin[part.node]

    def _carried(self, part: Inertia | AppliedLoad, local: complex) -> ComplexArray:
        """Return position, velocity and acceleration of the point of a part (3, rows)."""
        if part.node != NO_NODE:
            return np.asarray(self.course.nodes[:, part.node])
        return np.asarray(carried(self.mechanism, self.course.nodes.swapaxes(0, 1), part.member, local))

    # -- kinds ------------------------------------------------------------------------------------

    def _inertia(self, inertia: Inertia) -> None:
        found, metre, mass = self.found, self.metre, inertia.mass
        body, (place, speed, gain) = self._body(inertia), self._carried(inertia, inertia.centre)
        omega, alpha = np.zeros((2, len(place)))
        inertial = mass * metre * gain
        if inertia.node == NO_NODE:
            omega, alpha = turning(self.mechanism, self.course, inertia.member)
        else:
            found.pins[inertia.node] = found.pins.get(inertia.node, 0.0) - inertial
        found.inertia_force[body] += inertial
        spin = inertia.moment / metre * alpha
        found.inertia_moment[body] += (self._arm(body, place).conj() * inertial).imag + spin
        self._outside(place, -inertial)
        found.support_moment -= spin
        found.kinetic += 0.5 * mass * metre**2 * np.abs(speed) ** 2 + 0.5 * inertia.moment * omega**2
        found.kinetic_rate += metre * (speed.conj() * inertial).real + inertia.moment * omega * alpha
        if np.any(self.dynamics.gravity):
            weight = np.full(len(place), mass * self.dynamics.gravity)
            self._act(inertia, place, weight)
            self._outside(place, weight)
            found.power["gravity"] += metre * (speed.conj() * weight).real
            found.potential -= metre * ((place - self.statics.pole).conj() * weight).real

    def _rotor(self, rotor: RotorInertia) -> None:
        """Add the kinetic energy of a rotor, and the effort for it, which the members do not bear."""
        actuator = self.mechanism.actuators[rotor.actuator]
        _, rate, half = measured(self.mechanism, actuator, self.course.series).c
        effort = rotor.reflected * 2.0 * half
        self.found.rotors[rotor.actuator] = effort if actuator.rotary else effort / self.metre
        self.found.kinetic += 0.5 * rotor.reflected * rate**2
        self.found.kinetic_rate += effort * rate

    def _load(self, load: AppliedLoad) -> None:
        mechanism, nodes = self.mechanism, self.course.nodes
        factor = load.factor(self.course.time, self.course.inputs)
        if np.any(load.torque):
            torque = np.broadcast_to(factor * load.torque, self.course.time.shape)
            self._twist(load.member, torque)
            self.found.support_moment += torque / self.metre
            self.found.power["load"] += torque * turning(mechanism, self.course, load.member)[0]
            return
        place, speed, _ = self._carried(load, load.point)
        force = (
            load.force * (unit_of(mechanism, nodes[0], load.member) if load.follows else np.ones(len(place))) * factor
        )
        self._act(load, place, force)
        self._outside(place, force)
        self.found.power["load"] += self.metre * (speed.conj() * force).real

    def _gauge(self, number: int) -> None:
        """Apply the efforts of the springs and dampers on one gauge."""
        gauge = self.mechanism.gauges[number]
        value, rate, unit = reading(self.mechanism, gauge, self.course)
        metre = 1.0 if gauge.rotary else self.metre
        if gauge.rotary:
            value = self.turns.followed(number, value, gauge.drawn)
        self.found.gauges[number] = value, rate
        for spring in (s for s in self.dynamics.springs if s.gauge == number):
            if is_vector(self.mechanism, spring):
                self._vector(spring.stiffness, gauge)
                continue
            stretch = metre * (value - spring.free)
            self.found.potential += 0.5 * spring.stiffness * stretch**2
            self.found.power["spring"] -= spring.stiffness * stretch * metre * rate
            self._effort(number, -spring.stiffness * stretch, unit)
        for damper in (d for d in self.dynamics.dampers if d.gauge == number):
            self.found.power["damping"] -= damper.damping * (metre * rate) ** 2
            self._effort(number, -damper.damping * metre * rate, unit)

    def _vector(self, stiffness: float, gauge: Input) -> None:
        """Apply a spring of free length 0, the vector k (a - b); it is 0 where the ends meet."""
        arm, speed = self.course.nodes[:2, gauge.nodes[1]] - self.course.nodes[:2, gauge.node]
        force = -stiffness * self.metre * arm
        self.found.potential += 0.5 * stiffness * (self.metre * np.abs(arm)) ** 2
        self.found.power["spring"] += self.metre * (speed.conj() * force).real
        self._pin(gauge.nodes[1], force)
        self._pin(gauge.node, -force)

    def _effort(self, number: int, effort: FloatArray, unit: ComplexArray) -> None:
        """Apply a torque [N m] or force [N], positive in the direction in which the gauge's value increases."""
        gauge = self.mechanism.gauges[number]
        if gauge.rotary:
            self._twist(gauge.members[0], effort)
            self._twist(gauge.guide, -effort)
            return
        if gauge.kind == SPAN:
            self._pin(gauge.nodes[1], effort * unit)
            self._pin(gauge.node, -effort * unit)
        else:
            guide = self.statics.body_of_member[gauge.guide]
            self._slide(gauge.node, self.statics.pushed[number], guide, effort * unit)

    def _slide(self, node: int, body: int, guide: int, force: ComplexArray) -> None:
        """Apply a force at a node to a body, or to the node's pin if it is NONE, and the opposite one to a guide."""
        place = self.course.nodes[0, node]
        if body == NONE:
            self._pin(node, force)
        else:
            self._push(body, place, force)
        self._push(guide, place, -force)

    def _pin(self, node: int, force: ComplexArray) -> None:
        self.found.pins[node] = self.found.pins.get(node, 0.0) + force
        self._push(self.statics.body_of_pin[node], self.course.nodes[0, node], force)

    def _friction(self) -> None:
        mechanism = self.mechanism
        for friction in self.dynamics.frictions:
            if friction.slide >= 0:
                self._rub(friction.slide, friction.damping)
                continue
            members = next(pin.members for pin in self.statics.pins if pin.node == friction.node)
            own = turning(mechanism, self.course, members[0])[0]
            for member in members[1:]:
                speed = turning(mechanism, self.course, member)[0] - own
                self._twist(member, -friction.damping * speed)
                self._twist(members[0], friction.damping * speed)
                self.found.power["damping"] -= friction.damping * speed**2

    def _rub(self, number: int, damping: float) -> None:
        """Apply the friction of a sliding pair at its first node."""
        mechanism, slide = self.mechanism, self.mechanism.slides[number]
        _, rate, unit = reading(mechanism, travel_along(slide, slide.name), self.course)
        force = -damping * self.metre * rate * unit
        normal = self.statics.normals[number]
        reaction = self.statics.reactions[normal]
        self._slide(slide.node, NONE if normal in self.statics.on_pins else reaction.plus, reaction.minus, force)
        self.found.power["damping"] -= damping * (self.metre * rate) ** 2
