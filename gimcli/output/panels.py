"""Pictures of graphs: curves over a common abscissa, hodographs and polar diagrams."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.output.axis import fitted, short, tick_texts, value_window
from gimcli.output.curves import pieces
from gimcli.output.graph import EQUAL, POLAR, Curve, CurveGraph, PlaceMark
from gimcli.output.picture import LAYOUT, WIDEST, Frame, Picture, PictureLayout, Sheet, Text, composition
from gimcli.output.style import CUT, DOT, PAPER, SOFT, VERTICAL, Mark, Pen, curve_pen, event_mark
from gimcli.rounding import round_above
from gimcli.table import labelled

HEIGHT, LEAST_WIDTH = 1.55, 4.4
"""Size of a panel's axes [in]."""

MOST_CURVES = 12
"""Largest number of curves in a panel."""

APART = 0.6
"""Least distance of the word at a pole from other words above the axes [in]: a limit or change point is its reason."""

ZERO = Pen(0.6, SOFT, layer=1)
PLACE = Mark(size=2.2, face=PAPER, width=0.6)

GRID, RIM = Pen(0.5, SOFT, layer=1), Pen(0.9, SOFT, layer=1)

MOST_CIRCLES = 5

RAYS = 30
"""Angle between the rays [deg]."""

SMALL = 0.9
"""Radius [in] below which only the axes and the outer circle have numbers."""


def with_panels(picture: Picture, graphs: Sequence[CurveGraph]) -> Picture | Sheet:
    """Return a picture with graphs below it."""
    width = max(picture.frame.width, LEAST_WIDTH)
    return Sheet("", (picture, *(panel(graph, width) for graph in graphs))) if graphs else picture


def history_sheet(graphs: Sequence[CurveGraph], title: str) -> Sheet:
    """Return the pictures of graphs one above the other, under a title."""
    return Sheet(title, tuple(panel(graph, WIDEST) for graph in graphs))


def panel(graph: CurveGraph, width: float) -> Picture:
    """Return the picture of a graph; `width` is that of the axes [in]."""
    if graph.form == POLAR:
        return polar_picture(graph)
    if graph.form == EQUAL:
        return _equal_axes(graph)
    low, high = _with_margin(*_values(graph))
    left, right = _abscissa_limits(graph)
    picture = Picture("", Frame(complex(left, low), complex(right, high), width, HEIGHT), _labels(graph))
    _draw_zero(picture)
    for place, word in graph.verticals:
        if left <= place <= right:
            picture.draw(VERTICAL, [complex(place, low), complex(place, high)])
            picture.above.append((place, word))
    _draw_curves(picture, graph)
    return picture


@composition
def _equal_axes(graph: CurveGraph, *, layout: PictureLayout = LAYOUT) -> Picture:
    """Return a graph whose axes have one scale; the first row is marked."""
    shown = _shown(graph)
    left, right = value_window(np.asarray(c.x, dtype=np.float64) for c in shown)
    low, high = value_window(np.asarray(c.y, dtype=np.float64) for c in shown)
    corners = [complex(left, low), complex(right, high), *([0.0j] if graph.origin else [])]
    picture = Picture("", Frame.around(np.array(corners), layout), _labels(graph))
    _draw_zero(picture, upright=True)
    _draw_curves(picture, graph)
    _draw_marks(picture, graph.marks)
    starts = [z[np.isfinite(z)][:1] for z in (curve.places for curve in shown)]
    picture.draw(DOT, *np.concatenate([*starts, np.zeros(0)]).tolist(), key="start")
    return picture


def _draw_zero(picture: Picture, upright: bool = False) -> None:
    """Draw the line on which the values are zero, and an `upright` one."""
    low, high = picture.frame.low, picture.frame.high
    if low.imag < 0.0 < high.imag:
        picture.draw(ZERO, [complex(low.real, 0.0), complex(high.real, 0.0)])
    if upright and low.real < 0.0 < high.real:
        picture.draw(ZERO, [complex(0.0, low.imag), complex(0.0, high.imag)])


def _draw_marks(picture: Picture, marks: Sequence[PlaceMark]) -> None:
    """Mark places on the curves, with texts beside the curve on the side away from their middle."""
    if not marks:
        return
    middle = complex(np.mean([mark.place for mark in marks]))
    away = 9.0 * picture.frame.point * picture.frame.font
    for mark in marks:
        side = mark.place - middle
        normal = mark.normal or side or 1j
        outwards = normal if (normal.conjugate() * side).real >= 0.0 else -normal
        wide = 1.0 + 0.5 * abs(outwards.real) / abs(outwards)  # a text is wider than high
        picture.texts.append(Text(mark.place + wide * away * outwards / abs(outwards), mark.text, 7.0, halo=True))
    picture.draw(PLACE, *(mark.place for mark in marks))


def _shown(graph: CurveGraph) -> Sequence[Curve]:
    return graph.curves[:MOST_CURVES]


def _values(graph: CurveGraph) -> tuple[float, float]:
    """Return the range of the values that are shown."""
    curves, places = _shown(graph), [place for place, _ in graph.verticals]
    beside = [np.array([_row(curve.x, place) for place in places]) for curve in curves if len(curve.x)]
    return value_window([np.asarray(c.y, dtype=np.float64) for c in curves if len(c.x)], beside)


def _row(x: FloatArray, place: float) -> float:
    """Return the row of an abscissa, with the fraction between it and the next one."""
    k = int(np.argmin(np.where(np.isfinite(x), np.abs(x - place), np.inf)))
    steps = {side: x[k + side] - x[k] for side in (-1, 1) if 0 <= k + side < len(x)}
    return k + next((side * (place - x[k]) / step for side, step in steps.items() if (place - x[k]) * step > 0.0), 0.0)


