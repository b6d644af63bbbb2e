"""Equations of second degree with constant coefficients: one place at a time or many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.mechanism import FloatArray


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
        return np.asarray(self.c + (half @ x[..., None])[..., 0])

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

    def joined(self, *others: Quadric) -> Quadric:
        """Return these equations and others after them."""
        parts = (self, *others)
        return Quadric(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("c", "linear", "q")))

    def _bent(self, x: FloatArray) -> FloatArray:
        """Return Q x (..., m, n)."""
        flat = self.q.reshape(-1, x.shape[-1])
        bent = flat @ x if x.ndim == 1 else x @ flat.T
        return np.asarray(bent.reshape(*x.shape[:-1], *self.q.shape[:2]))
