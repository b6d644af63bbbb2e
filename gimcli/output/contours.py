"""Contours of a quantity over two others: bands, lines with their values, points where the neighbours have none."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.output.axis import short
from gimcli.output.graph import Axis
from gimcli.output.picture import Frame, Picture, Text
from gimcli.output.style import INK, Fill, Mark, Pen
from gimcli.table import labelled

WIDTH, HEIGHT = 5.0, 3.3
"""Size of the axes [in]."""

LEVELS = 8
"""Approximate number of levels."""

LIGHT, DARK = (246, 249, 252), (92, 146, 200)
"""Colours (red, green, blue) of the lowest and of the highest band."""

LINE = Pen(0.9, INK, layer=5)

ALONE = Mark("o", 5.0, face=INK)
"""Mark of a value without neighbours."""

MOST_WRITTEN = 12
"""Largest number of these values that are written."""

SHORTEST = 0.12
"""Least length of a line with its value, relative to the width of the axes."""


def contour_picture(across: Axis, up: Axis, name: Axis, x: FloatArray, y: FloatArray, values: FloatArray) -> Picture:
    """Return the contours of values (len(y), len(x)); NaN: no value."""
    import contourpy

    frame = Frame(complex(x.min(), y.min()), complex(x.max(), y.max()), WIDTH, HEIGHT)
    picture = Picture(
        labelled(name.name, name.unit), frame, (labelled(across.name, across.unit), labelled(up.name, up.unit))
    )
    known = values[np.isfinite(values)]
    if not len(known):
        return picture
    levels = _levels(float(known.min()), float(known.max()))
    found: Any = contourpy.contour_generator(
        x, y, np.ma.masked_invalid(values), corner_mask=True, fill_type="OuterOffset"
    )
    for k, (low, high) in enumerate(zip([-np.inf, *levels], [*levels, np.inf], strict=True)):
        picture.draw(_band(k, len(levels) + 1), *_outlines(found.filled(low, high)))
    for level in levels:
        lines = [_complex(line) for line in found.lines(level)]
        picture.draw(LINE, *lines)
        _write_value(picture, level, lines)
    _mark_alone(picture, x, y, values)
    return picture


def _mark_alone(picture: Picture, x: FloatArray, y: FloatArray, values: FloatArray) -> None:
    """Mark the values that are not part of an area; write them if they are few and there is no area."""
    known = np.pad(np.isfinite(values), 1)
    cells = known[:-1, :-1].astype(int) + known[1:, :-1] + known[:-1, 1:] + known[1:, 1:] >= 3  # of four corners
    inside = cells[:-1, :-1] | cells[1:, :-1] | cells[:-1, 1:] | cells[1:, 1:]
    rows, columns = np.nonzero(np.isfinite(values) & ~inside)
    places = _complex(np.column_stack([x[columns], y[rows]]))
    picture.draw(ALONE, *places)
    if len(places) <= MOST_WRITTEN and not inside.any():
        up = 0.04 * (picture.frame.high - picture.frame.low).imag
        for place, value in zip(places, values[rows, columns], strict=True):
            picture.texts.append(Text(complex(place) + 1j * up, f"{value:.4g}", halo=True))


def _levels(low: float, high: float) -> list[float]:
    """Return round numbers between two values."""
    spread = high - low
    if spread <= 1e-9 * max(abs(low), abs(high)):
        return []
    ten = 10.0 ** np.floor(np.log10(spread / LEVELS))
    step = min((part * ten for part in (1.0, 2.0, 5.0, 10.0)), key=lambda size: abs(spread / size - LEVELS))
    first, last = int(np.ceil(low / step)), int(np.floor(high / step))
    return [float(f"{k * step:.12g}") for k in range(first, last + 1) if low < k * step < high]


def _band(number: int, count: int) -> Fill:
    share = number / max(1, count - 1)
    colour = "#" + "".join(f"{round(a + share * (b - a)):02x}" for a, b in zip(LIGHT, DARK, strict=True))
    return Fill(colour, colour, 0.3, layer=0.5)


def _outlines(filled: tuple[list[FloatArray], list[FloatArray]]) -> Iterator[ComplexArray]:
    """Yield each area as one outline; its holes are joined to it by seams."""
    for points, offsets in zip(*filled, strict=True):
        z = _complex(points)
        rings = [z[a:b] for a, b in pairwise(offsets)]
        yield np.concatenate([rings[0], *(np.append(ring, rings[0][0]) for ring in rings[1:])])


def _write_value(picture: Picture, level: float, lines: list[ComplexArray]) -> None:
    """Write a level on its longest line."""
    span = picture.frame.high - picture.frame.low
    scaled = [line.real / span.real + 1j * line.imag / span.imag for line in lines]
    lengths = [float(np.abs(np.diff(line)).sum()) for line in scaled]
    if lengths and max(lengths) > SHORTEST:
        longest = int(np.argmax(lengths))
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(scaled[longest])))])
        middle = int(np.searchsorted(way, way[-1] / 2.0))
        picture.texts.append(Text(complex(lines[longest][middle]), short(level), halo=True))


def _complex(points: FloatArray) -> ComplexArray:
    return np.asarray(points[:, 0] + 1j * points[:, 1])
