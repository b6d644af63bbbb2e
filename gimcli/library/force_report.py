"""The report of statistics, work and bearing loads."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from gimcli.dynamics.force_statistics import Extremum, ForceSummary


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
