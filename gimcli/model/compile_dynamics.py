"""Compiler of masses, loads, springs, dampers and friction: from the file's units to SI and the normal frame."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gimcli.calculus.numbers import places, scalar
from gimcli.dynamic_data import (
    NO_MEMBER,
    NO_NODE,
    TIME,
    AppliedLoad,
    DampingForce,
    DrivingEffort,
    Friction,
    Inertia,
    Release,
    RotorInertia,
    SpringForce,
)
from gimcli.mechanism import FRAME, HEIGHT, Dynamics, Input, PairRow
from gimcli.model import schema
from gimcli.model.compile_geometry import GeometryCompiler
from gimcli.model.laws import Sampled
from gimcli.model.pairs import node_of
from gimcli.model.tables import read_table
from gimcli.model.units import KILOGRAMS, METRES


class DynamicsCompiler:
    """Compiles the dynamic sections of a model after its members have been compiled."""

    def __init__(self, own: GeometryCompiler, pairs: tuple[PairRow, ...], actuators: tuple[Input, ...]) -> None:
        self.own, self.model, self.actuators = own, own.model, actuators
        self.slides = [row.pair for row in pairs if row.kind == HEIGHT]
        self.number = own.number
        self.gauges: list[Input] = []

    def compile(self) -> tuple[Dynamics, tuple[Input, ...]]:
        """Return the dynamic data, and the gauges that springs and dampers measure."""
        model = self.model
        metre = METRES.get(model.units.length)
        dynamics = Dynamics(
            metre=None if metre is None else metre * self.own.scale,
            inertias=tuple(self._inertia(name, mass) for name, mass in model.masses.items()),
            gravity=_vector(model.gravity),
            loads=tuple(self._load(name, load) for name, load in model.loads.items()),
            springs=tuple(self._spring(name, spring) for name, spring in model.springs.items()),
            dampers=tuple(DampingForce(n, self._gauge(n, d), d.damping) for n, d in model.dampers.items()),
            frictions=tuple(self._friction(name, part) for name, part in model.friction.items()),
            releases=tuple(self._release(k, name) for k, name in enumerate(model.actuators)),
            rotors=tuple(
                RotorInertia(k, r.inertia, r.ratio if r.lead is None else 2.0 * math.pi * self.own.scale / r.lead)
                for k, r in enumerate(actuator.rotor for actuator in model.actuators.values())
                if r is not None
            ),
        )
        return dynamics, tuple(self.gauges)

    def _inertia(self, name: str, mass: schema.Mass) -> Inertia:
        own, known = mass.mass * KILOGRAMS[self.model.units.mass], mass.inertia is not None
        if (node := node_of(self.model, name)) is not None:
            index, place, number = self._at(node)
            return Inertia(index, own, 0.0, place, node=number)
        number = self.number[name]
        if mass.centre is None:
            centre = scalar(self.own.members[number].shape.sum() / len(self.own.members[number].shape))
        else:
            centre = self.own.carried(name, None, mass.centre)
        return Inertia(number, own, _number(mass.inertia), centre, known)

    def _load(self, name: str, load: schema.Load) -> AppliedLoad:
        force, turning = _vector(load.force or load.follower), load.follower is not None
        node = node_of(self.model, load.on)
        member, point, number = (self.number[load.on], 0.0j, NO_NODE) if node is None else self._at(node)
        if load.torque is None and node is None:
            point = self.own.carried(load.on, load.at, load.local)
        over, curve = TIME, None
        if load.table is not None:
            over = TIME if load.over == "time" else list(self.model.actuators).index(load.over)
            curve = self._sampled(load.table, 1.0 if over == TIME else self.own.units[self.actuators[over].rotary])
        return AppliedLoad(name, member, point, force, _number(load.torque), turning, curve, over, number)

    def _sampled(self, table: str, unit: float) -> Sampled:
        """Return the curve of a table whose first column has a unit."""
        at, value = read_table(self.own.folder / table)
        return Sampled([place * unit for place in at], value)

    def _at(self, node: str) -> tuple[int, complex, int]:
        """Return the member of a part at a node, its point of the member, and the node; a fixed one has no node."""
        number = self.own.names.index(node)
        if number in self.own.members[FRAME].nodes:
            return FRAME, scalar(self.own.drawn[number]), NO_NODE
        return NO_MEMBER, 0.0j, number

    def _gauge(self, name: str, part: schema.Gauge) -> int:
        self.gauges.append(self.own.quantity(name, part))
        return len(self.gauges) - 1

    def _spring(self, name: str, spring: schema.Spring) -> SpringForce:
        k = self._gauge(name, spring)
        gauge = self.gauges[k]
        free = gauge.drawn if spring.free is None else spring.free * self.own.units[gauge.rotary]
        return SpringForce(name, k, spring.stiffness, free)

    def _friction(self, name: str, part: schema.PairFriction) -> Friction:
        sliding = name in self.model.prismatic
        node, slide = (-1, self.slides.index(name)) if sliding else (self.own.names.index(name), -1)
        radius, length = (_number(value) / self.own.scale for value in (part.radius, part.length))
        return Friction(name, _number(part.viscous), node, slide, _number(part.mu), radius, length)

    def _release(self, k: int, name: str) -> Release:
        actuator, unit = self.model.actuators[name], self.own.units[self.actuators[k].rotary]
        start = None if actuator.start is None else actuator.start * unit
        return Release(k, actuator.free, start, actuator.speed * unit, self._effort(actuator.effort, unit))

    def _effort(self, effort: schema.Effort | None, unit: float) -> DrivingEffort:
        if effort is None:
            return DrivingEffort()
        if effort.table is not None:
            curve = self._sampled(effort.table, 1.0 if effort.over == "time" else unit)
            return DrivingEffort(curve=curve, over=effort.over)
        if effort.stall is not None:
            return DrivingEffort(constant=effort.stall, idle=(effort.idle or 0.0) * unit)
        return DrivingEffort(effort.constant or 0.0)


def _number(given: float | None) -> float:
    """Return a number of the file, 0 if it is not given; a recorded number stays one, also if its value is 0."""
    return 0.0 if given is None else given


def _vector(pair: Sequence[float] | None) -> complex:
    """Return x + iy of a pair of numbers; 0 if there is none."""
    return scalar(places([pair or (0.0, 0.0)])[0])  # type: ignore[no-any-return]  # or recorded
