"""Critical positions of a point: singularities of the map y = Y x + y0 on the positions G(x) = 0.

A position is critical if l = (lambda, alpha) != 0 exists with lambda' G_x = alpha' Y: no velocity of the mechanism
moves the point along alpha. With l as additional unknowns, of length 1, these positions are a curve of a regular system
(Jo & Haug 1989; Haug, Luh, Adkins & Wang 1996). With one degree of freedom all positions are critical: alpha is normal
to the path, and the equations are G alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import FloatArray
from gimcli.structure.quadric import Quadric

NOTHING = 1e-9
"""Multiplier below which it is rounding; tangents, and multipliers of folds, have length 1."""


@dataclass(frozen=True)
class Stratum:
    """The set of positions with some inputs at an end of their ranges."""

    form: Quadric  # G: members and pairs, then one equation per input at an end
    table: FloatArray  # Y (2, n)
    held: tuple[tuple[int, float], ...] = ()  # actuator; +1 at the low end of its range, -1 at the high end

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return int(self.form.linear.shape[1])

    @property
    def freedoms(self) -> int:
        """Dimension of the set of positions."""
        return self.n - self.form.m


class CriticalPath:
    """The positions of a stratum with one degree of freedom: p = x (n,)."""

    def __init__(self, stratum: Stratum) -> None:
        self.stratum = stratum

    def residual(self, p: FloatArray) -> FloatArray:
        """Return G."""
        return self.stratum.form.value(p)

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return G_x."""
        return self.stratum.form.slope(p)

    def starts(self, x: FloatArray) -> FloatArray:
        """Return starts p (rows, n) of positions x (rows, n)."""
        return x

    def multipliers(self, p: FloatArray, tangent: FloatArray) -> FloatArray:
        """Return l (m + 2,): alpha is the point's velocity turned to the left, 0 where the point is at rest."""
        form, velocity = self.stratum.form, self.stratum.table @ tangent
        alpha = np.array([-velocity[1], velocity[0]])
        weights = np.linalg.lstsq(form.slope(p).T, self.stratum.table.T @ alpha, rcond=None)[0]
        return np.concatenate([weights, alpha])


class Fold:
    """The critical positions of a stratum with several degrees of freedom: p = (x, lambda, alpha)."""

    def __init__(self, stratum: Stratum) -> None:
        self.stratum = stratum

    def residual(self, p: FloatArray) -> FloatArray:
        """Return G, lambda' G_x - alpha' Y and |l|^2 - 1; p may have leading axes."""
        form, n = self.stratum.form, self.stratum.n
        x, weights, alpha = p[..., :n], p[..., n:-2], p[..., -2:]
        balance = np.einsum("...mn,...m->...n", form.slope(x), weights) - alpha @ self.stratum.table
        length = np.sum(p[..., n:] ** 2, axis=-1, keepdims=True) - 1.0
        return np.concatenate([form.value(x), balance, length], axis=-1)

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return the derivatives of the residual by p."""
        form, n, m = self.stratum.form, self.stratum.n, self.stratum.form.m
        slope = form.slope(p[..., :n])
        table = np.zeros((*p.shape[:-1], m + n + 1, n + m + 2))
        table[..., :m, :n] = slope
        table[..., m : m + n, :n] = form.weighted(p[..., n:-2])
        table[..., m : m + n, n:-2] = np.swapaxes(slope, -1, -2)
        table[..., m : m + n, -2:] = -self.stratum.table.T
        table[..., -1, n:] = 2.0 * p[..., n:]
        return table

    def starts(self, x: FloatArray) -> FloatArray:
        """Return starts p (2 rows, ·) at positions x (rows, n), with the two least singular vectors as multipliers."""
        slope = self.stratum.form.slope(x)
        minus = np.broadcast_to(-self.stratum.table, (len(x), *self.stratum.table.shape))
        left = np.linalg.svd(np.concatenate([slope, minus], axis=1))[0]
        return np.concatenate([np.concatenate([x, left[:, :, -1 - k]], axis=1) for k in range(2)])

    def multipliers(self, p: FloatArray, tangent: FloatArray) -> FloatArray:
        """Return l (m + 2,)."""
        return p[self.stratum.n :]


Critical = CriticalPath | Fold


def critical(stratum: Stratum) -> Critical:
    """Return the curve of a stratum's critical positions."""
    return CriticalPath(stratum) if stratum.freedoms == 1 else Fold(stratum)


def sides(curve: Critical, p: FloatArray, tangent: FloatArray) -> FloatArray:
    """Return on which sides of its path the point can move from a critical position, positive along alpha.

    There is one number for each input at an end, released into its range (0 if the point then moves only along the
    path), and one for each curvature: alpha . y'' = -lambda' G_xx (v, v) for the velocities v at which the point rests.
    """
    stratum = curve.stratum
    multipliers, x = curve.multipliers(p, tangent), p[: stratum.n]
    weights, base = multipliers[:-2], stratum.form.m - len(stratum.held)
    released = [weights[base + k] * inward for k, (_, inward) in enumerate(stratum.held)]
    released = [0.0 if abs(gain) <= NOTHING else gain for gain in released]
    count = stratum.freedoms - 1
    if not count:
        return np.array(released)
    across = np.linalg.svd(np.vstack([stratum.form.slope(x), stratum.table]))[2][-count:]
    bend = -across @ stratum.form.weighted(weights) @ across.T
    return np.concatenate([released, np.linalg.eigvalsh(bend)])
