"""Linearised equations of motion at rest: M s'' + C s' + K s = Q for small changes s of the released inputs.

    M = sum of m B_i.B_j + J w_i w_j,   K_ij = -dQ_i/ds_j = -sum of F.B_ij + dF/ds_j.B_i,   C = sum of c R_i R_j

with the first and second influence coefficients B_i = dp/ds_i and B_ij = d2p/ds_i ds_j of the points where forces act,
and R_i of the quantities that springs and dampers measure. All are exact, not differences: the kernels return the bias
a(s') = sum of B_ij s'_i s'_j, and B_ij = (a(e_i + e_j) - a(e_i) - a(e_j)) / 2. Source: Durango, Giraldo, Calle & Mesa
2014, eqs 1-6, for the coefficients; Meirovitch, Fundamentals of Vibrations, 2001, chapter 7, for M, C and K.

The equilibrium that a mechanism reaches when it moves slowly under its forces is found by steps of these. Each step
solves K d = Q; where K is not positive definite, the magnitudes of its eigenvalues are used, so that the steps follow
the forces towards a stable equilibrium. Source: Nocedal & Wright, Numerical Optimization, 2006, section 3.4 (modified
Newton's method).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from gimcli.calculus.jet import Jet
from gimcli.dynamic_data import DrivingEffort
from gimcli.dynamics.equilibria_balance import GeneralisedForces, PositionJet, StaticBalance
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.reducer import ReducedEquations, release_of, with_released
from gimcli.errors import StructureError
from gimcli.kernels import influence, reduction
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.numerics.follower import Follower
from gimcli.positions.dispatch import plain
from gimcli.status import Status
from gimcli.structure.coordinate_partitioning import Choice, free_choice, input_choice

LEVER = 1e-3
"""Least lever of a force in its scale, relative to the greatest of all nodes; without a lever a force is balanced."""

NEARLY = 1e-6
"""Ratio of singular values below which steps end at a singular position: it is found to half the digits only."""


@dataclass(frozen=True)
class Linearised:
    """The linearised equations of motion of the released inputs at rest; SI units, by rad or m of the coordinates.

    The k coordinates are the released inputs. At a dead point of these inputs they do not determine the position; the
    coordinates are then x or y of nodes, or quantities that springs and dampers measure.
    """

    mechanism: Mechanism = field(repr=False)
    released: tuple[int, ...]  # actuators
    names: tuple[str, ...]  # of the coordinates
    units: tuple[str, ...]  # "rad" or "m" of each coordinate
    z: ComplexArray = field(repr=False)  # (nodes,) normal frame
    inputs: FloatArray  # (actuators,) rad, or length in the normal frame
    gauges: FloatArray  # (gauges,) of springs and dampers: rad, counted through full turns, or normal length
    mass: FloatArray  # (k, k) symmetric; 0 if no masses are defined
    stiffness: FloatArray  # (k, k) derivatives of -effort; symmetric if `symmetric`
    stiffness_scale: FloatArray  # (k, k) sum of the magnitudes of all contributions: what rounding is relative to
    damping: FloatArray  # (k, k)
    effort: FloatArray  # (k,) N m or N: of weight, springs, loads and driving efforts at rest; 0 in equilibrium
    effort_scale: FloatArray  # (k,) sum of the magnitudes of all forces times those of their influence coefficients
    potential: float  # J, of weight and springs
    symmetric: bool  # whether the forces are conservative: no load follows a member and no table depends on an input
    input_rates: FloatArray = field(repr=False)  # (k, actuators) rad or normal length by coordinate
    node_rates: ComplexArray = field(repr=False)  # (k, nodes) normal length by coordinate

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
        released: numbers of the released actuators, at least one; those that follow them move with them.
        time: argument of the tables over time [s].
        gauges: values of the gauges at a position nearby, such as `Linearised.gauges`: angles of torsion springs are
            continued from them; by default from the initial configuration.

    Raises:
        ModelError: no masses, loads or springs are defined, or the unit of length is not physical.
        StructureError: the position is singular, so that the motion from there is not unique.
    """
    return Linearisation(mechanism, tuple(released), time).at(z, inputs, gauges)


