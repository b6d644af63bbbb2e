"""PNG pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.output.atomic import written_bytes

if TYPE_CHECKING:
    from gimcli.output.picture import Content


def write_png(picture: Content, path: Path | str) -> None:
    """Write a picture as a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from gimcli.output.figure import canvas_of, quiet

    with written_bytes(path) as handle, quiet():
        canvas_of(FigureCanvasAgg, picture).print_png(handle)
