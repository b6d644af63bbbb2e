"""Trace a motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Annotated, Any, cast

import numpy as np

from gimcli import graphs, output
from gimcli.errors import refuse
from gimcli.graphs.extras import Extras
from gimcli.library.inputs import (
    MOST_STEPS,
    Jit,
    Method,
    OneOf,
    Range,
    Steps,
    Strategy,
    Tolerance,
    checked,
    refuse_unmoved,
)
from gimcli.library.result import UnderWay, in_parts
from gimcli.library.trace_result import MotionUnderWay, TraceResult
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.motion import PIECE, Motion
from gimcli.motion.summary import Summary, events, reachable, traced_paths
from gimcli.positions.options import Options
from gimcli.progress import Notify, Phases, no_phases
from gimcli.quantities.point_ranges import PointRanges
from gimcli.table import Table

if TYPE_CHECKING:
    from gimcli.rates.derivatives import TracedRates

AT_LIMIT = ("stop", "skip", "reverse")


@in_parts
@checked
def trace(
    mechanism: Mechanism, steps: Steps = 360, *, derivatives: Annotated[int, Range(0, 3)] = 0,
    measure: str | Sequence[str] = (), plot: str | Sequence[str] = (),
    at_limit: Annotated[str, OneOf(AT_LIMIT)] = "stop", circuit: bool = False,
    branch: Annotated[int, Range(1, MOST_STEPS)] = 1, all_branches: bool = False,
    method: Method = "auto", strategy: Strategy = "spectral", tolerance: Tolerance = 1e-10,
    jit: Jit = "auto", sequence: str = "", notify: Notify | None = None, progress: Phases = no_phases,
) -> UnderWay[TraceResult]:  # fmt: skip
    """Trace the motion that the actuators' laws prescribe, or whole circuits.

    Args:
        mechanism: from `load` or `loads`.
        steps: number of steps, 1 to 10 000 000; the result has steps + 1 rows.
        derivatives: 1: velocities, 2: also accelerations, 3: also jerks; they are columns, with respect to the real
            time (the `duration` of the model, or 1 s).
        measure: one text or a list, such as "transmission" or ["centre:rod/rocker", "curvature:P"]; adds columns.
        plot: graphs below the drawing in `picture()` and in saved pictures, a text or a list: columns such as
            "P.vx,rocker.angle", "velocity", "omega", measures, "hodograph:P" (see `gim manual graphs`); also adds the
            columns that they need.
        at_limit: what happens where the law exceeds a limit of the input. "stop": the rows after it have no position.
            "skip": rows have no position while the law is out of reach, and are then solved again on the same arc.
            "reverse": the input turns back.
        circuit: follow the circuit of the start, not the law; the rows are at even distances along the closed circuit
            of the initial position.
        branch: branch taken at the first change point; 1: the motion keeps its curve. With `circuit` the circuit to
            follow, as `singularities` numbers them.
        all_branches: follow the circuit and all circuits that cross it; one after another, with the column "branch".
        method: "auto", "newton" or "gim" (geometric iteration only).
        strategy: the sequence of method "gim", "spectral" or "classic"; see `sequence`.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        sequence: with method "gim": the moves of one sweep, such as "A>B O4>B": FROM>TO imposes a distance,
            ARM^VERTEX>TO an angle. By default the best sequence is searched.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (rows done, all rows), for a progress bar.

    Returns:
        A TraceResult: `xy[name]` (rows, 2), `angle[member]` (rows,), `status` (rows,), `events`, and the columns of the
        CSV file by name. A row that is not solved has a status word other than "ok", and NaN. Circuits of several
        independent machines are a MachinesResult, whose `each` has one result by the name of each machine.

    Raises:
        UsageError: an unknown name, an invalid argument, or arguments that exclude each other.
        StructureError: the mechanism has no actuator, or is not fully driven, over-driven or contradictory.
        UnassembledError: with `circuit` or `all_branches`, if no assembled position to start from was found; a motion
            along the laws has a status instead.
    """
    chosen = Options(method, strategy, tolerance, jit, moves=sequence)
    own = Extras(mechanism, measure, plot, derivatives)
    refuse_unmoved(mechanism, "add an actuator, or use `gim solve`")
    if circuit or all_branches:
        from gimcli.library.circuit_trace import CircuitTrace
        from gimcli.library.machines import MachineTables, driven_machines

        _refuse_mixed(method, own.order, at_limit, branch, all_branches)
        circuits = partial(CircuitTrace, steps=steps, tolerance=tolerance, branch=branch, every=all_branches)
        begun = {
            name: circuits(one, extras=partial(Extras, one, measure, plot, derivatives), progress=progress)
            for name, one, *_ in driven_machines(mechanism)
        }
        return next(iter(begun.values())) if len(begun) == 1 else cast(Any, MachineTables(mechanism, begun))
    if at_limit != "stop" or branch > 1:
        _refuse_mixed(method, own.order if at_limit == "reverse" else 0)
    return MotionTrace(mechanism, steps, chosen, own, at_limit, branch, notify, progress)


def _refuse_mixed(method: str, rates: int, at_limit: str = "stop", branch: int = 1, every: bool = False) -> None:
    """Raise UsageError for arguments that cannot be combined with circuits, branches or reversed inputs."""
    refuse(
        (
            method == "gim",
            "method gim: circuits, branches and limits are followed by continuation, not by geometric iteration;"
            " remove the method",
        ),
        (
            rates,
            "derivatives and graphs of velocities need a motion along the law: remove circuit, all-branches and"
            " at-limit reverse",
        ),
        (
            at_limit != "stop",
            f"at-limit {at_limit}: a circuit continues through limits; remove at-limit or circuit",
        ),
        (every and branch > 1, "all-branches follows all branches; remove branch"),
    )


class MotionTraceResult(TraceResult):
    """Rows of a motion along the actuators' laws."""

    _found: MotionTrace

    @cached_property
    def _motion(self) -> Motion:
        """The rows that are drawn, and all events."""
        return self._found.summary.motion

    @property
    def rows(self) -> int:
        """The number of rows."""
        return self._found.summary.rows

    @property
    def solved(self) -> int:
        """The number of rows that are "ok"."""
        return self._found.summary.solved

    @property
    def worst(self) -> float:
        """The largest residual of all rows, relative to the mechanism's size."""
        return self._found.summary.residual

    @cached_property
    def reachable(self) -> dict[str, list[list[float]]]:
        """The intervals of every input's law that the motion reached, in the file's unit."""
        return reachable(self._motion)

    @cached_property
    def events(self) -> list[dict[str, Any]]:
        """Change points that were passed, exchanges of the sequence, and limits with the interval of the input."""
        return [event for part in self._motion.machines for event in self._events(part)]

    def _events(self, part: Motion) -> list[dict[str, Any]]:
        """Return the events of a machine, named if there are several."""
        found = events(part)
        limits = [event for event in found if event["kind"] == "limit"]
        if limits:
            from gimcli.branching.singular_positions import circuit_ranges

            interval = circuit_ranges(part)
            for event in limits:
                event["interval"] = interval
        name = {"machine": part.mechanism.as_machine.name} if self._motion.parts else {}
        return [{**event, **name} for event in found]

    @property
    def machines(self) -> list[dict[str, Any]]:
        """Name, number of solved rows, reachable intervals and events of each independent machine of the file."""
        found = []
        for part, solved in zip(self._motion.machines, self._found.summary.each, strict=True):
            name = part.mechanism.as_machine.name
            own = [event for event in self.events if event.get("machine", name) == name]
            found.append({"name": name, "solved": solved, "reachable": reachable(part), "events": own})
        return found

    @cached_property
    def measured(self) -> dict[str, Any]:
        """Ranges of the measures, and their results for the whole motion."""
        return self._found.extras.report(self._motion)

    @cached_property
    def points(self) -> dict[str, dict[str, Any]]:
        """For each traced point the ranges "x" and "y" of its coordinates, and its "curve" (see `TraceResult`)."""
        return self._found.ranges.report(self._motion)

    def headline(self) -> str:
        """Return the result in one line."""
        quality = f", worst residual {self.worst:.1e}" if self.solved else ""
        return f"{self.mechanism.name}: {self.solved} of {self.rows} positions solved{quality}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        why: dict[str, Any] = {}
        if not self.complete:
            from gimcli.motion.unassembled import motion_reason

            why = {"reason": motion_reason(self._motion)}
        return {
            "steps": self._found.steps, "solved": self.solved, "residual": self.worst, "reachable": self.reachable,
            "events": self.events, "status": self._motion.overall.word, **why, "machines": self.machines,
            "points": self.points,
            **self.measured,
        }  # fmt: skip

    def _turns(self, member: int) -> FloatArray:
        """Return the directions of a member (rows,) in the file's angle unit, full turns counted."""
        angles = self._found.angles()
        return np.concatenate([angles(motion, member) for motion in self._motions])

    def picture(self) -> output.picture.Content | None:
        """Return some positions, the curves of the traced points and the graphs; None if no row is solved."""
        if not self.solved:
            return None
        motion, mechanism, extras = self._motion, self.mechanism, self._found.extras
        curves, outlines = extras.record.curves(motion), extras.record.outlines(motion)
        poses, paths = self._poses(motion), traced_paths(motion)
        picture = output.drawing.motion_picture(mechanism, poses, paths, mechanism.name, curves, outlines)
        return output.panels.with_panels(picture, self.graphs())

    def geometry(self) -> output.geometry.Geometry | None:
        """Return the first position and all curves in true size, with all rows of the traced points."""
        if not self.solved:
            return None
        motion, extras = self._motion, self._found.extras
        found = output.geometry.motion_geometry(self.mechanism, self._poses(motion)[0], self.table())
        for name, curve in extras.record.curves(motion).items():
            found.add_curve(f"curve {name}", curve)
        found.add_loops("area swept", extras.record.outlines(motion))
        return found

    def graphs(self) -> list[output.graph.CurveGraph]:
        """Return the graphs of `plot` as data."""
        from gimcli.quantities.motion_table import motion_events

        return self._found.extras.graphs(self._motion, motion_events(self._motion))

    def animation(self) -> output.animation.Animation | None:
        """Return the motion with its events, velocities and columns; None if no row is solved."""
        return graphs.motion_animation.law_animation(
            self._motion, self._found.extras, self._found.steps, self._found.angles()
        )


