"""One picture on matplotlib's axes, and the sizes on paper of the parts around them.

The axes have limits, ticks and one matplotlib artist per style; around them are borders, titles and legends.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from itertools import chain, count
from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.output.axis import power_of_ten, set_ticks
from gimcli.output.picture import Picture, Text
from gimcli.output.style import BOTTOM, DPI, FONT, LEFT, LETTER, LINE, PIXELS, RIGHT, TOP, Mark, Pen

HALO = 2.0
"""Width of the light edge around letters [pt]."""


MOST_LINES = 4
"""Largest number of lines of a title; a longer one is cut."""


IN_NAMES = (
    "-.0-9:A-Z_a-z\u00b7\u00c0-\u00d6\u00d8-\u00f6\u00f8-\u037d\u037f-\u1fff\u200c\u200d\u203f\u2040\u2070-\u218f"
    "\u2c00-\u2fef\u3001-\ud7ff\uf900-\ufdcf\ufdf0-\ufffd\U00010000-\U000effff"
)
"""Characters of a name in XML. Source: W3C, Extensible Markup Language 1.0, fifth edition, production 4a."""


class PartNames:
    """The identifiers of one file: each is used once."""

    def __init__(self) -> None:
        self._used: set[str] = set()

    def of(self, part: str) -> str:
        """Return the identifier of a part such as "member:crank".

        Other characters than those of a name in XML become their number, such as "_x0020_" for a space. A part that
        comes again, such as that of another panel, gets a number.
        """
        stem = re.sub(f"[^{IN_NAMES}]", lambda found: f"_x{ord(found[0]):04X}_", part)
        own = next(name for name in chain([stem], (f"{stem}-{k}" for k in count(2))) if name not in self._used)
        self._used.add(own)
        return own


def set_up(axes: Any, picture: Picture) -> None:
    """Set limits, labels and ticks of the axes."""
    low, high = picture.frame.low, picture.frame.high
    axes.set_xlim(low.real, high.real)
    axes.set_ylim(low.imag, high.imag)
    if picture.bare:
        axes.set_axis_off()
        return
    axes.set_xlabel(picture.labels[0], parse_math=False)
    axes.set_ylabel(picture.labels[1], parse_math=False)
    set_ticks(axes, picture)
    _write_above(axes, picture)
    if picture.logarithmic:
        axes.set_yticks(*_decades(low.imag, high.imag))
    if picture.logarithmic_x:
        axes.set_xticks(*_decades(low.real, high.real))
        axes.set_xticks(_between(low.real, high.real), minor=True)


def _write_above(axes: Any, picture: Picture) -> None:
    """Write words above the axes, without overlap."""
    frame, taken = picture.frame, -math.inf
    for place, word in sorted(picture.above):
        middle = frame.width * (place - frame.low.real) / (frame.high.real - frame.low.real)
        half = 0.5 * LETTER * FONT * frame.font * len(word)
        if middle - half < taken:
            continue
        taken = middle + half
        side = "left" if middle < half else "right" if middle > frame.width - half else "center"
        axes.annotate(
            word, (place, 1.0), (0.0, 2.0), ("data", "axes fraction"), "offset points", ha=side, va="bottom",
            fontsize=FONT * frame.font, parse_math=False,
        )  # fmt: skip


def _decades(low: float, high: float) -> tuple[FloatArray, list[str]]:
    """Return ticks at powers of ten, and their labels."""
    decades = np.arange(np.ceil(low), np.floor(high) + 1)
    ticks = decades[:: max(1, len(decades) // 8)]
    return ticks, [power_of_ten(int(tick)) for tick in ticks]


def _between(low: float, high: float) -> FloatArray:
    """Return minor ticks at 2 to 9 times the powers of ten."""
    decades = np.arange(np.floor(low), np.ceil(high))
    ticks = np.add.outer(decades, np.log10(np.arange(2.0, 10.0))).ravel()
    return np.asarray(ticks[(ticks > low) & (ticks < high)])


def fill(axes: Any, picture: Picture, names: PartNames | None = None) -> None:
    """Add one collection per pen and fill, one line of markers per mark, and the texts.

    With `names` each part has its own artists, in a group with its name.
    """
    named = {} if names is None else picture.split()
    for part, own in named.items() if set(named) - {""} else [("", picture)]:
        artists = _artists(own)
        if part and names is not None:
            _add_group(axes, names.of(part), min(one.get_zorder() for one in artists), artists)
            continue
        for artist in artists:
            axes.add_artist(artist)
    for text in picture.texts:
        _write_text(axes, text, picture.frame.font)


def _artists(picture: Picture) -> list[Any]:
    """Return the artists of strokes, areas and marks."""
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.lines import Line2D

    found: list[Any] = []
    for style, z in picture.drawn.items():
        if isinstance(style, Mark):
            found.append(Line2D(np.real(z), np.imag(z), **mark_style(style)))
        elif isinstance(style, Pen):
            lines = LineCollection(list(map(_xy, z)), colors=style.color, linewidths=style.width)
            lines.set(linestyle=dash(style), zorder=style.layer, joinstyle="round")
            lines.set_capstyle("butt" if style.dash else "round")
            found.append(lines)
        else:
            areas = PolyCollection(list(map(_xy, z)), facecolors=style.face)
            areas.set(edgecolor=style.edge, linewidth=style.width, zorder=style.layer, joinstyle="round")
            found.append(areas)
    return found


def _add_group(axes: Any, name: str, layer: float, artists: Sequence[Any]) -> None:
    """Add matplotlib artists to axes as one group of an SVG file."""
    from matplotlib.artist import Artist

    class PartGroup(Artist):
        def draw(self, renderer: Any) -> None:
            renderer.open_group("part", gid=self.get_gid())
            for artist in sorted(artists, key=lambda one: float(one.get_zorder())):
                artist.draw(renderer)
            renderer.close_group("part")

    for artist in artists:
        artist.set_figure(axes.figure)
        artist.axes = axes
        if not artist.is_transform_set():
            artist.set_transform(axes.transData)
        artist.set_clip_path(axes.patch)
    group = PartGroup()
    group.set_gid(name)
    group.set_zorder(layer)
    axes.add_artist(group)


def _xy(z: ComplexArray) -> FloatArray:
    return np.column_stack((z.real, z.imag))


def mark_style(mark: Mark) -> dict[str, Any]:
    """Return a mark as matplotlib's keyword arguments."""
    return {
        "linestyle": "none", "marker": mark.shape, "markersize": mark.size, "markerfacecolor": mark.face,
        "markeredgecolor": mark.edge, "markeredgewidth": mark.width, "zorder": mark.layer,
    }  # fmt: skip


