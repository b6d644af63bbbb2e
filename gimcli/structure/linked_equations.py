"""The equations of a mechanism with gears that its linkage turns: of positions x and of the inputs w that follow.

An input that follows quantities of the linkage is an unknown besides the coordinates of the nodes. Its equation is
w = phase + sum of ratio times input + sum of ratio times quantity; angles are counted over all turns, from references
near them. The equations of the other constraints are those of `System`, with w among the inputs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gimcli.calculus.numbers import phase
from gimcli.calculus.series import Series
from gimcli.mechanism import ANGLE, ComplexArray, FloatArray, Mechanism, PairRow
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
        return LinkedPoint(y, np.array([float(value) for value in self._readings(list(z), drawn)]))

    def point(self, z: ComplexArray, inputs: FloatArray) -> LinkedPoint:
        """Return a position (nodes,) with inputs (actuators,) as one row; full turns of what is read do not matter."""
        read = self._readings(list(z), np.zeros(len(self.reads)))
        y = np.append(self.system.coordinates(z), inputs[self.followers])
        return LinkedPoint(y[:, None], np.array(read, dtype=float)[:, None])

    def newton(self, at: LinkedPoint, u: FloatArray) -> tuple[FloatArray, LinkedPoint]:
        """Return the residuals of one position (equations,) and the position after one Newton step (least squares)."""
        inputs, z = self.inputs(u, at.y), self.nodes(at.y)
        read = np.array([float(value) for value in self._readings(list(z), at.read)])
        residual = np.append(self.system.residual(at.y[: self.n], inputs), self._coupling(at.y, u, read))
        step = np.linalg.lstsq(self._jacobian(at, inputs, z), -residual, rcond=None)[0]
        return residual, LinkedPoint(at.y + step, read)

    def _jacobian(self, at: LinkedPoint, inputs: FloatArray, z: ComplexArray) -> FloatArray:
        system, count = self.system, len(self.linked)
        table = np.zeros((system.m + count, self.n + count))
        table[: system.m, : self.n] = system.jacobian(at.y[: self.n], inputs)
        for k, follower in enumerate(self.followers):
            table[: system.m, self.n + k] = system.along_inputs(at.y[: self.n], inputs, _unit(len(inputs), follower))
        for k, row, ratio in self.reads:
            table[system.m + k, : self.n] -= ratio * self._gradient(row, z)
        table[system.m :, self.n :] += np.eye(count)
        return table

    def _gradient(self, row: PairRow, z: ComplexArray) -> FloatArray:
        """Return the derivatives (n,) of a quantity that is read."""
        found = np.zeros(self.n)
        for k in range(self.n):
            rates = self.system.placed(np.zeros(len(z), dtype=complex), _unit(self.n, k))
            found[k] = self._quantity(row, [Series(np.array(one)) for one in zip(z, rates, strict=True)], None).c[1]
        return found

    # -- many positions, and derivatives -----------------------------------------------------------

    def many(self, at: LinkedPoint, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return residuals (equations, rows), Jacobians (rows, equations, unknowns) and readings (reads, rows)."""
        orders, rows = 2, at.y.shape[1]
        y, inputs = np.zeros((orders, *at.y.shape)), np.zeros((orders, *u.shape))
        y[0], inputs[0] = at.y, u
        value, read = self._series(y, inputs, at.read)
        columns = []
        for k in range(len(at.y)):
            y[1] = 0.0
            y[1, k] = 1.0
            columns.append(self._series(y, inputs, at.read)[0][1])
        slopes = np.array(columns).reshape(len(at.y), len(value[0]), rows)
        return value[0], np.moveaxis(slopes, (0, 1, 2), (2, 1, 0)), read

    def derivatives(self, at: LinkedPoint, rates: FloatArray) -> FloatArray:
        """Return the derivatives of y (orders, unknowns, rows) by a parameter.

        rates: the inputs of the drivers and their derivatives (orders, actuators, rows); the values come first.
        """
        factor = np.array([1.0, 1.0, 2.0, 6.0][: len(rates)])[:, None, None]
        u, y = rates / factor, np.zeros((len(rates), *at.y.shape))
        y[0] = at.y
        _, jacobian, _ = self.many(at, u[0])
        inverse = np.linalg.pinv(jacobian)
        for k in range(1, len(rates)):
            right, _ = self._series(y[: k + 1], u[: k + 1], at.read)
            y[k] = -np.einsum("rij,jr->ir", inverse, right[k])
        return np.asarray(y * factor)

    def _series(self, y: FloatArray, u: FloatArray, near: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the residuals (orders, equations, rows) of series y and u, and the readings (reads, rows)."""
        z0 = np.repeat(self.nodes(y[0])[None], len(y), axis=0)
        z0[1:] = 0.0
        z0[1:] = [self.system.placed(order, x) for order, x in zip(z0[1:], y[1:, : self.n], strict=True)]
        z = [Series(z0[:, k]) for k in range(z0.shape[1])]
        inputs = np.array([self.mechanism.coupled(u[0]) - 0.0, *(self.linear(part) for part in u[1:])])
        inputs[:, self.followers] = y[:, self.n :]
        values = [Series(inputs[:, k]) for k in range(inputs.shape[1])]
        turns = [np.exp(1j * value) for value in values]
        rows = []
        for part, value in self.constraints.equations(z, values, turns):
            rows += [value.c.real] * (part != "imag") + [value.c.imag] * (part != "real")
        read = [self._quantity(row, z, near[k]).c for k, (_, row, _) in enumerate(self.reads)]
        for k, coupling in enumerate(self.linked):
            total = y[:, self.n + k].copy()
            total[0] -= coupling.phase
            for actuator, ratio in coupling.terms:
                total -= ratio * u[:, actuator]
            for own, (number, _, ratio) in zip(read, self.reads, strict=True):
                total -= ratio * own * (number == k)
            rows.append(total)
        return np.moveaxis(np.array(rows), 0, 1), np.array([own[0] for own in read])

    def linear(self, rates: FloatArray) -> FloatArray:
        """Return the derivatives of all inputs that follow linearly."""
        found = rates.copy()
        for coupling in self.mechanism.couplings:
            found[coupling.follower] = sum((ratio * rates[k] for k, ratio in coupling.terms), 0.0 * rates[0])
        return found

    # -- readings --------------------------------------------------------------------------------

    def _readings(self, z: list[complex], near: FloatArray) -> list[float]:
        """Return the quantities that are read at one position; angles are those nearest to the references."""
        moving = [Series(np.array([value])) for value in z]
        return [self._quantity(row, moving, near[k]).c[0] for k, (_, row, _) in enumerate(self.reads)]

    def _quantity(self, row: PairRow, z: list[Series], near: FloatArray | float | None) -> Series:
        """Return a quantity; an angle is that nearest to a reference, or in -pi..pi."""
        _, value = self.constraints.quantity(row, z, complex, 0.0, 1.0)
        if row.kind != ANGLE:
            return Series(value.real.c)  # a FRAME guide gives plain numbers, too
        base = 0.0 if near is None else near
        found: Series = phase(value * np.exp(-1j * np.asarray(base))) + base
        return found

    def _coupling(self, y: FloatArray, u: FloatArray, read: FloatArray) -> FloatArray:
        """Return the residuals (followers,) of the inputs that follow, at one position."""
        found = y[self.n :].copy()
        for k, coupling in enumerate(self.linked):
            found[k] -= coupling.phase + sum(ratio * u[actuator] for actuator, ratio in coupling.terms)
        for own, (k, _, ratio) in zip(read, self.reads, strict=True):
            found[k] -= ratio * own
        return found


def _unit(size: int, k: int) -> FloatArray:
    found = np.zeros(size)
    found[k] = 1.0
    return found


@derived
def linked_equations(mechanism: Mechanism) -> LinkedEquations:
    """Return the equations of a mechanism whose linkage turns gears."""
    return LinkedEquations(mechanism)
