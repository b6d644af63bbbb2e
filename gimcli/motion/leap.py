"""Passage of a meeting of branches by interpolation, for mechanisms that are too large for the curve of their motion.

At the meeting itself the equations determine a node to only half the digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from gimcli.numerics.along import lagrange
from gimcli.positions.position import Row

if TYPE_CHECKING:
    from gimcli.continuation.arc import ArcPassage

BEFORE = 4
"""Number of rows on each side of the meeting."""


@dataclass(frozen=True)
class Leap:
    """An interpolation polynomial through rows on both sides of a meeting of branches; used like an `ArcPassage`."""

    centre: float
    rows: list[Row]
    limit = False
    met = None

    @property
    def ends(self) -> tuple[float, float]:
        """The first and the last time of the interval."""
        return self.rows[0].time, self.rows[-1].time

    @property
    def exit(self) -> Row:
        """The last row."""
        return self.rows[-1]

    def at(self, time: float) -> Row:
        """Return the interpolated position."""
        return extrapolated(self.rows, time)

    def mirrored(self) -> Leap:
        """Return the same passage in the opposite direction, with times of the opposite sign."""
        return Leap(-self.centre, [Row(-row.time, row.x, row.y, row.g, row.error) for row in reversed(self.rows)])

    def centred(self) -> Leap:
        """Return the same passage with its centre where a measure changes its sign, if one does."""
        low, high = self.rows[BEFORE - 1 : BEFORE + 1]
        flips = np.flatnonzero(low.g * high.g < 0.0)
        if not len(flips):
            return self
        from gimcli.numerics.along import bisected

        k = flips[0]
        return Leap(bisected(lambda time: not self.at(time).g[k] * low.g[k] > 0.0, low.time, high.time)[1], self.rows)


Gap: TypeAlias = "ArcPassage | Leap"
"""An interval around a singular position that a motion passes without solving its rows."""


def extrapolated(rows: list[Row], time: float) -> Row:
    """Return the value at a time of the polynomial through some rows."""
    weights = lagrange([row.time for row in rows], time)
    x, y, g = (np.asarray(sum(w * getattr(row, part) for w, row in zip(weights, rows, strict=True))) for part in "xyg")
    return Row(time, x, y, g)
