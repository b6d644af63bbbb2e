"""Follow whole circuits instead of a law: rows at equal distances, also past limits and dead points."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from gimcli import graphs, output
from gimcli.branching.resampling import circuit_motion
from gimcli.branching.singular_positions import drawn_circuit
from gimcli.branching.singularities import STATIONARY, input_ends, interval, singularities
from gimcli.canonical import counted
from gimcli.continuation.branches import all_circuits
from gimcli.continuation.circuit import Circuit
from gimcli.errors import refuse
from gimcli.graphs.extras import Extras
from gimcli.library.inputs import in_file_units, interval_of
from gimcli.library.result import UnderWay
from gimcli.library.trace_result import TraceResult
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.motion.summary import traced_paths
from gimcli.progress import Phases
from gimcli.quantities.point_ranges import PointRanges
from gimcli.rates.member_angles import direction, full_turn
from gimcli.table import Column, Table

DENSE = 720
"""Least number of rows of a circuit for which no member is expected to turn by half a turn between two rows."""


class CircuitTraceResult(TraceResult):
    """Rows along whole circuits, one circuit after another; `circuits` describes each."""

    _found: CircuitTrace

    @cached_property
    def circuits(self) -> list[dict[str, Any]]:
        """For each circuit: whether it is closed, intervals of its inputs, limits, change points, points, measures."""
        found = self._found
        return [
            _of_circuit(self.mechanism, n, circuit, singularities(circuit)) | {"points": points} | extras.report(motion)
            for n, circuit, extras, motion, points in zip(
                found.numbers, found.circuits, found.extras, found.motions, found.points(), strict=True
            )
        ]

    @property
    def points(self) -> dict[str, dict[str, Any]]:
        """Ranges and curves of the traced points, if one circuit was followed (see `TraceResult`)."""
        return self.circuits[0]["points"] if len(self.circuits) == 1 else {}

    @property
    def events(self) -> list[dict[str, Any]]:
        """Limits, dead points and change points of all circuits."""
        return [{"branch": one["branch"], **event} for one in self.circuits for event in one["events"]]

    @property
    def reachable(self) -> dict[str, list[list[float]]]:
        """The interval of every input on each circuit."""
        return {a.name: [one["interval"][a.name] for one in self.circuits] for a in self.mechanism.actuators}

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: {self.solved} of {self.rows} positions solved, worst residual {self.worst:.1e}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        circuits = self.circuits
        return {
            "steps": self._found.steps, "solved": self.solved, "residual": self.worst, "reachable": self.reachable,
            "events": self.events,
            "circuits": [{k: v for k, v in one.items() if k != "events"} for one in circuits],
            "status": next((m.overall.word for m in self._motions if not m.good.all()), "ok"),
            **{key: circuits[0][key] for key in ("points", "measures") if len(circuits) == 1 and key in circuits[0]},
        }  # fmt: skip

    def _turns(self, member: int) -> FloatArray:
        """Return the directions of a member (rows,) in the file's angle unit, full turns counted along each circuit."""
        return np.concatenate([self._found.angles(motion, member) for motion in self._motions])

    def picture(self) -> output.picture.Content | None:
        """Return positions on the first circuit, and the curves, areas and graphs of all circuits."""
        mechanism = self.mechanism
        paths = {name + tail: path for tail, motion, _ in self._each for name, path in traced_paths(motion).items()}
        more = {n + tail: curve for tail, motion, own in self._each for n, curve in own.record.curves(motion).items()}
        outlines = [outline for _, motion, own in self._each for outline in own.record.outlines(motion)]
        poses, title = self._poses(self._motions[0]), f"{mechanism.name}: circuit"
        return output.panels.with_panels(
            output.drawing.motion_picture(mechanism, poses, paths, title, more, outlines), self.graphs()
        )

    def geometry(self) -> output.geometry.Geometry:
        """Return a position on the first circuit, and the curves of all circuits, in true size."""
        return output.geometry.motion_geometry(self.mechanism, self._poses(self._motions[0])[0], self.table())

    def graphs(self) -> list[output.graph.CurveGraph]:
        """Return the graphs of `plot` as data, those of each circuit in turn."""
        found: list[output.graph.CurveGraph] = []
        for k, (tail, motion, extras) in enumerate(self._each):
            if extras.plans:
                events = self.circuits[k]["events"]
                marks = [(e["kind"], {"part of the length": e["way"], **e["at"]}) for e in events]
                every = extras.graphs(motion, marks)
                found += [replace(one, up=replace(one.up, name=one.up.name + tail)) for one in every]
        return found

    @property
    def _each(self) -> list[tuple[str, Motion, Extras]]:
        """The end of the names, the rows, and the measures and graphs of each circuit."""
        tails = [f", branch {number}" * (len(self._motions) > 1) for number in self._found.numbers]
        return list(zip(tails, self._motions, self._found.extras, strict=True))

    def animation(self) -> output.animation.Animation:
        """Return the circuits with their events and columns."""
        return graphs.circuit_animation.circuit_trace_animation(self._motions, self.circuits, self._found.extras)


