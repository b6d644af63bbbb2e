"""The constraints of all pairs and actuators, with their values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, Mechanism, PairRow
from gimcli.structure.derived import derived
from gimcli.structure.rotation import rotation_classes
from gimcli.structure.steps import NONE, Constraint, Value, Vector


@dataclass(frozen=True, eq=False)
class ImposedRow(PairRow):
    """A constraint and its value; `implied`: the rotation classes and the other rows already ensure it."""

    value: Value = field(default=Value(0.0))
    implied: bool = False


@derived
def pair_rows(mechanism: Mechanism) -> tuple[ImposedRow, ...]:
    """Return the constraints of all pairs, then those of all actuators."""
    implied = rotation_classes(mechanism).implied
    pairs = [_imposed(row, NONE, row.kind == ANGLE or row in implied) for row in mechanism.pairs]
    return (*pairs, *(_imposed(actuator, k, False) for k, actuator in enumerate(mechanism.actuators)))


def _imposed(row: PairRow, actuator: int, implied: bool) -> ImposedRow:
    own = {part.name: getattr(row, part.name) for part in fields(PairRow)}
    return ImposedRow(**own, value=Value(0.0, actuator), implied=implied)


def constraint_of(
    mechanism: Mechanism, row: PairRow, value: Value, nodes: Sequence[Sequence[int]], pivot: int = NONE
) -> Constraint:
    """Return the constraint between nodes that gives a quantity a value.

    nodes: of each member, those whose first two determine its direction. pivot: the first node instead, if the member
    has it.
    """
    if row.kind == SPAN:
        first, second = row.nodes
        return Constraint(row.name, SPAN, second, first, value)

    def base(index: int) -> tuple[int, int, complex]:
        """Return two nodes of a member and the vector between them."""
        member = mechanism.members[index]
        u = pivot if pivot in member.nodes else nodes[index][0]
        v = next(n for n in nodes[index] if n != u)
        return u, v, member.reach(u, v)

    def direction(index: int, factor: complex) -> Vector:
        """Return e^(i phi) of a member times a factor."""
        if index == FRAME:
            return Vector(factor)
        u, v, reach = base(index)
        return Vector(factor / reach, u, v)

    if row.kind == HEIGHT:
        guide, vector = mechanism.members[row.guide], direction(row.guide, row.normal)
        anchor = guide.nodes[0] if row.guide == FRAME else vector.u
        return Constraint(row.name, HEIGHT, row.node, anchor, value.plus(row.height(guide.local(anchor))), vector)
    sides = list(zip(row.members, (row.arm, row.reference), strict=True))
    (arm, own), (reference, other) = sides if row.members[0] != FRAME else sides[::-1]
    u, v, reach = base(arm)
    vector = direction(reference, (own / reach).conjugate() * other)
    turn = 1 if row.members[0] != FRAME else -1
    return Constraint(row.name, ANGLE, v, u, Value(0.0), replace(vector, actuator=value.actuator, turn=turn))
