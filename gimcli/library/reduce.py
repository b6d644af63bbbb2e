"""Reduce a mechanism to an equivalent model with one degree of freedom."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from gimcli import output
from gimcli.dynamics.physical import require_masses
from gimcli.dynamics.reduction import Flywheel, Reduction, chosen_input, flywheel, reduce_to_input, reduction_table
from gimcli.errors import refuse
from gimcli.library.inputs import Jit, Steps, refuse_unmoved
from gimcli.library.machines import driven_machines, for_each_machine, loaded_machines
from gimcli.library.result import RowsResult
from gimcli.mechanism import Machine, Mechanism
from gimcli.progress import Notify, Phases, no_phases
from gimcli.status import Status
from gimcli.structure.mobility import require_driven


@for_each_machine(lambda mechanism, given: _reduced(mechanism, given.get("actuator", "")))
def reduce(
    mechanism: Mechanism, actuator: str = "", steps: Steps = 360, *, fluctuation: float | None = None,
    rpm: float | None = None, jit: Jit = "auto", notify: Notify | None = None, progress: Phases = no_phases,
) -> ReduceResult:  # fmt: skip
    """Find the equivalent one-degree-of-freedom model: inertia, torque and potential reduced to one input.

    Args:
        mechanism: from `load` or `loads`; it needs masses.
        actuator: name of the actuator; by default the first one of each machine.
        steps: number of steps over the law of that input, 1 to 10 000 000; the result has steps + 1 rows.
        fluctuation: coefficient of speed fluctuation for a flywheel, (largest - smallest) / mean speed, below 2; with
            `rpm`.
        rpm: mean speed of the flywheel [rev/min]; with `fluctuation`.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (rows done, all rows), for a progress bar.

    Returns:
        A ReduceResult: columns (rows,) q, J, dJ_dq, tau, V, dtau_dq, dV_dq and status, with units in `table()`;
        `.wheel` is the flywheel, or None.

    Raises:
        UsageError: an unknown input or an invalid argument.
        ModelError: no masses are defined.
        StructureError: the mechanism has no actuator, or is not fully driven or over-driven.
    """
    refuse(((fluctuation is None) != (rpm is None), "a flywheel needs both fluctuation and rpm"))
    require_masses(mechanism)
    refuse_unmoved(mechanism, "add an actuator")
    chosen = chosen_input(mechanism, actuator)
    require_driven(mechanism)
    found = reduce_to_input(mechanism, chosen, steps, jit, notify, progress("reducing"))
    wheel = None
    if fluctuation is not None and rpm is not None:
        wheel = flywheel(found, rpm * math.pi / 30.0, fluctuation)
    return ReduceResult(found, wheel)


def _reduced(mechanism: Mechanism, name: str) -> Sequence[Machine]:
    """Return the machine of an input; all machines on which forces act if it has no name."""
    if not name:
        return [one for one in loaded_machines(mechanism) if one.actuators] or driven_machines(mechanism)[:1]
    return [one for one in mechanism.loaded_machines if chosen_input(mechanism, name) in one.actuators]


class ReduceResult(RowsResult):
    """Reduced inertia, torque and potential over the input, as columns by name, and the flywheel (`wheel`)."""

    KIND = "reduced"

    def __init__(self, found: Reduction, wheel: Flywheel | None) -> None:
        self.mechanism, self._found, self.wheel = found.mechanism, found, wheel
        self._table = reduction_table(found)
        self.inputs = {found.mechanism.actuators[found.actuator].name: self["q"]}  # the input that remains (rows,)

    @property
    def complete(self) -> bool:
        """Whether all rows are solved."""
        return bool(self._found.solved == len(self._found.q))

    @property
    def _overall(self) -> Status:
        """OK, or the status of the first row that is not solved."""
        bad = self._found.codes[self._found.codes != Status.OK]
        return Status(int(bad[0])) if not self.complete else Status.OK

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: reduced at {self._found.solved} of {len(self._found.q)} positions"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found, table = self._found, self.table()
        return {
            "input": self.mechanism.actuators[found.actuator].name, "steps": len(found.q) - 1,
            "solved": found.solved, "status": self._overall.word,
            **{n: table.floats(n).tolist() for n in table.names if n != "status"},
            **({"flywheel": asdict(self.wheel)} if self.wheel else {}),
        }  # fmt: skip

    def picture(self) -> output.picture.Content | None:
        """Return graphs of the reduced quantities over the input; None if fewer than two rows are solved."""
        found, table, actuator = self._found, self.table(), self.mechanism.actuators[self._found.actuator]
        if found.solved < 2:
            return None
        q = table.floats("q")
        units = {column.name: column.unit for column in table.columns}
        labels = {"J": "reduced inertia J", "dJ_dq": "dJ/dq", "tau": "reduced torque tau", "V": "potential energy V"}
        over = output.graph.Axis(actuator.name, units["q"])
        graphs = [
            output.graph.CurveGraph(over, output.graph.Axis(w, units[n]), [output.graph.Curve(w, q, table.floats(n))])
            for n, w in labels.items()
        ]
        return output.panels.history_sheet(graphs, f"{found.mechanism.name}: reduced to {actuator.name}")
