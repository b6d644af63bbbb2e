"""The animations of motions and positions.

A traced or simulated motion has its rows, events, velocities and columns; a solved position, or each configuration, is
a clip of one row.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.motion.summary import occurrences
from gimcli.output.animation import Animation, Clip, Graph, Moment, shown_rows
from gimcli.quantities.motion_table import abscissa
from gimcli.rates.member_angles import Angles, in_rows
from gimcli.rounding import at_inputs, number, titled
from gimcli.status import Status
from gimcli.table import Column, Table, xy_columns

if TYPE_CHECKING:
    from gimcli.dynamics.simulation_types import Event, Simulation
    from gimcli.graphs.extras import Extras
    from gimcli.rates.derivatives import Instant


SAME = 1e-6
"""Largest distance, relative to the size, of the first and the last position of a closed motion."""

REVERSED = "velocities need a motion along the law, without at-limit reverse"

MOST_CURVES = 8
"""Largest number of curves in a graph that is shown first."""


def law_animation(motion: Motion, extras: Extras, steps: int, angles: Angles = in_rows) -> Animation | None:
    """Return the animation of a motion along the laws in `steps` steps; None if no row is solved.

    `motion` has all rows, or evenly spread ones of a long motion; `angles` counts full turns.
    """
    mechanism = motion.mechanism
    if not motion.solved:
        return None
    without = REVERSED if motion.turned_back or motion.parameter is not None else ""
    order = 0 if without else max(2, extras.order)
    table = _with_steps(extras.with_expressions(extras.apart(motion, angles, order)), motion, steps)
    across, closed = abscissa(motion).name, returns(mechanism, motion)
    every = ((time, kind, mechanism.inputs_to_file(inputs)) for kind, time, inputs in occurrences(motion))
    events = sorted((time, kind, event_text(mechanism, kind, inputs)) for time, kind, inputs in every)
    clip = motion_clip("motion", motion, table, mechanism.duration, across, events, closed, without)
    notes = thinning(len(clip.time), steps + 1)
    return Animation(mechanism.name, mechanism, (clip,), first_graphs(table, extras, across), notes)


def motion_clip(
    name: str, motion: Motion, table: Table, seconds: float, axis: str, events: Sequence[tuple[float, str, str]],
    closed: bool, without: str, note: str = "",
) -> Clip:  # fmt: skip
    """Return the clip of a motion: evenly spread rows, and those beside events.

    Args:
        name: its name.
        motion: all rows.
        table: the columns for graphs, with all rows.
        seconds: the time in which the motion is shown.
        axis: the column that is the abscissa.
        events: time (0 to 1), kind and text of each event.
        closed: whether the last position is the first one.
        without: why there are no velocities; "" for those along the laws.
        note: a line about the motion.
    """
    rows = shown_rows(motion.good, [row_at(motion.time, time) for time, *_ in events])
    shown = motion.rows(rows)
    moments = tuple(Moment(row_at(shown.time, time), kind, text) for time, kind, text in events)
    return Clip(
        name, motion.mechanism.to_file(shown.z.T), shown.time * seconds, words(shown.codes), rows_of(table, rows), axis,
        moments, closed, rates=None if without else law_rates(shown), without=without, note=note,
    )  # fmt: skip


def first_graphs(table: Table, extras: Extras | None, over: str) -> tuple[Graph, ...]:
    """Return the graphs that are shown first: those that were requested, else the coordinates of the first point."""
    found = requested_graphs(table, extras, over) if extras is not None else []
    if not found:
        points = [name for name in table.names if name.endswith((".x", ".y"))][:2]
        found = [Graph(tuple(points), over)] if points else []
    return tuple(found)


def requested_graphs(table: Table, extras: Extras, over: str) -> list[Graph]:
    """Return the graphs of --plot whose curves and abscissae a table has; `over` is the usual abscissa."""
    found = []
    for plan in extras.plans:
        names = tuple(dict.fromkeys(curve.y.text for curve in plan.curves))[:MOST_CURVES]
        across = plan.curves[0].x if plan.curves else None
        found.append(Graph(names, over if across is None else across.text))
    return [graph for graph in found if graph.columns and {*graph.columns, graph.over} <= set(table.names)]


def law_rates(motion: Motion) -> ComplexArray | None:
    """Return velocity and acceleration (2, rows, nodes) in the file's units; None if no row has them."""
    from gimcli.rates.derivatives import rates

    found = rates(motion.mechanism, motion.time, motion.z, 2).nodes[1:]
    return np.asarray(np.moveaxis(found, 1, 2) * motion.mechanism.scale) if np.isfinite(found).any() else None


