"""The report of a check as a table with one value in each row."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gimcli.library.rounding import at_inputs
from gimcli.mechanism import Mechanism
from gimcli.table import Column, Table

HEAD = ("section", "name", "quantity", "value", "unit", "at")

Row = tuple[str, str, str, str, str, str]


def check_table(mechanism: Mechanism, report: dict[str, Any]) -> Table:
    """Return one row for each value; numbers have all digits, `at` has the inputs."""
    warnings = [("warning", one["where"], "", one["text"], "", "") for one in report["warnings"]]
    rows = [*_structure(mechanism, report), *_motion(mechanism, report), *warnings]
    return Table(tuple(Column(n, np.array(c, dtype=str)) for n, c in zip(HEAD, zip(*rows, strict=True), strict=True)))


def _structure(mechanism: Mechanism, report: dict[str, Any]) -> Iterator[Row]:
    for key in ("type", "links", "pairs", "formula", "gruebler", "mobility"):
        yield "mechanism", "", key, str(report[key]), "", ""
    for key in ("redundant", "undriven", "overdriven", "multiple_joints"):
        yield "mechanism", "", key, " ".join(report[key]), "", ""
    for loop in report["loops"]:
        name = " ".join(loop["links"])
        yield "loop", name, loop["type"], loop["kind"], "", ""
        for link, value in loop["dimensions"].items():
            yield "loop", name, link, repr(value), _unit(mechanism.length_unit), ""
    for group in report["groups"]:
        yield "group", " ".join(group["links"]), group["kind"], group["class"], "", ""


def _motion(mechanism: Mechanism, report: dict[str, Any]) -> Iterator[Row]:
    def at(inputs: dict[str, float]) -> str:
        return at_inputs(mechanism, inputs)

    for one in report["inputs"]:
        ends = {"law from": one["law"][0], "law to": one["law"][1]}
        if one["range"]:
            ends |= {"range from": one["range"][0], "range to": one["range"][1]}
        for quantity, value in ends.items():
            yield "input", one["name"], quantity, repr(value), _unit(one["unit"]), ""
    for one in report["outputs"]:
        what = "stroke" if one["kind"] == "slider" else "swing"
        where = f"{at(one['least_at'])}; {at(one['greatest_at'])}"
        yield "output", one["name"], what, repr(one["range"]), _unit(one["unit"]), where
        if one["time_ratio"] is not None:
            yield "output", one["name"], "time ratio", repr(one["time_ratio"]), "", where
    for one in report["transmission"]:
        yield "transmission", "/".join(one["parts"]), "worst angle", repr(one["worst"]), one["unit"], at(one["at"])
    for one in report["peaks"]:
        yield "greatest", one["name"], one["quantity"], repr(one["greatest"]), one["unit"], at(one["at"])
    for one in report.get("machines", [report]):
        for node, away in (one["drawing"] or {"nodes": {}})["nodes"].items():
            yield "initial coordinates", node, "distance", repr(away), _unit(mechanism.length_unit), ""


def _unit(unit: str) -> str:
    return "" if unit == "unit" else unit
