"""Find the efforts that hold one position at rest, and the reactions there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from gimcli import output
from gimcli.dynamics.force_motion import UNDETERMINED, force_table, open_reactions
from gimcli.dynamics.force_statistics import UNITS
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.physical import require_action
from gimcli.graphs.extras import Extras
from gimcli.library.by_name import places
from gimcli.library.inputs import Jit, Time, Tolerance, in_file_units, inputs_of
from gimcli.library.machines import for_each_machine, loaded_machines
from gimcli.library.record import quantity_rows
from gimcli.library.result import Result
from gimcli.library.solved_positions import positions_at_rest
from gimcli.mechanism import Mechanism
from gimcli.motion.solve import solve as solve_position
from gimcli.positions.options import Options
from gimcli.positions.position import Position
from gimcli.quantities.state import SeparateState
from gimcli.rounding import titled
from gimcli.status import Status
from gimcli.structure.drive_check import require_consistent
from gimcli.table import Table

LIMITS = ("least", "greatest")
LEFT_OUT = ("step", "energy.kinetic", "efficiency", "friction", "residual")
"""Columns of a motion that have no meaning at rest; those of powers are left out, too."""


@for_each_machine(loaded_machines)
def holding_forces(
    mechanism: Mechanism, at: Mapping[str, float | str] | None = None, *, time: Time = 0.0,
    tolerance: Tolerance = 1e-10, jit: Jit = "auto", measure: str | Sequence[str] = (), **inputs: float,
) -> HoldingResult:  # fmt: skip
    """Find the efforts that hold one position at rest, for example `holding_forces(m, motor=60)`.

    Args:
        mechanism: from `load` or `loads`; it needs masses, loads, springs, dampers or friction.
        at: dict of inputs by name, for names that are not Python names or are names of arguments.
        time: time [s] at which tables of loads over the time are read.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        measure: quantities of the report and the table, a text or a list, such as "hypot(A.fx, A.fy)".
        inputs: inputs by name, in the file's units. Inputs that are not given have the value at the start of their law.

    Returns:
        A HoldingResult: efforts [N m or N] and reactions [N] as columns of one row, by the names of `forces`. With dry
        friction the efforts are between `INPUT.effort.least` and `INPUT.effort.greatest`.

    Raises:
        UsageError: an unknown name or an invalid argument.
        ModelError: no masses, loads, springs, dampers or friction are defined.
        StructureError: the mechanism has no actuator, or is not fully driven, over-driven or contradictory.
    """
    require_action(mechanism)
    values, extras = inputs_of(mechanism, at, inputs), Extras(mechanism, measure)
    position = solve_position(mechanism, values, Options(tolerance=tolerance, jit=jit))
    require_consistent(mechanism, position.z, position.inputs, position.status, tolerance)
    return HoldingResult(position, time, extras)


class HoldingResult(Result):
    """The efforts and reactions of one position at rest: one row, with the columns of `forces`."""

    KIND = "holding"

    def __init__(self, position: Position, time: float, extras: Extras) -> None:
        self.mechanism, self._found, self.time = position.mechanism, position, time
        self.inputs = in_file_units(position.mechanism, position.inputs)
        self._measured = extras.beside(self._state, ())

    @cached_property
    def _forces(self) -> Forces:
        """The efforts and reactions; NaN where they are not determined."""
        return self._state.forces

    @cached_property
    def _state(self) -> SeparateState:
        """The position at rest, of which any quantity may be asked by its name."""
        position, mechanism = self._found, self.mechanism
        z = np.where(position.status.value, complex(math.nan, math.nan), position.z)[:, None]
        inputs, residual = position.inputs[:, None], position.residual.total
        return positions_at_rest(mechanism, self.time, inputs, z, residual, int(position.status))

    @cached_property
    def _table(self) -> Table:
        table = force_table(self._state.motion, self._forces)
        left_out = [*LEFT_OUT, *(f"{a.name}.hold.{end}" for a in self.mechanism.actuators for end in LIMITS)]
        return Table(tuple(c for c in table.columns if c.name not in left_out and not c.name.startswith("power.")))

    def table(self) -> Table:
        """Return one row: time, inputs, efforts, reactions, shaking force, potential energy, status, measures."""
        return Table((*self._table.columns, *(c for c in self._measured if c.name not in self._table.names)))

    @cached_property
    def status(self) -> str:
        """The status word: "ok", that of the position, "singular", or "standstill" with dry friction."""
        return str(self._table["status"][0])

    @property
    def complete(self) -> bool:
        """Whether the forces are determined, with dry friction within limits."""
        return self.status in ("ok", "standstill")

    @property
    def reason(self) -> str:
        """Why there are no forces; "" if they are determined."""
        if self.complete:
            return ""
        if self._found.status is Status.OK:
            return UNDETERMINED
        from gimcli.motion.unassembled import reason

        return f"{self.status}: {reason(self.mechanism, self._found.status, self._found.inputs)}"

    @property
    def open(self) -> list[str]:
        """Names of the reactions that redundant constraints leave undetermined."""
        return open_reactions(self._forces)

    @property
    def forces(self) -> dict[str, tuple[complex | float, str]]:
        """Efforts, normal forces and moments as numbers, pin forces as x + iy, by name, with their units."""
        found: dict[str, tuple[complex | float, str]] = {}
        columns = {column.name: column for column in self._table.columns if column.unit in UNITS}
        for name, column in columns.items():
            value = float(column.values[0])
            if name.endswith(".fx"):
                found[name[:-3]] = complex(value, float(columns[f"{name[:-1]}y"].values[0])), column.unit
            elif not name.endswith(".fy"):
                found[name] = value, column.unit
        return found

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{titled(self.mechanism, self.inputs)}: forces at rest, {self.status}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        forces = {
            name: {"x": value.real, "y": value.imag, "magnitude": abs(value), "unit": unit}
            if isinstance(value, complex)
            else {"value": value, "unit": unit}
            for name, (value, unit) in self.forces.items()
        }
        return {
            "status": self.status, "reason": self.reason, "time": self.time, "inputs": self.inputs, "forces": forces,
            "open": self.open, **({"measures": quantity_rows(self._measured).by("name")} if self._measured else {}),
        }  # fmt: skip

    def picture(self) -> output.picture.Content | None:
        """Return the position with the pin forces; None if it is not solved."""
        mechanism = self.mechanism
        if self._found.status.value:
            return None
        found = places(mechanism, self._found.z[:, None], lambda z: complex(z[0]))
        points = {point.name: found[point.name] for point in mechanism.points}
        vectors = {
            name: (found[node], value)
            for name, (value, _) in self.forces.items()
            if isinstance(value, complex) and (node := self._node(name)) and np.isfinite(value)
        }
        title = f"{titled(mechanism, self.inputs)}: forces at rest"
        arrows = [output.vectors.Arrows("force", "N", vectors)] if vectors else []
        return output.drawing.position_picture(mechanism, mechanism.to_file(self._found.z), title, points, arrows)

    def _node(self, reaction: str) -> str:
        """Return the node of a pin force; "" for the shaking force."""
        nodes = [node for node in self.mechanism.nodes if reaction == node or reaction.startswith(f"{node}.")]
        return max(nodes, key=len, default="")
