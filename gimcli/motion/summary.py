"""Summary of a motion that is solved in pieces: counts, and enough rows for a picture."""

from __future__ import annotations

import math

import numpy as np

from gimcli.mechanism import IntArray
from gimcli.motion.motion import Motion

DRAWN = 4096
"""Approximate number of rows kept, greater than the resolution of a picture."""


class Summary:
    """Counts of a motion of `rows` rows, and a motion with some of these rows."""

    def __init__(self, rows: int) -> None:
        self.rows = rows
        self.seen = 0
        self.solved = 0
        self.each: list[int] = []  # solved rows of each independent machine
        self.residual = math.nan  # greatest residual of the solved rows
        self._every = -(-rows // DRAWN)
        self._pieces: list[Motion] = []
        self._bad = False

    def add(self, piece: Motion) -> IntArray:
        """Add the next piece; return which of its rows are kept."""
        keep = (self.seen + np.arange(len(piece.time))) % self._every == 0
        keep[-1] = True
        bad, good = np.flatnonzero(~piece.good), np.flatnonzero(piece.good)
        if len(bad) and not self._bad:  # the first failed row, and the one before it
            keep[bad[0]] = keep[max(0, bad[0] - 1)] = self._bad = True
        if len(good):
            keep[good[-1]] = True
            self.residual = float(np.fmax(self.residual, np.max(piece.residual[good])))
        self.solved += len(good)
        own = [part.solved for part in piece.machines]
        self.each = [done + more for done, more in zip(self.each or [0] * len(own), own, strict=True)]
        self.seen += len(piece.time)
        self._pieces.append(piece if keep.all() else piece.rows(np.flatnonzero(keep)))
        return np.flatnonzero(keep)

    @property
    def motion(self) -> Motion:
        """The kept rows as one motion, with all events."""
        return Motion.joined(self._pieces)
