"""What is checked of a position: every constraint by the user's name, from the members as written.

Nothing of a plan or a solver enters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gimcli.kernels import constraints
from gimcli.mechanism import FRAME, Drive, Input, Mechanism, Member
from gimcli.structure.derived import derived
from gimcli.structure.rotation import ties
from gimcli.structure.steps import NONE, Value, Vector

NOTHING = Value(0.0)


@dataclass(frozen=True, eq=False)
class Check:
    """One constraint: the span of nodes p and q, the angle between two vectors, or a height of p over q.

    Directions are taken from the two nodes of a member that are farthest apart.
    """

    name: str
    kind: int  # of kernels.constraints
    p: int = NONE
    q: int = NONE  # NONE: the origin
    first: Vector | None = None  # arm, or normal
    second: Vector | None = None  # what the arm should point along
    value: Value = NOTHING  # length, or height


@derived
def checks(mechanism: Mechanism) -> tuple[Check, ...]:
    """Return every constraint of a mechanism."""
    return tuple(_checks(mechanism))


def _checks(mechanism: Mechanism) -> Iterator[Check]:
    for member in mechanism.members[FRAME + 1 :]:
        yield from _of_member(mechanism, member)
    for slide in mechanism.slides:
        yield _height(mechanism, slide.name, slide.node, slide.member, slide.point, 1j * slide.direction, NONE)
    for tie in ties(mechanism):  # heights do not tell a member turned end for end
        held = direction(mechanism, tie.guide).times(tie.turn)
        yield Check(tie.name, constraints.ANGLE, first=direction(mechanism, tie.body), second=held)
    for number, actuator in enumerate(mechanism.actuators):
        yield _of_actuator(mechanism, number, actuator)


def _of_member(mechanism: Mechanism, member: Member) -> Iterator[Check]:
    names, nodes = mechanism.nodes, member.nodes
    shape = member.shape - member.shape[0]
    for k, node in enumerate(nodes[1:], start=1):
        label = member.name if len(nodes) == 2 else f"{member.name} {names[nodes[0]]}-{names[node]}"
        yield Check(label, constraints.SPAN, node, nodes[0], value=Value(float(np.abs(shape[k]))))
        if k > 1:
            label = f"{member.name} {names[nodes[1]]}-{names[nodes[0]]}-{names[node]}"
            arm = Vector(complex(1.0 / shape[k]), nodes[0], node)
            yield Check(label, constraints.ANGLE, first=arm, second=Vector(complex(1.0 / shape[1]), nodes[0], nodes[1]))


def _of_actuator(mechanism: Mechanism, number: int, actuator: Input) -> Check:
    name = actuator.name
    if actuator.drive is Drive.DISTANCE:
        return Check(name, constraints.SPAN, actuator.b, actuator.a, value=Value(0.0, number))
    if actuator.drive is Drive.TRAVEL:
        guide = actuator.reference_member
        return _height(mechanism, name, actuator.a, guide, actuator.point, actuator.direction, number)
    arm = direction(mechanism, actuator.arm_member).times(actuator.arm_direction)
    reference = direction(mechanism, actuator.reference_member).driven(actuator.reference_direction, number, 1)
    return Check(name, constraints.ANGLE, first=arm, second=reference)


def _height(
    mechanism: Mechanism, name: str, node: int, guide: int, point: complex, normal: complex, actuator: int
) -> Check:
    """Return the height of a node over the line through `point` of a guide, along the guide's `normal`."""
    origin = NONE if guide == FRAME else mechanism.members[guide].nodes[0]
    away = point if guide == FRAME else point - complex(mechanism.members[guide].shape[0])
    height = (away * normal.conjugate()).real
    vector = direction(mechanism, guide).times(normal)
    return Check(name, constraints.HEIGHT, node, origin, vector, value=Value(height, actuator))


def direction(mechanism: Mechanism, index: int) -> Vector:
    """Return e^(i phi) of a member, times a length, from its two nodes farthest apart."""
    if index == FRAME:
        return Vector(1.0 + 0.0j)
    member = mechanism.members[index]
    far = farthest(member)
    return Vector(complex(1.0 / (member.shape[far] - member.shape[0])), member.nodes[0], member.nodes[far])


def farthest(member: Member) -> int:
    """Return which of a member's nodes is farthest from its first."""
    return int(np.argmax(np.abs(member.shape - member.shape[0])))
