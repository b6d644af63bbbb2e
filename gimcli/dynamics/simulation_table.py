"""Results of a simulation: the table, and the events in the file's units."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.dynamics.force_columns import columns_of, effort_unit, reactions as force_reactions
from gimcli.dynamics.forces import Forces, inverse_dynamics
from gimcli.dynamics.physical import input_units
from gimcli.dynamics.simulation_types import Event, Simulation
from gimcli.dynamics.statics import statics
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.status import Status
from gimcli.structure.carried import carried_point
from gimcli.table import Column, Table, per_second, xy_columns

ENERGIES = ("kinetic", "potential", "dissipated", "supplied")


def column_names(mechanism: Mechanism) -> list[str]:
    """Return the names of the columns except those of reactions; no simulation is needed for them."""
    return [
        "step", "time", "status", *(f"energy.{kind}" for kind in (*ENERGIES, "drift")),
        *(a.name + part for a in mechanism.actuators for part in ("", ".speed", ".acceleration", ".effort")),
        *(f"{name}.{axis}" for name in mechanism.traced for axis in "xy"),
    ]  # fmt: skip


def simulation_table(found: Simulation, times: FloatArray, forces: Forces | None = None) -> Table:
    """Return one row per time: inputs and their rates, points, energies, efforts or all reactions, status.

    Rows that the simulation did not reach are kept as empty rows with time and status.
    """
    mechanism, rows, columns = found.mechanism, len(found.time), list[Column]()
    for k, actuator in enumerate(mechanism.actuators):
        unit = mechanism.unit_of(actuator)
        for order, suffix in enumerate(("", ".speed", ".acceleration")):
            values = mechanism.value_to_file(k, found.inputs[order, k])
            columns.append(Column(actuator.name + suffix, values, per_second(unit, order) if order else unit))
    for name in mechanism.traced:
        path = np.asarray(mechanism.to_file(carried_point(mechanism, name, found.nodes[0])))
        columns += xy_columns(f"{name}.", path, mechanism.length_unit)
    energies = zip((*ENERGIES, "drift"), (*found.energy, found.drift), strict=True)
    columns += [Column(f"energy.{name}", values, "J") for name, values in energies]
    if forces is None:
        units = input_units(mechanism)
        columns += [
            Column(f"{mechanism.actuators[k].name}.effort", own / units[k], effort_unit(mechanism, k))
            for k, own in enumerate(found.efforts) if not np.all(np.isnan(own))
        ]  # fmt: skip
    else:
        columns += columns_of(forces, force_reactions(forces.statics))
        if found.friction is not None:
            from gimcli.dynamics.regularised_friction import friction_columns

            columns += friction_columns(mechanism, forces.course, found.friction)
    reason = found.status if found.status is not Status.OK else Status.NOT_CONVERGED
    words = np.array([Status.OK.word] * rows + [reason.word] * (len(times) - rows))
    head = Column("step", np.arange(len(times))), Column("time", times, "s")
    missing = np.full(len(times) - rows, np.nan)
    columns = [Column(c.name, np.concatenate([c.values, missing]), c.unit) for c in columns]
    return Table((*head, *columns, Column("status", words)))


def event_report(mechanism: Mechanism, event: Event) -> dict[str, Any]:
    """Return an event in the file's units."""
    report: dict[str, Any] = {"kind": event.kind, "time": event.time}
    if event.pair:
        report["pair"] = event.pair
    if event.actuator >= 0 and len(mechanism.actuators) > 1:
        report["actuator"] = mechanism.actuators[event.actuator].name
    return report | {"at": mechanism.inputs_to_file(event.inputs), "speed": mechanism.inputs_to_file(event.speeds)}


def reactions(found: Simulation) -> Forces:
    """Return the reactions along a simulation; the efforts of the free inputs are computed from the motion."""
    forces = inverse_dynamics(statics(found.mechanism), found.course())
    if found.friction is None:
        return forces
    from gimcli.dynamics.regularised_friction import with_friction

    return with_friction(forces, found.friction)


def reaction_units(mechanism: Mechanism) -> dict[str, str]:
    """Return the units of the columns of reactions by name; no simulation is needed for them."""
    units = {name: one.unit for one in force_reactions(statics(mechanism)) for name in one.names}
    if not any(friction.mu > 0.0 for friction in mechanism.dynamics.frictions):
        return units
    from gimcli.dynamics.regularised_friction import friction_names

    return {**units, **dict.fromkeys(friction_names(mechanism), "")}
