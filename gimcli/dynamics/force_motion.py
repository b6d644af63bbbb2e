"""Inverse dynamics of a motion in pieces: the forces of each piece, and a summary of all pieces."""

from __future__ import annotations

import numpy as np

from gimcli.dynamics.force_table import Peaks, determined_rows, open_reactions
from gimcli.dynamics.forces import Forces, inverse_dynamics
from gimcli.dynamics.kinematic_history import Courses, Turns
from gimcli.dynamics.statics import Statics, statics
from gimcli.mechanism import IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.motion.summary import Summary
from gimcli.positions.dispatch import choose, plain
from gimcli.progress import Notify

EACH = 2.5e-6
"""Approximate time of one term of the equations without compilation [s]."""


class ForceMotion:
    """Computes the forces of the pieces of a motion, one after the other."""

    def __init__(self, mechanism: Mechanism, rows: int, jit: str = "auto", notify: Notify | None = None):
        self.statics: Statics = statics(mechanism)
        work = EACH * rows * sum(map(len, self.statics.columns))
        self.run = plain if self.statics.surplus else choose(jit, work, notify, ("balance_rows",))
        self.courses, self.turns = Courses(mechanism, rows, jit, notify), Turns()
        self.summary, self.peaks = Summary(rows), Peaks(mechanism)
        self.determined = 0  # rows with determined forces
        self.open: list[str] = []  # names of reactions that are indeterminate because of redundant constraints
        self.rows: IntArray = np.zeros(0, dtype=np.int64)  # of the last piece, that are drawn

    def take(self, piece: Motion) -> Forces:
        """Return the forces of the next piece."""
        forces = inverse_dynamics(self.statics, self.courses(piece), self.run, self.turns)
        self.rows = self.summary.add(piece)
        self.peaks.add(piece, forces)
        self.determined += int(determined_rows(piece, forces).sum())
        self.open = self.open or open_reactions(forces)
        return forces
