"""Equations of second degree with constant coefficients, evaluated at one point or at many points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.mechanism import FloatArray

DEPENDENT = 1e-10
"""Singular values below this fraction of the greatest are 0: a linear equation then depends on others."""


@dataclass(frozen=True)
class Flat:
    """An affine subspace: the points x = x0 + N y (..., n) for all y (..., k)."""

    origin: FloatArray = field(repr=False)  # x0 (n,)
    basis: FloatArray = field(repr=False)  # N (n, k) orthonormal: distances are the same in x and y

    def lift(self, y: FloatArray) -> FloatArray:
        """Return the point x (..., n) of y (..., k)."""
        return np.asarray(y @ self.basis.T + self.origin)

    def drop(self, x: FloatArray) -> FloatArray:
        """Return y (..., k) of the point closest to x (..., n)."""
        return np.asarray((x - self.origin) @ self.basis)


@dataclass(frozen=True)
class Quadric:
    """c + L x + x Q x / 2 = 0, m equations in n coordinates; x may have leading axes."""

    c: FloatArray = field(repr=False)  # (m,)
    linear: FloatArray = field(repr=False)  # (m, n)
    q: FloatArray = field(repr=False)  # (m, n, n) symmetric

    @property
    def m(self) -> int:
        """Number of equations."""
        return len(self.c)

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return int(self.linear.shape[1])

    def value(self, x: FloatArray) -> FloatArray:
        """Return the left sides (..., m) at x (..., n)."""
        half = self.linear + 0.5 * self._second(x)
        return np.asarray(self.c + (half @ x if x.ndim == 1 else (half @ x[..., None])[..., 0]))

    def slope(self, x: FloatArray) -> FloatArray:
        """Return the derivatives (..., m, n) of the left sides."""
        return np.asarray(self.linear + self._second(x))

    def weighted(self, weights: FloatArray, x: FloatArray) -> FloatArray:
        """Return the second derivative (..., n, n) at any x of the weighted sum of the equations, weights (..., m)."""
        return np.asarray(np.tensordot(weights, self.q, (-1, 0)))

    def rows(self, chosen: Sequence[int]) -> Quadric:
        """Return the chosen equations."""
        at = list(chosen)
        return Quadric(self.c[at], self.linear[at], self.q[at])

    def divided(self, factor: float) -> Quadric:
        """Return these equations divided by a factor."""
        return Quadric(self.c / factor, self.linear / factor, self.q / factor)

    def split_linear(self, x: FloatArray) -> tuple[Flat, Quadric]:
        """Return the subspace on which the linear equations hold, and the other equations in its coordinates.

        The origin of the subspace is its point closest to x (n,). If all equations are linear, they are returned
        unchanged, with the whole space.
        """
        curved = np.any(self.q, axis=(1, 2))
        if not curved.any():
            return Flat(np.zeros_like(x), np.eye(len(x))), self
        linear = self.linear[~curved]
        left, size, right = np.linalg.svd(linear)
        rank = int(np.sum(size > DEPENDENT * size.max(initial=0.0)))
        correction = right[:rank].T @ ((left[:, :rank].T @ (self.c[~curved] + linear @ x)) / size[:rank])
        flat = Flat(x - correction, right[rank:].T)
        return flat, self.rows(np.flatnonzero(curved).tolist()).within(flat)

    def within(self, flat: Flat) -> Quadric:
        """Return the equations in the coordinates y of a subspace."""
        n, origin = flat.basis, flat.origin
        return Quadric(self.value(origin), self.slope(origin) @ n, n.T @ self.q @ n)

    def joined(self, *others: Quadric) -> Quadric:
        """Return these equations followed by others."""
        parts = (self, *others)
        return Quadric(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("c", "linear", "q")))

    def _second(self, x: FloatArray) -> FloatArray:
        """Return Q x (..., m, n)."""
        table = self.q.reshape(-1, x.shape[-1])
        product = table @ x if x.ndim == 1 else x @ table.T
        return np.asarray(product.reshape(*x.shape[:-1], *self.q.shape[:2]))
