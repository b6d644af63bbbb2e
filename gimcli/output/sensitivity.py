"""Pictures of sensitivities: bars at one position; values, bands of the tolerances and derivatives over a motion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from gimcli.mechanism import FloatArray
from gimcli.output.curves import pieces
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.output.panels import panel
from gimcli.output.picture import WIDEST, Frame, Picture, Sheet, Text, rectangle
from gimcli.output.style import INK, PALETTE, PAPER, Fill, Pen, tint
from gimcli.table import Column

ROW, BAR = 0.24, 0.13
"""Height of a line of the bar chart and of its bar [in]."""

NAMES, VALUES = 0.34, 0.22
"""Parts of the width for the names and for the values."""

MOST_BARS = 24
MOST_GRAPHS = 4
"""Largest number of quantities that are drawn."""

POSITIVE, NEGATIVE = Fill(PALETTE[1], PALETTE[1], 0.5), Fill(PAPER, PALETTE[1], 1.0)
BANDS = {
    "worst": ("worst case", Fill(tint(PALETTE[1]), tint(PALETTE[1]), 0.3, layer=1)),
    "rss": ("root of the sum of squares (RSS)", Fill("#b9cfe8", "#b9cfe8", 0.3, layer=1.5)),
}
SAMPLED = "three standard deviations of random designs"


class BarLine(NamedTuple):
    """A line of a bar chart."""

    name: str
    value: float
    text: str  # the value with its unit
    unit: str


class Band(NamedTuple):
    """A quantity over a motion, its derivatives (unit, rows) by dimension, and the half widths of its bands."""

    name: str
    unit: str
    values: FloatArray  # (rows,)
    slopes: Mapping[str, tuple[str, FloatArray]]
    spreads: Mapping[str, FloatArray]


def bar_chart(title: str, charts: Mapping[str, Sequence[BarLine]]) -> Sheet:
    """Return one chart for each quantity; values in other units than that of most bars have no bar."""
    return Sheet(title, tuple(_bars(name, lines) for name, lines in list(charts.items())[:MOST_GRAPHS]))


def _bars(title: str, lines: Sequence[BarLine]) -> Picture:
    """Return the bars of one quantity, the first line on top; data units are inches."""
    shown = lines[:MOST_BARS]
    height = ROW * (len(shown) + 1)
    picture = Picture(title, Frame(0j, complex(WIDEST, height), WIDEST, height), bare=True)
    common = Counter(line.unit for line in shown).most_common(1)[0][0]
    most = max((abs(line.value) for line in shown if line.unit == common), default=0.0) or 1.0
    left, room = NAMES * WIDEST, (1.0 - NAMES - VALUES) * WIDEST
    for k, line in enumerate(shown):
        middle = height - ROW * (k + 0.8)
        picture.texts.append(Text(complex(0.0, middle), line.name, begins=True))
        end = left + (room * abs(line.value) / most if line.unit == common else 0.0)
        if end > left:
            picture.draw(
                POSITIVE if line.value > 0.0 else NEGATIVE,
                rectangle(complex((left + end) / 2, middle), complex(end - left, BAR) / 2),
            )
        picture.texts.append(Text(complex(end + 0.08, middle), line.text, begins=True))
    picture.draw(Pen(0.8, INK), [complex(left, 0.0), complex(left, height)])
    if len(lines) > len(shown):
        picture.legend.append((f"and {len(lines) - len(shown)} smaller ones", Pen(0.0)))
    return picture


def sensitivity_graphs(title: str, abscissa: Column, bands: Sequence[Band]) -> Sheet:
    """Return for each quantity its value, the bands of its tolerances if there are any, and its derivatives."""
    panels = [one for band in bands[:MOST_GRAPHS] for one in _panels(abscissa, band)]
    return Sheet(title, tuple(panels))


def _panels(abscissa: Column, band: Band) -> list[Picture]:
    across, x = Axis(abscissa.name, abscissa.unit), abscissa.values
    value = panel(CurveGraph(across, Axis(band.name, band.unit), [Curve(band.name, x, band.values)]), WIDEST)
    found = [value]
    if band.spreads:
        found.append(_deviation(across, x, band))
        _draw_bands(value, x, band.values, band.spreads)
    units = Counter(unit for unit, _ in band.slopes.values()).most_common()
    for unit, _ in units:
        own = {name: rows for name, (of, rows) in band.slopes.items() if of == unit and np.nanmax(np.abs(rows)) > 0.0}
        curves = [Curve(name, x, rows) for name, rows in own.items()]
        if curves:
            label = f"derivative of {band.name}" if len(curves) > 1 else f"{band.name} by {curves[0].name}"
            curves = curves if len(curves) > 1 else [Curve(label, x, curves[0].y)]
            found.append(panel(CurveGraph(across, Axis(label, unit), curves), WIDEST))
    return found


def _deviation(across: Axis, x: FloatArray, band: Band) -> Picture:
    """Return the bands around zero."""
    both = np.concatenate([x, [np.nan], x])
    curves = []
    for label, rows in band.spreads.items():
        name, factor = (SAMPLED, 3.0) if label == "sampled_sd" else (BANDS[label][0], 1.0)
        curves.append(Curve(name, both, factor * np.concatenate([rows, [np.nan], -rows])))
    chart = panel(CurveGraph(across, Axis(f"tolerance of {band.name}", band.unit), curves), WIDEST)
    _draw_bands(chart, x, np.zeros_like(x), band.spreads)
    return chart


def _draw_bands(chart: Picture, x: FloatArray, middle: FloatArray, spreads: Mapping[str, FloatArray]) -> None:
    for label, (_, fill) in BANDS.items():
        if label in spreads:
            chart.draw(fill, *_outlines(x, middle, spreads[label]))


def _outlines(x: FloatArray, middle: FloatArray, half: FloatArray) -> list[FloatArray]:
    """Return the outline of each piece of a band between its gaps."""
    known = np.isfinite(middle) & np.isfinite(half)
    found = []
    for rows in (run.real.astype(int) for run in pieces(np.where(known, np.arange(len(x)), np.nan)) if len(run) > 1):
        upper, lower = (x[rows] + 1j * (middle[rows] + sign * half[rows]) for sign in (1.0, -1.0))
        found.append(np.concatenate([upper, lower[::-1]]))
    return found
