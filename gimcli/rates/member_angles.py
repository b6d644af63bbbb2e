"""Directions of members along a motion, full turns counted.

From the positions of two rows alone a direction is known up to full turns. It is taken to change by less than half a
turn from one row to the next. Where the inputs move far from one row to the next, or where a member turns far, rows
between are solved for the count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Protocol

import numpy as np

from gimcli.canonical import counted, phase
from gimcli.mechanism import FRAME, BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.positions.inputs import divided, law_inputs, scales

if TYPE_CHECKING:
    from gimcli.motion.motion import Motion

COUNTED = np.pi / 36.0
"""Largest change of an input (in rad, or relative to the size) between two rows that are used to count full turns."""

CLEAR, DENSEST, BESIDE = 1.0, 20_000, 2
"""Rotation of a member [rad] between two rows above which rows between are solved; the largest number of rows for which
this is done; steps on either side in which rows are added too."""


class Angles(Protocol):
    """Directions of the members of a motion whose pieces are given in order."""

    def __call__(self, motion: Motion, member: int) -> FloatArray:
        """Return the directions of a member (rows,) in the file's angle unit, full turns counted; NaN if not solved."""


class Again(Protocol):
    """Solves a motion again in the same pieces, with rows between."""

    def __call__(self, *, between: Callable[[FloatArray], FloatArray]) -> Iterator[Motion]:
        """Return the pieces; `between` adds times between consecutive times."""


def direction(mechanism: Mechanism, member: int, z: ComplexArray) -> FloatArray:
    """Return the directions of a member (rows,) from its first node to its second, in the file's angle unit."""
    if member == FRAME:
        return np.where(np.isfinite(z[0]), 0.0, np.nan)
    first, second = mechanism.members[member].nodes[:2]
    found = phase(z[second] - z[first])
    return np.asarray(np.degrees(found) if mechanism.angle_unit == "deg" else found)


def full_turn(mechanism: Mechanism) -> float:
    """Return a full turn in the file's angle unit."""
    return 360.0 if mechanism.angle_unit == "deg" else 2.0 * np.pi


def in_rows(motion: Motion, member: int) -> FloatArray:
    """Return the directions of a member (rows,) of a motion with close rows: no rows between are solved."""
    return counted(direction(motion.mechanism, member, motion.z), full_turn(motion.mechanism))


class LawAngles:
    """Directions of members along the laws, of pieces in order or of a whole motion; some of its rows are enough."""

    def __init__(self, mechanism: Mechanism, steps: int, again: Again) -> None:
        self.mechanism, self.steps, self._again = mechanism, steps, again
        self._piece: Motion | None = None  # the piece that was given last
        self._before: Motion | None = None  # the last solved row before it
        self._dense: Motion | None = None  # the piece with rows between, if they are needed
        self._denser: Iterator[Motion] | None = None  # solves such pieces
        self._done = 0  # pieces given
        self._last: dict[int, float] = {}  # by member: its direction in that row
        self._ends: dict[int, float] = {}  # the same in the piece that was given last

    def __call__(self, motion: Motion, member: int) -> FloatArray:
        """Return the directions of a member (rows,) in the file's angle unit, full turns counted; NaN if not solved."""
        if motion is not self._piece:
            self._advance(motion)
        turn, own = full_turn(self.mechanism), direction(self.mechanism, member, motion.z)
        count = self._count(motion, member, own)
        found = np.asarray(own + turn * np.round((count - own) / turn))
        good = np.flatnonzero(np.isfinite(found))
        if len(good):
            self._ends[member] = float(found[good[-1]])
        return found

    def _advance(self, motion: Motion) -> None:
        """Begin the next piece."""
        if self._piece is not None:
            good = np.flatnonzero(self._piece.good)
            self._before = self._piece.rows(good[-1:]) if len(good) else self._before
            self._last |= self._ends
        self._piece, self._dense, self._ends = motion, None, {}
        self._done += 1
        if _is_whole(motion):
            self._dense = self._solved(divided(motion.time, _parts(self.mechanism, motion.inputs)), motion)
        else:
            self._continue(motion if self._before is None else motion.joined([self._before, motion]))

    def _continue(self, ends: Motion) -> None:
        """Solve the rows between those of the next piece, if they are needed; `ends` has the row before, too."""
        if self._denser is not None or np.any(_parts(self.mechanism, ends.inputs) > 1):
            if self._denser is None:
                own, laws = self.mechanism, law_inputs(self.mechanism)
                self._denser = self._again(between=lambda times: divided(times, _parts(own, laws(times))))
                for _ in range(self._done - 1):
                    next(self._denser)
            self._dense = next(self._denser)

    def _solved(self, times: FloatArray, motion: Motion) -> Motion:
        """Return a whole motion at times that include its own."""
        return motion if len(times) == len(motion.time) else next(self._again(between=lambda _: times))

    def _count(self, motion: Motion, member: int, own: FloatArray) -> FloatArray:
        """Return directions (rows,) with full turns counted, continued from the last piece; `own` has no turns."""
        dense = motion if self._dense is None else self._dense
        if _is_whole(motion):
            dense = self._dense = self._refined(dense, member)
        angle, rows = direction(self.mechanism, member, dense.z), np.searchsorted(dense.time, motion.time)
        angle[rows] = np.where(np.isfinite(own), own, angle[rows])
        before = [self._last[member]] if member in self._last else []
        return counted(np.concatenate([before, angle]), full_turn(self.mechanism))[len(before) :][rows]

    def _refined(self, dense: Motion, member: int) -> Motion:
        """Return a whole motion with more rows where a member turns far from one row to the next."""
        while True:
            wide = _wide(self.mechanism, direction(self.mechanism, member, dense.z))
            times = divided(dense.time, np.where(wide, 4, 1))
            if not wide.any() or len(times) > DENSEST + self.steps:
                return dense
            dense = self._solved(times, dense)


def _is_whole(motion: Motion) -> bool:
    return bool(motion.time[0] == 0.0 and motion.time[-1] == 1.0)


def _wide(mechanism: Mechanism, angle: FloatArray) -> BoolArray:
    """Return the steps (rows - 1,) in which an angle changes far, and those beside them."""
    turn = full_turn(mechanism)
    change = np.abs((np.diff(angle) + 0.5 * turn) % turn - 0.5 * turn) * (2.0 * np.pi / turn)
    with np.errstate(invalid="ignore"):
        wide = change > CLEAR
    found = wide.copy()
    for k in range(1, BESIDE + 1):
        found[k:] |= wide[:-k]
        found[:-k] |= wide[k:]
    return found


def _parts(mechanism: Mechanism, inputs: FloatArray) -> IntArray:
    """Return for each step (rows - 1,) the number of parts in which no input changes by more than COUNTED."""
    change = np.max(np.abs(np.diff(inputs)) / scales(mechanism)[:, None], axis=0, initial=0.0)
    return np.asarray(np.maximum(np.ceil(change / COUNTED * (1.0 - 1e-12)), 1), dtype=np.int64)
