"""The table of a motion, or of a piece of it: quantities over its rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.mechanism import FRAME, Mechanism
from gimcli.motion.motion import Motion
from gimcli.motion.summary import first_columns, status_column
from gimcli.quantities.coordinates import MemberTurning, PointVector
from gimcli.quantities.quantity import Quantity
from gimcli.quantities.state import MotionState
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
