"""The report of a check as tables of texts for the terminal, as a table with one value in each row, and as a page.

The page has the motion along the laws, or the initial configuration.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gimcli import graphs, output
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.rounding import ZERO, Section, at_inputs, input_value, interval, length, length_with_unit, number, spaced
from gimcli.table import Column, Table

MOST = 12
"""Greatest number of rows of a section."""

LOOP = 4
"""Number of links of a mechanism that is one loop."""

ENDS = ("least", "greatest")
"""Keys of the ends of a range."""

Rows = list[tuple[str, ...]]


def check_sections(mechanism: Mechanism, report: dict[str, Any]) -> list[Section]:
    """Return the sections that are not empty, in the order in which they are read."""
    speeds = f"Greatest speeds and accelerations (duration {number(report['duration'])} s)"
    inputs, outputs, joints = (
        [cells(mechanism, one) for one in report[key]]
        for key, cells in (("inputs", _input_cells), ("outputs", _output_cells), ("transmission", _joint_cells))
    )
    found = [
        Section("Mechanism", ("", ""), _mechanism_rows(mechanism, report)),
        Section("Inputs", ("input", "law", "range on the circuit"), inputs),
        _limited("Outputs", ("output", "range", "from", "to", "time ratio"), outputs),
        _limited("Worst transmission angles", ("joint", "angle", "at"), joints),
        _limited(speeds, ("", "speed", "at", "acceleration", "at"), _peak_rows(mechanism, report["peaks"])),
    ]
    return [section for section in found if section.rows]


def _limited(heading: str, head: tuple[str, ...], rows: Rows) -> Section:
    """Return a section with the first rows."""
    return Section(heading, head, rows[:MOST], max(0, len(rows) - MOST))


def _mechanism_rows(mechanism: Mechanism, report: dict[str, Any]) -> Rows:
    """Return type, dimensions, loops, formula, mobility, groups and initial coordinates."""
    rows: Rows = [
        ("type", report["type"]),
        *_loop_rows(mechanism, report),
        ("multiple joints", ", ".join(report["multiple_joints"])),
        ("Grübler's formula", report["formula"]),
        ("mobility", "not known" if report["mobility"] is None else str(report["mobility"])),
        ("redundant constraints", ", ".join(report["redundant"]) or "none"),
        ("undriven nodes", ", ".join(report["undriven"])),
        ("over-driven by", ", ".join(report["overdriven"])),
        ("groups", "; ".join(f"{g['kind']} ({', '.join(g['links'])})" for g in report["groups"])),
        ("initial coordinates", _moved(mechanism, report["drawing"]) if report["drawing"] else ""),
    ]
    return [(title, text) for title, text in rows if text]


def _loop_rows(mechanism: Mechanism, report: dict[str, Any]) -> Rows:
    """Return the dimensions of the mechanism if it is one loop, else one row for each loop."""
    loops = [loop for loop in report["loops"] if not loop["type"].startswith("loop")]
    texts = [
        (": ".join(filter(None, (one["type"], one["kind"]))), _dimensions(mechanism, one), _grashof(mechanism, one))
        for one in loops[:MOST]
    ]
    if report["links"] == LOOP and len(loops) == 1:
        return list(zip(("dimensions", "Grashof"), texts[0][1:], strict=True))
    return [("loop", "; ".join(filter(None, own))) for own in texts]


def _dimensions(mechanism: Mechanism, loop: dict[str, Any]) -> str:
    sizes = ", ".join(f"{name} {length(mechanism, value)}" for name, value in loop["dimensions"].items())
    return f"{sizes}{spaced(mechanism.length_unit)}" if sizes else ""


def _grashof(mechanism: Mechanism, loop: dict[str, Any]) -> str:
    """Return the comparison of the sums of lengths, for four-bar linkages."""
    if loop["grashof"] is None:
        return ""
    s, p, q, most = sorted(loop["dimensions"].values())
    sign = "=" if loop["margin"] == 0.0 else "<" if loop["margin"] > 0.0 else ">"
    sums = length(mechanism, s + most), length(mechanism, p + q)
    return f"s + l = {sums[0]} {sign} p + q = {sums[1]} (Barker: {loop['code']})"


def _moved(mechanism: Mechanism, drawing: dict[str, Any]) -> str:
    """Return how far nodes are from their initial coordinates."""
    if length(mechanism, drawing["distance"]) == "0":
        return "an assembled position"
    away, part = length_with_unit(mechanism, drawing["distance"]), number(100.0 * drawing["relative"], 100.0)
    return f"nodes move at most {away} ({part} % of the size) to the assembled position: {drawing['node']}"


def _input_cells(mechanism: Mechanism, one: dict[str, Any]) -> tuple[str, ...]:
    """Return name, law and range of an input, and what it follows."""
    name, unit, span, ends = one["name"], spaced(one["unit"]), [one[end] for end in ENDS], one["range"]
    first, last, least, most = (input_value(mechanism, name, value) for value in (*one["law"], *span))
    law = f"{first} to {last}{unit}" if one["moves"] else f"constant, {first}{unit}"
    beyond = f", between {least} and {most}{unit}" * (one["moves"] and sorted(one["law"]) != span)
    follows = f", with {' and '.join(one['follows'])}" if one["follows"] else ""
    reach = interval(mechanism, name, ends[0], ends[1], one["full_turn"]) if ends else "not known"
    return name, law + beyond + follows, reach


def _output_cells(mechanism: Mechanism, one: dict[str, Any]) -> tuple[str, ...]:
    """Return name, range, ends and time ratio of an output."""
    ratio, strokes = one["time_ratio"], one["strokes_per_turn"] or 0.0
    times = f"{number(strokes)} strokes a turn" * (strokes > 1.0) if ratio is None else number(ratio)
    at = {end: _at(mechanism, one, f"{end}_") for end in ENDS}
    if one["kind"] == "slider":
        stroke = f"stroke {length_with_unit(mechanism, one['range'])}"
        return f"{one['name']} on {one['guide']}", stroke, *at.values(), times
    swing = "full turn" if one["full_turn"] else f"swing {number(one['range'])} {one['unit']}"
    values = {end: one[end] * (abs(one[end]) > ZERO * one["range"]) for end in ENDS}
    return one["name"], swing, *(f"{number(values[end])} {one['unit']} at {at[end]}" for end in ENDS), times


def _joint_cells(mechanism: Mechanism, one: dict[str, Any]) -> tuple[str, ...]:
    """Return name, worst transmission angle and its place of a joint."""
    return f"{' / '.join(one['parts'])} at {one['node']}", f"{number(one['worst'])} {one['unit']}", _at(mechanism, one)


def _peak_rows(mechanism: Mechanism, peaks: Sequence[dict[str, Any]]) -> Rows:
    """Return greatest speed and acceleration of points and members."""
    by_name: dict[tuple[str, bool], list[str]] = {}
    for one in peaks:
        rotary, second = "angular" in one["quantity"], "acceleration" in one["quantity"]
        cells = by_name.setdefault((one["name"], rotary), ["", "", "", ""])
        text = "no bound" if math.isinf(one["greatest"]) else f"{number(one['greatest'])} {one['unit']}"
        cells[2 * second : 2 * second + 2] = text, "constant" if one["constant"] else _at(mechanism, one)
    return [(name, *cells) for (name, _), cells in by_name.items()]


def _at(mechanism: Mechanism, one: dict[str, Any], key: str = "") -> str:
    """Return the input, or the time if there are several inputs, of an extreme."""
    several = len(mechanism.drivers) > 1
    return f"time = {number(one[f'{key}time'])} s" if several else at_inputs(mechanism, one[f"{key}at"])


HEAD = ("section", "name", "quantity", "value", "unit", "at")

FACTS = ("type", "links", "pairs", "formula", "gruebler", "mobility")
LISTS = ("redundant", "undriven", "overdriven", "multiple_joints")
"""Keys of the report about the whole mechanism: one value, and lists of names."""

LAW = ("law from", "law to", "range from", "range to")


def check_table(mechanism: Mechanism, report: dict[str, Any]) -> Table:
    """Return one row for each value; numbers have all digits, `at` has the inputs."""
    length = spaced(mechanism.length_unit).strip()
    drawings = [one["drawing"] or {"nodes": {}} for one in report.get("machines", [report])]
    rows = [
        *(("mechanism", "", key, str(report[key]), "", "") for key in FACTS),
        *(("mechanism", "", key, " ".join(report[key]), "", "") for key in LISTS),
        *(
            ("loop", " ".join(loop["links"]), quantity, value, unit, "")
            for loop in report["loops"]
            for quantity, value, unit in (
                (loop["type"], loop["kind"], ""),
                *((link, repr(size), length) for link, size in loop["dimensions"].items()),
            )
        ),
        *(("group", " ".join(one["links"]), one["kind"], one["class"], "", "") for one in report["groups"]),
        *(
            ("input", one["name"], end, repr(value), spaced(one["unit"]).strip(), "")
            for one in report["inputs"]
            for end, value in zip(LAW, [*one["law"], *(one["range"] or ())], strict=False)  # the range may be unknown
        ),
        *(
            ("output", one["name"], quantity, repr(value), spaced(unit).strip(),
             "; ".join(at_inputs(mechanism, one[f"{end}_at"]) for end in ENDS))
            for one in report["outputs"]
            for quantity, value, unit in (
                ("stroke" if one["kind"] == "slider" else "swing", one["range"], one["unit"]),
                ("time ratio", one["time_ratio"], ""),
            )
            if value is not None
        ),
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


def check_page(
    mechanism: Mechanism, motion: Motion | None, z: ComplexArray | None, sections: Sequence[Section],
    warnings: Sequence[str], note: str = "",
) -> output.animation.Animation:  # fmt: skip
    """Return a page with the report and the motion, or else with a position z (nodes,) and a note on it."""
    moving = (
        None
        if motion is None
        else graphs.motion_animation.law_animation(motion, graphs.extras.Extras(mechanism), len(motion.time) - 1)
    )
    shown = moving or output.animation.Animation(mechanism.name, mechanism, (_position(mechanism, z, note),))
    last = [Section("Warnings", warnings=tuple(warnings))] if warnings else []
    return replace(shown, report=(*sections, *last))


def _position(mechanism: Mechanism, z: ComplexArray | None, note: str) -> output.animation.Clip:
    """Return a clip of one row; without a position it is empty, and the page shows the initial coordinates."""
    status = "not-assembled" if z is None else "ok"
    place = np.full(len(mechanism.nodes), complex(np.nan, np.nan)) if z is None else mechanism.to_file(z)
    table = Table((Column("time", np.zeros(1), "s"), Column("status", np.array([status]))))
    return output.animation.Clip(
        note or "initial configuration", place[None, :], np.zeros(1), (status,), table, note=note
    )
