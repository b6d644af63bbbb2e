"""The symbols of textbook drawings, in data units; `pt` is one typographic point of the picture."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray
from gimcli.output.picture import Picture
from gimcli.output.style import ARROW, BLOCK, CYLINDER, GROUND, HATCH, HEAD, ROD, SUPPORT, THIN, Fill, Pen

BLOCK_LENGTH, BLOCK_HEIGHT = 20.0, 12.0
"""Size of a sliding block [pt]."""

OVERHANG = 12.0
"""Length of a guide beyond its block [pt]."""

PIVOT_HEIGHT, PIVOT_HALF = 11.0, 7.0
"""Triangle of a fixed pivot [pt]."""


def rectangle(first: complex, second: complex, beyond: float, height: float, along: complex) -> ComplexArray:
    """Return the outline of a bar from `first` to `second` that extends by `beyond` at both ends."""
    start, end, half = first - along * beyond, second + along * beyond, 1j * along * height / 2
    return np.array([start - half, end - half, end + half, start + half])


def hatch(picture: Picture, first: complex, second: complex, away: complex) -> None:
    """Draw a ground line with slanting strokes on the side `away` (unit)."""
    pt, span = picture.frame.point, second - first
    count = max(2, round(abs(span) / (4.2 * pt)))
    slant = (away - span / abs(span)) * 4.0 * pt
    feet = first + span * (np.arange(count) + 0.8) / count
    picture.stroke(GROUND, [first, second])
    picture.stroke(HATCH, *(np.array([foot, foot + slant]) for foot in feet.tolist()))


def fixed_pivot(picture: Picture, at: complex, upward: bool = False) -> None:
    """Draw the triangle, ground line and hatching of a pivot on the frame."""
    pt, down = picture.frame.point, 1j if upward else -1j
    foot, half = at + down * PIVOT_HEIGHT * pt, PIVOT_HALF * pt
    picture.area(SUPPORT, [at, foot - half, foot + half])
    hatch(picture, foot - 1.5 * half, foot + 1.5 * half, down)


def block(picture: Picture, first: complex, second: complex, along: complex, fill: Fill = BLOCK) -> None:
    """Draw a sliding block that covers one or two nodes."""
    pt = picture.frame.point
    picture.area(fill, rectangle(first, second, BLOCK_LENGTH / 2 * pt, BLOCK_HEIGHT * pt, along))


def frame_guide(picture: Picture, first: complex, second: complex, along: complex, away: complex) -> None:
    """Draw the hatched line on which a block rests."""
    pt = picture.frame.point
    reach, shift = along * (BLOCK_LENGTH / 2 + OVERHANG) * pt, away * BLOCK_HEIGHT / 2 * pt
    hatch(picture, first - reach + shift, second + reach + shift, away)


def moving_guide(picture: Picture, first: complex, second: complex, along: complex) -> None:
    """Draw the guide of a block that slides on a moving member."""
    reach = along * (BLOCK_LENGTH / 2 + OVERHANG) * picture.frame.point
    picture.stroke(THIN, [first - reach, second + reach])


def cylinder(picture: Picture, base: complex, end: complex, fill: Fill = CYLINDER) -> None:
    """Draw a cylinder from `base` and its rod to `end`."""
    if base == end:
        return
    pt, along = picture.frame.point, (end - base) / abs(end - base)
    first, second = base + 0.14 * (end - base), base + 0.60 * (end - base)
    half = 2.6j * along * pt
    picture.stroke(replace(ROD, color=fill.edge), [base, end])
    picture.area(fill, rectangle(first, second, 0.0, 8.0 * pt, along))
    picture.stroke(ARROW, [second - 4 * along * pt - half, second - 4 * along * pt + half])


def head(picture: Picture, tip: complex, along: complex, size: float = 6.0, fill: Fill = HEAD) -> None:
    """Draw an arrowhead of `size` [pt] in the direction `along` (unit)."""
    back = tip - along * size * picture.frame.point
    half = 0.32j * along * size * picture.frame.point
    picture.area(fill, [tip, back + half, back - half])


def arrow(picture: Picture, path: NDArray[Any], pen: Pen = ARROW, fill: Fill = HEAD, size: float = 6.0) -> None:
    """Draw a polyline with an arrowhead at its end."""
    along = path[-1] - path[-2]
    along = along / abs(along) if along else 1.0 + 0.0j
    picture.stroke(pen, np.append(path[:-1], path[-1] - 0.6 * along * size * picture.frame.point))
    head(picture, complex(path[-1]), complex(along), size, fill)


def turning_arrow(picture: Picture, at: complex, middle: complex, sense: float) -> None:
    """Draw the arc of a rotary input about the direction `middle` (unit)."""
    turn = np.linspace(-1.0, 1.0, 25) * np.radians(52.0) * (1.0 if sense >= 0 else -1.0)
    arrow(picture, at + 15.0 * picture.frame.point * middle * np.exp(1j * turn))


def travel_arrow(picture: Picture, at: complex, along: complex, aside: complex, sense: float) -> None:
    """Draw the straight arrow of a driven sliding pair on the side `aside` (unit) of its block."""
    pt, along = picture.frame.point, along if sense >= 0 else -along
    start = at + aside * (BLOCK_HEIGHT / 2 + 5.0) * pt - along * 9.0 * pt
    arrow(picture, np.linspace(start, start + along * 20.0 * pt, 8))
