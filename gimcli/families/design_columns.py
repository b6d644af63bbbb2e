"""Columns of many designs at once, from their positions: the same numbers as those of a trace of each design.

Columns of coordinates, inputs, angles, transmission angles, velocities, accelerations, jerks and forces are computed
for all designs together. Measures along the path, and forces that `DesignForces` refuses, such as those with dry
friction, are computed design by design, which takes some milliseconds each. Full turns of directions are counted as in
a trace (`rates.member_angles`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.canonical import TURN, counted, filled, phase
from gimcli.families.design_state import DesignState
from gimcli.families.designs import Designs
from gimcli.families.family import ONE, kernel_name, mode_of
from gimcli.families.four_bar_type import four_bar_types
from gimcli.families.quantity_text import SOLVED, TYPE, ColumnNames
from gimcli.language.arrays import strict
from gimcli.language.expression import Expression
from gimcli.mechanism import FRAME, FloatArray, IntArray
from gimcli.positions.dispatch import choose, plain
from gimcli.positions.inputs import divided, scales
from gimcli.quantities.catalogue import catalogue
from gimcli.quantities.quantity import Item
from gimcli.quantities.state import ApartError, MotionState, State
from gimcli.rates.member_angles import CLEAR, COUNTED, LawAngles, full_turn
from gimcli.status import Status

FINEST = 64
"""Largest number of parts of a step in which an angle is followed to count its turns."""


def counted_angles(solved: Designs, member: int) -> FloatArray:
    """Return the direction of a member (designs, rows) in the file's angle unit, full turns counted."""
    mechanism = solved.family.mechanism
    if member == FRAME:
        return np.where(np.isfinite(solved.z[:, 0]), 0.0, np.nan)
    found = np.full(solved.codes.shape, np.nan)
    if solved.compiled:
        found = _together(solved, member) * (full_turn(mechanism) / TURN)
    for k in np.flatnonzero(np.any(solved.good & ~np.isfinite(found), axis=1)).tolist():
        motion = solved.motion(k)
        if motion is not None:
            own = motion.mechanism
            found[k] = LawAngles(own, len(motion.time) - 1, solved.again(own))(motion, member)
    return found


def _together(solved: Designs, member: int) -> FloatArray:
    """Return the directions of a member [rad] with full turns counted, of all designs together.

    Rows between are solved where inputs move far from one row to the next, or the member turns far.
    """
    change = np.abs(np.diff(solved.inputs, axis=2)) / scales(solved.family.mechanism)[:, None]
    parts = min(int(np.ceil(np.max(change, initial=0.0) / COUNTED * (1.0 - 1e-12))) or 1, FINEST)
    found, wide = _counted(solved, member, parts)
    while len(wide) and parts < FINEST:
        parts = min(4 * parts, FINEST)
        finer, still = _counted(solved.chosen(wide), member, parts)
        found[wide], wide = finer, wide[still]
    return found


def _counted(solved: Designs, member: int, parts: int) -> tuple[FloatArray, IntArray]:
    """Return angles [rad], and the designs in which the member turns far from one row to the next.

    Each step is divided into `parts`, which are solved too if there are several. NaN for designs that miss some of
    these rows.
    """
    exact = angle = _direction(solved, member)
    if parts > 1:
        inputs = divided(solved.inputs, np.full(exact.shape[1] - 1, parts))
        angle = _direction(solved.solve(solved.designs, inputs=inputs), member)
        angle[:, ::parts] = np.where(np.isfinite(exact), exact, angle[:, ::parts])
    total = counted(angle)
    wide = np.flatnonzero(np.any(np.abs(np.diff(filled(total), axis=1)) > CLEAR, axis=1))
    found = np.where(np.isfinite(exact), total[:, ::parts], np.nan)
    found[_interrupted(angle, exact, parts)] = np.nan
    return found, wide


def _direction(solved: Designs, member: int) -> FloatArray:
    first, second = solved.family.mechanism.members[member].nodes[:2]
    return np.asarray(phase(solved.z[:, second] - solved.z[:, first]))


