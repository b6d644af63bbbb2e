"""Angle of a member, or of one member relative to another, full turns counted.

The direction of a member is that from its first node to its second. The angle starts between -180 and 180 degrees
(-180 excluded).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gimcli.measures import naming
from gimcli.measures.measure import Head, Kind, Measure
from gimcli.mechanism import FRAME, FloatArray, Mechanism
from gimcli.rates.member_angles import full_turn
from gimcli.rates.path_derivatives import PathDerivatives


class RelativeAngle(Measure):
    """The angle from the second member to the first."""

    def __init__(self, mechanism: Mechanism, spec: str, first: int, second: int) -> None:
        self.mechanism, self.spec, self.pair = mechanism, spec, (first, second)
        self.heads = (Head(spec, mechanism.angle_unit, "angle"),)
        self._shift: float | None = None  # full turns that are subtracted; None before the first solved row

    def values(self, derivatives: PathDerivatives) -> list[FloatArray]:
        """Return the angle in the file's unit, full turns counted."""
        first, second = (derivatives.angle(member) for member in self.pair)
        angle, turn = np.asarray(first - second), full_turn(self.mechanism)
        good = np.flatnonzero(np.isfinite(angle))
        if self._shift is None and len(good):
            self._shift = turn * math.ceil(float(angle[good[0]]) / turn - 0.5)
        return [angle - (self._shift or 0.0)]


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> list[Measure]:
    members = [naming.member(mechanism, spec, name) for name in names]
    return [RelativeAngle(mechanism, spec, members[0], members[1] if len(members) > 1 else FRAME)]


KIND = Kind("angle", "MEMBER[/MEMBER]", "direction of a member, or its angle from another one", (1, 2), _make)
