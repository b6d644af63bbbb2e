"""Dry (Coulomb) friction in simulations, regularised: below a slip speed it grows smoothly with the speed.

    moment in a pin = rho |R| tanh(omega / e),   force in a guide = mu (|N1| + |N2|) tanh(v / (e L))

rho: radius of the friction circle; R: pin force; N1, N2: the two contacts of a guide (or the normal force of a pin in a
slot); L: unit of length of the normal frame, about the size of the mechanism; e [rad/s]: the slip speed. What should
stand creeps with less than e where the load is at most 76 % of the greatest friction, tanh(1). The reactions depend on
the accelerations and on the friction itself: the kernel `gimcli.kernels.body_balance` solves the equations of all
bodies for both in each state.

Reactions along a simulation are those to this friction, which acts on the bodies as known forces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import count

import numpy as np

from gimcli.dynamic_data import AppliedLoad, Inertia
from gimcli.dynamics.coulomb import form_table, rub
from gimcli.dynamics.equilibrium_equations import equilibrium
from gimcli.dynamics.forces import UNIQUE, Forces
from gimcli.dynamics.kinematic_history import Course
from gimcli.dynamics.load_arrays import FrictionPair, friction_pairs, ints, moving_loads, with_force_gauges
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.reducer import Reducer, free_inputs
from gimcli.dynamics.statics import statics
from gimcli.errors import StructureError
from gimcli.kernels import body_balance as kernels
from gimcli.kernels.body_balance import GUIDE, PIN, BalancedBodies, Contacts
from gimcli.kernels.equilibrium import ALONG
from gimcli.kernels.reduction import DISSIPATED, SUPPLIED
from gimcli.mechanism import FRAME, SPAN, FloatArray, IntArray, Mechanism
from gimcli.structure.steps import NONE
from gimcli.table import Column


class BodyBalance:
    """The bodies, unknowns and contacts of a mechanism; `free` are its released inputs."""

    def __init__(self, mechanism: Mechanism, free: Sequence[int]) -> None:
        read = with_force_gauges(mechanism)
        self.statics, self.mechanism, self.first = statics(read), read, 2 * len(mechanism.nodes)
        every = self.statics
        couples = [pair.reaction(every) for pair in friction_pairs(read) if pair.friction.slide == NONE]
        count, known = len(every.reactions), len(every.reactions) + len(every.gauges)
        self.reactions = [*every.reactions, *every.gauges, *couples]
        self.couples = known + np.arange(len(couples), dtype=np.int64)
        self.readings = np.array([*every.efforts, *range(count, known)], dtype=np.int64)  # of actuators and gauges
        unknown = np.setdiff1d(np.arange(count), self.readings[list(free)])
        self.unknown = np.full(known + len(couples), -1, dtype=np.int64)
        self.unknown[unknown] = np.arange(len(unknown))
        self.unknowns, self.equations = len(unknown), every.equations
        self.pairs: list[FrictionPair] = []  # of the contacts
        self.columns: list[int] = []
        self.contacts = self._contacts()
        self.bodies = self._bodies()

    def _bodies(self) -> BalancedBodies:
        read, reactions = self.mechanism, self.reactions
        vectors = [reaction.vector for reaction in reactions]
        turned = [(c, v.u, v.v, int(reactions[c].kind == ALONG)) for c, v in enumerate(vectors) if v.u != NONE]
        contact = np.full(len(vectors), -1, dtype=np.int64)
        contact[self.columns] = np.arange(len(self.columns))
        readings = [int(i.kind == SPAN) for i in (*read.actuators, *read.gauges)]
        inertias = [i for i in read.dynamics.inertias if i.member != FRAME]
        terms, factors = self._terms()
        rotors, ratios = self._rotors()
        return BalancedBodies(
            terms, factors, np.array([(v.z.real, v.z.imag) for v in vectors]).reshape(-1, 2), ints(turned, 4),
            self.unknown, contact, self._acted(inertias), self._acted(moving_loads(read)),
            ints(list(zip(self.readings.tolist(), readings, strict=True)), 2), self.couples,
            rotors, ratios, self.first,
        )  # fmt: skip

    def _terms(self) -> tuple[IntArray, FloatArray]:
        """Return the entries of the equations, as in `gimcli.dynamics.equilibrium_equations.equilibrium`."""
        every = self.statics
        entries = [(c, entry) for c, reaction in enumerate(self.reactions) for entry in every.entries(reaction)]
        terms = [
            (every.first_row[body] + axis, c, kind, node, every.bodies[body].node)
            for c, (body, axis, kind, _, node) in entries
        ]
        return ints(terms, 5), np.array([factor for _, (_, _, _, factor, _) in entries])

    def _rotors(self) -> tuple[IntArray, FloatArray]:
        """Return number of the rotor and column of each actuator that turns it, and the ratios."""
        leaders = {coupling.follower: coupling.terms for coupling in self.mechanism.couplings}
        turned = [
            ((k, int(self.readings[actuator])), ratio)
            for k, rotor in enumerate(self.mechanism.dynamics.rotors)
            for actuator, ratio in leaders.get(rotor.actuator, ((rotor.actuator, 1.0),))
        ]
        return ints([row for row, _ in turned], 2), np.array([ratio for _, ratio in turned], dtype=float)

    @property
    def shares(self) -> list[tuple[int, int, float]]:
        """Columns of actuators, unknowns of their followers without gears, whose effort they bear, and the ratios."""
        return [
            (int(self.readings[actuator]), int(self.unknown[self.readings[coupling.follower]]), ratio)
            for coupling in self.mechanism.couplings if not coupling.geared
            for actuator, ratio in coupling.terms
        ]  # fmt: skip

    def _acted(self, parts: Sequence[Inertia | AppliedLoad]) -> IntArray:
        """Return first equation, node of reference, and whether there is an equation of moments, of the bodies."""
        every, rows = self.statics, list[tuple[int, int, int]]()
        for part in parts:
            body = every.body_of(part)
            if body == NONE:
                rows.append((-1, 0, 0))
            else:
                own = every.bodies[body]
                rows.append((every.first_row[body], own.node, int(own.member != NONE)))
        return ints(rows, 3)

    # -- contacts -------------------------------------------------------------------------------------

    def _contacts(self) -> Contacts:
        """Return the pairs with dry friction: each member on a pin but the first, and the guides."""
        pairs, speeds = friction_pairs(self.mechanism), list[int]()
        guides = len(self.readings) - sum(pair.friction.slide != NONE for pair in pairs)  # the last gauges
        numbers = {True: count(), False: count(guides)}
        for pair in pairs:
            on_pin = pair.friction.slide == NONE
            number = next(numbers[on_pin])
            if any(any(form.values()) for form in pair.forms(self.statics)):
                self.pairs.append(pair)
                self.columns.append(int((self.couples if on_pin else self.readings)[number]))
                speeds.append(number if on_pin else self.first + number)
        first, second = form_table(self.statics, self.pairs, len(self.unknown))[..., self.unknown >= 0]
        self.forms = np.stack([first.real, first.imag + second.real], axis=1)
        kinds = [PIN if pair.friction.slide == NONE else GUIDE for pair in self.pairs]
        return Contacts(np.array(kinds, dtype=np.int64), np.array(speeds, dtype=np.int64))


SOFT = 1e-12
"""Singular values below this fraction of the greatest belong to redundant constraints."""


class RegularisedFriction:
    """The dry friction of a mechanism in the states of a simulation."""

    def __init__(self, reducer: Reducer, slip: float) -> None:
        self.reducer, self.slip = reducer, slip
        self.balance = BodyBalance(reducer.mechanism, reducer.free)
        if reducer.mechanism.gears:
            from gimcli.dynamics.gear_reactions import refuse_dry_friction  # imported late: few mechanisms have gears

            refuse_dry_friction(self.balance.statics)
        columns, size, free = len(self.balance.unknown), self.balance.equations, len(reducer.free)
        count = len(self.balance.columns)
        self.room = kernels.BalanceRoom(
            np.zeros((columns, 2)), np.zeros(columns), np.zeros((columns, self.balance.unknowns + free)),
            np.zeros((size, self.balance.unknowns + free)),
            np.zeros((size, 1 + count)), np.zeros(reducer.terms.variables),
        )  # fmt: skip
        for own, follower, ratio in self.balance.shares:
            self.room.gains[own, follower] -= ratio
        self.loop = kernels.LoopRoom(
            np.zeros(count), np.zeros(count), np.zeros((count, 2, 1 + count)), np.zeros(count), np.zeros(count),
            np.zeros((count, 2)), np.zeros((count, count)), np.zeros(2 * count), np.zeros(count), np.zeros(count),
        )  # fmt: skip
        self.failed = False  # whether the last state has no solution, or no unique one
        self.checked = False  # whether the reactions of the contacts are determined

    @property
    def names(self) -> list[str]:
        """The names of the contacts: of a node, or a sliding pair."""
        return [pair.friction.name for pair in self.balance.pairs]

    def __call__(self, given: FloatArray) -> bool:
        """Add the friction to the state of the reducer's last move; return whether the friction is determined.

        `given` are the accelerations of the inputs that follow laws.
        """
        reducer, balance, room = self.reducer, self.balance, self.room
        reducer.run(kernels.fill)(
            balance.bodies, reducer.acting, reducer.at, reducer.room, given, reducer.factors, reducer.out.effort, room
        )  # fmt: skip
        found, self.failed = self._solved(), False
        if found is None:
            return False
        np.dot(balance.forms, found[: balance.unknowns], out=self.loop.y)
        done = reducer.run(kernels.find_friction)(
            balance.contacts, reducer.acting, reducer.at, reducer.room.velocity, self.slip, self.loop
        )
        self.failed = not done
        if done:
            self._apply(found[:, 0] + found[:, 1:] @ self.loop.f)
        return bool(done)

    def _solved(self) -> FloatArray | None:
        """Return the unknowns without friction, and by each friction (unknowns + free, 1 + contacts)."""
        matrix, sides = self.room.matrix, self.room.sides
        if matrix.shape[0] == matrix.shape[1]:
            try:
                return np.asarray(np.linalg.solve(matrix, sides), dtype=np.float64)
            except np.linalg.LinAlgError:
                return None
        if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(sides))):
            return None
        size = np.linalg.norm(matrix, axis=0)
        size[size == 0.0] = 1.0
        if not self.checked:
            self._require_determined(matrix / size)
        return np.asarray(np.linalg.lstsq(matrix / size, sides, rcond=SOFT)[0] / size[:, None])

    def _apply(self, unknowns: FloatArray) -> None:
        """Set accelerations, efforts of the inputs that follow laws, and powers."""
        reducer, out, metre = self.reducer, self.reducer.out, self.reducer.acting.metre
        free = len(reducer.free)
        reducer.gain[:free] = unknowns[len(unknowns) - free :]
        out.energy[DISSIPATED] += metre * float(self.loop.f @ self.loop.speed)
        if reducer.given:
            rates = reducer.room.velocity[[reducer.terms.first_reading + k for k in reducer.given]]
            out.energy[SUPPLIED] -= float(out.q[free:] @ rates)
            out.q[free:] = self._efforts(unknowns)
            out.energy[SUPPLIED] += float(out.q[free:] @ rates)

    def _efforts(self, unknowns: FloatArray) -> FloatArray:
        """Return the efforts of the inputs that follow laws, with those of their followers and rotors."""
        reducer, bodies = self.reducer, self.balance.bodies
        acting, gains = reducer.acting, reducer.acceleration
        efforts = []
        for k in reducer.given:
            column = int(self.balance.readings[k])
            effort = unknowns[bodies.unknown[column]]
            for own, follower, ratio in self.balance.shares:
                effort += ratio * unknowns[follower] if own == column else 0.0
            effort *= acting.metre
            for (rotor, own), ratio in zip(bodies.rotors.tolist(), bodies.rotor_ratio.tolist(), strict=True):
                effort += ratio * acting.rotor[rotor] * gains[acting.rotors[rotor]] if own == column else 0.0
            efforts.append(effort)
        return np.array(efforts)

    def _require_determined(self, matrix: FloatArray) -> None:
        """Raise StructureError if redundant constraints leave the reactions of a contact open."""
        self.checked = True
        _, values, across = np.linalg.svd(matrix)
        rank = int(np.sum(values > SOFT * values[0]))
        stressed = np.linalg.norm(across[rank:], axis=0)
        open_ones = [
            name
            for k, name in enumerate(self.names)
            if np.any(stressed[: self.balance.unknowns][self.balance.forms[k].any(axis=0)] > UNIQUE)
        ]
        if open_ones:
            names = ", ".join(dict.fromkeys(open_ones))
            raise StructureError(
                f"{self.reducer.mechanism.name}: redundant constraints leave the forces in {names} indeterminate, and"
                " so the dry friction there: remove the redundant constraints (`gim mobility` names them), or `mu`"
            )


def with_friction(forces: Forces, friction: FloatArray) -> Forces:
    """Return reactions without dry friction plus those to the friction of a simulation (contacts, rows)."""
    balance, good = BodyBalance(forces.mechanism, free_inputs(forces.mechanism)), np.flatnonzero(forces.good)
    table = equilibrium(balance.statics, forces.course.nodes[0][:, good], balance.reactions)
    right = np.einsum("rik,kr->ri", table[:, :, balance.columns], friction[:, good])
    own = table[:, :, : len(forces.statics.reactions)]  # the other columns are gauges and moments in pins
    unknowns = forces.unknowns.copy()
    unknowns[:, good] += np.einsum("rci,ri->cr", np.linalg.pinv(own, rcond=SOFT), right)
    rub(forces.loads, balance.pairs, friction, _powers(balance, forces.course, friction))
    return replace(forces, unknowns=unknowns)


def friction_columns(mechanism: Mechanism, course: Course, friction: FloatArray) -> list[Column]:
    """Return the friction of each pair, on the member that turns or slides, and its power; friction (contacts, rows).

    A moment [N m] in a pin, a force [N] along a guide, positive from its first node to its second.
    """
    balance, metre = BodyBalance(mechanism, free_inputs(mechanism)), require_action(mechanism)
    columns, powers = list[Column](), _powers(balance, course, friction)
    for name, pair, own in zip(_names(balance), balance.pairs, friction, strict=True):
        unit, factor = ("N m", metre) if pair.friction.slide == NONE else ("N", 1.0)
        columns.append(Column(f"{name}.friction", -factor * own, unit))
    names = np.array([pair.friction.name for pair in balance.pairs])
    each = ((name, powers[names == name].sum(axis=0)) for name in dict.fromkeys(names.tolist()))
    return [*columns, *(Column(f"friction.power.{name}", power, "W") for name, power in each)]


def friction_names(mechanism: Mechanism) -> list[str]:
    """Return the names of the columns of friction; no simulation is needed for them."""
    balance = BodyBalance(mechanism, free_inputs(mechanism))
    pairs = dict.fromkeys(pair.friction.name for pair in balance.pairs)
    return [*(f"{name}.friction" for name in _names(balance)), *(f"friction.power.{name}" for name in pairs)]


def _names(balance: BodyBalance) -> list[str]:
    """Return the names of the contacts: of the pair, with the member where several turn on one pin."""
    names, members = [pair.friction.name for pair in balance.pairs], balance.mechanism.members
    several = [names.count(name) > 1 for name in names]
    return [
        f"{pair.friction.name}.{members[pair.member].name}" if more else pair.friction.name
        for pair, more in zip(balance.pairs, several, strict=True)
    ]


def _powers(balance: BodyBalance, course: Course, friction: FloatArray) -> FloatArray:
    """Return the power of the friction [W] (contacts, rows)."""
    speeds = [pair.rate(balance.mechanism, course) for pair in balance.pairs]
    metre = require_action(balance.mechanism)
    return np.asarray(-friction * np.array(speeds).reshape(friction.shape) * metre)
