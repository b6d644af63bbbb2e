"""Reduce a mechanism to one input."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from gimcli.dynamics.flywheel import Flywheel, flywheel
from gimcli.dynamics.physical import require_masses
from gimcli.dynamics.reduction import Reduction, chosen_input, reduce_to_input, reduction_table
from gimcli.errors import UsageError
from gimcli.library.inputs import MOST_STEPS, refuse_choice, refuse_count, refuse_unmoved
from gimcli.library.result import RowsResult
from gimcli.mechanism import Mechanism
from gimcli.positions.dispatch import choose
from gimcli.positions.options import JIT
from gimcli.progress import Notify, Phases, no_phases
from gimcli.status import Status
from gimcli.structure.drive_check import explained
from gimcli.structure.mobility import refuse_unfit

if TYPE_CHECKING:
    from gimcli.output.picture import Content

WORK = 6e-4
"""Seconds that a row takes without compiling, about."""


def reduce(
    mechanism: Mechanism, input: str = "", steps: int = 360, *, fluctuation: float | None = None,
    rpm: float | None = None, jit: str = "auto", notify: Notify | None = None, progress: Phases = no_phases,
) -> ReduceResult:  # fmt: skip
    """Reduce a mechanism to an input, by default the first: inertia, torque, potential and their derivatives.

    `fluctuation` and `rpm` also find the flywheel that keeps the speed of a cycle. Raises UsageError, ModelError where
    there are no masses, and StructureError.
    """
    if (fluctuation is None) != (rpm is None):
        raise UsageError("a flywheel needs both --fluctuation and --rpm")
    refuse_choice("jit", jit, JIT)
    refuse_count("steps", steps, 1, MOST_STEPS)
    require_masses(mechanism)
    refuse_unmoved(mechanism, "add one")
    actuator = chosen_input(mechanism, input)
    run = choose(jit, steps * WORK, notify, ("move",))
    with explained(mechanism):
        refuse_unfit(mechanism)
        found = reduce_to_input(mechanism, actuator, steps, run, progress("reducing"))
    wheel = None
    if fluctuation is not None and rpm is not None:
        wheel = flywheel(found, rpm * math.pi / 30.0, fluctuation)
    return ReduceResult(found, wheel)


class ReduceResult(RowsResult):
    """Reduced inertia, torque and potential over the input, by their columns, and the `wheel` asked for."""

    KIND = "reduced"

    def __init__(self, found: Reduction, wheel: Flywheel | None) -> None:
        self.mechanism, self.found, self.wheel = found.mechanism, found, wheel
        self._table = reduction_table(found)

    @property
    def complete(self) -> bool:
        """Tell whether all rows are solved."""
        return self.found.solved == len(self.found.q)

    @property
    def overall(self) -> Status:
        """OK, or what ended the first row that is not solved."""
        bad = self.found.codes[self.found.codes != Status.OK]
        return Status(int(bad[0])) if not self.complete else Status.OK

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: reduced at {self.found.solved} of {len(self.found.q)} positions"

    def report(self) -> dict[str, Any]:
        """Return what --json prints."""
        found, table = self.found, self.table()
        report = {
            "input": self.mechanism.actuators[found.actuator].name, "steps": len(found.q) - 1,
            "solved": found.solved, "status": self.overall.word,
            **{n: table.floats(n).tolist() for n in table.names if n != "status"},
        }  # fmt: skip
        return {**report, "flywheel": asdict(self.wheel)} if self.wheel else report

    def picture(self) -> Content | None:
        """Return the reduced quantities over the input; None where there is nothing to draw."""
        from gimcli.output.history import Panel, history_sheet

        found, table, actuator = self.found, self.table(), self.mechanism.actuators[self.found.actuator]
        if found.solved < 2:
            return None
        q = table.floats("q")
        units = {column.name: column.unit for column in table.columns}
        labels = {"J": "reduced inertia J", "dJ_dq": "dJ/dq", "tau": "reduced torque", "V": "potential V"}
        panels = [Panel(f"{label} [{units[n]}]", [("", q, table.floats(n))]) for n, label in labels.items()]
        title = f"{found.mechanism.name}: reduced to {actuator.name}"
        return history_sheet(panels, f"{actuator.name} [{units['q']}]", title)
