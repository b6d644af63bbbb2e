"""The page of a sweep: the motion of each design, and one slider for each dimension that chooses the design."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gimcli.families.design_columns import DesignColumns
from gimcli.families.design_table import DesignTable
from gimcli.library.motion_animation import returns, words
from gimcli.library.sweep_tables import SweepTables
from gimcli.mechanism import FloatArray, IntArray
from gimcli.output.animation import Animation, Clip, DimensionSlider, Graph
from gimcli.quantities.graphs import abscissa
from gimcli.quantities.motion_table import motion_table
from gimcli.rounding import number
from gimcli.status import Status
from gimcli.table import Table

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
    listed = [v.values for v in table.varied.variations if hasattr(v, "values")]
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
    for own in (one for one in found.job.kept if one.kind != "rows"):
        values = np.broadcast_to(own.values(columns), len(columns.designs))
        for text, value in zip(texts, values.tolist(), strict=True):
            unit = f" {own.unit}" if own.unit not in ("", "unit") else ""
            text.append(f"{own.text} = {value if isinstance(value, str) else number(value) + unit}")
    return ["; ".join(text) for text in texts]


def _clip(columns: DesignColumns, k: int, design: int, kept: str) -> Clip:
    mechanism, solved, own = columns.mechanism, columns.solved, columns.motions.motion(k)
    status = Status(int(columns.status[k])).word
    note = f"design {design + 1}: {status}; {kept}" if kept else f"design {design + 1}: {status}"
    name, z = f"design {design + 1}", mechanism.to_file(solved.z[k].T)
    time, table, more = solved.time * mechanism.duration, Table(()), dict[str, Any]()
    if own is not None:
        table = motion_table(own)
        more = {"axis": abscissa(own).name, "closed": returns(own.mechanism, own), "mechanism": own.mechanism}
    return Clip(name, z, time, words(solved.codes[k]), table, without=WITHOUT, note=note, **more)
