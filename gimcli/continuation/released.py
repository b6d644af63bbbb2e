"""All positions of a mechanism with released inputs: x and k parameters q, F(x, u) = 0 with u = base + along q."""

from __future__ import annotations

import numpy as np

from gimcli.continuation.arclength import ArclengthConstants, correct
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.carried import read_inputs
from gimcli.structure.system import system_of

SETTLING = ArclengthConstants(corrections=12)
"""Constants of the corrections of a position."""

LOST = 1e-10
"""Singular values below this fraction of the greatest are 0."""


class ReleasedPositions:
    """Positions y = (x, q) (n + k,) as the solutions of m equations; inputs that follow the linkage are in x."""

    def __init__(self, mechanism: Mechanism, base: FloatArray, along: FloatArray) -> None:
        self.mechanism, self.system = mechanism, system_of(mechanism)
        self.base, self.along = base, along  # (actuators,), (actuators, k)

    @property
    def count(self) -> int:
        """The number k of parameters."""
        return int(self.along.shape[1])

    def given(self, q: FloatArray | float) -> FloatArray:
        """Return the inputs (..., actuators) at q (..., k); those that follow the linkage are not determined by it."""
        return np.asarray(self.base + np.atleast_1d(q) @ self.along.T)

    def rates(self, q: FloatArray | float) -> FloatArray:
        """Return the derivatives of the inputs (actuators, k), or (..., actuators, k), at q (..., k)."""
        return self.along

    def point(self, z: ComplexArray, q: FloatArray | float) -> FloatArray:
        """Return y (n + k,) of positions z (nodes,)."""
        inputs = read_inputs(self.mechanism, z, self.given(q)) if self.system.followers else None
        return np.append(self.system.coordinates(z, inputs), q)

    def nodes(self, y: FloatArray) -> ComplexArray:
        """Return the positions (nodes,) of y (n + k,), or (nodes, rows) of y (n + k, rows)."""
        return self.system.nodes(y[: self.system.n])

    def inputs(self, y: FloatArray) -> FloatArray:
        """Return all inputs (actuators,) of y (n + k,), or (actuators, rows) of y (n + k, rows)."""
        return self._completed(self.given(y[self.system.n :].T), y.T).T

    def input_rates(self, y: FloatArray, v: FloatArray) -> FloatArray:
        """Return the rates of all inputs (..., actuators) along directions v (..., n + k) at y (..., n + k)."""
        n = self.system.n
        return self._completed((self.rates(y[..., n:]) @ v[..., n:, None])[..., 0], v)

    def linearised(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the equations (..., m) at y (..., n + k) and their derivatives (..., m, n + k)."""
        n = self.system.n
        value, table = self.system.linearised(y[..., :n], self.given(y[..., n:]))
        return value, self._along(table, y[..., n:])

    def jacobian(self, y: FloatArray) -> FloatArray:
        """Return the derivatives of the equations (..., m, n + k) at y (..., n + k)."""
        n = self.system.n
        return self._along(self.system.jacobians(y[..., :n], self.given(y[..., n:])), y[..., n:])

    def second(self, y: FloatArray) -> FloatArray:
        """Return the second derivatives of the equations (..., n + k, m, n + k) at y (..., n + k), linear in q."""
        n, k = self.system.n, self.count
        full = np.zeros((n + k, n + len(self.along)))
        full[:n, :n], full[n:, n:] = np.eye(n), self.along.T
        x, u = y[..., None, :n], self.given(y[..., None, n:])
        return np.asarray(self.system.jacobian_along(x, u, full) @ full.T)

    def directions(self, y: FloatArray) -> FloatArray:
        """Return orthonormal directions of motion (..., k, n + k) at y (..., n + k)."""
        return np.asarray(np.linalg.svd(self.jacobian(y), full_matrices=True)[2][..., self.system.n :, :])

    def bends(self, y: FloatArray, directions: FloatArray) -> FloatArray:
        """Return the second derivatives (..., j, j, n + k) at y (..., n + k) along directions (..., j, n + k).

        The inputs are linear in q. The result is perpendicular to all directions of motion; in a singular position it
        is that of least norm.
        """
        n, inverse = self.system.n, np.linalg.pinv(self.jacobian(y), rcond=LOST)[..., None, None, :, :]
        x, u = y[..., None, :n], self.given(y[..., None, n:])
        full = np.concatenate([directions[..., :n], directions[..., n:] @ self.along.T], axis=-1)
        right = np.einsum("...imc,...jc->...ijm", self.system.jacobian_along(x, u, full), full)
        return np.asarray(-(inverse @ right[..., None])[..., 0])

    def settled(self, y: FloatArray) -> FloatArray | None:
        """Return the solution nearest to y (n + k,); None without convergence."""
        return correct(self, y, SETTLING, freedoms=self.count)

    def _along(self, table: FloatArray, q: FloatArray) -> FloatArray:
        """Return derivatives (..., m, n + k) of those (..., m, n + actuators) by coordinates and inputs."""
        n = self.system.n
        return np.concatenate([table[..., :n], table[..., n:] @ self.rates(q)], axis=-1)

    def _completed(self, inputs: FloatArray, y: FloatArray) -> FloatArray:
        """Return inputs (..., actuators), or rates, with those that follow the linkage from y (..., n + k)."""
        if self.system.followers:
            inputs[..., self.system.followers] = self.system.following(y[..., : self.system.n])
        return inputs
