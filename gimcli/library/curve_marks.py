"""Values of the input along a hodograph."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from gimcli.mechanism import FloatArray
from gimcli.output.graph import EQUAL, Curve, CurveGraph, PlaceMark
from gimcli.table import Column

DEGREES = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0)
NICE = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Distances of the marks: of angles in degrees, or times a power of ten."""

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
    power = 10.0 ** math.floor(math.log10(least)) if least > 0.0 else 1.0
    return next(power * own for own in NICE if power * own >= least * (1.0 - 1e-9))


def _text(value: float, unit: str) -> str:
    return f"{value:g}°" if unit == "deg" else f"{value:.4g}"
