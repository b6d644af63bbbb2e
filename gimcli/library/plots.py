"""Graphs of columns, as --plot names them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.library.plot_text import HODOGRAPH, POLAR as POLAR_WORD, CurveText, GraphText, Operand, graphs_of
from gimcli.measures.naming import guess
from gimcli.mechanism import FloatArray, IntArray, Mechanism
from gimcli.output.graph import EQUAL, ORDINARY, POLAR, Axis, Curve, CurveGraph
from gimcli.table import Column, Table

LONGEST = 40
"""Largest number of letters of the name of an axis that lists its curves."""

LISTED = 12
"""Number of columns that the message for an unknown name lists."""


@dataclass(frozen=True)
class PlottedQuantity:
    """A column, its magnitude, or the magnitude of a vector with two columns."""

    label: str
    columns: tuple[str, ...]  # one, or x and y
    magnitude: bool = False

    def values(self, columns: Mapping[str, Column]) -> FloatArray:
        """Return the values (rows,)."""
        parts = [np.asarray(columns[name].values, dtype=np.float64) for name in self.columns]
        if len(parts) == 2:
            return np.asarray(np.hypot(*parts))
        return np.abs(parts[0]) if self.magnitude else parts[0]

    def unit(self, columns: Mapping[str, Column]) -> str:
        """Return the unit."""
        return columns[self.columns[0]].unit


@dataclass(frozen=True)
class Group:
    """Quantities with a common name, such as the angular velocities of all members."""

    title: str
    quantities: Sequence[PlottedQuantity]


@dataclass(frozen=True)
class PlannedCurve:
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
        return {name for c in self.curves for q in (c.y, c.x) if q is not None for name in q.columns}


class Vocabulary:
    """The columns of a command, and the words for groups of them."""

    def __init__(self, columns: Iterable[str], words: Mapping[str, Group]) -> None:
        self.columns: Collection[str] = dict.fromkeys(columns)
        self.words = words

    def has(self, name: str) -> bool:
        """Return whether a text names a column, a vector (x and y) or a word."""
        return name in self.columns or bool(self.components(name)) or bool(self.groups(name))

    def unknown(self, name: str, rest: str) -> UsageError:
        """Return the error for an unknown name, with a similar one."""
        near = guess(name, [*self.words, *self.columns])
        if near.startswith("known:"):
            shown = [*self.words, *list(self.columns)[:LISTED]]
            near = f"known: {', '.join(shown)}{', ...' * (len(self.columns) > LISTED)}"
        return UsageError(f"plot: no quantity or column '{name}'; {near}")

    def groups(self, name: str) -> list[Group]:
        """Return the groups of a word, or the one quantity of WORD:NAME."""
        if name in self.words:
            return [self.words[name]]
        word, colon, label = name.partition(":")
        own = [q for q in self.words[word].quantities if q.label == label] if colon and word in self.words else []
        return [Group(self.words[word].title, own)] if own else []

    def components(self, name: str, *tails: str) -> tuple[str, str] | None:
        """Return the columns x and y of a vector such as `P.v`, of a point, or of a reaction; `tails` come first."""
        for tail in (*tails, "", ".", ".f"):
            if f"{name}{tail}x" in self.columns and f"{name}{tail}y" in self.columns:
                return f"{name}{tail}x", f"{name}{tail}y"
        return None

    def plans(self, text: str, angle: str = "") -> list[PlannedGraph]:
        """Return the graphs of a text; `angle` is the default angle of polar diagrams."""
        return [plan for one in graphs_of(text, self) for plan in self._plans(one, angle)]

    def _plans(self, graph: GraphText, angle: str) -> list[PlannedGraph]:
        if graph.form == HODOGRAPH:
            return [PlannedGraph(EQUAL, "", tuple(map(self._hodograph, graph.curves)))]
        if graph.form == POLAR_WORD:
            return [self._polar(graph, angle)]
        if len(graph.curves) == 1 and not graph.curves[0].y.magnitude and graph.curves[0].y.name not in self.columns:
            over = self._abscissa(graph.curves[0])
            groups = self.groups(graph.curves[0].y.name)
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
            raise UsageError(f"plot: '{curve.x.name}' has several columns; name one as the abscissa")
        return found[0]

    def _quantities(self, operand: Operand) -> list[PlottedQuantity]:
        """Return the quantities of a name: a column, the components of a vector, or the members of a group."""
        name, columns = operand.name, self.components(operand.name)
        if operand.magnitude:
            pair = (name,) if name in self.columns else columns
            if pair is None:
                raise UsageError(f"plot: '|{name}|': '{name}' is neither a column nor a vector (columns x and y)")
            return [PlottedQuantity(f"|{name}|", pair, True)]
        if name in self.columns:
            return [PlottedQuantity(name, (name,))]
        if columns is not None:
            return [PlottedQuantity(column, (column,)) for column in columns]
        return [q for group in self.groups(name) for q in group.quantities]

    def _hodograph(self, curve: CurveText) -> PlannedCurve:
        """Return the curve of the tip of a vector; that of a point is its velocity, or its reaction."""
        columns = self.components(curve.y.name, ".v", ".f")
        if columns is None or curve.x is not None or curve.y.magnitude:
            raise UsageError(
                f"plot 'hodograph:{curve.y.name}': expected a point, or a vector with the columns x and y, such as P.v"
            )
        x, y = (PlottedQuantity(column, (column,)) for column in columns)
        return PlannedCurve(y, x)

    def _polar(self, graph: GraphText, angle: str) -> PlannedGraph:
        curves = []
        for one in graph.curves:
            over = self._abscissa(one) or (PlottedQuantity(angle, (angle,)) if angle else None)
            if over is None:
                raise UsageError("plot: a polar diagram needs an angle: write polar:COLUMN/ANGLE")
            name = one.y.name
            alone = name in self.columns or self.components(name) is not None
            for q in self._quantities(Operand(name, True) if alone else one.y):
                curves.append(
                    PlannedCurve(PlottedQuantity(q.label if alone else f"|{q.label}|", q.columns, True), over)
                )
        return PlannedGraph(POLAR, "", tuple(curves))


def _is_path(curve: PlannedCurve) -> bool:
    """Return whether a curve is one component of a vector over the other."""
    x, y = curve.x, curve.y
    if x is None or x.magnitude or y.magnitude or len(x.columns) + len(y.columns) != 2:
        return False
    ends = x.columns[0][-1:] + y.columns[0][-1:]
    return x.columns[0][:-1] == y.columns[0][:-1] and ends in ("xy", "yx")


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
        over = abscissa if curve.x is None else Column(curve.x.label, curve.x.values(columns), curve.x.unit(columns))
        overs.append(over)
        units.append(curve.y.unit(columns))
        curves.append(Curve(_label(plan, curve), over.values, curve.y.values(columns)))
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
