"""Positions at which an input has a given value, of many designs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gimcli.mechanism import FloatArray, IntArray

if TYPE_CHECKING:
    from gimcli.families.design_columns import ColumnsAtRow, DesignColumns

EXACT = 1e-9
"""Share of a step within which a row has the value."""


def columns_at(columns: DesignColumns, actuator: int, value: float) -> ColumnsAtRow:
    """Return the columns where an input first has a value [normal frame].

    If the value lies between two rows, the position there is solved from the row before: the second row is moved there.
    """
    from gimcli.families.design_columns import ColumnsAtRow

    inputs = columns.solved.inputs
    row, share = first_crossing(inputs[:, actuator], value)
    count = len(columns.designs)
    row, share = np.broadcast_to(row, count), np.broadcast_to(share, count)
    on_row = (row < 0) | (np.minimum(share, 1.0 - share) <= EXACT)
    nearest = np.where(row < 0, -1, row + (share > 0.5))
    if on_row.all():
        return ColumnsAtRow(columns, nearest)
    moved = np.broadcast_to(inputs, (count, *inputs.shape[1:])).copy()
    time = np.broadcast_to(columns.time, (count, columns.time.shape[1])).copy()
    for k in np.flatnonzero(~on_row).tolist():
        at = row[k]
        moved[k, :, at + 1] = moved[k, :, at] + share[k] * (moved[k, :, at + 1] - moved[k, :, at])
        moved[k, actuator, at + 1] = value
        time[k, at + 1] = time[k, at] + share[k] * (time[k, at + 1] - time[k, at])
    return ColumnsAtRow(columns.with_inputs(moved, time), np.where(on_row, nearest, row + 1))


def first_crossing(values: FloatArray, value: float) -> tuple[IntArray, FloatArray]:
    """Return the step in which values (designs, rows) first reach a value, -1 if none, and the share of the step."""
    first, second = values[:, :-1] - value, values[:, 1:] - value
    reach = EXACT * np.abs(second - first)
    inside = (np.minimum(first, second) <= reach) & (np.maximum(first, second) >= -reach) & (first != second)
    row = np.where(inside.any(axis=1), inside.argmax(axis=1), -1)
    one, two = (np.take_along_axis(part, np.maximum(row, 0)[:, None], axis=1)[:, 0] for part in (first, second))
    with np.errstate(all="ignore"):
        return row, np.clip(np.where(one == two, 0.0, one / (one - two)), 0.0, 1.0)
