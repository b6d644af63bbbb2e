"""Natural coordinates: x and y of the points at which members are joined, and no angles.

A member gives the distance of its two points that are farthest apart, and two linear equations for each further
point. Source: Garcia de Jalon & Bayo, Kinematic and Dynamic Simulation of Multibody Systems, 1994,
chapter 2.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from gimcli.comparison.bodies import Stop
from gimcli.kernels import coordinates as kernels
from gimcli.kernels.points import DISTANCE, LINE, RIGID
from gimcli.mechanism import FRAME, HEIGHT, SPAN, ComplexArray, FloatArray, Mechanism, PairRow
from gimcli.positions.newton import Run
from gimcli.structure.kinematic_nodes import free_nodes, kinematic_nodes
from gimcli.structure.steps import NONE

Row = tuple[tuple[int, ...], tuple[float, ...]]
"""The integers and floats of an equation in the kernel."""


class NaturalCoordinates:
    """A mechanism in natural coordinates: two unknowns per moving point."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.points = kinematic_nodes(mechanism)
        self.free = list(free_nodes(mechanism))
        self.base = [self._base(k) for k in range(len(mechanism.members))]
        rows = [
            *self._members(),
            *(self._row(row, NONE) for row in mechanism.pairs),
            *(self._row(actuator, k) for k, actuator in enumerate(mechanism.actuators)),
        ]
        self.heads = np.array([head for head, _ in rows], dtype=np.int64).reshape(-1, 8)
        self.factors = np.array([factor for _, factor in rows], dtype=float).reshape(-1, 3)
        self.columns = np.full(len(mechanism.nodes), NONE, dtype=np.int64)
        self.columns[self.free] = 2 * np.arange(len(self.free))
        self.unknowns = 2 * len(self.free)
        self.equations = int(sum(2 if head[0] == RIGID else 1 for head in self.heads))

    def start(self, z: ComplexArray) -> FloatArray:
        """Return the unknowns at a position z (nodes,)."""
        return np.stack([z[self.free].real, z[self.free].imag], axis=1).ravel()

    def follow(
        self, inputs: FloatArray, start: ComplexArray, stop: Stop, run: Run
    ) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """Solve inputs (actuators, rows) from a position (nodes,); return z, iterations and 1 for converged rows."""
        rows = inputs.shape[1]
        x, y = (np.tile(part, (rows, 1)) for part in (start.real, start.imag))
        iterations, good = np.zeros(rows), np.zeros(rows)
        weights = np.full(self.unknowns, 1.0 / stop.length)
        values = np.ascontiguousarray(inputs.T)
        run(kernels.follow_points)(
            self.start(start), values, np.cos(values), np.sin(values), self.heads, self.factors, self.columns,
            kernels.room(self.equations, self.unknowns), weights, stop.tolerance, stop.iterations, x, y, iterations,
            good,
        )  # fmt: skip
        return self._carried((x + 1j * y).T), iterations, good

    def _carried(self, z: ComplexArray) -> ComplexArray:
        """Compute the nodes that are in no equation: they are linear in the points of their member."""
        for member, nodes, (u, v) in zip(self.mechanism.members[1:], self.points[1:], self.base[1:], strict=True):
            for node in set(member.nodes) - set(nodes):
                z[node] = z[u] + (member.reach(u, node) / member.reach(u, v)) * (z[v] - z[u])
        return z

    def _base(self, index: int) -> tuple[int, int]:
        """Return the two points of a member that are farthest apart; (NONE, NONE) if it has fewer than two."""
        member = self.mechanism.members[index]
        pairs = combinations(self.points[index], 2)
        return max(pairs, key=lambda p: abs(member.reach(*p)), default=(NONE, NONE))

    def _members(self) -> list[Row]:
        rows: list[Row] = []
        for index, member in enumerate(self.mechanism.members[1:], start=1):
            u, v = self.base[index]
            reach = member.reach(u, v)
            rows.append(((DISTANCE, v, u, NONE, NONE, NONE, NONE, 1), (0.0, 0.0, abs(reach))))
            for node in set(self.points[index]) - {u, v}:
                w = member.reach(u, node) / reach
                rows.append(((RIGID, node, u, u, v, NONE, NONE, 1), (w.real, w.imag, 0.0)))
        return rows

    def _row(self, row: PairRow, actuator: int) -> Row:
        """Return the equation of a row of a pair, or of an actuator given by its number."""
        if row.kind == SPAN:
            p, q = row.nodes
            return (DISTANCE, q, p, NONE, NONE, actuator, NONE, 1), (0.0, 0.0, 0.0)
        return self._line(row, actuator) if row.kind == HEIGHT else self._angle(row, actuator)

    def _line(self, row: PairRow, actuator: int) -> Row:
        """Return normal . (node - point) = value, with the line in the frame of a member."""
        member = self.mechanism.members[row.guide]
        if row.guide == FRAME:
            u, v, anchor, w = NONE, NONE, member.nodes[0], row.normal
        else:
            u, v = self.base[row.guide]
            anchor, w = u, row.normal / member.reach(u, v)
        height = row.height(member.local(anchor))
        return (LINE, row.node, anchor, u, v, actuator, NONE, 1), (w.real, w.imag, height)

    def _angle(self, row: PairRow, actuator: int) -> Row:
        """Return the equation: the component of the arm normal to the driven ray is zero."""
        arm, reference = (self.mechanism.members[k] for k in row.members)
        p, q = self.base[row.members[0]]
        across = 1j * row.reference / row.arm * arm.reach(p, q)
        across /= abs(across)
        u, v = (NONE, NONE) if row.guide == FRAME else self.base[row.guide]
        if u != NONE:
            across /= reference.reach(u, v)
        return (LINE, q, p, u, v, NONE, actuator, 1), (across.real, across.imag, 0.0)
