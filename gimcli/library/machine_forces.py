"""The forces of independent machines of one file: computed for each, with the columns of all in one table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.errors import refuse
from gimcli.library.machines import MachinesResult
from gimcli.library.result import UnderWay
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.status import Status
from gimcli.table import Column, Table

COMMON = ("step", "time")
"""Columns with the same values for all machines."""

SUMS = ("shaking.", "power.", "energy.")
"""Beginnings of the names of columns that are added; those of each machine are there too, after its name."""

GRAPHS, CURVES = ",", "+"
"""Signs between the graphs of a text, and between the curves of a graph."""

SHAKING = ("shaking.fx", "shaking.fy", "shaking.moment")


class MachineForces(MachinesResult):
    """The forces of several machines: `each` by name, and one row for each step with the columns of all."""

    solved = 0

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints: rows are solved if the forces of all machines are determined there."""
        return {**super().report(), "solved": self.solved}


class ForcesBeside(UnderWay[MachineForces]):
    """The forces of machines that move at the same times: first the tables of the pieces, then the result."""

    def __init__(
        self, mechanism: Mechanism, begun: dict[str, Any], measure: Sequence[str], plot: Sequence[str]
    ) -> None:  # fmt: skip
        self.mechanism, self.begun, self.solved = mechanism, begun, 0
        self.expected = max(one.expected for one in begun.values())

        def owned(text: str) -> bool:
            return any(one.knows((), [text]) for one in begun.values())

        texts = list(plot)
        for sign in GRAPHS, CURVES:  # each machine has a picture of its own, with its own graphs and curves
            texts = [part for text in texts for part in ([text] if owned(text) else text.split(sign))]
        measures = {name: [text for text in measure if one.knows([text], ())] for name, one in begun.items()}
        unknown = [f"plot {text.strip()}" for text in texts if not owned(text)]
        unknown += [f"measure {text}" for text in measure if not any(text in own for own in measures.values())]
        refuse(*((one, f"{one}: no machine has these columns; machines: {', '.join(begun)}") for one in unknown))
        for name, one in begun.items():
            one.choose(measures[name], [text for text in texts if one.knows((), [text])])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self._beside([one.head for one in self.begun.values()]).names

    def tables(self) -> Iterator[Table]:
        """Yield the table of each piece of the motion."""
        for one in self.begun.values():
            one.keeps = self.keeps
        for tables in zip(*(one.tables() for one in self.begun.values()), strict=True):
            table = self._beside(tables)
            self.solved += int(np.sum(table["status"] == Status.OK.word))
            yield table

    def result(self, table: Table | None) -> MachineForces:
        """Return the result, after all tables were read; `table` is None if they were written to a file."""
        each = {name: one.result(self._own(name, one, table)) for name, one in self.begun.items()}
        found = MachineForces(self.mechanism, each, table)
        found.solved = self.solved
        return found

    def _own(self, machine: str, one: Any, table: Table | None) -> Table | None:
        """Return the columns of a machine."""
        if table is None:
            return None
        known = table.by_name
        return Table(tuple(replace(known.get(f"{machine}.{n}") or known[n], name=n) for n in one.names))

    def _beside(self, tables: Sequence[Table]) -> Table:
        """Return the columns of all machines; those that several have begin with the name of the machine."""
        counts = Counter(name for table in tables for name in table.names)
        columns = {name: column for table in tables for name, column in table.by_name.items() if counts[name] == 1}
        ahead = {name: column for name, column in tables[0].by_name.items() if name in COMMON}
        own = {
            f"{machine}.{name}": replace(column, name=f"{machine}.{name}")
            for machine, table in zip(self.begun, tables, strict=True)
            for name, column in table.by_name.items()
            if counts[name] > 1 and name not in COMMON
        }
        common = [name for name in tables[0].names if counts[name] > 1 and name.startswith(SUMS)]
        sums = [
            Column(name, np.sum([t[name] for t in tables if name in t.names], axis=0), tables[0].by_name[name].unit)
            for name in common
        ]
        shifted = [c if c.name != SHAKING[2] else replace(c, values=c.values + self._shift(tables)) for c in sums]
        residual = Column("residual", np.max([table["residual"] for table in tables], axis=0))
        status = Column("status", _worst([table["status"] for table in tables]))
        return Table((*ahead.values(), *columns.values(), *shifted, *own.values(), residual, status))

    def _shift(self, tables: Sequence[Table]) -> FloatArray:
        """Return what the shaking moments [N m] change about the first ground node of the file (rows,)."""
        whole, found = self.mechanism, np.zeros(len(tables[0]))
        metre = (whole.dynamics.metre or 0.0) / whole.scale
        for one, table in zip(self.begun.values(), tables, strict=True):
            arm = metre * (one.found.statics.mechanism.origin - whole.origin)
            found += arm.real * table["shaking.fy"] - arm.imag * table["shaking.fx"]
        return found


def _worst(words: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Return the worst word of each row (rows,): the one with the greatest code."""
    codes = {status.word: int(status) for status in Status}
    found = {str(word) for own in words for word in np.unique(own)}
    kinds = sorted(found, key=lambda word: codes.get(word, int(Status.LIMIT)))  # words of friction have no code
    ranks = [np.select([own == kind for kind in kinds], range(len(kinds))) for own in words]
    return np.asarray(np.array(kinds)[np.max(ranks, axis=0)])
