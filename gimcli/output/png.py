"""PNG pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.output.atomic import written_bytes

if TYPE_CHECKING:
    from gimcli.output.picture import Content
    from gimcli.output.printed import Printed


COMPRESSION = 3
"""Level of compression: drawings get hardly smaller, but slower, with higher levels."""


def write_png(picture: Content | Printed, path: Path | str) -> None:
    """Write a picture as a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from gimcli.output.figure import drawn

    with written_bytes(path) as handle, drawn(FigureCanvasAgg, picture) as canvas:
        canvas.print_png(handle, pil_kwargs={"compress_level": COMPRESSION})
