"""Graphs of values over the time or over an input, one above the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gimcli.mechanism import FloatArray
from gimcli.output.panels import panel as graph
from gimcli.output.picture import WIDEST, Picture, Sheet
from gimcli.output.style import DOT
from gimcli.table import Column, Table


@dataclass(frozen=True)
class Panel:
    """Curves with a common vertical axis, and marks of events."""

    label: str
    curves: Sequence[tuple[str, FloatArray, FloatArray]]  # name, abscissa (the same for all), values
    marks: Sequence[complex] = ()  # abscissa + i value


def history_sheet(panels: Sequence[Panel], over: str, title: str) -> Sheet:
    """Return panels with a common abscissa; `over` is its name."""
    return Sheet(title, tuple(_panel(panel, over) for panel in panels))


def _panel(panel: Panel, over: str) -> Picture:
    columns = [Column(name, values) for name, _, values in panel.curves]
    table = Table((Column(over, panel.curves[0][1]), *columns))
    picture = graph(panel.label, table, WIDEST, peaks=True)
    picture.mark(DOT, *panel.marks)
    return picture
