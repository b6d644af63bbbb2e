"""A picture as a matplotlib figure: one artist per style, no layout passes."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray
from gimcli.output.picture import Content, Gallery, Key, Picture, Sheet, Text
from gimcli.output.style import DPI, FONT, INK, PAPER, Mark, Pen

LEFT, RIGHT, BOTTOM, TOP = 0.85, 0.3, 0.5, 0.2
"""Borders about the axes [in]."""

NARROWEST = 4.8
"""Least width of a figure [in]."""

LINE = 0.19
"""Height of a line of the title or of the legend [in]."""

LETTER = 0.0087
"""Width of a letter [in] per point of its size."""

LONGEST = 48
"""Letters of a name in the legend; a longer one is cut."""


@contextmanager
def quiet() -> Iterator[None]:
    """Keep a glyph that the font lacks from printing a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def canvas_of(canvas: Any, content: Content) -> Any:
    """Return what is to be drawn on matplotlib's canvas of some format."""
    if isinstance(content, Gallery):
        from gimcli.output.gallery import gallery_figure

        return canvas(gallery_figure(content))
    return canvas(figure_of(content))


def figure_of(content: Picture | Sheet) -> Any:
    """Return the matplotlib figure of a picture, or of several one above the other."""
    from matplotlib.figure import Figure

    pictures = content.pictures if isinstance(content, Sheet) else (content,)
    width = max([NARROWEST, *(LEFT + picture.frame.width + RIGHT for picture in pictures)])
    heading = _lines(content.title, width) if isinstance(content, Sheet) else []
    heights = [_height(picture, width) for picture in pictures]
    height = sum(heights) + len(heading) * LINE
    figure = Figure((width, height), dpi=DPI, facecolor=PAPER)
    write_title(figure, heading, 0.5, 1 - 0.12 / height)
    bottom = sum(heights)
    for picture, own in zip(pictures, heights, strict=True):
        bottom -= own
        _add_picture(figure, picture, bottom, own, (width, height))
    return figure


def _lines(title: str, width: float) -> list[str]:
    return textwrap.wrap(title, int(width / (LETTER * (FONT + 2))))


def _height(picture: Picture, width: float) -> float:
    """Return the height [in] of a picture with its title and legend."""
    _, rows = _legend_shape(picture, width)
    bottom, top = BOTTOM + rows * LINE + (0.04 if rows else 0.0), TOP + len(_lines(picture.title, width)) * LINE
    return bottom + picture.frame.height + top


def _add_picture(figure: Any, picture: Picture, base: float, own: float, size: tuple[float, float]) -> None:
    """Add a picture whose lower edge is at `base` [in] of a figure."""
    width, height = size
    frame, title = picture.frame, _lines(picture.title, width)
    columns, rows = _legend_shape(picture, width)
    bottom = base + BOTTOM + rows * LINE + (0.04 if rows else 0.0)
    left = LEFT + (width - LEFT - RIGHT - frame.width) / 2
    axes = figure.add_axes((left / width, bottom / height, frame.width / width, frame.height / height))
    dress(axes, picture)
    fill(axes, picture)
    axes.yaxis.get_offset_text().set_fontsize(FONT)
    middle = (left + frame.width / 2) / width
    write_title(figure, title, middle, (base + own - 0.12) / height)
    if rows:
        _add_legend(figure, picture, columns, (middle, (base + 0.07) / height))


def dress(axes: Any, picture: Picture) -> None:
    """Set limits, labels and ticks."""
    low, high = picture.frame.low, picture.frame.high
    axes.set_xlim(low.real, high.real)
    axes.set_ylim(low.imag, high.imag)
    if picture.bare:
        axes.set_axis_off()
        return
    axes.set_xlabel(picture.labels[0], fontsize=FONT + 1, parse_math=False)
    axes.set_ylabel(picture.labels[1], fontsize=FONT + 1, parse_math=False)
    axes.tick_params(labelsize=FONT, width=0.6, length=3, direction="in", top=True, right=True)
    for side in axes.spines.values():
        side.set_linewidth(0.6)
    if picture.logarithmic:
        axes.set_yticks(*_decades(low.imag, high.imag))
    if picture.logarithmic_x:
        axes.set_xticks(*_decades(low.real, high.real))
        axes.set_xticks(_between(low.real, high.real), minor=True)
        axes.tick_params(which="minor", width=0.4, length=1.8, direction="in", top=True)


