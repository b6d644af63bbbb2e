"""Find the driving efforts and the reactions of a prescribed motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli import output
from gimcli.dynamics.force_motion import BearingLoad, ForceMotion, Work, force_table
from gimcli.dynamics.force_statistics import Extremum, ForceStatistics, ForceSummary, Statistic, amounts
from gimcli.dynamics.physical import require_action
from gimcli.graphs.extras import Extras, texts
from gimcli.graphs.plots import PlannedGraph, drawn, usual_graphs, varying, with_marks
from gimcli.library.inputs import Jit, Steps, Tolerance, checked, refuse_unmoved
from gimcli.library.machine_forces import ForcesBeside, MachineForces
from gimcli.library.machines import accepted, loaded_machines
from gimcli.library.record import Records, RowField
from gimcli.library.result import RowsResult, UnderWay, in_parts
from gimcli.library.trace_result import MotionUnderWay
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.motion import Motion, stream
from gimcli.motion.summary import events, reachable
from gimcli.positions.inputs import law_inputs
from gimcli.positions.options import Options
from gimcli.progress import Notify, Phases, no_phases
from gimcli.quantities.motion_table import input_or_time, motion_events
from gimcli.quantities.state import MotionState, State
from gimcli.rounding import greatest, input_value, number
from gimcli.table import Column, Table, labelled

DRAWN = 4096
"""Most rows between which angles of springs are continued where extremes are refined."""

CLOSE = 1e-12
"""Difference of normalised times that have the same position."""

FORCES = ("N", "N m", "W")
"""Units of columns that are not bounded near singular positions."""


@in_parts
@checked
def forces(
    mechanism: Mechanism, steps: Steps = 360, *, tolerance: Tolerance = 1e-10, jit: Jit = "auto",
    measure: str | Sequence[str] = (), plot: str | Sequence[str] = (), notify: Notify | None = None,
    progress: Phases = no_phases,
) -> UnderWay[ForcesResult | MachineForces]:  # fmt: skip
    """Find driving efforts, reactions and shaking force along the actuators' laws (inverse dynamics).

    Args:
        mechanism: from `load` or `loads`; it needs masses, loads, springs, dampers or friction.
        steps: number of steps, 1 to 10 000 000; the result has steps + 1 rows.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        measure: quantities that are added to the columns, a text or a list, such as "P.vx" or "hypot(A.fx, A.fy)".
        plot: the graphs of the picture, a text or a list, such as "effort,|A.f|,reactions" (see `gim manual graphs`);
            by default the efforts.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (rows done, all rows), for a progress bar.

    Returns:
        A ForcesResult: forces [N], torques [N m] and powers [W] as the columns of the CSV file, by name, (rows,); NaN
        where they are not determined. `.statistics[name]` has mean, RMS, least and greatest value of an effort,
        reaction or moment, `.work[name]` the work of an actuator or a kind of force, `.bearings[name]` the mean load
        of a pin. Of several independent machines a MachineForces, whose `each` has one by the name of each machine.

    Raises:
        UsageError: an invalid argument.
        ModelError: no masses, loads, springs, dampers or friction are defined.
        StructureError: the mechanism has no actuator, or is not fully driven, over-driven or contradictory.
    """
    require_action(mechanism)
    refuse_unmoved(mechanism, "add an actuator")
    every = loaded_machines(mechanism)
    if len(every) == 1:
        return ForcesAlong(every[0].mechanism, steps, tolerance, jit, measure, plot, notify, progress)
    begun = {one.name: ForcesAlong(one.mechanism, steps, tolerance, jit, (), (), notify, progress) for one in every}
    return ForcesBeside(mechanism, begun, texts(measure), texts(plot))


class ForcesResult(RowsResult):
    """Driving efforts, reactions, shaking force and powers along a motion, as columns by name."""

    KIND = "forces"

    def __init__(self, along: ForcesAlong, table: Table | None) -> None:
        super().__init__(along, table)
        self._along, self._found, self.steps = along, along.found, along.steps

    @cached_property
    def _summary(self) -> ForceSummary:
        """Statistics, work and mean bearing loads; extremes are refined between the rows."""
        return self._along.statistics.summary(self._amounts_at, self._inputs_at)

    @property
    def statistics(self) -> dict[str, Statistic]:
        """Mean, RMS, least and greatest value of every effort, reaction and moment by name."""
        return self._summary.statistics

    @property
    def work(self) -> dict[str, Work]:
        """Positive and negative work [J] of every actuator and of every kind of force."""
        return self._summary.work

    @property
    def bearings(self) -> dict[str, BearingLoad]:
        """Mean load [N] and speed [rev/min] of every pin, by the name of its reaction."""
        return self._summary.bearings

    def _amounts_at(self, times: FloatArray) -> dict[str, Column]:
        """Return efforts and reactions at increasing normalised times."""
        mechanism, wanted = self.mechanism, times
        if any(mechanism.gauges[spring.gauge].rotary for spring in mechanism.dynamics.springs):
            wanted = np.union1d(times, np.linspace(0.0, 1.0, min(self.steps, DRAWN) + 1))  # angles beyond half a turn
        apart = np.append(0.0, wanted)
        apart = apart[np.diff(apart, prepend=-1.0) > CLOSE]
        piece = next(stream(mechanism, 1, self._along.options, between=lambda _: apart))
        forces = ForceMotion(mechanism, len(apart), "off").take(piece)
        found = amounts(force_table(piece, forces), forces.bounded)
        rows = np.searchsorted(apart, times + CLOSE) - 1
        return {name: replace(amount, values=amount.values[rows]) for name, amount in found.items()}

    def _inputs_at(self, times: FloatArray) -> FloatArray:
        """Return the inputs (actuators, times) at normalised times, in the file's units."""
        inputs = law_inputs(self.mechanism)(times)
        return np.array([self.mechanism.value_to_file(k, row) for k, row in enumerate(inputs)]).reshape(inputs.shape)

    @cached_property
    def _state(self) -> State | None:
        """The rows of the motion, of which any quantity may be asked by its name; None if they are not kept."""
        motions = self._along.motions
        return MotionState(Motion.joined(motions), self._along.angles()) if motions else None

    @property
    def measured(self) -> dict[str, Any]:
        """Ranges of the measures, and their results for the whole motion."""
        return self._along.extras.report(self._found.summary.motion)

    @property
    def complete(self) -> bool:
        """Whether the forces of all rows are determined."""
        return bool(self._found.determined == self.steps + 1)

    @property
    def events(self) -> list[dict[str, Any]]:
        """Singular positions and limits of the motion."""
        return events(self._found.summary.motion)

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: forces at {self._found.determined} of {self.steps + 1} positions"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found, motion, mechanism = self._found, self._found.summary.motion, self.mechanism
        whole = found.summary.solved < self.steps + 1 or self.complete
        return {
            "steps": self.steps, "solved": found.determined, "residual": found.summary.residual,
            "reachable": reachable(motion), "events": self.events,
            "status": motion.overall.word if whole else found.failure[0],
            "energy_drift": found.drift, "power_error": found.error, **summary_report(mechanism, self._summary),
            "left_out": found.left_out, "open": found.open,
            "left_out_at": [mechanism.inputs_to_file(inputs) for inputs in found.left_out_at],
            **({} if found.friction is None else {"friction": found.friction.report()}), **self.measured,
        }  # fmt: skip

    def picture(self) -> output.picture.Content | None:
        """Return the graphs, by default of the efforts; None if no forces are determined."""
        if not self._found.determined:
            return None
        plans, constant = self._shown()
        title = "; ".join([f"{self.mechanism.name}: forces", *constant])
        return output.panels.history_sheet(self._graphs(plans), title)

    def graphs(self) -> list[output.graph.CurveGraph]:
        """Return the graphs of the picture as data."""
        return self._graphs(self._shown()[0])

    def _shown(self) -> tuple[list[PlannedGraph], list[str]]:
        """Return the graphs, and the constant quantities that have none."""
        own = self._along.extras
        return (own.plans, []) if own.plans else varying(usual_graphs(self.mechanism), own.kept)

    def _graphs(self, plans: Sequence[PlannedGraph]) -> list[output.graph.CurveGraph]:
        motion, columns = self._found.summary.motion, self._along.extras.kept
        over, marks = input_or_time(self.mechanism, motion.time, motion.inputs), motion_events(motion)
        return [with_marks(drawn(plan, columns, over, marks), over) for plan in plans]


