"""Common attributes of the results of motions and positions: coordinates, angles and status of each row."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from functools import cached_property, partial
from itertools import chain
from typing import Any

import numpy as np

from gimcli.library.by_name import ByName, angles, by_member, pairs, places
from gimcli.library.result import Found, Result, RowsResult, UnderWay
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion, stream
from gimcli.positions.options import Options
from gimcli.progress import Notify, Progress
from gimcli.quantities.state import MotionState, State
from gimcli.rates.member_angles import LawAngles
from gimcli.structure.drive_check import require_consistent

POSES = 120
"""Largest number of positions that a picture chooses from."""


class Placed(Result):
    """A result whose rows are positions."""

    @property
    @abstractmethod
    def _z(self) -> ComplexArray:
        """The positions (nodes, rows) in the normal frame, NaN in rows without one."""

    @cached_property
    def xy(self) -> ByName:
        """Coordinates (rows, 2) of nodes and points in the file's length unit; NaN in rows not solved or reached."""
        return places(self.mechanism, self._z, pairs)

    @cached_property
    def angle(self) -> ByName:
        """Directions (rows,) of the members, from their first node to their second, in the file's angle unit."""
        return angles(self.mechanism, self._z, np.asarray)


class TraceResult(Placed, RowsResult):
    """A motion: `xy[name]` (rows, 2), `angle[member]` (rows,), `status` (rows,), `events`, and the columns by name."""

    KIND = ""

    @property
    def _motions(self) -> list[Motion]:
        """The motions whose rows follow each other; none if they were written to a file."""
        return self._found.motions  # type: ignore[no-any-return]  # `_found` is Any

    @property
    def rows(self) -> int:
        """The number of rows."""
        return sum(len(m.time) for m in self._motions)

    @property
    def solved(self) -> int:
        """The number of rows that are "ok"."""
        return sum(m.solved for m in self._motions)

    @property
    def complete(self) -> bool:
        """Whether all rows are solved."""
        return self.solved == self.rows

    @property
    def worst(self) -> float:
        """The largest residual of all rows, relative to the mechanism's size."""
        return float(np.nanmax([np.nanmax(m.residual) for m in self._motions]))

    @property
    @abstractmethod
    def points(self) -> dict[str, dict[str, Any]]:
        """For each traced point: ranges "x" and "y" of its coordinates in the solved rows, and the "curve".

        "closed" or "open"; "there and back": a closed motion on the same arc; "fixed": a point that does not move.
        Empty if no row is solved, or if several circuits were followed: `report()["circuits"]` has those of each.
        """

    @property
    @abstractmethod
    def events(self) -> list[dict[str, Any]]:
        """Events of the motion, such as limits and change points: kind, and the inputs."""

    @cached_property
    def angle(self) -> ByName:
        """Directions (rows,) of the members, from their first node to their second, in the file's angle unit.

        They are continuous: full turns are counted. Over rows without a position (`at_limit="skip"`), an angle changes
        by at most half a turn: full turns that the law makes there are not counted. NaN where a row is not solved.
        """
        return by_member(self.mechanism, self._turns)

    @cached_property
    def _state(self) -> State:
        """The rows of the motion, of which any quantity may be asked by its name."""
        whole = self._motions[0] if len(self._motions) == 1 else Motion.joined(self._motions)
        return MotionState(whole, lambda _, member: self._turns(member))

    @abstractmethod
    def _turns(self, member: int) -> FloatArray:
        """Return the directions of a member (rows,) in the file's angle unit, full turns counted."""

    def _poses(self, motion: Motion) -> ComplexArray:
        """Return positions (poses, nodes), evenly spread over the solved rows, in file units; a picture shows some."""
        good = np.flatnonzero(motion.good)
        chosen = good[np.unique(np.linspace(0, len(good), POSES, endpoint=False).astype(int))]
        return self.mechanism.to_file(motion.z[:, chosen].T)

    @cached_property
    def _z(self) -> ComplexArray:
        return np.concatenate([m.z for m in self._motions], axis=1)


class MotionUnderWay(UnderWay[Found]):
    """A result along the actuators' laws, of a motion that is being solved in pieces."""

    def __init__(
        self, mechanism: Mechanism, steps: int, options: Options, notify: Notify | None, progress: Progress,
        **form: Any,
    ) -> None:  # fmt: skip
        """Begin to solve the motion; `form` are further arguments of `stream`."""
        self.mechanism, self.steps, self.options, self.expected = mechanism, steps, options, steps + 1
        solve = partial(stream, mechanism, steps, options, **form)
        self.angles, self.motions = partial(LawAngles, mechanism, steps, solve), list[Motion]()
        self._pieces = solve(notify=notify, progress=progress)
        first = self._first = next(self._pieces)
        require_consistent(mechanism, first.start, first.inputs[:, 0], first.first_status, options.tolerance)

    def pieces(self) -> Iterator[Motion]:
        """Yield the pieces of the motion, once; they are kept if the result keeps its parts."""
        pieces, self._pieces = self._pieces, iter(())
        for piece in chain((self._first,), pieces):
            self.motions += [piece] * self.keeps
            yield piece
