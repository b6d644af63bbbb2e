"""The text of --plot: graphs of quantities.

    GRAPHS  = GRAPH, GRAPH ...          one below the other
    GRAPH   = CURVE + CURVE ...         on one axis, or  hodograph:CURVE ..., polar:CURVE ...
    CURVE   = QUANTITY, or QUANTITY / QUANTITY: the first over the second, in place of the input or the time
    QUANTITY = NAME, |NAME| (the magnitude), FUNCTION(...) or (EXPRESSION)

Names of a model may contain all these signs. The longest text that is a known name is read as a name.
"""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.errors import UsageError
from gimcli.language.expression import Expression, ExpressionError
from gimcli.language.reader import ExpressionReader, KnownNames

HODOGRAPH, POLAR = "hodograph", "polar"


@dataclass(frozen=True)
class CurveText:
    """A quantity, over another one or over the default abscissa."""

    y: Expression
    x: Expression | None = None


@dataclass(frozen=True)
class GraphText:
    """A graph as it is written."""

    form: str  # "", "hodograph" or "polar"
    curves: tuple[CurveText, ...]


def graphs_of(text: str, names: KnownNames) -> list[GraphText]:
    """Return the graphs of a text; raise UsageError where it is not of the form above."""
    if not text.strip(" \t\n,"):
        raise UsageError(f"plot: expected a column or a quantity, got '{text}'")
    try:
        return _PlotReader(text, names).graphs()
    except ExpressionError as error:
        raise UsageError(f"plot '{text}': {error}") from None


class _PlotReader(ExpressionReader):
    """Reads the text from left to right."""

    def graphs(self) -> list[GraphText]:
        found = []
        while self.rest():
            if not self.takes(","):
                found.append(self._graph())
        return found

    def _graph(self) -> GraphText:
        known = self.names.longest(self.rest())
        form = "" if known else next((word for word in (HODOGRAPH, POLAR) if self.takes(f"{word}:")), "")
        curves = [self._curve()]
        while self.takes("+"):
            curves.append(self._curve())
        return GraphText(form, _over_common(curves))

    def _curve(self) -> CurveText:
        y = self.operand()
        return CurveText(y, self.operand() if self.takes("/") else None)


def _over_common(curves: list[CurveText]) -> tuple[CurveText, ...]:
    """Return the curves of one graph: an abscissa also holds for the curves before it that have none."""
    found: list[CurveText] = []
    for curve in reversed(curves):
        over = curve.x or (found[-1].x if found else None)
        if found and over is not None and found[-1].x is None:
            raise UsageError(f"plot: '{found[-1].y.text}' has no abscissa, but a curve before it has: add /COLUMN")
        found.append(CurveText(curve.y, over))
    return tuple(reversed(found))
