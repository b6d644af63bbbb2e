"""The positions that a mechanism can take if some of its inputs are released, as solutions of F(x, u(q)) = 0.

The unknowns y = (x, q) are the coordinates of the moving nodes and the k released inputs. The directions of motion are
the null space of the Jacobian, so that limits and dead points of an input are ordinary positions.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.continuation.arclength import ArclengthConstants, correct
from gimcli.dynamics.equilibria_balance import PositionJet
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.system import system_of

SETTLING = ArclengthConstants(corrections=12)
"""Constants of the corrections of a position."""

LOST = 1e-10
"""Singular values below this fraction of the greatest are 0."""


def released_inputs_line(
    mechanism: Mechanism, released: Sequence[int], inputs: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return base (actuators,) and along (actuators, k) of u = base + along q through some inputs (actuators,).

    released: numbers of k actuators that follow no others; those that follow them move too, the others are held.
    """
    along = mechanism.following[:, [mechanism.drivers.index(k) for k in released]]
    values = mechanism.coupled(inputs)
    return values - along @ values[list(released)], along


class Freedoms:
    """Positions of a mechanism with released inputs: u = base + along q."""

    def __init__(self, mechanism: Mechanism, base: FloatArray, along: FloatArray) -> None:
        self.mechanism, self.system = mechanism, system_of(mechanism)
        self.base, self.along = base, along  # (actuators,), (actuators, k)

    @property
    def count(self) -> int:
        """The number k of released inputs."""
        return int(self.along.shape[1])

    def point(self, z: ComplexArray, q: FloatArray) -> FloatArray:
        """Return y (n + k,) of positions z (nodes,)."""
        return np.concatenate([self.system.coordinates(z), q])

    def nodes(self, y: FloatArray) -> ComplexArray:
        """Return the positions (nodes,) of y (n + k,), or (nodes, rows) of y (n + k, rows)."""
        return self.system.nodes(y[: self.system.n])

    def inputs(self, y: FloatArray) -> FloatArray:
        """Return the inputs (actuators,) of y (n + k,), or (actuators, rows) of y (n + k, rows)."""
        free = self.along @ y[self.system.n :]
        return np.asarray(self.base.reshape(-1, *[1] * (free.ndim - 1)) + free)

    def residual(self, y: FloatArray) -> FloatArray:
        """Return the equations (..., m) at y (..., n + k)."""
        return self.system.residual(*self._parts(y))

    def jacobian(self, y: FloatArray) -> FloatArray:
        """Return the derivatives of the equations (..., m, n + k) at y (..., n + k)."""
        n, table = self.system.n, self.system.jacobians(*self._parts(y))
        return np.concatenate([table[..., :n], table[..., n:] @ self.along], axis=-1)

    def directions(self, y: FloatArray) -> FloatArray:
        """Return orthonormal directions of motion (k, n + k)."""
        return np.asarray(np.linalg.svd(self.jacobian(y), full_matrices=True)[2][self.system.n :])

    def bends(self, y: FloatArray, directions: FloatArray) -> FloatArray:
        """Return the second derivatives (..., j, j, n + k) at y (..., n + k) along directions (..., j, n + k).

        They are perpendicular to all directions of motion; in a singular position they are those of least norm.
        """
        x, u = self._parts(y[..., None, :])
        n, inverse = self.system.n, np.linalg.pinv(self.jacobian(y), rcond=LOST)[..., None, None, :, :]
        full = np.concatenate([directions[..., :n], directions[..., n:] @ self.along.T], axis=-1)
        right = np.einsum("...imc,...jc->...ijm", self.system.jacobian_along(x, u, full), full)
        return np.asarray(-(inverse @ right[..., None])[..., 0])

    def _parts(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the coordinates (..., n) and the inputs (..., actuators) of y (..., n + k)."""
        n = self.system.n
        return y[..., :n], self.base + y[..., n:] @ self.along.T

    def settled(self, y: FloatArray) -> FloatArray | None:
        """Return the solution nearest to y (n + k,); None without convergence."""
        return correct(self, y, SETTLING, freedoms=self.count)

    def jet(self, y: FloatArray, first: FloatArray, second: FloatArray) -> PositionJet:
        """Return positions y (n + k, rows) with derivatives (j, n + k, rows) and (j, j, n + k, rows)."""
        n, nodes = self.system.n, self.nodes(y)
        j, rows = first.shape[0], y.shape[1]

        def by_node(v: FloatArray) -> ComplexArray:
            lead = v.shape[:-2]
            result = np.zeros((*lead, len(self.mechanism.nodes), rows), dtype=complex)
            placed = self.system.placed(np.moveaxis(result, -2, 0), np.moveaxis(v[..., :n, :], -2, 0))
            return np.moveaxis(placed, 0, -2)

        rates = np.einsum("uk,jkr->jur", self.along, first[:, n:])
        bends = np.einsum("uk,ijkr->ijur", self.along, second[:, :, n:])
        return PositionJet(
            nodes, by_node(first), by_node(second), self.inputs(y).reshape(-1, rows),
            rates.reshape(j, -1, rows), bends.reshape(j, j, -1, rows),
        )  # fmt: skip
