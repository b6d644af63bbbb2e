"""Torque and speed of the motors' rotors, behind their gears or screws."""

from __future__ import annotations

import math

import numpy as np

from gimcli.dynamics.forces import Forces
from gimcli.dynamics.kinematic_history import reading
from gimcli.table import Column, Table

LAST = ("residual", "status")
"""Columns that stay at the end of the table."""


def with_rotors(table: Table, forces: Forces) -> Table:
    """Return a table of forces with torque [N m] and speed [rev/min] of each rotor; the table itself without any."""
    columns = rotor_columns(forces)
    if not columns:
        return table
    own = [column for column in table.columns if column.name not in LAST]
    return Table((*own, *columns, *(column for column in table.columns if column.name in LAST)))


def rotor_columns(forces: Forces) -> list[Column]:
    """Return torque [N m] and speed [rev/min] of each rotor (rows,), positive in its own positive sense."""
    mechanism, columns = forces.mechanism, []
    for rotor in mechanism.dynamics.rotors:
        actuator = mechanism.actuators[rotor.actuator]
        metre = 1.0 if actuator.rotary else mechanism.dynamics.metre or 1.0
        speed = rotor.ratio * reading(mechanism, actuator, forces.course)[1]
        name = f"{actuator.name}.rotor"
        columns += [
            Column(f"{name}.torque", forces.effort(rotor.actuator) * metre / rotor.ratio, "N m"),
            Column(f"{name}.speed", np.where(forces.good, speed * 30.0 / math.pi, np.nan), "1/min"),
        ]
    return columns
