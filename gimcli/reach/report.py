"""Tables and reports of a workspace or reach, with the user's names and in the file's units."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.reach.boundary import Workspace
from gimcli.reach.circuit_paths import StartAssemblies
from gimcli.reach.reach import Interval, Reach, ReachedPath
from gimcli.reach.region import HOLE, INNER, OUTER, Edge
from gimcli.reach.task import WorkspaceTask
from gimcli.table import Column, Table, xy_columns


def placed(mechanism: Mechanism, y: FloatArray) -> ComplexArray:
    """Return points (rows, 2) of the normal frame in the file's coordinates (rows, 2)."""
    return mechanism.to_file(y @ np.array([1.0, 1.0j]))


def held_inputs(task: WorkspaceTask, edge: Edge) -> dict[str, float]:
    """Return the inputs that are at an end of their range along a curve (12 digits); empty on singular curves."""
    held = {}
    for actuator, inward in edge.arc.held:
        span = next(r for r in task.limited if r.actuator == actuator)
        value = _value(task.mechanism, actuator, span.low if inward > 0.0 else span.high)
        held[task.mechanism.actuators[actuator].name] = float(f"{value:.12g}")
    return held


def _value(mechanism: Mechanism, actuator: int, value: float) -> float:
    return float(mechanism.value_to_file(actuator, np.array([value]))[0])


def region_table(found: Workspace) -> Table:
    """Return one row per point of a curve; the region is to the left of its boundaries."""
    mechanism, edges = found.task.mechanism, found.edges
    z = [placed(mechanism, edge.points(1)) for edge in edges]
    row = np.array([k for k, path in enumerate(z) for _ in path], dtype=int)  # the edge of each row
    number = {id(edge): k for k, loop in enumerate(found.loops) for edge in loop.edges}
    held = (held_inputs(found.task, edge) for edge in edges)
    own = {
        "curve": range(len(edges)), "loop": [number.get(id(edge), -1) for edge in edges],
        "kind": [edge.kind for edge in edges],
        "held": [" ".join(f"{name}={value:.12g}" for name, value in one.items()) for one in held],
    }  # fmt: skip
    columns = [Column(name, np.array(values)[row]) for name, values in own.items()]
    return Table((*columns, *xy_columns("", np.concatenate([*z, np.zeros(0)]), mechanism.length_unit)))


def outlines(found: Workspace) -> dict[str, list[ComplexArray]]:
    """Return the curves of every kind, dense enough to draw, in the file's coordinates."""
    curves: dict[str, list[ComplexArray]] = {OUTER: [], HOLE: [], INNER: []}
    for loop in found.loops:
        curves[OUTER if loop.area > 0.0 else HOLE].append(placed(found.task.mechanism, loop.points()))
    curves[INNER] = [placed(found.task.mechanism, edge.points()) for edge in (*found.inner, *found.open)]
    return curves


def reach_table(found: Reach) -> Table:
    """Return one row per point of a path, with the inputs there."""
    mechanism, columns = found.task.mechanism, []
    knots = [(k, run.x) for k, run in enumerate(found.runs)]
    z = placed(mechanism, found.task.place(np.concatenate([path for _, path in knots])))
    columns.append(Column("path", np.concatenate([np.full(len(path), k) for k, path in knots])))
    for k, actuator in enumerate(mechanism.actuators):
        values = [_along(found, k, number, path) for number, path in knots]
        columns.append(Column(actuator.name, np.concatenate(values), mechanism.unit_of(actuator)))
    return Table((*columns, *xy_columns("", z, mechanism.length_unit)))


def _along(found: Reach, k: int, number: int, path: FloatArray) -> FloatArray:
    """Return an input along a path within its interval; angles are continuous."""
    mechanism, interval = found.task.mechanism, found.runs[number].intervals[k]
    u = found.task.inputs(path)[:, k]
    if mechanism.actuators[k].rotary:
        u = np.unwrap(u)
        u += 2.0 * np.pi * np.round((0.5 * (interval.low + interval.high) - 0.5 * (u.min() + u.max())) / (2.0 * np.pi))
    return np.asarray(mechanism.value_to_file(k, u))


def assemblies(mechanism: Mechanism, start: StartAssemblies) -> dict[str, Any]:
    """Return how many assemblies there are at the start of the law, and how many are on other paths."""
    counted = start.count is not None
    return {
        "at": mechanism.inputs_to_file(start.inputs), "count": start.count,
        "left_out": start.left_out if counted else None, "complete": start.complete,
    }  # fmt: skip


def bounds_of(mechanism: Mechanism, corners: tuple[FloatArray, FloatArray]) -> dict[str, list[float]]:
    """Return the least and the greatest x and y [file's unit]."""
    low, high = (placed(mechanism, corner[None, :])[0] for corner in corners)
    return {"x": [low.real, high.real], "y": [low.imag, high.imag]}


def ranges_of(mechanism: Mechanism, run: ReachedPath) -> dict[str, dict[str, Any]]:
    """Return the range of each input along a path, by name [file's unit]."""
    return {mechanism.actuators[one.actuator].name: _interval(mechanism, one) for one in run.intervals}


def _interval(mechanism: Mechanism, interval: Interval) -> dict[str, Any]:
    k = interval.actuator
    return {
        "from": _value(mechanism, k, interval.low), "to": _value(mechanism, k, interval.high),
        "full_turn": interval.full, "turns_back_at": [_value(mechanism, k, v) for v in interval.folds],
    }  # fmt: skip
