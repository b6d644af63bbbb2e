"""The initial position problem: assemble a mechanism at given inputs from a guess.

Dyads take the side that the guess is drawn on; coupled groups are settled from the guess.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.follow import Row
from gimcli.solvers import closed, newton
from gimcli.solvers.block import Block
from gimcli.solvers.newton import Packed, Run
from gimcli.solvers.side import sides
from gimcli.status import Status
from gimcli.structure.steps import Coupled, Dyad, Orient, Place, Plan, Tilt

@dataclass
class Assembly:
    """One position, its branch and what it cost."""

    status: Status
    row: Row
    signs: FloatArray
    error: float
    work: float
    step: int = -1  # number of the plan's step that failed


class Assembler:
    """Assembles single positions of a plan."""

    def __init__(self, mechanism: Mechanism, plan: Plan, run: Run, tolerance: float) -> None:
        self.mechanism, self.plan, self.run = mechanism, plan, run
        self.tolerance = tolerance * mechanism.size
        self.packed = {k: Packed(s) for k, s in enumerate(plan.steps) if isinstance(s, Coupled)}

    def assemble(self, inputs: FloatArray, guess: ComplexArray, time: float = 0.0) -> Assembly:
        """Assemble at inputs (actuators,) from a guess (nodes,)."""
        block = Block.empty(self.plan, len(self.mechanism.nodes), np.array([time]), inputs[:, None], 0)
        frame = self.mechanism.members[0]
        block.x[list(frame.nodes), 0], block.y[list(frame.nodes), 0] = frame.shape.real, frame.shape.imag
        drawn = Block.empty(self.plan, len(self.mechanism.nodes), np.array([time]), inputs[:, None], 0)
        drawn.x[:, 0], drawn.y[:, 0] = guess.real, guess.imag
        signs = sides(self.plan, drawn, self.mechanism.size)
        status, failed = Status.OK, -1
        with np.errstate(all="ignore"):
            for k, step in enumerate(self.plan.steps):
                if not self._step(k, step, block, drawn, signs):
                    status, failed = self._why(block, step), k
                    break
        row = Row(time, block.x[:, 0].copy(), block.y[:, 0].copy(), block.g[:, 0].copy())
        return Assembly(status, row, signs, float(block.error[0]), float(block.work[0]), failed)

    @staticmethod
    def _why(block: Block, step: object) -> Status:
        if block.singular and not block.blocked:
            return Status.SINGULAR
        return Status.NOT_ASSEMBLED

    def _step(self, k: int, step: object, block: Block, drawn: Block, signs: FloatArray) -> bool:
        if isinstance(step, Place):
            closed.place(step, block)
        elif isinstance(step, Orient):
            closed.orient(step, block)
        elif isinstance(step, Tilt):
            closed.tilt(step, block, signs, self.tolerance)
        elif isinstance(step, Dyad):
            closed.dyad(step, block, signs, self.tolerance)
        elif isinstance(step, Coupled):
            return self._couple(self.packed[k], block, drawn)
        return block.end > 0

    def _couple(self, packed: Packed, block: Block, drawn: Block) -> bool:
        base = list(packed.group.base)
        block.x[base, 0], block.y[base, 0] = drawn.x[base, 0], drawn.y[base, 0]
        good, _ = newton.settle(packed, block, 0, self.run, self.tolerance, 50)
        return good
