"""Cubics between two points with derivatives, and polynomials through several points."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

Part = float | FloatArray
"""Fraction of the interval, 0..1; for several cubics an array that can be multiplied with their points."""


def hermite(here: FloatArray, low: FloatArray, there: FloatArray, high: FloatArray, t: Part) -> FloatArray:
    """Return the cubic at t, for given end points (here, there) and derivatives by t at them (low, high)."""
    p = (1.0 + 2.0 * t) * (1.0 - t) ** 2 * here + t**2 * (3.0 - 2.0 * t) * there
    return p + t * (1.0 - t) ** 2 * low - t**2 * (1.0 - t) * high


def hermite_slope(here: FloatArray, low: FloatArray, there: FloatArray, high: FloatArray, t: Part) -> FloatArray:
    """Return the derivative by t of the same cubic."""
    return 6.0 * t * (1.0 - t) * (there - here) + (1.0 - t) * (1.0 - 3.0 * t) * low + t * (3.0 * t - 2.0) * high


def lagrange(nodes: Sequence[float], time: float) -> list[float]:
    """Return the weights, at a time, of the values at `nodes` in the interpolation polynomial."""
    return [math.prod((time - b) / (a - b) for b in nodes if b != a) for a in nodes]
