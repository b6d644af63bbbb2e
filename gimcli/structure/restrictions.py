"""Restrictions of the Geometrical-Iterative Method: distances and angles between nodes.

A member of n nodes is n-1 distances and n-2 angles about one vertex, or, where its nodes are not
in line, 2n-3 distances; which of these is a choice that convergence depends on, so that every
member offers several models. A sliding pair is an angle of 0 or 180 degrees: its node stays on a
line, here also one at an offset. Source: Petuya et al. 2004, section 2.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.structure.pair_rows import ImposedRow, pair_rows
from gimcli.structure.steps import NONE, Value, Vector

COLLINEAR = 0.02
"""Sine below which three nodes count as in line: tangent circles converge like 1/sqrt(n)."""


@dataclass(frozen=True)
class Restriction:
    """One restriction and the nodes that it can move while the others stand still.

    RD: distance of `b` from `a`. RA: `b` on the ray from vertex `a` along `vector`. RL: `b` at
    `value` from `a` along the unit `vector`.
    """

    name: str
    kind: str
    a: int
    b: int
    value: Value
    vector: Vector | None
    movable: tuple[int, ...]

    @cached_property
    def nodes(self) -> tuple[int, ...]:
        """All nodes that it ties."""
        return tuple(dict.fromkeys((self.a, self.b, *(self.vector.nodes if self.vector else ()))))

    @property
    def driven(self) -> bool:
        """Tell whether an actuator's law enters."""
        return self.value.actuator != NONE or (self.vector is not None and self.vector.actuator != NONE)


@dataclass(frozen=True)
class Move:
    """Impose a restriction by moving one of its nodes."""

    restriction: Restriction
    node: int
    rule: str = ""

    @property
    def about(self) -> tuple[int, ...]:
        """Nodes that stand still."""
        return tuple(n for n in self.restriction.nodes if n != self.node)


def distance(name: str, a: int, b: int, value: Value) -> Restriction:
    """Return a distance; either node can move."""
    return Restriction(name, "RD", a, b, value, None, (a, b))


def angle(name: str, vertex: int, arm: int, b: int, turn: complex, actuator: int = NONE) -> Restriction:
    """Return the angle at a vertex from arm to b; either end can move."""
    return Restriction(name, "RA", vertex, b, Value(0.0), Vector(turn, vertex, arm, actuator=actuator), (b, arm))


def member_models(mechanism: Mechanism, index: int, nodes: Sequence[int], known: Set[int]) -> list[list[Restriction]]:
    """Return the ways to model the free nodes of a member.

    First what settles its nodes one after the other as they are placed (`nodes` is that order):
    distances only, where they are not in line. Then the chain of distances and angles as written,
    which is the paper's model of a member, and the distances and angles about each vertex.
    """
    member, names = mechanism.members[index], mechanism.nodes
    place = {n: member.local(n) for n in nodes}

    def rd(a: int, b: int) -> Restriction:
        label = member.name if len(nodes) == 2 else f"{member.name} {names[a]}-{names[b]}"
        return distance(label, a, b, Value(abs(place[b] - place[a])))

    def ra(vertex: int, arm: int, b: int) -> Restriction:
        turn = (place[b] - place[vertex]) / (place[arm] - place[vertex])
        label = f"{member.name} {names[arm]}-{names[vertex]}-{names[b]}"
        return angle(label, vertex, arm, b, turn / abs(turn))

    def wanted(restrictions: list[Restriction]) -> list[Restriction]:
        return [r for r in restrictions if not set(r.nodes) <= known]

    def sine(a: int, b: int, c: int) -> float:
        p, q = place[a] - place[c], place[b] - place[c]
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
        links = pairwise(chain)
        models.append(wanted([rd(a, b) for a, b in links] + [ra(b, a, c) for a, b, c in joints]))
    for vertex in fixed[:2] if len(fixed) > 1 else nodes:
        others = [n for n in nodes if n != vertex]
        if len(fixed) > 1:  # angles from the arm that stands
            arm = next(n for n in fixed if n != vertex)
            free = [n for n in others if n not in known]
            models.append([r for n in free for r in (rd(vertex, n), ra(vertex, arm, n))])
        else:
            turns = pairwise(others)
            models.append(wanted([rd(vertex, n) for n in others] + [ra(vertex, p, n) for p, n in turns]))
    return [m for k, m in enumerate(models) if _names(m) not in [_names(o) for o in models[:k]]]


