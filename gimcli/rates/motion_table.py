"""Results of a motion: the table, the ranges of the inputs that were reached, and the events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, IntArray
from gimcli.motion.coupler_points import carried_point
from gimcli.motion.motion import Motion
from gimcli.positions.inputs import law_inputs
from gimcli.rates.member_angles import Angles, in_rows
from gimcli.status import Status
from gimcli.table import Column, Table, per_second, xy_columns

if TYPE_CHECKING:
    from gimcli.rates.derivatives import TracedRates


def motion_table(
    motion: Motion, names: tuple[str, ...] | None = None, first: int = 0, order: int = 0,
    rates: TracedRates | None = None, more: Sequence[Column] = (), angles: Angles = in_rows,
    members: Sequence[int] = (),
) -> Table:  # fmt: skip
    """Return one row per step, numbered from `first`: time, inputs, traced points, residual, sweeps, status.

    `order` adds derivatives of the points by the real time, up to jerk (3), and the members' angles with theirs;
    `rates` does so for a motion in pieces, with `angles`. Without derivatives only angles of `members` are added.
    `more` are columns of measures, which follow them.
    """
    mechanism, columns = motion.mechanism, first_columns(motion, first)
    for name, path in traced_paths(motion, names).items():
        columns += xy_columns(f"{name}.", path, mechanism.length_unit)
    if order and rates is None:
        from gimcli.rates.derivatives import TracedRates

        rates = TracedRates(mechanism, names or mechanism.traced, order)
    if rates is not None:
        columns += _rate_columns(motion, rates, angles)
    else:
        columns += [angle_column(motion, member, angles) for member in members]
    columns += more
    last = Column("residual", motion.residual), Column("sweeps", motion.work.astype(np.int64))
    own = [status_column(part.codes, f"{part.mechanism.as_machine.name}.status") for part in motion.parts]
    return Table((*columns, *last, status_column(motion.codes), *own))


def first_columns(motion: Motion, first: int) -> list[Column]:
    """Return the first columns of every motion: steps numbered from `first`, time, inputs."""
    mechanism, steps = motion.mechanism, np.arange(first, first + len(motion.time))
    inputs = [
        Column(a.name, mechanism.value_to_file(k, motion.inputs[k]), mechanism.unit_of(a))
        for k, a in enumerate(mechanism.actuators)
    ]
    return [Column("step", steps), Column("time", motion.time * mechanism.duration, "s"), *inputs]


def status_column(codes: IntArray, name: str = "status") -> Column:
    """Return the status words of rows (rows,)."""
    return Column(name, np.array([s.word for s in Status])[codes])


def angle_column(motion: Motion, member: int, angles: Angles) -> Column:
    """Return the direction of a member, full turns counted."""
    mechanism = motion.mechanism
    return Column(f"{mechanism.members[member].name}.angle", angles(motion, member), mechanism.angle_unit)


def _rate_columns(motion: Motion, rates: TracedRates, angles: Angles) -> list[Column]:
    """Return velocity, acceleration, jerk of points, then angle, omega, alpha, angular jerk of members."""
    mechanism, columns = motion.mechanism, []
    points, turning = rates(motion)
    points *= mechanism.scale
    if mechanism.angle_unit == "deg":
        np.degrees(turning, out=turning)
    for number, name in enumerate(rates.names):
        for k in range(rates.order):
            label = f"{name}.{'vaj'[k]}"
            columns += xy_columns(label, points[k, number], per_second(mechanism.length_unit, k + 1))
    for number, member in enumerate(mechanism.members[FRAME + 1 :]):
        columns.append(angle_column(motion, FRAME + 1 + number, angles))
        for k in range(rates.order):
            label = f"{member.name}.{('omega', 'alpha', 'jerk')[k]}"
            columns.append(Column(label, turning[k, number], per_second(mechanism.angle_unit, k + 1)))
    return columns


def traced_paths(motion: Motion, names: tuple[str, ...] | None = None) -> dict[str, ComplexArray]:
    """Return the paths of the traced points in the file's coordinates; NaN in rows that are not solved."""
    mechanism, chosen = motion.mechanism, names or motion.mechanism.traced
    return {name: np.asarray(mechanism.to_file(carried_point(mechanism, name, motion.z))) for name in chosen}


def reachable(motion: Motion) -> dict[str, list[list[float]]]:
    """Return for every actuator the range of its law that the motion reached, in the file's unit."""
    if motion.parts:
        found = {name: ranges for part in motion.parts for name, ranges in reachable(part).items()}
        return {a.name: found[a.name] for a in motion.mechanism.actuators}
    mechanism = motion.mechanism
    if motion.first_status is not Status.OK:
        return {a.name: [] for a in mechanism.actuators}
    if motion.turned_back:
        there = np.array([inputs for _, inputs in motion.turned_back]).T
        passed = np.concatenate([motion.inputs[:, motion.good], there], axis=1)
        ranges = np.stack([passed.min(axis=1), passed.max(axis=1)], axis=1)
        return {
            a.name: [[float(v) for v in mechanism.value_to_file(k, ranges[k])]]
            for k, a in enumerate(mechanism.actuators)
        }
    end = float(motion.time[motion.good][-1]) if motion.limit is None else motion.limit
    ends = law_inputs(mechanism)(np.array([motion.time[0], end]))
    rows = law_inputs(mechanism)(motion.time[motion.time <= end])
    spans = [_span(*pair) for pair in zip(ends, rows, strict=True)]
    return {
        a.name: [[float(v) for v in mechanism.value_to_file(k, spans[k])]] for k, a in enumerate(mechanism.actuators)
    }


def _span(ends: FloatArray, rows: FloatArray) -> FloatArray:
    """Return the ends of a law, or its least and greatest value if it reverses beyond them."""
    least, greatest = np.min(rows, initial=ends.min()), np.max(rows, initial=ends.max())
    return ends if (least, greatest) == (ends.min(), ends.max()) else np.array([least, greatest])


def occurrences(motion: Motion) -> list[tuple[str, float, FloatArray]]:
    """Return kind, normalised time and inputs (actuators,) of meetings of branches, exchanged sequences and limits."""
    times = [("sequence exchanged", t) for t in motion.exchanged]
    if motion.limit is not None and not motion.turned_back and motion.first_status is Status.OK:
        times.append(("limit", motion.limit))
    return [
        *((met.kind, time, met.inputs) for time, met in zip(motion.bridged, motion.meetings, strict=False)),
        *((kind, time, law_inputs(motion.mechanism)(np.array([time]))[:, 0]) for kind, time in times),
        *(("limit", time, np.array(at)) for time, at in sorted((*motion.turned_back, *motion.touched))),
    ]


def events(motion: Motion) -> list[dict[str, Any]]:
    """Return the events of a motion (singular positions, changed sequences, limits), with the inputs there."""
    return [{"kind": kind, "at": motion.mechanism.inputs_to_file(at)} for kind, _, at in occurrences(motion)]
