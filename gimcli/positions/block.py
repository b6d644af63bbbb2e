"""A stretch of a motion as arrays: what the solvers read and fill, row by row.

The first `history` rows are solved already; they are what the branch is continued from.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gimcli.kernels.circular import cos_sin
from gimcli.mechanism import FloatArray
from gimcli.structure.steps import NONE, Plan, Vector


@dataclass
class RowBlock:
    """Rows of one stretch; `end` shrinks to the first row that could not be solved safely."""

    time: FloatArray  # (rows,)
    inputs: FloatArray  # (actuators, rows)
    history: int
    x: FloatArray  # (nodes, rows)
    y: FloatArray
    g: FloatArray  # (branches, rows) signed measures of the steps with two solutions
    rx: FloatArray  # (registers, rows) directions
    ry: FloatArray
    quality: FloatArray  # (branches, rows) square of the measure over its rounding: |quality| < 1 tells nothing
    error: FloatArray  # (rows,) estimated error of the nodes
    work: FloatArray  # (rows,) sweeps or iterations
    end: int
    blocked: bool = False  # the row at `end` has no solution at all
    singular: bool = False  # the row at `end` is solved, but not to the tolerance
    weak_branch: int = NONE  # the branch that ended the block
    lenient: bool = False  # go on as long as the branches can be told apart, whatever the tolerance
    cos: FloatArray = field(init=False)
    sin: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self.cos, self.sin = cos_sin(self.inputs)

    @staticmethod
    def empty(plan: Plan, nodes: int, time: FloatArray, inputs: FloatArray, history: int) -> RowBlock:
        """Return a block with nothing solved."""
        rows = len(time)

        def room(count: int) -> FloatArray:
            return np.full((count, rows), np.nan)

        return RowBlock(
            time, inputs, history, room(nodes), room(nodes), room(plan.branches), room(plan.registers),
            room(plan.registers), room(plan.branches), np.zeros(rows), np.zeros(rows), rows,
        )  # fmt: skip

    @property
    def span(self) -> slice:
        """Rows to solve."""
        return slice(self.history, self.end)

    def vector(self, vector: Vector, rows: slice) -> tuple[FloatArray, FloatArray]:
        """Return a vector's components over some rows."""
        zr: FloatArray | float = vector.z.real
        zi: FloatArray | float = vector.z.imag
        if vector.actuator != NONE:
            c, s = self.cos[vector.actuator, rows], self.sin[vector.actuator, rows] * vector.turn
            zr, zi = zr * c - zi * s, zr * s + zi * c
        if vector.u != NONE:
            bx = self.x[vector.v, rows] - self.x[vector.u, rows]
            by = self.y[vector.v, rows] - self.y[vector.u, rows]
        elif vector.register != NONE:
            bx, by = self.rx[vector.register, rows], self.ry[vector.register, rows]
        else:
            full = np.ones(len(self.time[rows]))
            return zr * full, zi * full
        return zr * bx - zi * by, zr * by + zi * bx

    def stop(self, row: int, blocked: bool = False, singular: bool = False, weak_branch: int = NONE) -> None:
        """Let the block end before a row, if it does not end earlier."""
        if row < self.end:
            self.end, self.blocked, self.singular, self.weak_branch = row, blocked, singular, weak_branch
