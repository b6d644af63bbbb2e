"""Derivatives of solved positions: one call for many rows, with little overhead for a single row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.kernels import tape as kernels
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism, Point
from gimcli.positions.newton import Run
from gimcli.rates.plan_rates import Differentiated
from gimcli.rates.slots import POSITION, Slot
from gimcli.structure.steps import Plan

PLAIN = 3e-8
"""Approximate time of one operation per row without compilation [s]."""


class Differentiator:
    """A differentiated plan: given slots of given points, and of all members except the frame.

    Points are nodes or points by name, or points of members without a name. Slot 0, the position, is included if
    `position` is true.
    """

    def __init__(
        self, mechanism: Mechanism, plan: Plan, slots: Sequence[Slot], points: Sequence[str | Point],
        position: bool = True,
    ) -> None:  # fmt: skip
        skipped = 0 if position else 1
        found = Differentiated(mechanism, plan, [POSITION, *slots])
        for number, point in enumerate(points):
            found.write_point(number, point, skipped)
        for number, member in enumerate(mechanism.members[FRAME + 1 :]):
            found.write_angle(number, member)
        self.tape = found.tape
        self.w, self.heads, self.factors = found.tape.arrays()
        self.points = len(slots) + 1 - skipped, len(points)
        self.angles = len(slots), len(mechanism.members) - 1
        groups = [(sum(e.rows for e in g.equations), 2 * len(g.base)) for g in plan.coupled]
        self.operations = len(self.heads) + sum(m * n * (n + len(slots)) for m, n in groups)

    def plain_seconds(self, rows: int) -> float:
        """Return the estimated time of a number of rows without compilation [s]."""
        return rows * PLAIN * self.operations

    def __call__(self, z: ComplexArray, given: FloatArray, run: Run) -> tuple[ComplexArray, FloatArray]:
        """Return points (slots, points, rows) and angles of members (slots - 1, members, rows).

        z (nodes, rows), given (., actuators, rows). Rows without a position or with singular gradients are NaN.
        """
        rows = z.shape[1]
        points, angles = np.empty((*self.points, rows), dtype=complex), np.empty((*self.angles, rows))
        z, given = np.ascontiguousarray(z), np.ascontiguousarray(given)
        with np.errstate(all="ignore"):
            run(kernels.play)(self.w, self.heads, self.factors, parts(z), given, parts(points), angles)
        return points, angles


def parts(z: ComplexArray) -> FloatArray:
    """Return a view with real and imaginary parts as the last axis."""
    return z.view(float).reshape(*z.shape, 2)
