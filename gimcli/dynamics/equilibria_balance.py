"""Generalised forces of weight, springs, loads and constant efforts at rest, with their exact derivatives.

    Q_a = -dV/da + sum of F.r_a + T w_a,    dQ_a/db

V is the potential of the weights, the springs and of all forces that have one: constant forces in the fixed frame,
constant torques, and efforts that are constant or have a table over their own input. Forces that turn with a member,
and loads with a table over an input, have none. Velocities are zero, so that dampers and friction do not act. Source:
Goldstein, Classical Mechanics, 1980, section 1.4 (generalised forces); the second derivatives are those of the
positions on the constraints.

The positions that a mechanism can take if some of its inputs are released are the solutions of F(x, u(q)) = 0: the
unknowns y = (x, q) are the coordinates of the moving nodes and the k released inputs. The directions of motion are
the null space of the Jacobian, so that limits and dead points of an input are ordinary positions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.jet import Jet
from gimcli.calculus.numbers import nominal, phase
from gimcli.canonical import beside
from gimcli.continuation.released import ReleasedPositions
from gimcli.dynamic_data import TIME, DrivingEffort, LoadCurve, Release, SpringForce
from gimcli.dynamics.kinematic_history import Course
from gimcli.dynamics.load_arrays import is_vector, moving_loads
from gimcli.dynamics.loading import Loading, LoadPart
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.statics import statics
from gimcli.kernels import laws
from gimcli.mechanism import SPAN, ComplexArray, FloatArray, Input, Mechanism
from gimcli.structure.carried import measured, unit_of


class PositionJet(NamedTuple):
    """Some positions, with the derivatives of nodes and inputs along k directions, in the normal frame."""

    nodes: Jet  # (nodes, rows)
    inputs: Jet  # (actuators, rows)


class Contribution(NamedTuple):
    """The generalised forces of a force or torque, and how the place or the angle on which it acts changes."""

    q: Dual  # (k, rows) J per unit of the directions, with derivatives
    potential: FloatArray | None  # (rows,) J
    amount: FloatArray | float  # (rows,) N in the normal frame, or N m, to which rounding is relative
    rates: ComplexArray | FloatArray  # (k, rows)
    turns: bool


def _contribution(
    on: Jet, work: Any, turns: bool = False, potential: FloatArray | None = None, amount: FloatArray | None = None
) -> Contribution:
    """Return what a force does; `work` is in J per unit of the place, angle or reading on which it acts.

    A constant force has a potential; of another one it is given if there is one.
    """
    if isinstance(work, Dual):
        q = (on.rates * np.conjugate(work)).real
    else:
        own = (on * np.conjugate(work)).real
        q, potential = own.rates, -own.value
    return Contribution(q, potential, np.abs(nominal(work)) if amount is None else amount, on.first, turns)


class StaticBalance:
    """The forces on a mechanism at rest, at one time of the loads.

    released: the inputs whose own constant efforts act.
    """

    def __init__(self, mechanism: Mechanism, released: tuple[int, ...], time: float) -> None:
        self.mechanism, dynamics = mechanism, mechanism.dynamics
        self.time, self.metre = np.array([time]), require_action(mechanism)
        self.efforts = [r for r in dynamics.releases if r.actuator in released and r.effort != DrivingEffort()]
        self.loads = moving_loads(mechanism)
        self.twisted = [s for s in dynamics.springs if mechanism.gauges[s.gauge].rotary]
        self.torques = [load for load in self.loads if load.torque]
        self.constant = self.loading((), ())

    def loading(self, nodes: Any, inputs: Any) -> Loading:
        """Return the forces at positions of the nodes and inputs."""
        return Loading(statics(self.mechanism), Course(self.time, inputs, nodes))

    @property
    def conservative(self) -> bool:
        """Whether all forces have a potential."""
        return not any(load.follows or (load.curve is not None and load.over != TIME) for load in self.loads)

    def initial_angles(self) -> FloatArray:
        """Return the angles (angles,) at the initial coordinates."""
        gauges = [self.mechanism.gauges[s.gauge].drawn for s in self.twisted]
        return np.array([*gauges, *(0.0 for _ in self.torques)])


class GeneralisedForces:
    """The forces at some positions, along k directions; J per unit of the directions."""

    def __init__(self, balance: StaticBalance, at: PositionJet, near: FloatArray | None = None) -> None:
        """Take positions.

        near: angles close to those of the first position (angles,), the others follow one another; or close to those
        of each position (angles, rows).
        """
        self.balance, self.at, self.near = balance, at, near
        self.mechanism, self.unit, self._row = balance.mechanism, balance.constant.unit, count()
        k, nodes, rows = at.nodes.first.shape
        self.z = [at.nodes[number] for number in range(nodes)]
        # (angles, rows) of torsion springs and of members with a torque, without jumps
        self.angles = np.zeros((len(balance.twisted) + len(balance.torques), rows))
        self.parts = list(self._parts())
        q = np.array([part.q.value for part in self.parts]).reshape(-1, k, rows)
        slope = np.array([part.q.slopes for part in self.parts]).reshape(-1, k, k, rows).swapaxes(1, 2)
        rest = [part.potential is None for part in self.parts]
        known = (part.potential for part in self.parts if part.potential is not None)
        self.potential: FloatArray = sum(known, np.zeros(rows))  # (rows,) J
        self.q, self.slope = q.sum(axis=0), slope.sum(axis=0)  # (k, rows) all forces, (k, k, rows) dQ_a / db
        self.rest, self.rest_slope = q[rest].sum(axis=0), slope[rest].sum(axis=0)  # of those without a potential
        self.size, self.steep = np.abs(q).sum(axis=0), np.abs(slope).sum(axis=0)  # sums of magnitudes

    def _parts(self) -> Iterator[Contribution]:
        for mass in self.balance.constant.masses:
            yield _contribution(mass.place(self.z), mass.work)
        yield from map(self._spring, self.mechanism.dynamics.springs)
        for load in self._loads():
            own = load.part.member
            on = self._followed(phase(unit_of(self.mechanism, self.z, own))) if load.turns else load.place(self.z)
            yield _contribution(on, load.work, load.turns)
        yield from map(self._drive, self.balance.efforts)

    def _loads(self) -> list[LoadPart]:
        """Return the loads in numbers with derivatives, as far as they depend on the position."""
        if self.balance.conservative:
            return self.balance.constant.loads
        return self.balance.loading((self.at.nodes.dual,), self.at.inputs.dual).loads

    def _spring(self, spring: SpringForce) -> Contribution:
        gauge, vector = self.mechanism.gauges[spring.gauge], is_vector(self.mechanism, spring)
        on = self.z[gauge.nodes[1]] - self.z[gauge.node] if vector else self._reading(gauge)
        value = np.abs(on.value) if vector else on.value
        potential, effort, stiffness = laws.spring(spring.law, value, self.unit(gauge.rotary))
        work = Dual(on.value * -stiffness if vector else effort, on.first * -stiffness)
        amount = np.maximum(stiffness * (np.abs(value) + abs(spring.free)), np.abs(effort))
        return _contribution(on, work, gauge.rotary, potential, amount)

    def _reading(self, gauge: Input) -> Any:
        """Return what a gauge measures: an angle, a length or a height."""
        with np.errstate(divide="ignore", invalid="ignore"):
            found = measured(self.mechanism, gauge, self.z)
        if gauge.rotary:
            return self._followed(found)
        if gauge.kind != SPAN:
            return found
        still = found.value == 0.0  # coincident nodes: the force has no determined direction
        return Jet(found.value, *(np.where(still, 0.0, part) for part in (found.first, found.second)))

    def _followed(self, angle: Jet) -> Jet:
        """Return an angle without jumps, and keep it in the next row of `angles`."""
        row, plain = next(self._row), angle.value
        if self.near is not None and self.near.ndim == 2:
            self.angles[row] = beside(plain, self.near[row])
        else:
            before = plain[:1] if self.near is None else self.near[row : row + 1]
            self.angles[row] = np.unwrap(np.concatenate([before, plain]))[1:]
        return Jet(self.angles[row], angle.first, angle.second)

    def _drive(self, release: Release) -> Contribution:
        value, rotary = self.at.inputs[release.actuator], self.mechanism.actuators[release.actuator].rotary
        unit, curve = self.unit(rotary), release.effort.curve
        work = release.effort.at(self.balance.time, value.dual, np.zeros(1)) * unit
        over = isinstance(work, Dual)  # a table over the input's own value
        return _contribution(value, work, rotary, -unit * _integral(curve, value.value) if curve and over else None)


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


def released_inputs_line(
    mechanism: Mechanism, released: Sequence[int], inputs: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return base (actuators,) and along (actuators, k) of u = base + along q through some inputs (actuators,).

    released: numbers of k actuators that follow no others; those that follow them move too, the others are held.
    """
    along = mechanism.following[:, [mechanism.drivers.index(k) for k in released]]
    values = mechanism.coupled(inputs)
    return values - along @ values[list(released)], along


def position_jet(positions: ReleasedPositions, y: FloatArray, first: FloatArray, second: FloatArray) -> PositionJet:
    """Return positions y (rows, n + k) with derivatives (j, rows, n + k) and (j, j, rows, n + k)."""
    system, nodes = positions.system, len(positions.mechanism.nodes)

    def by_node(v: FloatArray) -> ComplexArray:
        moved = np.moveaxis(v, -1, 0)
        placed = system.placed(np.zeros((nodes, *moved.shape[1:]), dtype=complex), moved[: system.n])
        return np.moveaxis(placed, 0, -2)

    rates, bends = (np.moveaxis(positions.input_rates(y, v), -1, -2) for v in (first, second))
    places = Jet(positions.nodes(y.T), by_node(first), by_node(second))
    return PositionJet(places, Jet(positions.inputs(y.T), rates, bends))
