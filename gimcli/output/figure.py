"""Convert a picture to a matplotlib figure, with one artist per style and without automatic layout, to save time."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from gimcli.output.axes import dash, fill, mark_style, set_up, title_lines, write_title
from gimcli.output.gallery import gallery_figure
from gimcli.output.picture import Content, Gallery, Key, Picture, Sheet
from gimcli.output.style import BOTTOM, DPI, FONT, LEFT, LETTER, LINE, PAPER, RIGHT, TOP, Mark

NARROWEST = 4.8
"""Least width of a figure [in]."""

LONGEST = 48
"""Largest number of letters of a name in the legend; longer names are cut."""


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress matplotlib's warnings about glyphs that the font does not have (context manager)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def canvas_of(canvas: Any, content: Content) -> Any:
    """Return the figure of a content on a matplotlib canvas of the given class."""
    if isinstance(content, Gallery):
        return canvas(gallery_figure(content))
    return canvas(figure_of(content))


def figure_of(content: Picture | Sheet) -> Any:
    """Return the matplotlib figure of a picture, or of several pictures one above the other."""
    from matplotlib.figure import Figure

    pictures = content.pictures if isinstance(content, Sheet) else (content,)
    width = max([NARROWEST, *(LEFT + picture.frame.width + RIGHT for picture in pictures)])
    heading = title_lines(content.title, width) if isinstance(content, Sheet) else []
    heights = [_height(picture, width) for picture in pictures]
    height = sum(heights) + len(heading) * LINE
    figure = Figure((width, height), dpi=DPI, facecolor=PAPER)
    write_title(figure, heading, 0.5, 1 - 0.12 / height)
    bottom = sum(heights)
    for picture, own in zip(pictures, heights, strict=True):
        bottom -= own
        _add_picture(figure, picture, bottom, own, (width, height))
    return figure


def _height(picture: Picture, width: float) -> float:
    """Return the height [in] of a picture with its title and legend."""
    _, rows = _legend_shape(picture, width)
    bottom, top = BOTTOM + rows * LINE + (0.04 if rows else 0.0), TOP + len(title_lines(picture.title, width)) * LINE
    return bottom + picture.frame.height + top


def _add_picture(figure: Any, picture: Picture, base: float, own: float, size: tuple[float, float]) -> None:
    """Add a picture whose lower edge is at `base` [in] of a figure."""
    width, height = size
    frame, title = picture.frame, title_lines(picture.title, width)
    columns, rows = _legend_shape(picture, width)
    bottom = base + BOTTOM + rows * LINE + (0.04 if rows else 0.0)
    left = LEFT + (width - LEFT - RIGHT - frame.width) / 2
    axes = figure.add_axes((left / width, bottom / height, frame.width / width, frame.height / height))
    set_up(axes, picture)
    fill(axes, picture)
    axes.yaxis.get_offset_text().set_fontsize(FONT)
    middle = (left + frame.width / 2) / width
    write_title(figure, title, middle, (base + own - 0.12) / height)
    if rows:
        _add_legend(figure, picture, columns, (middle, (base + 0.07) / height))


def _cut(name: str) -> str:
    return name if len(name) <= LONGEST else name[: LONGEST - 1] + "…"


def _legend_shape(picture: Picture, width: float) -> tuple[int, int]:
    """Return the numbers of columns and rows of the legend that fit into the figure's width."""
    count = len(picture.legend)
    if not count:
        return 0, 0
    entry = 0.55 + LETTER * FONT * max(len(_cut(name)) for name, _ in picture.legend)
    columns = max(1, min(count, int((width - 0.3) / entry)))
    return columns, -(-count // columns)


def _add_legend(figure: Any, picture: Picture, columns: int, at: tuple[float, float]) -> None:
    from matplotlib.lines import Line2D

    keys = [Line2D([], [], **_key_style(style)) for _, style in picture.legend]
    legend = figure.legend(
        keys, [""] * len(keys), loc="lower center", bbox_to_anchor=at, ncols=columns, frameon=False, fontsize=FONT,
        borderpad=0.0, borderaxespad=0.0, handlelength=3.2, columnspacing=1.5,
    )  # fmt: skip
    for text, (name, _) in zip(legend.get_texts(), picture.legend, strict=True):
        text.set(parse_math=False, text=_cut(name))


def _key_style(style: Key) -> dict[str, Any]:
    if isinstance(style, tuple):
        return {**mark_style(style[1]), **_key_style(style[0])}
    if isinstance(style, Mark):
        return mark_style(style)
    return {"color": style.color, "linewidth": style.width, "linestyle": dash(style)}
