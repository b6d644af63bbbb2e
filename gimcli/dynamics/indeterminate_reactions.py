"""Determined parts of a reaction when redundant constraints allow self-stresses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray, FloatArray

UNIQUE = 1e-8
"""Greatest component of a reaction in a unit self-stress for which the reaction counts as determined."""


@dataclass(frozen=True)
class Amount:
    """A linear combination of unknowns: a real value, or a force x + iy."""

    value: NDArray[np.inexact]  # (rows,) in one solution
    free: NDArray[np.inexact]  # (surplus, rows) in each self-stress; solutions differ by combinations of them

    def __add__(self, other: Amount) -> Amount:
        return Amount(self.value + other.value, self.free + other.free)

    def __sub__(self, other: Amount) -> Amount:
        return Amount(self.value - other.value, self.free - other.free)

    @property
    def real(self) -> Amount:
        """The component along x."""
        return Amount(self.value.real, self.free.real)

    @property
    def imag(self) -> Amount:
        """The component along y."""
        return Amount(self.value.imag, self.free.imag)

    @property
    def determined(self) -> FloatArray:
        """The real value if it is the same in all solutions, else NaN (rows,)."""
        if not len(self.free):
            return np.asarray(self.value)
        return np.where(np.linalg.norm(self.free, axis=0) < UNIQUE, self.value, np.nan)

    @property
    def shared(self) -> ComplexArray:
        """The component of a force that is the same in all solutions if exactly one component is, else NaN (rows,)."""
        if not len(self.free):
            return np.full(self.value.shape, np.nan + 1j * np.nan)
        open_ones = np.stack([self.free.real, self.free.imag]).transpose(2, 0, 1)  # rows, axis, stress
        axes, parts, _ = np.linalg.svd(open_ones)
        across = axes[:, 0, 1] + 1j * axes[:, 1, 1]
        least = parts[:, 1] if parts.shape[1] > 1 else np.zeros(len(parts))
        one = (least < UNIQUE) & (parts[:, 0] >= UNIQUE)
        return np.where(one, across * (across.conj() * self.value).real, np.nan + 1j * np.nan)


def joined(x: FloatArray, y: FloatArray) -> ComplexArray:
    """Return x + iy; NaN in x does not make y NaN."""
    force = np.empty(len(x), dtype=complex)
    force.real, force.imag = x, y
    return force
