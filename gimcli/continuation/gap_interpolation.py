"""Interpolation across singular positions that a motion passes, from solved positions on both sides.

At the singular position itself the equations determine a node to only half the digits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.numerics.interpolation import lagrange
from gimcli.numerics.roots import bisected
from gimcli.positions.position import Row

AT_LIMIT = 8.0 * float(np.finfo(float).eps)
"""Distance from a limit, relative to the parameter, below which an input is at the limit."""

BEYOND = 1e-12
"""Distance beyond a limit, relative to the parameter, up to which an input is at it: the accuracy of limits."""


@dataclass(frozen=True)
class GapInterpolation:
    """An interpolation polynomial through positions on both sides of a singular one.

    `limit`, `inwards`, `exit`, `ends` and `at` are the same as in `ArcPassage`, the other kind of gap.
    """

    centre: float
    rows: list[Row]

    @property
    def ends(self) -> tuple[float, float]:
        """The first and the last time of the interval."""
        return self.rows[0].time, self.rows[-1].time

    @property
    def limit(self) -> bool:
        """False: the input continues in the same sense."""
        return False

    @property
    def inwards(self) -> bool:
        """False: the motion leaves the gap on the other side."""
        return False

    @property
    def exit(self) -> Row:
        """The last row."""
        return self.rows[-1]

    def at(self, time: float) -> Row:
        """Return the interpolated position."""
        weights = lagrange([row.time for row in self.rows], time)
        x, y, g = (
            np.asarray(sum(w * getattr(row, part) for w, row in zip(weights, self.rows, strict=True))) for part in "xyg"
        )
        return Row(time, x, y, g)

    def mirrored(self) -> GapInterpolation:
        """Return the same gap in the opposite direction, with times of the opposite sign."""
        return GapInterpolation(
            -self.centre, [Row(-row.time, row.x, row.y, row.g, row.error) for row in reversed(self.rows)]
        )

    def turning(self) -> float:
        """Return the time at which a measure changes its sign, or the centre if none does."""
        low, high = self.rows[3], self.rows[4]
        flips = np.flatnonzero(low.g * high.g < 0.0)
        if not len(flips):
            return self.centre
        branch = flips[0]
        return bisected(lambda time: not self.at(time).g[branch] * low.g[branch] > 0.0, low.time, high.time)[1]
