"""The initial position problem: assemble a mechanism at given inputs from a guess.

Dyads take the side that the guess is drawn on; coupled groups are settled from the guess. From a
random start any configuration will do: where a side leads nowhere the other one is taken, and a
group that does not settle near its start is started from other places too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gimcli.continuation.gap_interpolation import Gap, Row
from gimcli.errors import StructureError
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.motion.backtracking import Backtracking, RandomPlaces
from gimcli.positions import closed_forms, newton
from gimcli.positions.block import RowBlock
from gimcli.positions.branch_signs import sides
from gimcli.positions.newton import Packed, Run
from gimcli.status import Status
from gimcli.structure.residual import allowed, errors
from gimcli.structure.restrictions import Move
from gimcli.structure.steps import NONE, Coupled, Dyad, Orient, Place, Plan, Tilt

NEAR = 0.2
"""A position is taken at once when no node is farther from its guess, relative to the size."""

SWEEPS = 60
"""Sweeps that bring a far guess near enough for Newton-Raphson."""

TRIALS = 60
"""Disturbed guesses tried before a group counts as impossible to assemble."""

STREWN = 120
"""Random starts over a square of twice the size that are tried after them where any configuration will do."""


@dataclass
class Assembly:
    """One position, its branch and what it cost."""

    status: Status
    row: Row
    signs: FloatArray
    error: float
    work: float
    surplus: bool = False  # the plan has constraints that are only checked
    gap: Gap | None = None  # of a singular position: the way through it
    came: bool = False  # a motion has led there

    @property
    def regular(self) -> bool:
        """Return whether it is assembled, and not in a singular position."""
        return self.status is Status.OK and self.gap is None


class Assembler:
    """Assembles single positions of a plan."""

    def __init__(self, mechanism: Mechanism, plan: Plan, run: Run, tolerance: float, anywhere: bool = False) -> None:
        """Prepare; `anywhere`: guesses are random starts, any configuration will do."""
        self.mechanism, self.plan, self.run, self.anywhere = mechanism, plan, run, anywhere
        self.tolerance = tolerance * mechanism.size
        self.accuracy = newton.Accuracy(tolerance, mechanism.size, mechanism.shortest)
        self.packed = {k: Packed(s) for k, s in enumerate(plan.steps) if isinstance(s, Coupled)}
        self._sequences: dict[tuple[int, ...], tuple[Move, ...]] = {}

    def assemble(
        self, inputs: FloatArray, guess: ComplexArray, time: float = 0.0, signs: FloatArray | None = None
    ) -> Assembly:
        """Assemble at inputs (actuators,) from a guess (nodes,), on the sides of the guess or as `signs` say."""
        block = RowBlock.empty(self.plan, len(self.mechanism.nodes), np.array([time]), inputs[:, None], 0)
        frame = self.mechanism.members[0]
        block.x[list(frame.nodes), 0], block.y[list(frame.nodes), 0] = frame.shape.real, frame.shape.imag
        drawn = RowBlock.empty(self.plan, len(self.mechanism.nodes), np.array([time]), inputs[:, None], 0)
        drawn.x[:, 0], drawn.y[:, 0] = guess.real, guess.imag
        signs = sides(self.plan, drawn, self.mechanism.size) if signs is None else signs
        with np.errstate(all="ignore"):
            status = self._take(block, drawn, signs)
        row = Row(time, block.x[:, 0].copy(), block.y[:, 0].copy(), block.g[:, 0].copy())
        return Assembly(status, row, signs, float(block.error[0]), float(block.work[0]), self.plan.surplus > 0)

    def _take(self, block: RowBlock, drawn: RowBlock, signs: FloatArray) -> Status:
        """Take all steps in order; `signs` then holds the sides taken."""
        steps, k, failed = self.plan.steps, 0, Status.OK
        before = [0.0] * len(steps)  # error that each step started with
        ways = Backtracking(self.plan, signs, drawn, self._random(np.random.default_rng(0))) if self.anywhere else None
        while True:
            if k == len(steps):
                if ways is None or self._holds(self.plan.surplus, block):
                    return Status.OK
            else:
                before[k] = float(block.error[0])
                if self._step(k, steps[k], block, drawn, signs):
                    k += 1
                    continue
                if failed is Status.OK:
                    failed = Status.SINGULAR if block.singular and not block.blocked else Status.NOT_ASSEMBLED
            k = ways.other(k) if ways is not None else NONE
            if k == NONE:
                return failed
            self._forget(k, block)
            block.end, block.blocked, block.singular, block.error[0] = 1, False, False, before[k]

    def _forget(self, k: int, block: RowBlock) -> None:
        """Take back what the steps from k on have placed."""
        for step in self.plan.steps[k:]:
            if isinstance(step, Orient | Tilt):
                block.rx[step.register, 0] = block.ry[step.register, 0] = np.nan
            else:
                nodes = list(step.nodes) if isinstance(step, Coupled) else [step.node]
                block.x[nodes, 0] = block.y[nodes, 0] = np.nan

    def _step(self, k: int, step: object, block: RowBlock, drawn: RowBlock, signs: FloatArray) -> bool:
        if isinstance(step, Place):
            closed_forms.place(step, block)
        elif isinstance(step, Orient):
            closed_forms.orient(step, block)
        elif isinstance(step, Tilt):
            closed_forms.tilt(step, block, signs, self.tolerance)
        elif isinstance(step, Dyad):
            closed_forms.dyad(step, block, signs, self.tolerance)
        elif isinstance(step, Coupled):
            return self._couple(self.packed[k], block, drawn)
        return block.end > 0

    def _couple(self, packed: Packed, block: RowBlock, drawn: RowBlock) -> bool:
        """Settle a group: the assembled position nearest to the guess of those that the first starts find."""
        base, nodes = list(packed.group.base), list(packed.group.nodes)
        drawing = drawn.x[nodes, 0] + 1j * drawn.y[nodes, 0]
        best: tuple[tuple[bool, float], ComplexArray] | None = None
        for number, start in enumerate(self._starts(packed, block, drawn)):
            block.x[base, 0], block.y[base, 0] = start.real, start.imag
            if newton.settle(packed, block, 0, self.run, self.accuracy):
                z = block.x[nodes, 0] + 1j * block.y[nodes, 0]
                loose = self.anywhere and not self._holds(packed.group.surplus, block)
                rank = loose, float(np.max(np.abs(z - drawing)))
                if self._faithful(block) and (best is None or rank < best[0]):
                    best = rank, z
            elif number == 0 and block.singular and self._fits(packed, block, start):
                return False  # a singular position: no other start determines it better
            if best is not None and self._enough(best[0], number):
                break
        if best is not None:
            block.x[nodes, 0], block.y[nodes, 0] = best[1].real, best[1].imag
            block.singular = False
        return best is not None

    def _enough(self, rank: tuple[bool, float], number: int) -> bool:
        """Return whether no start after this one is needed: the first position, or the nearest of two."""
        loose, far = rank
        return not loose if self.anywhere else far <= NEAR * self.mechanism.size or number >= 1

    def _holds(self, surplus: int, block: RowBlock) -> bool:
        """Return whether surplus constraints, which nothing imposes exactly, hold among what is placed."""
        if surplus <= 0:
            return True
        z = block.x[:, :1] + 1j * block.y[:, :1]
        enough = allowed(self.mechanism, self.accuracy.tolerance)
        found = (e[0] for _, _, e in errors(self.mechanism, z, block.inputs[:, :1]))
        return all(e <= enough for e in found if np.isfinite(e))

    def _starts(self, packed: Packed, block: RowBlock, drawn: RowBlock) -> Iterator[ComplexArray]:
        """Yield starts of the base nodes: the guess, the guess after some sweeps, the guess disturbed, any."""
        base, size = list(packed.group.base), self.mechanism.size
        guess = drawn.x[:, 0] + 1j * drawn.y[:, 0]
        yield guess[base]
        swept = self._swept(packed, block, guess)
        if swept is not None:
            yield swept[base]
        generator = np.random.default_rng(0)
        for k in range(TRIALS):
            reach = size * (0.02 + k / TRIALS)
            noise = generator.standard_normal((2, len(base))) * reach
            yield guess[base] + noise[0] + 1j * noise[1]
        random = self._random(generator)
        for _ in range(STREWN if self.anywhere else 0):
            yield random(len(base))

    def _random(self, generator: np.random.Generator) -> RandomPlaces:
        """Return a source of random places, evenly over a square of twice the size about the frame."""
        centre, size = np.mean(self.mechanism.members[FRAME].shape), self.mechanism.size

        def random(count: int) -> ComplexArray:
            spread = generator.uniform(-1.0, 1.0, (2, count)) * size
            return np.asarray(centre + spread[0] + 1j * spread[1])

        return random

    def _swept(self, packed: Packed, block: RowBlock, guess: ComplexArray) -> ComplexArray | None:
        from gimcli.gim import sweeps
        from gimcli.gim.sequence import group_sequence

        own = list(packed.group.nodes)
        z = np.where(np.isfinite(block.x[:, 0]), block.x[:, 0] + 1j * block.y[:, 0], guess)
        z[own] = guess[own]
        if packed.group.base not in self._sequences:
            try:
                found = group_sequence(self.mechanism, own, self.mechanism.drawn, block.inputs[:, 0], self.plan)
            except StructureError:
                found = ()
            self._sequences[packed.group.base] = found
        moves = self._sequences[packed.group.base]
        if not moves:
            return None
        constants = sweeps.SweepConstants(sweeps=SWEEPS)
        done = sweeps.settle(moves, z, block.inputs[:, 0], self.mechanism.size, 1e-6, self.run, constants)
        block.work[0] += done.sweeps
        return done.z if np.all(np.isfinite(done.z)) else None

    def _faithful(self, block: RowBlock) -> bool:
        """Return whether no driven angle is a half turn off: a line does not know its two ends apart."""
        z = block.x[:, :1] + 1j * block.y[:, :1]
        angles = [e[0] for _, is_angle, e in errors(self.mechanism, z, block.inputs[:, :1]) if is_angle]
        return not any(np.isfinite(e) and e > 1.0 for e in angles)

    def _fits(self, packed: Packed, block: RowBlock, start: ComplexArray) -> bool:
        """Return whether the members of a group fit at its start already, which is then left in the block."""
        base, group = list(packed.group.base), packed.group
        block.x[base, 0], block.y[base, 0] = start.real, start.imag
        for place in group.places:
            closed_forms.place(place, block)
        names = {e.name for e in group.equations}
        z = block.x[:, :1] + 1j * block.y[:, :1]
        found = errors(self.mechanism, z, block.inputs[:, :1])
        return all(e[0] <= self.accuracy.tolerance for name, _, e in found if name in names and np.isfinite(e[0]))