class CircuitTrace(UnderWay[TraceResult]):
    """A circuit, or all circuits that meet it: first the tables, then the result."""

    made = CircuitTraceResult

    def __init__(
        self, mechanism: Mechanism, steps: int, tolerance: float, branch: int, every: bool,
        extras: Callable[[], Extras], progress: Phases,
    ) -> None:  # fmt: skip
        """Follow the circuits; `extras` makes the measures and graphs of one circuit."""
        follow = progress("following the circuit")
        circuits: tuple[Circuit, ...] = (drawn_circuit(mechanism, tolerance),)
        if every or branch > 1:
            follow = progress("following branches")
            circuits = all_circuits(circuits[0], progress=follow).circuits
        refuse(
            (
                branch > len(circuits) == 1,
                f"branch {branch}: no branch crosses the circuit of the initial configuration; remove branch",
            ),
            (
                branch > len(circuits),
                f"branch: expected a number from 1 to {len(circuits)}, got {branch}; 1 is the circuit of the initial"
                " configuration, the others cross it (see `gim singularities`)",
            ),
        )
        self.mechanism, self.steps, self.tolerance, self.every = mechanism, steps, tolerance, every
        self.numbers = list(range(1, len(circuits) + 1)) if every else [branch]
        progress("positions along the circuit")
        self.circuits = [circuits[n - 1] for n in self.numbers]
        self.motions = [circuit_motion(circuit, steps + 1, tolerance) for circuit in self.circuits]
        self.extras = [extras() for _ in self.numbers]
        self.expected = sum(len(motion.time) for motion in self.motions)
        self._dense: dict[int, Motion] = {}

    def angles(self, motion: Motion, member: int) -> FloatArray:
        """Return the directions of a member (rows,) along a circuit, full turns counted."""
        number = next(k for k, own in enumerate(self.motions) if own is motion)
        circuit = self.circuits[number]
        each = -(-max(DENSE, len(circuit.places)) // self.steps)
        if number not in self._dense:
            self._dense[number] = circuit_motion(circuit, each * self.steps + 1, self.tolerance)
        found = direction(self.mechanism, member, self._dense[number].z)
        return counted(found, full_turn(self.mechanism))[::each]

    @cached_property
    def _tables(self) -> list[Table]:
        tables = []
        for number, motion, extras in zip(self.numbers, self.motions, self.extras, strict=True):
            table = extras.table(motion, self.angles)
            extras.keep(table, np.arange(len(motion.time)))
            branch = (Column("branch", np.full(len(table), number)),) if self.every else ()
            tables.append(Table((*table.columns, *branch)))
        return tables

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self._tables[0].names

    def tables(self) -> Iterator[Table]:
        """Yield the table of each circuit; if all are followed, the last column is `branch`."""
        yield from self._tables

    def points(self) -> list[dict[str, dict[str, Any]]]:
        """Return the ranges of the traced points on each circuit."""
        found = []
        for motion, table in zip(self.motions, self._tables, strict=True):
            ranges = PointRanges(self.mechanism)
            ranges.add(table)
            found.append(ranges.report(motion))
        return found


def _of_circuit(mechanism: Mechanism, number: int, circuit: Circuit, found: list[Any]) -> dict[str, Any]:
    """Return the report of a circuit: whether it is closed, the intervals of its inputs, limits and change points."""

    def at(inputs: FloatArray) -> dict[str, float]:
        return in_file_units(mechanism, inputs)

    reach = interval_of(*map(at, input_ends(circuit, interval(circuit, found))))
    own = [one for one in found if one.kind != STATIONARY]
    events = [{"kind": one.kind, "at": at(circuit.curve.inputs(one.p)), "way": one.fraction} for one in own]
    return {
        "branch": number, "closed": circuit.closed, "ended": circuit.ended, "turns": abs(circuit.turns),
        "interval": reach, "events": events,
    }  # fmt: skip
