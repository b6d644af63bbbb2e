"""Rates of points in rows in which the equations do not determine them, as at a change point."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray

SMOOTH = 1e-2
"""Greatest distance of a position from the curve through the rows beside it, relative to their distance."""


def quintic(h: FloatArray, before: ComplexArray, after: ComplexArray) -> ComplexArray:
    """Return coefficients (6, ...) in s = 0..1 of curves with given positions, rates and accelerations at both ends.

    The ends (3, ...) are `h` apart in time.
    """
    (p0, v0, a0), (p1, v1, a1) = before, after
    v0, v1, a0, a1, d = v0 * h, v1 * h, a0 * h**2, a1 * h**2, p1 - p0
    third = 10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1
    fourth = -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1
    return np.array([p0, v0, a0 / 2, third, fourth, 6 * d - 3 * (v0 + v1) - (a0 - a1) / 2])


def completed(time: FloatArray, paths: ComplexArray) -> ComplexArray:
    """Return paths (points, 3, rows) in which missing rates of single rows are filled if the motion is smooth there.

    They are those of the polynomial of sixth degree through the position of the row and all values of the rows beside.
    """
    known = np.all(np.isfinite(paths), axis=(0, 1)).reshape(-1)
    alone = np.flatnonzero(~known[1:-1] & known[:-2] & known[2:]) + 1
    if not len(alone):
        return paths
    before, after, here = (np.moveaxis(paths[:, :, alone + k], 1, 0) for k in (-1, 1, 0))
    ahead, behind = time[alone + 1] - time[alone], time[alone] - time[alone - 1]
    h = ahead + behind
    place, rate, change = _derivatives(quintic(h, before, after), behind / h)
    off = (here[0] - place) / -((ahead * behind) ** 3)  # a multiple of u^3, u = (t - t_before) (t - t_after)
    u, slope = -ahead * behind, behind - ahead
    rate = rate / h + off * 3.0 * u**2 * slope
    change = change / h**2 + off * (6.0 * u * slope**2 + 6.0 * u**2)
    smooth = np.abs(here[0] - place) <= SMOOTH * np.abs(after[0] - before[0])
    filled = paths.copy()
    filled[:, 1, alone] = np.where(smooth, rate, here[1])
    filled[:, 2, alone] = np.where(smooth, change, here[2])
    return filled


def _derivatives(table: ComplexArray, s: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return the values of polynomials (6, ...) at s, and their first two derivatives by it."""
    place = sum(c * s**k for k, c in enumerate(table))
    rate = sum(k * c * s ** (k - 1) for k, c in enumerate(table) if k)
    change = sum(k * (k - 1) * c * s ** (k - 2) for k, c in enumerate(table) if k > 1)
    return np.asarray(place), np.asarray(rate), np.asarray(change)
