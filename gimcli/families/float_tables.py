"""The numbers of a plan that depend on the dimensions, for many designs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import nominal
from gimcli.calculus.recorded import Recorded, Recording
from gimcli.mechanism import FRAME, FloatArray, Mechanism
from gimcli.positions.program import PlanProgram


class FloatTables(NamedTuple):
    """The numbers of a plan, plain or dual, leading axis designs."""

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
            self.slots.append((varied, [table[k].place for k in varied]))
            self.nominal.append(np.array([x.value if isinstance(x, Recorded) else x for x in table], dtype=float))
        self.wanted = sorted({place for _, own in self.slots for place in own})

    def flat(self, designs: Any) -> list[Any]:
        """Return the numbers (designs, numbers) of each table of designs (designs, dimensions), plain or dual."""
        found = self.recording.evaluate([designs[:, k] for k in range(designs.shape[1])], self.wanted)
        return [self._filled(*one, found, designs) for one in zip(self.nominal, self.slots, strict=True)]

    def tables(self, designs: Any) -> FloatTables:
        """Return the tables of designs (designs, dimensions), plain or dual."""
        own = dict(zip(FloatTables._fields, self.flat(designs), strict=True))
        own |= {k: np.reshape(x, (len(designs), x.shape[1] // 2, 2)) for k, x in own.items() if k != "reach"}
        return FloatTables(**own)

    def _filled(self, nominals: FloatArray, slot: Any, found: dict[int, Any], designs: Any) -> Any:
        """Return a list of numbers with those that differ from design to design."""
        table = np.repeat(nominals[None], len(designs), axis=0)
        slopes = np.zeros((len(designs.slopes) if isinstance(designs, Dual) else 0, *table.shape))
        for column, place in zip(*slot, strict=True):
            table[:, column] = nominal(found[place])
            if isinstance(designs, Dual):
                slopes[..., column] = found[place].slopes
        return Dual(table, slopes) if isinstance(designs, Dual) else table
