"""Graphs of quantities over a motion: their curves and their abscissa."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.measures.measure import Head
from gimcli.mechanism import FRAME, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.table import Column, Table

POINT_QUANTITIES = {"velocity": ("v", 1), "acceleration": ("a", 2), "jerk": ("j", 3)}
"""Magnitudes of the traced points' derivatives: letter of their columns, and order."""

MEMBER_QUANTITIES = {"omega": 1, "alpha": 2}
"""Angular velocity and acceleration of the members, and order."""

ORDERS = {name: order for name, (_, order) in POINT_QUANTITIES.items()} | MEMBER_QUANTITIES


def abscissa(motion: Motion) -> Column:
    """Return the abscissa of graphs of a motion; for a circuit the fraction of its length."""
    if motion.headings is not None:
        return Column("part of the length", motion.time)
    return input_or_time(motion.mechanism, motion.time, motion.inputs)


def input_or_time(mechanism: Mechanism, time: FloatArray, inputs: FloatArray) -> Column:
    """Return the input if there is only one in `inputs` (actuators, rows) and it is monotonic, else the time [s]."""
    if len(mechanism.actuators) == 1:
        steps = np.diff(inputs[0])
        if np.all(steps > 0.0) or np.all(steps < 0.0):
            actuator = mechanism.actuators[0]
            unit = mechanism.unit_of(actuator)
            return Column(actuator.name, mechanism.value_to_file(0, inputs[0]), unit)
    return Column("time", time * mechanism.duration, "s")


def quantity(mechanism: Mechanism, table: Table, name: str) -> list[Column]:
    """Return the curves of a quantity: of all traced points, or of all moving members."""
    columns = {column.name: column for column in table.columns}
    if name in MEMBER_QUANTITIES:
        found = [(m.name, columns[f"{m.name}.{name}"]) for m in mechanism.members[FRAME + 1 :]]
        return [Column(label, column.values, column.unit) for label, column in found]
    letter, _ = POINT_QUANTITIES[name]
    curves = []
    for point in mechanism.traced:
        x, y = columns[f"{point}.{letter}x"], columns[f"{point}.{letter}y"]
        curves.append(Column(point, np.hypot(x.values, y.values), x.unit))
    return curves


def measured(heads: Sequence[Head], columns: Sequence[Column]) -> dict[str, list[Column]]:
    """Return the curves of each graph, from columns of measures; curves with the same graph and unit are together."""
    groups: dict[tuple[str, str], list[Column]] = {}
    for head, column in zip(heads, columns, strict=True):
        if head.graph:
            short = Column(head.name.partition(":")[2], column.values, column.unit)
            groups.setdefault((head.graph, head.unit), []).append(short)
    return {
        graph if graph not in [g for g, u in groups if u != unit] else f"{graph}, {unit or '-'}": group
        for (graph, unit), group in groups.items()
    }
