"""The tables of a sweep that is being computed, and what is known of its designs so far."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from gimcli.families.sweep_job import DESIGN, GOAL, STATUS, Rows
from gimcli.families.sweep_run import SweepRun, best_of
from gimcli.status import Status
from gimcli.table import Column, Table

STEP = "step"
"""Column of the number of the row in each motion, if whole columns are kept."""

DRAWN = 1_000_000
"""Largest number of designs that are kept for a picture."""


class SweepTables:
    """A sweep that is being computed chunk by chunk."""

    def __init__(self, run: SweepRun, units: Mapping[str, str]) -> None:
        self.run, self.job, self.mechanism = run, run.job, run.job.mechanism
        own = {"length": self.mechanism.length_unit, "angle": self.mechanism.angle_unit}
        self.units = {name: own.get(unit, "") for name, unit in units.items()}
        self.counts = np.zeros(len(Status), dtype=np.int64)
        self.careful, self.rows = 0, 0
        self.ranges: dict[str, tuple[float, float, int]] = {}
        self.draws = True
        self.drawn: list[Rows] = []  # rows for the picture, if it is drawn
        self.best: Table | None = None  # the best designs, if they are requested

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        own = self.job.row.names or ()
        return (*own[:-1], STEP, own[-1]) if self.job.rows else own

    def tables(self) -> Iterator[Table]:
        """Yield the table of each chunk, in the order of the designs; with `best` one table."""
        for chunk in best_of(self.job, self.run.chunks()):
            rows = chunk["rows"]
            self.counts += chunk["counts"]
            self.careful += int(chunk["careful"])
            self.rows += len(rows)
            self._add_ranges(rows)
            if self.draws and sum(map(len, self.drawn)) < DRAWN:
                self.drawn.append(rows)
            table = self._table(rows)
            self.best = table if self.job.best else None
            yield table

    def unit(self, name: str) -> str:
        """Return the unit of a column."""
        own = {q.text: q.unit for q in self.job.kept} | self.units
        return self.job.aim.unit if name == GOAL and self.job.aim is not None else own.get(name, "")

    def _table(self, rows: Rows) -> Table:
        each = self.job.steps + 1 if self.job.rows else 1
        own = {name: rows[name] for name in self.job.row.names or ()}
        flat = {name: values.ravel() if values.ndim > 1 else np.repeat(values, each) for name, values in own.items()}
        flat[STATUS] = np.array([status.word for status in Status])[flat[STATUS]]
        if self.job.rows:
            flat[STEP] = np.tile(np.arange(each), len(rows))
        return Table(tuple(Column(name, np.ascontiguousarray(flat[name]), self.unit(name)) for name in self.names))

    def _add_ranges(self, rows: Rows) -> None:
        """Add the least and the greatest value, and the number of designs without one."""
        for name in self.job.row.names or ():
            if name in (DESIGN, STATUS) or rows[name].dtype.kind != "f":
                continue
            values = rows[name][np.isfinite(rows[name])]
            low, high, missing = self.ranges.get(name, (np.nan, np.nan, 0))
            low = float(np.fmin(low, values.min(initial=np.inf))) if len(values) else low
            high = float(np.fmax(high, values.max(initial=-np.inf))) if len(values) else high
            self.ranges[name] = low, high, missing + rows[name].size - len(values)

    def clear(self) -> None:
        """Remove the folder of the parts, after everything was written."""
        if self.run.store is not None:
            self.run.store.clear()
