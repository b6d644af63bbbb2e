"""Graphs one above the other."""

from __future__ import annotations

from collections.abc import Sequence

from gimcli.output.graph import CurveGraph
from gimcli.output.panels import panel
from gimcli.output.picture import WIDEST, Sheet


def history_sheet(graphs: Sequence[CurveGraph], title: str) -> Sheet:
    """Return the pictures of graphs one above the other, under a title."""
    return Sheet(title, tuple(panel(graph, WIDEST) for graph in graphs))
