"""Interpolation of samples without overshoot, as scipy's PchipInterpolator, which takes half a second to import."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


class ShapePreservingCubic:
    """Cubics between samples (samples,), with a continuous derivative and without overshoot; extrapolated beyond them.

    The derivative at a sample is the harmonic mean of the slopes on both sides, weighted by the lengths, and 0 at an
    extreme. Source: Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304; at the ends Moler, Numerical
    Computing with MATLAB, 2004, section 3.6.
    """

    def __init__(self, at: ArrayLike, value: ArrayLike) -> None:
        self.at, own = np.asarray(at, dtype=float), np.asarray(value, dtype=float)
        h, self._inner = np.diff(self.at), self.at[1:-1]
        rise = np.diff(own) / h
        ends = [_slope_at_end(one, other) for one, other in ((h, rise), (h[::-1], rise[::-1]))]
        slope = np.array([ends[0], *_inner_slopes(h, rise), ends[1]])
        bent = (slope[:-1] + slope[1:] - 2.0 * rise) / h
        falling = np.array([bent / h, (rise - slope[:-1]) / h - bent, slope[:-1], own[:-1]])
        self._falling = [np.apply_along_axis(np.polyder, 0, falling, order) for order in range(4)]

    def __call__(self, at: FloatArray, order: int = 0) -> FloatArray:
        """Return the value at each abscissa, or its derivative of an order."""
        k = self._inner.searchsorted(at, side="right")
        after = at - self.at.take(k)
        found, *others = self._falling[order].take(k, axis=1)
        for part in others:
            found = found * after + part
        return np.asarray(found)


def _inner_slopes(h: FloatArray, rise: FloatArray) -> FloatArray:
    """Return the derivatives at the inner samples, for lengths h and slopes `rise` of the intervals."""
    left, right = h[:-1] + 2.0 * h[1:], 2.0 * h[:-1] + h[1:]
    same = np.sign(rise[:-1]) * np.sign(rise[1:]) > 0.0
    before, after = (np.where(same, one, 1.0) for one in (rise[:-1], rise[1:]))
    return np.where(same, 1.0 / ((left / before + right / after) / (left + right)), 0.0)


def _slope_at_end(h: FloatArray, rise: FloatArray) -> float:
    """Return the derivative at the first sample: that of the parabola through three, if it keeps the shape."""
    if len(h) == 1:
        return float(rise[0])
    slope = float(((2.0 * h[0] + h[1]) * rise[0] - h[0] * rise[1]) / (h[0] + h[1]))
    if np.sign(slope) != np.sign(rise[0]):
        return 0.0
    return 3.0 * float(rise[0]) if np.sign(rise[0]) != np.sign(rise[1]) and abs(slope) > 3.0 * abs(rise[0]) else slope
