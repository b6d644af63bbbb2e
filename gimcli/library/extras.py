"""The measures and graphs that are requested of a trace."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gimcli.mechanism import ComplexArray, IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.progress import Notify
from gimcli.quantities.coordinates import MemberTurning, PointVector, RowValue
from gimcli.quantities.motion_table import motion_table, usual
from gimcli.quantities.quantity import Quantity
from gimcli.quantities.record import Record
from gimcli.quantities.state import MotionState, Needs
from gimcli.rates.member_angles import Angles, in_rows
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.library.plots import KeptColumns, PlannedGraph
    from gimcli.output.graph import CurveGraph
    from gimcli.rates.derivatives import TracedRates


class Extras:
    """The quantities and graphs of one trace."""

    def __init__(
        self, mechanism: Mechanism, measures: Sequence[str], plot: str | Sequence[str], derivatives: int
    ) -> None:
        self.mechanism = mechanism
        self.plans: list[PlannedGraph] = []
        self._kept: KeptColumns | None = None
        texts = [plot] if isinstance(plot, str) else list(plot)
        wanted: list[Quantity] = []
        if measures:
            from gimcli.quantities.catalogue import catalogue

            items = (item for text in measures for item in catalogue(mechanism).asked(text))
            wanted += dict.fromkeys(item.quantity for item in items)
        self.record = Record(wanted)
        if any(text.strip() for text in texts):
            wanted += self._planned(texts, measures)
        needs = Needs(mechanism)
        motion = [one for one in wanted if isinstance(one, PointVector | MemberTurning)]
        for one in motion:
            one.values(needs)
        self.order = max(derivatives, needs.order)
        self.names = (*mechanism.traced, *(name for name in needs.points if name not in mechanism.traced))
        self._members = needs.members
        others = {one.spec: one for one in wanted if one not in motion and not isinstance(one, RowValue)}
        self._others = list(others.values())

    def _planned(self, texts: Sequence[str], measures: Sequence[str]) -> list[Quantity]:
        """Read the graphs and return their quantities; raise UsageError for an unknown quantity."""
        from gimcli.library.plots import KeptColumns, only_angle
        from gimcli.library.vocabulary import Vocabulary
        from gimcli.quantities.catalogue import catalogue

        vocabulary, known = Vocabulary(self.mechanism, specs=tuple(measures)), catalogue(self.mechanism)
        for plan in (p for text in texts for p in vocabulary.plans(text, only_angle(self.mechanism))):
            if plan not in self.plans:
                self.plans.append(plan)
        self._kept = KeptColumns(self.plans)
        found = (known.column(name) for plan in self.plans for name in sorted(plan.columns))
        return [item.quantity for item in found if item is not None]

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

    def check(self, head: Table) -> None:
        """Raise UsageError if a graph cannot be drawn, such as one with abscissae of different units."""
        from gimcli.library.plots import drawn

        for plan in self.plans:
            drawn(plan, {column.name: column for column in head.columns}, Column("", head.columns[0].values))

    def keep(self, table: Table, rows: IntArray) -> None:
        """Keep rows of the next table for the graphs."""
        if self._kept is not None:
            self._kept.add(table, rows)

    def graphs(self, motion: Motion, events: Sequence[tuple[str, Mapping[str, float]]]) -> list[CurveGraph]:
        """Return the graphs; `motion` has the rows that are kept."""
        if self._kept is None:
            return []
        from gimcli.library.plots import drawn
        from gimcli.quantities.graphs import abscissa

        columns, across = self._kept.columns, abscissa(motion)
        return [drawn(plan, columns, across, events) for plan in self.plans]

    def curves(self, motion: Motion) -> dict[str, ComplexArray]:
        """Return the curves that the measures add to the drawing."""
        return self.record.curves(motion)

    def outlines(self, motion: Motion) -> list[ComplexArray]:
        """Return the areas that the measures add to the drawing."""
        return self.record.outlines(motion)

    def report(self, motion: Motion) -> dict[str, Any]:
        """Return the results of the measures for the whole motion, for --json."""
        return {"measures": self.record.results(motion)} if self.record.measures else {}
