"""The equations of members, pairs and inputs in double or high precision, written without the terms of the analyses.

The same code serves complex doubles and numbers of mpmath. Because the equations are of second degree, central
differences of any width give their exact Jacobian.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, HEIGHT, SPAN, ComplexArray, FloatArray, Mechanism, PairRow
from gimcli.structure.kinematic_nodes import moving_nodes

Numbers = Any
"""An array (rows,) of complex numbers of any precision."""


class Constraints:
    """The equations of a mechanism in the coordinates of its moving nodes."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.free = list(moving_nodes(mechanism))

    def equations(
        self, z: Numbers, inputs: Numbers, turns: Numbers, exact: Any = complex
    ) -> Iterator[tuple[str, Numbers]]:
        """Yield each equation (rows,), after the part of it that must be zero: "real", "imag" or "both".

        z: positions (nodes, rows). inputs: (actuators, rows). turns: exp(i inputs). exact: converts a double to the
        precision of z.
        """
        for member in self.mechanism.members[FRAME + 1 :]:
            (u, v, _), first, far = member.ends, exact(member.shape[0]), exact(member.shape[member.base])
            arm, reach = z[v] - z[u], far - first
            yield "real", (arm * arm.conjugate() - reach * reach.conjugate()) / member.stretch**2
            for k, node in enumerate(member.nodes):
                if node not in (u, v) and node not in member.carried:
                    yield "both", z[node] - z[u] - (exact(member.shape[k]) - first) / reach * arm
        for row in self.mechanism.pairs:
            yield self.quantity(row, z, exact, 0.0, 1.0)
        for row, value, turn in zip(self.mechanism.actuators, inputs, turns, strict=True):
            yield self.quantity(row, z, exact, value, turn)

    def quantity(self, row: PairRow, z: Numbers, exact: Any, value: Numbers, turn: Numbers) -> tuple[str, Numbers]:
        """Return the equation of a pair or an actuator: its quantity minus the value."""
        if row.kind == SPAN:
            first, second = row.nodes
            arm = z[second] - z[first]
            return "real", arm * arm.conjugate() - value * value
        if row.kind == HEIGHT:
            place = self._in_guide(row.node, row.guide, row.point, z, exact)
            return "real", place * exact(row.normal).conjugate() - value
        arm, reference = (self._rotation(k, z, exact) for k in row.members)
        arm, reference = arm * exact(row.arm), reference * exact(row.reference)
        return "imag", arm * (reference * turn).conjugate()

    def residual(self, z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return the residuals of the equations (equations, rows) in double precision."""
        rows = []
        for part, value in self.equations(z, inputs + 0.0j, np.exp(1j * inputs)):
            rows += [value.real] * (part != "imag") + [value.imag] * (part != "real")
        return np.array(rows).reshape(len(rows), z.shape[1])

    def jacobian(self, z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return their derivatives (rows, equations, 2 x moving nodes), x and y of a node side by side."""
        columns = []
        for node in self.free:
            for step in (1.0, 1.0j):  # any width: the third derivatives are zero
                ahead, behind = z.copy(), z.copy()
                ahead[node] += step
                behind[node] -= step
                columns.append(0.5 * (self.residual(ahead, inputs) - self.residual(behind, inputs)))
        return np.moveaxis(np.array(columns), (0, 1, 2), (2, 1, 0))

    def _rotation(self, index: int, z: Numbers, exact: Any) -> Numbers:
        """Return e^(i phi) of a member as a linear function of two of its nodes."""
        member = self.mechanism.members[index]
        if index == FRAME:
            return exact(1.0)
        u, v, _ = member.ends
        return (z[v] - z[u]) / (exact(member.shape[member.base]) - exact(member.shape[0]))

    def _in_guide(self, node: int, index: int, point: complex, z: Numbers, exact: Any) -> Numbers:
        """Return the position of a node relative to a point of a member, in the member's own frame."""
        member = self.mechanism.members[index]
        if index == FRAME:
            return z[node] - exact(point)
        rotation = self._rotation(index, z, exact)
        origin = z[member.nodes[0]] - rotation * exact(member.shape[0])
        return (z[node] - origin - rotation * exact(point)) * rotation.conjugate()
