"""The table of a motion or of a piece of it, ranges of quantities over the pieces, abscissa and events of graphs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.motion.summary import first_columns, occurrences, status_column
from gimcli.quantities.coordinates import MemberTurning, PointVector
from gimcli.quantities.quantity import ColumnRange, Quantity
from gimcli.quantities.state import MotionState, derivatives_of
from gimcli.table import Column, Table


def usual(
    mechanism: Mechanism, names: Sequence[str] | None = None, order: int = 0, members: Sequence[int] = ()
) -> list[Quantity]:
    """Return the coordinates of points, by default of the traced ones, and their derivatives up to an order.

    With derivatives also the directions of all members with theirs, without only the directions of `members`.
    """
    points = mechanism.traced if names is None else names
    found: list[Quantity] = [PointVector(mechanism, name, 0) for name in points]
    found += [PointVector(mechanism, name, k) for name in points for k in range(1, order + 1)]
    if not order:
        return [*found, *(MemberTurning(mechanism, member, 0) for member in members)]
    every = range(FRAME + 1, len(mechanism.members))
    return [*found, *(MemberTurning(mechanism, member, k) for member in every for k in range(order + 1))]


def motion_table(
    motion: Motion, quantities: Sequence[Quantity] | None = None, first: int = 0, state: MotionState | None = None,
    blank: bool = False,
) -> Table:  # fmt: skip
    """Return one row per step, numbered from `first`: time, inputs, quantities, residual, sweeps, status.

    `state` is that of the motion, if it has more than its positions; by default the traced points are the quantities.
    `blank`: quantities are not computed, only named.
    """
    state = state or MotionState(motion)
    columns = first_columns(motion, first)
    for one in usual(motion.mechanism) if quantities is None else quantities:
        nothing = np.full(len(motion.time), np.nan) if blank else None
        columns += [
            Column(h.name, state.value(one, k) if nothing is None else nothing, h.unit) for k, h in enumerate(one.heads)
        ]
    last = Column("residual", motion.residual), Column("sweeps", motion.work.astype(np.int64))
    own = [status_column(part.codes, f"{part.mechanism.as_machine.name}.status") for part in motion.parts]
    return Table((*columns, *last, status_column(motion.codes), *own))


POINT_QUANTITIES = {"velocity": "v", "acceleration": "a", "jerk": "j"}
"""Magnitudes of the points' derivatives: letter of their columns."""

MEMBER_QUANTITIES = ("angle", "omega", "alpha")
"""Direction, angular velocity and acceleration of the members."""


def abscissa(motion: Motion) -> Column:
    """Return the abscissa of graphs of a motion; for a circuit the fraction of its length."""
    if motion.headings is not None:
        return Column("part of the length", motion.time)
    return input_or_time(motion.mechanism, motion.time, motion.inputs)


def input_or_time(mechanism: Mechanism, time: FloatArray, inputs: FloatArray) -> Column:
    """Return the only independent input of `inputs` (actuators, rows) if it is monotonic, else the time [s]."""
    if len(mechanism.drivers) == 1:
        (k,) = mechanism.drivers
        steps = np.diff(inputs[k])
        if np.all(steps > 0.0) or np.all(steps < 0.0):
            actuator = mechanism.actuators[k]
            return Column(actuator.name, mechanism.value_to_file(k, inputs[k]), mechanism.unit_of(actuator))
    return Column("time", time * mechanism.duration, "s")


def motion_events(motion: Motion) -> list[tuple[str, Mapping[str, float]]]:
    """Return limits and change points of a motion along its laws, with the time and the inputs there."""
    mechanism = motion.mechanism
    return [
        (kind, {"time": time * mechanism.duration, **mechanism.inputs_to_file(at)})
        for kind, time, at in occurrences(replace(motion, exchanged=()))
    ]


class Record:
    """Requested quantities, and their ranges over the pieces so far."""

    def __init__(self, measures: Sequence[Quantity]) -> None:
        self.measures = tuple(measures)
        self.ranges = {head.name: ColumnRange() for measure in measures for head in measure.heads}
        self.memory: dict[str, Any] = {}

    def add(self, state: MotionState) -> None:
        """Add the next piece of a motion."""
        for measure in self.measures:
            for k, head in enumerate(measure.heads):
                self.ranges[head.name].add(state.value(measure, k), state.motion.good)

    def curves(self, motion: Motion) -> dict[str, ComplexArray]:
        """Return the curves that the measures add to a drawing of a motion."""
        derivatives = derivatives_of(motion)
        return {name: curve for measure in self.measures for name, curve in measure.curves(derivatives).items()}

    def outlines(self, motion: Motion) -> list[ComplexArray]:
        """Return the areas that the measures add to a drawing of a motion."""
        derivatives = derivatives_of(motion)
        return [outline for measure in self.measures for outline in measure.outlines(derivatives)]

    def results(self, state: MotionState) -> dict[str, dict[str, Any]]:
        """Return ranges and results of the measures for the whole motion, of which `state` has some rows."""
        report = {}
        for measure in self.measures:
            columns = {head.name: {"unit": head.unit, **asdict(self.ranges[head.name])} for head in measure.heads}
            report[measure.spec] = {"columns": columns, **measure.whole(state, self.ranges)}
        return report
