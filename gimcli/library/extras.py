"""The measures and graphs that are requested of a trace."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gimcli.mechanism import ComplexArray, IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.rates.member_angles import Angles
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.library.plots import KeptColumns, PlannedGraph
    from gimcli.output.graph import CurveGraph
    from gimcli.quantities.record import Record


class Extras:
    """The measures and graphs of one trace, and the columns that they need."""

    def __init__(
        self, mechanism: Mechanism, measures: Sequence[str], plot: str | Sequence[str], derivatives: int
    ) -> None:
        self.mechanism, self.specs, self.order = mechanism, list(measures), derivatives
        self.points: list[str] = []  # that are not traced
        self.members: list[int] = []  # whose directions are needed
        self.plans: list[PlannedGraph] = []
        self.record: Record | None = None
        self._kept: KeptColumns | None = None
        texts = [plot] if isinstance(plot, str) else list(plot)
        if any(text.strip() for text in texts):
            self._plan(texts)
        if self.specs:
            from gimcli.quantities.record import Record

            self.record = Record(mechanism, self.specs)

    def _plan(self, texts: Sequence[str]) -> None:
        """Read the graphs, and add what they need; raise UsageError for an unknown quantity."""
        from gimcli.library.plots import KeptColumns, only_angle
        from gimcli.library.trace_plots import TraceVocabulary
        from gimcli.quantities.coordinates import MemberTurning, PointVector, RowValue
        from gimcli.quantities.state import Needs

        vocabulary = TraceVocabulary(self.mechanism, tuple(self.specs))
        for plan in (p for text in texts for p in vocabulary.plans(text, only_angle(self.mechanism))):
            if plan not in self.plans:
                self.plans.append(plan)
        needs = Needs(self.mechanism)
        found = (vocabulary.catalogue.column(name) for plan in self.plans for name in sorted(plan.columns))
        for item in (item for item in found if item is not None):
            if isinstance(item.quantity, PointVector | MemberTurning | RowValue):  # columns of every motion
                item.quantity.values(needs)
            else:
                self.specs += [item.quantity.spec] * (item.quantity.spec not in self.specs)
        self.order = max(self.order, needs.order)
        self.points += [name for name in needs.points if name not in self.mechanism.traced]
        self.members += needs.members
        self._kept = KeptColumns(self.plans)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the points that have columns."""
        return (*self.mechanism.traced, *self.points)

    def head(self, row: Motion) -> list[Column]:
        """Return the measures' columns for the head of a table, with the rows of `row`."""
        return self.record.head_columns(len(row.time)) if self.record is not None else []

    def columns(self, piece: Motion, angles: Angles) -> list[Column]:
        """Return the measures' columns of the next piece of the motion; `angles` counts full turns."""
        return self.record.columns(piece, angles) if self.record is not None else []

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
        return self.record.curves(motion) if self.record is not None else {}

    def outlines(self, motion: Motion) -> list[ComplexArray]:
        """Return the areas that the measures add to the drawing."""
        return self.record.outlines(motion) if self.record is not None else []

    def report(self, motion: Motion) -> dict[str, Any]:
        """Return the results of the measures for the whole motion, for --json."""
        return {"measures": self.record.results(motion)} if self.record is not None else {}
