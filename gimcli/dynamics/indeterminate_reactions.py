"""A reaction beside the stresses that redundant constraints leave open: what all solutions share of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray, FloatArray

UNIQUE = 1e-8
"""Part that a reaction may have in a free stress (a unit vector) and still count as unique."""


@dataclass(frozen=True)
class Amount:
    """A sum of unknowns with factors: real, or x + iy of a force."""

    value: NDArray[np.inexact]  # (rows,) in one solution
    free: NDArray[np.inexact]  # (surplus, rows) in each stress by which other solutions differ

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
        """The real value where all solutions share it, else NaN (rows,)."""
        if not len(self.free):
            return np.asarray(self.value)
        return np.where(np.linalg.norm(self.free, axis=0) < UNIQUE, self.value, np.nan)

    @property
    def shared(self) -> ComplexArray:
        """The component of a force that all solutions share, where they share one direction only, else NaN (rows,)."""
        if not len(self.free):
            return np.full(self.value.shape, np.nan + 1j * np.nan)
        open_ones = np.stack([self.free.real, self.free.imag]).transpose(2, 0, 1)  # rows, axis, stress
        axes, parts, _ = np.linalg.svd(open_ones)
        across = axes[:, 0, 1] + 1j * axes[:, 1, 1]
        least = parts[:, 1] if parts.shape[1] > 1 else np.zeros(len(parts))
        one = (least < UNIQUE) & (parts[:, 0] >= UNIQUE)
        return np.where(one, across * (across.conj() * self.value).real, np.nan + 1j * np.nan)


def joined(x: FloatArray, y: FloatArray) -> ComplexArray:
    """Return x + iy, each with its own NaN."""
    force = np.empty(len(x), dtype=complex)
    force.real, force.imag = x, y
    return force
