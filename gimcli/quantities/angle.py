"""Angle of a member, or of one member relative to another, full turns counted.

The direction of a member is that from its first node to its second. The angle starts between -180 and 180 degrees
(-180 excluded).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, Mechanism
from gimcli.quantities.quantity import Head, Kind, Quantity, member_of
from gimcli.quantities.state import State
from gimcli.rates.member_angles import full_turn


class RelativeAngle(Quantity):
    """The angle from the second member to the first."""

    circular = True

    def __init__(self, mechanism: Mechanism, spec: str, first: int, second: int) -> None:
        self.mechanism, self.spec, self.pair = mechanism, spec, (first, second)
        self.heads = (Head(spec, mechanism.angle_unit, "angle"),)

    def values(self, state: State) -> Sequence[Any]:
        """Return the angle in the file's unit, full turns counted."""
        first, second = map(state.counted, self.pair)
        angle, turn = first - second, full_turn(state.mechanism)
        return [angle - turn * np.ceil(state.first(self.spec, angle) / turn - 0.5)]


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> Sequence[Quantity]:
    members = [member_of(mechanism, spec, name) for name in names]
    return [RelativeAngle(mechanism, spec, members[0], members[1] if len(members) > 1 else FRAME)]


KIND = Kind("angle", "MEMBER[/MEMBER]", "direction of a member, or its angle from another one", (1, 2), _make)
