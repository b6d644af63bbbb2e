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
from gimcli.rounding import ZERO, Section, at_inputs, input_value, interval, length, number
from gimcli.table import Column, Table

MOST = 12
"""Greatest number of rows of a section."""

LOOP = 4
"""Number of links of a mechanism that is one loop."""

Rows = list[tuple[str, ...]]


def check_sections(mechanism: Mechanism, report: dict[str, Any]) -> list[Section]:
    """Return the sections that are not empty, in the order in which they are read."""
    texts = _Texts(mechanism, report)
    speeds = f"Greatest speeds and accelerations (duration {number(report['duration'])} s)"
    found = [
        Section("Mechanism", ("", ""), texts.mechanism()),
        Section("Inputs", ("input", "law", "range on the circuit"), texts.inputs()),
        _limited("Outputs", ("output", "range", "from", "to", "time ratio"), texts.outputs()),
        _limited("Worst transmission angles", ("joint", "angle", "at"), texts.transmission()),
        _limited(speeds, ("", "speed", "at", "acceleration", "at"), texts.peaks()),
    ]
    return [section for section in found if section.rows]


def _limited(heading: str, head: tuple[str, ...], rows: Rows) -> Section:
    """Return a section with the first rows."""
    return Section(heading, head, rows[:MOST], max(0, len(rows) - MOST))


class _Texts:
    def __init__(self, mechanism: Mechanism, report: dict[str, Any]) -> None:
        self.own, self.report = mechanism, report
        self.unit = _unit(mechanism.length_unit)

    def mechanism(self) -> Rows:
        """Return type, dimensions, loops, formula, mobility, groups and initial coordinates."""
        report = self.report
        rows: Rows = [
            ("type", report["type"]),
            *self._loops(),
            ("multiple joints", ", ".join(report["multiple_joints"])),
            ("Grübler's formula", report["formula"]),
            ("mobility", "not known" if report["mobility"] is None else str(report["mobility"])),
            ("redundant constraints", ", ".join(report["redundant"]) or "none"),
            ("undriven nodes", ", ".join(report["undriven"])),
            ("over-driven by", ", ".join(report["overdriven"])),
            ("groups", "; ".join(f"{g['kind']} ({', '.join(g['links'])})" for g in report["groups"])),
        ]
        return [*((title, text) for title, text in rows if text), *self._drawing()]

    def _loops(self) -> Rows:
        """Return the dimensions of the mechanism if it is one loop, else one row for each loop."""
        loops = [loop for loop in self.report["loops"] if not loop["type"].startswith("loop")]
        if self.report["links"] == LOOP and len(loops) == 1:
            sizes, rule = self._dimensions(loops[0]), self._grashof(loops[0])
            return [*([("dimensions", sizes)] if sizes else []), *([("Grashof", rule)] if rule else [])]
        texts = [f"{loop['type']}: {loop['kind']}" if loop["kind"] else loop["type"] for loop in loops[:MOST]]
        parts = ((text, self._dimensions(one), self._grashof(one)) for text, one in zip(texts, loops, strict=False))
        return [("loop", "; ".join(filter(None, own))) for own in parts]

    def _dimensions(self, loop: dict[str, Any]) -> str:
        sizes = ", ".join(f"{name} {length(self.own, value)}" for name, value in loop["dimensions"].items())
        return f"{sizes}{self.unit}" if sizes else ""

    def _grashof(self, loop: dict[str, Any]) -> str:
        """Return the comparison of the sums of lengths, for four-bar linkages."""
        if loop["grashof"] is None:
            return ""
        s, p, q, most = sorted(loop["dimensions"].values())
        sign = "=" if loop["margin"] == 0.0 else "<" if loop["margin"] > 0.0 else ">"
        sums = length(self.own, s + most), length(self.own, p + q)
        return f"s + l = {sums[0]} {sign} p + q = {sums[1]} (Barker: {loop['code']})"

    def _drawing(self) -> Rows:
        """Return how far nodes are from their initial coordinates."""
        drawing = self.report["drawing"]
        if drawing is None:
            return []
        away, part = length(self.own, drawing["distance"]), number(100.0 * drawing["relative"], 100.0)
        moved = f"nodes move at most {away}{self.unit} ({part} % of the size) to the assembled position"
        return [("initial coordinates", "an assembled position" if away == "0" else f"{moved}: {drawing['node']}")]

    def inputs(self) -> Rows:
        """Return law and range of each input."""
        return [
            (
                one["name"], self._law(one),
                interval(self.own, one["name"], one["range"][0], one["range"][1], one["full_turn"])
                if one["range"]
                else "not known",
            )
            for one in self.report["inputs"]
        ]  # fmt: skip

    def _law(self, one: dict[str, Any]) -> str:
        """Return the law of an input, and what it follows."""
        unit, keys = _unit(one["unit"]), ("least", "greatest")
        first, last, least, most = (input_value(self.own, one["name"], v) for v in (*one["law"], *map(one.get, keys)))
        law = f"{first} to {last}{unit}" if one["moves"] else f"constant, {first}{unit}"
        beyond = one["moves"] and sorted(one["law"]) != [one["least"], one["greatest"]]
        follows = f", with {' and '.join(one['follows'])}" if one["follows"] else ""
        return law + f", between {least} and {most}{unit}" * beyond + follows

    def outputs(self) -> Rows:
        """Return range, ends and time ratio of each output."""
        return [self._output(one) for one in self.report["outputs"]]

    def _output(self, one: dict[str, Any]) -> tuple[str, ...]:
        slider = one["kind"] == "slider"
        unit = _unit(one["unit"])
        name = f"{one['name']} on {one['guide']}" if slider else one["name"]
        ratio, strokes = one["time_ratio"], one["strokes_per_turn"] or 0.0
        times = f"{number(strokes)} strokes a turn" * (strokes > 1.0) if ratio is None else number(ratio)
        if slider:
            ends = [self._at(one, key) for key in ("least_", "greatest_")]
            return name, f"stroke {length(self.own, one['range'])}{unit}", *ends, times
        values = {key: one[key] * (abs(one[key]) > ZERO * one["range"]) for key in ("least", "greatest")}
        ends = [f"{number(value)}{unit} at {self._at(one, f'{key}_')}" for key, value in values.items()]
        return name, "full turn" if one["full_turn"] else f"swing {number(one['range'])}{unit}", *ends, times

    def transmission(self) -> Rows:
        """Return the worst transmission angle of each joint."""
        return [
            (
                f"{' / '.join(one['parts'])} at {one['node']}", f"{number(one['worst'])} {one['unit']}",
                self._at(one),
            )
            for one in self.report["transmission"]
        ]  # fmt: skip

    def peaks(self) -> Rows:
        """Return greatest speed and acceleration of points and members."""
        by_name: dict[tuple[str, bool], list[str]] = {}
        for one in self.report["peaks"]:
            rotary, second = "angular" in one["quantity"], "acceleration" in one["quantity"]
            cells = by_name.setdefault((one["name"], rotary), ["", "", "", ""])
            value = one["greatest"]
            text = "no bound" if math.isinf(value) else f"{number(value)} {one['unit']}"
            cells[2 * second : 2 * second + 2] = text, "constant" if one["constant"] else self._at(one)
        return [(name, *cells) for (name, _), cells in by_name.items()]

    def _at(self, one: dict[str, Any], key: str = "") -> str:
        """Return the input, or the time if there are several inputs, of an extreme."""
        if len(self.own.drivers) > 1:
            return f"time = {number(one[f'{key}time'])} s"
        return at_inputs(self.own, one[f"{key}at"])


