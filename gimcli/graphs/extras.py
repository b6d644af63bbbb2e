"""The measures and graphs that are requested of a trace."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.mechanism import IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.progress import Notify
from gimcli.quantities.coordinates import MemberTurning, PointVector, RowValue
from gimcli.quantities.motion_table import Record, abscissa, motion_table, usual
from gimcli.quantities.quantity import Quantity
from gimcli.quantities.state import ApartError, MotionState, Needs
from gimcli.rates.member_angles import Angles, in_rows
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.graphs.plots import PlannedGraph
    from gimcli.output.graph import CurveGraph
    from gimcli.rates.derivatives import TracedRates


class Extras:
    """The quantities and graphs that are requested of one motion, beside the columns of its command."""

    def __init__(
        self, mechanism: Mechanism, measures: str | Sequence[str] = (), plot: str | Sequence[str] = (),
        derivatives: int = 0, columns: Mapping[str, str] | None = None, usual: Sequence[PlannedGraph] = (),
    ) -> None:  # fmt: skip
        """Read the texts of measures and graphs; raise UsageError for an unknown name.

        `columns` are the units of the columns that only the command has, `usual` its graphs without `plot`.
        """
        self.mechanism = mechanism
        self.plans: list[PlannedGraph] = []
        self.specs, graphs = texts(measures), texts(plot)
        self.wanted: list[Quantity] = []
        if self.specs:
            from gimcli.quantities.catalogue import catalogue

            items = (item for text in self.specs for item in catalogue(mechanism).asked(text))
            self.wanted += dict.fromkeys(item.quantity for item in items)
        self.record = Record(self.wanted)
        if graphs:
            self._plan(graphs, columns)
        drawn = self.plans or usual
        self._names, self._parts = {name for plan in drawn for name in plan.columns}, list[list[Column]]()
        motion = [one for one in self.wanted if isinstance(one, PointVector | MemberTurning)]
        needs = Needs(mechanism, motion)
        self.order = max(derivatives, needs.order)
        self.names = (*mechanism.traced, *(name for name in needs.points if name not in mechanism.traced))
        self._members = needs.members
        others = {one.spec: one for one in self.wanted if one not in motion and not isinstance(one, RowValue)}
        self._others = list(others.values())

    def _plan(self, graphs: Sequence[str], columns: Mapping[str, str] | None) -> None:
        """Read the graphs and add their quantities."""
        from gimcli.graphs.vocabulary import Vocabulary
        from gimcli.quantities.catalogue import catalogue

        vocabulary, known = Vocabulary(self.mechanism, columns, self.specs), catalogue(self.mechanism)
        every = (plan for text in graphs for plan in vocabulary.plans(text))
        self.plans = list(dict.fromkeys(every))
        names = dict.fromkeys(name for plan in self.plans for name in sorted(plan.columns))
        found = (known.column(name) for name in names if name not in (columns or ()))
        self.wanted = [*self.wanted, *(item.quantity for item in found if item is not None)]

    def measured(self, state: MotionState, names: Sequence[str]) -> list[Column]:
        """Return the columns of measures that a table with some names lacks; `state` is the next piece of a motion."""
        self.record.add(state)
        return _columns(state, self.record.measures, names)

    def beside(self, state: MotionState, names: Sequence[str]) -> list[Column]:
        """Return the columns of measures and graphs that a table with some names lacks."""
        return _columns(state, self.wanted, names)

    def quantities(self, order: int | None = None) -> list[Quantity]:
        """Return the quantities of the table, with derivatives up to an order, by default as far as they are needed."""
        own = self.order if order is None else order
        return [*usual(self.mechanism, self.names, own, self._members), *self._others]

    def traced(self, order: int, rows: int = 0, jit: str = "off", notify: Notify | None = None) -> TracedRates | None:
        """Return what computes the derivatives of the points and members; None without derivatives."""
        if not order:
            return None
        from gimcli.rates.derivatives import TracedRates

        return TracedRates(self.mechanism, self.names, order, rows, jit, notify)

    def table(self, piece: Motion, angles: Angles, first: int = 0, traced: TracedRates | None = None) -> Table:
        """Return the table of the next piece of the motion; `angles` counts full turns."""
        state = MotionState(piece, angles, self.record.memory, traced)
        table = motion_table(piece, self.quantities(), first, state)
        self.record.add(state)
        return table

    def head(self, row: Motion) -> Table:
        """Return the table of the first row, with empty quantities."""
        return motion_table(row, self.quantities(), blank=True)

    def apart(self, motion: Motion, angles: Angles = in_rows, order: int | None = None) -> Table:
        """Return the table of a motion that is no piece of the traced one, such as a part of its rows."""
        state = MotionState(motion, angles, traced=self.traced(self.order if order is None else order))
        return motion_table(motion, self.quantities(order), state=state)

    def with_expressions(self, table: Table) -> Table:
        """Return a table with the expressions of the graphs as further columns, by their texts."""
        columns = {c.name: c for c in table.columns}
        every = {q.text: q for plan in self.plans for curve in plan.curves for q in curve if q is not None}
        own = {name: q for name, q in every.items() if name not in columns}
        more = (Column(name, q.values(columns, len(table)), q.unit_in(columns)) for name, q in own.items())
        return Table((*table.columns, *more))

    def check(self, head: Table) -> None:
        """Raise UsageError if a graph cannot be drawn, such as one with abscissae of different units."""
        from gimcli.graphs.plots import drawn

        for plan in self.plans:
            drawn(plan, {column.name: column for column in head.columns}, Column("", head.columns[0].values))

    def keep(self, table: Table, rows: IntArray) -> None:
        """Keep rows of the next table for the graphs."""
        self._parts.append([Column(c.name, c.values[rows], c.unit) for c in table.columns if c.name in self._names])

    @property
    def kept(self) -> dict[str, Column]:
        """The columns of the graphs by name, in the rows that are kept."""
        each = zip(*self._parts, strict=True)
        return {c[0].name: Column(c[0].name, np.concatenate([p.values for p in c]), c[0].unit) for c in each}

    def graphs(self, motion: Motion, events: Sequence[tuple[str, Mapping[str, float]]]) -> list[CurveGraph]:
        """Return the graphs; `motion` has the rows that are kept."""
        if not self.plans:
            return []
        from gimcli.graphs.plots import drawn

        columns, across = self.kept, abscissa(motion)
        return [drawn(plan, columns, across, events) for plan in self.plans]

    def report(self, motion: Motion, given: MotionState | None = None) -> dict[str, Any]:
        """Return the results of the measures for the whole motion, for --json; `given` is its state, if not by laws."""
        state = given or MotionState(motion, memory=self.record.memory)
        return {"measures": self.record.results(state)} if self.record.measures else {}


def texts(given: str | Sequence[str]) -> list[str]:
    """Return the texts of an argument that are not empty."""
    return [text for text in ([given] if isinstance(given, str) else given) if text.strip()]


def _columns(state: MotionState, quantities: Sequence[Quantity], names: Sequence[str]) -> list[Column]:
    """Return the columns of quantities without those of some names; raise UsageError where a state has none."""
    heads = {h.name: (one, k, h.unit) for one in quantities for k, h in enumerate(one.heads) if h.name not in names}
    try:
        return [Column(name, np.asarray(state.value(one, k)), unit) for name, (one, k, unit) in heads.items()]
    except ApartError as error:
        raise UsageError(f"{', '.join(heads)}: {error}") from None
