"""Tables and reports of a workspace or reach, with the user's names and in the file's units."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.reach.boundary import Workspace
from gimcli.reach.circuit_paths import StartAssemblies
from gimcli.reach.reach import Interval, Reach
from gimcli.reach.region import HOLE, INNER, OUTER, Edge
from gimcli.reach.task import WorkspaceTask
from gimcli.table import Column, Table, xy_columns

REGION_COLUMNS = ("curve", "loop", "kind", "held", "x", "y")
"""Columns of the table of a region."""


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
    task, unit = found.task, found.task.mechanism.length_unit
    number = {id(edge): k for k, loop in enumerate(found.loops) for edge in loop.edges}
    columns: list[list[Any]] = [[] for _ in REGION_COLUMNS]
    for k, edge in enumerate(found.edges):
        z = placed(task.mechanism, edge.points(1))
        held = " ".join(f"{name}={value:.12g}" for name, value in held_inputs(task, edge).items())
        same = (k, number.get(id(edge), -1), edge.kind, held)
        for column, value in zip(columns, same, strict=False):
            column.extend([value] * len(z))
        columns[-2].extend(z.real)
        columns[-1].extend(z.imag)
    units = ("", "", "", "", unit, unit)
    return Table(tuple(Column(n, np.array(c), u) for n, c, u in zip(REGION_COLUMNS, columns, units, strict=True)))


def region_report(found: Workspace) -> dict[str, Any]:
    """Return the results for `--json`."""
    mechanism, scale = found.task.mechanism, found.task.mechanism.scale
    return {
        "point": found.task.point, "freedoms": found.task.freedoms, "complete": found.complete,
        "area": found.area * scale**2, "area_error": found.area_error * scale**2,
        "perimeter": found.perimeter * scale,
        "bounds": _bounds(mechanism, found.bounds),
        "regions": sum(loop.area > 0.0 for loop in found.loops), "holes": sum(loop.area < 0.0 for loop in found.loops),
        "barriers": len(found.inner),
        "curves": [
            {
                "kind": edge.kind, "held": held_inputs(found.task, edge), "length": edge.arc.length * scale,
                "points": len(edge.arc.y),
            }
            for edge in found.edges
        ],
    }  # fmt: skip


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


def reach_report(found: Reach) -> dict[str, Any]:
    """Return the results for `--json`."""
    mechanism = found.task.mechanism
    return {
        "point": found.task.point, "freedoms": 1, "complete": found.complete,
        "all": found.start is None, "assemblies": None if found.start is None else _assemblies(mechanism, found.start),
        "paths": [
            {
                "drawn": run.drawn, "closed": run.closed, "length": run.length * mechanism.scale,
                "bounds": _bounds(mechanism, run.bounds),
                "inputs": {mechanism.actuators[i.actuator].name: _interval(mechanism, i) for i in run.intervals},
            }
            for run in found.runs
        ],
    }  # fmt: skip


def _assemblies(mechanism: Mechanism, start: StartAssemblies) -> dict[str, Any]:
    counted = start.count is not None
    return {
        "at": mechanism.inputs_to_file(start.inputs), "count": start.count,
        "left_out": start.left_out if counted else None, "complete": start.complete,
    }  # fmt: skip


def _bounds(mechanism: Mechanism, corners: tuple[FloatArray, FloatArray]) -> dict[str, list[float]]:
    low, high = (placed(mechanism, corner[None, :])[0] for corner in corners)
    return {"x": [low.real, high.real], "y": [low.imag, high.imag]}


def _interval(mechanism: Mechanism, interval: Interval) -> dict[str, Any]:
    k = interval.actuator
    return {
        "from": _value(mechanism, k, interval.low), "to": _value(mechanism, k, interval.high),
        "full_turn": interval.full, "turns_back_at": [_value(mechanism, k, v) for v in interval.folds],
    }  # fmt: skip
