"""What is drawn in a picture by style: lines, areas and places of marks."""

from __future__ import annotations

from typing import Any

from gimcli.output.style import Fill, Mark, Pen


def _of(kind: type, picture: Any) -> dict[Any, list[Any]]:
    return {style: things for style, things in picture.drawn.items() if isinstance(style, kind)}


def strokes(picture: Any) -> dict[Pen, list[Any]]:
    """Return the open polylines by style."""
    return _of(Pen, picture)


def areas(picture: Any) -> dict[Fill, list[Any]]:
    """Return the closed polygons by style."""
    return _of(Fill, picture)


def marks(picture: Any) -> dict[Mark, list[Any]]:
    """Return the places of marks by style."""
    return _of(Mark, picture)
