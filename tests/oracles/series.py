"""Independent derivatives: Taylor series of the plan with numpy, gradients by unit speeds, singular values.

The steps of the plan are differentiated in order: the k-th derivative of their equations is linear in the k-th
derivatives of the unknowns, with the gradients of the position. With these derivatives set to 0, the k-th coefficient
of the series of the equations is the right-hand side:

    Phi_q q^(k) = -Phi^(k) | q^(k) = 0

Source: Fraczek & Wojtyra, Kinematics of multibody systems, 2008, eqs 1.12-1.16. No differences are used.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from jets import Jet, constant, derivatives, dot, quotient, slope, times, turn

from gimcli import Mechanism
from gimcli.mechanism import FRAME, HEIGHT, SPAN, ComplexArray, FloatArray
from gimcli.structure.plan import make_plan
from gimcli.structure.steps import (
    NONE,
    Constraint,
    Coupled,
    Dyad,
    Orient,
    Place,
    Plan,
    Tilt,
    Value,
    Vector,
)

Equations = Callable[[], list[FloatArray]]
"""Values of some equations as series (order + 1, rows)."""


SINGULAR = 1e-8
"""With a smaller ratio of the smallest to the largest singular value, the equations determine no velocity."""


@dataclass(frozen=True)
class Rates:
    """Derivatives with respect to the real time [s] in the normal frame; NaN in rows not solved or singular."""

    mechanism: Mechanism = field(repr=False)
    order: int
    nodes: ComplexArray = field(repr=False)  # (order + 1, nodes, rows): position, velocity, acceleration ...

    def point(self, name: str) -> ComplexArray:
        """Return position, velocity ... of a node or point (order + 1, rows)."""
        mechanism = self.mechanism
        if name in mechanism.nodes:
            return np.asarray(self.nodes[:, mechanism.nodes.index(name)])
        point = next(p for p in mechanism.points if p.name == name)
        if point.member == FRAME:
            return constant(point.local, self.order, self.nodes.shape[2])
        member = mechanism.members[point.member]
        far, first = member.base, member.shape[0]
        z, other = self.nodes[:, member.nodes[0]], self.nodes[:, member.nodes[far]]
        return np.asarray(z + (other - z) * ((point.local - first) / (member.shape[far] - first)))

    def angular(self, index: int) -> FloatArray:
        """Return omega, alpha ... of a member (order, rows) [rad/s, rad/s^2 ...]."""
        member = self.mechanism.members[index]
        if index == FRAME:
            return np.zeros((self.order, self.nodes.shape[2]))
        arm = self.nodes[:, member.nodes[member.base]] - self.nodes[:, member.nodes[0]]
        series = arm / derivatives(np.ones_like(arm))
        rate = quotient(slope(series), series[:-1])  # w' / w = i omega for a rigid member
        return np.asarray(derivatives(rate).imag)


def rates(mechanism: Mechanism, time: FloatArray, z: ComplexArray, order: int, plan: Plan | None = None) -> Rates:
    """Differentiate positions z (nodes, rows) at normalised times (rows,) up to an order."""
    plan = plan or make_plan(mechanism)
    with np.errstate(all="ignore"):
        series = _Series(mechanism, time, z, order)
        for step in plan.steps:
            series.take(step)
        nodes = np.stack([derivatives(series.nodes[n]) for n in range(len(mechanism.nodes))], axis=1)
    nodes[:, :, ~np.all(np.isfinite(nodes), axis=(0, 1))] = complex(np.nan, np.nan)
    return Rates(mechanism, order, nodes)


class _Series:
    """The known quantities as series: nodes, directions in registers, inputs."""

    def __init__(self, mechanism: Mechanism, time: FloatArray, z: ComplexArray, order: int) -> None:
        self.order, self.rows, self.z = order, len(time), z
        self.nodes = {n: constant(0.0, order, self.rows) for n in range(len(mechanism.nodes))}
        for n, jet in self.nodes.items():
            jet[0] = z[n]
        self.registers: dict[int, Jet] = {}
        self.inputs = [
            np.stack([a.law(time, k) / (mechanism.duration**k * _factorial(k)) for k in range(order + 1)])
            for a in mechanism.actuators
        ]
        self.turns = [turn(value) for value in self.inputs]

    def take(self, step: object) -> None:
        """Differentiate the unknowns of a step."""
        if isinstance(step, Place):
            self.nodes[step.node] = self.nodes[step.anchor] + self.vector(step.vector)
        elif isinstance(step, Orient):
            self.registers[step.register] = self.vector(step.vector)
        elif isinstance(step, Tilt):
            self._tilt(step)
        elif isinstance(step, Dyad):
            self._solve([self.nodes[step.node]], lambda: [*self.equation(step.first), *self.equation(step.second)])
        else:
            assert isinstance(step, Coupled)
            self._couple(step)

    def vector(self, vector: Vector) -> Jet:
        """Return the series of a vector."""
        if vector.u != NONE:
            base = self.nodes[vector.v] - self.nodes[vector.u]
        elif vector.register != NONE:
            base = self.registers[vector.register]
        else:
            base = constant(1.0, self.order, self.rows)
        if vector.actuator != NONE:
            e = self.turns[vector.actuator]
            base = times(base, e if vector.turn > 0 else np.conj(e))
        return np.asarray(vector.z * base)

    def value(self, value: Value) -> Jet:
        """Return a length that may follow an input."""
        result = constant(value.constant, self.order, self.rows)
        return result if value.actuator == NONE else result + value.gain * self.inputs[value.actuator]

    def equation(self, equation: Constraint) -> list[FloatArray]:
        """Return the series of one equation of a dyad or of a coupled group."""
        away = self.nodes[equation.p] - self.nodes[equation.q]
        if equation.offset is not None:
            away = away - self.vector(equation.offset)
        value = self.value(equation.value)
        if equation.kind == SPAN:
            return [dot(away, away) - times(value, value).real]
        assert equation.vector is not None
        vector = self.vector(equation.vector)
        if equation.kind == HEIGHT:
            return [dot(vector, away) - value.real]
        return [(away - vector).real, (away - vector).imag]

    def _tilt(self, step: Tilt) -> None:
        """Differentiate the direction u of B - A = u (tau + i e): |u| = 1, u x (B - A) = e."""
        along = self.vector(step.along)[0]
        u = constant(0.0, self.order, self.rows)
        u[0] = along / np.abs(along)
        self.registers[step.register] = u
        e = constant(step.distance, self.order, self.rows).real

        def equations() -> list[FloatArray]:
            arm = self.nodes[step.b] - self.nodes[step.a]
            return [dot(u, u), dot(1j * u, arm) - e]

        self._solve([u], equations)

    def _couple(self, group: Coupled) -> None:
        def equations() -> list[FloatArray]:
            for place in group.places:
                self.nodes[place.node] = self.nodes[place.anchor] + self.vector(place.vector)
            return [f for equation in group.equations for f in self.equation(equation)]

        self._solve([self.nodes[n] for n in group.base], equations)
        equations()

    def _solve(self, unknowns: Sequence[Jet], equations: Equations) -> None:
        """Find the derivatives of unknowns order by order."""
        if self.order == 0:
            return
        table = self._gradients(unknowns, equations)
        for k in range(1, self.order + 1):
            right = np.stack([-f[k] for f in equations()], axis=1)  # (rows, equations)
            found = _solved(table, right)
            for n, jet in enumerate(unknowns):
                jet[k] = found[:, 2 * n] + 1j * found[:, 2 * n + 1]

    def _gradients(self, unknowns: Sequence[Jet], equations: Equations) -> FloatArray:
        """Return the gradients (rows, equations, coordinates): first coefficients with one coordinate at unit speed.

        The known quantities contribute the same to all of them, which is subtracted.
        """
        rest = np.stack([f[1] for f in equations()], axis=1)
        columns = []
        for jet in unknowns:
            for unit in (1.0, 1j):
                jet[1] = unit
                columns.append(np.stack([f[1] for f in equations()], axis=1) - rest)
                jet[1] = 0.0
        return np.stack(columns, axis=2)


def _solved(table: FloatArray, right: FloatArray) -> FloatArray:
    """Solve the equations of each row, by least squares if some are redundant; NaN where they are singular."""
    scale = np.linalg.norm(table, axis=2)
    table, right = table / scale[:, :, None], right / scale
    good = np.all(np.isfinite(table), axis=(1, 2)) & np.all(np.isfinite(right), axis=1)
    left, values, across = np.linalg.svd(np.where(good[:, None, None], table, 0.0), full_matrices=False)
    good &= values[:, -1] > SINGULAR * values[:, 0]
    values[~good] = np.nan
    turned = np.einsum("rmk,rm->rk", left, right) / values
    return np.asarray(np.einsum("rkn,rk->rn", across, turned))


def _factorial(k: int) -> int:
    return (1, 1, 2, 6, 24)[k]
