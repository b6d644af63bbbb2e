"""Positions of a coupler point of many four-bars in closed form, with their derivatives (Freudenstein's loop)."""

from typing import NamedTuple

import numpy as np

NAMES = ("r1", "r2", "r3", "r4", "rcx", "rcy", "theta0", "x0", "y0")


class Rates(NamedTuple):
    """Values (designs, rows, 2) of the point and their derivatives."""

    values: np.ndarray
    by_dimension: np.ndarray  # (designs, rows, 2, dimensions)
    by_input: np.ndarray


class FourBarPoint:
    """The coupler point of four-bars (see families.md of the references); `side` +1: B to the left of A -> O4."""

    def __init__(self, side=1.0):
        self.side = side

    def values(self, designs, inputs):
        return _real(self._positions(designs, inputs)[0])

    def rates(self, designs, inputs):
        with np.errstate(all="ignore"):
            place, parts = self._positions(designs, inputs)
            by_dimension, by_input = _slopes(designs, *parts)
        return Rates(_real(place), np.stack((by_dimension.real, by_dimension.imag), 2), _real(by_input))

    def _positions(self, designs, inputs):
        r1, r2, r3, r4, u, v, theta, x, y = (designs[:, k, None] for k in range(9))
        with np.errstate(all="ignore"):
            e2 = np.exp(1j * inputs)
            diagonal = r1 - r2 * e2
            square = np.abs(diagonal) ** 2
            along = (square + r3**2 - r4**2) / (2.0 * r3)
            e3 = diagonal / square * (along + 1j * self.side * np.sqrt(square - along**2))
        turned = np.exp(1j * theta)
        return x + 1j * y + turned * (r2 * e2 + (u + 1j * v) * e3), (e2, e3, turned)


def _slopes(designs, e2, e3, turned):
    r1, r2, r3, r4, u, v = (designs[:, k, None] for k in range(6))
    e4 = (r2 * e2 + r3 * e3 - r1) / r4
    lever = (1j * r3 * e3 * e4.conj()).real
    arm = 1j * (u + 1j * v) * e3

    def by_loop(change):
        """The turn of the coupler that closes the loop again, times its lever at P."""
        return -arm * (change * e4.conj()).real / lever

    one = np.ones_like(e2)
    columns = [by_loop(-one), e2 + by_loop(e2), by_loop(e3), by_loop(-e4), e3, 1j * e3]
    columns.append(1j * (r2 * e2 + (u + 1j * v) * e3))
    columns = [turned * column for column in columns] + [one, 1j * one]
    return np.stack(columns, -1), turned * (1j * r2 * e2 + by_loop(1j * r2 * e2))


def _real(z):
    return np.stack((z.real, z.imag), -1)
