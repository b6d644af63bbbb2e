"""The animation of a simulated motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.dynamics.simulation_table import ENERGIES
from gimcli.dynamics.simulation_types import Event, Simulation
from gimcli.library.motion_animation import row_at, rows_of, thinning
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.output.animation import Animation, Clip, Graph, Moment, shown_rows
from gimcli.rounding import at_inputs, number
from gimcli.table import Table


def simulation_animation(
    found: Simulation, times: FloatArray, table: Table, requested: Sequence[Graph]
) -> Animation | None:  # fmt: skip
    """Return a simulated motion with its events, velocities and columns at `times`; None if it has no row."""
    mechanism, status = found.mechanism, table["status"]
    if not len(found.time):
        return None
    rows = shown_rows(np.asarray(status == "ok"), [row_at(times, event.time) for event in found.events])
    nodes = _padded(found.nodes, len(times))[:, :, rows]
    clip = Clip(
        "motion", mechanism.to_file(nodes[0].T), times[rows], tuple(map(str, status[rows])), rows_of(table, rows),
        events=tuple(Moment(row_at(times[rows], e.time), e.kind, _text(mechanism, e)) for e in found.events),
        forward=True, rates=np.moveaxis(nodes[1:], 1, 2) * mechanism.scale,
    )  # fmt: skip
    graphs = [Graph((a.name,), "time") for a in mechanism.actuators[:2]]
    energies = tuple(f"energy.{kind}" for kind in ENERGIES if np.nanmax(np.abs(table[f"energy.{kind}"])) > 0.0)
    graphs += [Graph(energies, "time")] if energies else []
    title = f"{mechanism.name}: simulation"
    return Animation(title, mechanism, (clip,), tuple(requested or graphs), thinning(len(rows), len(times)))


def _padded(nodes: ComplexArray, rows: int) -> ComplexArray:
    """Return positions and rates (3, nodes, rows) with NaN for the rows that were not reached."""
    missing = np.full((*nodes.shape[:2], rows - nodes.shape[2]), complex(np.nan, np.nan))
    return np.concatenate([nodes, missing], axis=2)


def _text(mechanism: Mechanism, event: Event) -> str:
    at = at_inputs(mechanism, mechanism.inputs_to_file(event.inputs))
    return f"{event.kind} at time = {number(event.time)} s, {at}"
