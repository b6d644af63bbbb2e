"""SVG pictures."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.output.atomic import written_text

if TYPE_CHECKING:
    from gimcli.output.picture import Content
    from gimcli.output.printed import Printed


def write_svg(picture: Content | Printed, path: Path | str) -> None:
    """Write a picture as an SVG file; the same picture always gives the same bytes."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    from gimcli.output.figure import drawn

    text = io.StringIO()
    with drawn(FigureCanvasSVG, picture) as canvas:
        canvas.print_svg(text, metadata={"Date": None})
    with written_text(path) as handle:
        handle.write(text.getvalue())
