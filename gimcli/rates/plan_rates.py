"""Derivatives of solved positions: the steps of a plan, each differentiated in its turn, written on a tape.

What is wanted are slots: slot 0 is the position, every other one a derivative along the inputs' rates. With f_k
the part of slot k and (i, j, c) its cross terms, Leibniz's rule is

    (f g)_k = f g_k + f_k g + c (f_i g_j + f_j g_i)

with none for a first derivative, (i, i, 1) for a second one, (s, t, 1) for the mixed one along s and t, and
(1, 2, 3) for a third one. The equations of a step, with the unknowns' own slot k at 0, give the right-hand side;
the gradients are those of the positions and are factored once:

    Phi_q q_k = -Phi_k | q_k = 0

    distance   (|p - q|^2 - v^2) / 2 = 0
    line       n.(p - q) - v = 0
    closure    p - q - w (V - U) = 0

Source: Fraczek & Wojtyra, Kinematics of multibody systems, 2008, eqs 1.12-1.16; Griewank & Walther, Evaluating
Derivatives, 2008, chapter 13. Never by differences.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.kernels import tape as kernels
from gimcli.mechanism import FRAME, Mechanism, Member, Point
from gimcli.rates.constraint_rates import DISTANCE, LINE, Imposed
from gimcli.rates.tape import ComplexLanes, Lane, Number, Real, Tape, Term
from gimcli.structure.checks import farthest
from gimcli.structure.steps import (
    NONE,
    Coupled,
    Dyad,
    Orient,
    Place,
    Plan,
    Step,
    Tilt,
    Value,
    Vector,
)


@dataclass(frozen=True)
class Slot:
    """A derivative that is wanted.

    The inputs' own part of it is row `given` of what is handed over, or 1 for the actuator `unit`, else 0.
    """

    cross: tuple[int, int, int] | None = None
    given: int | None = None
    unit: int | None = None
    order: int = 1


POSITION = Slot(given=0, order=0)
Ways = dict[int, dict[int, Number]]
"""Of nodes, how they move with each base node."""


class Nodes(dict[int, list[Number]]):
    """Nodes by slots: the position of each is known, its derivatives are 0 until they are found."""

    def __init__(self, tape: Tape, slots: int) -> None:
        super().__init__()
        self.tape, self.slots = tape, slots

    def __missing__(self, node: int) -> list[Number]:
        to = self.tape.keep(2)
        self.tape.emit(kernels.NODE, to, node)
        self[node] = [ComplexLanes(to), *[0j] * (self.slots - 1)]
        return self[node]


class Differentiated:
    """What stands so far, by slots: nodes, directions in registers, inputs and what they turn."""

    def __init__(self, mechanism: Mechanism, plan: Plan, slots: Sequence[Slot]) -> None:
        self.mechanism, self.slots, self.tape = mechanism, slots, Tape()
        fixed = mechanism.members[FRAME]
        self.nodes = Nodes(self.tape, len(slots))
        for node, z in zip(fixed.nodes, fixed.shape, strict=True):
            self.nodes[node] = [complex(z), *[0j] * (len(slots) - 1)]
        self.registers: dict[int, list[Number]] = {}
        self.inputs: dict[tuple[int, int], Real] = {}
        self.turns: dict[tuple[int, int], Number] = {}
        for step in plan.steps:
            with self.tape.step():
                self.take(step)

    # -- what is given -------------------------------------------------------------------------

    def input(self, actuator: int, k: int) -> Real:
        """Return slot k of an input."""
        key = actuator, k
        if key not in self.inputs:
            slot, tape = self.slots[k], self.tape
            if slot.given is not None:
                to = tape.keep(1)
                tape.emit(kernels.VALUE, to, slot.given, actuator)
                self.inputs[key] = Lane(to)
            else:
                self.inputs[key] = 1.0 if slot.unit == actuator else 0.0
        return self.inputs[key]

    def turn(self, actuator: int, k: int) -> Number:
        """Return slot k of e = exp(i theta): e' = i theta' e, differentiated."""
        if (actuator, k) not in self.turns:
            self.turns[actuator, k] = self._turn(actuator, k)
        return self.turns[actuator, k]

    def _turn(self, actuator: int, k: int) -> Number:
        tape = self.tape
        if k == 0:
            to = tape.keep(2)
            tape.emit(kernels.COS_SIN, to, tape.lane(self.input(actuator, 0)))
            return ComplexLanes(to)
        i, j, c = self.slots[k].cross or (0, 0, 0)
        terms = [(k, 0, 1.0)] if c == 0 else [(k, 0, 1.0), (i, j, 1.0), (j, i, c - 1.0)]
        parts = [(f, self.input(actuator, p), self.turn(actuator, n)) for p, n, f in terms if f != 0.0]
        parts = [(f, rate, e) for f, rate, e in parts if rate != 0.0 and e != 0.0]
        to = tape.keep(2) if parts else 0
        for n, (f, rate, e) in enumerate(parts):
            tape.emit(kernels.ADD_TURN if n else kernels.TURN, to, tape.lane(rate), tape.lane(e), f=f)
        return ComplexLanes(to) if parts else 0j

    # -- vectors and equations -----------------------------------------------------------------

    def leibniz(self, f: Mapping[int, Number], g: Mapping[int, Number], k: int) -> list[Term]:
        """Return the terms of slot k of a product."""
        if k == 0:
            return [(1.0, f[0], g[0])]
        i, j, c = self.slots[k].cross or (0, 0, 0)
        cross: list[Term] = [(2.0 * c, f[i], g[i])] if i == j else [(1.0 * c, f[i], g[j]), (1.0 * c, f[j], g[i])]
        return [(1.0, f[0], g[k]), (1.0, f[k], g[0]), *(cross if c else [])]

    def base(self, vector: Vector, k: int) -> Number:
        """Return slot k of what a vector is hung on."""
        if vector.u != NONE:
            return self.tape.plus(self.nodes[vector.v][k], self.nodes[vector.u][k], -1.0)
        if vector.register != NONE:
            return self.registers[vector.register][k]
        return 1.0 + 0j if k == 0 else 0j

    def _e(self, vector: Vector, k: int) -> Number:
        if vector.actuator == NONE:
            return 1.0 + 0j if k == 0 else 0j
        return self.turn(vector.actuator, k)

    def _sum(self, vector: Vector, terms: list[Term]) -> Number:
        return self.tape.products(terms, conjugate=vector.turn < 0)

    def vector(self, vector: Vector, k: int) -> Number:
        """Return slot k of a vector that is carried along."""
        if vector.actuator == NONE:
            return self.tape.scaled(self.base(vector, k), vector.z)
        turns, bases = ({n: part(vector, n) for n in self.needed(k)} for part in (self._e, self.base))
        return self.tape.scaled(self._sum(vector, self.leibniz(turns, bases, k)), vector.z)

    def needed(self, k: int) -> set[int]:
        """Return the slots of its factors that slot k of a product needs."""
        return {0, k, *(self.slots[k].cross or (0, 0))[:2]}

    def value(self, value: Value, k: int) -> Real:
        """Return slot k of a length that may follow an input."""
        constant = value.constant if k == 0 else 0.0
        if value.actuator == NONE:
            return constant
        given = self.input(value.actuator, k)
        if isinstance(given, Lane):
            return self.tape.real(kernels.AFFINE, given.lane, f=constant, g=value.gain)
        return constant + value.gain * given

    # -- steps ---------------------------------------------------------------------------------

    def take(self, step: Step) -> None:
        """Differentiate what a step places."""
        if isinstance(step, Place):
            self.carry(step, self.nodes[step.node], range(1, len(self.slots)))
        elif isinstance(step, Orient):
            slots = range(len(self.slots))
            self.registers[step.register] = [self.tape.kept_number(self.vector(step.vector, k)) for k in slots]
        elif isinstance(step, Tilt):
            self.tilt(step)
        elif isinstance(step, Dyad):
            self.dyad(step)
        else:
            self.couple(step)

    def carry(self, step: Place, node: list[Number], slots: Iterable[int], keep: bool = True) -> None:
        """Find slots of a node that is carried along."""
        vector, tape = step.vector, self.tape
        for k in slots:
            anchor = self.nodes[step.anchor][k]
            if vector.u != NONE and vector.actuator == NONE:
                found = tape.carried(anchor, self.nodes[vector.v][k], self.nodes[vector.u][k], vector.z)
            else:
                found = tape.plus(anchor, self.vector(vector, k))
            node[k] = tape.kept_number(found) if keep else found

    def dyad(self, step: Dyad) -> None:
        """Find all slots of a node that stands on two loci."""
        node = self.nodes[step.node]
        loci = [Imposed.locus(self, step.node, locus) for locus in (step.first, step.second)]
        self.pair(node, (loci[0].gradient(), loci[1].gradient()), loci)

    def tilt(self, step: Tilt) -> None:
        """Find all slots of the direction u of B - A = u (tau + i e): |u| = 1, u x (B - A) = e."""
        tape = self.tape
        unit = tape.pair(kernels.UNIT, tape.lane(self.vector(step.along, 0)))
        u = self.registers[step.register] = [tape.kept_number(unit), *[0j] * (len(self.slots) - 1)]

        def arm(k: int) -> Number:
            return tape.scaled(tape.plus(self.nodes[step.b][k], self.nodes[step.a][k], -1.0), -1j)

        known = Value(1.0)
        bound = [Imposed(self, DISTANCE, u.__getitem__, None, known), Imposed(self, LINE, u.__getitem__, arm, known)]
        self.pair(u, (u[0], bound[1].normal(0)), bound)

    def pair(self, unknown: list[Number], gradients: tuple[Number, Number], imposed: list[Imposed]) -> None:
        """Find all slots of one complex unknown from two equations."""
        tape = self.tape
        n, m = (tape.lane(g) for g in gradients)
        determinant = tape.real(kernels.DETERMINANT, n, m)
        right = tape.take(2)
        for k in range(1, len(self.slots)):
            with tape.step():
                if any([one.fill(right + row, k) for row, one in enumerate(imposed)]):
                    to = tape.keep(2)
                    tape.emit(kernels.MEET, to, n, m, right, determinant.lane)
                    unknown[k] = ComplexLanes(to)

    # -- coupled groups --------------------------------------------------------------------------

    def couple(self, group: Coupled) -> None:
        """Find all slots of the nodes of a coupled group."""
        tape, m, n = self.tape, sum(e.rows for e in group.equations), 2 * len(group.base)
        base, carried = ([self.nodes[x] for x in some] for some in (group.base, [p.node for p in group.places]))
        imposed = [Imposed.equation(self, e) for e in group.equations]
        rows = [int(r) for r in np.cumsum([0, *(e.rows for e in group.equations[:-1])])]
        a, scales, d, right = (tape.take(count) for count in (m * n, m, 3 * n, m))
        self._gradients(group, imposed, a, n)
        tape.emit(kernels.FACTOR, a, scales, d, m, n)
        for k in range(1, len(self.slots)):
            with tape.step():
                for place, node in zip(group.places, carried, strict=True):
                    self.carry(place, node, (k,), keep=False)
                moves = any([one.fill(right + row, k) for row, one in zip(rows, imposed, strict=True)])
            if moves:
                tape.emit(kernels.SOLVE, right, a, scales, d, f=m, g=n)
                for b, node in enumerate(base):
                    to = tape.keep(2)
                    tape.emit(kernels.NEGATIVE, to, right + 2 * b)
                    node[k] = ComplexLanes(to)
            for place, node in zip(group.places, carried, strict=True):
                self.carry(place, node, (k,))

    def _gradients(self, group: Coupled, imposed: list[Imposed], a: int, n: int) -> None:
        """Fill the gradients: a node is C b + c in the base nodes b, C complex."""
        tape = self.tape
        ways: Ways = {b: {k: 1.0 + 0j if k == b else 0j for k in group.base} for b in group.base}
        for place in group.places:
            more = self._ways(ways, place.vector, group.base)
            ways[place.node] = {b: tape.plus(_way(ways, place.anchor, b), more[b]) for b in group.base}
        row = a
        for e, one in zip(group.equations, imposed, strict=True):
            turning = self._ways(ways, e.vector, group.base) if e.vector is not None else dict.fromkeys(group.base, 0j)
            for column, b in enumerate(group.base):
                with tape.step():
                    way = tape.plus(_way(ways, e.p, b), _way(ways, e.q, b), -1.0)
                    for k, part in enumerate(one.gradients(way, turning[b])):
                        tape.put(row + k * n + 2 * column, part)
            row += e.rows * n

    def _ways(self, ways: Ways, vector: Vector, base: Iterable[int]) -> dict[int, Number]:
        """Return how a vector changes by each base node."""
        if vector.u == NONE:
            return dict.fromkeys(base, 0j)
        found: dict[int, Number] = {}
        for b in base:
            way = self.tape.plus(_way(ways, vector.v, b), _way(ways, vector.u, b), -1.0)
            found[b] = self.tape.scaled(self._sum(vector, [(1.0, self._e(vector, 0), way)]), vector.z)
        return found

    # -- what is asked for -----------------------------------------------------------------------

    def tell_point(self, number: int, point: str | Point, skipped: int) -> None:
        """Write all slots of a point out."""
        u, v, z = carrier(self.mechanism, point)
        with self.tape.step():
            for k in range(skipped, len(self.slots)):
                place = self.nodes[u][k]
                if v != u:
                    place = self.tape.carried(place, self.nodes[v][k], place, z)
                elif k == 0:
                    place = self.tape.plus(place, z)
                self.tape.emit(kernels.TELL, self.tape.lane(place), k - skipped, number)

    def tell_angle(self, number: int, member: Member) -> None:
        """Write all slots of a member's angle phi out: the arm's w_k = (i phi_k - ...) w.

        A third derivative: (i phi_3 - 3 phi_1 phi_2 - i phi_1^3) w.
        """
        tape, u, v = self.tape, member.nodes[0], member.nodes[farthest(member)]
        with tape.step():
            arms = [tape.plus(self.nodes[v][k], self.nodes[u][k], -1.0) for k in range(len(self.slots))]
            inverse = tape.real(kernels.INVERSE, tape.lane(arms[0]))
            told: list[int] = [0]
            for k, arm in enumerate(arms[1:], start=1):
                told.append(tape.real(kernels.ACROSS, tape.lane(arms[0]), tape.lane(arm), inverse.lane).lane)
                if self.slots[k].order == 3:
                    omega = told[(self.slots[k].cross or (0, 0))[0]]
                    square = tape.real(kernels.PRODUCT, omega, omega)
                    tape.emit(kernels.ADD_PRODUCT, told[k], square.lane, omega)
                tape.emit(kernels.TELL_ANGLE, told[k], k - 1, number)


def _way(ways: Ways, node: int, base: int) -> Number:
    return ways[node][base] if node in ways else 0j


def carrier(mechanism: Mechanism, point: str | Point) -> tuple[int, int, complex]:
    """Return nodes u, v and z so that a node or point is u + z (v - u), or u + z for one node."""
    if isinstance(point, str) and point in mechanism.nodes:
        node = mechanism.nodes.index(point)
        return node, node, 0j
    if isinstance(point, str):
        point = next(p for p in mechanism.points if p.name == point)
    member = mechanism.members[point.member]
    far, first = farthest(member), member.shape[0]
    u, v = member.nodes[0], member.nodes[far]
    if point.member == FRAME:
        return u, u, complex(point.local - first)
    return u, v, complex((point.local - first) / (member.shape[far] - first))
