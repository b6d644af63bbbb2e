"""Generalised forces of weight, springs, loads and constant efforts at rest, with their exact derivatives.

    Q_a = -dV/da + sum of F.r_a + T w_a,    dQ_a/db

V is the potential of the weights, the springs and of all forces that have one: constant forces in the fixed frame,
constant torques, and efforts that are constant or have a table over their own input. Forces that turn with a member,
and loads with a table over an input, have none. Velocities are zero, so that dampers and friction do not act. Source:
Goldstein, Classical Mechanics, 1980, section 1.4 (generalised forces); the second derivatives are those of the
positions on the constraints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.calculus.jet import Jet
from gimcli.dynamic_data import NO_NODE, TIME, AppliedLoad, Inertia, LoadCurve, SpringForce
from gimcli.dynamics.load_arrays import is_vector, moving_loads
from gimcli.dynamics.physical import require_action
from gimcli.mechanism import FRAME, SPAN, ComplexArray, FloatArray, Input, Mechanism


@dataclass(frozen=True)
class PositionJet:
    """Some positions, with the derivatives of nodes and inputs along k directions, in the normal frame."""

    nodes: ComplexArray  # (nodes, rows)
    first: ComplexArray  # (k, nodes, rows)
    second: ComplexArray  # (k, k, nodes, rows)
    inputs: FloatArray  # (actuators, rows)
    rates: FloatArray  # (k, actuators, rows): the inputs are linear in the directions
    bends: FloatArray  # (k, k, actuators, rows)

    def node(self, number: int) -> Jet:
        """Return the position of a node as a complex number."""
        return Jet(self.nodes[number], self.first[:, number], self.second[:, :, number])

    def input(self, number: int) -> Jet:
        """Return the value of an actuator [rad, or length of the normal frame]."""
        return Jet(self.inputs[number], self.rates[:, number], self.bends[:, :, number])


@dataclass(frozen=True)
class GeneralisedForces:
    """The forces at some positions, along k directions; J per unit of the directions."""

    potential: FloatArray  # (rows,) J
    q: FloatArray  # (k, rows) all generalised forces
    slope: FloatArray  # (k, k, rows) dQ_a / db
    rest: FloatArray  # (k, rows) the part of `q` that has no potential
    rest_slope: FloatArray  # (k, k, rows) its derivatives
    size: FloatArray  # (k, rows) sum of the magnitudes of all contributions
    stiffness: FloatArray  # (rows,) sum of the magnitudes of the contributions to `slope`
    angles: FloatArray  # (angles, rows) of torsion springs and of members with a torque, without jumps


class StaticBalance:
    """The forces on a mechanism at rest, at one time of the loads.

    released: the inputs whose own constant efforts act.
    """

    def __init__(self, mechanism: Mechanism, released: tuple[int, ...], time: float) -> None:
        self.mechanism, self.time = mechanism, time
        self.dynamics, self.metre = mechanism.dynamics, require_action(mechanism)
        self.efforts = [r for r in self.dynamics.releases if r.actuator in released]
        self.inertias = [i for i in self.dynamics.inertias if i.member != FRAME and i.mass]
        self.loads = moving_loads(mechanism)
        self.twisted = [s for s in self.dynamics.springs if mechanism.gauges[s.gauge].rotary]
        self.torques = [load for load in self.loads if load.torque]

    @property
    def conservative(self) -> bool:
        """Whether all forces have a potential."""
        return not any(load.follows or (load.curve is not None and load.over != TIME) for load in self.loads)

    def __call__(self, at: PositionJet, near: FloatArray | None = None) -> GeneralisedForces:
        """Return the forces at some positions.

        near: angles close to those of the first position (angles,), the others follow one another; or close to those
        of each position (angles, rows).
        """
        return _Sum(self, at, near).run()

    def initial_angles(self) -> FloatArray:
        """Return the angles (angles,) at the initial coordinates."""
        gauges = [self.mechanism.gauges[s.gauge].drawn for s in self.twisted]
        return np.array([*gauges, *(0.0 for _ in self.torques)])

    def factor(self, load: AppliedLoad, inputs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the factor of a load (rows,), and its derivative by the input of its table."""
        if load.curve is None or load.over == TIME:
            own = 1.0 if load.curve is None else float(load.curve(np.array([self.time]))[0])
            return np.full(inputs.shape[1], own), np.zeros(inputs.shape[1])
        return _table(load.curve, inputs[load.over])


