"""A motion by sweeps, row by row, with three measures because sweeps may not converge or may change the branch.

- The sequence is exchanged if its spectral radius exceeds 1 or it has become much slower: the search is repeated for
  the next position, extrapolated from the last two.
- A row in which the sweeps do not converge is approached in smaller steps.
- A converged row is compared with the continuous motion: halfway between two positions of the same branch the
  constraints have nearly the same errors as at both positions, halfway between two branches much greater ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gimcli.gim.sweeper import Sweeper
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.positions.inputs import divided, nearest_turns, pace
from gimcli.status import Status
from gimcli.structure.residual import allowed, residual


@dataclass(frozen=True)
class SwitchingConstants:
    """Constants of a motion by sweeps."""

    slower: float = 4.0  # another sequence is searched if a row needs this many times the sweeps
    least: int = 60  # number of sweeps up to which no other sequence is searched
    gain: float = 1.2  # another sequence is used if it needs this many times fewer sweeps
    parts: tuple[int, ...] = (4, 16, 64)  # numbers of parts of a step that failed, tried in this order
    steps_a_turn: int = 90  # for the motion from the drawn inputs to the first row
    apart: float = 0.05  # of the size: nodes at a greater distance are on different branches
    halfway: float = 8.0  # ratio of the error halfway to that at the ends, above which the branches differ


SWITCHING = SwitchingConstants()


@dataclass
class Swept:
    """A motion by sweeps; all rows after the first unsolved one have its status."""

    z: ComplexArray  # (nodes, rows), NaN where not solved
    work: FloatArray  # (rows,) sweeps
    codes: IntArray  # (rows,) of Status
    exchanged: list[int] = field(default_factory=list)  # rows after which the sequence was exchanged


def off_branch(
    mechanism: Mechanism, z: ComplexArray, other: ComplexArray, inputs: FloatArray, tolerance: float,
) -> BoolArray:  # fmt: skip
    """Return (rows,) whether positions z (nodes, rows) are on another branch than the exact positions `other`.

    Solutions closer than the square root of the tolerance cannot be distinguished by residuals.
    """
    far = np.max(mechanism.apart(z, other), axis=0) > SWITCHING.apart * mechanism.size
    ends = np.maximum(residual(mechanism, z, inputs).total, allowed(mechanism, tolerance))
    halfway = residual(mechanism, 0.5 * (z + other), inputs).total
    known = np.all(np.isfinite(z) & np.isfinite(other), axis=0)
    return np.asarray(known & (far | (halfway > SWITCHING.halfway * ends)))


class SwitchingState:
    """The state of a motion by sweeps."""

    def __init__(self, sweeper: Sweeper, inputs: FloatArray, exact: ComplexArray) -> None:
        self.sweeper, self.inputs, self.exact = sweeper, inputs, exact
        rows = inputs.shape[1]
        empty = np.full(exact.shape, complex(math.nan, math.nan))
        self.swept = Swept(empty, np.zeros(rows), np.full(rows, int(Status.NOT_CONVERGED)))
        self.done = 0  # number of solved rows
        self.slow = 0.0  # number of sweeps above which another sequence is searched; 0: not known yet

    def run(self, first: ComplexArray | None = None) -> Swept:
        """Solve all rows up to the first that fails; first: the position of the first row, if known."""
        rows = self.inputs.shape[1]
        status = self._begin() if first is None else self._take(first)
        while status is Status.OK and self.done < rows:
            status = self._solve_rows()
            if self.done < rows and status is not Status.OK:
                status = self._recover(status)
        self.swept.codes[: self.done] = int(Status.OK)
        self.swept.codes[self.done :] = int(status)
        return self.swept

    # -- the first row ---------------------------------------------------------------------

    def _begin(self) -> Status:
        """Solve the first row from the drawn position; if it fails, follow the inputs from the drawn ones."""
        sweeper, inputs = self.sweeper, self.inputs[:, 0]
        first = sweeper.settle(inputs, sweeper.mechanism.drawn)
        status = self._checked(first.status, first.z, 0)
        self.swept.work[0] = first.sweeps
        if status is not Status.OK:
            z = self._from_drawn(inputs)
            if z is not None and self._checked(Status.OK, z, 0) is Status.OK:
                return self._take(z)
        return self._take(first.z) if status is Status.OK else status

    def _from_drawn(self, inputs: FloatArray) -> ComplexArray | None:
        sweeper = self.sweeper
        begin = nearest_turns(sweeper.mechanism, sweeper.mechanism.drawn_inputs, inputs)
        turns = pace(sweeper.mechanism, np.stack([begin, inputs], axis=1))
        if not turns > 0.0:
            return None
        parts = max(8, math.ceil(turns * SWITCHING.steps_a_turn))
        between = divided(np.stack([begin, inputs], axis=1), np.array([parts]))
        unknown = np.full((len(sweeper.mechanism.nodes), parts + 1), complex(math.nan, math.nan))
        path = SwitchingState(sweeper, between, unknown).run()
        self.swept.work[0] += path.work.sum()
        return path.z[:, -1] if path.codes[-1] == Status.OK else None

    def _take(self, z: ComplexArray) -> Status:
        self.swept.z[:, self.done] = z
        self.done += 1
        return Status.OK

    # -- rows ------------------------------------------------------------------------------

    def _solve_rows(self) -> Status:
        """Solve rows until one fails or is slow; return the status of the failed row, else OK."""
        first = self.done
        z, work, stop, status = self.sweeper.follow(self.inputs[:, first - 1 :], self.swept.z[:, first - 1], self.slow)
        rows = slice(first, first + stop - 1)
        wrong = np.flatnonzero(
            off_branch(
                self.sweeper.mechanism, z[:, 1:stop], self.exact[:, rows], self.inputs[:, rows],
                self.sweeper.options.tolerance,
            )
        )  # fmt: skip
        if len(wrong):
            stop, status = int(wrong[0]) + 1, Status.JUMPED
        rows = slice(first, first + stop - 1)
        self.swept.z[:, rows], self.swept.work[rows] = z[:, 1:stop], work[1:stop]
        self.done += stop - 1
        if status is not Status.OK:
            self.swept.work[self.done] = work[stop]
        elif stop > 1:
            self._check_speed(float(work[stop - 1]))
        return status

    def _check_speed(self, sweeps: float) -> None:
        """Search for a faster sequence after a slow row; set the number of sweeps that counts as slow."""
        if self.slow > 0.0 and sweeps > self.slow and self.done < self.inputs.shape[1]:
            if self._exchange():
                self.slow = 0.0
                return
        elif self.slow > 0.0:
            return
        self.slow = max(float(SWITCHING.least), SWITCHING.slower * sweeps)

    def _exchange(self) -> bool:
        """Exchange the sequence for one that is better at the next row; return whether there was one.

        The next position is extrapolated from the last two.
        """
        last, before = self.swept.z[:, self.done - 1], self.swept.z[:, max(0, self.done - 2)]
        taken = self.sweeper.exchange(2.0 * last - before, SWITCHING.gain)
        if taken:
            self.swept.exchanged.append(self.done - 1)
        return taken

    def _recover(self, status: Status) -> Status:
        """Solve a row that failed by another sequence, else in smaller steps; return its status."""
        row, spent = self.done, self.swept.work[self.done]
        if self._exchange():
            self.slow = 0.0
            again = self._solve_rows()
            if self.done > row:
                self.swept.work[row] += spent
                return Status.OK  # a later row that failed is then treated in the same manner
            status = again
        for parts in SWITCHING.parts:
            inputs = divided(self.inputs[:, row - 1 : row + 1], np.array([parts]))
            z, work, stop, failed = self.sweeper.follow(inputs, self.swept.z[:, row - 1], math.inf)
            self.swept.work[row] += work.sum()
            if failed is Status.OK and stop == parts + 1:
                status = self._checked(Status.OK, z[:, -1], row)
                if status is Status.OK:
                    return self._take(z[:, -1])
        return status

    def _checked(self, status: Status, z: ComplexArray, row: int) -> Status:
        if status is not Status.OK:
            return status
        wrong = off_branch(
            self.sweeper.mechanism, z[:, None], self.exact[:, [row]], self.inputs[:, [row]],
            self.sweeper.options.tolerance,
        )  # fmt: skip
        return Status.JUMPED if wrong[0] else Status.OK
