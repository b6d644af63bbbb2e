"""The numbers of a plan that depend on the dimensions, for many designs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.recorded import Recorded, Recording
from gimcli.mechanism import FRAME, FloatArray, IntArray, Mechanism
from gimcli.positions.program import PlanProgram


class FloatTables(NamedTuple):
    """The numbers of a plan, leading axis designs (or dimensions, for derivatives)."""

    vz: FloatArray  # (·, vectors, 2) of `Program`
    lv: FloatArray  # (·, loci, 2)
    cv: FloatArray  # (·, checks, 2)
    reach: FloatArray  # (·, steps)
    gvz: FloatArray  # (·, vectors of all groups, 2)
    gev: FloatArray  # (·, equations of all groups, 2)
    frame: FloatArray  # (·, nodes, 2) coordinates of the nodes of the frame, 0 for others
    points: FloatArray  # (·, points, 2) coordinates of `Mechanism.points` in the frames of their members
    shapes: FloatArray  # (·, nodes of all members, 2) coordinates in the members' own frames, one after another
    normals: FloatArray  # (·, slides, 2) normals of the guides in `Mechanism.slides`, in the frames of their members
    laws: FloatArray  # (·, actuators, 2) first and last value of laws of that kind, NaN for others


def listed(mechanism: Mechanism, program: PlanProgram) -> list[list[Any]]:
    """Return the entries of each table as a flat list of numbers, plain or recorded."""
    q, groups = program.tables, [packed.tables for packed in program.groups]
    frame: list[Any] = [0.0] * (2 * len(mechanism.nodes))
    for node, z in zip(mechanism.members[FRAME].nodes, mechanism.members[FRAME].shape, strict=True):
        frame[2 * node : 2 * node + 2] = [z.real, z.imag]
    return [
        _flat(q.vz), _flat(q.lv), _flat(q.cv), list(q.reach),
        [x for group in groups for x in _flat(group[3])], [x for group in groups for x in _flat(group[4])], frame,
        _parts(point.local for point in mechanism.points), _parts(z for m in mechanism.members for z in m.shape),
        _parts(row.normal for row in mechanism.slides),
        [getattr(a.law, name, np.nan) for a in mechanism.actuators for name in ("start", "end")],
    ]  # fmt: skip


def _flat(rows: Sequence[Sequence[Any]]) -> list[Any]:
    return [x for row in rows for x in row]


def _parts(numbers: Any) -> list[Any]:
    return [part for z in numbers for part in (z.real, z.imag)]


class TableMaker:
    """Makes the tables of designs from a recording."""

    def __init__(self, recording: Recording, lists: Sequence[Sequence[Any]]) -> None:
        self.recording, self.slots = recording, []
        self.nominal: list[FloatArray] = []
        for table in lists:
            varied = [k for k, x in enumerate(table) if isinstance(x, Recorded)]
            self.slots.append((np.array(varied, dtype=np.int64), [table[k].place for k in varied]))
            self.nominal.append(np.array([x.value if isinstance(x, Recorded) else x for x in table], dtype=float))
        self.wanted = sorted({place for _, own in self.slots for place in own})

    def flat(self, designs: FloatArray) -> list[FloatArray]:
        """Return each table of designs (designs, dimensions) as its list of numbers (designs, numbers)."""
        return self._filled(self.recording.evaluate(designs.T, self.wanted), len(designs), self.nominal)

    def values(self, designs: FloatArray) -> FloatTables:
        """Return the tables of designs (designs, dimensions)."""
        return _shaped(self.flat(designs))

    def tangents(self, designs: FloatArray) -> FloatTables:
        """Return the derivatives of the tables of designs (designs, dimensions), leading axes designs, dimensions."""
        count, n = designs.shape
        tables = _shaped(self.flat_tangents(designs))
        return FloatTables(*(x.reshape(count, n, *x.shape[1:]) for x in tables))

    def flat_tangents(self, designs: FloatArray) -> list[FloatArray]:
        """Return the derivatives of the lists of numbers (designs x dimensions, numbers)."""
        found = self.recording.tangents(designs.T, self.wanted)
        flat = {place: np.ravel(np.swapaxes(one.slopes, 0, 1)) for place, one in found.items()}
        return self._filled(flat, designs.size, [np.zeros_like(x) for x in self.nominal])

    def _filled(self, found: dict[int, Any], count: int, base: Sequence[FloatArray]) -> list[FloatArray]:
        tables = []
        for x, (columns, places) in zip(base, self.slots, strict=True):
            tables.append(np.repeat(x[None], count, axis=0))
            for column, place in zip(columns.tolist(), places, strict=True):
                tables[-1][:, column] = found[place]
        return tables


def _shaped(flat: Sequence[FloatArray]) -> FloatTables:
    """Return tables from their lists of numbers (designs, numbers)."""
    pairs = zip(FloatTables._fields, flat, strict=True)
    return FloatTables(*(x if name == "reach" else x.reshape(len(x), x.shape[1] // 2, 2) for name, x in pairs))


def with_inputs(table: FloatArray, inputs: int) -> FloatArray:
    """Return derivatives (designs, dimensions, ...) with those by inputs after them; they are 0."""
    return np.concatenate([table, np.zeros((len(table), inputs, *table.shape[2:]))], axis=1)


def spans(mechanism: Mechanism) -> IntArray:
    """Return the first row of each member in `FloatTables.shapes`, and their number."""
    return np.cumsum([0, *(len(member.nodes) for member in mechanism.members)])
