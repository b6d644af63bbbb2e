"""The quantities of a motion that --plot may name."""

from __future__ import annotations

from collections.abc import Sequence

from gimcli.connected import grouped
from gimcli.errors import UsageError
from gimcli.library.plots import Group, PlottedQuantity, Vocabulary, amount, plotted
from gimcli.mechanism import Mechanism
from gimcli.quantities.catalogue import catalogue
from gimcli.quantities.graphs import MEMBER_QUANTITIES, POINT_QUANTITIES
from gimcli.quantities.kinds import KINDS, quantities_of
from gimcli.quantities.quantity import Item


class TraceVocabulary(Vocabulary):
    """Columns of a motion, also of nodes that are not traced, and measures, also those that are not requested."""

    def __init__(self, mechanism: Mechanism, specs: Sequence[str]) -> None:
        self.specs, self.catalogue = specs, catalogue(mechanism)
        super().__init__(dict.fromkeys([*self.catalogue.columns, "sweeps"], ""), {}, mechanism)
        for word in POINT_QUANTITIES:
            own = tuple(self._magnitude(name, word) for name in mechanism.traced)
            self.words[word] = Group(f"{word} |{POINT_QUANTITIES[word]}|", own)
        for word in MEMBER_QUANTITIES:
            columns = {name: f"{name}.{word}" for name in self.catalogue.members}
            self.words[word] = Group(
                word, tuple(plotted(column, self.unit(column) or "", name) for name, column in columns.items())
            )

    def unit(self, name: str) -> str | None:
        """Return the unit of a column; None if there is no such column."""
        item = self.catalogue.column(name)
        return self.columns.get(name) if item is None else item.head.unit

    def groups(self, name: str) -> list[Group]:
        """Return the groups of a word or of a measure."""
        own = [i for spec in self.specs if name in (spec, spec.partition(":")[0]) for i in self.catalogue.find(spec)]
        word, _, point = name.partition(":")
        if not own and word in POINT_QUANTITIES and point in self.catalogue.points:
            return [Group(self.words[word].title, (self._magnitude(point, word),))]
        if not own and word in KINDS and name not in self.words:
            own = list(self.catalogue.find(name))
        return _of_measures(own) if own else super().groups(name)

    def unknown(self, name: str, rest: str) -> UsageError:
        """Return the error for an unknown name."""
        if name.partition(":")[0] in KINDS:
            try:
                quantities_of(self.mechanism, rest)
            except UsageError as error:
                return error
        return super().unknown(name, rest)

    def _magnitude(self, point: str, word: str) -> PlottedQuantity:
        columns = [f"{point}.{POINT_QUANTITIES[word]}{axis}" for axis in "xy"]
        return amount(point, columns, self.unit(columns[0]) or "")


def _of_measures(items: Sequence[Item]) -> list[Group]:
    """Return the graphs of measures; columns with the same graph and unit are together."""
    heads = (item.head for item in items if item.head.graph)
    groups = grouped(((h.graph, h.unit), plotted(h.name, h.unit, h.name.partition(":")[2])) for h in heads)
    return [Group(title, tuple(quantities)) for (title, _), quantities in groups.items()]
