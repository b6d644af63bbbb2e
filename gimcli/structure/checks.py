"""The constraints by which a position is checked, with the names of the model file.

They are derived from the members, pairs and actuators of the file, independently of the plan and the solvers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gimcli.calculus.numbers import scalar
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, Mechanism, Member, PairRow
from gimcli.structure.derived import derived
from gimcli.structure.rotation import ties
from gimcli.structure.steps import NONE, Value, Vector

ZERO = Value(0.0)


@dataclass(frozen=True, eq=False)
class Check:
    """One constraint: the distance of nodes p and q, the angle between two vectors, or the height of p over q.

    The direction of a member is taken from its first node and that of its `base`.
    """

    name: str
    kind: int
    p: int = NONE
    q: int = NONE  # NONE: the origin
    first: Vector | None = None  # ANGLE: the arm; HEIGHT: the normal
    second: Vector | None = None  # ANGLE: required direction of the arm
    value: Value = ZERO  # required length or height, normal frame


@derived
def checks(mechanism: Mechanism) -> tuple[Check, ...]:
    """Return every constraint of a mechanism."""
    return tuple(_checks(mechanism))


def _checks(mechanism: Mechanism) -> Iterator[Check]:
    for member in mechanism.members[FRAME + 1 :]:
        yield from _of_member(mechanism, member)
    for row in mechanism.pairs:
        if row.kind != ANGLE:
            yield _of_row(mechanism, row, NONE)
    for tie in ties(mechanism):  # heights are also satisfied if the body is rotated by 180 deg
        target = direction(mechanism, tie.guide).times(tie.turn)
        yield Check(tie.pair, ANGLE, first=direction(mechanism, tie.body), second=target)
    for number, actuator in enumerate(mechanism.actuators):
        yield _of_row(mechanism, actuator, number)


def _of_member(mechanism: Mechanism, member: Member) -> Iterator[Check]:
    names, nodes = mechanism.nodes, member.nodes
    shape = member.shape - member.shape[0]
    for k, node in enumerate(nodes[1:], start=1):
        label = member.name if len(nodes) == 2 else f"{member.name} {names[nodes[0]]}-{names[node]}"
        yield Check(label, SPAN, node, nodes[0], value=Value(abs(shape[k])))
        if k > 1:
            label = f"{member.name} {names[nodes[1]]}-{names[nodes[0]]}-{names[node]}"
            arm = Vector(scalar(1.0 / shape[k]), nodes[0], node)
            yield Check(label, ANGLE, first=arm, second=Vector(scalar(1.0 / shape[1]), nodes[0], nodes[1]))


def _of_row(mechanism: Mechanism, row: PairRow, actuator: int) -> Check:
    """Return the constraint of a pair (actuator NONE), or of the actuator of this number."""
    if row.kind == SPAN:
        first, second = row.nodes
        return Check(row.name, SPAN, second, first, value=Value(0.0, actuator))
    if row.kind == HEIGHT:
        return _height(mechanism, row, actuator)
    arm, reference = (direction(mechanism, k) for k in row.members)
    return Check(row.name, ANGLE, first=arm.times(row.arm), second=reference.driven(row.reference, actuator, 1))


def _height(mechanism: Mechanism, row: PairRow, actuator: int) -> Check:
    """Return the constraint on the height of a node over the line of a guide."""
    guide = mechanism.members[row.guide]
    origin = NONE if row.guide == FRAME else guide.nodes[0]
    offset = row.point if row.guide == FRAME else row.point - scalar(guide.shape[0])
    height = (offset * row.normal.conjugate()).real
    vector = direction(mechanism, row.guide).times(row.normal)
    return Check(row.name, HEIGHT, row.node, origin, vector, value=Value(height, actuator))


def direction(mechanism: Mechanism, index: int) -> Vector:
    """Return e^(i phi) of a member as a vector from its first node to the node farthest from it."""
    if index == FRAME:
        return Vector(1.0 + 0.0j)
    member = mechanism.members[index]
    far = member.base
    return Vector(scalar(1.0 / (member.shape[far] - member.shape[0])), member.nodes[0], member.nodes[far])
