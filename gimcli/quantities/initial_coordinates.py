"""How far the assembled position is from the initial coordinates, and on which side of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism, Member
from gimcli.quantities.state import Positions
from gimcli.quantities.transmission import TransmissionJoint, output_joints
from gimcli.structure.rotation import drawn_turn, shapes

FAR = 0.1
"""Distance of a node from its initial coordinates, relative to the size, above which a drawing is far."""

IN_LINE = 0.05
"""Sine of an angle below which three nodes are in line, so that they have no side."""


@dataclass(frozen=True)
class InitialCoordinates:
    """The distances of the nodes of an assembled position from their initial coordinates, and the mirrored parts."""

    distance: FloatArray = field(repr=False)  # (nodes,) normal frame; 0 for remote nodes
    mirrored_members: tuple[str, ...]  # their shape is the mirror image of their initial coordinates
    mirrored_joints: tuple[tuple[str, str, str], ...]  # node and two parts, on the other side than drawn

    @property
    def farthest(self) -> int:
        """The node with the greatest distance."""
        return int(np.argmax(self.distance))

    def far(self, mechanism: Mechanism) -> list[int]:
        """Return the nodes that are far from their initial coordinates, farthest first."""
        order = np.argsort(-self.distance, kind="stable").tolist()
        return [node for node in order if self.distance[node] > FAR * mechanism.size]


def initial_coordinates(mechanism: Mechanism, z: ComplexArray) -> InitialCoordinates:
    """Compare an assembled position z (nodes,), at the inputs of the drawing, with the initial coordinates."""
    members = tuple(
        member.name
        for member in mechanism.members[FRAME + 1 :]
        if len(member.nodes) > 2 and _mirrored(mechanism, member)
    )
    joints = tuple(
        (mechanism.nodes[joint.node], joint.first.name, joint.second.name)
        for joint in output_joints(mechanism)
        if _side(mechanism, joint, mechanism.drawn) * _side(mechanism, joint, z) < 0.0
    )
    away = np.abs(z - mechanism.drawn)
    away[list(mechanism.remote)] = 0.0  # a small angle moves them far
    return InitialCoordinates(away, members, joints)


def _mirrored(mechanism: Mechanism, member: Member) -> bool:
    """Return whether the mirror image of a shape fits the initial coordinates better than the shape."""
    own, drawn = shapes(mechanism, member)
    return bool(abs(np.dot(own, drawn)) * (1.0 - IN_LINE) > abs(drawn_turn(mechanism, member)))


def _side(mechanism: Mechanism, joint: TransmissionJoint, z: ComplexArray) -> float:
    """Return 1 or -1 for the side of the second line of a joint, seen from the first; 0 if they are in line."""
    first, second = (
        complex(Positions(mechanism, z[:, None]).line(line, joint.node)[0]) for line in (joint.first, joint.second)
    )
    size = abs(first) * abs(second)
    sine = (first.conjugate() * second).imag / size if size > 0.0 else 0.0
    return float(np.sign(sine)) if abs(sine) > IN_LINE else 0.0
