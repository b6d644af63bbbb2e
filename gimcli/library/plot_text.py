"""The text of --plot: graphs of columns.

    GRAPHS  = GRAPH, GRAPH ...          one below the other
    GRAPH   = CURVE + CURVE ...         on one axis, or  hodograph:CURVE ..., polar:CURVE ...
    CURVE   = QUANTITY, or QUANTITY / QUANTITY: the first over the second, in place of the input or the time
    QUANTITY = NAME, or |NAME|: the magnitude

Names of a model may contain all these signs. The longest text that is a known name is read as a name.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Protocol

from gimcli.errors import UsageError

HODOGRAPH, POLAR = "hodograph", "polar"

SIGNS = ",+/| \t\n"
"""Signs that end a name, unless the name is known with them."""


@dataclass(frozen=True)
class Operand:
    """A name, or the magnitude of what it names."""

    name: str
    magnitude: bool = False


@dataclass(frozen=True)
class CurveText:
    """A quantity, over another one or over the default abscissa."""

    y: Operand
    x: Operand | None = None


@dataclass(frozen=True)
class GraphText:
    """A graph as it is written."""

    form: str  # "", "hodograph" or "polar"
    curves: tuple[CurveText, ...]


class Names(Protocol):
    """The names that may be plotted."""

    def has(self, name: str) -> bool:
        """Return whether a text is a name."""

    def unknown(self, name: str, rest: str) -> UsageError:
        """Return the error for a name that is not known; `rest` is the text from it to the end of the curve."""


def graphs_of(text: str, names: Names) -> list[GraphText]:
    """Return the graphs of a text; raise UsageError where it is not of the form above."""
    return _PlotReader(text, names).graphs()


class _PlotReader:
    """Reads the text from left to right."""

    def __init__(self, text: str, names: Names) -> None:
        self.text, self.names, self.at = text, names, 0

    def graphs(self) -> list[GraphText]:
        if not self.text.strip(" \t\n,"):
            raise UsageError(f"plot: expected a column or a quantity, got '{self.text}'")
        found = []
        while self._skip(" \t\n,"):
            found.append(self._graph())
        return found

    def _graph(self) -> GraphText:
        form = next((word for word in (HODOGRAPH, POLAR) if self._takes(f"{word}:")), "")
        curves = [self._curve()]
        while self._skip(" \t\n") and self._takes("+"):
            curves.append(self._curve())
        return GraphText(form, _over_common(curves))

    def _curve(self) -> CurveText:
        y = self._operand()
        over = self._skip(" \t\n") and self._takes("/")
        return CurveText(y, self._operand() if over else None)

    def _operand(self) -> Operand:
        self._skip(" \t\n")
        name = self._known(len(self.text))
        if name is None and self._takes("|"):
            return self._magnitude()
        if name is None:
            word = re.split(f"[{re.escape(SIGNS)}]", self.text[self.at :])[0]
            if not word:
                got = f"'{self.text[self.at]}'" if self.at < len(self.text) else "nothing"
                raise UsageError(f"plot '{self.text}': expected a name, got {got}")
            raise self.names.unknown(word, re.split(r"[,+\s]", self.text[self.at :])[0])
        self.at += len(name)
        return Operand(name)

    def _magnitude(self) -> Operand:
        """Return the operand after an opening bar."""
        closing = [k for k in range(len(self.text), self.at, -1) if self.text[k - 1] == "|"]
        for end in closing:
            name = self.text[self.at : end - 1].strip()
            if self.names.has(name):
                self.at = end
                return Operand(name, True)
        if not closing:
            raise UsageError(f"plot '{self.text}': expected a closing | after '{self.text[self.at :]}'")
        word = self.text[self.at : closing[-1] - 1]
        raise self.names.unknown(word, word)

    def _known(self, most: int) -> str | None:
        """Return the longest known name that begins here; None if there is none."""
        ends = [k for k in range(most, self.at, -1) if k == most or self.text[k] in SIGNS]
        return next((self.text[self.at : k] for k in ends if self.names.has(self.text[self.at : k])), None)

    def _skip(self, signs: str) -> bool:
        """Skip signs; return whether there is more text."""
        while self.at < len(self.text) and self.text[self.at] in signs:
            self.at += 1
        return self.at < len(self.text)

    def _takes(self, word: str) -> bool:
        """Skip a word that begins here, unless a known name does; return whether it was skipped."""
        if not self.text.startswith(word, self.at) or self._known(len(self.text)) is not None:
            return False
        self.at += len(word)
        return True


def _over_common(curves: list[CurveText]) -> tuple[CurveText, ...]:
    """Return the curves of one graph: an abscissa also holds for the curves before it that have none."""
    found: list[CurveText] = []
    for curve in reversed(curves):
        over = curve.x or (found[-1].x if found else None)
        if found and over is not None and found[-1].x is None:
            raise UsageError(f"plot: '{found[-1].y.name}' has no abscissa, but a curve before it has: add /COLUMN")
        found.append(CurveText(curve.y, over))
    return tuple(reversed(found))
