"""Films of an animation: pictures with one window, shown one after another. Files .gif and .mp4."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from shutil import which
from subprocess import CalledProcessError
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np

from gimcli.errors import OutputError, reason
from gimcli.mechanism import ComplexArray, FloatArray, IntArray
from gimcli.output import style
from gimcli.output.animation import Animation, Clip
from gimcli.output.atomic import written_bytes
from gimcli.output.axes import fill
from gimcli.output.curves import pieces
from gimcli.output.figure import drawn
from gimcli.output.picture import LAYOUT, Picture, PictureLayout, Text, composition
from gimcli.output.pose import Drawing
from gimcli.output.printed import PictureOptions, dressed
from gimcli.output.scene import Scene
from gimcli.output.style import Pen, curve_pen

SHORTEST, LONGEST = 4.0, 10.0
"""Shortest and longest film of one motion [s]; other durations of the motion are shown slower or faster."""

STILL = 1.0
"""Time for which a single position is shown [s]."""

AHEAD = Pen(0.8, style.SOFT, layer=1)
"""The part of a curve that is not reached yet."""


GIF_RATE, GIF_DPI = 20, 90
MP4_RATE, MP4_DPI = 25, 120
"""Frames per second, and resolution [dots per inch]."""


def write_gif(animation: Animation, path: Path | str) -> None:
    """Write an animation as a GIF file that repeats."""
    from matplotlib.animation import PillowWriter

    write_film(animation, path, PillowWriter(fps=GIF_RATE), GIF_RATE, GIF_DPI)


def require_ffmpeg(path: Path) -> None:
    """Raise OutputError if the program that encodes the film is not installed."""
    if which("ffmpeg") is None:
        raise OutputError(f"{path}: .mp4 needs the program ffmpeg, which is not on the PATH: install it, or write .gif")


def write_mp4(animation: Animation, path: Path | str) -> None:
    """Write an animation as an MP4 file (H.264), encoded by ffmpeg."""
    from matplotlib.animation import FFMpegWriter

    require_ffmpeg(Path(path))
    writer = FFMpegWriter(fps=MP4_RATE, codec="h264", extra_args=["-pix_fmt", "yuv420p"])
    try:
        write_film(animation, path, writer, MP4_RATE, MP4_DPI)
    except CalledProcessError as fault:
        last = str(fault.stderr or fault).strip().splitlines()[-1:]
        raise OutputError(f"{path}: ffmpeg cannot encode the film: {' '.join(last)}; write .gif") from fault


def write_film(animation: Animation, path: Path | str, writer: Any, rate: int, dpi: int) -> None:
    """Write a film with one of matplotlib's writers, `rate` frames per second; the file appears when it is whole."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    path = Path(path)
    frames = Frames(animation)
    with TemporaryDirectory() as folder, drawn(FigureCanvasAgg, frames.background) as canvas:
        part, figure = Path(folder) / f"film{path.suffix.lower()}", canvas.figure
        figure.set_dpi(frames.background.dpi or dpi)
        figure.savefig = lambda target, **given: target.write(canvas.buffer_rgba())  # the writers save each frame so
        try:
            with writer.saving(figure, part, figure.dpi):  # may change the size of the figure
                canvas.draw()
                still, shown = canvas.copy_from_bbox(figure.bbox), None
                for clip, row in frame_rows(animation, rate):
                    if shown != (clip.name, row):
                        canvas.restore_region(still)
                        _draw(figure.axes[0], frames.picture(clip, row))
                        shown = (clip.name, row)
                    writer.grab_frame()
        except OSError as fault:
            raise OutputError(f"{path}: cannot be written: {reason(fault)}; choose another path") from fault
        with written_bytes(path) as handle:
            handle.write(part.read_bytes())


def _draw(axes: Any, picture: Picture) -> None:
    """Draw the artists of a picture over what the canvas shows, and remove them from the axes."""
    before = set(axes.get_children())
    fill(axes, picture)
    added = [artist for artist in axes.get_children() if artist not in before]
    for artist in sorted(added, key=lambda artist: artist.get_zorder()):
        axes.draw_artist(artist)
        artist.remove()


def frame_rows(animation: Animation, rate: int) -> Iterator[tuple[Clip, int]]:
    """Yield the clip and the row of each frame, in real time or scaled to SHORTEST or LONGEST; open motions go back."""
    for clip in animation.clips:
        rows = _rows(clip.time, rate)
        for row in rows if clip.closed or clip.forward or len(clip.time) < 2 else np.append(rows, rows[::-1]):
            yield clip, int(row)


def _rows(time: FloatArray, rate: int) -> IntArray:
    if len(time) < 2:
        return np.zeros(round(STILL * rate), dtype=np.int64)
    passed = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(time)))))
    if not np.isfinite(passed[-1]) or passed[-1] <= 0.0:
        passed = np.linspace(0.0, SHORTEST, len(time))
    length = min(max(float(passed[-1]), SHORTEST), LONGEST)
    at = np.linspace(0.0, passed[-1], max(2, round(length * rate)))
    return np.round(np.interp(at, passed, np.arange(len(time)))).astype(np.int64)


@composition
def film_background(
    scene: Scene, title: str, shown: Sequence[ComplexArray], names: Sequence[str], *, layout: PictureLayout = LAYOUT
) -> Picture:
    """Return what stands still in a film: the axes around all places, markers of the frame, and the names of curves."""
    drawing = Drawing.around(scene.mechanism, scene, title, shown, layout)
    drawing.crosses(scene)
    if len(names) > 1:
        drawing.picture.legend += [(name, curve_pen(index)) for index, name in enumerate(names)]
    return drawing.picture


class Frames:
    """The pictures of an animation, all with the same window."""

    def __init__(self, animation: Animation) -> None:
        self.animation, self.scene, self.options = animation, animation.scene, animation.options or PictureOptions()
        traced = self.scene.traced
        self.paths = {
            clip.name: {name: self.scene.place(at, clip.positions) for name, at in traced.items()}
            for clip in animation.clips
        }
        shown = [
            *(z for paths in self.paths.values() for z in paths.values()),
            *(np.ravel(clip.positions[:, sorted(self.scene.used)]) for clip in animation.clips),
        ]
        background = film_background(self.scene, animation.title, shown, list(traced))
        self.background = self.options.printed(background)

    def picture(self, clip: Clip, row: int) -> Picture:
        """Return the moving part of one frame: mechanism and curves up to a row, or the reason why it is not solved."""
        picture = Picture("", cast(Picture, self.background.content).frame)
        for index, path in enumerate(self.paths[clip.name].values()):
            picture.draw(AHEAD, *(run for run in pieces(path, clip.breaks) if len(run) > 1))
            picture.draw(curve_pen(index), *(run for run in pieces(path[: row + 1], clip.breaks) if len(run) > 1))
        words = [clip.name] if len(self.animation.clips) > 1 else []
        if clip.good[row]:
            Drawing(picture, self.scene).strong(self.scene, clip.positions[row], {})
        else:
            words.append(clip.status[row])
        if words:
            frame = picture.frame
            middle, top = (frame.low.real + frame.high.real) / 2, frame.high.imag - 10.0 * frame.point
            picture.texts.append(Text(complex(middle, top), ": ".join(words)))
        return cast(Picture, dressed(picture, self.background.look))
