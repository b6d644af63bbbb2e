"""Convert a picture to a matplotlib figure, with one artist per style and without automatic layout, to save time."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from gimcli.output.atomic import written_bytes
from gimcli.output.axes import (
    PartNames,
    borders,
    cut,
    dash,
    fill,
    height_below,
    legend_shape,
    mark_style,
    resolution,
    set_up,
    title_height,
    title_lines,
    whole_height,
    write_title,
)
from gimcli.output.gallery import corners, gallery_size
from gimcli.output.picture import Content, Key, Picture, Sheet
from gimcli.output.printed import Printed, settings_of
from gimcli.output.style import Mark

ROUNDING = 1e-9
"""Part that is added to the size: some versions of matplotlib cut 349.9999 pixels to 349."""

NARROWEST = 4.8
"""Least width of a figure [in], unless a size is given."""


OPTIONS: dict[str, dict[str, Any]] = {
    ".png": {"pil_kwargs": {"compress_level": 3}},  # drawings get hardly smaller, but slower, with higher levels
    ".svg": {"metadata": {"Date": None}},
    ".pdf": {"metadata": {"CreationDate": None}},
}
"""What matplotlib is given for each format: the same picture always gives the same bytes."""


def write_picture(picture: Content | Printed, path: Path | str) -> None:
    """Write a picture as a PNG, PDF or SVG file, by its suffix; an SVG file has a group for each part."""
    from matplotlib.backend_bases import FigureCanvasBase

    kind = Path(path).suffix.lower()
    printed = replace(picture if isinstance(picture, Printed) else Printed(picture), grouped=kind == ".svg")
    with written_bytes(path) as handle, drawn(FigureCanvasBase, printed) as canvas:
        edges = {"facecolor": "auto", "edgecolor": "auto", "dpi": canvas.figure.dpi}
        canvas.print_figure(handle, format=kind[1:], **edges, **OPTIONS[kind])


@contextmanager
def drawn(canvas: Any, content: Content | Printed) -> Iterator[Any]:
    """Yield the figure of a content on a matplotlib canvas of the given class (context manager).

    The settings of its look, and silence about glyphs that the font does not have, hold until it is written.
    """
    from matplotlib import rc_context

    printed = content if isinstance(content, Printed) else Printed(content)
    with warnings.catch_warnings(), rc_context(settings_of(printed.look)):
        warnings.simplefilter("ignore")
        figure = figure_of(printed)
        figure.set_dpi(printed.dpi or resolution(figure.get_figwidth()))
        figure.set_size_inches(figure.get_size_inches() * (1.0 + ROUNDING))
        yield canvas(figure)


def figure_of(printed: Printed) -> Any:
    """Return the matplotlib figure of a picture, of several pictures one above the other, or of a gallery."""
    from matplotlib.figure import Figure

    content = printed.content
    names = PartNames() if printed.grouped else None
    font = content.pictures[0].frame.font
    if isinstance(content, Sheet) and content.columns:
        return _gallery(content, Figure(printed.size or gallery_size(content)), names)
    widths = (sum(borders(one.frame.font)) + one.frame.width for one in content.pictures)
    width = printed.size[0] if printed.size else max(NARROWEST, *widths)
    heading = content.title if isinstance(content, Sheet) else ""
    heights = [whole_height(picture, width) for picture in content.pictures]
    bottom = sum(heights)
    figure = Figure((width, bottom + title_height(heading, width, font)))
    _write_heading(figure, heading, font)
    for picture, own in zip(content.pictures, heights, strict=True):
        bottom -= own
        _add_picture(figure, picture, bottom, own, names)
    return figure


def _write_heading(figure: Any, title: str, font: float) -> None:
    width, height = figure.get_size_inches()
    write_title(figure, title_lines(title, width, font), 0.5, 1 - 0.12 / height)


def _gallery(gallery: Sheet, figure: Any, names: PartNames | None) -> Any:
    """Return the figure of a gallery; only the left and the lowest panels have numbers at their axes."""
    width, height = figure.get_size_inches()
    for k, (panel, (left, bottom)) in enumerate(zip(gallery.pictures, corners(gallery, width, height), strict=True)):
        axes = _axes(figure, panel, left, bottom, names)
        axes.set_title(panel.title, pad=3.0, parse_math=False)
        if k % gallery.columns:
            axes.set(ylabel="", yticklabels=[])
        if k + gallery.columns < len(gallery.pictures):
            axes.set(xlabel="", xticklabels=[])
    _write_heading(figure, gallery.title, gallery.pictures[0].frame.font)
    return figure


def _axes(figure: Any, picture: Picture, left: float, bottom: float, names: PartNames | None) -> Any:
    """Return the axes of a picture whose lower left corner is at a place [in] of a figure."""
    (width, height), frame = figure.get_size_inches(), picture.frame
    axes = figure.add_axes((left / width, bottom / height, frame.width / width, frame.height / height))
    set_up(axes, picture)
    fill(axes, picture, names)
    return axes


def _add_picture(figure: Any, picture: Picture, base: float, own: float, names: PartNames | None) -> None:
    """Add a picture whose lower edge is at `base` [in] of a figure, with its title and its legend."""
    (width, height), frame = figure.get_size_inches(), picture.frame
    left, right = borders(frame.font)
    left += (width - left - right - frame.width) / 2
    _axes(figure, picture, left, base + height_below(picture, width), names)
    middle = (left + frame.width / 2) / width
    write_title(figure, title_lines(picture.title, width, frame.font), middle, (base + own - 0.12) / height)
    columns, rows = legend_shape(picture, width)
    if rows:
        _add_legend(figure, picture, columns, (middle, (base + 0.07) / height))


def _add_legend(figure: Any, picture: Picture, columns: int, at: tuple[float, float]) -> None:
    from matplotlib.lines import Line2D

    keys = [Line2D([], [], **_key_style(style)) for _, style in picture.legend]
    legend = figure.legend(
        keys, [""] * len(keys), loc="lower center", bbox_to_anchor=at, ncols=columns, frameon=False,
        borderpad=0.0, borderaxespad=0.0, handlelength=3.2, columnspacing=1.5,
    )  # fmt: skip
    for text, (name, _) in zip(legend.get_texts(), picture.legend, strict=True):
        text.set(parse_math=False, text=cut(name))


def _key_style(style: Key) -> dict[str, Any]:
    if isinstance(style, tuple):
        return {**mark_style(style[1]), **_key_style(style[0])}
    if isinstance(style, Mark):
        return mark_style(style)
    return {"color": style.color, "linewidth": style.width, "linestyle": dash(style)}
