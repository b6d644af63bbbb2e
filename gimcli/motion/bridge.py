"""Singular positions that a motion goes straight through: interpolated from both sides.

At the position itself the equations tell a node to half the digits only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import FloatArray


@dataclass
class Row:
    """One solved position and the measures that tell its branch."""

    time: float
    x: FloatArray
    y: FloatArray
    g: FloatArray
    error: float = 0.0


@dataclass(frozen=True)
class Bridge:
    """Positions on both sides of a singular one, and the polynomial through them."""

    centre: float
    rows: list[Row]
    flipped: tuple[int, ...] = ()  # branches whose sign it changes

    @property
    def times(self) -> list[float]:
        """Times of the positions."""
        return [row.time for row in self.rows]

    def at(self, time: float) -> Row:
        """Return the interpolated position."""
        weights = lagrange(self.times, time)
        x, y, g = (
            np.asarray(sum(w * getattr(row, part) for w, row in zip(weights, self.rows, strict=True))) for part in "xyg"
        )
        return Row(time, x, y, g)

    def turning(self) -> float:
        """Return the time at which a measure changes its sign; the centre where none does."""
        low, high = self.rows[3], self.rows[4]
        flips = np.flatnonzero(low.g * high.g < 0.0)
        if not len(flips):
            return self.centre
        branch, a, b = flips[0], low.time, high.time
        for _ in range(60):
            middle = 0.5 * (a + b)
            same = self.at(middle).g[branch] * low.g[branch] > 0.0
            a, b = (middle, b) if same else (a, middle)
        return 0.5 * (a + b)


def lagrange(nodes: list[float], time: float) -> list[float]:
    """Return the weights of the polynomial through values at some nodes."""
    weights = []
    for i, a in enumerate(nodes):
        w = 1.0
        for k, b in enumerate(nodes):
            if k != i:
                w *= (time - b) / (a - b)
        weights.append(w)
    return weights
