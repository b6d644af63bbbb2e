"""The initial position problem: assemble a mechanism at given inputs from a guess.

Dyads are placed on the side of the guess; coupled groups are solved from the guess. If the guess is random, any
configuration is accepted: if one side of a dyad cannot be assembled, the other one is tried, and a group that does not
converge from its guess is also started from random positions.

The choices are the sides of dyads and guides, and the start of each coupled group, which may converge to different
configurations. The last choice is changed first (depth-first search).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gimcli.errors import StructureError
from gimcli.kernels.plan_steps import ORIENT, TILT
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions import newton
from gimcli.positions.block import NEW, RowBlock, sides
from gimcli.positions.newton import Packed, Run
from gimcli.positions.position import Row
from gimcli.positions.program import plan_program
from gimcli.status import Status
from gimcli.structure.residual import allowed, errors
from gimcli.structure.steps import NONE, Plan

if TYPE_CHECKING:
    from gimcli.continuation.arc import Gap
    from gimcli.structure.restrictions import Move

TURNS = 1024
"""Greatest number of changed choices."""

CHANCES = 40
"""Greatest number of random starts of each group, if a later step cannot be assembled."""

RandomPlaces = Callable[[int], ComplexArray]
"""Returns a number of random positions."""


class Backtracking:
    """The remaining choices: other sides of dyads, and other starts of groups."""

    def __init__(self, signs: FloatArray, drawn: RowBlock, random: RandomPlaces) -> None:
        self.program, self.signs, self.drawn, self.random = drawn.program, signs, drawn, random
        self.begun, self.turns = signs.copy(), TURNS
        self.chances = dict.fromkeys(self.program.packed, CHANCES)

    def other(self, k: int) -> int:
        """Change the last changeable choice before step k, reset those after it; return its step, or NONE."""
        self.turns -= 1
        for earlier in range(k - 1, NONE, -1) if self.turns > 0 else ():
            if self._changed(earlier):
                return earlier
        return NONE

    def _changed(self, k: int) -> bool:
        branch = self.program.tables.steps[k][5]
        if self.chances.get(k, 0):
            base = list(self.program.packed[k].group.base)
            places = self.random(len(base))
            self.drawn.x[base, NEW], self.drawn.y[base, NEW] = places.real, places.imag
            self.chances[k] -= 1
            return True
        if branch != NONE:
            first = self.signs[branch] == self.begun[branch]
            self.signs[branch] *= -1.0  # back to the first side if both have been tried
            return bool(first)
        return False


NEAR = 0.2
"""A position is accepted without further starts if no node is farther from its guess, relative to the size."""

SWEEPS = 60
"""Number of sweeps to improve a guess for Newton-Raphson."""

TRIALS = 60
"""Number of perturbed guesses for a group."""

RANDOM_STARTS = 120
"""Number of random starts after them, in a square of twice the size, if any configuration is accepted."""


@dataclass
class Assembly:
    """One assembled (or failed) position, its branch and the number of iterations."""

    status: Status
    row: Row
    signs: FloatArray  # (branches,) sides of the steps with two solutions
    error: float  # estimated error of the nodes
    work: float  # number of iterations
    surplus: bool = False  # whether the plan has redundant constraints, which are only checked
    gap: Gap | None = None  # at a singular position: the arc through it
    came: bool = False  # whether a motion has led there

    @property
    def regular(self) -> bool:
        """Whether it is assembled and not singular."""
        return self.status is Status.OK and self.gap is None


class Assembler:
    """Assembles single positions of a plan."""

    def __init__(self, mechanism: Mechanism, plan: Plan, run: Run, tolerance: float, anywhere: bool = False) -> None:
        """Prepare for a plan; `anywhere`: guesses are random and any configuration is accepted."""
        self.mechanism, self.plan, self.run, self.anywhere = mechanism, plan, run, anywhere
        self.tolerance = tolerance * mechanism.size
        self.accuracy = newton.Accuracy(tolerance, mechanism.size, mechanism.shortest)
        self.program = plan_program(mechanism, plan)
        self.failed = NONE  # number of the first step that failed in the last assembly
        self._sequences: dict[tuple[int, ...], tuple[Move, ...]] = {}

    def assemble(
        self, inputs: FloatArray, guess: ComplexArray, time: float = 0.0, signs: FloatArray | None = None
    ) -> Assembly:
        """Assemble at inputs (actuators,) from a guess (nodes,), on the sides `signs` (default: of the guess)."""
        block, drawn = (RowBlock(self.program, np.array([time]), inputs[:, None]) for _ in range(2))
        drawn.x[:, NEW], drawn.y[:, NEW] = guess.real, guess.imag
        signs = sides(drawn, self.mechanism.size) if signs is None else signs
        with np.errstate(all="ignore"):
            status = self._take(block, drawn, signs)
        row = Row(time, block.x[:, NEW].copy(), block.y[:, NEW].copy(), block.g[:, NEW].copy())
        return Assembly(status, row, signs, float(block.error[NEW]), float(block.work[NEW]), self.plan.surplus > 0)

    def _take(self, block: RowBlock, drawn: RowBlock, signs: FloatArray) -> Status:
        """Execute all steps in order; `signs` is changed to the sides of the solution."""
        k, failed, count = 0, Status.OK, len(self.plan.steps)
        before = [0.0] * count  # estimated error before each step
        self.failed = NONE
        search = Backtracking(signs, drawn, self._random(np.random.default_rng(0))) if self.anywhere else None
        while True:
            if k == count:
                if search is None or self._holds(self.plan.surplus, block):
                    return Status.OK
            else:
                before[k] = float(block.error[NEW])
                if self._step(k, block, drawn, signs):
                    k += 1
                    continue
                if failed is Status.OK:
                    self.failed = k
                    failed = Status.SINGULAR if block.singular and not block.blocked else Status.NOT_ASSEMBLED
            k = search.other(k) if search is not None else NONE
            if k == NONE:
                return failed
            self._forget(k, block)
            block.end, block.blocked, block.singular, block.error[NEW] = NEW + 1, False, False, before[k]

    def _forget(self, k: int, block: RowBlock) -> None:
        """Undo the steps from k on."""
        for later, (kind, to, *_) in enumerate(self.program.tables.steps[k:], start=k):
            x, y = (block.rx, block.ry) if kind in (ORIENT, TILT) else (block.x, block.y)
            placed = list(self.program.packed[later].group.nodes) if later in self.program.packed else [to]
            x[placed, NEW] = y[placed, NEW] = np.nan

    def _step(self, k: int, block: RowBlock, drawn: RowBlock, signs: FloatArray) -> bool:
        packed = self.program.packed.get(k)
        if packed is not None:
            return self._couple(packed, block, drawn)
        block.step(k, signs, self.tolerance)
        return block.end > NEW

    def _couple(self, packed: Packed, block: RowBlock, drawn: RowBlock) -> bool:
        """Solve a group from several starts; use the solution closest to the guess; return whether there is one."""
        base, nodes = list(packed.group.base), list(packed.group.nodes)
        drawing = drawn.x[nodes, NEW] + 1j * drawn.y[nodes, NEW]
        best: tuple[tuple[bool, float], ComplexArray] | None = None
        for number, start in enumerate(self._starts(packed, block, drawn)):
            block.x[base, NEW], block.y[base, NEW] = start.real, start.imag
            if block.settle(packed, self.run, self.accuracy):
                z = block.x[nodes, NEW] + 1j * block.y[nodes, NEW]
                loose = self.anywhere and not self._holds(packed.group.surplus, block)
                rank = loose, float(np.max(np.abs(z - drawing)))
                if self._faithful(block) and (best is None or rank < best[0]):
                    best = rank, z
            elif number == 0 and block.singular and self._fits(packed, block, start):
                return False  # a singular position: other starts would not determine it better
            if best is not None and self._enough(best[0], number):
                break
        if best is not None:
            block.x[nodes, NEW], block.y[nodes, NEW] = best[1].real, best[1].imag
            block.singular = False
        return best is not None

    def _enough(self, rank: tuple[bool, float], number: int) -> bool:
        """Return whether further starts are unnecessary, given the rank of the best solution and the start's number."""
        loose, far = rank
        return not loose if self.anywhere else far <= NEAR * self.mechanism.size or number >= 1

    def _holds(self, surplus: int, block: RowBlock) -> bool:
        """Return whether redundant constraints, which are not imposed exactly, are satisfied by the placed nodes."""
        enough = allowed(self.mechanism, self.accuracy.tolerance)
        return surplus <= 0 or all(error <= enough for _, _, error in self._errors(block))

    def _errors(self, block: RowBlock) -> list[tuple[str, bool, float]]:
        """Return name and error of the constraints between placed nodes, and whether it is an angle."""
        z = block.x[:, NEW : NEW + 1] + 1j * block.y[:, NEW : NEW + 1]
        found = errors(self.mechanism, z, block.inputs[:, NEW : NEW + 1])
        return [(name, is_angle, float(error[0])) for name, is_angle, error in found if np.isfinite(error[0])]

    def _starts(self, packed: Packed, block: RowBlock, drawn: RowBlock) -> Iterator[ComplexArray]:
        """Yield starts of the base nodes: the guess, the guess after sweeps, perturbed guesses, random positions."""
        base, size = list(packed.group.base), self.mechanism.size
        guess = drawn.x[:, NEW] + 1j * drawn.y[:, NEW]
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
        for _ in range(RANDOM_STARTS if self.anywhere else 0):
            yield random(len(base))

    def _random(self, generator: np.random.Generator) -> RandomPlaces:
        """Return a generator function of uniform random positions in a square of twice the size around the frame."""
        centre, size = self.mechanism.centre, self.mechanism.size

        def random(count: int) -> ComplexArray:
            spread = generator.uniform(-1.0, 1.0, (2, count)) * size
            return np.asarray(centre + spread[0] + 1j * spread[1])

        return random

    def _swept(self, packed: Packed, block: RowBlock, guess: ComplexArray) -> ComplexArray | None:
        from gimcli.gim import sweeps
        from gimcli.gim.sequence import group_sequence

        own = list(packed.group.nodes)
        z = np.where(np.isfinite(block.x[:, NEW]), block.x[:, NEW] + 1j * block.y[:, NEW], guess)
        z[own] = guess[own]
        if packed.group.base not in self._sequences:
            try:
                found = group_sequence(self.mechanism, own, self.mechanism.drawn, self.plan)
            except StructureError:
                found = ()
            self._sequences[packed.group.base] = found
        moves = self._sequences[packed.group.base]
        if not moves:
            return None
        constants = sweeps.SweepConstants(sweeps=SWEEPS)
        done = sweeps.settle(moves, z, block.inputs[:, NEW], self.mechanism.size, 1e-6, self.run, constants)
        block.work[NEW] += done.sweeps
        return done.z if np.all(np.isfinite(done.z)) else None

    def _faithful(self, block: RowBlock) -> bool:
        """Return whether no driven angle has an error of 180 deg, which the equation of a line does not exclude."""
        return not any(is_angle and error > 1.0 for _, is_angle, error in self._errors(block))

    def _fits(self, packed: Packed, block: RowBlock, start: ComplexArray) -> bool:
        """Return whether a start of a group already satisfies its equations; it is then stored in the block."""
        base, group = list(packed.group.base), packed.group
        block.x[base, NEW], block.y[base, NEW] = start.real, start.imag
        block.carry(packed)
        names = {e.name for e in group.equations}
        return all(error <= self.accuracy.tolerance for name, _, error in self._errors(block) if name in names)
