"""Places at which a condition begins to hold, or a value changes its sign, between two others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Place = TypeVar("Place", float, FloatArray)

HALVINGS = 60
"""Most bisections: more than the binary digits of a number."""


def bisected(holds: Callable[[Place], Any], low: Place, high: Place) -> tuple[Place, Place]:
    """Return the last place at which a condition does not hold and the first at which it does, to rounding.

    It does not hold at `low` and holds at `high`; arrays are pairs of their own. `low` may be above `high`.
    """
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if np.all((middle == low) | (middle == high)):
            break
        there = holds(middle)
        low, high = (cast("Place", np.where(there, *ends)[()]) for ends in ((low, middle), (middle, high)))
    return low, high


def sign_changes(value: Callable[[FloatArray], FloatArray], grid: FloatArray) -> FloatArray:
    """Return the places (roots,) between those of a grid (rows,) at which a value changes its sign, to rounding."""
    at = value(grid)
    k = np.flatnonzero(at[:-1] * at[1:] < 0.0)
    return bisected(lambda place: value(place) * at[k] <= 0.0, grid[k], grid[k + 1])[1] if len(k) else grid[k]
