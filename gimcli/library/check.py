"""Check a model: what the mechanism is, what its motion does, and what in the file is doubtful."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from gimcli import output
from gimcli.branching.singular_positions import drawn_circuit
from gimcli.branching.singularities import input_ends, interval, limits
from gimcli.continuation.circuit import Circuit
from gimcli.errors import GimError, StructureError
from gimcli.library.check_views import check_page, check_sections, check_table
from gimcli.library.check_warnings import file_warnings, motion_warnings
from gimcli.library.inputs import in_file_units, interval_of, leaders
from gimcli.library.machines import joined_reports
from gimcli.library.mobility import mobility
from gimcli.library.result import Result
from gimcli.mechanism import Mechanism
from gimcli.motion.motion import trace
from gimcli.motion.solve import solve
from gimcli.positions.inputs import law_inputs
from gimcli.positions.options import TOLERANCE, Options
from gimcli.positions.position import Position
from gimcli.progress import Phases, no_phases
from gimcli.quantities.initial_coordinates import initial_coordinates
from gimcli.quantities.motion_summary import MotionSummary, Output, Peak, motion_summary
from gimcli.quantities.quantity import angle_to_file
from gimcli.rounding import Section
from gimcli.status import Status
from gimcli.structure.drive_check import explained
from gimcli.structure.loop_types import LoopType
from gimcli.structure.mechanism_types import MechanismType, mechanism_type
from gimcli.structure.mobility import assembled
from gimcli.table import Table, per_second

DRAWN = 360
"""Steps of the motion on the page of several machines."""

OTHER_INPUTS = "an assembled position at other inputs than those of the law"
"""The note on the position of a page, where the start of the law cannot be assembled."""

NOT_DRIVEN = "not driven"
"""The status of a mechanism that the inputs do not drive."""

FULL_TURN = 2.0 * math.pi * (1.0 - 1e-9)
"""The least range of a full turn [rad]."""

QUANTITIES = {
    (False, 1): "speed", (False, 2): "acceleration", (True, 1): "angular speed", (True, 2): "angular acceleration",
}  # fmt: skip


def check(mechanism: Mechanism, *, progress: Phases = no_phases) -> CheckResult:
    """Check a model: type, mobility, ranges, strokes, transmission angles, greatest speeds, and warnings.

    Args:
        mechanism: from `load` or `loads`.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.

    Returns:
        A CheckResult: `.type`, `.warnings`, and `report()` with all numbers in the file's units. A mechanism that is
        not assembled or not fully driven has no motion; a warning states why. Of several independent machines each has
        its sections, and its report in `report()["machines"]`.
    """
    return CheckResult(mechanism, progress) if len(mechanism.machines) == 1 else MachinesCheck(mechanism, progress)


class CheckResult(Result):
    """The report on a model; `print` shows it."""

    KIND = "check"

    def __init__(self, mechanism: Mechanism, progress: Phases = no_phases, whole: bool = True) -> None:
        """Find everything; `whole`: it is the whole file, whose own warnings are in the report."""
        self.mechanism, self.error, self.whole = mechanism, "", whole  # error: why there is no motion
        self._found = self._position()
        self._kind = self._type()
        moves = bool(mechanism.actuators) and not self.error
        progress("following the circuit")
        self._circuit = self._followed() if moves else None
        progress("searching extremes of the motion")
        self._summary = self._extremes() if moves else None

    @property
    def type(self) -> str:
        """The type of each machine, such as "four-bar linkage: crank-rocker" or "Watt II six-bar"."""
        return str(self.report()["type"])

    @property
    def warnings(self) -> list[dict[str, str]]:
        """The warnings: file and line ("where", which may be empty), and the text."""
        return list(self.report()["warnings"])

    @property
    def remarks(self) -> list[str]:
        """The warnings as lines."""
        return [f"warning: {text}" for text in self._texts]

    @property
    def _texts(self) -> list[str]:
        """The warnings as lines: where, and what."""
        return [": ".join(filter(None, (one["where"], one["text"]))) for one in self.warnings]

    @property
    def complete(self) -> bool:
        """Whether the mechanism, that is all its machines, are assembled."""
        return self.report()["status"] in (Status.OK.word, NOT_DRIVEN)

    def headline(self) -> str:
        """Return the result in one line."""
        count = len(self.warnings)
        return f"{self.mechanism.name}: {self.type}; {count or 'no'} warning{'s' * (count != 1)}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        return self._report

    def _sections(self) -> list[Section]:
        """Return the report as tables of texts, for people."""
        return check_sections(self.mechanism, self.report())

    def table(self) -> Table:
        """Return one row for each value of the report: section, name, quantity, value, unit, at."""
        return check_table(self.mechanism, self.report())

    def animation(self) -> output.animation.Animation:
        """Return the page: the report, and the motion along the laws if there is one."""
        motion = self._summary.motion if self._summary else None
        z = self._found.z if self._found is not None and not self.error else assembled(self.mechanism)
        note = OTHER_INPUTS if self.error and z is not None else ""
        return check_page(self.mechanism, motion, z, self._sections(), self._texts, note)

    def __repr__(self) -> str:
        texts = [text for section in self._sections() for text in ("", section.heading, *section.lines())]
        return "\n".join([self.headline(), *texts, *self.remarks])

    # -- the parts ------------------------------------------------------------------------------

    def _position(self) -> Position | None:
        """Return the position at the inputs of the drawing; None if the inputs do not drive the mechanism."""
        mechanism = self.mechanism
        try:
            with explained(mechanism):
                position = solve(mechanism, mechanism.drawn_inputs, Options(tolerance=TOLERANCE))
        except StructureError as error:
            self.error = str(error)
            return None
        if position.status.value:
            from gimcli.motion.unassembled import reason

            self.error = f"{position.status.word}: {reason(mechanism, position.status, position.inputs)}"
        return position

    def _type(self) -> MechanismType:
        z = self._found.z if self._found is not None and not self.error else assembled(self.mechanism)
        return mechanism_type(self.mechanism, self.mechanism.drawn if z is None else z)

    def _followed(self) -> Circuit | None:
        """Return the circuit of the start of the laws; None if it is not known."""
        with suppress(GimError):
            return drawn_circuit(self.mechanism, TOLERANCE)
        return None

    @cached_property
    def _limits(self) -> list[Any]:
        return limits(self._circuit) if self._circuit is not None else []

    def _extremes(self) -> MotionSummary | None:
        curve = self._circuit.curve if self._circuit is not None else None
        ends = [(curve.nodes(one.p), curve.inputs(one.p)) for one in self._limits if curve is not None]
        try:
            with explained(self.mechanism):
                return motion_summary(self.mechanism, TOLERANCE, ends)
        except StructureError as error:
            self.error = str(error)
            return None

    # -- the report -----------------------------------------------------------------------------

    @cached_property
    def _report(self) -> dict[str, Any]:
        summary = self._summary
        report: dict[str, Any] = {
            **self._structure(), "duration": self.mechanism.duration, "inputs": self._inputs(),
            "solved": summary.motion.solved if summary else 0, "rows": len(summary.motion.time) if summary else 0,
            "outputs": [self._output(one) for one in summary.outputs] if summary else [],
            "transmission": self._transmission(),
            "peaks": [self._peak(one) for one in summary.peaks] if summary else [],
            "drawing": self._drawing(),
        }  # fmt: skip
        of_file = file_warnings(self.mechanism, self.error) if self.whole else []
        return report | {
            "warnings": motion_warnings(self.mechanism, report, self.error) + of_file,
            "status": NOT_DRIVEN if self._found is None else self._found.status.word,
        }

    def _structure(self) -> dict[str, Any]:
        chain, formation = self._kind.chain, self._kind.formation
        try:
            found = mobility(self.mechanism).report()
        except StructureError:
            found = dict.fromkeys(("mobility", "start")) | {"redundant": [], "undriven": [], "overdriven": []}
        return {
            "type": self._kind.name, "links": len(chain.links), "pairs": chain.pairs,
            "couplings": list(chain.couplings), "multiple_joints": list(chain.multiple), "formula": chain.formula,
            "gruebler": chain.gruebler, "mobility": found["mobility"], "redundant": found["redundant"],
            "undriven": found["undriven"], "overdriven": found["overdriven"], "start": found["start"],
            "loops": [self._loop(loop) for loop in self._kind.loops],
            "groups": [] if formation is None else [
                {"kind": g.description, "class": g.numeral, "links": [formation.links[k] for k in g.links]}
                for g in formation.groups
            ],
        }  # fmt: skip

    def _loop(self, found: LoopType) -> dict[str, Any]:
        bar, scale = found.four_bar, self.mechanism.scale
        return {
            "type": found.name, "kind": found.kind, "links": [self._kind.chain.links[k] for k in found.loop.links],
            "pairs": found.loop.kinds, "dimensions": {name: v * scale for name, v in found.dimensions.items()},
            "code": bar.code if bar else None, "grashof": bar.grashof if bar else None,
            "margin": bar.excess * scale if bar else None, "near_change_point": bar.near_change_point if bar else None,
        }  # fmt: skip

    def _inputs(self) -> list[dict[str, Any]]:
        mechanism, summary, reach = self.mechanism, self._summary, self._reach()
        laws = law_inputs(mechanism)(np.linspace(0.0, 1.0, 1001)) if mechanism.actuators else np.zeros((0, 1))
        values = [mechanism.value_to_file(k, law) for k, law in enumerate(laws)]
        limit = self._at(summary.motion.limit) if summary and summary.motion.limit is not None else {}
        turn = self._in_file(FULL_TURN) if self._circuit is not None and self._circuit.turning else math.inf
        return [
            {
                "name": one.name, "unit": mechanism.unit_of(one), "follows": leaders(mechanism, k),
                "law": [float(own[0]), float(own[-1])], "least": float(own.min()), "greatest": float(own.max()),
                "moves": bool(np.ptp(laws[k]) > 0.0), "range": reach.get(one.name),
                "full_turn": one.rotary and float(np.ptp(reach[one.name])) >= turn if reach else None,
                "limit": limit.get(one.name),
            }
            for k, (one, own) in enumerate(zip(mechanism.actuators, values, strict=True))
        ]  # fmt: skip

    def _reach(self) -> dict[str, list[float]]:
        """Return the interval of every input on the circuit; empty if the circuit is not known."""
        if self._circuit is None:
            return {}
        ends = input_ends(self._circuit, interval(self._circuit, self._limits))
        return interval_of(*(in_file_units(self.mechanism, end) for end in ends))

    def _at(self, time: float) -> dict[str, float]:
        """Return the inputs at a normalised time in the file's units."""
        return in_file_units(self.mechanism, law_inputs(self.mechanism)(np.array([time]))[:, 0])

    def _in_file(self, value: float, slides: bool = False) -> float:
        """Return an angle, or a length, in the file's unit."""
        return value * self.mechanism.scale if slides else float(angle_to_file(self.mechanism, np.array([value]))[0])

    def _output(self, one: Output) -> dict[str, Any]:
        mechanism, ends = self.mechanism, [one.found.least, one.found.greatest]
        return {
            "name": one.name, "kind": "slider" if one.slides else "link", "guide": one.guide or None,
            "unit": mechanism.length_unit if one.slides else mechanism.angle_unit,
            "range": self._in_file(one.range, one.slides),
            "least": None if one.slides else self._in_file(ends[0].value),
            "greatest": None if one.slides else self._in_file(ends[1].value),
            "full_turn": not one.slides and one.range >= FULL_TURN,
            "least_at": self._at(ends[0].time), "greatest_at": self._at(ends[1].time),
            "least_time": ends[0].time * mechanism.duration, "greatest_time": ends[1].time * mechanism.duration,
            "time_ratio": one.time_ratio, "strokes_per_turn": one.strokes or None,
        }  # fmt: skip

    def _transmission(self) -> list[dict[str, Any]]:
        mechanism = self.mechanism
        return [
            {
                "node": mechanism.nodes[one.joint.node], "parts": [one.joint.first.name, one.joint.second.name],
                "worst": self._in_file(one.angle), "unit": mechanism.angle_unit,
                "at": self._at(one.time), "time": one.time * mechanism.duration,
            }
            for one in (self._summary.angles if self._summary else ())
        ]  # fmt: skip

    def _peak(self, one: Peak) -> dict[str, Any]:
        mechanism = self.mechanism
        return {
            "name": one.name, "quantity": QUANTITIES[one.rotary, one.order],
            "greatest": self._in_file(one.found.value, not one.rotary),
            "unit": per_second(mechanism.angle_unit if one.rotary else mechanism.length_unit, one.order),
            "at": self._at(one.found.time), "time": one.found.time * mechanism.duration, "constant": one.constant,
        }  # fmt: skip

    def _drawing(self) -> dict[str, Any] | None:
        """Return how far the assembled position is from the initial coordinates; None if there is none."""
        if self._found is None or self.error:
            return None
        mechanism = self.mechanism
        found = initial_coordinates(mechanism, self._found.z)
        away = (np.abs(self._found.z - mechanism.drawn) * mechanism.scale).tolist()
        return {
            "node": mechanism.nodes[found.farthest], "distance": away[found.farthest],
            "relative": float(np.max(found.distance)) / mechanism.size,
            "nodes": dict(zip(mechanism.nodes, away, strict=True)),
            "far": [mechanism.nodes[k] for k in found.far(mechanism)],
            "mirrored_members": list(found.mirrored_members),
            "mirrored_joints": [list(one) for one in found.mirrored_joints],
        }  # fmt: skip


class MachinesCheck(CheckResult):
    """The reports on independent machines of one file."""

    def __init__(self, mechanism: Mechanism, progress: Phases = no_phases) -> None:
        self.mechanism = mechanism
        self.each = {one.name: CheckResult(one.mechanism, progress, whole=False) for one in mechanism.machines}
        self.error = "; ".join(f"{name}: {one.error}" for name, one in self.each.items() if one.error)

    def _sections(self) -> list[Section]:
        """Return the sections of each machine; their headings begin with its name."""
        return [
            replace(own, heading=f"{name}: {own.heading}") for name, one in self.each.items() for own in one._sections()
        ]

    def animation(self) -> output.animation.Animation:
        """Return the page: the reports, and the motion along the laws if all machines have one."""
        motion = None if self.error else trace(self.mechanism, DRAWN, Options(tolerance=TOLERANCE))
        return check_page(self.mechanism, motion, assembled(self.mechanism), self._sections(), self._texts)

    @cached_property
    def _report(self) -> dict[str, Any]:
        reports = {name: one.report() for name, one in self.each.items()}
        report = joined_reports(reports)
        report["warnings"] += file_warnings(self.mechanism, self.error)
        return {**report, "machines": [{"name": name, **own} for name, own in reports.items()]}
