"""What the results of motions have in common: places, angles and statuses of their rows."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.library.places import angles, pairs, places
from gimcli.library.result import ByName, RowsResult
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.motion.motion import Motion

POSES = 6
"""Positions that a picture shows."""


class TraceResult(RowsResult):
    """Rows of a motion: `xy[name]` (rows, 2), `angle[member]`, `status`, `events`, and columns by their names."""

    KIND = ""

    motions: Sequence[Motion]

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return sum(len(m.time) for m in self.motions)

    @property
    def solved(self) -> int:
        """How many of them are ok."""
        return sum(m.solved for m in self.motions)

    @property
    def complete(self) -> bool:
        """Tell whether all are."""
        return self.solved == self.rows

    @property
    def worst(self) -> float:
        """The greatest residual, relative to the mechanism's size."""
        return float(np.nanmax([np.nanmax(m.residual) for m in self.motions]))

    @property
    @abstractmethod
    def events(self) -> list[dict[str, Any]]:
        """What happens on the way: kind, and the inputs there."""

    @cached_property
    def xy(self) -> ByName:
        """Places (rows, 2) of nodes and points in the file's length unit; NaN where a row is not solved."""
        return places(self.mechanism, self._z, pairs)

    @cached_property
    def angle(self) -> ByName:
        """Directions (rows,) of the members, from their first node to their second, counted through turns."""
        each = angles(self.mechanism, self._z, lambda a: a)
        return ByName(
            tuple(each), lambda name: self.turns(lambda z: angles(self.mechanism, z, lambda a: np.asarray(a))[name])
        )

    @abstractmethod
    def turns(self, member: Callable[[ComplexArray], FloatArray]) -> FloatArray:
        """Return the angles of a member (rows,) counted through turns."""

    def poses(self, motion: Motion) -> ComplexArray:
        """Return some positions (poses, nodes) for a picture, evenly spread over the solved ones, in file units."""
        good = np.flatnonzero(motion.good)
        chosen = good[np.unique(np.linspace(0, len(good), POSES, endpoint=False).astype(int))]
        return self.mechanism.to_file(motion.z[:, chosen].T)

    @cached_property
    def _z(self) -> ComplexArray:
        return np.concatenate([m.z for m in self.motions], axis=1)
