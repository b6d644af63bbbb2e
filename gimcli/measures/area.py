"""Area swept by a member: of the region that its outline passes over, and signed.

The region (counted once, however often it is passed over) is a union of triangles between close poses: see
`sweeping_area`. The signed area is that of the line from the member's first node A to its second B, positive where it
moves to its left, d(area)/dt = Im((B - A)* (v_A + v_B) / 2); what is swept back is taken off, and over a closed cycle
it is the area within B's path less that within A's (planimeter). It is integrated by the trapezoidal rule with end
corrections, of fourth order. Source: Bottema & Roth, Theoretical Kinematics, 1979, chapter VIII (Holditch).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.measures import naming
from gimcli.measures.measure import Head, Kind, Measure, unit_of
from gimcli.measures.missing_rates import completed
from gimcli.measures.sweeping_area import corners_of, swept, swept_area
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.rates.path_derivatives import PathDerivatives


class Area(Measure):
    """Signed area so far in the rows; the region's area of the whole motion."""

    def __init__(self, mechanism: Mechanism, spec: str, member: int) -> None:
        self.mechanism, self.spec, self.member = mechanism, spec, member
        self.unit = unit_of(mechanism, "{}^2")
        self.heads = (Head(f"{spec}.signed", self.unit, "signed area swept"),)
        self._sum = 0.0
        self._last: ComplexArray | None = None  # (time, rate, its derivative, arm, middle) of the last row so far

    def values(self, derivatives: PathDerivatives) -> list[FloatArray]:
        """Return the signed area swept up to each row; a stretch that is not solved adds nothing."""
        rows = self._signed_rate(derivatives)
        joint = rows if self._last is None else np.concatenate([self._last, rows], axis=1)
        steps = _signed_steps(joint)
        self._last = rows[:, -1:]
        total = self._sum + np.concatenate([np.zeros(rows.shape[1] - len(steps)), np.cumsum(steps)])
        self._sum = float(total[-1])
        return [np.where(derivatives.motion.good, total, np.nan) * self.mechanism.scale**2]

    def _signed_rate(self, derivatives: PathDerivatives) -> ComplexArray:
        ends = list(self.mechanism.members[self.member].nodes[:2])
        z = derivatives.motion.z[ends]  # known even where velocities are not
        paths = np.moveaxis(derivatives.timed.nodes[:, ends], 0, 1).copy()
        paths[:, 0] = z
        a, b = completed(derivatives.clock, paths)
        arm, middle = b - a, (a + b) / 2.0
        rate = (np.conj(arm[0]) * middle[1]).imag
        change = (np.conj(arm[1]) * middle[1] + np.conj(arm[0]) * middle[2]).imag
        return np.array([derivatives.clock + 0j, rate + 0j, change + 0j, z[1] - z[0], (z[0] + z[1]) / 2.0])

    def outlines(self, derivatives: PathDerivatives) -> list[ComplexArray]:
        """Return triangles that cover the region."""
        corners = corners_of(self.mechanism, self.member)
        found = swept(derivatives, corners, 1) * self.mechanism.scale + self.mechanism.origin
        return list(found)

    def whole(self, derivatives: PathDerivatives) -> dict[str, Any]:
        """Return the region's area, how far it may be off, and the signed area of the whole motion."""
        area, error = swept_area(derivatives, corners_of(self.mechanism, self.member))
        square = self.mechanism.scale**2
        return {"area": area * square, "error": error * square, "signed": self._sum * square, "unit": self.unit}


def _signed_steps(rows: ComplexArray) -> FloatArray:
    """Return the area swept between successive rows; by the chord where a velocity is not known."""
    time, rate, change = rows[:3].real
    h = np.diff(time)
    smooth = h / 2.0 * (rate[1:] + rate[:-1]) + h**2 / 12.0 * (change[:-1] - change[1:])
    arm, middle = rows[3], rows[4]
    chord = (np.conj(arm[1:] + arm[:-1]) / 2.0 * np.diff(middle)).imag
    steps = np.where(np.isfinite(smooth), smooth, chord)
    return np.where(np.isfinite(steps), steps, 0.0)


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> list[Measure]:
    index = naming.member(mechanism, spec, names[0])
    if index == FRAME:
        raise UsageError(f"measure '{spec}': the frame sweeps nothing; name a moving member")
    return [Area(mechanism, spec, index)]


KIND = Kind(
    "area", "MEMBER",
    "area that a member sweeps: signed by its line so far, and of the region passed over (told at the end)",
    (1,), _make,
)  # fmt: skip