def _interrupted(angle: FloatArray, exact: FloatArray, parts: int) -> IntArray:
    """Return the designs of which a row between two solved rows is not solved."""
    rows = np.arange(exact.shape[1]) * parts
    known = np.isfinite(exact)
    first, last = np.where(known, rows, angle.shape[1]).min(axis=1), np.where(known, rows, -1).max(axis=1)
    every = np.arange(angle.shape[1])
    inside = (every >= first[:, None]) & (every <= last[:, None])
    return np.flatnonzero(np.any(inside & ~np.isfinite(angle), axis=1))


class DesignColumns(DesignState):
    """The columns of some designs along the laws; in dual numbers with the derivatives by the dimensions, or plain."""

    def __init__(
        self, solved: Designs, names: ColumnNames, outcome: IntArray | None = None, dual: bool = False
    ) -> None:  # fmt: skip
        """Take the designs; `outcome` (designs,) is a status to which those of quantities are added.

        Dual numbers raise ApartError where they are not possible, also later for a column.
        """
        self.solved, self.names, self.dual = solved, names, dual
        self.moving = moving = solved.with_slopes() if dual else solved
        family, mode = solved.family, solved.solve.keywords["jit"]  # compiled where the positions are
        run = choose(mode_of(family.plan, mode), ONE * len(solved.designs), None, (kernel_name(family.plan),))
        options = {"jit": "off" if run is plain else "on", "notify": solved.solve.keywords["notify"]}
        time = moving.time * moving.durations[:, None]
        used = (item for name in sorted(names.used) for item in names.find(name))
        super().__init__(family, solved.designs, moving.z, moving.tables, None, time, used, **options)
        self.inputs = moving.inputs
        self._columns: dict[str, Any] = {}
        self._angles: dict[int, Any] = {}
        self._failed = np.zeros(solved.codes.shape, dtype=np.int64)  # failures of what is computed one by one
        self.outcome = np.zeros(len(solved.designs), dtype=np.int64) if outcome is None else outcome

    def __getitem__(self, name: str) -> Any:
        """Return a column (designs, rows), or the columns of a measure (columns, designs, rows); NaN if not solved.

        All are in the file's units. A dimension or a word has one value for each design (designs, 1).
        """
        if name not in self._columns:
            self._columns[name] = self._new(name)
        return self._columns[name]

    def _new(self, name: str) -> Any:
        items = self.names.find(name)
        if items:
            with np.errstate(all="ignore"):
                found = [np.where(self.solved.good, self._column(item), np.nan) for item in items]
            return np.stack(found) if len(found) > 1 else found[0]
        if name in self.names.dimensions:
            return self.moving.designs[:, self.names.dimensions.index(name), None]
        if name == TYPE:
            return four_bar_types(self.mechanism, self.tables, self.solved.z[:, :, 0])[:, None]
        return (self.solved.solved.astype(float) if name == SOLVED else self.solved.reachable)[:, None]

    def of(self, own: Expression) -> Any:
        """Return the value of each design (designs,), or one for all; of a column (designs, rows); NaN if not defined.

        A condition is True only where all values that decide it are defined.
        """
        with np.errstate(all="ignore"):
            found = np.asarray(own.value(self, strict(self.lacks)))
            if own.kind.what == "rows":
                self.lacks(found)
            elif found.ndim:
                found = found[:, 0]
            if own.kind.what == "yes":
                return np.equal(found, 1.0)
            return np.where(np.isfinite(found), found, np.nan) if found.dtype.kind == "f" else found

    def at(self, actuator: str, value: float) -> DesignColumns | ColumnsAtRow:
        """Return the columns at the first position at which an input has a value [file's unit]."""
        k = [a.name for a in self.mechanism.actuators].index(actuator)
        solved, row = self.solved.at_input(k, self.mechanism.value_from_file(k, value))
        same = solved is self.solved
        return ColumnsAtRow(self if same else DesignColumns(solved, self.names, self.outcome, self.dual), row)

    @property
    def status(self) -> IntArray:
        """(designs,) status of the positions; if all are solved, of the rates and forces in rows of the quantities."""
        positions = self.solved.status
        return np.where((positions <= Status.TANGENT) & (self.outcome > 0), self.outcome, positions)

    def failures(self) -> IntArray:
        """Return the status of solved rows (designs, rows) whose rates or forces are not determined; 0 in others."""
        known = [np.isfinite(found).all(axis=(1, 2)) for found in self._rates or ()]
        known += [np.isfinite(found) for found in self._forces.values()]
        missing = self.solved.good & ~np.all([self.solved.good, *known], axis=0)
        return np.asarray(np.maximum(self._failed, missing * int(Status.SINGULAR)))

    def lacks(self, rows: Any) -> Any:
        """Return whether values (..., designs, rows) are missing in a row with a failure (..., designs, 1).

        The failures are added to the status of the designs.
        """
        missing = np.isnan(rows)
        if not missing.any():
            return missing[..., :1]
        failed = missing * self.failures()
        np.maximum(self.outcome, failed.reshape(-1, *failed.shape[-2:]).max(axis=(0, 2)), out=self.outcome)
        return np.any(failed, axis=-1, keepdims=True)

    def _column(self, item: Item) -> Any:
        """Return a column of all designs together where that is possible, else of one design after the other."""
        try:
            return np.broadcast_to(self.value(*item), self.solved.codes.shape)
        except ApartError:
            if self.dual:
                raise
            return self._one_by_one(item.head.name)

    # -- the state ---------------------------------------------------------------------------------------

    first = State.first

    def input_rates(self, order: int) -> Any:
        """Return the inputs and their derivatives by the real time up to an order, from the laws."""
        return self.moving.input_rates(order)

    def counted(self, member: int) -> Any:
        """Return the direction of a member (designs, rows) in the file's angle unit, full turns counted."""
        if member not in self._angles:
            self._angles[member] = counted_angles(self.solved, member)
            if self.dual and member != FRAME:
                first, second = (self.node(node) for node in self.mechanism.members[member].nodes[:2])
                slopes = np.angle(second - first).slopes * (full_turn(self.mechanism) / TURN)
                self._angles[member] = Dual(self._angles[member], slopes)
        return self._angles[member]

    def row(self, name: str) -> Any:
        """Return the step, the time [s], the residual, or an input (designs or 1, rows)."""
        if name == "residual":
            return self.solved.residual
        return self.solved.time * (self.solved.codes.shape[1] - 1) if name == "step" else super().row(name)

    def _one_by_one(self, name: str) -> FloatArray:
        """Return a column that is computed for one design after the other."""
        found: FloatArray = np.full(self.solved.codes.shape, np.nan)
        for k in np.flatnonzero(np.any(self.solved.good, axis=1)).tolist():
            motion = self.solved.motion(k)
            item = None if motion is None else catalogue(motion.mechanism).column(name)
            if motion is not None and item is not None:  # without friction there is no power of it
                state = MotionState(motion, lambda _, member, k=k: self.counted(member)[k])
                found[k] = state.value(*item)
                self._failed[k] = np.maximum(self._failed[k], state.failures())
        return found


class ColumnsAtRow:
    """The columns at one row of each design; NaN for rows below 0."""

    def __init__(self, columns: DesignColumns, row: IntArray) -> None:
        self._columns, self._row = columns, row

    def __getitem__(self, name: str) -> Any:
        """Return a column (designs, 1), the columns of a measure (columns, designs, 1), or a number (designs, 1)."""
        values = self._columns[name]
        if self._columns.names.kind(name).what != "rows":
            return values
        self._columns.lacks(np.where(np.arange(values.shape[-1]) == self._row[:, None], values, 0.0))
        places = np.broadcast_to(np.maximum(self._row, 0)[:, None], (*values.shape[:-1], 1))
        return np.where(self._row[:, None] >= 0, np.take_along_axis(values, places, -1), np.nan)

    def at(self, actuator: str, value: float) -> DesignColumns | ColumnsAtRow:
        """Return the columns at another value."""
        return self._columns.at(actuator, value)