def event_text(mechanism: Mechanism, kind: str, inputs: dict[str, float]) -> str:
    """Return an event with the inputs there."""
    return f"{kind} at {at_inputs(mechanism, inputs)}"


def row_at(time: FloatArray, at: float) -> float:
    """Return the row, between rows, of a time."""
    return float(np.interp(at, time, np.arange(len(time))))


def words(codes: IntArray) -> tuple[str, ...]:
    """Return the status words of rows."""
    return tuple(Status(int(code)).word for code in codes)


def returns(mechanism: Mechanism, motion: Motion) -> bool:
    """Return whether all rows are solved and the last position is the first one."""
    gap = mechanism.apart(motion.z[:, -1], motion.z[:, 0]) if motion.good.all() else np.array([np.inf])
    return bool(len(motion.time) > 1 and np.max(gap) <= SAME * mechanism.size)


def thinning(shown: int, rows: int) -> tuple[str, ...]:
    """Return a note if not all rows are shown."""
    return (f"{shown} of {rows} rows are shown; a table has all.",) if shown < rows else ()


def _with_steps(table: Table, motion: Motion, steps: int) -> Table:
    """Return a table with the numbers of the steps of a motion of which it has some rows."""
    numbers = np.rint(motion.time * steps).astype(np.int64)
    return Table((Column("step", numbers), *(c for c in table.columns if c.name != "step")))


def rows_of(table: Table, rows: IntArray) -> Table:
    """Return some rows of a table."""
    return Table(tuple(Column(c.name, c.values[rows], c.unit) for c in table.columns))


STILL = "a single position: `gim solve --velocities` has velocities"

NO_RATES = "configurations have no velocities: use `gim solve --velocities` or trace the motion"


def position_animation(
    mechanism: Mechanism, z: ComplexArray, inputs: Mapping[str, float], places: Mapping[str, complex],
    moving: Instant | None,
) -> Animation:  # fmt: skip
    """Return a solved position z (nodes,) with its velocities, if these are known.

    `places` are the coordinates of nodes and points in the file's units.
    """
    rates, without = None, STILL
    if moving is not None and not moving.singular:
        vectors = [moving.of_points(order) for order in (1, 2)]
        rates, without = np.array([[[of[name] for name in mechanism.nodes]] for of in vectors]), ""
    clip = _clip("position", mechanism, z, inputs, places, rates, without)
    return Animation(titled(mechanism, inputs), mechanism, (clip,))


def configurations_animation(
    mechanism: Mechanism, z: ComplexArray, inputs: Mapping[str, float], places: Mapping[str, ComplexArray],
    names: Sequence[str], notes: Sequence[str], verdict: str,
) -> Animation:  # fmt: skip
    """Return all configurations z (configurations, nodes), one clip each with a name and a note."""
    clips = []
    for k, (name, note) in enumerate(zip(names, notes, strict=True)):
        own = {point: complex(values[k]) for point, values in places.items()}
        clips.append(_clip(name, mechanism, z[k], inputs, own, None, NO_RATES, note))
    return Animation(titled(mechanism, inputs), mechanism, tuple(clips), notes=(verdict,), choice="Configuration")


def _clip(
    name: str, mechanism: Mechanism, z: ComplexArray, inputs: Mapping[str, float], places: Mapping[str, complex],
    rates: ComplexArray | None, without: str, note: str = "",
) -> Clip:  # fmt: skip
    """Return a clip of one row with the inputs and the coordinates of nodes and points."""
    own = [Column(a.name, np.array([inputs[a.name]]), mechanism.unit_of(a)) for a in mechanism.actuators]
    points = [c for n, at in places.items() for c in xy_columns(f"{n}.", np.array([at]), mechanism.length_unit)]
    at, table = mechanism.to_file(z)[None], Table((*own, *points))
    return Clip(name, at, np.zeros(1), ("ok",), table, rates=rates, without=without, note=note)


def simulation_animation(
    found: Simulation, nodes: ComplexArray, times: FloatArray, table: Table, requested: Sequence[Graph]
) -> Animation | None:  # fmt: skip
    """Return a simulated motion with its events, velocities and columns at `times`; None if it has no row.

    `nodes` are positions and rates (3, nodes, times) in the normal frame, NaN in rows that were not reached.
    """
    from gimcli.dynamics.simulation_table import ENERGIES

    mechanism, status = found.mechanism, table["status"]
    if not len(found.time):
        return None
    rows = shown_rows(np.asarray(status == "ok"), [row_at(times, event.time) for event in found.events])
    nodes = nodes[:, :, rows]
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


def _text(mechanism: Mechanism, event: Event) -> str:
    at = at_inputs(mechanism, mechanism.inputs_to_file(event.inputs))
    return f"{event.kind} at time = {number(event.time)} s, {at}"
