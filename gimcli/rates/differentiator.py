"""Derivatives of solved positions in many rows by one call, or in one row with next to nothing around it."""

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
"""Seconds that an operation takes a row without compiling."""


class Differentiator:
    """A plan ready to be differentiated: some slots of some points and of all members but the frame.

    Points are nodes or points by name, or points of members that the model does not name. Slot 0, the position, is
    written of them where `position` asks for it.
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
        self.w, self.heads, self.factors = found.tape.arrays()
        self.points = len(slots) + 1 - skipped, len(points)
        self.angles = len(slots), len(mechanism.members) - 1
        groups = [(sum(e.rows for e in g.equations), 2 * len(g.base)) for g in plan.coupled]
        self.operations = len(self.heads) + sum(m * n * (n + len(slots)) for m, n in groups)

    def plain_seconds(self, rows: int) -> float:
        """Estimate the seconds that some rows take without compiling."""
        return rows * PLAIN * self.operations

    def __call__(self, z: ComplexArray, given: FloatArray, run: Run) -> tuple[ComplexArray, FloatArray]:
        """Return points (slots, points, rows) and members' angles (slots - 1, members, rows).

        z (nodes, rows), given (., actuators, rows). NaN where a row has no position or its gradients are singular.
        """
        rows = z.shape[1]
        points, angles = np.empty((*self.points, rows), dtype=complex), np.empty((*self.angles, rows))
        z, given = np.ascontiguousarray(z), np.ascontiguousarray(given)
        with np.errstate(all="ignore"):
            run(kernels.play)(self.w, self.heads, self.factors, parts(z), given, parts(points), angles)
        return points, angles


def parts(z: ComplexArray) -> FloatArray:
    """Return real and imaginary parts as a last axis, in the same memory."""
    return z.view(float).reshape(*z.shape, 2)
