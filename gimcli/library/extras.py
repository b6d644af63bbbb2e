"""The measures and graphs that are requested of a trace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gimcli.errors import UsageError
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.rates.member_angles import Angles
from gimcli.rates.motion_table import motion_table
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.measures.record import Record


class Extras:
    """The measures and graphs of one trace."""

    def __init__(
        self, mechanism: Mechanism, measures: Sequence[str], plot: str | Sequence[str], derivatives: int
    ) -> None:
        self.mechanism, self.specs, self.order = mechanism, list(measures), derivatives
        words = plot.replace(",", " ").split() if isinstance(plot, str) else plot
        self.plots = list(dict.fromkeys(words))
        self.record: Record | None = None
        if self.plots:
            from gimcli.measures.graphs import ORDERS

            self.order = max(derivatives, *(ORDERS.get(word, 0) for word in self.plots))
        for word in self.plots:
            self._include(word)
        if self.specs:
            from gimcli.measures.record import Record

            self.record = Record(mechanism, self.specs)

    def _include(self, word: str) -> None:
        """Add the measure that a graph needs, unless it is there; raise UsageError for an unknown quantity."""
        from gimcli.measures import KINDS
        from gimcli.measures.graphs import ORDERS
        from gimcli.measures.naming import guess

        if word in ORDERS or any(word in (spec, spec.partition(":")[0]) for spec in self.specs):
            return
        if word.partition(":")[0] not in KINDS:
            raise UsageError(f"plot: no quantity '{word}'; {guess(word, [*ORDERS, *KINDS])}")
        self.specs.append(word)

    def head(self, row: Motion) -> list[Column]:
        """Return the measures' columns for the head of a table, with the rows of `row`."""
        return self.record.head_columns(len(row.time)) if self.record is not None else []

    def columns(self, piece: Motion, angles: Angles) -> list[Column]:
        """Return the measures' columns of the next piece of the motion; `angles` counts full turns."""
        return self.record.columns(piece, angles) if self.record is not None else []

    def curves(self, motion: Motion) -> dict[str, ComplexArray]:
        """Return the curves that the measures add to the drawing."""
        return self.record.curves(motion) if self.record is not None else {}

    def outlines(self, motion: Motion) -> list[ComplexArray]:
        """Return the areas that the measures add to the drawing."""
        return self.record.outlines(motion) if self.record is not None else []

    def panels(self, motion: Motion) -> dict[str, Table]:
        """Return the graphs by name, as tables whose first column is the abscissa."""
        from gimcli.measures.graphs import ORDERS, abscissa, measured, quantity
        from gimcli.measures.record import Record

        if not self.plots:
            return {}
        record = Record(self.mechanism, self.specs)  # measured again: the motion has only the rows of the picture
        more, heads = record.columns(motion), record.heads
        specs = [measure.spec for measure in record.measures for _ in measure.heads]
        table, across, panels = motion_table(motion, order=self.order), abscissa(motion), {}
        for word in self.plots:
            if word in ORDERS:
                panels[word] = Table((across, *quantity(self.mechanism, table, word)))
                continue
            own = [k for k, spec in enumerate(specs) if word in (spec, spec.partition(":")[0])]
            for name, group in measured([heads[k] for k in own], [more[k] for k in own]).items():
                panels[f"{name}, {word}" if name in panels else name] = Table((across, *group))
        return panels

    def report(self, motion: Motion) -> dict[str, Any]:
        """Return the results of the measures for the whole motion, for --json."""
        return {"measures": self.record.results(motion)} if self.record is not None else {}
