"""Inverse dynamics of a motion in pieces: the forces of each piece, their table, and a summary of all pieces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gimcli.dynamics.force_columns import SHARED, columns_of, reactions, rotors, totals
from gimcli.dynamics.forces import Forces, piece_forces
from gimcli.dynamics.kinematic_history import Courses, Turns
from gimcli.dynamics.statics import Statics, statics
from gimcli.mechanism import BoolArray, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.motion.summary import Summary, first_columns, status_column
from gimcli.positions.dispatch import choose, plain
from gimcli.progress import Notify
from gimcli.status import Status
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.dynamics.coulomb import DryFriction
    from gimcli.dynamics.efficiency import FrictionSummary

UNDETERMINED = (
    "singular: at a singular position or a dead point of the drive, velocities or reactions are not determined"
    " or grow without bound; change the law or the number of steps"
)
"""Message for rows without forces."""

EACH = 2.5e-6
"""Approximate time of one term of the equations without compilation [s]."""

SHOWN = 5
"""Rows that are left out whose inputs are reported."""


class ForceMotion:
    """Computes the forces of the pieces of a motion, one after the other."""

    def __init__(self, mechanism: Mechanism, rows: int, jit: str = "auto", notify: Notify | None = None):
        self.statics: Statics = statics(mechanism)
        work = EACH * rows * sum(map(len, self.statics.columns))
        self.run = plain if self.statics.surplus else choose(jit, work, notify, ("balance_rows",))
        self.courses, self.turns = Courses(mechanism, rows, jit, notify), Turns()
        self.summary, self.balance = Summary(rows), PowerBalance()
        self.determined = 0  # rows with determined forces
        self.friction: FrictionSummary | None = None  # of a mechanism with dry friction
        self.open: list[str] = []  # names of reactions that are indeterminate because of redundant constraints
        self.rows: IntArray = np.zeros(0, dtype=np.int64)  # of the last piece, that are drawn

    def take(self, piece: Motion) -> Forces:
        """Return the forces of the next piece."""
        forces = piece_forces(self.statics, self.courses, piece, self.run, self.turns)
        self.rows = self.summary.add(piece)
        if forces.dry is not None:
            self._rub(piece, forces, forces.dry)
        self.balance.add(forces)
        self.determined += int(determined_rows(piece, forces).sum())
        self.open = self.open or open_reactions(forces)
        return forces

    def _rub(self, piece: Motion, forces: Forces, dry: DryFriction) -> None:
        """Add a piece to the summary of dry friction."""
        from gimcli.dynamics.efficiency import FrictionSummary  # imported late: only for models with dry friction

        self.friction = self.friction or FrictionSummary(self.statics.mechanism)
        self.friction.add(piece, forces, dry)

    @property
    def failure(self) -> tuple[str, str]:
        """The word and the message for rows of a solved motion that have no forces."""
        worst = None if self.friction is None else self.friction.failure
        return ("singular", UNDETERMINED) if worst is None else (worst.word, f"{worst.word}: {worst.text}")


class PowerBalance:
    """The greatest power-balance error, and the number of rows next to singular positions."""

    def __init__(self) -> None:
        self.power = 0.0  # greatest absolute power of any kind, W
        self.error = 0.0  # greatest absolute error of the power balance, W
        self.left_out = 0  # rows whose forces have too great an estimated error
        self.left_out_at: list[FloatArray] = []  # inputs (actuators,) of the first `SHOWN` of these rows

    def add(self, forces: Forces) -> None:
        """Add the next rows."""
        rows = np.flatnonzero(forces.good & ~forces.bounded)
        self.left_out += len(rows)
        self.left_out_at += list(forces.course.inputs[:, rows[: SHOWN - len(self.left_out_at)]].T)
        kinds = [forces.drive_power, forces.loads.kinetic_rate, *forces.loads.power.values()]
        self.power = max([self.power, *(float(np.nanmax(np.abs(p[forces.good]), initial=0.0)) for p in kinds)])
        self.error = max(self.error, float(np.nanmax(np.abs(forces.power_error[forces.good]), initial=0.0)))

    @property
    def drift(self) -> float:
        """The greatest error relative to the greatest power."""
        return self.error / self.power if self.power else 0.0


def force_table(motion: Motion, forces: Forces, first: int = 0) -> Table:
    """Return one row per step: time, inputs, efforts, reactions, shaking force, power, energy, rotors, status."""
    columns = columns_of(forces, [*reactions(forces.statics), *totals(forces.statics)])
    singular = motion.good & ~forces.good  # velocities or reactions are not determined
    status = status_column(np.where(singular, int(Status.SINGULAR), motion.codes))
    if forces.dry is not None:
        from gimcli.dynamics.efficiency import friction_columns, with_friction_words

        columns += friction_columns(forces, forces.dry)
        status = with_friction_words(status, forces.dry)
    columns += columns_of(forces, rotors(forces.statics))
    return Table((*first_columns(motion, first), *columns, Column("residual", motion.residual), status))


def determined_rows(motion: Motion, forces: Forces) -> BoolArray:
    """Return for every row whether its forces are determined, or at a standstill given by their limits."""
    given = forces.good if forces.dry is None else forces.good | forces.dry.standstill
    return np.asarray(motion.good & given)


def open_reactions(forces: Forces) -> list[str]:
    """Return the names of the reactions that are indeterminate in every row because of redundant constraints."""
    good = forces.good
    if not forces.statics.surplus or not good.any():
        return []
    own = columns_of(forces, reactions(forces.statics))
    names = [column.name.rsplit(".", 1)[0] for column in own if np.all(np.isnan(column.values[good]))]
    return [name for name in dict.fromkeys(names) if not name.endswith(f".{SHARED}")]
