"""Positions at arrays of inputs, each solved by itself from the initial coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.errors import UsageError, refuse
from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.graphs.extras import Extras
from gimcli.library.inputs import inputs_of
from gimcli.library.trace_result import Placed
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.quantities.coordinates import MemberTurning, PointVector
from gimcli.quantities.state import AT_REST, SeparateState
from gimcli.status import Status
from gimcli.table import Column, Table


def solved_positions(
    mechanism: Mechanism, at: Mapping[str, Any], tolerance: float, measure: str | Sequence[str]
) -> SolvedPositions:  # fmt: skip
    """Return the positions at inputs of which some are arrays (rows,); the others are the same in all rows."""
    try:
        given = np.broadcast_arrays(*(np.asarray(values, dtype=np.float64) for values in at.values()))
    except ValueError:
        raise UsageError("at: expected numbers, and arrays of equal length") from None
    refuse((given[0].ndim != 1, f"at: expected arrays with one axis, got {given[0].ndim}"))
    rows = [inputs_of(mechanism, dict(zip(at, row, strict=True)), {}) for row in np.stack(given, axis=1).tolist()]
    inputs = np.array(rows).reshape(len(rows), -1)
    found = Family(mechanism, [], tolerance).solve(np.empty((len(rows), 0)), inputs=inputs[:, :, None])
    return SolvedPositions(mechanism, found, inputs.T, Extras(mechanism, measure))


def positions_state(
    mechanism: Mechanism, inputs: FloatArray, z: ComplexArray, residual: FloatArray, codes: Sequence[int] | IntArray
) -> SeparateState:
    """Return positions z (nodes, rows) at inputs (actuators, rows) as a state, at the rates of the laws there.

    The time is that of the first input.
    """
    from gimcli.rates.derivatives import law_state

    each = [law_state(mechanism, *row) for row in zip(inputs.T, z.T, strict=True)]
    times = np.array([np.append(time, 0.0)[0] for time, _ in each])
    time, given = np.where(np.isfinite(times), times, 0.0), np.stack([given for _, given in each], axis=-1)
    return SeparateState(separate(mechanism, time, inputs, z, residual, codes), given)


def positions_at_rest(
    mechanism: Mechanism, time: float, inputs: FloatArray, z: ComplexArray, residual: Any = 0.0, code: int = 0
) -> SeparateState:  # fmt: skip
    """Return positions z (nodes, rows) at inputs (actuators, rows) and a time [s] as a state at rest."""
    rows = np.full(inputs.shape[1], time / mechanism.duration)
    return SeparateState(separate(mechanism, rows, inputs, z, residual + 0.0 * rows, code + 0 * rows), rest=AT_REST)


def separate(
    mechanism: Mechanism, time: FloatArray, inputs: FloatArray, z: ComplexArray, residual: FloatArray, codes: Any
) -> Motion:
    """Return positions z (nodes, rows) at normalised times (rows,) as rows that are no motion."""
    return Motion(mechanism, time, inputs, z, np.asarray(codes, dtype=int), residual, 0.0 * time, z[:, 0])


class SolvedPositions(Placed):
    """Positions: `status` (rows,), `xy[name]` (rows, 2), `angle[member]` (rows,), and the columns by name.

    A row that is not solved has a status word other than "ok", and NaN.
    """

    KIND = "solve"

    def __init__(self, mechanism: Mechanism, found: Designs, inputs: FloatArray, extras: Extras) -> None:
        self.mechanism, self._found, self._inputs, self._extras = mechanism, found, inputs, extras

    @cached_property
    def _state(self) -> SeparateState:
        """The positions, of which any quantity may be asked by its name, at the rates of the laws there."""
        found = self._found
        return positions_state(self.mechanism, self._inputs, self._z, found.residual[:, 0], found.codes[:, 0])

    @property
    def _z(self) -> Any:
        return self._found.z[:, :, 0].T

    @property
    def complete(self) -> bool:
        """Whether all positions are solved."""
        return bool(self._found.good.all())

    def table(self) -> Table:
        """Return one row for each position: inputs, coordinates of nodes and points, directions, residual, status."""
        own, state = self.mechanism, self._state
        names = [*own.nodes, *(p.name for p in own.points)]
        asked = [PointVector(own, name, 0) for name in names]
        members = [MemberTurning(own, k, 0) for k in range(FRAME + 1, len(own.members))]
        columns = [Column(a.name, state.row(a.name), own.unit_of(a)) for a in own.actuators]
        for one in (*asked, *members):
            columns += [Column(h.name, np.asarray(state.value(one, k)), h.unit) for k, h in enumerate(one.heads)]
        columns += self._extras.beside(state, [column.name for column in columns])
        words = np.array([status.word for status in Status])[self._found.codes[:, 0]]
        return Table((*columns, Column("residual", self._found.residual[:, 0]), Column("status", words)))

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: {int(self._found.good.sum())} of {len(self._found.codes)} positions solved"

    def report(self) -> dict[str, Any]:
        """Return the number of positions, and of those that are solved."""
        return {"positions": len(self._found.codes), "solved": int(self._found.good.sum())}
