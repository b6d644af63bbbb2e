"""Pictures and the page of a sweep.

The pictures have curves over one dimension, contours over two, otherwise distributions. The page has the motion of each
design, and one slider for each dimension that chooses the design.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gimcli.families.design_columns import DesignColumns
from gimcli.families.design_table import DesignTable
from gimcli.families.sweep_job import DESIGN, GOAL, STATUS, Rows
from gimcli.families.sweep_run import SweepTables
from gimcli.graphs.motion_animation import returns, words
from gimcli.mechanism import ComplexArray, FloatArray, IntArray
from gimcli.output.animation import Animation, Clip, DimensionSlider, Graph
from gimcli.output.contours import contour_picture
from gimcli.output.drawing import motion_picture
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.output.panels import panel
from gimcli.output.picture import WIDEST, Picture, Sheet
from gimcli.quantities.motion_table import abscissa, motion_table
from gimcli.rounding import number
from gimcli.status import Status
from gimcli.table import Table

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
    names = [q.text for q in found.job.kept if q.kind.what == "number"]
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
    columns = DesignColumns(job.family.solve(designs, job.steps), job.names)
    solved = np.flatnonzero(columns.solved.good.any(axis=1))
    if not name or not len(solved):
        return []
    own = job.table.names[place]
    size = float(np.abs(designs[:, place]).max())
    paths = mechanism.to_file(columns.point(name))
    curves: dict[str, ComplexArray] = {
        f"{name}, {own} = {number(float(designs[k, place]), size)}": paths[k] for k in solved.tolist()
    }
    middle = columns.solved.motion(int(solved[len(solved) // 2]))
    if middle is None:
        return []
    poses = middle.mechanism.to_file(middle.z[:, middle.good][:, :1]).T
    return [motion_picture(middle.mechanism, poses, curves, mechanism.name)]


# -- the page ----------------------------------------------------------------------------------


MOST_PLACES = 300_000
"""Largest number of positions of nodes on a page, which limits its size to about 15 MB."""

MOST_DESIGNS = 400
"""Largest number of designs on a page."""

STEPS = 72
"""Largest number of steps of the motions on a page."""

WITHOUT = "velocities are not computed for many designs; trace one of them"


def sweep_animation(found: SweepTables) -> Animation | None:
    """Return the motions of the designs, or of evenly spread ones; None if no design is solved."""
    job, mechanism = found.job, found.mechanism
    steps = min(job.steps, STEPS)
    most = max(1, min(MOST_DESIGNS, MOST_PLACES // ((steps + 1) * len(mechanism.nodes))))
    numbers, sliders = chosen_designs(job.table, most, found)
    designs = np.concatenate([job.table.rows(k, k + 1) for k in numbers.tolist()])
    columns = job.columns(designs, steps, {})
    if not columns.solved.good.any():
        return None
    kept = _kept(found, columns)
    clips = tuple(_clip(columns, k, int(numbers[k]), kept[k]) for k in range(len(designs)))
    left = job.table.count - len(numbers)
    notes = (f"{len(numbers)} of {job.table.count} designs are shown; a table has all.",) if left else ()
    names = [f"{name}.{part}" for name in mechanism.traced[:1] for part in "xy"]
    graphs = (Graph(tuple(names)),) if names else ()
    return Animation(mechanism.name, mechanism, clips, graphs, notes, choice="Design", sliders=sliders)


def chosen_designs(table: DesignTable, most: int, found: SweepTables) -> tuple[IntArray, tuple[DimensionSlider, ...]]:
    """Return the numbers (from 0) of at most `most` designs, and the sliders that choose one of them."""
    if not table.shape:
        numbers = np.unique(np.linspace(0, table.count - 1, most).round().astype(int))
        return numbers, (DimensionSlider("design", "", tuple(float(k + 1) for k in numbers)),)
    counts = list(table.shape)
    while math.prod(counts) > most:
        counts[int(np.argmax(counts))] -= 1
    listed = [v.values for v in table.listed]
    places = [np.unique(np.linspace(0, len(v) - 1, c).round().astype(int)) for v, c in zip(listed, counts, strict=True)]
    places = [at[np.argsort(v[at])] for at, v in zip(places, listed, strict=True)]
    grid = np.meshgrid(*places, indexing="ij")
    numbers = np.ravel_multi_index([g.ravel() for g in grid], table.shape)
    sliders = tuple(
        DimensionSlider(name, found.unit(name), tuple(_rounded(values[at])))
        for name, values, at in zip(table.names, listed, places, strict=True)
    )
    return np.asarray(numbers), sliders


def _rounded(values: FloatArray) -> list[float]:
    size = float(np.abs(values).max(initial=0.0))
    return [float(number(float(value), size)) for value in values]


def _kept(found: SweepTables, columns: DesignColumns) -> list[str]:
    """Return the kept quantities of each design in words."""
    texts: list[list[str]] = [[] for _ in columns.designs]
    for own in (one for one in found.job.kept if one.kind.what != "rows"):
        values = np.broadcast_to(columns.of(own), len(columns.designs))
        for text, value in zip(texts, values.tolist(), strict=True):
            unit = f" {own.kind.unit}" if own.kind.unit not in (None, "", "unit") else ""
            text.append(f"{own.text} = {value if isinstance(value, str) else number(value) + unit}")
    return ["; ".join(text) for text in texts]


def _clip(columns: DesignColumns, k: int, design: int, kept: str) -> Clip:
    mechanism, solved, own = columns.mechanism, columns.solved, columns.solved.motion(k)
    status = Status(int(columns.status[k])).word
    note = f"design {design + 1}: {status}; {kept}" if kept else f"design {design + 1}: {status}"
    name, z = f"design {design + 1}", mechanism.to_file(solved.z[k].T)
    time, table, more = solved.time[0] * mechanism.duration, Table(()), dict[str, Any]()
    if own is not None:
        table = motion_table(own)
        more = {"axis": abscissa(own).name, "closed": returns(own.mechanism, own), "mechanism": own.mechanism}
    return Clip(name, z, time, words(solved.codes[k]), table, without=WITHOUT, note=note, **more)
