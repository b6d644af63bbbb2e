"""Coordinates of nodes and points, directions of members, and their derivatives by the time; values of each row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gimcli.mechanism import Mechanism
from gimcli.quantities.quantity import Head, Quantity, angle_to_file
from gimcli.quantities.state import State
from gimcli.table import per_second

LETTERS = ("", "v", "a", "j")
"""Before the coordinates of a point, velocity, acceleration and jerk."""

TURNING = ("angle", "omega", "alpha", "jerk")
"""Direction of a member, angular velocity, acceleration and jerk."""


class PointVector(Quantity):
    """The place of a node or point, or its velocity, acceleration or jerk."""

    def __init__(self, mechanism: Mechanism, name: str, order: int) -> None:
        self.name, self.order, self.spec = name, order, f"{name}.{LETTERS[order]}"
        unit = per_second(mechanism.length_unit, order) if order else mechanism.length_unit
        self.heads = tuple(Head(f"{self.spec}{axis}", unit) for axis in "xy")

    def values(self, state: State) -> Sequence[Any]:
        """Return x and y."""
        z = state.point(self.name, self.order)
        z = z * state.mechanism.scale if self.order else state.mechanism.to_file(z)
        return z.real, z.imag


class MemberTurning(Quantity):
    """The direction of a member, full turns counted, or its angular velocity, acceleration or jerk."""

    def __init__(self, mechanism: Mechanism, member: int, order: int) -> None:
        self.member, self.order = member, order
        self.spec = f"{mechanism.members[member].name}.{TURNING[order]}"
        unit = per_second(mechanism.angle_unit, order) if order else mechanism.angle_unit
        self.heads, self.circular = (Head(self.spec, unit),), not order

    def values(self, state: State) -> Sequence[Any]:
        """Return the value."""
        if not self.order:
            return [state.counted(self.member)]
        return [angle_to_file(state.mechanism, state.turning(self.member, self.order))]


class RowValue(Quantity):
    """The step, the time, the residual, or an input."""

    def __init__(self, name: str, unit: str = "") -> None:
        self.spec, self.heads = name, (Head(name, unit),)

    def values(self, state: State) -> Sequence[Any]:
        """Return the value."""
        return [state.row(self.spec)]
