"""Restrictions of the Geometrical-Iterative Method: distances and angles between nodes.

A member of n nodes is modelled by n-1 distances and n-2 angles about one vertex or, if its nodes are not in line, by
2n-3 distances. Convergence depends on the model, so several models are offered for each member. A sliding pair is an
angle of 0 or 180 degrees: its node stays on a line; here the line may also have an offset. Source: Petuya et al. 2004,
section 2.

Two parameters occur in several functions: `known`, the nodes whose positions are already determined (restrictions
between known nodes are left out), and `kinematic`, for each member its nodes that take part in the solution (see
`kinematic_nodes`).
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.structure.pair_rows import ImposedRow, pair_rows
from gimcli.structure.steps import NONE, Constraint, Value, Vector

COLLINEAR = 0.02
"""Three nodes are in line if the sine of their angle is below this: near-tangent circles converge like 1/sqrt(n)."""


@dataclass(frozen=True)
class Restriction(Constraint):
    """A constraint, and those of its nodes that can be moved to satisfy it while its other nodes are fixed.

    The paper's RD (distance) is a SPAN, its RA (p on the ray from vertex q) an ANGLE. RL (p on a line) is a HEIGHT.
    """

    movable: tuple[int, ...] = ()

    @property
    def letters(self) -> str:
        """RD, RA or RL."""
        return {SPAN: "RD", ANGLE: "RA", HEIGHT: "RL"}[self.kind]

    def gradient(self, z: ComplexArray, inputs: FloatArray) -> dict[int, complex]:
        """Return {node: g} with d(constraint) = sum Re(conj(g) dz), as a length; an angle is multiplied by |p - q|."""
        a, b = complex(z[self.q]), complex(z[self.p])
        if self.kind == SPAN:
            n = (b - a) / abs(b - a) if b != a else 1.0 + 0.0j  # coincident nodes: any direction
            return {self.p: n, self.q: -n}
        assert self.vector is not None
        w, factor = vector_value(self.vector, z, inputs)
        if self.kind == ANGLE:  # as if satisfied: the input of an actuator need not match the position
            u = (b - a) / abs(b - a) if b != a else w / abs(w)
            g = {self.p: 1j * u, self.q: -1j * u}
            if self.vector.u != NONE:
                arm = complex(z[self.vector.v] - z[self.vector.u])
                reach = (u.conjugate() * (b - a)).real
                turn = 1j * arm / abs(arm) ** 2 * reach  # the ray rotates with the arm
                g[self.vector.v] = g.get(self.vector.v, 0.0) - turn
                g[self.vector.u] = g.get(self.vector.u, 0.0) + turn
            return g
        g = {self.p: w, self.q: -w}
        if self.vector.u != NONE:
            lever = factor.conjugate() * (b - a)
            g[self.vector.v] = g.get(self.vector.v, 0.0) + lever
            g[self.vector.u] = g.get(self.vector.u, 0.0) - lever
        return g

    def measure(self, z: ComplexArray, inputs: FloatArray) -> float:
        """Return the value of a constraint as a length; its gradient is `gradient`."""
        a, b = complex(z[self.q]), complex(z[self.p])
        if self.kind == SPAN:
            return abs(b - a)
        assert self.vector is not None
        w, _ = vector_value(self.vector, z, inputs)
        if self.kind == HEIGHT:
            return (w.conjugate() * (b - a)).real
        turn = w.conjugate() * (b - a)
        return float(np.angle(turn)) * abs(b - a)


def vector_value(vector: Vector, z: ComplexArray, inputs: FloatArray) -> tuple[complex, complex]:
    """Return the value of a vector at a position z (nodes,), and its factor z e^(+-i theta)."""
    factor = vector.z
    if vector.actuator != NONE:
        factor *= complex(np.exp(1j * vector.turn * inputs[vector.actuator]))
    base = complex(z[vector.v] - z[vector.u]) if vector.u != NONE else 1.0 + 0.0j
    return factor * base, factor


@dataclass(frozen=True)
class Move:
    """Satisfy a restriction by moving one of its nodes; `rule` is that which selected the move, `reason` why."""

    restriction: Restriction
    node: int
    rule: str = ""
    reason: str = ""

    @property
    def about(self) -> tuple[int, ...]:
        """Nodes of the restriction that are not moved."""
        return tuple(n for n in self.restriction.nodes if n != self.node)


def distance(name: str, a: int, b: int, value: Value) -> Restriction:
    """Return a distance restriction; either node can be moved."""
    return Restriction(name, SPAN, b, a, value, None, (a, b))


def angle(name: str, vertex: int, arm: int, b: int, turn: complex, actuator: int = NONE) -> Restriction:
    """Return the restriction of the angle at a vertex from `arm` to b; either end can be moved.

    turn: e^(i angle). actuator: the actuator whose input is added to the angle.
    """
    return Restriction(name, ANGLE, b, vertex, Value(0.0), Vector(turn, vertex, arm, actuator=actuator), (b, arm))


def member_distance(mechanism: Mechanism, index: int, a: int, b: int, alone: bool) -> Restriction:
    """Return the distance of two nodes of a member; `alone`: the only restriction of the member."""
    member, names = mechanism.members[index], mechanism.nodes
    return distance(member.name + f" {names[a]}-{names[b]}" * (not alone), a, b, Value(abs(member.reach(a, b))))


def member_angle(mechanism: Mechanism, index: int, vertex: int, arm: int, b: int) -> Restriction:
    """Return the angle at a vertex between two nodes of a member."""
    member, names = mechanism.members[index], mechanism.nodes
    turn = member.reach(vertex, b) / member.reach(vertex, arm)
    return angle(f"{member.name} {names[arm]}-{names[vertex]}-{names[b]}", vertex, arm, b, turn / abs(turn))


def member_models(mechanism: Mechanism, index: int, nodes: Sequence[int], known: Set[int]) -> list[list[Restriction]]:
    """Return the alternative models of a member, without the restrictions between known nodes.

    nodes: the member's nodes in the order in which they are placed. The first model consists of distances only (if the
    nodes are not in line). The next is the chain of distances and angles in the order of the file. The others are the
    distances and angles about each vertex.
    """
    member = mechanism.members[index]
    rd = partial(member_distance, mechanism, index, alone=len(nodes) == 2)
    ra = partial(member_angle, mechanism, index)

    def wanted(restrictions: list[Restriction]) -> list[Restriction]:
        return [r for r in restrictions if not set(r.nodes) <= known]

    def sine(a: int, b: int, c: int) -> float:
        p, q = member.reach(c, a), member.reach(c, b)
        return abs((p.conjugate() * q).imag) / (abs(p) * abs(q))

    if len(nodes) == 2:
        return [wanted([rd(*nodes)])]
    models = []
    chain = [n for n in member.nodes if n in nodes]
    sides = [rd(nodes[0], nodes[1])]
    for k, c in enumerate(nodes[2:], start=2):
        best = max((sine(a, b, c), a, b) for i, b in enumerate(nodes[:k]) for a in nodes[:i])
        if best[0] < COLLINEAR:
            break
        sides += [rd(best[1], c), rd(best[2], c)]
    else:
        models.append(wanted(sides))
    fixed = [n for n in nodes if n in known]
    if len(fixed) < 2:  # as written: A B C is AB, BC and the angle at B
        joints = zip(chain, chain[1:], chain[2:], strict=False)
        models.append(wanted([rd(a, b) for a, b in pairwise(chain)] + [ra(b, a, c) for a, b, c in joints]))
    for vertex in fixed[:2] if len(fixed) > 1 else nodes:
        others = [n for n in nodes if n != vertex]
        if len(fixed) > 1:  # angles from the arm between the two known nodes
            arm = next(n for n in fixed if n != vertex)
            free = [n for n in others if n not in known]
            models.append([r for n in free for r in (rd(vertex, n), ra(vertex, arm, n))])
        else:
            turns = pairwise(others)
            models.append(wanted([rd(vertex, n) for n in others] + [ra(vertex, p, n) for p, n in turns]))
    return [m for k, m in enumerate(models) if _names(m) not in [_names(o) for o in models[:k]]]


def _names(model: list[Restriction]) -> set[tuple[str, tuple[int, ...]]]:
    return {(r.letters, tuple(sorted(r.nodes)) if r.kind == SPAN else r.nodes) for r in model}


def pair_restrictions(mechanism: Mechanism, known: Set[int], kinematic: Sequence[Sequence[int]]) -> list[Restriction]:
    """Return the restrictions of sliding pairs and actuators, without those between known nodes."""
    make = {SPAN: _span, HEIGHT: _line, ANGLE: _driven_angle}
    result = (make[row.kind](mechanism, row, kinematic) for row in pair_rows(mechanism))
    return [r for r in result if not set(r.nodes) <= known]


def _span(_: Mechanism, row: ImposedRow, __: Sequence[Sequence[int]]) -> Restriction:
    a, b = row.nodes
    return distance(row.name, a, b, row.value)


def _line(mechanism: Mechanism, row: ImposedRow, kinematic: Sequence[Sequence[int]]) -> Restriction:
    member, value = mechanism.members[row.guide], row.value
    movable: tuple[int, ...] = (row.node,)
    if row.guide == FRAME:
        anchor, vector = member.nodes[0], Vector(row.normal)
    else:
        anchor, v = kinematic[row.guide][:2]
        vector = Vector(row.normal / (member.reach(anchor, v)), anchor, v)
        if value.actuator == NONE:
            movable = (row.node, v, anchor)
    height = row.height(member.local(anchor))
    return Restriction(row.name, HEIGHT, row.node, anchor, value.plus(height), vector, movable)


def _driven_angle(mechanism: Mechanism, row: ImposedRow, kinematic: Sequence[Sequence[int]]) -> Restriction:
    (arm_member, reference), number = row.members, row.value.actuator
    member = mechanism.members[arm_member]
    pivot = row.node if row.nodes else kinematic[arm_member][0]
    arm = next(n for n in kinematic[arm_member] if n != pivot)
    turn = member.reach(pivot, arm) / row.arm
    if reference == FRAME:
        turn *= row.reference
        vector = Vector(turn / abs(turn), actuator=number)
        return Restriction(row.name, ANGLE, arm, pivot, Value(0.0), vector, (arm, pivot))
    body = mechanism.members[reference]
    u = pivot if pivot in body.nodes else kinematic[reference][0]
    v = next(n for n in kinematic[reference] if n != u)
    turn *= row.reference / body.reach(u, v)
    ray = Vector(turn / abs(turn), u, v, actuator=number)
    return Restriction(row.name, ANGLE, arm, pivot, Value(0.0), ray, (arm, v) if u == pivot else (arm, pivot, v, u))
