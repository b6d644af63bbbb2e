"""Area swept by a member: the area of the region that its outline covers, and the signed area of its line.

The region (each part counted once) is a union of triangles between close poses, see `sweeping_area`. The signed area is
swept by the line from the member's first node A to its second node B, positive if the line moves to its left:
d(area)/dt = Im((B - A)* (v_A + v_B) / 2). Over a closed cycle it is the area inside B's path minus that inside A's
(planimeter). It is integrated by the trapezoidal rule with end corrections, of fourth order. Source: Bottema & Roth,
Theoretical Kinematics, 1979, chapter VIII (Holditch).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.quantities import naming
from gimcli.quantities.missing_rates import completed
from gimcli.quantities.quantity import ColumnRange, Head, Kind, Quantity, unit_of
from gimcli.quantities.state import State
from gimcli.quantities.sweeping_area import corners_of, swept, swept_area
from gimcli.rates.path_derivatives import PathDerivatives


class Area(Quantity):
    """The signed area up to each row, and the area of the region of the whole motion."""

    def __init__(self, mechanism: Mechanism, spec: str, member: int) -> None:
        self.mechanism, self.spec, self.member = mechanism, spec, member
        self.unit = unit_of(mechanism, "{}^2")
        self.heads = (Head(f"{spec}.signed", self.unit, "signed area swept"),)

    def values(self, state: State) -> Sequence[Any]:
        """Return the signed area swept up to each row; intervals that are not solved add nothing."""
        rows, (last, before) = self._signed_rate(state.path), state.memory.get(self.spec, (None, 0.0))
        steps = _signed_steps(rows if last is None else np.concatenate([last, rows], axis=1))
        total = before + np.concatenate([np.zeros(rows.shape[1] - len(steps)), np.cumsum(steps)])
        state.memory[self.spec] = rows[:, -1:], float(total[-1])
        return [np.where(state.path.motion.good, total, np.nan) * self.mechanism.scale**2]

    def _signed_rate(self, path: PathDerivatives) -> ComplexArray:
        """Return time, rate, its derivative, arm and middle (5, rows)."""
        ends = list(self.mechanism.members[self.member].nodes[:2])
        z = path.motion.z[ends]  # known also in rows without velocities
        paths = np.moveaxis(path.timed.nodes[:, ends], 0, 1).copy()
        paths[:, 0] = z
        a, b = completed(path.clock, paths)
        arm, middle = b - a, (a + b) / 2.0
        rate = (np.conj(arm[0]) * middle[1]).imag
        change = (np.conj(arm[1]) * middle[1] + np.conj(arm[0]) * middle[2]).imag
        return np.array([path.clock + 0j, rate + 0j, change + 0j, z[1] - z[0], (z[0] + z[1]) / 2.0])

    def outlines(self, path: PathDerivatives) -> list[ComplexArray]:
        """Return the triangles that cover the region."""
        corners = corners_of(self.mechanism, self.member)
        return list(swept(path, corners, 1) * self.mechanism.scale + self.mechanism.origin)

    def whole(self, state: State, ranges: Mapping[str, ColumnRange]) -> dict[str, Any]:
        """Return area and error estimate of the region, and the signed area of the whole motion."""
        area, error = swept_area(state.path, corners_of(self.mechanism, self.member))
        square, signed = self.mechanism.scale**2, state.memory[self.spec][1]
        return {"area": area * square, "error": error * square, "signed": signed * square, "unit": self.unit}


def _signed_steps(rows: ComplexArray) -> FloatArray:
    """Return the signed area swept between successive rows; by the chord where a velocity is unknown."""
    time, rate, change = rows[:3].real
    h = np.diff(time)
    smooth = h / 2.0 * (rate[1:] + rate[:-1]) + h**2 / 12.0 * (change[:-1] - change[1:])
    arm, middle = rows[3], rows[4]
    chord = (np.conj(arm[1:] + arm[:-1]) / 2.0 * np.diff(middle)).imag
    steps = np.where(np.isfinite(smooth), smooth, chord)
    return np.where(np.isfinite(steps), steps, 0.0)


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> Sequence[Quantity]:
    index = naming.member(mechanism, spec, names[0])
    if index == FRAME:
        raise UsageError(f"measure '{spec}': expected a moving member, got the frame")
    return [Area(mechanism, spec, index)]


KIND = Kind(
    "area", "MEMBER",
    "area that a member sweeps: signed area of its line, and area of the region it covers (printed at the end)",
    (1,), _make,
)  # fmt: skip
