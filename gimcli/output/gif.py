"""Animated GIF pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gimcli.output.animation import Animation

RATE, DPI = 20, 90
"""Frames per second, and resolution [dots per inch]."""


def write_gif(animation: Animation, path: Path | str) -> None:
    """Write an animation as a GIF file that repeats."""
    from matplotlib.animation import PillowWriter

    from gimcli.output.film import write_film

    write_film(animation, path, PillowWriter(fps=RATE), RATE, DPI)