class _Sum:
    """Adds the contributions of all forces."""

    def __init__(self, balance: StaticBalance, at: PositionJet, near: FloatArray | None) -> None:
        self.balance, self.at, self.near = balance, at, near
        self.mechanism, self.metre = balance.mechanism, balance.metre
        k, rows = len(at.first), at.nodes.shape[1]
        self.potential, self.stiffness = np.zeros(rows), np.zeros(rows)
        self.q, self.rest, self.size = (np.zeros((k, rows)) for _ in range(3))
        self.slope, self.rest_slope = np.zeros((k, k, rows)), np.zeros((k, k, rows))
        self.angles = np.zeros((len(balance.twisted) + len(balance.torques), rows))

    def run(self) -> GeneralisedForces:
        for part in self.balance.inertias:
            pull = part.mass * self.balance.dynamics.gravity * self.metre
            self._add_potential((self._point(part, part.centre) * -np.conj(pull)).real)
        for spring in self.balance.dynamics.springs:
            self._add_spring(spring)
        for load in self.balance.loads:
            self._add_load(load)
        for release in self.balance.efforts:
            self._add_effort(release.actuator)
        return GeneralisedForces(
            self.potential, self.q, self.slope, self.rest, self.rest_slope, self.size, self.stiffness, self.angles
        )  # fmt: skip

    def _add_potential(self, v: Jet) -> None:
        self.potential += v.value
        self._add(-v.first, -v.second)

    def _add(self, q: FloatArray, slope: FloatArray) -> None:
        self.q += q
        self.slope += slope
        self.size += np.abs(q)
        self.stiffness += np.sqrt(np.sum(slope**2, axis=(0, 1)))

    def _add_rest(self, q: FloatArray, slope: FloatArray) -> None:
        """Add a force without a potential."""
        self._add(q, slope)
        self.rest += q
        self.rest_slope += slope

    # -- springs --------------------------------------------------------------------------------------

    def _add_spring(self, spring: SpringForce) -> None:
        gauge, stiffness, free = self.mechanism.gauges[spring.gauge], spring.stiffness, spring.free
        if gauge.rotary:
            row = [s.gauge for s in self.balance.twisted].index(spring.gauge)
            stretch = self._between(gauge, row) - free
        elif is_vector(self.mechanism, spring):
            arm = self.at.node(gauge.nodes[1]) - self.at.node(gauge.node)
            self._add_potential((arm * arm.conjugate()).real * (0.5 * stiffness * self.metre**2))
            return
        else:
            stretch = (self._length(gauge) if gauge.kind == SPAN else self._height(gauge)) - free
            stiffness = stiffness * self.metre**2
        self._add_potential(stretch * stretch * (0.5 * stiffness))

    def _length(self, gauge: Input) -> Any:
        arm = self.at.node(gauge.nodes[1]) - self.at.node(gauge.node)
        square = (arm * arm.conjugate()).real
        length = np.sqrt(square.value)
        safe = np.where(length > 0.0, length, np.inf)  # coincident nodes: the direction of the force is not determined
        return square.through(length, 0.5 / safe, -0.25 / safe**3)

    def _height(self, gauge: Input) -> Any:
        unit = self._unit(gauge.guide) * complex(gauge.normal)
        away = self.at.node(gauge.node) - self._on_member(gauge.guide, gauge.point)
        return (away * unit.conjugate()).real

    def _between(self, gauge: Input, row: int) -> Jet:
        """Return the angle between two members, without jumps from row to row."""
        one, other = self._unit(gauge.members[0]) * complex(gauge.arm), self._unit(gauge.guide) * gauge.reference
        return self._angle(one * other.conjugate(), row)

    def _angle(self, unit: Jet, row: int) -> Jet:
        """Return the angle of a complex number of modulus 1, and keep it in a row of `angles`."""
        plain = np.angle(unit.value)
        if self.near is not None and self.near.ndim == 2:
            turn = 2.0 * np.pi
            self.angles[row] = plain + turn * np.round((self.near[row] - plain) / turn)
        else:
            before = plain[:1] if self.near is None else self.near[row : row + 1]
            self.angles[row] = np.unwrap(np.concatenate([before, plain]))[1:]
        first = (unit.conjugate().value * unit.first).imag
        second = (unit.conjugate().value * unit.second).imag
        return Jet(self.angles[row], first, second)  # (e^(i a))_ab = (i a_ab - a_a a_b) e^(i a)

    # -- loads ----------------------------------------------------------------------------------------

    def _add_load(self, load: AppliedLoad) -> None:
        factor, growth = self.balance.factor(load, self.at.inputs)
        over = self.at.input(load.over) if load.over != TIME else None
        if load.torque:
            row = len(self.balance.twisted) + [id(one) for one in self.balance.torques].index(id(load))
            self._add_force(self._angle(self._unit(load.member), row) * load.torque, factor, growth, over)
            return
        point, force = self._point(load, load.point), load.force * self.metre
        if load.follows:
            self._add_follower(load, point, factor, growth, over)
        else:
            self._add_force((point * np.conj(force)).real, factor, growth, over)

    def _add_force(self, work: Jet, factor: FloatArray, growth: FloatArray, over: Jet | None) -> None:
        """Add a force whose work at the factor 1 is a function of the position."""
        if over is None:
            self._add_potential(work * -float(factor[0]))
            return
        self._add_rest(factor * work.first, factor * work.second + growth * work.first[:, None] * over.first[None, :])

    def _add_follower(
        self, load: AppliedLoad, point: Jet, factor: FloatArray, growth: FloatArray, over: Jet | None
    ) -> None:
        """Add a force that turns with its member."""
        unit = self._unit(load.member) * (load.force * self.metre)
        force = Jet(unit.value.conj() * factor, unit.first.conj() * factor, unit.second)
        if over is not None:
            force = Jet(force.value, force.first + growth * unit.value.conj() * over.first, force.second)
        slope = force.value * point.second + point.first[:, None] * force.first[None, :]
        self._add_rest((force.value * point.first).real, slope.real)

    def _add_effort(self, number: int) -> None:
        effort = next(r.effort for r in self.balance.efforts if r.actuator == number)
        value = self.at.input(number)
        unit = 1.0 if self.mechanism.actuators[number].rotary else self.metre
        if effort.curve is not None and effort.over == "value":
            force, slope = _table(effort.curve, value.value)
            self._add_potential(value.through(_integral(effort.curve, value.value), force, slope) * -unit)
            return
        at = self.balance.time if effort.over == "time" else 0.0  # over the speed: at rest
        constant_force = effort.constant if effort.curve is None else float(effort.curve(np.array([at]))[0])
        self._add_potential(value * (-constant_force * unit))

    # -- positions ------------------------------------------------------------------------------------

    def _point(self, part: Inertia | AppliedLoad, local: complex) -> Any:
        return self.at.node(part.node) if part.node != NO_NODE else self._on_member(part.member, local)

    def _on_member(self, number: int, local: complex) -> Any:
        """Return the position of a point fixed to a member."""
        if number == FRAME:
            return local
        member = self.mechanism.members[number]
        u, v, span = member.ends
        share = (local - complex(member.shape[0])) / span
        return self.at.node(u) + (self.at.node(v) - self.at.node(u)) * share

    def _unit(self, number: int) -> Any:
        """Return e^(i phi) of a member."""
        if number == FRAME:
            return 1.0 + 0.0j
        u, v, span = self.mechanism.members[number].ends
        return (self.at.node(v) - self.at.node(u)) * (1.0 / span)


def _integral(curve: LoadCurve, at: FloatArray) -> FloatArray:
    """Return the integral of a table from its first sample to some places (rows,); it is cubic between samples."""
    knots = np.concatenate([curve.at, np.clip(at, curve.at[0], curve.at[-1])])
    order = np.argsort(knots, kind="stable")
    low, high = knots[order][:-1], knots[order][1:]
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    pieces = half * (curve(middle - half / np.sqrt(3.0)) + curve(middle + half / np.sqrt(3.0)))  # Gauss, two points
    total = np.zeros(len(knots))
    total[order[1:]] = np.cumsum(pieces)
    inside = total[len(curve.at) :]
    return np.asarray(inside + curve(at) * (at - knots[len(curve.at) :]))


def _table(curve: LoadCurve, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the values of a table (rows,) and their slopes."""
    return curve(at), np.array([curve.slope(float(place)) for place in at])
