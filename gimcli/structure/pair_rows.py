"""What sliding pairs and actuators impose, one row each: a span, a height or an angle, in the frames of the members.

SPAN    the distance of two nodes is the value
HEIGHT  the height of a node over a point of a guide, along a direction of the guide, is the value
ANGLE   the angle from the reference's direction to the arm's, about a node, is the value
"""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.kernels.constraints import ANGLE, HEIGHT, SPAN
from gimcli.mechanism import Drive, Input, Mechanism, Slide
from gimcli.structure.derived import derived
from gimcli.structure.rotation import rotation_classes
from gimcli.structure.steps import Value


@dataclass(frozen=True, eq=False)
class PairRow:
    """One row; `point` and `normal` are in the frame of the guide."""

    name: str
    kind: int  # of kernels.constraints
    nodes: tuple[int, ...]  # two that are apart, the one over the guide, or the vertex
    members: tuple[int, ...]  # none, the guide, or the arm and the reference
    value: Value
    point: complex = 0.0j
    normal: complex = 0.0j
    arm: complex = 1.0 + 0.0j  # directions in the frames of arm and reference
    reference: complex = 1.0 + 0.0j
    implied: bool = False  # by the pair's other slide and the angle that both hold

    @property
    def node(self) -> int:
        """The first of its nodes."""
        return self.nodes[0]

    @property
    def guide(self) -> int:
        """The last of its members."""
        return self.members[-1]


@derived
def pair_rows(mechanism: Mechanism) -> tuple[PairRow, ...]:
    """Return the rows of all sliding pairs, then those of all actuators."""
    implied = rotation_classes(mechanism).implied
    slides = [_of_slide(slide, number in implied) for number, slide in enumerate(mechanism.slides)]
    return (*slides, *(_of_actuator(k, actuator) for k, actuator in enumerate(mechanism.actuators)))


def _of_slide(slide: Slide, implied: bool) -> PairRow:
    normal = 1j * slide.direction
    return PairRow(
        slide.name, HEIGHT, (slide.node,), (slide.member,), Value(0.0), slide.point, normal, implied=implied
    )  # fmt: skip


def _of_actuator(number: int, actuator: Input) -> PairRow:
    name, value = actuator.name, Value(0.0, number)
    if actuator.drive is Drive.DISTANCE:
        return PairRow(name, SPAN, (actuator.a, actuator.b), (), value)
    if actuator.drive is Drive.TRAVEL:
        guide = (actuator.reference_member,)
        return PairRow(name, HEIGHT, (actuator.a,), guide, value, actuator.point, actuator.direction)
    return PairRow(
        name, ANGLE, (actuator.a,), (actuator.arm_member, actuator.reference_member), value,
        arm=actuator.arm_direction, reference=actuator.reference_direction,
    )  # fmt: skip
