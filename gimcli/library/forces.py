"""Find the efforts and reactions that a prescribed motion asks for."""

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
from gimcli.structure.drive_check import explained, refuse_contradiction
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.output.picture import Content


def forces(
    mechanism: Mechanism, steps: int = 360, *, tolerance: float = 1e-10, jit: str = "auto",
    notify: Notify | None = None, progress: Phases = no_phases,
) -> ForcesResult:  # fmt: skip
    """Find efforts, reactions and shaking force along the actuators' laws.

    Raises ModelError where nothing has mass and nothing acts, StructureError where the mechanism is over-driven or not
    driven.
    """
    found = ForcesAlong(mechanism, steps, tolerance, jit, notify, progress)
    return found.result(joined(found.tables()))


class ForcesAlong:
    """The forces of a motion that is under way: tables of its pieces, then the result."""

    def __init__(
        self, mechanism: Mechanism, steps: int, tolerance: float, jit: str, notify: Notify | None,
        progress: Phases,
    ) -> None:  # fmt: skip
        refuse_count("steps", steps, 1, MOST_STEPS)
        chosen = Options.checked("auto", "spectral", tolerance, jit)
        require_action(mechanism)
        self.steps = steps
        with explained(mechanism):
            refuse_unmoved(mechanism, "add one")
            self._pieces = stream(mechanism, steps, chosen, notify=notify, progress=progress("forces along the motion"))
            self._first: Motion = next(self._pieces)
        first = self._first
        refuse_contradiction(mechanism, first.start, first.inputs[:, 0], first.first_status, tolerance)
        self.found = ForceMotion(mechanism, steps + 1, jit, notify)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        start = self._first.rows(np.arange(1))
        return force_table(start, motion_forces(start)).names

    def tables(self) -> Iterator[Table]:
        """Yield the table of each piece."""
        for piece in chain((self._first,), self._pieces):
            first = self.found.summary.seen
            yield force_table(piece, self.found.take(piece), first)

    def result(self, table: Table | None) -> ForcesResult:
        """Return the result, when all tables have been taken; without its table where that went to a file."""
        return ForcesResult(self.found, self.steps, table)


class ForcesResult(RowsResult):
    """Efforts, reactions, shaking force and powers along a motion, by their columns."""

    KIND = "forces"

    def __init__(self, found: ForceMotion, steps: int, table: Table | None) -> None:
        self.mechanism, self.found, self.steps = found.statics.mechanism, found, steps
        self._table = table

    @property
    def complete(self) -> bool:
        """Tell whether the forces of all rows are known."""
        return self.found.told == self.steps + 1

    @property
    def events(self) -> list[dict[str, Any]]:
        """Singular positions and limits on the way."""
        return events(self.found.summary.motion)

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: forces at {self.found.told} of {self.steps + 1} positions"

    def report(self) -> dict[str, Any]:
        """Return what --json prints."""
        found, motion, peaks = self.found, self.found.summary.motion, self.found.peaks
        whole = found.summary.solved < self.steps + 1 or self.complete
        return {
            "steps": self.steps, "solved": found.told, "residual": found.summary.residual,
            "reachable": reachable(motion), "events": self.events,
            "status": motion.overall.word if whole else "singular",
            "energy_drift": peaks.drift, "power_error": peaks.power_error, "peaks": peaks.report(),
            "left_out": peaks.left_out, "open": found.open,
        }  # fmt: skip

    def picture(self) -> Content | None:
        """Return the efforts over the input, and the path of the shaking force; None where nothing is known."""
        from gimcli.output.forces import forces_sheet

        found = self.found
        if not found.told:
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