class MotionTrace(MotionUnderWay[TraceResult]):
    """A motion that is being solved in pieces: first the tables of the pieces, then the result."""

    made = MotionTraceResult

    def __init__(
        self, mechanism: Mechanism, steps: int, options: Options, extras: Extras, at_limit: str, branch: int,
        notify: Notify | None, progress: Phases,
    ) -> None:  # fmt: skip
        rows = steps + 1 if at_limit != "stop" or branch > 1 else PIECE
        form: dict[str, Any] = {"rows": rows, "at_limit": at_limit, "branch": branch}
        super().__init__(mechanism, steps, options, notify, progress("tracing"), **form)
        self.summary, self.ranges = Summary(steps + 1), PointRanges(mechanism)
        self.extras, self._notify = extras, notify
        extras.check(self._head) if extras.plans else None

    @cached_property
    def _rates(self) -> TracedRates | None:
        return self.extras.traced(self.extras.order, self.steps + 1, self.options.jit, self._notify)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self._head.names

    @cached_property
    def _head(self) -> Table:
        return self.extras.head(self._first.rows(np.arange(1)))

    def tables(self) -> Iterator[Table]:
        """Yield the table of each piece of the motion."""
        angles = self.angles()
        for piece in self.pieces():
            own, first = self.extras, self.summary.seen
            table = own.table(piece, angles, first, self._rates)
            self.ranges.add(table)
            yield table
            own.keep(table, self.summary.add(piece))
