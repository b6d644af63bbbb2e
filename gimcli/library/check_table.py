"""The report of a check as a table with one value in each row."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.library.rounding import at_inputs
from gimcli.mechanism import Mechanism
from gimcli.table import Column, Table

HEAD = ("section", "name", "quantity", "value", "unit", "at")

FACTS = ("type", "links", "pairs", "formula", "gruebler", "mobility")
LISTS = ("redundant", "undriven", "overdriven", "multiple_joints")
"""Keys of the report about the whole mechanism: one value, and lists of names."""

ENDS = ("law from", "law to", "range from", "range to")

Rows = list[tuple[str, str, str, str, str, str]]


def check_table(mechanism: Mechanism, report: dict[str, Any]) -> Table:
    """Return one row for each value; numbers have all digits, `at` has the inputs."""
    length = _unit(mechanism.length_unit)
    drawings = [one["drawing"] or {"nodes": {}} for one in report.get("machines", [report])]
    rows = [
        *(("mechanism", "", key, str(report[key]), "", "") for key in FACTS),
        *(("mechanism", "", key, " ".join(report[key]), "", "") for key in LISTS),
        *(row for loop in report["loops"] for row in _loop(loop, length)),
        *(("group", " ".join(one["links"]), one["kind"], one["class"], "", "") for one in report["groups"]),
        *(row for one in report["inputs"] for row in _input(one)),
        *(row for one in report["outputs"] for row in _output(mechanism, one)),
        *(
            ("transmission", "/".join(one["parts"]), "worst angle", repr(one["worst"]), one["unit"],
             at_inputs(mechanism, one["at"]))
            for one in report["transmission"]
        ),
        *(
            ("greatest", one["name"], one["quantity"], repr(one["greatest"]), one["unit"],
             at_inputs(mechanism, one["at"]))
            for one in report["peaks"]
        ),
        *(
            ("initial coordinates", node, "distance", repr(away), length, "")
            for one in drawings for node, away in one["nodes"].items()
        ),
        *(("warning", one["where"], "", one["text"], "", "") for one in report["warnings"]),
    ]  # fmt: skip
    return Table(tuple(Column(n, np.array(c, dtype=str)) for n, c in zip(HEAD, zip(*rows, strict=True), strict=True)))


def _loop(loop: dict[str, Any], unit: str) -> Rows:
    name = " ".join(loop["links"])
    sizes: Rows = [("loop", name, link, repr(value), unit, "") for link, value in loop["dimensions"].items()]
    return [("loop", name, loop["type"], loop["kind"], "", ""), *sizes]


def _input(one: dict[str, Any]) -> Rows:
    ends = zip(ENDS, [*one["law"], *(one["range"] or ())], strict=False)  # the range may be unknown
    return [("input", one["name"], end, repr(value), _unit(one["unit"]), "") for end, value in ends]


def _output(mechanism: Mechanism, one: dict[str, Any]) -> Rows:
    where = "; ".join(at_inputs(mechanism, one[f"{end}_at"]) for end in ("least", "greatest"))
    what, ratio = "stroke" if one["kind"] == "slider" else "swing", one["time_ratio"]
    ratios: Rows = [("output", one["name"], "time ratio", repr(ratio), "", where)] * (ratio is not None)
    return [("output", one["name"], what, repr(one["range"]), _unit(one["unit"]), where), *ratios]


def _unit(unit: str) -> str:
    return "" if unit == "unit" else unit
