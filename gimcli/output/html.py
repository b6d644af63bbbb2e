"""Animated pages."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.output.atomic import written_text

if TYPE_CHECKING:
    from gimcli.output.animation import Animation


def write_html(animation: Animation, path: Path | str) -> None:
    """Write an animation as one HTML file that loads nothing else."""
    from gimcli.output.page import page

    with written_text(path) as handle:
        handle.write(page(animation))