def _write_text(axes: Any, text: Text, font: float) -> None:
    from matplotlib.patheffects import Normal, Stroke

    paper = axes.get_facecolor()
    ring = {"boxstyle": "circle,pad=0.18", "facecolor": paper, "edgecolor": text.color, "linewidth": 0.8}
    axes.text(
        text.at.real, text.at.imag, text.text, fontsize=text.size * font, color=text.color,
        ha="left" if text.begins else "center", va="center_baseline", zorder=10, parse_math=False,
        bbox=ring if text.ring else None,
        path_effects=[Stroke(linewidth=HALO, foreground=paper), Normal()] if text.halo else None,
    )  # fmt: skip


def title_lines(title: str, width: float, font: float = 1.0) -> list[str]:
    """Return the lines of a title that fit into a width [in]; `font` is the size of texts, relative to the usual."""
    letters = max(8, int(width / (LETTER * (FONT + 2) * font)))
    return textwrap.wrap(title, letters, max_lines=MOST_LINES, placeholder=" …")


def write_title(figure: Any, lines: list[str], x: float, y: float) -> None:
    """Write the title of a figure; x, y are the middle of its upper edge, in parts of the figure."""
    from matplotlib import rcParams

    figure.text(x, y, "\n".join(lines), ha="center", va="top", fontsize=rcParams["figure.titlesize"], parse_math=False)


def dash(pen: Pen) -> Any:
    """Return a pen's line style in matplotlib's form."""
    return (0.0, pen.dash) if pen.dash else "solid"


LONGEST = 48
"""Largest number of letters of a name in the legend; longer names are cut."""


def borders(font: float) -> tuple[float, float]:
    """Return the widths [in] on the left and on the right of the axes."""
    return LEFT * font, RIGHT


def title_height(title: str, width: float, font: float) -> float:
    """Return the height [in] of a title in a figure of a width [in]."""
    return len(title_lines(title, width, font)) * LINE * font


def height_below(picture: Picture, width: float) -> float:
    """Return the height [in] of the numbers, the name of the axis and the legend below the axes."""
    font, (_, rows) = picture.frame.font, legend_shape(picture, width)
    if picture.bare:
        return 0.05
    return (BOTTOM + rows * LINE) * font + (0.04 if rows else 0.0)


def whole_height(picture: Picture, width: float) -> float:
    """Return the height [in] of a picture with its title and legend, in a figure of a width [in]."""
    above = (0.05 if picture.bare else TOP) + title_height(picture.title, width, picture.frame.font)
    return height_below(picture, width) + picture.frame.height + above


def legend_shape(picture: Picture, width: float) -> tuple[int, int]:
    """Return the numbers of columns and rows of the legend that fit into a width [in]."""
    count = len(picture.legend)
    if not count:
        return 0, 0
    entry = 0.55 + LETTER * FONT * picture.frame.font * max(len(cut(name)) for name, _ in picture.legend)
    columns = max(1, min(count, int((width - 0.3) / entry)))
    return columns, -(-count // columns)


def cut(name: str) -> str:
    """Return a name for the legend, not longer than `LONGEST` letters."""
    return name if len(name) <= LONGEST else name[: LONGEST - 1] + "…"


def resolution(width: float) -> float:
    """Return the usual resolution [dpi] of a figure of a width [in]."""
    return max(DPI, PIXELS / width)
