"""PDF pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.output.atomic import written_bytes

if TYPE_CHECKING:
    from gimcli.output.picture import Content


def write_pdf(picture: Content, path: Path | str) -> None:
    """Write a picture as a PDF file with one page; the same picture always gives the same bytes."""
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    from gimcli.output.figure import canvas_of, quiet

    with written_bytes(path) as handle, quiet():
        canvas_of(FigureCanvasPdf, picture).print_pdf(handle, metadata={"CreationDate": None})
