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

from gimcli.mechanism import ANGLE, HEIGHT, SPAN, Mechanism
from gimcli.structure.pair_rows import ImposedRow, constraint_of, pair_rows
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
    return Restriction(name, SPAN, b, a, value, movable=(a, b))


def angle(name: str, vertex: int, arm: int, b: int, turn: complex, actuator: int = NONE) -> Restriction:
    """Return the restriction of the angle at a vertex from `arm` to b; either end can be moved.

    turn: e^(i angle). actuator: the actuator whose input is added to the angle.
    """
    ray = Vector(turn, vertex, arm, actuator=actuator)
    return Restriction(name, ANGLE, b, vertex, Value(0.0), ray, movable=(b, arm))


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
    result = (_of_row(mechanism, row, kinematic) for row in pair_rows(mechanism))
    return [r for r in result if not set(r.nodes) <= known]


def _of_row(mechanism: Mechanism, row: ImposedRow, kinematic: Sequence[Sequence[int]]) -> Restriction:
    pivot = NONE if row.kind != ANGLE else row.node if row.nodes else kinematic[row.members[0]][0]
    c = constraint_of(mechanism, row, row.value, kinematic, pivot)
    vector, movable = c.vector, [c.q, c.p] if row.kind == SPAN else [c.p]
    if vector is not None and row.kind == ANGLE:
        vector = vector.times(1.0 / abs(vector.z))
        movable += [c.q] if vector.u == NONE else [vector.v] if vector.u == c.q else [c.q, vector.v, vector.u]
    elif vector is not None and vector.u != NONE and c.value.actuator == NONE:
        movable += [vector.v, c.q]
    return Restriction(c.name, c.kind, c.p, c.q, c.value, vector, movable=tuple(movable))