def _labels(graph: CurveGraph) -> tuple[str, str]:
    """Return the labels of the axes; the name of a single curve is on the axis."""
    up, curves = graph.up, graph.curves
    alone = curves[0].name if len(curves) == 1 else ""
    name = f"{up.name} of {alone}" if alone and alone != up.name else up.name
    return labelled(graph.across.name, graph.across.unit), labelled(name, up.unit)


def _draw_curves(picture: Picture, graph: CurveGraph) -> None:
    """Draw the curves of a graph, its events, and the legend."""
    for index, curve in enumerate(_shown(graph)):
        z = curve.places
        picture.draw_runs(curve_pen(index), pieces(z, _jumps(z, picture.frame)))
        if len(graph.curves) > 1:
            picture.legend.append((curve.name, curve_pen(index)))
        _mark_cut(picture, curve.name, z, graph)
    if len(graph.curves) > MOST_CURVES:
        picture.legend.append((f"and {len(graph.curves) - MOST_CURVES} more: name the columns", Pen(0.0)))
    for index, (kind, places) in enumerate(graph.events.items()):
        picture.draw(event_mark(index), *places, key=kind)


def _mark_cut(picture: Picture, name: str, z: ComplexArray, graph: CurveGraph) -> None:
    """Mark where a curve leaves the axes, with the reason; state its greatest magnitude in the legend."""
    low, high = picture.frame.low.imag, picture.frame.high.imag
    with np.errstate(invalid="ignore"):
        beyond = np.isfinite(z.real) & ~np.isnan(z.imag) & ((z.imag < low) | (z.imag > high))
    if not beyond.any():
        return
    first = np.flatnonzero(beyond & ~np.append(False, beyond[:-1]))
    edge, above = 0.02 * (high - low), picture.frame.width / (picture.frame.high.real - picture.frame.low.real)
    picture.draw(CUT, *(complex(z[k].real, high - edge if z[k].imag > high else low + edge) for k in first))
    for place in z.real[first]:
        if all(abs(place - other) * above > APART for other, _ in picture.above):
            picture.above.append((float(place), "pole"))
    most = z.imag[beyond][np.argmax(np.abs(z.imag[beyond]))]
    picture.legend.append((f"cut at a pole: {name} up to {short(most)} {graph.up.unit}".rstrip(), CUT))


def _jumps(z: ComplexArray, frame: Frame) -> list[int]:
    """Return the rows before which a curve jumps from one infinite value to the other."""
    span = frame.high.imag - frame.low.imag
    with np.errstate(all="ignore"):
        jump = (np.abs(np.diff(z.imag)) > span) & (z.imag[1:] * z.imag[:-1] < 0.0)
    return (np.flatnonzero(jump) + 1).tolist()


def _with_margin(low: float, high: float) -> tuple[float, float]:
    margin = 0.06 * (high - low)
    if margin <= 1e-9 * max(abs(low), abs(high)):  # constant up to rounding errors
        margin = 0.1 * max(abs(low), abs(high)) or 1.0
    return low - margin, high + margin


def _abscissa_limits(graph: CurveGraph) -> tuple[float, float]:
    """Return the range of the abscissa over which there are values, up to the limits beside it."""
    every = [np.asarray(curve.x, dtype=np.float64) for curve in graph.curves]
    known = [x[np.isfinite(x) & np.isfinite(c.y)] for x, c in zip(every, graph.curves, strict=True)]
    x = np.concatenate([*known, np.zeros(0)])
    if not len(x):
        x = np.concatenate([*(x[np.isfinite(x)] for x in every), np.zeros(0)])
    low, high = (float(x.min()), float(x.max())) if len(x) else (0.0, 1.0)
    near = max((float(np.nanmax(np.abs(np.diff(x)), initial=0.0)) for x in every if len(x) > 1), default=0.0)
    beside = [place for place, _ in graph.verticals if low - near <= place <= high + near]
    low, high = min([low, *beside]), max([high, *beside])
    return (low, high) if high > low else (low - 0.5, low + 0.5)


@composition
def polar_picture(graph: CurveGraph, *, layout: PictureLayout = LAYOUT) -> Picture:
    """Return the polar diagram of a graph, with circles at round radii and a ray every 30 degrees."""
    curves = graph.curves[:MOST_CURVES]
    _, greatest = value_window(np.abs(curve.y) for curve in curves)
    step = round_above(greatest / MOST_CIRCLES)
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
        picture.draw(curve_pen(index), *(run for run in pieces(z) if len(run) > 1))
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
    picture.draw(GRID, *(radius * circle for radius in radii[:-1]))
    picture.draw(RIM, rim * circle)
    small = rim < SMALL * 72.0 * picture.frame.point * picture.frame.font
    for degrees in range(0, 360, RAYS):
        ray = complex(np.exp(1j * math.radians(degrees)))
        picture.draw(GRID, [0.0j, rim * ray])
        if not small or degrees % 90 == 0:
            picture.texts.append(Text(1.07 * rim * ray, f"{degrees}°"))
    middle = complex(np.exp(1j * math.radians(0.5 * RAYS)))
    texts = tick_texts(radii * factor)
    for radius, text in list(zip(radii, texts, strict=True))[-1 if small else 0 :]:
        picture.texts.append(Text((radius - 0.04 * rim) * middle, text))