def _names(model: list[Restriction]) -> set[tuple[str, tuple[int, ...]]]:
    return {(r.kind, tuple(sorted(r.nodes)) if r.kind == "RD" else r.nodes) for r in model}


def pair_restrictions(mechanism: Mechanism, known: Set[int], kinematic: Sequence[Sequence[int]]) -> list[Restriction]:
    """Return the restrictions of sliding pairs and actuators that a free node takes part in."""
    make = {SPAN: _span, HEIGHT: _line, ANGLE: _driven_angle}
    result = [make[row.kind](mechanism, row, kinematic) for row in pair_rows(mechanism)]
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
        vector = Vector(row.normal / (member.local(v) - member.local(anchor)), anchor, v)
        if value.actuator == NONE:
            movable = (row.node, v, anchor)
    height = (row.normal.conjugate() * (row.point - member.local(anchor))).real
    return Restriction(row.name, "RL", anchor, row.node, value.plus(height), vector, movable)


def _driven_angle(mechanism: Mechanism, row: ImposedRow, kinematic: Sequence[Sequence[int]]) -> Restriction:
    (arm_member, reference), number = row.members, row.value.actuator
    member = mechanism.members[arm_member]
    pivot = row.node if row.nodes else kinematic[arm_member][0]
    arm = next(n for n in kinematic[arm_member] if n != pivot)
    turn = (member.local(arm) - member.local(pivot)) / row.arm
    if reference == FRAME:
        turn *= row.reference
        vector = Vector(turn / abs(turn), actuator=number)
        return Restriction(row.name, "RA", pivot, arm, Value(0.0), vector, (arm, pivot))
    body = mechanism.members[reference]
    u = pivot if pivot in body.nodes else kinematic[reference][0]
    v = next(n for n in kinematic[reference] if n != u)
    turn *= row.reference / (body.local(v) - body.local(u))
    ray = Vector(turn / abs(turn), u, v, actuator=number)
    return Restriction(row.name, "RA", pivot, arm, Value(0.0), ray, (arm, v if u == pivot else pivot))


# -- linearisation --------------------------------------------------------------------------


def gradient(r: Restriction, z: ComplexArray, inputs: FloatArray) -> dict[int, complex]:
    """Return g of every node with d(restriction) = sum Re(conj(g) dz), as a length."""
    a, b = complex(z[r.a]), complex(z[r.b])
    if r.kind == "RD":
        n = (b - a) / abs(b - a) if b != a else 1.0 + 0.0j  # no direction: any will do
        return {r.b: n, r.a: -n}
    assert r.vector is not None
    w, factor = vector_value(r.vector, z, inputs)
    if r.kind == "RA":  # where it is fulfilled; a drive's value need not fit the position
        u = (b - a) / abs(b - a) if b != a else w / abs(w)
        g = {r.b: 1j * u, r.a: -1j * u}
        if r.vector.u != NONE:
            arm = complex(z[r.vector.v] - z[r.vector.u])
            reach = (u.conjugate() * (b - a)).real
            turn = 1j * arm / abs(arm) ** 2 * reach  # the ray turns with the arm
            g[r.vector.v] = g.get(r.vector.v, 0.0) - turn
            g[r.vector.u] = g.get(r.vector.u, 0.0) + turn
        return g
    g = {r.b: w, r.a: -w}
    if r.vector.u != NONE:
        lever = factor.conjugate() * (b - a)
        g[r.vector.v] = g.get(r.vector.v, 0.0) + lever
        g[r.vector.u] = g.get(r.vector.u, 0.0) - lever
    return g


def measure(r: Restriction, z: ComplexArray, inputs: FloatArray) -> float:
    """Return a restriction's measure, a length whose gradient is `gradient`."""
    a, b = complex(z[r.a]), complex(z[r.b])
    if r.kind == "RD":
        return abs(b - a)
    assert r.vector is not None
    w, _ = vector_value(r.vector, z, inputs)
    if r.kind == "RL":
        return (w.conjugate() * (b - a)).real
    turn = w.conjugate() * (b - a)
    return float(np.angle(turn)) * abs(b - a)


def vector_value(vector: Vector, z: ComplexArray, inputs: FloatArray) -> tuple[complex, complex]:
    """Return a vector at a position, and its factor z e^(+-i theta)."""
    factor = vector.z
    if vector.actuator != NONE:
        factor *= complex(np.exp(1j * vector.turn * inputs[vector.actuator]))
    base = complex(z[vector.v] - z[vector.u]) if vector.u != NONE else 1.0 + 0.0j
    return factor * base, factor