class ForcesAlong(MotionUnderWay[ForcesResult]):
    """The forces of a motion that is being solved in pieces: first the tables of the pieces, then the result."""

    made = ForcesResult

    def __init__(
        self, mechanism: Mechanism, steps: int, tolerance: float, jit: str, measure: str | Sequence[str],
        plot: str | Sequence[str], notify: Notify | None, progress: Phases,
    ) -> None:  # fmt: skip
        """Begin to solve the motion."""
        options = Options(tolerance=tolerance, jit=jit)
        super().__init__(mechanism, steps, options, notify, progress("forces along the motion"))
        self.found = ForceMotion(mechanism, steps + 1, jit, notify)
        self.statistics = ForceStatistics(self.found.statics, steps)
        self._counted = self.angles()
        self.choose(measure, plot)

    def choose(self, measure: str | Sequence[str], plot: str | Sequence[str]) -> None:
        """Choose quantities of the table and graphs of the picture by texts; raise UsageError for an unknown one."""
        mechanism, units = self.mechanism, None
        if texts(plot):
            units = {column.name: column.unit for column in self._start[1].columns}
        self.extras = Extras(mechanism, measure, plot, columns=units, usual=usual_graphs(mechanism))
        if self.extras.plans:
            state, table = self._start
            self.extras.check(Table((*table.columns, *self.extras.beside(state, table.names))))

    @cached_property
    def _start(self) -> tuple[MotionState, Table]:
        """The first row and its table, without measures."""
        state = MotionState(self._first.rows(np.arange(1)))
        return state, force_table(state.motion, state.forces)

    @property
    def head(self) -> Table:
        """The table of the first row."""
        state, table = self._start
        measured = Extras(state.mechanism, self.extras.specs).beside(state, table.names)
        return Table((*table.columns, *measured))

    def knows(self, measure: Sequence[str], plot: Sequence[str]) -> bool:
        """Return whether the mechanism has the quantities of texts."""
        return accepted(self.choose, measure, plot)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self.head.names

    def tables(self) -> Iterator[Table]:
        """Yield the table of each piece of the motion."""
        for piece in self.pieces():
            first = self.found.summary.seen
            forces = self.found.take(piece)
            table = force_table(piece, forces, first)
            self.statistics.add(table, piece, forces)
            state = MotionState(piece, self._counted, self.extras.record.memory)
            state.forces = forces
            table = Table((*table.columns, *self.extras.measured(state, table.names)))
            yield table
            table = Table((*table.columns, *self.extras.beside(state, table.names)))
            self.extras.keep(_bounded(table, forces.bounded), self.found.rows)


