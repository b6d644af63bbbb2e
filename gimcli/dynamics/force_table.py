"""Results of inverse dynamics: the table, and indeterminate reactions."""

from __future__ import annotations

import numpy as np

from gimcli.dynamics.forces import Forces
from gimcli.mechanism import BoolArray, FloatArray
from gimcli.motion.motion import Motion
from gimcli.rates.motion_table import first_columns, status_column
from gimcli.status import Status
from gimcli.table import Column, Table, xy_columns

SHARED = "unique"
"""Part of the column name for the component of a reaction that is still determined if the whole reaction is not."""


def force_table(motion: Motion, forces: Forces, first: int = 0) -> Table:
    """Return one row per step: time, inputs, efforts, reactions, shaking force, power, energy, status."""
    columns = [*reaction_columns(forces), *_frame_columns(forces), *_power_columns(forces)]
    singular = motion.good & ~forces.good  # velocities or reactions are not determined
    status = status_column(np.where(singular, int(Status.SINGULAR), motion.codes))
    if forces.dry is not None:
        from gimcli.dynamics.coulomb_table import friction_columns, with_friction_words

        columns += friction_columns(forces, forces.dry)
        status = with_friction_words(status, forces.dry)
    return Table((*first_columns(motion, first), *columns, Column("residual", motion.residual), status))


def determined_rows(motion: Motion, forces: Forces) -> BoolArray:
    """Return for every row whether its forces are determined, or at a standstill given by their limits."""
    given = forces.good if forces.dry is None else forces.good | forces.dry.standstill
    return np.asarray(motion.good & given)


def reaction_columns(forces: Forces) -> list[Column]:
    """Return efforts and reactions [N, N m]; an indeterminate reaction is NaN."""
    mechanism = forces.mechanism
    columns = [
        Column(f"{actuator.name}.effort", forces.effort(k), "N m" if actuator.rotary else "N")
        for k, actuator in enumerate(mechanism.actuators)
        if k not in mechanism.geared
    ]
    for pin in forces.statics.pins:
        node, alone = mechanism.nodes[pin.node], len(pin.members) == 2 and not pin.loaded
        for member in pin.members[1:] if alone else pin.members:
            name = node if alone else f"{node}.{mechanism.members[member].name}"
            columns += xy_columns(f"{name}.f", forces.pin(pin, member), "N")
            if pin.node in forces.statics.open_pins:
                columns += xy_columns(f"{name}.{SHARED}.f", forces.pin_shared(pin, member), "N")
    for pair in dict.fromkeys(slide.pair for slide in mechanism.slides):
        columns.append(Column(f"{pair}.normal", forces.normal(pair), "N"))
        if sum(slide.pair == pair for slide in mechanism.slides) > 1:
            columns.append(Column(f"{pair}.moment", forces.moment(pair), "N m"))
    if mechanism.gears:
        from gimcli.dynamics.gear_table import gear_columns  # imported late: only for models with gears

        columns += gear_columns(forces)
    return columns


def _frame_columns(forces: Forces) -> list[Column]:
    moment = Column("shaking.moment", forces.shaking_moment, "N m")
    return [*xy_columns("shaking.f", forces.shaking_force, "N"), moment]


def _power_columns(forces: Forces) -> list[Column]:
    power = {"drive": forces.drive_power, **forces.loads.power}
    return [
        *(Column(f"power.{kind}", _only(forces, values), "W") for kind, values in power.items()),
        Column("power.error", _only(forces, forces.power_error), "W"),
        Column("energy.kinetic", _only(forces, forces.loads.kinetic), "J"),
        Column("energy.potential", _only(forces, forces.loads.potential), "J"),
    ]


def _only(forces: Forces, values: FloatArray) -> FloatArray:
    return np.asarray(np.where(forces.good, values, np.nan))


def open_reactions(forces: Forces) -> list[str]:
    """Return the names of the reactions that are indeterminate in every row because of redundant constraints."""
    good = forces.good
    if not forces.statics.surplus or not good.any():
        return []
    names = [c.name.rsplit(".", 1)[0] for c in reaction_columns(forces) if np.all(np.isnan(c.values[good]))]
    return [name for name in dict.fromkeys(names) if not name.endswith(f".{SHARED}")]
