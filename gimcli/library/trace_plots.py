"""The quantities of a motion that --plot may name, and what has to be computed for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gimcli.connected import grouped
from gimcli.errors import UsageError
from gimcli.library.plots import Group, PlottedQuantity, Vocabulary
from gimcli.measures import KINDS, measures_of
from gimcli.measures.graphs import MEMBER_QUANTITIES, POINT_QUANTITIES
from gimcli.measures.measure import Measure
from gimcli.mechanism import FRAME, Mechanism


@dataclass(frozen=True)
class Need:
    """What a column needs."""

    order: int = 0  # of derivatives
    point: str = ""
    member: int = FRAME  # its direction
    spec: str = ""  # measure


class TraceVocabulary(Vocabulary):
    """Columns of a motion, also of nodes that are not traced, and measures, also those that are not requested."""

    def __init__(self, mechanism: Mechanism, specs: Sequence[str]) -> None:
        self.mechanism, self.specs = mechanism, specs
        self.needs = _needs(mechanism)
        self._measures: dict[str, list[Measure]] = {}
        super().__init__(self.needs, _words(mechanism))
        self.columns = self.needs  # columns of measures are added

    def has(self, name: str) -> bool:
        """Return whether a text names a column, a vector (x and y), a word, or a measure or its column."""
        self._find_measure(name)
        return super().has(name)

    def groups(self, name: str) -> list[Group]:
        """Return the groups of a word or of a measure."""
        own = [m for spec in self.specs if name in (spec, spec.partition(":")[0]) for m in self._made(spec)]
        word, _, point = name.partition(":")
        if not own and word in POINT_QUANTITIES and f"{point}.x" in self.columns:
            return [Group(self.words[word].title, (_magnitude(point, word),))]
        if not own and name not in self.words:
            own = self._made(name)
        return _of_measures(own) if own else super().groups(name)

    def unknown(self, name: str, rest: str) -> UsageError:
        """Return the error for an unknown name."""
        if name.partition(":")[0] in KINDS:
            try:
                measures_of(self.mechanism, rest)
            except UsageError as error:
                return error
        return super().unknown(name, rest)

    def _made(self, spec: str) -> list[Measure]:
        """Return the measures of a text; an empty list if it is none."""
        if spec.partition(":")[0] not in KINDS:
            return []
        if spec not in self._measures:
            try:
                self._measures[spec] = measures_of(self.mechanism, spec)
            except UsageError:
                self._measures[spec] = []
            for head in (head for measure in self._measures[spec] for head in measure.heads):
                self.needs.setdefault(head.name, Need(spec=spec))
        return self._measures[spec]

    def _find_measure(self, name: str) -> None:
        """Add the columns of the measure to which a column may belong, such as `curvature:P.radius`."""
        if name.partition(":")[0] in KINDS and name not in self.needs:
            parts = name.split(".")
            for k in range(len(parts), 0, -1):
                if self._made(".".join(parts[:k])):
                    return


def _needs(mechanism: Mechanism) -> dict[str, Need]:
    """Return the numeric columns of a motion."""
    needs = dict.fromkeys(["step", "time", *(a.name for a in mechanism.actuators)], Need())
    for name in dict.fromkeys([*mechanism.traced, *(p.name for p in mechanism.points), *mechanism.nodes]):
        for order, letter in enumerate(("", "v", "a", "j")):
            needs |= dict.fromkeys([f"{name}.{letter}x", f"{name}.{letter}y"], Need(order, name))
    for number, member in enumerate(mechanism.members):
        if number != FRAME:
            needs[f"{member.name}.angle"] = Need(member=number)
            needs |= {f"{member.name}.{w}": Need(k) for k, w in enumerate(("omega", "alpha", "jerk"), 1)}
    return needs | dict.fromkeys(["residual", "sweeps"], Need())


def _words(mechanism: Mechanism) -> dict[str, Group]:
    titles = {word: f"{word} |{letter}|" for word, (letter, _) in POINT_QUANTITIES.items()}
    points = {w: Group(t, tuple(_magnitude(name, w) for name in mechanism.traced)) for w, t in titles.items()}
    members = [m.name for m in mechanism.members[FRAME + 1 :]]
    turning = {w: Group(w, tuple(PlottedQuantity(n, (f"{n}.{w}",)) for n in members)) for w in MEMBER_QUANTITIES}
    return points | turning


def _magnitude(point: str, word: str) -> PlottedQuantity:
    letter, _ = POINT_QUANTITIES[word]
    return PlottedQuantity(point, (f"{point}.{letter}x", f"{point}.{letter}y"), True)


def _of_measures(measures: Sequence[Measure]) -> list[Group]:
    """Return the graphs of measures; columns with the same graph and unit are together."""
    heads = (head for measure in measures for head in measure.heads if head.graph)
    groups = grouped(((h.graph, h.unit), PlottedQuantity(h.name.partition(":")[2], (h.name,))) for h in heads)
    return [Group(title, tuple(quantities)) for (title, _), quantities in groups.items()]
