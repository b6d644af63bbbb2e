"""Find the driving efforts and the reactions of a prescribed motion."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.dynamics.force_motion import ForceMotion
from gimcli.dynamics.force_table import force_table
from gimcli.dynamics.forces import motion_forces
from gimcli.dynamics.physical import require_action
from gimcli.library.inputs import MOST_STEPS, refuse_count, refuse_unmoved
from gimcli.library.result import RowsResult, joined
from gimcli.measures.graphs import input_or_time
from gimcli.mechanism import Mechanism
from gimcli.motion.motion import Motion, stream
from gimcli.positions.options import Options
from gimcli.progress import Notify, Phases, no_phases
from gimcli.rates.motion_table import events, reachable
from gimcli.structure.drive_check import explained, require_consistent
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.output.picture import Content


def forces(
    mechanism: Mechanism, steps: int = 360, *, tolerance: float = 1e-10, jit: str = "auto",
    notify: Notify | None = None, progress: Phases = no_phases,
) -> ForcesResult:  # fmt: skip
    """Find driving efforts, reactions and shaking force along the actuators' laws (inverse dynamics).

    Args:
        mechanism: from `load` or `loads`; it needs masses, loads, springs, dampers or friction.
        steps: number of steps, 1 to 10 000 000; the result has steps + 1 rows.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (rows done, all rows), for a progress bar.

    Returns:
        A ForcesResult: forces [N], torques [N m] and powers [W] as the columns of the CSV file, by name, (rows,); NaN
        where they are not determined. `report()` has the peak values.

    Raises:
        UsageError: an invalid argument.
        ModelError: no masses, loads, springs, dampers or friction are defined.
        StructureError: the mechanism has no actuator, or is not fully driven, over-driven or contradictory.
    """
    found = ForcesAlong(mechanism, steps, tolerance, jit, notify, progress)
    return found.result(joined(found.tables()))


class ForcesAlong:
    """The forces of a motion that is being solved in pieces: first the tables of the pieces, then the result."""

    def __init__(
        self, mechanism: Mechanism, steps: int, tolerance: float, jit: str, notify: Notify | None,
        progress: Phases,
    ) -> None:  # fmt: skip
        refuse_count("steps", steps, 1, MOST_STEPS)
        chosen = Options.checked("auto", "spectral", tolerance, jit)
        require_action(mechanism)
        self.steps = steps
        with explained(mechanism):
            refuse_unmoved(mechanism, "add an actuator")
            self._pieces = stream(mechanism, steps, chosen, notify=notify, progress=progress("forces along the motion"))
            self._first: Motion = next(self._pieces)
        first = self._first
        require_consistent(mechanism, first.start, first.inputs[:, 0], first.first_status, tolerance)
        self.found = ForceMotion(mechanism, steps + 1, jit, notify)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        start = self._first.rows(np.arange(1))
        return force_table(start, motion_forces(start)).names

    def tables(self) -> Iterator[Table]:
        """Yield the table of each piece of the motion."""
        for piece in chain((self._first,), self._pieces):
            first = self.found.summary.seen
            yield force_table(piece, self.found.take(piece), first)

    def result(self, table: Table | None) -> ForcesResult:
        """Return the result, after all tables were read; `table` is None if they were written to a file."""
        return ForcesResult(self.found, self.steps, table)


class ForcesResult(RowsResult):
    """Driving efforts, reactions, shaking force and powers along a motion, as columns by name."""

    KIND = "forces"

    def __init__(self, found: ForceMotion, steps: int, table: Table | None) -> None:
        self.mechanism, self.found, self.steps = found.statics.mechanism, found, steps
        self._table = table

    @property
    def complete(self) -> bool:
        """Whether the forces of all rows are determined."""
        return self.found.determined == self.steps + 1

    @property
    def events(self) -> list[dict[str, Any]]:
        """Singular positions and limits of the motion."""
        return events(self.found.summary.motion)

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: forces at {self.found.determined} of {self.steps + 1} positions"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found, motion, peaks = self.found, self.found.summary.motion, self.found.peaks
        whole = found.summary.solved < self.steps + 1 or self.complete
        return {
            "steps": self.steps, "solved": found.determined, "residual": found.summary.residual,
            "reachable": reachable(motion), "events": self.events,
            "status": motion.overall.word if whole else "singular",
            "energy_drift": peaks.drift, "power_error": peaks.power_error, "peaks": peaks.report(),
            "left_out": peaks.left_out, "open": found.open,
        }  # fmt: skip

    def picture(self) -> Content | None:
        """Return graphs of the efforts over the input, and of the shaking force; None if no forces are determined."""
        from gimcli.output.forces import forces_sheet

        found = self.found
        if not found.determined:
            return None
        mechanism = found.statics.mechanism
        time, inputs, efforts, shaking = found.kept
        over = input_or_time(mechanism, time, inputs)
        panels: dict[str, list[Column]] = {}
        for k, actuator in enumerate(mechanism.actuators):
            name, unit = ("driving torque", "N m") if actuator.rotary else ("driving force", "N")
            panels.setdefault(name, [over]).append(Column(actuator.name, efforts[k], unit))
        tables = {name: Table(tuple(columns)) for name, columns in panels.items()}
        return forces_sheet(tables, shaking, f"{mechanism.name}: forces")
