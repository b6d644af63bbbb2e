"""Columns of the reactions of gears: force on the second member, tangential force, belt tension or torque."""

from __future__ import annotations

import numpy as np

from gimcli.coupling_data import BELT, CROSSED, GearPair
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.gear_pivots import across
from gimcli.dynamics.physical import require_action
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.table import Column, xy_columns

TANGENTIAL, TENSION, TORQUE = "tangential", "tension", "torque"
"""Ends of the names of columns: tooth force along the pitch lines, difference of the tensions, torque of a belt."""


def gear_columns(forces: Forces) -> list[Column]:
    """Return the reactions of gears [N], of belts without radii the torque on the second wheel [N m]."""
    columns = []
    for gear, unknown in zip(forces.mechanism.gears, forces.statics.teeth, strict=True):
        value = forces.unknown(unknown)
        if gear.radii is None:
            columns.append(Column(f"{gear.name}.{TORQUE}", value * require_action(forces.mechanism), "N m"))
            continue
        columns += xy_columns(f"{gear.name}.f", _force(forces, gear, unknown, value), "N")
        kind = TENSION if gear.kind in (BELT, CROSSED) else TANGENTIAL
        columns.append(Column(f"{gear.name}.{kind}", value, "N"))
    return columns


def _force(forces: Forces, gear: GearPair, unknown: int, value: FloatArray) -> ComplexArray:
    """Return the force on the second member (rows,): of the teeth, or of the strand under tension."""
    part = 0.0 if forces.statics.reactions[unknown].vector.u < 0 and gear.slide < 0 else forces.direction(unknown)
    return np.asarray(value * part + np.abs(value) * across(forces.statics, gear, forces.course.nodes[0]))
