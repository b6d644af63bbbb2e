"""Linearised equations of motion at rest: M s'' + C s' + K s = Q for small changes s of the released inputs.

    M = sum of m B_i.B_j + J w_i w_j,   K_ij = -dQ_i/ds_j = -sum of F.B_ij + dF/ds_j.B_i,   C = sum of c R_i R_j

with the first and second influence coefficients B_i = dp/ds_i and B_ij = d2p/ds_i ds_j of the points where forces act,
and R_i of the quantities that springs and dampers measure. All are exact, not differences: the kernels return the bias
a(s') = sum of B_ij s'_i s'_j, and B_ij = (a(e_i + e_j) - a(e_i) - a(e_j)) / 2. Source: Durango, Giraldo, Calle & Mesa
2014, eqs 1-6, for the coefficients; Meirovitch, Fundamentals of Vibrations, 2001, chapter 7, for M, C and K.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.dynamic_data import TIME
from gimcli.dynamics.kinematic_history import Course, reading
from gimcli.dynamics.load_arrays import acting, moving_loads, with_friction_gauges
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.reducer import release_of
from gimcli.errors import StructureError
from gimcli.kernels import influence, reduction
from gimcli.mechanism import ANGLE, SPAN, ComplexArray, FloatArray, Input, Mechanism
from gimcli.positions.dispatch import plain
from gimcli.structure.coordinate_partitioning import Choice, free_choice, input_choice, make_chart
from gimcli.structure.polynomials import Terms, is_rotary, make_terms, with_gauges
from gimcli.structure.steps import NONE


@dataclass(frozen=True)
class Linearised:
    """The linearised equations of motion of the released inputs at rest; SI units, by rad or m of the coordinates.

    The k coordinates are the released inputs. At a dead point of these inputs they do not determine the position; the
    coordinates are then x or y of nodes, or quantities that springs and dampers measure (`on_inputs` is false).
    """

    mechanism: Mechanism = field(repr=False)
    released: tuple[int, ...]  # actuators
    on_inputs: bool  # whether the coordinates are the released inputs
    names: tuple[str, ...]  # of the coordinates
    units: tuple[str, ...]  # "rad" or "m" of each coordinate
    z: ComplexArray = field(repr=False)  # (nodes,) normal frame
    inputs: FloatArray  # (actuators,) rad, or length in the normal frame
    gauges: FloatArray  # (gauges,) of springs and dampers: rad, counted through full turns, or normal length
    mass: FloatArray  # (k, k) symmetric; 0 if no masses are defined
    stiffness: FloatArray  # (k, k) derivatives of -effort; symmetric if `symmetric`
    damping: FloatArray  # (k, k)
    effort: FloatArray  # (k,) N m or N: of weight, springs, loads and driving efforts at rest; 0 in equilibrium
    effort_scale: FloatArray  # (k,) sum of the magnitudes of all forces times those of their influence coefficients
    potential: float  # J, of weight and springs
    symmetric: bool  # whether the forces are conservative: no load follows a member and no table depends on an input
    input_rates: FloatArray = field(repr=False)  # (k, actuators) rad or normal length by coordinate
    node_rates: ComplexArray = field(repr=False)  # (k, nodes) normal length by coordinate
    node_curvatures: ComplexArray = field(repr=False)  # (k, k, nodes) second derivatives

    @property
    def unbalance(self) -> FloatArray:
        """The remaining efforts relative to `effort_scale` (k,); 0 in equilibrium, at most about 1."""
        scale = np.where(self.effort_scale > 0.0, self.effort_scale, 1.0)
        return np.asarray(np.abs(self.effort) / scale)


def linearised(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, released: Sequence[int], time: float = 0.0, *,
    gauges: FloatArray | None = None,
) -> Linearised:  # fmt: skip
    """Return the linearised equations of motion at an assembled position, the inputs that are not released held.

    Args:
        mechanism: with masses, loads or springs.
        z: position (nodes,), normal frame.
        inputs: values of all actuators (actuators,), rad or length in the normal frame.
        released: numbers of the released actuators, at least one.
        time: argument of the tables over time [s].
        gauges: values of the gauges at a position nearby, such as `Linearised.gauges`: angles of torsion springs are
            continued from them; by default from the initial configuration.

    Raises:
        ModelError: no masses, loads or springs are defined, or the unit of length is not physical.
        StructureError: the position is singular, so that the motion from there is not unique.
    """
    return _Linearisation(mechanism, tuple(released), time).at(z, inputs, gauges)


class _Linearisation:
    def __init__(self, mechanism: Mechanism, released: tuple[int, ...], time: float) -> None:
        metre = require_action(mechanism)
        self.mechanism, self.released, self.time, self.metre = mechanism, released, time, metre
        self.held = tuple(k for k in range(len(mechanism.actuators)) if k not in released)
        read = with_friction_gauges(_with_releases(mechanism, released))
        self.terms, self.loads = make_terms(with_gauges(read)), moving_loads(read)
        self.acting = acting(read, released, metre)
        self.efforts = [release_of(read, k).effort for k in released]

    def at(self, z: ComplexArray, inputs: FloatArray, gauges: FloatArray | None) -> Linearised:
        v = self._variables(z, inputs, gauges)
        choice = input_choice(self.terms, v, self.released, self.held)
        on_inputs = choice is not None
        choice = choice or free_choice(self.terms, v, self.held, len(self.released))
        if choice is None:
            raise self._singular()
        directions = np.eye(len(self.released), len(choice.independent))
        self._differentiate(v, choice, directions)
        stiffness, scale = self._stiffness()
        reduced = self._reduced(choice, directions)
        unit = np.array([1.0 if self._turns(c) else self.metre for c in choice.independent[: len(self.released)]])
        both = unit[:, None] * unit
        return Linearised(
            self.mechanism, self.released, on_inputs, *self._named(choice), self.z, v[self._inputs].copy(),
            self._own_gauges(v), directions @ reduced.m @ directions.T / both, stiffness / both, self._damping() / both,
            directions @ reduced.q / unit, scale / unit, float(reduced.energy[reduction.POTENTIAL]), self._symmetric,
            self.r[:, : len(self.mechanism.actuators)] / unit[:, None], self.b / unit[:, None],
            self.bb / both[:, :, None],
        )  # fmt: skip

    # -- position and influence coefficients ----------------------------------------------------------

    @property
    def _inputs(self) -> slice:
        first = self.terms.first_reading
        return slice(first, first + len(self.mechanism.actuators))

    def _variables(self, z: ComplexArray, inputs: FloatArray, gauges: FloatArray | None) -> FloatArray:
        terms = self.terms
        v, first, own = np.zeros(terms.variables), terms.first_reading, len(inputs)
        v[0:first:2], v[1:first:2], v[-1] = z.real, z.imag, 1.0
        v[self._inputs] = inputs
        read = terms.mechanism.actuators[own:]
        near = [g.drawn for g in read]
        near[: len(self.mechanism.gauges)] = near[: len(self.mechanism.gauges)] if gauges is None else list(gauges)
        v[first + own : -1] = [_read(terms.mechanism, g, z, last) for g, last in zip(read, near, strict=True)]
        return v

    def _differentiate(self, v: FloatArray, choice: Choice, directions: FloatArray) -> None:
        """Compute first and second influence coefficients of nodes (b, bb) and readings (r, rr) along directions."""
        terms, k = self.terms, len(directions)
        self.chart = make_chart(terms, choice)
        self.place, self.room = _arrays(terms, self.chart)
        self.place.v[:] = v
        plain(influence.set_signs)(self.chart, self.place, self.room)
        bias = np.zeros((k, k, terms.variables))
        for i in range(k):
            for j in range(i + 1):
                both = directions[i] if i == j else directions[i] + directions[j]
                bias[i, j] = bias[j, i] = self._bias(both)
        for i in range(k):
            for j in range(i):
                bias[i, j] = bias[j, i] = 0.5 * (bias[i, j] - bias[i, i] - bias[j, j])
        self._bias(np.zeros(directions.shape[1]))
        first, rates = terms.first_reading, directions @ self.place.b
        v[:] = self.place.v
        self.z, self.b, self.bb = (x[..., 0:first:2] + 1j * x[..., 1:first:2] for x in (v, rates, bias))
        self.r, self.rr = rates[:, first:-1], bias[..., first:-1]

    def _bias(self, speeds: FloatArray) -> FloatArray:
        """Return the accelerations of all variables at constant speeds of the independent variables."""
        if not plain(influence.settle)(self.chart, self.place, speeds, self.room):
            raise self._singular()
        return self.room.acceleration.copy()

    def _singular(self) -> StructureError:
        return StructureError(
            f"{self.mechanism.name}: the position is singular, so that the motion from there is not unique; choose"
            " another position, or release other inputs"
        )

    # -- matrices -------------------------------------------------------------------------------------

    def _reduced(self, choice: Choice, directions: FloatArray) -> reduction.Reduced:
        """Return inertia, generalised forces at rest and energies in all independent variables."""
        size, v = len(choice.independent), self.place.v
        first = self.terms.first_reading
        factors = np.array([self._factor(load.curve, load.over) for load in self.loads])
        for k, (actuator, effort) in enumerate(zip(self.released, self.efforts, strict=True)):
            if effort.curve is not None:
                at = {"time": self.time, "value": v[first + actuator], "speed": 0.0}[effort.over]
                self.acting.motor[k, 0] = _value(effort.curve, at)
        out = reduction.Reduced(
            np.zeros((size, size)), np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(reduction.ENERGIES)
        )
        plain(reduction.reduce)(self.acting, self.place, self.room, factors, out)
        return out

    def _factor(self, curve: Callable[[FloatArray], FloatArray] | None, over: int) -> float:
        at = self.time if over == TIME else self.place.v[self.terms.first_reading + over]
        return 1.0 if curve is None else _value(curve, at)

    def _stiffness(self) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives of the generalised forces with the sign changed, and the scale of these forces."""
        k = len(self.b)
        self.total, self.scale = np.zeros((k, k)), np.zeros(k)
        self._add_weights()
        self._add_loads()
        self._add_springs()
        self._add_efforts()
        return -self.total, self.scale

    def _add_weights(self) -> None:
        p = self.acting
        gravity = complex(*p.gravity) * p.metre
        for (u, v), (x, y, mass, *_) in zip(p.masses, p.mass, strict=True):
            self.total += mass * (np.conj(gravity) * _carry(self.bb, u, v, complex(x, y))).real
            self.scale += mass * abs(gravity) * np.abs(_carry(self.b, u, v, complex(x, y)))

    def _add_loads(self) -> None:
        p = self.acting
        for load, (u, v, follows), (x, y, fx, fy, torque, square) in zip(self.loads, p.loads, p.load, strict=True):
            arm, point = self.z[v] - self.z[u], complex(x, y)
            force = complex(fx, fy) * p.metre * (arm if follows else 1.0)
            rates, turns = _carry(self.b, u, v, point), _turn(arm, self.b, u, v, square)
            along = (np.conj(force) * rates).real + torque * turns
            slopes = (np.conj(force) * _carry(self.bb, u, v, point)).real + torque * _turn(arm, self.bb, u, v, square)
            if follows:
                slopes = slopes + (np.conj(1j * force) * rates).real[:, None] * turns
            factor = self._factor(load.curve, load.over)
            self.total += factor * slopes
            self.scale += abs(factor) * (abs(force) * np.abs(rates) + abs(torque) * np.abs(turns))
            if load.curve is not None and load.over != TIME:
                at = self.place.v[self.terms.first_reading + load.over]
                self.total += load.curve.slope(at) * along[:, None] * self.r[:, load.over]

    def _add_springs(self) -> None:
        p, first, v = self.acting, self.terms.first_reading, self.place.v
        for (variable, kind), (stiffness, free) in zip(p.springs, p.spring, strict=True):
            r, value = variable - first, v[variable]
            stretch = value + free if kind == SPAN and value < 0.0 else value - free
            factor = stiffness * (1.0 if kind == ANGLE else p.metre**2)
            self.total -= factor * (self.r[:, r, None] * self.r[:, r] + stretch * self.rr[..., r])
            self.scale += factor * (abs(value) + abs(free)) * np.abs(self.r[:, r])

    def _add_efforts(self) -> None:
        """Add the driving efforts, which can depend on the value of their own inputs."""
        p, first = self.acting, self.terms.first_reading
        for k, (actuator, effort) in enumerate(zip(self.released, self.efforts, strict=True)):
            unit = 1.0 if p.motors[k, 1] else p.metre
            at = {"time": self.time, "value": self.place.v[first + actuator], "speed": 0.0}[effort.over]
            now = p.motor[k, 0] if effort.curve is None else _value(effort.curve, at)
            self.total += now * unit * self.rr[..., actuator]
            self.scale += abs(now) * unit * np.abs(self.r[:, actuator])
            if effort.curve is not None and effort.over == "value":
                self.total += effort.curve.slope(at) * unit * self.r[:, actuator, None] * self.r[:, actuator]

    def _damping(self) -> FloatArray:
        """Return the matrix of dampers, viscous friction, and driving efforts that depend on the speed."""
        p, first = self.acting, self.terms.first_reading
        total = np.zeros((len(self.b), len(self.b)))
        for (variable, angle), damping in zip(p.dampers, p.damper, strict=True):
            rates = self.r[:, variable - first] * (1.0 if angle else p.metre)
            total += damping * rates[:, None] * rates
        for (u, v, m, n), (damping, one, other) in zip(p.rubs, p.rub, strict=True):
            rates = self._turning(u, v, one) - self._turning(m, n, other)
            total += damping * rates[:, None] * rates
        for actuator, effort, (_, angle) in zip(self.released, self.efforts, p.motors, strict=True):
            unit, rates = 1.0 if angle else p.metre, self.r[:, actuator]
            slope = effort.curve.slope(0.0) if effort.curve is not None and effort.over == "speed" else 0.0
            if effort.idle:
                slope -= effort.constant / effort.idle
            total -= slope * unit * rates[:, None] * rates
        return total

    def _turning(self, u: int, v: int, square: float) -> FloatArray:
        return np.zeros(len(self.b)) if u == NONE else _turn(self.z[v] - self.z[u], self.b, u, v, square)

    # -- names ----------------------------------------------------------------------------------------

    @property
    def _symmetric(self) -> bool:
        loads = all(not p.follows and (p.curve is None or p.over == TIME) for p in self.loads)
        return loads or len(self.released) == 1

    def _own_gauges(self, v: FloatArray) -> FloatArray:
        return v[self._inputs.stop : self._inputs.stop + len(self.mechanism.gauges)].copy()

    def _turns(self, variable: int) -> bool:
        first = self.terms.first_reading
        return variable >= first and is_rotary(self.terms, variable - first)

    def _named(self, choice: Choice) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return the names and the units of the coordinates."""
        own, first = choice.independent[: len(self.released)], self.terms.first_reading
        nodes, readings = self.mechanism.nodes, self.terms.mechanism.actuators
        names = [readings[c - first].name if c >= first else f"{nodes[c // 2]}.{'xy'[c % 2]}" for c in own]
        return tuple(names), tuple("rad" if self._turns(c) else "m" for c in own)


def _with_releases(mechanism: Mechanism, released: Sequence[int]) -> Mechanism:
    """Return the mechanism in which exactly the released inputs are free, with the efforts of the file."""
    releases = [replace(release_of(mechanism, k), free=k in released) for k in range(len(mechanism.actuators))]
    return replace(mechanism, dynamics=replace(mechanism.dynamics, releases=tuple(releases)))


def _arrays(terms: Terms, chart: influence.Chart) -> tuple[influence.InfluencePosition, influence.InfluenceScratch]:
    """Return the arrays of a position and the scratch arrays for a chart."""
    size, blocks = len(chart.independent), len(chart.blocks)
    widest = max([1, size, *(b[2] - b[1] for b in chart.blocks)])
    place = influence.InfluencePosition(
        np.zeros(terms.variables), np.zeros((size, terms.variables)), np.zeros(blocks)
    )  # fmt: skip
    room = influence.InfluenceScratch(
        np.zeros((3, terms.functions)), np.zeros((widest, widest)), np.zeros(2 * widest), np.zeros(widest),
        np.zeros(terms.variables), np.zeros(terms.variables), np.zeros(size), np.zeros(1, dtype=np.int64), np.zeros(3),
    )  # fmt: skip
    room.f[0, 0] = 1.0
    return place, room


def _read(mechanism: Mechanism, gauge: Input, z: ComplexArray, near: float) -> float:
    """Return the value of a gauge at a position (nodes,); angles are within half a turn of `near`."""
    still = Course(np.zeros(1), np.zeros((0, 1)), np.array([z, np.zeros_like(z)])[:, :, None])
    value = float(reading(mechanism, gauge, still)[0][0])
    return value + 2.0 * math.pi * round((near - value) / (2.0 * math.pi)) if gauge.rotary else value


def _carry(x: ComplexArray, u: int, v: int, z: complex) -> ComplexArray:
    """Return the derivatives of the point u + z (v - u) from those of the nodes (..., nodes)."""
    return np.asarray(x[..., u] + z * (x[..., v] - x[..., u]))


def _turn(arm: complex, x: ComplexArray, u: int, v: int, square: float) -> FloatArray:
    """Return the derivatives of the direction of an arm from those of the nodes (..., nodes), first or second."""
    return np.asarray((np.conj(arm) * (x[..., v] - x[..., u])).imag / square)


def _value(curve: Callable[[FloatArray], FloatArray], at: float) -> float:
    return float(curve(np.array([at]))[0])
