"""SVG pictures."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.output.atomic import written_text

if TYPE_CHECKING:
    from gimcli.output.picture import Content
    from gimcli.output.printed import Printed


def write_svg(picture: Content | Printed, path: Path | str) -> None:
    """Write a picture as an SVG file with a group for each part; the same picture always gives the same bytes."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    from gimcli.output.figure import drawn
    from gimcli.output.printed import Printed

    printed = picture if isinstance(picture, Printed) else Printed(picture)
    text = io.StringIO()
    with drawn(FigureCanvasSVG, replace(printed, grouped=True)) as canvas:
        canvas.print_svg(text, metadata={"Date": None})
    with written_text(path) as handle:
        handle.write(text.getvalue())