def _decades(low: float, high: float) -> tuple[NDArray[np.float64], list[str]]:
    """Return ticks at powers of ten, and their texts."""
    decades = np.arange(np.ceil(low), np.floor(high) + 1)
    ticks = decades[:: max(1, len(decades) // 8)]
    return ticks, [_power(int(tick)) for tick in ticks]


def _between(low: float, high: float) -> NDArray[np.float64]:
    """Return ticks at 2 to 9 times the powers of ten."""
    decades = np.arange(np.floor(low), np.ceil(high))
    ticks = np.add.outer(decades, np.log10(np.arange(2.0, 10.0))).ravel()
    return np.asarray(ticks[(ticks > low) & (ticks < high)])


def _power(exponent: int) -> str:
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def fill(axes: Any, picture: Picture) -> None:
    """Add one collection per pen and fill, one line of markers per mark, and the texts."""
    from matplotlib.collections import LineCollection, PolyCollection

    for pen, paths in picture.strokes.items():
        lines = LineCollection([_xy(path) for path in paths], colors=pen.color, linewidths=pen.width)
        lines.set(linestyle=_dash(pen), zorder=pen.layer, joinstyle="round")
        lines.set_capstyle("butt" if pen.dash else "round")
        axes.add_collection(lines, autolim=False)
    for fill, outlines in picture.areas.items():
        areas = PolyCollection([_xy(outline) for outline in outlines], facecolors=fill.face)
        areas.set(edgecolor=fill.edge, linewidth=fill.width, zorder=fill.layer, joinstyle="round")
        axes.add_collection(areas, autolim=False)
    for mark, places in picture.marks.items():
        z = np.array(places)
        axes.plot(z.real, z.imag, scalex=False, scaley=False, **_mark_style(mark))
    for text in picture.texts:
        _write_text(axes, text)


def _xy(z: ComplexArray) -> NDArray[np.float64]:
    return np.column_stack((z.real, z.imag))


def _mark_style(mark: Mark) -> dict[str, Any]:
    return {
        "linestyle": "none",
        "marker": mark.shape,
        "markersize": mark.size,
        "markerfacecolor": mark.face,
        "markeredgecolor": mark.edge,
        "markeredgewidth": mark.width,
        "zorder": mark.layer,
    }


def _write_text(axes: Any, text: Text) -> None:
    ring = {"boxstyle": "circle,pad=0.18", "facecolor": PAPER, "edgecolor": text.color, "linewidth": 0.8}
    axes.text(
        text.at.real,
        text.at.imag,
        text.text,
        fontsize=text.size,
        color=text.color,
        ha="center",
        va="center_baseline",
        zorder=10,
        parse_math=False,
        bbox=ring if text.ring else None,
    )


def write_title(figure: Any, lines: list[str], x: float, y: float) -> None:
    """Write a figure's title."""
    figure.text(x, y, "\n".join(lines), ha="center", va="top", fontsize=FONT + 2, color=INK, parse_math=False)


def _cut(name: str) -> str:
    return name if len(name) <= LONGEST else name[: LONGEST - 1] + "…"


def _legend_shape(picture: Picture, width: float) -> tuple[int, int]:
    """Return columns and rows that fit into the figure's width."""
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
        keys,
        [""] * len(keys),
        loc="lower center",
        bbox_to_anchor=at,
        ncols=columns,
        frameon=False,
        fontsize=FONT,
        borderpad=0.0,
        borderaxespad=0.0,
        handlelength=3.2,
        columnspacing=1.5,
    )
    for text, (name, _) in zip(legend.get_texts(), picture.legend, strict=True):
        text.set(parse_math=False, text=_cut(name))


def _key_style(style: Key) -> dict[str, Any]:
    if isinstance(style, tuple):
        return {**_mark_style(style[1]), **_key_style(style[0])}
    if isinstance(style, Mark):
        return _mark_style(style)
    return {"color": style.color, "linewidth": style.width, "linestyle": _dash(style)}


def _dash(pen: Pen) -> Any:
    return (0.0, pen.dash) if pen.dash else "solid"
