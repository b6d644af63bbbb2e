"""Derivatives of solved positions: the steps of a plan are differentiated one after the other and recorded on a tape.

The right-hand side is the residual of a step's equations with slot k of the unknowns (see `slots`) set to 0. The
gradients are those of the position and are factored once:

    Phi_q q_k = -Phi_k | q_k = 0

    distance   (|p - q|^2 - v^2) / 2 = 0
    line       n.(p - q) - v = 0
    closure    p - q - w (V - U) = 0

Source: Fraczek & Wojtyra, Kinematics of multibody systems, 2008, eqs 1.12-1.16; Griewank & Walther, Evaluating
Derivatives, 2008, chapter 13. No finite differences are used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from gimcli.calculus.numbers import scalar
from gimcli.kernels import tape as kernels
from gimcli.mechanism import CLOSURE, FRAME, HEIGHT, SPAN, Mechanism, Member, Point
from gimcli.rates.slots import Slot, SlotValues
from gimcli.rates.tape import ComplexLanes, Number, Term, vanishes
from gimcli.structure.steps import (
    NONE,
    Constraint,
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
class Imposed:
    """A distance, a line or a closure; `away` gives the slots of p - q, `vector` those of the vector."""

    of: SlotValues
    kind: int  # of kernels.constraints
    away: Callable[[int], Number]
    vector: Callable[[int], Number] | None
    value: Value

    @staticmethod
    def by(of: SlotValues, constraint: Constraint) -> Imposed:
        """Return a constraint of a dyad or of a coupled group."""
        offset = constraint.offset

        def away(k: int) -> Number:
            arm = of.tape.plus(of.nodes[constraint.p][k], of.nodes[constraint.q][k], -1.0)
            return arm if offset is None else of.tape.plus(arm, of.vector(offset, k), -1.0)

        vector = None if constraint.vector is None else partial(of.vector, constraint.vector)
        return Imposed(of, constraint.kind, away, vector, constraint.value)

    def normal(self, k: int) -> Number:
        """Return slot k of the vector."""
        assert self.vector is not None
        return self.vector(k)

    def gradient(self) -> Number:
        """Return the gradient by p - q."""
        return self.away(0) if self.kind == SPAN else self.normal(0)

    def gradients(self, arm: Number, turning: Number) -> list[Number]:
        """Return the gradients by a complex unknown that changes p - q by `arm` and the vector by `turning`.

        The gradient of Re(conj(a) c s) by the two parts of s is the complex number conj(c) a.
        """
        tape = self.of.tape
        if self.kind == CLOSURE:
            both = tape.plus(arm, turning, -1.0)
            return [tape.products([(1.0, both, unit)], conjugate=True) for unit in (1.0 + 0j, 1j)]
        if self.kind == SPAN:
            return [tape.products([(1.0, arm, self.away(0))], conjugate=True)]
        terms: list[Term] = [(1.0, arm, self.normal(0))]
        if not vanishes(turning):
            terms.append((1.0, turning, self.away(0)))
        return [tape.products(terms, conjugate=True)]

    def fill(self, to: int, k: int) -> bool:
        """Fill a lane, two for a closure, with slot k > 0 of the residual; return whether it can differ from 0."""
        of, tape = self.of, self.of.tape
        if self.kind == CLOSURE:
            apart = tape.plus(self.away(k), self.normal(k), -1.0)
            tape.put(to, apart)
            return not vanishes(apart)
        away = {n: self.away(n) for n in of.needed(k)}
        value = {n: of.value(self.value, n) for n in of.needed(k)}
        i, j, c = of.slots[k].cross or (0, 0, 0)
        if self.kind == SPAN:
            terms: list[Term] = [(1.0, away[0], away[k]), (1.0 * c, away[i], away[j])]
            return tape.dots(to, terms, [(-1.0, value[0], value[k]), (-1.0 * c, value[i], value[j])])
        normal = {n: self.normal(n) for n in of.needed(k)}
        return tape.dots(to, of.leibniz(normal, away, k), [(-1.0, 1.0, value[k])])


BaseGains = dict[int, dict[int, Number]]
"""Derivatives of nodes by base nodes, as complex factors: node, base node, factor."""


class Differentiated(SlotValues):
    """The steps of a plan, differentiated one after the other."""

    def __init__(self, mechanism: Mechanism, plan: Plan, slots: Sequence[Slot]) -> None:
        super().__init__(mechanism, slots)
        for step in plan.steps:
            with self.tape.step():
                self.take(step)

    def take(self, step: Step) -> None:
        """Differentiate the nodes or direction of a step."""
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
        """Compute slots of a node that is determined linearly by others."""
        vector, tape = step.vector, self.tape
        for k in slots:
            anchor = self.nodes[step.anchor][k]
            if vector.u != NONE and vector.actuator == NONE:
                found = tape.carried(anchor, self.nodes[vector.v][k], self.nodes[vector.u][k], vector.z)
                found = self.stretched(found, vector, k)
            else:
                found = tape.plus(anchor, self.vector(vector, k))
            node[k] = tape.kept_number(found) if keep else found

    def dyad(self, step: Dyad) -> None:
        """Compute all slots of a node on two loci."""
        node = self.nodes[step.node]
        loci = [Imposed.by(self, locus) for locus in (step.first, step.second)]
        self.pair(node, (loci[0].gradient(), loci[1].gradient()), loci)

    def tilt(self, step: Tilt) -> None:
        """Compute all slots of the direction u of B - A = u (tau + i e): |u| = 1, u x (B - A) = e."""
        tape = self.tape
        unit = tape.pair(kernels.UNIT, tape.lane(self.vector(step.along, 0)))
        u = self.registers[step.register] = [tape.kept_number(unit), *[0j] * (len(self.slots) - 1)]

        def arm(k: int) -> Number:
            return tape.scaled(tape.plus(self.nodes[step.b][k], self.nodes[step.a][k], -1.0), -1j)

        bound = [
            Imposed(self, SPAN, u.__getitem__, None, Value(1.0)),
            Imposed(self, HEIGHT, u.__getitem__, arm, Value(step.distance)),
        ]
        self.pair(u, (u[0], bound[1].normal(0)), bound)

    def pair(self, unknown: list[Number], gradients: tuple[Number, Number], imposed: list[Imposed]) -> None:
        """Compute all slots of one complex unknown from two equations."""
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
        """Compute all slots of the nodes of a coupled group."""
        tape, m, n = self.tape, sum(e.rows for e in group.equations), 2 * len(group.base)
        base, carried = ([self.nodes[x] for x in some] for some in (group.base, [p.node for p in group.places]))
        imposed = [Imposed.by(self, e) for e in group.equations]
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
                    tape.emit(kernels.SCALE, to, right + 2 * b, f=-1.0)
                    node[k] = ComplexLanes(to)
            for place, node in zip(group.places, carried, strict=True):
                self.carry(place, node, (k,))

    def _gradients(self, group: Coupled, imposed: list[Imposed], a: int, n: int) -> None:
        """Fill the gradients; a node is C b + c in the base nodes b, with complex C."""
        tape = self.tape
        gains: BaseGains = {b: {k: 1.0 + 0j if k == b else 0j for k in group.base} for b in group.base}
        for place in group.places:
            more = self._vector_gains(gains, place.vector, group.base)
            gains[place.node] = {b: tape.plus(_gain(gains, place.anchor, b), more[b]) for b in group.base}
        row = a
        for e, one in zip(group.equations, imposed, strict=True):
            fixed = dict.fromkeys(group.base, 0j)
            turning = fixed if e.vector is None else self._vector_gains(gains, e.vector, group.base)
            for column, b in enumerate(group.base):
                with tape.step():
                    gain = tape.plus(_gain(gains, e.p, b), _gain(gains, e.q, b), -1.0)
                    for k, part in enumerate(one.gradients(gain, turning[b])):
                        tape.put(row + k * n + 2 * column, part)
            row += e.rows * n

    def _vector_gains(self, gains: BaseGains, vector: Vector, base: Iterable[int]) -> dict[int, Number]:
        """Return the complex factors by which a vector changes with each base node."""
        if vector.u == NONE:
            return dict.fromkeys(base, 0j)
        found: dict[int, Number] = {}
        for b in base:
            gain = self.tape.plus(_gain(gains, vector.v, b), _gain(gains, vector.u, b), -1.0)
            found[b] = self.tape.scaled(self.total(vector, [(1.0, self.e(vector, 0), gain)]), vector.z)
        return found

    # -- output ----------------------------------------------------------------------------------

    def write_point(self, number: int, point: str | Point, skipped: int) -> None:
        """Write all slots of a point to the output."""
        u, v, z = carrier(self.mechanism, point)
        with self.tape.step():
            for k in range(skipped, len(self.slots)):
                place = self.nodes[u][k]
                if v != u:
                    place = self.tape.carried(place, self.nodes[v][k], place, z)
                elif k == 0:
                    place = self.tape.plus(place, z)
                self.tape.emit(kernels.WRITE_POINT, self.tape.lane(place), k - skipped, number)

    def write_slopes(self, first: int) -> None:
        """Write the derivatives of nodes that can differ from 0 to the output from slot `first` on, and lane GOOD."""
        for node, slots in self.nodes.items():
            for k, slope in enumerate(slots[1:]):
                if not vanishes(slope):
                    self.tape.emit(kernels.WRITE_POINT, self.tape.lane(slope), first + k, node)
        self.tape.emit(kernels.WRITE_ANGLE, self.tape.lane(0.0), 0, 0)

    def write_angle(self, number: int, member: Member) -> None:
        """Write all slots of a member's angle phi to the output: the arm's w_k = (i phi_k - ...) w.

        A third derivative: (i phi_3 - 3 phi_1 phi_2 - i phi_1^3) w.
        """
        tape, (u, v, _) = self.tape, member.ends
        with tape.step():
            arms = [tape.plus(self.nodes[v][k], self.nodes[u][k], -1.0) for k in range(len(self.slots))]
            inverse = tape.real(kernels.INVERSE, tape.lane(arms[0]))
            lanes: list[int] = [0]
            for k, arm in enumerate(arms[1:], start=1):
                lanes.append(tape.real(kernels.ACROSS, tape.lane(arms[0]), tape.lane(arm), inverse.lane).lane)
                if self.slots[k].order == 3:
                    omega = lanes[(self.slots[k].cross or (0, 0))[0]]
                    square = tape.real(kernels.PRODUCT, omega, omega)
                    tape.emit(kernels.ADD_PRODUCT, lanes[k], square.lane, omega)
                tape.emit(kernels.WRITE_ANGLE, lanes[k], k - 1, number)


def _gain(gains: BaseGains, node: int, base: int) -> Number:
    return gains[node][base] if node in gains else 0j


def carrier(mechanism: Mechanism, point: str | Point) -> tuple[int, int, complex]:
    """Return nodes u, v and z so that a node or point is u + z (v - u), or u + z for one node."""
    if isinstance(point, str) and point in mechanism.nodes:
        node = mechanism.nodes.index(point)
        return node, node, 0j
    if isinstance(point, str):
        point = next(p for p in mechanism.points if p.name == point)
    member = mechanism.members[point.member]
    far, first = member.base, member.shape[0]
    u, v = member.nodes[0], member.nodes[far]
    if point.member == FRAME:
        return u, u, scalar(point.local - first)
    return u, v, scalar((point.local - first) / (member.shape[far] - first))
