"""The usual graphs of forces, which of them show more than a constant, and what a report says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from gimcli.dynamics.force_statistics import Extremum, ForceSummary
from gimcli.library.plots import PlannedCurve, PlannedGraph, plotted
from gimcli.mechanism import Mechanism
from gimcli.output.graph import ORDINARY
from gimcli.table import Column


def summary_report(found: ForceSummary) -> dict[str, Any]:
    """Return the entries of the JSON report; undetermined numbers become null."""
    statistics = {
        name: {
            "unit": one.unit, "mean": one.mean, "rms": one.rms, "least": _place(one.least),
            "greatest": _place(one.greatest), "part": one.part,
        }
        for name, one in found.statistics.items()
    }  # fmt: skip
    peaks = {
        name: {"value": one.peak.value, "unit": one.unit, "time": one.peak.time, "at": one.peak.inputs}
        for name, one in found.statistics.items()
    }
    return {
        "peaks": peaks, "statistics": statistics, "closed": found.closed,
        "work": {name: {**asdict(one), "net": one.net} for name, one in found.work.items()},
        "bearings": {name: asdict(one) for name, one in found.bearings.items()},
    }  # fmt: skip


def _place(one: Extremum) -> dict[str, Any]:
    return {"value": one.value, "time": one.time, "at": one.inputs}


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
