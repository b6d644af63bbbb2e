"""The equations of a mechanism with gears that its linkage turns: of positions x and of the inputs w that follow.

An input that follows quantities of the linkage is an unknown besides the coordinates of the nodes. Its equation is
w = phase + sum of ratio times input + sum of ratio times quantity; angles are counted over all turns, from references
near them. The equations of the other constraints are those of `System`, with w among the inputs.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import phase
from gimcli.calculus.series import Series
from gimcli.mechanism import ANGLE, ComplexArray, FloatArray, Mechanism
from gimcli.structure.carried import height, turned
from gimcli.structure.derived import derived
from gimcli.structure.exact_equations import Constraints
from gimcli.structure.system import system_of


class LinkedPoint(NamedTuple):
    """A position and the inputs that follow."""

    y: FloatArray  # (n + followers, ...) coordinates of the moving nodes, then the inputs
    read: FloatArray  # (reads, ...) quantities that are read; angles with all their turns


class LinkedEquations:
    """The equations F(x, u, w) = 0 and w - phase - ... = 0 of a mechanism."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.system = mechanism, system_of(mechanism)
        self.constraints = Constraints(mechanism)
        self.linked = tuple(c for c in mechanism.couplings if c.reads)
        self.followers = [coupling.follower for coupling in self.linked]
        self.reads = [(k, row, ratio) for k, c in enumerate(self.linked) for row, ratio in c.reads]
        self.n = self.system.n

    def inputs(self, u: FloatArray, y: FloatArray) -> FloatArray:
        """Return all inputs (actuators, ...) of drivers' inputs u (actuators, ...) and unknowns y."""
        found = self.mechanism.coupled(u)
        found[self.followers] = y[self.n :]
        return found

    def nodes(self, y: FloatArray) -> ComplexArray:
        """Return the positions (nodes, ...) of unknowns y."""
        return self.system.nodes(y[: self.n])

    def first(self, u: FloatArray) -> LinkedPoint:
        """Return the drawn position, with drivers' inputs u (actuators,)."""
        z = self.mechanism.drawn
        y = np.append(self.system.coordinates(z), self.mechanism.drawn_inputs[self.followers])
        drawn = np.array([row.drawn for _, row, _ in self.reads])
        return LinkedPoint(y, np.array(self._readings(z, drawn)))

    def point(self, z: ComplexArray, inputs: FloatArray) -> LinkedPoint:
        """Return a position (nodes,) with inputs (actuators,) as one row; full turns of what is read do not matter."""
        read = self._readings(z, np.zeros(len(self.reads)))
        y = np.append(self.system.coordinates(z), inputs[self.followers])
        return LinkedPoint(y[:, None], np.array(read, dtype=float)[:, None])

    def newton(self, at: LinkedPoint, u: FloatArray) -> tuple[FloatArray, LinkedPoint]:
        """Return the residuals (equations, rows), and the positions after one Newton step (least squares)."""
        residual, jacobian, read = self.many(at, u)
        step = np.einsum("rij,jr->ir", np.linalg.pinv(jacobian), residual)
        return residual, LinkedPoint(at.y - step.reshape(at.y.shape), read.reshape(at.read.shape))

    def many(self, at: LinkedPoint, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return residuals (equations, rows), Jacobians (rows, equations, unknowns) and readings (reads, rows).

        A position without rows has one row.
        """
        unknowns, near = (part.reshape(len(part), -1) for part in at)
        tangents = np.eye(len(unknowns))[:, :, None] + np.zeros_like(unknowns)
        inputs = np.zeros((len(u), len(tangents) + 1, unknowns.shape[1]))
        inputs[:, 0] = u.reshape(len(u), -1)
        rows, read = self._evaluated(
            np.concatenate([unknowns[:, None], tangents], axis=1), inputs, near, lambda parts: Dual(parts[0], parts[1:])
        )  # fmt: skip
        slopes = np.array([row.slopes for row in rows])  # (equations, unknowns, rows)
        return np.array([row.value for row in rows]), np.moveaxis(slopes, -1, 0), np.array([own.value for own in read])

    def derivatives(self, at: LinkedPoint, rates: FloatArray) -> FloatArray:
        """Return the derivatives of y (orders, unknowns, rows) by a parameter.

        rates: the inputs of the drivers and their derivatives (orders, actuators, rows); the values come first.
        """
        factor = np.array([1.0, 1.0, 2.0, 6.0][: len(rates)])[:, None, None]
        u, y = (np.moveaxis(table, 0, 1) for table in (rates / factor, np.zeros((len(rates), *at.y.shape))))
        y[:, 0] = at.y
        _, jacobian, _ = self.many(at, u[:, 0])
        inverse = np.linalg.pinv(jacobian)
        for k in range(1, len(rates)):
            right, _ = self._evaluated(y[:, : k + 1], u[:, : k + 1], at.read, Series)
            y[:, k] = -np.einsum("rij,jr->ir", inverse, np.array([row.c[k] for row in right]))
        return np.asarray(np.moveaxis(y, 1, 0) * factor)

    def _evaluated(
        self, y: FloatArray, u: FloatArray, near: FloatArray, number: Callable[[Any], Any]
    ) -> tuple[list[Any], list[Any]]:
        """Return residuals and readings as numbers with derivatives.

        The unknowns y (unknowns, parts, rows) and the drivers' inputs u (actuators, parts, rows) are their values and
        their derivatives or coefficients, of which `number` makes a number.
        """
        start = self.nodes(y[:, 0])[:, None]
        nodes = self.system.placed(np.repeat(0.0 * start, y.shape[1] - 1, axis=1), y[: self.n, 1:])
        inputs = np.concatenate([self.mechanism.coupled(u[:, 0])[:, None], self.linear(u[:, 1:])], axis=1)
        inputs[self.followers] = y[self.n :]
        z, values, given = ([*map(number, own)] for own in (np.concatenate([start, nodes], axis=1), inputs, u))
        rows: list[Any] = []
        for part, value in self.constraints.equations(z, values, [np.exp(1j * value) for value in values]):
            rows += [value.real] * (part != "imag") + [value.imag] * (part != "real")
        read = self._readings(z, near)
        for k, coupling in enumerate(self.linked):
            total = values[coupling.follower] - coupling.phase
            total = reduce(operator.sub, (ratio * given[actuator] for actuator, ratio in coupling.terms), total)
            own = (ratio * value for value, (owner, _, ratio) in zip(read, self.reads, strict=True) if owner == k)
            rows.append(reduce(operator.sub, own, total))
        return rows, read

    def linear(self, rates: FloatArray) -> FloatArray:
        """Return the derivatives of all inputs that follow linearly."""
        found = rates.copy()
        for coupling in self.mechanism.couplings:
            found[coupling.follower] = sum((ratio * rates[k] for k, ratio in coupling.terms), 0.0 * rates[0])
        return found

    def _readings(self, z: Any, near: FloatArray) -> list[Any]:
        """Return the quantities that are read, as the positions z of the nodes; angles are those nearest to `near`."""
        return [
            phase(turned(self.mechanism, row, z) * np.exp(-1j * base)) + base
            if row.kind == ANGLE
            else height(self.mechanism, row, z)
            for base, (_, row, _) in zip(near, self.reads, strict=True)
        ]


@derived
def linked_equations(mechanism: Mechanism) -> LinkedEquations:
    """Return the equations of a mechanism whose linkage turns gears."""
    return LinkedEquations(mechanism)