def _unit(unit: str) -> str:
    """Return a unit after a space; nothing where lengths have no physical unit."""
    return "" if unit == "unit" else f" {unit}"


HEAD = ("section", "name", "quantity", "value", "unit", "at")

FACTS = ("type", "links", "pairs", "formula", "gruebler", "mobility")
LISTS = ("redundant", "undriven", "overdriven", "multiple_joints")
"""Keys of the report about the whole mechanism: one value, and lists of names."""

ENDS = ("law from", "law to", "range from", "range to")


def check_table(mechanism: Mechanism, report: dict[str, Any]) -> Table:
    """Return one row for each value; numbers have all digits, `at` has the inputs."""
    length = _unit(mechanism.length_unit).strip()
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
    return [("input", one["name"], end, repr(value), _unit(one["unit"]).strip(), "") for end, value in ends]


def _output(mechanism: Mechanism, one: dict[str, Any]) -> Rows:
    where = "; ".join(at_inputs(mechanism, one[f"{end}_at"]) for end in ("least", "greatest"))
    what, ratio = "stroke" if one["kind"] == "slider" else "swing", one["time_ratio"]
    ratios: Rows = [("output", one["name"], "time ratio", repr(ratio), "", where)] * (ratio is not None)
    return [("output", one["name"], what, repr(one["range"]), _unit(one["unit"]).strip(), where), *ratios]


def check_page(
    mechanism: Mechanism, motion: Motion | None, z: ComplexArray | None, sections: Sequence[Section],
    warnings: Sequence[str], note: str = "",
) -> output.animation.Animation:  # fmt: skip
    """Return a page with the report and the motion, or else with a position z (nodes,) and a note on it."""
    shown = (
        None
        if motion is None
        else graphs.motion_animation.law_animation(motion, graphs.extras.Extras(mechanism), len(motion.time) - 1)
    )
    if shown is None:
        shown = output.animation.Animation(mechanism.name, mechanism, (_position(mechanism, z, note),))
    last = [Section("Warnings", warnings=tuple(warnings))] if warnings else []
    return replace(shown, report=(*sections, *last))


def _position(mechanism: Mechanism, z: ComplexArray | None, note: str) -> output.animation.Clip:
    """Return a clip of one row; without a position it is empty, and the page shows the initial coordinates."""
    status = "not-assembled" if z is None else "ok"
    place = np.full(len(mechanism.nodes), complex(np.nan, np.nan)) if z is None else mechanism.to_file(z)
    table = Table((Column("time", np.zeros(1), "s"), Column("status", np.array([status]))))
    name = note or "initial configuration"
    return output.animation.Clip(name, place[None, :], np.zeros(1), (status,), table, note=note)
