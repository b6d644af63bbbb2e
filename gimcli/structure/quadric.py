"""Equations of second degree with constant coefficients: one place at a time or many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.mechanism import FloatArray

DEPENDENT = 1e-10
"""A singular value below this part of the greatest is 0: that linear equation follows from others."""


@dataclass(frozen=True)
class Flat:
    """The places x = x0 + N y (..., n) of all y (..., k)."""

    origin: FloatArray = field(repr=False)  # x0 (n,)
    basis: FloatArray = field(repr=False)  # N (n, k) orthonormal: distances are the same in x and y

    def lift(self, y: FloatArray) -> FloatArray:
        """Return x of y."""
        return np.asarray(y @ self.basis.T + self.origin)

    def drop(self, x: FloatArray) -> FloatArray:
        """Return y of the place next to x."""
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

    def value(self, x: FloatArray) -> FloatArray:
        """Return the left sides (..., m) at x (..., n)."""
        half = self.linear + 0.5 * self._bent(x)
        return np.asarray(self.c + (half @ x if x.ndim == 1 else (half @ x[..., None])[..., 0]))

    def slope(self, x: FloatArray) -> FloatArray:
        """Return their derivatives (..., m, n)."""
        return np.asarray(self.linear + self._bent(x))

    def weighted(self, weights: FloatArray) -> FloatArray:
        """Return the second derivative (..., n, n) of the equations' sum with some weights (..., m)."""
        return np.asarray(np.tensordot(weights, self.q, (-1, 0)))

    def rows(self, chosen: Sequence[int]) -> Quadric:
        """Return some of the equations."""
        at = list(chosen)
        return Quadric(self.c[at], self.linear[at], self.q[at])

    def parted(self, x: FloatArray) -> tuple[Flat, Quadric]:
        """Return where the linear equations hold, from the place next to x (n,) on, and the others there.

        Nothing is parted from equations that are all linear.
        """
        bent = np.any(self.q, axis=(1, 2))
        if not bent.any():
            return Flat(np.zeros_like(x), np.eye(len(x))), self
        linear = self.linear[~bent]
        left, size, right = np.linalg.svd(linear)
        told = int(np.sum(size > DEPENDENT * size.max(initial=0.0)))
        fall = right[:told].T @ ((left[:, :told].T @ (self.c[~bent] + linear @ x)) / size[:told])
        flat = Flat(x - fall, right[told:].T)
        return flat, self.rows(np.flatnonzero(bent).tolist()).within(flat)

    def within(self, flat: Flat) -> Quadric:
        """Return the equations in the coordinates y of some places."""
        n, origin = flat.basis, flat.origin
        return Quadric(self.value(origin), self.slope(origin) @ n, n.T @ self.q @ n)

    def joined(self, *others: Quadric) -> Quadric:
        """Return these equations and others after them."""
        parts = (self, *others)
        return Quadric(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("c", "linear", "q")))

    def _bent(self, x: FloatArray) -> FloatArray:
        """Return Q x (..., m, n)."""
        flat = self.q.reshape(-1, x.shape[-1])
        bent = flat @ x if x.ndim == 1 else x @ flat.T
        return np.asarray(bent.reshape(*x.shape[:-1], *self.q.shape[:2]))
