"""Graphs of columns, as --plot names them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gimcli.errors import UsageError
from gimcli.language.arrays import ARRAYS
from gimcli.language.expression import Expression, PartKind
from gimcli.language.reader import longest
from gimcli.library.plot_text import HODOGRAPH, POLAR as POLAR_WORD, CurveText, GraphText, graphs_of
from gimcli.mechanism import FloatArray, IntArray, Mechanism
from gimcli.output.graph import EQUAL, ORDINARY, POLAR, Axis, Curve, CurveGraph
from gimcli.quantities.naming import guess
from gimcli.table import Column, Table

LONGEST = 40
"""Largest number of letters of the name of an axis that lists its curves."""

LISTED = 12
"""Number of columns that the message for an unknown name lists."""


class PlottedQuantity(NamedTuple):
    """A column, or an expression of columns."""

    label: str
    expression: Expression

    @property
    def column(self) -> str:
        """The name of the column; "" for an expression."""
        return _name(self.expression)

    @property
    def columns(self) -> frozenset[str]:
        """Names of the columns in it."""
        return self.expression.names

    def unit_in(self, columns: Mapping[str, Column]) -> str:
        """Return the unit; "" if it has none or it is not known."""
        return columns[self.column].unit if self.column else self.expression.kind.unit or ""

    def values(self, columns: Mapping[str, Column], rows: int) -> FloatArray:
        """Return the values (rows,)."""
        values = {name: np.asarray(columns[name].values, dtype=np.float64)[None] for name in self.columns}
        with np.errstate(all="ignore"):
            found = self.expression.value(values, ARRAYS)
        return np.asarray(np.broadcast_to(found, (1, rows))[0])

    def magnitude(self, label: str = "") -> PlottedQuantity:
        """Return the amount of the quantity."""
        own = self.expression
        return PlottedQuantity(label or f"|{self.label}|", Expression(own.text, (*own.code, ("abs", 1)), own.kind))


def plotted(name: str, unit: str, label: str = "") -> PlottedQuantity:
    """Return a column as a quantity."""
    return PlottedQuantity(label or name, Expression(name, (name,), PartKind("rows", unit)))


def amount(label: str, columns: Sequence[str], unit: str) -> PlottedQuantity:
    """Return the amount of a vector with the columns x and y, or of one column."""
    code = (*columns, ("hypot", 2) if len(columns) == 2 else ("abs", 1))
    return PlottedQuantity(label, Expression(label, code, PartKind("rows", unit)))


class Group(NamedTuple):
    """Quantities with a common name, such as the angular velocities of all members."""

    title: str
    quantities: Sequence[PlottedQuantity]


class PlannedCurve(NamedTuple):
    """A quantity over another one, or over the default abscissa."""

    y: PlottedQuantity
    x: PlottedQuantity | None = None


@dataclass(frozen=True)
class PlannedGraph:
    """A graph before its columns are computed."""

    form: str
    title: str  # name of the vertical axis; "" for the names of its curves
    curves: Sequence[PlannedCurve]

    @property
    def columns(self) -> set[str]:
        """Names of the columns that the graph needs."""
        return {name for c in self.curves for q in c if q is not None for name in q.columns}


class Vocabulary:
    """The columns of a command, and the words for groups of them."""

    def __init__(self, columns: Mapping[str, str], words: dict[str, Group], mechanism: Mechanism) -> None:
        """Take the units of the columns by name."""
        self.columns, self.words, self.mechanism = columns, words, mechanism

    def unit(self, name: str) -> str | None:
        """Return the unit of a column; None if there is no such column."""
        return self.columns.get(name)

    def longest(self, text: str) -> str:
        """Return the longest name with which a text begins; "" if it begins with none."""
        return longest(text, lambda name: self.kind(name).what)

    def kind(self, name: str) -> PartKind:
        """Return what a name stands for: a column, a vector (x and y), or a word for a group."""
        parts = self.parts(name)
        if parts:
            return PartKind("rows", self.unit(parts[0]), len(parts))
        count = sum(len(group.quantities) for group in self.groups(name))
        return PartKind("rows" if count else "", "", count + 2)

    def code(self, name: str) -> Sequence[Any]:
        """Return the name itself."""
        return (name,)

    def unknown(self, name: str, rest: str) -> UsageError:
        """Return the error for an unknown name, with a similar one."""
        near = guess(name, [*self.words, *self.columns])
        if near.startswith("known:"):
            shown = [*self.words, *list(self.columns)[:LISTED]]
            near = f"known: {', '.join(shown)}{', ...' * (len(self.columns) > LISTED)}"
        return UsageError(f"plot: no quantity or column '{name}'; {near}")

    def across(self) -> tuple[str, str]:
        """Return name and unit of the only independent input, or of the time."""
        own = self.mechanism
        name = own.actuators[own.drivers[0]].name if len(own.drivers) == 1 else "time"
        return name, self.unit(name) or ""

    def refuse_value(self, actuator: str, value: float) -> None:
        """Raise UsageError: a graph has all rows."""
        raise UsageError(f"plot: at({actuator}={value:g}) is one row; a graph has all of them")

    def groups(self, name: str) -> list[Group]:
        """Return the groups of a word, or the one quantity of WORD:NAME."""
        if name in self.words:
            return [self.words[name]]
        word, colon, label = name.partition(":")
        own = [q for q in self.words[word].quantities if q.label == label] if colon and word in self.words else []
        return [Group(self.words[word].title, own)] if own else []

    def parts(self, name: str, *tails: str) -> tuple[str, ...]:
        """Return a column, or the columns x and y of a vector such as `P.v`, a point, or a reaction; `tails` first."""
        if not tails and self.unit(name) is not None:
            return (name,)
        pairs = ((f"{name}{tail}x", f"{name}{tail}y") for tail in (*tails, "", ".", ".f"))
        alone = [q.column for group in self.groups(name) for q in group.quantities]
        return next(
            (pair for pair in pairs if None not in map(self.unit, pair)), tuple(alone) if len(alone) == 1 else ()
        )

    def plans(self, text: str, angle: str = "") -> list[PlannedGraph]:
        """Return the graphs of a text; `angle` is the default angle of polar diagrams."""
        return [plan for one in graphs_of(text, self) for plan in self._plans(one, angle)]

    def _plans(self, graph: GraphText, angle: str) -> list[PlannedGraph]:
        if graph.form == HODOGRAPH:
            return [PlannedGraph(EQUAL, "", tuple(map(self._hodograph, graph.curves)))]
        if graph.form == POLAR_WORD:
            return [self._polar(graph, angle)]
        first, name = graph.curves[0], _name(graph.curves[0].y)
        if len(graph.curves) == 1 and name and self.unit(name) is None:
            over = self._abscissa(first)
            groups = self.groups(name)
            if groups:
                return [
                    PlannedGraph(ORDINARY, g.title, tuple(PlannedCurve(q, over) for q in g.quantities)) for g in groups
                ]
        curves = tuple(PlannedCurve(q, self._abscissa(c)) for c in graph.curves for q in self._quantities(c.y))
        return [PlannedGraph(EQUAL if all(map(_is_path, curves)) else ORDINARY, "", curves)]

    def _abscissa(self, curve: CurveText) -> PlottedQuantity | None:
        if curve.x is None:
            return None
        found = self._quantities(curve.x)
        if len(found) != 1:
            raise UsageError(f"plot: '{curve.x.text}' has several columns; name one as the abscissa")
        return found[0]

    def _quantities(self, given: Expression) -> list[PlottedQuantity]:
        """Return the quantities of a text: a column, the components of a vector, the members of a group, or one."""
        name = _name(given)
        if name:
            parts = self.parts(name)
            own = [plotted(column, self.unit(column) or "") for column in parts]
            return own or [q for group in self.groups(name) for q in group.quantities]
        code: list[Any] = []
        for item in given.code:
            if isinstance(item, str):
                code += self.parts(item)
            else:
                code.append(("hypot", 2) if item == ("hypot of columns", 1) else item)
        if given.kind.columns > 1:
            raise UsageError(f"plot: '{given.text}' has several columns; name one of them")
        return [PlottedQuantity(given.text, Expression(given.text, tuple(code), given.kind))]

    def _hodograph(self, curve: CurveText) -> PlannedCurve:
        """Return the curve of the tip of a vector; that of a point is its velocity, or its reaction."""
        name = _name(curve.y)
        columns = self.parts(name, ".v", ".f") if name else ()
        if not columns or curve.x is not None:
            raise UsageError(
                f"plot 'hodograph:{curve.y.text}': expected a point, or a vector with the columns x and y, such as P.v"
            )
        x, y = (plotted(column, self.unit(column) or "") for column in columns)
        return PlannedCurve(y, x)

    def _polar(self, graph: GraphText, angle: str) -> PlannedGraph:
        curves = []
        for one in graph.curves:
            over = self._abscissa(one) or (plotted(angle, self.unit(angle) or "") if angle else None)
            if over is None:
                raise UsageError("plot: a polar diagram needs an angle: write polar:COLUMN/ANGLE")
            parts = self.parts(_name(one.y)) if _name(one.y) else ()
            if parts:
                curves.append(PlannedCurve(amount(f"|{one.y.text}|", parts, self.unit(parts[0]) or ""), over))
            else:
                curves += [PlannedCurve(q.magnitude(), over) for q in self._quantities(one.y)]
        return PlannedGraph(POLAR, "", tuple(curves))


def _name(given: Expression) -> str:
    """Return the name that is the whole expression; "" for others."""
    return given.code[0] if len(given.code) == 1 and isinstance(given.code[0], str) else ""


def _is_path(curve: PlannedCurve) -> bool:
    """Return whether a curve is one component of a vector over the other."""
    if curve.x is None or not curve.x.column or not curve.y.column:
        return False
    x, y = curve.x.column, curve.y.column
    return x[:-1] == y[:-1] and x[-1:] + y[-1:] in ("xy", "yx")


def only_angle(mechanism: Mechanism) -> str:
    """Return the default angle of polar diagrams: the only rotary input; "" if there is none."""
    rotary = [a.name for a in mechanism.actuators if a.rotary]
    return rotary[0] if len(rotary) == 1 else ""


def drawn(
    plan: PlannedGraph, columns: Mapping[str, Column], abscissa: Column,
    events: Sequence[tuple[str, Mapping[str, float]]] = (),
) -> CurveGraph:  # fmt: skip
    """Return the graph of a plan, from columns that have the rows of the default abscissa.

    `events` are words, such as "limit", with the values there of columns that may be an abscissa.
    """
    across = abscissa
    curves, units, overs = [], [], []
    for curve in plan.curves:
        rows, x = len(abscissa.values), curve.x
        over = abscissa if x is None else Column(x.label, x.values(columns, rows), x.unit_in(columns))
        overs.append(over)
        units.append(curve.y.unit_in(columns))
        curves.append(Curve(_label(plan, curve), over.values, curve.y.values(columns, rows)))
    across = overs[0]
    if plan.title:
        curves, units, overs = _without_zeros(curves, units, overs)
    if len({over.unit for over in overs}) > 1:
        raise UsageError(f"plot: the curves of one graph need abscissae with one unit, got {_listed(overs)}")
    names = list(dict.fromkeys(over.name for over in overs))
    unit = units[0] if len(set(units)) == 1 else ""
    if len(set(units)) > 1:
        curves = [Curve(f"{c.name} [{u}]" if u else c.name, c.x, c.y) for c, u in zip(curves, units, strict=True)]
    if plan.form == POLAR:
        curves = [Curve(c.name, _radians(over), c.y) for c, over in zip(curves, overs, strict=True)]
    return CurveGraph(
        Axis(_joined(names), across.unit), Axis(plan.title or _title(plan), unit), curves, plan.form,
        [(at[names[0]], word) for word, at in events if len(names) == 1 and names[0] in at],
        origin=plan.form == EQUAL and not all(name.endswith(".x") for name in names),
    )  # fmt: skip


def _without_zeros(curves: list[Curve], units: list[str], overs: list[Column]) -> Any:
    """Return the curves of a word that are not zero everywhere; all if all are."""
    kept = [k for k, curve in enumerate(curves) if np.any(np.nan_to_num(curve.y))] or range(len(curves))
    return [[every[k] for k in kept] for every in (curves, units, overs)]


def _label(plan: PlannedGraph, curve: PlannedCurve) -> str:
    """Return the name of a curve in the legend."""
    if plan.form == EQUAL and curve.x is not None and len(plan.curves) > 1:
        return curve.y.label[:-1].rstrip(".")  # the vector
    return curve.y.label


def _title(plan: PlannedGraph) -> str:
    """Return the name of the vertical axis: the names of the curves, or what they have in common."""
    names = list(dict.fromkeys(curve.y.label for curve in plan.curves))
    joined = ", ".join(names)
    if len(joined) <= LONGEST:
        return joined
    tails = {name.rpartition(".")[2] for name in names}
    return tails.pop() if len(tails) == 1 else _joined(names)


def _joined(names: Sequence[str]) -> str:
    """Return names as one text that is not too long."""
    text = ", ".join(names)
    return text if len(text) <= LONGEST else f"{names[0]}, ..."


def _listed(columns: Sequence[Column]) -> str:
    return ", ".join(dict.fromkeys(f"{c.name} [{c.unit or '-'}]" for c in columns))


def _radians(column: Column) -> FloatArray:
    """Return the values of a column of angles in rad."""
    if column.unit not in ("deg", "rad"):
        raise UsageError(f"plot: a polar diagram needs an angle, '{column.name}' is none")
    return np.radians(column.values) if column.unit == "deg" else np.asarray(column.values)


class KeptColumns:
    """The columns of some plans, with the rows that are drawn, from a table in pieces."""

    def __init__(self, plans: Sequence[PlannedGraph]) -> None:
        self._names = {name for plan in plans for name in plan.columns}
        self._parts: list[list[Column]] = []

    def add(self, table: Table, rows: IntArray | slice) -> None:
        """Add rows of the next piece."""
        self._parts.append([Column(c.name, c.values[rows], c.unit) for c in table.columns if c.name in self._names])

    @property
    def columns(self) -> dict[str, Column]:
        """The columns by name."""
        each = zip(*self._parts, strict=True)
        return {c[0].name: Column(c[0].name, np.concatenate([p.values for p in c]), c[0].unit) for c in each}
