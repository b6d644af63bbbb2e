"""Pictures of a sweep: curves over one dimension, contours over two, otherwise distributions."""

from __future__ import annotations

import math

import numpy as np

from gimcli.families.design_columns import DesignColumns
from gimcli.families.design_motions import DesignMotions
from gimcli.families.sweep_job import DESIGN, GOAL, STATUS, Rows
from gimcli.library.sweep_tables import SweepTables
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.output.contours import contour_picture
from gimcli.output.drawing import motion_picture
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.output.panels import panel
from gimcli.output.picture import WIDEST, Picture, Sheet
from gimcli.rounding import number
from gimcli.status import Status

MOST_CURVES, MOST_GRAPHS = 6, 6
"""Largest numbers of coupler curves, and of graphs."""


def sweep_picture(found: SweepTables, rows: Rows) -> Sheet | None:
    """Return the picture of designs, None if there is nothing to draw, or too much for one picture."""
    table, title = found.job.table, found.mechanism.name
    long = [k for k, count in enumerate(table.shape) if count > 1]
    first: list[Picture] = []
    if len(rows) and len(long) in (1, 2) and found.rows > sum(map(len, found.drawn)):
        return None
    if len(rows) and len(long) == 2:
        graphs = _over_two(found, rows, *long)
    elif len(rows) and len(long) == 1:
        first = _coupler_curves(found, long[0])
        graphs = [panel(graph, WIDEST) for graph in _over_one(found, rows, long[0])]
    else:
        graphs = [panel(graph, WIDEST) for graph in _distributions(found, rows)]
    return Sheet("" if first else title, (*first, *graphs)) if first or graphs else None


def _drawn_names(found: SweepTables) -> list[str]:
    """Return the quantities that are numbers, with the goal."""
    names = [q.text for q in found.job.kept if q.kind == "number"]
    return [*names, *([GOAL] if found.job.aim is not None else [])][:MOST_GRAPHS]


def _axis(found: SweepTables, name: str) -> Axis:
    return Axis(name, found.unit(name))


def _over_one(found: SweepTables, rows: Rows, place: int) -> list[CurveGraph]:
    """Return the graph of each quantity over a dimension; rows that were filtered out are gaps."""
    name = found.job.table.names[place]
    across = found.job.table.rows(0, found.job.table.count)[:, place]
    order = np.argsort(across, kind="stable")
    return [
        CurveGraph(_axis(found, name), _axis(found, own), [Curve(own, across[order], _whole(found, rows, own)[order])])
        for own in _drawn_names(found)
    ]


def _over_two(found: SweepTables, rows: Rows, first: int, second: int) -> list[Picture]:
    """Return the contours of each quantity over two dimensions."""
    table = found.job.table
    shape = table.shape[first], table.shape[second]
    designs = table.rows(0, table.count)
    x, y = designs[:, first].reshape(shape)[:, 0], designs[:, second].reshape(shape)[0]
    right, up = np.argsort(x), np.argsort(y)
    across, axis = (_axis(found, table.names[k]) for k in (first, second))
    pictures = []
    for own in _drawn_names(found):
        values = _whole(found, rows, own).reshape(shape)[np.ix_(right, up)].T
        pictures.append(contour_picture(across, axis, _axis(found, own), x[right], y[up], values))
    return pictures


def _whole(found: SweepTables, rows: Rows, name: str) -> FloatArray:
    """Return the values of all designs; NaN for those that are not kept, or solved in part where others are whole."""
    values = np.full(found.job.table.count, math.nan)
    whole = rows[rows[STATUS] == Status.OK]
    chosen = whole if len(whole) else rows
    values[chosen[DESIGN] - 1] = chosen[name]
    return values


def _distributions(found: SweepTables, rows: Rows) -> list[CurveGraph]:
    """Return for each quantity the share of the designs below each value."""
    graphs = []
    for own in _drawn_names(found):
        values = np.sort(rows[own][np.isfinite(rows[own])])
        if len(values):
            values = (
                values[np.unique(np.linspace(0, len(values) - 1, 2001).astype(int))] if len(values) > 4000 else values
            )
            share = (np.arange(len(values)) + 0.5) / len(values)
            graphs.append(
                CurveGraph(_axis(found, own), Axis("share of the designs below"), [Curve(own, values, share)])
            )
    return graphs


def _coupler_curves(found: SweepTables, place: int) -> list[Picture]:
    """Return the paths of the first traced point in some designs, with the first pose of the middle one."""
    job, mechanism = found.job, found.mechanism
    name = next(iter(mechanism.traced), "")
    chosen = np.unique(np.linspace(0, job.table.count - 1, MOST_CURVES).round().astype(int))
    designs = np.concatenate([job.table.rows(k, k + 1) for k in chosen.tolist()])
    columns = DesignColumns(DesignMotions(job.family, job.family.solve(designs, job.steps), {}), job.names)
    solved = np.flatnonzero(columns.solved.good.any(axis=1))
    if not name or not len(solved):
        return []
    own = job.table.names[place]
    size = float(np.abs(designs[:, place]).max())
    paths = mechanism.to_file(columns.point(name))
    curves: dict[str, ComplexArray] = {
        f"{name}, {own} = {number(float(designs[k, place]), size)}": paths[k] for k in solved.tolist()
    }
    middle = columns.motions.motion(int(solved[len(solved) // 2]))
    if middle is None:
        return []
    poses = middle.mechanism.to_file(middle.z[:, middle.good][:, :1]).T
    return [motion_picture(middle.mechanism, poses, curves, mechanism.name)]
