"""Results of inverse dynamics: the table, and indeterminate reactions."""

from __future__ import annotations

import numpy as np

from gimcli.dynamics.force_columns import SHARED, columns_of, reactions, rotors, totals
from gimcli.dynamics.forces import Forces
from gimcli.mechanism import BoolArray
from gimcli.motion.motion import Motion
from gimcli.motion.summary import first_columns, status_column
from gimcli.status import Status
from gimcli.table import Column, Table


def force_table(motion: Motion, forces: Forces, first: int = 0) -> Table:
    """Return one row per step: time, inputs, efforts, reactions, shaking force, power, energy, rotors, status."""
    columns = columns_of(forces, [*reactions(forces.statics), *totals(forces.statics)])
    singular = motion.good & ~forces.good  # velocities or reactions are not determined
    status = status_column(np.where(singular, int(Status.SINGULAR), motion.codes))
    if forces.dry is not None:
        from gimcli.dynamics.coulomb_table import friction_columns, with_friction_words

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