def _bounded(table: Table, bounded: NDArray[np.bool_]) -> Table:
    """Return a table without the forces whose estimated error is too great."""
    columns = (
        replace(one, values=np.where(bounded, one.values, np.nan)) if one.unit in FORCES else one
        for one in table.columns
    )
    return Table(tuple(columns))


def summary_report(mechanism: Mechanism, found: ForceSummary) -> dict[str, Any]:
    """Return the entries of the JSON report; undetermined numbers become null."""
    return {
        "peaks": {
            name: {"value": one.peak.value, "unit": one.unit, "time": one.peak.time, "at": one.peak.inputs}
            for name, one in found.statistics.items()
        },
        "statistics": statistics(mechanism, found.statistics).by("name"), "closed": found.closed,
        "work": works(found.work).by("name"), "bearings": bearing_loads(found.bearings).by("name"),
    }  # fmt: skip


def statistics(mechanism: Mechanism, found: Mapping[str, Statistic]) -> Records:
    """Return mean, RMS and extremes, one row for each effort, reaction or moment."""
    every, sizes = list(found.values()), _sizes(mechanism, found)
    ends = {word: [getattr(one, word) for one in every] for word in ("least", "greatest", "peak")}
    at = f"at {', '.join(labelled(a.name, mechanism.unit_of(a)) for a in mechanism.actuators)}"

    def rounded(values: list[float]) -> list[str]:
        return [number(value, sizes[one.unit]) for value, one in zip(values, every, strict=True)]

    def place(end: Extremum) -> str:
        return ", ".join(input_value(mechanism, name, value) for name, value in end.inputs.items())

    means, squares = [one.mean for one in every], [one.rms for one in every]
    return Records(
        RowField("name", list(found), head=""),
        RowField("unit", [one.unit for one in every], head="unit"),
        RowField("mean", means, float, head="mean", text=rounded(means)),
        RowField("rms", squares, float, head="RMS", text=rounded(squares)),
        *(
            RowField(word, [{"value": one.value, "time": one.time, "at": one.inputs} for one in own], float, head=word,
                     text=rounded([one.value for one in own]), key=word != "peak")
            for word, own in ends.items()
        ),
        *(RowField(f"{word} at", own, float, head=at, text=place, key=False) for word, own in ends.items()),
        RowField("part", [one.part for one in every]),
    )  # fmt: skip


def _sizes(mechanism: Mechanism, found: Mapping[str, Statistic]) -> dict[str, float]:
    """Return the greatest value of each unit; a torque is zero in comparison with the forces, too."""
    sizes: dict[str, float] = {}
    for one in found.values():
        sizes[one.unit] = max(sizes.get(one.unit, 0.0), abs(one.peak.value))
    arm = mechanism.size * (mechanism.dynamics.metre or 0.0)
    return sizes | ({"N m": max(sizes["N m"], sizes.get("N", 0.0) * arm)} if "N m" in sizes else {})


def works(found: Mapping[str, Work]) -> Records:
    """Return the works [J], one row for each actuator or kind of force."""
    own = {word: [getattr(one, word) for one in found.values()] for word in ("positive", "negative", "net")}
    size = greatest([*own["positive"], *own["negative"]])
    fields = (RowField(word, values, float, head=word, size=size) for word, values in own.items())
    return Records(RowField("name", list(found), head=""), *fields)


def bearing_loads(found: Mapping[str, BearingLoad]) -> Records:
    """Return the mean loads, one row for each pin."""
    every, size = list(found.values()), greatest(load for one in found.values() for load in (one.ball, one.roller))
    return Records(
        RowField("name", list(found), head=""),
        RowField("speed", [one.speed for one in every], float, "1/min", head="mean speed"),
        RowField("turns", [one.turns for one in every]),
        RowField("ball", [one.ball for one in every], float, "N", head="ball, p = 3", size=size),
        RowField("roller", [one.roller for one in every], float, "N", head="roller, p = 10/3", size=size),
    )
