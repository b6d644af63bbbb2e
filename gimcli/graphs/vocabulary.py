"""The quantities that --plot may name, words for groups of them, and the graphs of a text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from gimcli.connected import grouped
from gimcli.errors import UsageError
from gimcli.graphs.plots import (
    HODOGRAPH,
    POLAR_WORD,
    Group,
    PlannedCurve,
    PlannedGraph,
    PlottedQuantity,
    amount,
    graphs_of,
    plotted,
)
from gimcli.language.expression import Expression, PartKind
from gimcli.language.reader import KnownNames
from gimcli.mechanism import Mechanism
from gimcli.nearest import guess
from gimcli.output.graph import EQUAL, ORDINARY, POLAR
from gimcli.quantities.catalogue import LISTED, catalogue
from gimcli.quantities.forces import no_forces
from gimcli.quantities.kinds import KINDS
from gimcli.quantities.motion_table import MEMBER_QUANTITIES, POINT_QUANTITIES
from gimcli.quantities.quantity import Item

TEXTS = ("status", "friction.state")
"""Columns without numbers."""

ENDS, BEGINS, REACTIONS = ("effort", "speed", "acceleration"), ("power", "energy"), "reactions"
"""Words for the columns that end, or begin, with them; the word for the magnitudes of all reactions."""


class Vocabulary(KnownNames):
    """The columns of a command and the quantities of its motion, and the words for groups of them."""

    def __init__(
        self, mechanism: Mechanism, columns: Mapping[str, str] | None = None, specs: Sequence[str] = ()
    ) -> None:
        """Take the units of the columns by name, if there are other ones than quantities, and texts of measures."""
        self.mechanism, self.specs = mechanism, specs
        self.columns = {name: unit for name, unit in (columns or {"sweeps": ""}).items() if name not in TEXTS}
        self.catalogue = catalogue(mechanism)

    @property
    def words(self) -> dict[str, Group]:
        """The words for groups that have a quantity."""
        known = dict.fromkeys([*ENDS, *BEGINS, REACTIONS, *POINT_QUANTITIES, *MEMBER_QUANTITIES])
        found = {word: self._word(word) for word in known}
        return {word: group for word, group in found.items() if group.quantities}

    def _word(self, word: str) -> Group:
        """Return the group of a word: columns of the command, else of the motion; without quantities if unknown."""
        names = {**self.columns, **self._forces} if word in (*ENDS, *BEGINS, REACTIONS) else {}
        if word in MEMBER_QUANTITIES:
            names = {own: self.unit(own) or "" for own in (f"{name}.{word}" for name in self.catalogue.members)}
        if word == REACTIONS:
            pins = [name[:-3] for name in names if name.endswith(".fx") and "@" not in name and name != "shaking.fx"]
            normal = [name for name in names if name.endswith(".normal")]
            found = [*(amount(pin, (f"{pin}.fx", f"{pin}.fy"), names[f"{pin}.fx"]) for pin in pins),
                     *(amount(name[: -len(".normal")], (name,), names[name]) for name in normal)]  # fmt: skip
            return Group("reaction", tuple(found))
        start, end = (f"{word}.", "") if word in BEGINS else ("", f".{word}")
        own = [name for name in names if name.startswith(start) and name.endswith(end)]
        if own or word not in POINT_QUANTITIES:
            labels = ((name, name[len(start) : len(name) - len(end)]) for name in own)
            return Group(word, tuple(plotted(name, names[name], label) for name, label in labels))
        every = tuple(self._magnitude(name, word) for name in self.mechanism.traced)
        return Group(f"{word} |{POINT_QUANTITIES[word]}|", every)

    @property
    def _forces(self) -> dict[str, str]:
        """The units of the forces of a motion without columns of its own, by name."""
        if len(self.columns) > 1:
            return {}
        return {head.name: head.unit for one in self.catalogue.forces for head in one.heads}

    def unit(self, name: str) -> str | None:
        """Return the unit of a column; None if there is no such column."""
        item = None if name in self.columns else self.catalogue.column(name)
        return self.columns.get(name) if item is None else item.head.unit

    def kind(self, name: str) -> PartKind:
        """Return what a name stands for: a column, a vector (x and y), or a word for a group."""
        parts = self.parts(name)
        if parts:
            return PartKind("rows", self.unit(parts[0]), len(parts))
        count = sum(len(group.quantities) for group in self.groups(name))
        own = self._named(name)
        return PartKind("rows" if count else "", "", count + 2) if own is None else own.kind

    def code(self, name: str) -> Sequence[Any]:
        """Return the code of a name: the name itself, or the expression that it is short for."""
        own = self._named(name)
        return (name,) if own is None else own.code

    def _named(self, name: str) -> Expression | None:
        """Return the expression of a name that is no column, such as stroke:P or one of the file; None for others."""
        own = None if self.parts(name) or self.groups(name) else self.catalogue.named(name)
        return (
            own if own is not None and (len(own.code) == 1 or all(len(self.parts(n)) == 1 for n in own.names)) else None
        )

    def unknown(self, name: str, rest: str) -> UsageError:
        """Return the error for an unknown name, with a similar one."""
        if name.partition(":")[0] in KINDS:
            return self.catalogue.unknown(rest, rest)
        words, columns = list(self.words), [*self.columns, *self.catalogue.columns]
        near = no_forces(self.mechanism, name) or guess(name, [*words, *columns], most=len(words) + LISTED)
        return UsageError(f"plot: no quantity or column '{name}'; {near}")

    def across(self) -> tuple[str, str]:
        """Return name and unit of the only independent input, or of the time."""
        return self.catalogue.across()

    def refuse_value(self, actuator: str, value: float) -> None:
        """Raise UsageError: a graph has all rows."""
        raise UsageError(
            f"plot: at({actuator}={value:g}) is one row, a graph has all of them; `gim sweep --keep` has it"
        )

    def groups(self, name: str) -> list[Group]:
        """Return the groups of a word or of a measure, or the one quantity of WORD:NAME."""
        word, colon, label = name.partition(":")
        specs = [spec for spec in self.specs if name in (spec, spec.partition(":")[0])]
        items = [item for spec in specs for item in self.catalogue.find(spec)]
        if not items and word in KINDS and not self._word(name).quantities:
            items = list(self.catalogue.find(name))
        if items:
            return _of_measures(items)
        if word in POINT_QUANTITIES and label in self.catalogue.points:
            return [Group(self._word(word).title, (self._magnitude(label, word),))]
        group = self._word(word)
        own = [q for q in group.quantities if q.label == label or not colon]
        return [Group(group.title, own)] if own else []

    def parts(self, name: str, *tails: str) -> tuple[str, ...]:
        """Return a column, or the columns x and y of a vector such as `P.v`, a point, or a reaction; `tails` first."""
        if not tails and self.unit(name) is not None:
            return (name,)
        pairs = [(f"{name}{tail}x", f"{name}{tail}y") for tail in (*tails, "", ".", ".f")]
        own = [pair for pair in pairs if self.columns.keys() >= set(pair)]  # of the command, before those of the motion
        own += [pair for pair in pairs if None not in map(self.unit, pair)]
        alone = [q.column for group in self.groups(name) for q in group.quantities] if not own else []
        return own[0] if own else tuple(alone) if len(alone) == 1 else ()

    def plans(self, text: str) -> list[PlannedGraph]:
        """Return the graphs of a text; the default angle of polar diagrams is the only rotary input."""
        return [plan for one in graphs_of(text, self) for plan in self._plans(one)]

    def _plans(self, graph: PlannedGraph) -> list[PlannedGraph]:
        if graph.form == HODOGRAPH:
            return [PlannedGraph(EQUAL, "", tuple(map(self._hodograph, graph.curves)))]
        if graph.form == POLAR_WORD:
            return [self._polar(graph)]
        first, name = graph.curves[0], graph.curves[0].y.column
        if len(graph.curves) == 1 and name and self.unit(name) is None and (groups := self.groups(name)):
            every = ((g.title, tuple(PlannedCurve(q, self._abscissa(first)) for q in g.quantities)) for g in groups)
            return [PlannedGraph(ORDINARY, title, curves) for title, curves in every]
        curves = tuple(PlannedCurve(q, self._abscissa(c)) for c in graph.curves for q in self._quantities(c.y))
        return [PlannedGraph(EQUAL if all(map(_is_path, curves)) else ORDINARY, "", curves)]

    def _abscissa(self, curve: PlannedCurve) -> PlottedQuantity | None:
        if curve.x is None:
            return None
        found = self._quantities(curve.x)
        if len(found) != 1:
            raise UsageError(f"plot: '{curve.x.text}' has several columns; name one as the abscissa")
        return found[0]

    def _quantities(self, given: PlottedQuantity) -> list[PlottedQuantity]:
        """Return the quantities of a text: a column, the components of a vector, the members of a group, or one."""
        if given.column:
            own = [plotted(column, self.unit(column) or "") for column in self.parts(given.column)]
            return own or [q for group in self.groups(given.column) for q in group.quantities]
        code = list[Any]()
        for item in given.code:
            if isinstance(item, str):
                code += self.parts(item)
            else:
                code.append(("hypot", 2) if item == ("hypot of columns", 1) else item)
        if given.kind.columns > 1:
            raise UsageError(f"plot: '{given.text}' has several columns; name one of them")
        return [replace(given, code=tuple(code))]

    def _hodograph(self, curve: PlannedCurve) -> PlannedCurve:
        """Return the curve of the tip of a vector; that of a point is its velocity, or its reaction."""
        columns = self.parts(curve.y.column, ".v", ".f") if curve.y.column else ()
        if not columns or curve.x is not None:
            raise UsageError(
                f"plot 'hodograph:{curve.y.text}': expected a point, or a vector with the columns x and y, such as P.v"
            )
        x, y = (plotted(column, self.unit(column) or "") for column in columns)
        return PlannedCurve(y, x)

    def _polar(self, graph: PlannedGraph) -> PlannedGraph:
        curves, rotary = [], [actuator.name for actuator in self.mechanism.actuators if actuator.rotary]
        angle = rotary[0] if len(rotary) == 1 else ""
        for one in graph.curves:
            over = self._abscissa(one) or (plotted(angle, self.unit(angle) or "") if angle else None)
            if over is None:
                raise UsageError("plot: a polar diagram needs an angle: write polar:COLUMN/ANGLE")
            parts = self.parts(one.y.column) if one.y.column else ()
            if parts:
                curves.append(PlannedCurve(amount(f"|{one.y.text}|", parts, self.unit(parts[0]) or ""), over))
            else:
                curves += [PlannedCurve(q.magnitude(), over) for q in self._quantities(one.y)]
        return PlannedGraph(POLAR, "", tuple(curves))

    def _magnitude(self, point: str, word: str) -> PlottedQuantity:
        columns = [f"{point}.{POINT_QUANTITIES[word]}{axis}" for axis in "xy"]
        return amount(point, columns, self.unit(columns[0]) or "")


def _of_measures(items: Sequence[Item]) -> list[Group]:
    """Return the graphs of measures; columns with the same graph and unit are together."""
    heads = (item.head for item in items if item.head.graph)
    groups = grouped(((h.graph, h.unit), plotted(h.name, h.unit, h.name.partition(":")[2])) for h in heads)
    return [Group(title, tuple(quantities)) for (title, _), quantities in groups.items()]


def _is_path(curve: PlannedCurve) -> bool:
    """Return whether a curve is one component of a vector over the other."""
    if curve.x is None or not curve.x.column or not curve.y.column:
        return False
    x, y = curve.x.column, curve.y.column
    return x[:-1] == y[:-1] and x[-1:] + y[-1:] in ("xy", "yx")
