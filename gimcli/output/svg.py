"""SVG pictures."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.output.atomic import written_text

if TYPE_CHECKING:
    from gimcli.output.picture import Content


def write_svg(picture: Content, path: Path | str) -> None:
    """Write a picture as an SVG file; the same picture always gives the same bytes."""
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    from gimcli.output.figure import canvas_of, quiet

    text = io.StringIO()
    with quiet(), matplotlib.rc_context({"svg.hashsalt": "gim"}):
        canvas_of(FigureCanvasSVG, picture).print_svg(text, metadata={"Date": None})
    with written_text(path) as handle:
        handle.write(text.getvalue())