class Linearisation(ReducedEquations):
    """The linearised equations of motion of one choice of released inputs, for any number of positions."""

    def __init__(self, mechanism: Mechanism, released: tuple[int, ...], time: float) -> None:
        super().__init__(with_released(mechanism, released), released, require_action(mechanism))
        self.mechanism, self.released, self.metre = mechanism, released, self.acting.metre
        self.held = tuple(k for k in mechanism.drivers if k not in released)
        self.balance = StaticBalance(self.read, released, time)
        self.resisting = _resisting(self.acting, [release_of(self.read, k).effort for k in released])

    def at(self, z: ComplexArray, inputs: FloatArray, gauges: FloatArray | None = None) -> Linearised:
        """Return the linearised equations at a position; see `linearised`."""
        v = self.variables(z, inputs, gauges)
        choice = input_choice(self.terms, v, self.released, self.held)
        choice = choice or free_choice(self.terms, v, self.held, len(self.released))
        if choice is None:
            raise self._singular()
        directions = np.eye(len(self.released), len(choice.independent))
        at = self._differentiate(v, choice, directions)
        forces, damping = GeneralisedForces(self.balance, at, self._angles), self._damping(directions)
        scale, rough = self._scales(at, forces)
        place, reduced = self.at_rest, self._reduced(self.acting)
        unit = np.array([1.0 if self._turns(c) else self.metre for c in choice.independent[: len(self.released)]])
        self.unit, both, mechanism = unit, unit[:, None] * unit, self.mechanism
        return Linearised(
            mechanism, self.released, *self._named(choice), mechanism.whole(at.nodes.value[:, 0]),
            self.inputs(place.v).copy(), place.v[self._gauges].copy(), directions @ reduced.m @ directions.T / both,
            -forces.slope[..., 0] / both, rough / both, damping / both, forces.q[:, 0] / unit,
            scale / unit, float(reduced.energy[reduction.POTENTIAL]),
            self.balance.conservative or len(self.released) == 1, at.inputs.first[..., 0] / unit[:, None],
            mechanism.whole(at.nodes.first[..., 0], -1) / unit[:, None],
        )  # fmt: skip

    def moved(self, steps: FloatArray) -> tuple[ComplexArray, FloatArray, FloatArray] | None:
        """Return the position after changes (k,) of the coordinates [rad, m] from the position of the last `at`.

        Returns nodes, inputs and gauges, as `at` takes them; None if the position is not reached on the same branch.
        """
        last, to = (influence.InfluencePosition(*(part.copy() for part in self.at_rest)) for _ in range(2))
        target = last.v[self.chart.independent]
        target[: len(steps)] += steps / self.unit
        still = np.zeros(len(target))
        self.room.weak[:] = 0.0
        if not plain(influence.follow)(self.chart, last, to, target, still, self.room):
            return None
        return self.nodes(to.v), self.inputs(to.v), to.v[self._gauges]

    # -- position and influence coefficients ----------------------------------------------------------

    @property
    def _gauges(self) -> slice:
        first = self.input_variables.stop
        return slice(first, first + len(self.mechanism.gauges))

    @property
    def _angles(self) -> FloatArray:
        """The angles (angles, 1) of the torsion springs, counted through full turns, and of members with a torque."""
        springs = [self.at_rest.v[self.input_variables.stop + spring.gauge] for spring in self.balance.twisted]
        return np.array([*springs, *(0.0 for _ in self.balance.torques)])[:, None]

    def _differentiate(self, v: FloatArray, choice: Choice, directions: FloatArray) -> PositionJet:
        """Return the position with its derivatives along directions (k, independent variables)."""
        self.choose(choice)
        self.at_rest, k, first = self.place(v), len(directions), self.terms.first_reading
        plain(influence.set_signs)(self.chart, self.at_rest, self.room)
        bias = np.zeros((k, k, len(v)))
        for i in range(k):
            for j in range(i + 1):
                both = directions[i] if i == j else directions[i] + directions[j]
                bias[i, j] = bias[j, i] = self._bias(both)
        for i in range(k):
            for j in range(i):
                bias[i, j] = bias[j, i] = 0.5 * (bias[i, j] - bias[i, i] - bias[j, j])
        parts = [part[..., None] for part in (self.at_rest.v, directions @ self.at_rest.b, bias)]
        nodes = Jet(*(part[..., 0:first:2, :] + 1j * part[..., 1:first:2, :] for part in parts))
        return PositionJet(nodes, Jet(*(part[..., self.input_variables, :] for part in parts)))

    def _bias(self, speeds: FloatArray) -> FloatArray:
        """Return the accelerations of all variables at constant speeds of the independent variables."""
        if not plain(influence.settle)(self.chart, self.at_rest, speeds, self.room):
            raise self._singular()
        return self.room.acceleration.copy()

    def require_regular(self) -> None:
        """Raise StructureError if the position of the last `at` is singular up to rounding."""
        if free_choice(self.terms, self.at_rest.v, self.held, len(self.released), NEARLY) is None:
            raise self._singular("the forces lead to a position that is")

    def _singular(self, which: str = "the position is") -> StructureError:
        return StructureError(
            f"{self.mechanism.name}: {which} singular, so that the motion from there is not unique; choose"
            " another position, or release other inputs"
        )

    # -- matrices -------------------------------------------------------------------------------------

    def _scales(self, at: PositionJet, forces: GeneralisedForces) -> tuple[FloatArray, FloatArray]:
        """Return what rounding in the forces (k,) and in their derivatives (k, k) is relative to."""
        scale, rough, size = np.zeros(len(at.nodes.first)), forces.steep[..., 0], self.mechanism.size
        least = LEVER * np.max(np.abs(at.nodes.first[:, list(self.mechanism.close), 0]), axis=1)
        for part in forces.parts:
            lever = np.maximum(np.abs(part.rates[:, 0]), least / (size if part.turns else 1.0))
            amount = np.ravel(part.amount)[0]
            scale += amount * lever
            rough = rough + amount / (1.0 if part.turns else size) * lever[:, None] * lever
        return scale, rough

    def _damping(self, directions: FloatArray) -> FloatArray:
        """Return the matrix of dampers, viscous friction, and driving efforts that depend on the speed."""
        forces = []
        for speeds in directions:
            self._bias(speeds)
            forces.append(directions @ self._reduced(self.resisting).q)
        self._bias(np.zeros(directions.shape[1]))
        return np.asarray(0.0 - np.array(forces).T)

    def _reduced(self, acting: reduction.Acting) -> reduction.Reduced:
        """Return inertia, generalised forces and energies in all independent variables, without loads."""
        plain(reduction.reduce)(acting, self.at_rest, self.room, np.zeros(len(acting.loads)), self.out)
        return self.out

    # -- names ----------------------------------------------------------------------------------------

    def _turns(self, variable: int) -> bool:
        first = self.terms.first_reading
        return variable >= first and self.terms.is_rotary(variable - first)

    def _named(self, choice: Choice) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return the names and the units of the coordinates."""
        own, first = choice.independent[: len(self.released)], self.terms.first_reading
        nodes, readings = self.mechanism.nodes, self.terms.mechanism.actuators
        names = [readings[c - first].name if c >= first else f"{nodes[c // 2]}.{'xy'[c % 2]}" for c in own]
        return tuple(names), tuple("rad" if self._turns(c) else "m" for c in own)


def _resisting(acting: reduction.Acting, efforts: Sequence[DrivingEffort]) -> reduction.Acting:
    """Return only what depends on the speeds: at rest, driving efforts act as dampers of their slopes."""
    slopes = [
        (effort.constant / effort.idle if effort.idle else 0.0)
        - (float(effort.curve.slope(np.zeros(1))[0]) if effort.curve is not None and effort.over == "speed" else 0.0)
        for effort in efforts
    ]
    own = np.array(slopes) / acting.units[acting.motors]
    return acting._replace(
        gravity=np.zeros(2), springs=acting.springs[:0], spring=acting.spring[:0], motor=np.zeros_like(acting.motor),
        dampers=np.concatenate([acting.dampers, acting.motors]), damper=np.concatenate([acting.damper, own]),
    )  # fmt: skip


STEPS, SHORTEST = 200, 0.5**39
"""Most steps, and the least part of a step that is tried."""

FARTHEST = 0.3
"""Longest step of a coordinate: rad, or sizes of the mechanism."""

BALANCED = 1e-13
"""Remaining efforts, relative to the forces that act, at which the iteration ends."""

ACCEPTED = 1e-10
"""Remaining efforts that are an equilibrium if further steps do not reduce them."""

OVERSHOOT = 0.5
"""Greatest effort against a step at its end, relative to that along it at its start."""

FLAT = 1e-9
"""Least curvature of the potential that a step uses, relative to the scale of its contributions."""


class Settling(Follower[FloatArray, Linearised]):
    """A slow motion under the forces towards an equilibrium; `found` is its last position, `status` that of its end."""

    shortest = SHORTEST

    def __init__(self, equations: Linearisation, z: ComplexArray, inputs: FloatArray) -> None:
        """Move to the equilibrium from an assembled position; arguments and errors as for `linearised`.

        Raises StructureError also if the forces lead to a singular position.
        """
        self.equations, self.found, self.step, self.status = equations, equations.at(z, inputs), 1.0, Status.OK
        for _ in range(STEPS):
            if np.max(self.found.unbalance) <= BALANCED or not self.go():
                break
        equations.require_regular()
        if np.max(self.found.unbalance) <= ACCEPTED:
            self.status = Status.OK

    def predict(self) -> FloatArray:
        """Return a part of a step."""
        return self.step * _step(self.found)

    def correct(self, guess: FloatArray) -> Linearised | None:
        """Return the linearised equations after a step; None if it is not reached, or goes too far."""
        place = self.equations.moved(guess)
        self.status = Status.LIMIT if place is None else Status.NOT_CONVERGED
        if place is None:
            return None
        with suppress(StructureError):
            there = self.equations.at(*place)
            if self._is_good(there, guess):
                return there
        self.equations.at(self.found.z, self.found.inputs, self.found.gauges)
        return None

    def accept(self, there: Linearised) -> bool:
        """Take a position, unless rounding ends the iteration."""
        before = float(np.max(self.found.unbalance))
        if before <= ACCEPTED and np.max(there.unbalance) >= before:
            self.step = 0.0
            return False
        self.found, self.step = there, 1.0
        return True

    def _is_good(self, there: Linearised, step: FloatArray) -> bool:
        """Return whether a step does not go far beyond the place where the effort along it is zero."""
        if there.names != self.found.names or np.max(there.unbalance) <= ACCEPTED:
            return True
        return bool(there.effort @ step >= -OVERSHOOT * (self.found.effort @ step))


def _step(found: Linearised) -> FloatArray:
    """Return Newton's step where the potential is convex, else one down its slope; at most FARTHEST."""
    metre = found.mechanism.dynamics.metre or 1.0
    length = np.array([1.0 if unit == "rad" else found.mechanism.size * metre for unit in found.units])
    stiffness, effort = found.stiffness * length[:, None] * length, found.effort * length
    values, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    least = FLAT * float(np.max(found.stiffness_scale * length[:, None] * length))
    if values[0] > least:
        step = np.linalg.solve(stiffness, effort)
    else:
        step = vectors @ ((vectors.T @ effort) / np.maximum(np.abs(values), max(least, np.finfo(float).tiny)))
    return np.asarray(step * length * min(1.0, FARTHEST / max(float(np.max(np.abs(step))), 1e-300)))
