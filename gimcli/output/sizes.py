"""Sizes on paper of the parts of a figure: borders, titles and legends around the axes."""

from __future__ import annotations

from gimcli.output.axes import title_lines
from gimcli.output.picture import Picture
from gimcli.output.style import BOTTOM, DPI, FONT, LEFT, LETTER, LINE, PIXELS, RIGHT, TOP

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
