"""Inverse dynamics of a motion in pieces: the forces of each piece, their table, and a summary of all pieces.

Work of the actuators, and of every kind of force, over a motion; positive and negative parts apart.

Integrals over the time of quantities in equal time steps, from rows in pieces.

Each step is integrated by the cubic through its ends and the rows beside them (weights -1, 13, 13, -1 by 24), beside a
missing row by the parabola through three rows, between missing rows by the trapezoidal rule. Where the motion is
closed, the rows beside the ends are those at the other end: the sum is then the trapezoidal rule over a period, which
is exact to rounding for smooth quantities with enough rows. Where a quantity changes its sign, its positive part is
that of the line through the ends of the step. Source: Davis & Rabinowitz, Methods of Numerical Integration, 1984,
sections 2.9 (periodic integrands) and 2.3.

The mean load of a bearing is the constant load with the same fatigue life. Lives are L = (C / P)^p revolutions, p = 3
for ball and 10/3 for roller bearings (ISO 281:2007), and shares of the life are added (Palmgren 1924, Miner 1945). So a
load F(t) in a pin that turns at the relative speed w(t) is equivalent to

    P = (integral of |F|^p |w| dt / integral of |w| dt)^(1/p)

This is the mean load of the catalogues (such as SKF, Rolling bearings, 2018, section B.3), with the direction of the
load left out: radial bearings without axial load, P = F.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gimcli.dynamics.force_columns import SHARED, columns_of, reaction_name, reactions, rotors, totals
from gimcli.dynamics.forces import Forces, piece_forces
from gimcli.dynamics.kinematic_history import Courses, Turns, turning
from gimcli.dynamics.statics import Statics, statics
from gimcli.mechanism import BoolArray, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.motion.summary import Summary, first_columns, status_column
from gimcli.positions.dispatch import choose, plain
from gimcli.progress import Notify
from gimcli.status import Status
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.dynamics.efficiency import FrictionSummary


UNDETERMINED = (
    "singular: at a singular position or a dead point of the drive, velocities or reactions are not determined"
    " or grow without bound; change the law or the number of steps"
)
"""Message for rows without forces."""

EACH = 2.5e-7
"""Approximate time of one term of the equations without compilation [s]."""

SHOWN = 5
"""Rows that are left out whose inputs are reported."""


class ForceMotion:
    """Computes the forces of the pieces of a motion, one after the other."""

    def __init__(self, mechanism: Mechanism, rows: int, jit: str = "auto", notify: Notify | None = None):
        self.statics: Statics = statics(mechanism)
        work = EACH * rows * sum(map(len, self.statics.columns))
        self.run = plain if self.statics.surplus else choose(jit, work, notify, ("play",))
        self.courses, self.turns = Courses(mechanism, rows, jit, notify), Turns()
        self.summary = Summary(rows)
        self.power = self.error = 0.0  # greatest absolute power of any kind, and error of the power balance, W
        self.left_out = 0  # rows whose forces have too great an estimated error
        self.left_out_at: list[FloatArray] = []  # inputs (actuators,) of the first `SHOWN` of these rows
        self.determined = 0  # rows with determined forces
        self.friction: FrictionSummary | None = None  # of a mechanism with dry friction
        self.open: list[str] = []  # names of reactions that are indeterminate because of redundant constraints
        self.rows: IntArray = np.zeros(0, dtype=np.int64)  # of the last piece, that are drawn

    def take(self, piece: Motion) -> Forces:
        """Return the forces of the next piece."""
        forces = piece_forces(self.statics, self.courses, piece, self.run, self.turns)
        self.rows = self.summary.add(piece)
        if forces.dry is not None:
            from gimcli.dynamics.efficiency import FrictionSummary  # imported late: only for models with dry friction

            self.friction = self.friction or FrictionSummary(self.statics.mechanism)
            self.friction.add(piece, forces, forces.dry)
        left_out = np.flatnonzero(forces.good & ~forces.bounded)
        self.left_out += len(left_out)
        self.left_out_at += list(forces.course.inputs[:, left_out[: SHOWN - len(self.left_out_at)]].T)
        kinds = [forces.drive_power, forces.loads.kinetic_rate, *forces.loads.power.values()]
        self.power = max([self.power, *(float(np.nanmax(np.abs(p[forces.good]), initial=0.0)) for p in kinds)])
        self.error = max(self.error, float(np.nanmax(np.abs(forces.power_error[forces.good]), initial=0.0)))
        self.determined += int(determined_rows(piece, forces).sum())
        self.open = self.open or open_reactions(forces)
        return forces

    @property
    def drift(self) -> float:
        """The greatest error of the power balance relative to the greatest power."""
        return self.error / self.power if self.power else 0.0

    @property
    def failure(self) -> tuple[str, str]:
        """The word and the message for rows of a solved motion that have no forces."""
        worst = None if self.friction is None else self.friction.failure
        return ("singular", UNDETERMINED) if worst is None else (worst.word, f"{worst.word}: {worst.text}")


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


def failures(motion: Motion, forces: Forces) -> IntArray:
    """Return the status (rows,) of solved rows whose forces are not determined, 0 in others."""
    missing = motion.good & ~determined_rows(motion, forces)
    if forces.dry is None:
        return np.where(missing, int(Status.SINGULAR), 0)
    from gimcli.dynamics.coulomb_solver import FrictionStatus

    own = np.array([int(code.status) for code in FrictionStatus])[forces.dry.codes]
    return np.where(missing, np.where(own > 0, own, int(Status.SINGULAR)), 0)


def open_reactions(forces: Forces) -> list[str]:
    """Return the names of the reactions that are indeterminate in every row because of redundant constraints."""
    good = forces.good
    if not forces.statics.surplus or not good.any():
        return []
    own = columns_of(forces, reactions(forces.statics))
    names = [column.name.rsplit(".", 1)[0] for column in own if np.all(np.isnan(column.values[good]))]
    return [name for name in dict.fromkeys(names) if not name.endswith(f".{SHARED}")]


BESIDE = 3
"""Rows that are kept from piece to piece."""


WEIGHTS = np.array([-1.0, 12.0, 25.0]) / 24.0
"""Weights of the first rows, and reversed of the last ones, of a sum of inner steps; those between are 1."""

NOTHING = 1e-12
"""Value that is a rounding error of 0, relative to the greatest of the rows beside it."""


class RowIntegrals:
    """Integrals of quantities (quantities, rows) that come in pieces; NaN: the row is missing.

    The positive parts of the last `signed` quantities are integrated, too.
    """

    def __init__(self, quantities: int, signed: int = 0) -> None:
        self.net, self.steps = np.zeros((2, quantities))  # by the time step; number of steps covered
        self.positive = np.zeros(signed)
        self._unsigned = quantities - signed
        self._first = self._last = np.zeros((quantities, 0))

    def add(self, values: FloatArray) -> None:
        """Add the next rows (quantities, rows)."""
        if self._first.shape[1] < BESIDE:
            self._first = np.concatenate([self._first, values[:, :BESIDE]], axis=1)[:, :BESIDE]
        rows = np.concatenate([self._last, values], axis=1)
        self._last = rows[:, -BESIDE:]
        if rows.shape[1] < 2 * BESIDE:
            self._count(rows[:, :-3], rows[:, 1:-2], rows[:, 2:-1], rows[:, 3:], np.arange(len(rows)))
            return
        weights = np.ones(rows.shape[1])
        weights[:BESIDE], weights[-BESIDE:] = WEIGHTS, WEIGHTS[::-1]
        net = rows @ weights
        low, high = rows[:, 1:-1].min(axis=1), rows[:, 1:-1].max(axis=1)
        one_sign = ~((low < 0.0) & (high > 0.0))
        one_sign[: self._unsigned] = True
        simple = np.isfinite(net) & one_sign
        self.net += np.where(simple, net, 0.0)
        self.steps += np.where(simple, rows.shape[1] - 3, 0)
        self.positive += np.where(simple & (high > 0.0), net, 0.0)[self._unsigned :]
        own = np.flatnonzero(~simple)
        if len(own):
            other = rows[own]
            self._count(other[:, :-3], other[:, 1:-2], other[:, 2:-1], other[:, 3:], own)

    def finish(self, closed: bool) -> None:
        """Add the first and the last step; `closed`: the last row repeats the first one."""
        first, last = self._first, self._last
        if last.shape[1] < 2:
            return
        gap, own = np.full((len(last), 1), np.nan), np.arange(len(last))
        several = last.shape[1] > 2
        wraps = closed and several
        after = first[:, 2:3] if several else gap
        self._count(last[:, -2:-1] if wraps else gap, first[:, :1], first[:, 1:2], after, own)
        if several:
            self._count(last[:, -3:-2], last[:, -2:-1], last[:, -1:], first[:, 1:2] if wraps else gap, own)

    def _count(self, before: FloatArray, start: FloatArray, end: FloatArray, after: FloatArray, own: IntArray) -> None:
        """Add steps between rows `start` and `end` (quantities, steps) to the quantities `own`."""
        known = np.isfinite(start) & np.isfinite(end)
        left, right = np.isfinite(before), np.isfinite(after)
        with np.errstate(invalid="ignore", divide="ignore"):
            whole = np.select(
                [left & right, right, left],
                [(13.0 * (start + end) - before - after) / 24.0, (5.0 * start + 8.0 * end - after) / 12.0,
                 (8.0 * start + 5.0 * end - before) / 12.0],
                0.5 * (start + end),
            )  # fmt: skip
            top, bottom = np.maximum(start, end), np.minimum(start, end)
            above = np.where(bottom < 0.0, 0.5 * top**2 / (top - bottom), whole)
        self.net[own] += np.sum(np.where(known, whole, 0.0), axis=1)
        self.steps[own] += np.sum(known, axis=1)
        signed, least = own >= self._unsigned, NOTHING * np.fmax.reduce(np.abs([before, start, end, after]))
        positive = np.sum(np.where(known & (top > least), above, 0.0), axis=1)
        self.positive[own[signed] - self._unsigned] += positive[signed]


@dataclass(frozen=True)
class Work:
    """Work [J] over the determined rows: while the power is positive, and while it is negative."""

    positive: float
    negative: float

    @property
    def net(self) -> float:
        """The sum of both."""
        return self.positive + self.negative


def powers(forces: Forces) -> dict[str, FloatArray]:
    """Return the power [W] of each actuator, and of each kind of force (rows,); NaN without determined forces."""
    efforts = {f"{a.name}.effort": forces.power(k) for k, a in enumerate(forces.mechanism.actuators)}
    return {name: np.where(forces.good, power, np.nan) for name, power in {**efforts, **forces.loads.power}.items()}


BALL, ROLLER = 3.0, 10.0 / 3.0
"""Exponents of the life of ball and roller bearings."""

TURNING = 1e-9
"""Turns in the whole motion above which a pair turns."""


@dataclass(frozen=True)
class BearingLoad:
    """The mean load of one pin; NaN where the pair does not turn or its reaction is not determined."""

    speed: float  # rev/min, mean of the magnitude of the relative speed
    turns: float  # in both directions together
    ball: float  # N, mean load with p = 3
    roller: float  # N, with p = 10/3


def bearing_load(turned: FloatArray, step: float) -> BearingLoad:
    """Return the mean load from the integrals and the number of steps (4,) of `turning_pins`; step [s]."""
    angle, ball, roller, steps = turned.tolist()
    turns = angle * step / (2.0 * math.pi)
    speed = 60.0 * turns / (steps * step) if steps else math.nan
    if not turns > TURNING:
        return BearingLoad(speed, turns, math.nan, math.nan)
    return BearingLoad(speed, turns, (ball / angle) ** (1.0 / BALL), (roller / angle) ** (1.0 / ROLLER))


def turning_pins(forces: Forces) -> dict[str, FloatArray]:
    """Return the relative speed, and its products with powers of the force (3, rows), by the names of the reactions.

    Rows next to singular positions are left out.
    """
    statics, course, found = forces.statics, forces.course, dict[str, FloatArray]()
    for pin, member in ((one, member) for one in statics.pins for member in one.members[1:]):
        first, own = (turning(statics.mechanism, course, k)[0] for k in (pin.members[0], member))
        force = np.abs(forces.pin(pin, member))
        every = (own - first) * np.array([np.ones_like(force), force**BALL, force**ROLLER])
        found[reaction_name(statics, pin, member)] = np.where(forces.bounded & np.isfinite(force), every, np.nan)
    return found
