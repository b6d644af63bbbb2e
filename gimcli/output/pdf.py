"""PDF pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.output.atomic import written_bytes

if TYPE_CHECKING:
    from gimcli.output.picture import Content
    from gimcli.output.printed import Printed


def write_pdf(picture: Content | Printed, path: Path | str) -> None:
    """Write a picture as a PDF file with one page; the same picture always gives the same bytes."""
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    from gimcli.output.figure import drawn

    with written_bytes(path) as handle, drawn(FigureCanvasPdf, picture) as canvas:
        canvas.print_pdf(handle, metadata={"CreationDate": None})
