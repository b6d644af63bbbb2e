"""A sweep in chunks of designs; what a chunk gives depends on its number alone, not on who computes it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.errors import UsageError
from gimcli.families.design_columns import ColumnsAtRow, DesignColumns
from gimcli.families.design_table import DesignTable
from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.four_bar_type import LETTERS
from gimcli.families.quantity_text import REACHABLE, TYPE, ColumnNames, quantity
from gimcli.language.expression import Expression
from gimcli.mechanism import FRAME, FloatArray, IntArray, Mechanism
from gimcli.progress import Notify
from gimcli.status import Status


class MachineColumns(DesignColumns):
    """The columns of a file with several machines; those of no machine alone have the rows that all of them reach."""

    def __init__(self, parts: Sequence[DesignColumns], solved: Designs, names: ColumnNames) -> None:
        super().__init__(solved, names)
        self.parts = parts
        for part in parts:
            part.outcome = self.outcome

    def __getitem__(self, name: str) -> Any:
        """Return values in the shapes of `DesignColumns`; NaN if the machine is not solved."""
        own = [part[name] for part in self.parts if part.names.kind(name).what == "rows"]
        if not own:
            return super().__getitem__(name)
        if self.names.kind(name).columns == 1:
            return np.fmax.reduce(own)
        return np.concatenate([one.reshape(-1, *one.shape[-2:]) for one in own])

    def failures(self) -> IntArray:
        """Return the status of solved rows (designs, rows) whose rates are not determined; 0 in others."""
        return np.asarray(np.max([part.failures() for part in self.parts], axis=0))

    def at(self, actuator: str, value: float) -> Any:
        """Return the columns at the first position at which an input has a value [file's unit]."""
        own = next(part for part in self.parts if actuator in part.names.rows)
        whole = DesignColumns(self.solved, self.names)
        return _ColumnsAt(own, partial(own.at, actuator, value), partial(whole.at, actuator, value))


class _ColumnsAt:
    """The columns where an input of one machine has a value; those of other machines where all are solved."""

    def __init__(self, own: DesignColumns, *at: partial[DesignColumns | ColumnsAtRow]) -> None:
        self._own, self._at = own, at

    def __getitem__(self, name: str) -> Any:
        """Return a column (designs, 1), or the columns of a measure (columns, designs, 1)."""
        return self._at[not self._own.names.kind(name).what]()[name]


def joined_designs(family: Family, designs: FloatArray, parts: Sequence[Designs]) -> Designs:
    """Return the positions of all machines; the status of a row is the worst one."""
    mechanism, time, frame = family.mechanism, parts[0].time[0], family.mechanism.members[FRAME]
    z = np.full((len(designs), len(mechanism.nodes), len(time)), complex(math.nan, math.nan))
    tables = family.tables(designs)
    ground = tables.shapes[:, : len(frame.nodes)]  # the frame is the first member
    z[:, list(frame.nodes)] = ground[..., :1] + 1j * ground[..., 1:]
    for machine, part in zip(mechanism.machines, parts, strict=True):
        placed, nodes = (machine.mechanism.to_file(part.z) - mechanism.origin) / mechanism.scale, list(machine.nodes)
        z[:, nodes] = np.where(np.isfinite(placed), placed, z[:, nodes])
    codes = np.max([part.codes for part in parts], axis=0)
    residual = np.max([part.residual for part in parts], axis=0)  # NaN where a machine is not solved
    inputs = family.law_inputs(time, tables)
    again, careful = partial(family.solve, **parts[0].solve.keywords), max(part.careful for part in parts)
    return Designs(family, again, designs, tables, parts[0].time, inputs, z, codes, residual, careful)


Rows = NDArray[np.void]

MOST_IN_CHUNK, PLACES = 4096, 2_000_000
"""Largest number of designs of a chunk, and of positions of nodes, to limit memory."""

DESIGN, STATUS, GOAL = "design", "status", "goal"
"""Columns of a sweep: number of the design from 1, its status, the goal."""


@dataclass(frozen=True)
class SweepJob:
    """What is computed of each design, and how."""

    mechanism: Mechanism
    table: DesignTable
    steps: int = 72
    keep: tuple[str, ...] = ()
    where: str = ""
    goal: str = ""
    best: int = 0  # number of designs that are kept; 0: all
    tolerance: float = 1e-10
    size: int = MOST_IN_CHUNK  # number of designs of a chunk
    jit: str = "auto"  # "on" or "off" in all processes, so that all compute the same numbers
    rows: bool = False  # whether whole columns are kept, not only numbers of each design
    threads: int | None = None
    notify: Notify | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.__dataclass_fields__} | {"notify": None}

    @cached_property
    def family(self) -> Family:
        """The family; it is made anew in each process."""
        return Family(self.mechanism, self.table.names, self.tolerance)

    @cached_property
    def names(self) -> ColumnNames:
        """The names of columns and dimensions."""
        by_law = not any(a.name == n.partition(".")[0] for a in self.mechanism.actuators for n in self.table.names)
        return ColumnNames(self.mechanism, self.table.names, by_law)

    @cached_property
    def machines(self) -> tuple[tuple[Family, ColumnNames, list[int]], ...]:
        """Of each machine the family, the names, and the places of its dimensions; empty if there is one machine."""
        found = []
        for one in self.mechanism.machines if len(self.mechanism.machines) > 1 else ():
            own = [k for k, name in enumerate(self.table.names) if name in one.mechanism.written.dimensions]
            names = [self.table.names[k] for k in own]
            found.append((Family(one.mechanism, names, self.tolerance), ColumnNames(one.mechanism, names), own))
        return tuple(found)

    @cached_property
    def kept(self) -> tuple[Expression, ...]:
        """The kept quantities."""
        kinds = ("rows",) if self.rows else ("number", "text")
        return tuple(quantity(text, self.names, kinds, "keep") for text in self.keep)

    @cached_property
    def filter(self) -> Expression | None:
        """The condition that kept designs satisfy."""
        return quantity(self.where, self.names, ("yes",), "where") if self.where else None

    @cached_property
    def aim(self) -> Expression | None:
        """The quantity that is least in the best designs."""
        return quantity(self.goal, self.names, ("number",), "goal") if self.goal else None

    @cached_property
    def quantities(self) -> tuple[Expression, ...]:
        """All quantities that are computed."""
        return tuple(q for q in (*self.kept, self.filter, self.aim) if q is not None)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.table.count // self.size)

    @cached_property
    def row(self) -> np.dtype[np.void]:
        """The columns of a design."""
        shape = (self.steps + 1,) if self.rows else ()
        own = [(q.text, LETTERS if q.kind.what == "text" else "f8", shape) for q in self.kept]
        goal = [(GOAL, "f8")] if self.aim is not None else []
        fields: list[Any] = [(DESIGN, "i8"), *((n, "f8") for n in self.table.names), *own, *goal, (STATUS, "i1")]
        names = [name for name, *_ in fields]
        for name in names:
            if names.count(name) > 1:
                raise UsageError(f"keep: two columns would be named '{name}'; rename the parameter, or keep another")
        return np.dtype(fields)

    def check(self) -> None:
        """Raise UsageError where a quantity, filter or goal is not valid."""
        used = frozenset[str]().union(*(q.names for q in self.quantities))
        if TYPE in used:
            self.names.check_type()
        if self.best and self.aim is None:
            raise UsageError("best: the best designs need a goal, such as goal='max(P.y)' (the least value is best)")
        assert self.row.names

    def run(self, number: int) -> Rows:
        """Return one chunk: the designs by status, the number that was solved one by one, and the kept rows."""
        first = number * self.size
        designs = self.table.rows(first, min(first + self.size, self.table.count))
        reachable = any(REACHABLE in q.names for q in self.quantities)
        options: dict[str, Any] = {"reachable": reachable, "threads": self.threads, "jit": self.jit}
        if self.notify is not None:
            options["notify"] = self.notify
        columns = self.columns(designs, self.steps, options)
        rows = np.empty(len(designs), dtype=self.row)
        rows[DESIGN] = np.arange(first + 1, first + 1 + len(designs))
        for k, name in enumerate(self.table.names):
            rows[name] = designs[:, k]
        for own in self.kept:
            rows[own.text] = columns.of(own)
        if self.aim is not None:
            rows[GOAL] = columns.of(self.aim)
        held = slice(None) if self.filter is None else np.broadcast_to(columns.of(self.filter), len(designs))
        rows[STATUS] = status = columns.status  # of what was computed before
        rows = rows[held]
        return packed(np.bincount(status, minlength=len(Status)), columns.solved.careful, self.chosen(rows))

    def columns(self, designs: FloatArray, steps: int, options: dict[str, Any]) -> DesignColumns:
        """Solve designs (designs, dimensions) and return their columns; `options` are those of Family.solve."""

        def of(family: Family, names: ColumnNames, own: FloatArray) -> DesignColumns:
            return DesignColumns(family.solve(own, steps, **options), names)

        if not self.machines:
            return of(self.family, self.names, designs)
        parts = [of(family, names, designs[:, own]) for family, names, own in self.machines]
        solved = joined_designs(self.family, designs, [part.solved for part in parts])
        return MachineColumns(parts, solved, self.names)

    def chosen(self, rows: Rows) -> Rows:
        """Return the best rows by the goal, the best first; all rows if all are kept."""
        if not self.best:
            return rows
        known = rows[np.isfinite(rows[GOAL])]
        order = np.lexsort((known[DESIGN], known[GOAL]))
        return np.asarray(known[order[: self.best]])


def chunk_size(mechanism: Mechanism, steps: int) -> int:
    """Return the number of designs of a chunk, which limits memory."""
    return max(1, min(MOST_IN_CHUNK, PLACES // ((steps + 1) * max(len(mechanism.nodes), 1))))


def packed(counts: IntArray, careful: int, rows: Rows) -> Rows:
    """Return a chunk as one record, which is saved as one array."""
    kind = np.dtype([("counts", "i8", counts.shape), ("careful", "i8"), ("rows", rows.dtype, rows.shape)])
    found = np.zeros((), dtype=kind)
    found["counts"], found["careful"], found["rows"] = counts, careful, rows
    return found


def default_keep(mechanism: Mechanism, rows: bool = False) -> tuple[str, ...]:
    """Return what is kept by default: the ranges of the traced points, or of the nodes that are not on the frame.

    With `rows` their coordinates.
    """
    moving = [n for k, n in enumerate(mechanism.nodes) if k not in mechanism.members[FRAME].nodes]
    points: Sequence[str] = mechanism.traced or moving
    if rows:
        return tuple(f"{name}.{part}" for name in points for part in "xy")
    return (*(f"range({name}.{part})" for name in points for part in "xy"), "solved")
