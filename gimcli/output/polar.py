"""Polar diagrams: the magnitude of a quantity as radius over an angle."""

from __future__ import annotations

import math

import numpy as np

from gimcli.mechanism import ComplexArray
from gimcli.output.graph import CurveGraph
from gimcli.output.picture import LAYOUT, Frame, Picture, PictureLayout, Text, composition
from gimcli.output.style import CUT, SOFT, Pen, curve_pen
from gimcli.output.ticks import fitted, short, tick_texts
from gimcli.output.value_window import value_window
from gimcli.table import labelled

GRID, RIM = Pen(0.5, SOFT, layer=1), Pen(0.9, SOFT, layer=1)

STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Distances of the circles, times a power of ten."""

MOST_CIRCLES = 5

RAYS = 30
"""Angle between the rays [deg]."""

SMALL = 0.9
"""Radius [in] below which only the axes and the outer circle have numbers."""

MOST_CURVES = 12


@composition
def polar_picture(graph: CurveGraph, *, layout: PictureLayout = LAYOUT) -> Picture:
    """Return the polar diagram of a graph, with circles at round radii and a ray every 30 degrees."""
    curves = graph.curves[:MOST_CURVES]
    _, greatest = value_window(np.abs(curve.y) for curve in curves)
    step = _step(greatest)
    rim = step * math.ceil(greatest / step * (1.0 - 1e-9))
    circle = np.asarray(np.exp(1j * np.radians(np.arange(0, 361, 2))))
    picture = Picture("", Frame.around(np.asarray(1.12 * rim * circle), layout), bare=True)
    name, factor = fitted(labelled(graph.up.name, graph.up.unit), greatest)
    alone = f" of {curves[0].name}" if len(graph.curves) == 1 and curves[0].name != graph.up.name else ""
    picture.title = f"{name}{alone} over {graph.across.name}"
    _draw_grid(picture, circle, step, rim, factor)
    for index, curve in enumerate(curves):
        radius = np.abs(curve.y)
        with np.errstate(invalid="ignore"):
            beyond = np.flatnonzero(radius > rim * (1.0 + 1e-9))
        z = np.where(radius <= rim * (1.0 + 1e-9), radius, np.nan) * np.exp(1j * curve.x)
        picture.stroke(curve_pen(index), *_runs(z))
        if len(graph.curves) > 1:
            picture.legend.append((curve.name, curve_pen(index)))
        if len(beyond):
            most = float(np.max(radius[beyond]))
            picture.legend.append((f"beyond the circle: {curve.name} {short(most)} {graph.up.unit}".rstrip(), CUT))
    if len(graph.curves) > MOST_CURVES:
        picture.legend.append((f"and {len(graph.curves) - MOST_CURVES} more: name the columns", Pen(0.0)))
    return picture


def _draw_grid(picture: Picture, circle: ComplexArray, step: float, rim: float, factor: float) -> None:
    radii = step * np.arange(1.0, round(rim / step) + 1.0)
    picture.stroke(GRID, *(radius * circle for radius in radii[:-1]))
    picture.stroke(RIM, rim * circle)
    small = rim < SMALL * 72.0 * picture.frame.point * picture.frame.font
    for degrees in range(0, 360, RAYS):
        ray = complex(np.exp(1j * math.radians(degrees)))
        picture.stroke(GRID, [0.0j, rim * ray])
        if not small or degrees % 90 == 0:
            picture.texts.append(Text(1.07 * rim * ray, f"{degrees}°"))
    middle = complex(np.exp(1j * math.radians(0.5 * RAYS)))
    texts = tick_texts(radii * factor)
    for radius, text in list(zip(radii, texts, strict=True))[-1 if small else 0 :]:
        picture.texts.append(Text((radius - 0.04 * rim) * middle, text))


def _runs(z: ComplexArray) -> list[ComplexArray]:
    """Return the pieces of a curve between its gaps."""
    gap = ~np.isfinite(z)
    pieces = np.split(z, np.flatnonzero(gap[1:] | gap[:-1]) + 1)
    return [piece for piece in pieces if len(piece) > 1 and np.all(np.isfinite(piece))]


def _step(greatest: float) -> float:
    """Return the round distance of the circles."""
    if not greatest > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(greatest / MOST_CIRCLES))
    return next(power * own for own in STEPS if greatest <= MOST_CIRCLES * power * own * (1.0 + 1e-9))
