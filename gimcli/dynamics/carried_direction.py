"""Directions that move with a member."""

from __future__ import annotations

from gimcli.mechanism import FRAME, Mechanism
from gimcli.structure.steps import Vector


def carried_direction(mechanism: Mechanism, index: int, direction: complex) -> Vector:
    """Return a direction in a member's own frame as a vector that moves with the member."""
    if index == FRAME:
        return Vector(direction)
    u, v, span = mechanism.members[index].ends
    return Vector(direction / span, u, v)
