"""The state of a motion on one branch, and the solution of the rows that continue it.

The "time" of a row is the independent variable of the inputs: the coordinate on a leg of the laws, or the time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from gimcli.continuation.arc import ArcPassage
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.positions import newton
from gimcli.positions.block import NEW, RowBlock, sides
from gimcli.positions.inputs import Inputs
from gimcli.positions.newton import Run
from gimcli.positions.position import Row
from gimcli.positions.program import plan_program
from gimcli.structure.steps import Plan

if TYPE_CHECKING:
    from gimcli.motion.motion_curve import MotionCurve


@dataclass(frozen=True)
class FollowingConstants:
    """Constants of the path following."""

    rows: int = 2048  # in one block, which then fits into the processor cache
    many: int = 16  # number of rows from which on all are solved in one compiled call
    growth: float = 1.75  # factor of the small steps that lead to the second row
    steps: int = 14  # number of these steps
    first: tuple[float, ...] = (1 / 512, 1 / 64, 1 / 8, 1.0)  # fractions of the first step, if these steps fail
    split: int = 8  # number of parts of an interval that is refined
    resolution: float = 1e-12  # relative accuracy of the location of a limit
    doubtful: int = 100  # most doubtful rows that are refined one after the other; a limit needs 30
    loosest: float = 1e-6  # error of the nodes of a coupled group that is allowed near a singular position
    memory: int = 400  # number of solved rows that are kept


class BranchState:
    """A plan, the signs of a branch and its last solved rows; it solves the rows that continue them."""

    def __init__(
        self, mechanism: Mechanism, plan: Plan, inputs: Inputs, run: Run, tolerance: float,
        motion_curve: Callable[[], MotionCurve] | None = None, constants: FollowingConstants | None = None,
    ) -> None:  # fmt: skip
        self.mechanism, self.plan, self.inputs, self.run = mechanism, plan, inputs, run
        self.constants = constants or FollowingConstants()
        self.tolerance = tolerance * mechanism.size
        self.accuracy = newton.Accuracy(tolerance, mechanism.size, mechanism.shortest)
        self.loose_accuracy = newton.Accuracy(tolerance, mechanism.size, mechanism.shortest, self.constants.loosest)
        self.sign = np.ones(plan.branches)
        self.program = plan_program(mechanism, plan)
        self.determinant = dict.fromkeys(self.program.packed, 0.0)
        self.log: list[Row] = []
        self.bridges: list[ArcPassage] = []  # arcs through singular positions that the motion has passed
        self.lenient = False  # passing a position that cannot be solved to the tolerance
        self._motion_curve = motion_curve
        self.turn = 1.0  # change of the time for one turn of the input, or a travel of 2 pi sizes

    @cached_property
    def motion_curve(self) -> MotionCurve | None:
        """The curve of the motion; None if it is not used."""
        return None if self._motion_curve is None else self._motion_curve()

    def begin(self, row: Row, signs: FloatArray) -> None:
        """Start from a solved position."""
        self.log, self.sign = [row], signs.copy()
        self.determinant = dict.fromkeys(self.program.packed, 0.0)
        self.bridges = []

    def sides(self, row: Row) -> FloatArray:
        """Return the branch signs (branches,) of a row."""
        when = np.array([row.time])
        guess = RowBlock(self.program, when, self.inputs(when))
        guess.x[:, NEW], guess.y[:, NEW] = row.x, row.y
        return sides(guess, self.mechanism.size)

    def evaluate(self, times: FloatArray, history: list[Row], values: FloatArray | None = None) -> RowBlock:
        """Solve rows at times that continue a history; values: their inputs (actuators, rows), if already known."""
        past = self.useful(times, history)
        inputs = self.inputs(np.concatenate([[row.time for row in past], times]))
        if values is not None:
            inputs[:, len(past) :] = values
        block = RowBlock(self.program, times, inputs, past)
        block.lenient = self.lenient
        with np.errstate(all="ignore"):
            self._solve(block)
        return block

    def _solve(self, block: RowBlock) -> None:
        accuracy = self.loose_accuracy if block.lenient else self.accuracy
        for k in range(len(self.plan.steps)):
            if block.end <= NEW:
                return
            packed = self.program.packed.get(k)
            if packed is None:
                block.step(k, self.sign, self.tolerance)
            else:
                self.determinant[k] = block.follow(packed, self.run, self.determinant[k], accuracy)

    def useful(self, times: FloatArray, history: list[Row]) -> list[Row]:
        """Return up to four rows of the history with spacing similar to that of `times`, or the first and the last."""
        step = times[0] - history[-1].time
        chosen = [history[-1]]
        for row in reversed(history[:-1]):
            if len(chosen) == 4:
                break
            if chosen[-1].time - row.time >= 0.5 * step:
                chosen.append(row)
        if len(chosen) == 1 < len(history):
            chosen.append(history[0])
        return chosen[::-1]

    def remember(self, rows: list[Row]) -> None:
        """Append solved rows to the history."""
        self.log += rows
        if len(self.log) > 2 * self.constants.memory:
            del self.log[: -self.constants.memory]
