"""The strokes of the symbols of textbook drawings: pivots, blocks, guides, cylinders and the arrows of the inputs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray
from gimcli.output.style import ARROW, BLOCK, CYLINDER, GROUND, HATCH, HEAD, ROD, SUPPORT, THIN, Fill, Mark, Pen
from gimcli.output.symbol import Stroke, Strokes

BLOCK_LENGTH, BLOCK_HEIGHT = 20.0, 12.0
"""Size of a sliding block [pt]."""

OVERHANG = BLOCK_LENGTH / 2 + 12.0
"""Length of a guide beyond the place of its block [pt]."""

PIVOT_HEIGHT, PIVOT_HALF = 11.0, 7.0
"""Triangle of a fixed pivot [pt]."""

SLANT = 4.0
"""Size of the strokes of a hatching along and across the line [pt]."""

OUTLINES = {
    "o": (np.exp(2j * np.pi * np.arange(24) / 24),),
    "D": (np.sqrt(2.0) * np.exp(0.5j * np.pi * np.arange(4)),),
    "x": (np.array([-1 - 1j, 1 + 1j]), np.array([-1 + 1j, 1 - 1j])),
}
"""Outlines or lines of marks of the size 2, by matplotlib's names of their shapes."""


def hatching(first: complex, second: complex, away: complex, share: tuple[float, float] = (0.0, 0.0)) -> Strokes:
    """Return a ground line in the direction of x with slanting strokes on the side `away` (unit)."""
    line = (first, second)
    return Stroke(GROUND, line, share), Stroke(HATCH, line, share, slant=(away - 1.0) * SLANT)


def fixed_pivot(upward: bool = False) -> Strokes:
    """Return the triangle, ground line and hatching of a pivot on the frame; x is horizontal."""
    down = 1j if upward else -1j
    foot = down * PIVOT_HEIGHT
    triangle = Stroke(SUPPORT, (0j, foot - PIVOT_HALF, foot + PIVOT_HALF))
    return triangle, *hatching(foot - 1.5 * PIVOT_HALF, foot + 1.5 * PIVOT_HALF, down)


def bar(fill: Fill, shares: tuple[float, float], beyond: float, height: float) -> Stroke:
    """Return a rectangle between two parts of the span that extends by `beyond` [pt] at both ends."""
    end, half, (first, second) = beyond, 0.5j * height, shares
    return Stroke(fill, (-end - half, end - half, end + half, half - end), (first, second, second, first))


def block(fill: Fill = BLOCK) -> Stroke:
    """Return a sliding block that covers one or two nodes."""
    return bar(fill, (0.0, 1.0), BLOCK_LENGTH / 2, BLOCK_HEIGHT)


def frame_guide(away: complex) -> Strokes:
    """Return the hatched line on which a block rests; `away` is the side of the hatching (i or -i)."""
    beside = away * BLOCK_HEIGHT / 2
    return hatching(beside - OVERHANG, beside + OVERHANG, away, (0.0, 1.0))


def moving_guide() -> Strokes:
    """Return the guide of a block that slides on a moving member."""
    return (Stroke(THIN, (-OVERHANG, OVERHANG), (0.0, 1.0)),)


def cylinder() -> Strokes:
    """Return a cylinder from the first place and its rod to the second one, with the piston."""
    piston = Stroke(ARROW, (-4.0 - 2.6j, -4.0 + 2.6j), 0.6)
    return Stroke(ROD, share=(0.0, 1.0)), bar(CYLINDER, (0.14, 0.6), 0.0, 8.0), piston


def arrow_lines(path: NDArray[Any], size: float) -> tuple[ComplexArray, ComplexArray]:
    """Return a polyline that ends inside its arrowhead of a size, and the outline of the arrowhead."""
    along = path[-1] - path[-2]
    along = along / abs(along) if along else 1.0 + 0.0j
    tip = path[-1] + along * size * np.array([0.0, -1.0 + 0.32j, -1.0 - 0.32j])
    return np.append(path[:-1], path[-1] - 0.6 * along * size), tip


def arrow(path: NDArray[Any], pen: Pen = ARROW, fill: Fill = HEAD, size: float = 6.0) -> Strokes:
    """Return a polyline [pt] with an arrowhead at its end."""
    line, tip = arrow_lines(path, size)
    return Stroke(pen, line), Stroke(fill, tip)


def turning_arrow(sense: float) -> Strokes:
    """Return the arc of a rotary input about the direction of x."""
    return arrow(15.0 * np.exp(1j * sense * np.radians(np.linspace(-52.0, 52.0, 25))))


def travel_arrow(aside: float, sense: float) -> Strokes:
    """Return the straight arrow of a driven sliding pair, to the left (1) or to the right (-1) of its block."""
    return arrow(1j * aside * (BLOCK_HEIGHT / 2 + 5.0) + sense * np.linspace(-9.0, 11.0, 8))


def mark_strokes(mark: Mark) -> Strokes:
    """Return a mark as strokes."""
    lines = [0.5 * mark.size * outline for outline in OUTLINES[mark.shape]]
    if len(lines) > 1:
        return tuple(Stroke(Pen(mark.width, mark.edge, layer=mark.layer), line) for line in lines)
    return (Stroke(Fill(mark.face, mark.edge, mark.width, mark.layer), lines[0]),)
