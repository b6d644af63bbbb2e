"""The usual graphs of forces, and which of them show more than a constant.

Hodographs have values of the input along their curves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gimcli.graphs.plots import PlannedCurve, PlannedGraph, plotted
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.output.graph import EQUAL, ORDINARY, Curve, CurveGraph, PlaceMark
from gimcli.rounding import round_above
from gimcli.table import Column

CONSTANT = 1e-9
"""Range of a constant quantity, relative to its largest value."""


def usual_graphs(mechanism: Mechanism) -> list[PlannedGraph]:
    """Return the graphs without --plot: driving efforts over the input."""
    plans = []
    for rotary, title in ((True, "driving torque"), (False, "driving force")):
        own = [a.name for k, a in enumerate(mechanism.actuators) if a.rotary is rotary and k not in mechanism.geared]
        unit = "N m" if rotary else "N"
        curves = tuple(PlannedCurve(plotted(f"{name}.effort", unit, name)) for name in own)
        plans += [PlannedGraph(ORDINARY, title, curves)] if own else []
    return plans


def varying(plans: Sequence[PlannedGraph], columns: Mapping[str, Column]) -> tuple[list[PlannedGraph], list[str]]:
    """Return the graphs that show more than a constant, and the values of the constant ones as texts."""
    kept, texts = [], []
    for plan in plans:
        names = sorted(plan.columns)
        if all(_is_constant(columns[name]) for name in names):
            texts += [_value(columns[name]) for name in names]
        else:
            kept.append(plan)
    return (kept, texts) if kept else (list(plans[:1]), [])


def _is_constant(column: Column) -> bool:
    values = column.values[np.isfinite(column.values)]
    return len(values) == 0 or float(np.ptp(values)) <= CONSTANT * float(np.max(np.abs(values)))


def _value(column: Column) -> str:
    """Return a constant column as text."""
    values = column.values[np.isfinite(column.values)]
    return f"{column.name} = {values[0]:.4g} {column.unit}" if len(values) else f"no {column.name}"


DEGREES = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0)
"""Distances of the marks of angles in degrees."""

MOST = 12
"""Most marks of a curve."""

TOGETHER = 0.06
"""Distance of two marks, relative to the extent of the curve, below which the second one is left out."""


def with_marks(graph: CurveGraph, over: Column) -> CurveGraph:
    """Return a graph with equal axes with the values of the input, or of the time, along its curves."""
    if graph.form != EQUAL or len(over.values) < 2:
        return graph
    return replace(graph, marks=[mark for curve in graph.curves for mark in _marks(curve, over)])


def _marks(curve: Curve, over: Column) -> list[PlaceMark]:
    at = _round_values(over)
    order = np.argsort(over.values)
    knots, table = over.values[order], (np.asarray(curve.x)[order], np.asarray(curve.y)[order])
    x, y = (np.interp(at, knots, values) for values in table)
    across = 1j * sum(unit * np.interp(at, knots, np.gradient(own)) for unit, own in zip((1, 1j), table, strict=True))
    extent = max(float(np.ptp(v[np.isfinite(v)])) if np.isfinite(v).any() else 0.0 for v in (curve.x, curve.y))
    found: list[PlaceMark] = []
    for value, place, normal in zip(at.tolist(), (x + 1j * y).tolist(), np.asarray(across).tolist(), strict=True):
        apart = all(abs(place - other.place) > TOGETHER * extent for other in found)
        if math.isfinite(abs(place)) and apart:
            found.append(PlaceMark(place, _text(value, over.unit), normal if math.isfinite(abs(normal)) else 0.0j))
    return found


def _round_values(over: Column) -> FloatArray:
    low, high = float(over.values.min()), float(over.values.max())
    step = _step(high - low, over.unit == "deg")
    return step * np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1.0)


def _step(span: float, degrees: bool) -> float:
    """Return the least round distance with at most MOST distances in a span."""
    least = span / MOST * (1.0 - 1e-9)
    if degrees and DEGREES[0] <= least <= DEGREES[-1]:
        return next(step for step in DEGREES if step >= least)
    return round_above(least)


def _text(value: float, unit: str) -> str:
    return f"{value:g}°" if unit == "deg" else f"{value:.4g}"
