"""Columns of the table of forces of a motion with dry friction, and the words of its rows."""

from __future__ import annotations

import numpy as np

from gimcli.dynamics.coulomb import DryFriction
from gimcli.dynamics.coulomb_status import SELF_LOCKING, FrictionStatus
from gimcli.dynamics.efficiency import row_efficiency, self_locking
from gimcli.dynamics.force_columns import effort_unit
from gimcli.dynamics.forces import Forces
from gimcli.table import Column

WORDS = np.array([status.word for status in FrictionStatus])
LIMITS = ("least", "greatest")
STATE = "friction.state"
"""Name of the column with the words of the rows."""


def friction_columns(forces: Forces, dry: DryFriction) -> list[Column]:
    """Return the power lost in each pair, limits of the efforts, efficiency, and the words of the rows."""
    columns = [
        Column(f"friction.power.{name}", np.where(forces.good, power, np.nan), "W")
        for name, power in zip(dry.names, dry.powers, strict=True)
    ]
    for k, actuator in enumerate(forces.mechanism.actuators):
        if k in forces.mechanism.geared:
            continue
        unit = effort_unit(forces.mechanism, k)
        for word, values in (("effort", dry.effort), ("hold", dry.hold)):
            columns += [Column(f"{actuator.name}.{word}.{end}", values[i, k], unit) for i, end in enumerate(LIMITS)]
    locked = np.where(self_locking(dry) & (dry.codes == FrictionStatus.SLIDING), SELF_LOCKING, WORDS[dry.codes])
    return [*columns, Column("friction.efficiency", row_efficiency(forces, dry)), Column(STATE, locked)]


def with_friction_words(status: Column, dry: DryFriction) -> Column:
    """Return the status column with the words of rows whose forces dry friction does not determine."""
    return Column(status.name, np.where(dry.codes == FrictionStatus.SLIDING, status.values, WORDS[dry.codes]))
