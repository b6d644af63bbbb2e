"""Graphs of columns, as --plot names them, and the reader of their texts.

The usual graphs of forces are those that show more than a constant; hodographs have values of the input along them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gimcli.errors import UsageError
from gimcli.language.arrays import ARRAYS
from gimcli.language.expression import Expression, ExpressionError, PartKind
from gimcli.language.reader import ExpressionReader, KnownNames
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.output.graph import EQUAL, ORDINARY, POLAR, Axis, Curve, CurveGraph, PlaceMark
from gimcli.rounding import round_above
from gimcli.table import Column

LONGEST = 40
"""Largest number of letters of the name of an axis that lists its curves."""


@dataclass(frozen=True)
class PlottedQuantity(Expression):
    """A column, or an expression of columns, with a name in the legend."""

    label: str = ""

    @property
    def column(self) -> str:
        """The name of the column; "" for an expression."""
        return self.code[0] if len(self.code) == 1 and isinstance(self.code[0], str) else ""

    def unit_in(self, columns: Mapping[str, Column]) -> str:
        """Return the unit; "" if it has none or it is not known."""
        return columns[self.column].unit if self.column else self.kind.unit or ""

    def values(self, columns: Mapping[str, Column], rows: int) -> FloatArray:
        """Return the values (rows,)."""
        values = {name: np.asarray(columns[name].values, dtype=np.float64)[None] for name in self.names}
        with np.errstate(all="ignore"):
            found = self.value(values, ARRAYS)
        return np.asarray(np.broadcast_to(found, (1, rows))[0])

    def magnitude(self) -> PlottedQuantity:
        """Return the amount of the quantity."""
        return replace(self, label=f"|{self.label}|", code=(*self.code, ("abs", 1)))


def plotted(name: str, unit: str, label: str = "") -> PlottedQuantity:
    """Return a column as a quantity."""
    return PlottedQuantity(name, (name,), PartKind("rows", unit), label or name)


def amount(label: str, columns: Sequence[str], unit: str) -> PlottedQuantity:
    """Return the amount of a vector with the columns x and y, or of one column."""
    code = (*columns, ("hypot", 2) if len(columns) == 2 else ("abs", 1))
    text = f"|{columns[0][:-1] if len(columns) == 2 else columns[0]}|"
    return PlottedQuantity(text, code, PartKind("rows", unit), label)


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
        return {name for c in self.curves for q in c if q is not None for name in q.names}


def drawn(
    plan: PlannedGraph, columns: Mapping[str, Column], abscissa: Column,
    events: Sequence[tuple[str, Mapping[str, float]]] = (),
) -> CurveGraph:  # fmt: skip
    """Return the graph of a plan, from columns that have the rows of the default abscissa.

    `events` are words, such as "limit", with the values there of columns that may be an abscissa.
    """
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
        named = ", ".join(dict.fromkeys(f"{over.name} [{over.unit or '-'}]" for over in overs))
        raise UsageError(f"plot: the curves of one graph need abscissae with one unit, got {named}")
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


def _radians(column: Column) -> FloatArray:
    """Return the values of a column of angles in rad."""
    if column.unit not in ("deg", "rad"):
        raise UsageError(f"plot: a polar diagram needs an angle, '{column.name}' is none")
    return np.radians(column.values) if column.unit == "deg" else np.asarray(column.values)


HODOGRAPH, POLAR_WORD = "hodograph", "polar"


def graphs_of(text: str, names: KnownNames) -> list[PlannedGraph]:
    """Return the graphs of a text as it is written: their form is "", "hodograph" or "polar", their title "".

    A quantity may be a name that stands for several ones. Raises UsageError where the text cannot be read.
    """
    if not text.strip(" \t\n,"):
        raise UsageError(f"plot: expected a column or a quantity, got '{text}'")
    try:
        return _PlotReader(text, names).graphs()
    except ExpressionError as error:
        raise UsageError(f"plot '{text}': {error}") from None


class _PlotReader(ExpressionReader):
    """Reads the text from left to right."""

    def graphs(self) -> list[PlannedGraph]:
        found = []
        while self.rest():
            if not self.takes(","):
                found.append(self._graph())
        return found

    def _graph(self) -> PlannedGraph:
        known = self.names.longest(self.rest())
        form = "" if known else next((word for word in (HODOGRAPH, POLAR_WORD) if self.takes(f"{word}:")), "")
        curves = [self._curve()]
        while self.takes("+"):
            curves.append(self._curve())
        return PlannedGraph(form, "", _over_common(curves))

    def _curve(self) -> PlannedCurve:
        return PlannedCurve(self._quantity(), self._quantity() if self.takes("/") else None)

    def _quantity(self) -> PlottedQuantity:
        own = self.operand()
        return PlottedQuantity(own.text, own.code, own.kind, own.text)


def _over_common(curves: Sequence[PlannedCurve]) -> Sequence[PlannedCurve]:
    """Return the curves of one graph: an abscissa also holds for the curves before it that have none."""
    found: list[PlannedCurve] = []
    for curve in reversed(curves):
        over = curve.x or (found[-1].x if found else None)
        if found and over is not None and found[-1].x is None:
            raise UsageError(f"plot: '{found[-1].y.text}' has no abscissa, but a curve before it has: add /COLUMN")
        found.append(PlannedCurve(curve.y, over))
    return tuple(reversed(found))


CONSTANT = 1e-9
"""Range of a constant quantity, relative to its largest value."""


def usual_graphs(mechanism: Mechanism) -> list[PlannedGraph]:
    """Return the graphs without --plot: driving efforts over the input."""
    plans = []
    for rotary, title in ((True, "driving torque"), (False, "driving force")):
        own = [a.name for k, a in enumerate(mechanism.actuators) if a.rotary is rotary and k not in mechanism.geared]
        unit = "N m" if rotary else "N"
        curves = tuple(PlannedCurve(plotted(f"{name}.effort", unit, name)) for name in own)
        plans += [PlannedGraph(ORDINARY, title, curves)] if own else []
    return plans


def varying(plans: Sequence[PlannedGraph], columns: Mapping[str, Column]) -> tuple[list[PlannedGraph], list[str]]:
    """Return the graphs that show more than a constant, and the values of the constant ones as texts."""
    constant = {plan: [_constant(columns[name]) for name in sorted(plan.columns)] for plan in plans}
    kept = [plan for plan, texts in constant.items() if not all(texts)]
    found = [text for texts in constant.values() if all(texts) for text in texts]
    return (kept, found) if kept else (list(plans[:1]), [])


def _constant(column: Column) -> str:
    """Return a constant column as text; "" if it varies."""
    values = column.values[np.isfinite(column.values)]
    if not len(values):
        return f"no {column.name}"
    same = float(np.ptp(values)) <= CONSTANT * float(np.max(np.abs(values)))
    return f"{column.name} = {values[0]:.4g} {column.unit}" if same else ""


DEGREES = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0)
"""Distances of the marks of angles in degrees."""

MOST = 12
"""Most marks of a curve."""

TOGETHER = 0.06
"""Distance of two marks, relative to the extent of the curve, below which the second one is left out."""


def with_marks(graph: CurveGraph, over: Column) -> CurveGraph:
    """Return a graph with equal axes with the values of the input, or of the time, along its curves."""
    if graph.form != EQUAL or len(over.values) < 2:
        return graph
    return replace(graph, marks=[mark for curve in graph.curves for mark in _marks(curve, over)])


def _marks(curve: Curve, over: Column) -> list[PlaceMark]:
    at = _round_values(over)
    order = np.argsort(over.values)
    knots, table = over.values[order], (np.asarray(curve.x)[order], np.asarray(curve.y)[order])
    x, y = (np.interp(at, knots, values) for values in table)
    across = 1j * sum(unit * np.interp(at, knots, np.gradient(own)) for unit, own in zip((1, 1j), table, strict=True))
    extent = max(float(np.ptp(v[np.isfinite(v)])) if np.isfinite(v).any() else 0.0 for v in (curve.x, curve.y))
    found: list[PlaceMark] = []
    for value, place, normal in zip(at.tolist(), (x + 1j * y).tolist(), np.asarray(across).tolist(), strict=True):
        apart = all(abs(place - other.place) > TOGETHER * extent for other in found)
        if math.isfinite(abs(place)) and apart:
            found.append(PlaceMark(place, _text(value, over.unit), normal if math.isfinite(abs(normal)) else 0.0j))
    return found


def _round_values(over: Column) -> FloatArray:
    low, high = float(over.values.min()), float(over.values.max())
    step = _step(high - low, over.unit == "deg")
    return step * np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1.0)


def _step(span: float, degrees: bool) -> float:
    """Return the least round distance with at most MOST distances in a span."""
    least = span / MOST * (1.0 - 1e-9)
    if degrees and DEGREES[0] <= least <= DEGREES[-1]:
        return next(step for step in DEGREES if step >= least)
    return round_above(least)


def _text(value: float, unit: str) -> str:
    return f"{value:g}°" if unit == "deg" else f"{value:.4g}"
