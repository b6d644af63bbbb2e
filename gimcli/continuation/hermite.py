"""Hermite's cubic between two points of a curve."""

from __future__ import annotations

from gimcli.mechanism import FloatArray

Part = float | FloatArray
"""Part of the way, 0..1; with more cubics than one an array that is multiplied with their points."""


def hermite(here: FloatArray, low: FloatArray, there: FloatArray, high: FloatArray, t: Part) -> FloatArray:
    """Return the cubic with given ends and derivatives by t there (low, high) at a part t."""
    p = (1.0 + 2.0 * t) * (1.0 - t) ** 2 * here + t**2 * (3.0 - 2.0 * t) * there
    return p + t * (1.0 - t) ** 2 * low - t**2 * (1.0 - t) * high


def hermite_slope(here: FloatArray, low: FloatArray, there: FloatArray, high: FloatArray, t: Part) -> FloatArray:
    """Return its derivative by t."""
    return 6.0 * t * (1.0 - t) * (there - here) + (1.0 - t) * (1.0 - 3.0 * t) * low + t * (3.0 * t - 2.0) * high
