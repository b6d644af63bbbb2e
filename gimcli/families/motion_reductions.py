"""One number of a whole motion: the least, greatest, mean or root-mean-square value of a quantity, and its range.

By the envelope theorem, the derivative of a least or greatest value is that of the quantity in the row of this value.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.families.position_quantities import PositionAngle, PositionQuantity, QuantityFinder
from gimcli.mechanism import FloatArray

REDUCED = re.compile(r"\s*(min|max|range|mean|rms)\s*\((.*)\)\s*")


@dataclass(frozen=True)
class MotionReduction:
    """A number of a motion, in the unit of its quantity."""

    word: str
    quantity: PositionQuantity

    @property
    def name(self) -> str:
        """The name, such as max(P.y)."""
        return f"{self.word}({self.quantity.name})"

    def values(self, rows: FloatArray) -> FloatArray:
        """Return the number of each motion (...,) from the values of its rows (..., rows)."""
        return np.asarray(_VALUES[self.word](self._continuous(rows)))

    def slopes(self, rows: FloatArray, slopes: FloatArray) -> FloatArray:
        """Return the derivatives (dimensions,) from the rows of one motion and their derivatives (dimensions, rows)."""
        values = self._continuous(rows)
        least, greatest = slopes[:, np.argmin(values)], slopes[:, np.argmax(values)]
        found = {"min": least, "max": greatest, "range": greatest - least, "mean": slopes.mean(axis=1)}
        if self.word == "rms":
            return np.asarray(slopes @ values / (len(values) * self.values(rows)))
        return np.asarray(found[self.word])

    def _continuous(self, rows: FloatArray) -> FloatArray:
        """Return angles without jumps of a full turn."""
        quantity = self.quantity
        return np.unwrap(rows, period=quantity.turn) if isinstance(quantity, PositionAngle) else rows


_VALUES: dict[str, Callable[[FloatArray], Any]] = {
    "min": lambda rows: rows.min(axis=-1), "max": lambda rows: rows.max(axis=-1),
    "range": lambda rows: np.asarray(np.ptp(rows, axis=-1)), "mean": lambda rows: rows.mean(axis=-1),
    "rms": lambda rows: np.asarray(np.sqrt(np.mean(rows**2, axis=-1))),
}  # fmt: skip


def reductions(finder: QuantityFinder, text: str) -> list[MotionReduction]:
    """Return the numbers of a motion that a text such as range(P.y) names; an empty list for other texts."""
    found = REDUCED.fullmatch(text)
    return [] if found is None else [MotionReduction(found[1], one) for one in finder.find(found[2].strip())]
