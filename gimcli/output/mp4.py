"""MP4 films, encoded by ffmpeg."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gimcli.errors import OutputError

if TYPE_CHECKING:
    from gimcli.output.animation import Animation

RATE, DPI = 25, 120
"""Frames per second, and resolution [dots per inch]."""


def require_ffmpeg(path: Path) -> None:
    """Raise OutputError if the program that encodes the film is not installed."""
    from shutil import which

    if which("ffmpeg") is None:
        raise OutputError(f"{path}: .mp4 needs the program ffmpeg, which is not on the PATH: install it, or write .gif")


def write_mp4(animation: Animation, path: Path | str) -> None:
    """Write an animation as an MP4 file (H.264)."""
    from subprocess import CalledProcessError

    from matplotlib.animation import FFMpegWriter

    from gimcli.output.film import write_film

    require_ffmpeg(Path(path))
    try:
        write_film(animation, path, FFMpegWriter(fps=RATE, codec="h264", extra_args=["-pix_fmt", "yuv420p"]), RATE, DPI)
    except CalledProcessError as fault:
        last = str(fault.stderr or fault).strip().splitlines()[-1:]
        raise OutputError(f"{path}: ffmpeg cannot encode the film: {' '.join(last)}; write .gif") from fault
