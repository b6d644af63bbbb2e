"""Graphs below a drawing: one quantity each, over the input or the time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.output.picture import Frame, Picture, Sheet
from gimcli.output.style import SOFT, Mark, Pen, curve_pen
from gimcli.table import Column, Table, labelled

HEIGHT, LEAST_WIDTH = 1.55, 4.4
"""Size of a panel's axes [in]."""

MOST_CURVES = 12
"""Largest number of curves in a panel."""

REST, PEAK, BEYOND = 0.1, 12.0, 2.0
"""A spread is the range of the values without the part REST at either end. If the full range is more than PEAK spreads,
the window ends BEYOND spreads from that range."""

ZERO = Pen(0.6, SOFT, layer=1)


def with_panels(picture: Picture, panels: Mapping[str, Table]) -> Picture | Sheet:
    """Return a picture with a panel below it for each table; the first column of a table is the abscissa."""
    width = max(picture.frame.width, LEAST_WIDTH)
    below = [panel(name, table, width) for name, table in panels.items()]
    return Sheet("", (picture, *below)) if below else picture


def panel(name: str, table: Table, width: float, peaks: bool = False) -> Picture:
    """Return a graph of a table's columns over its first column; `peaks` shows all values, also short peaks."""
    across, curves = table.columns[0], table.columns[1 : 1 + MOST_CURVES]
    x = np.asarray(across.values, dtype=np.float64)
    low, high = _window([np.asarray(c.values, dtype=np.float64) for c in curves], peaks)
    left, right = _limits(x)
    frame = Frame(complex(left, low), complex(right, high), width, HEIGHT)
    unit = curves[0].unit if curves else ""
    picture = Picture("", frame, (labelled(across.name, across.unit), labelled(name, unit)))
    if low < 0.0 < high:
        picture.stroke(ZERO, [complex(left, 0.0), complex(right, 0.0)])
    for index, column in enumerate(curves):
        _draw(picture, index, x, column)
    if len(table.columns) - 1 > MOST_CURVES:
        picture.legend.append((f"and {len(table.columns) - 1 - MOST_CURVES} more", Pen(0.0)))
    return picture


def _draw(picture: Picture, index: int, x: FloatArray, column: Column) -> None:
    pen, span = curve_pen(index), picture.frame.high.imag - picture.frame.low.imag
    z = x.astype(np.complex128)
    z.imag = column.values
    runs = list(_runs(z, span))
    picture.stroke(pen, *(run for run in runs if len(run) > 1))
    picture.mark(Mark("o", 2.0, pen.color, pen.color), *(complex(run[0]) for run in runs if len(run) == 1))
    if column.name:
        picture.legend.append((column.name, pen))


def _runs(z: ComplexArray, span: float) -> Iterable[ComplexArray]:
    """Yield the pieces of a curve between its gaps, and between jumps from one infinite value to the other."""
    gap = ~np.isfinite(z)
    with np.errstate(all="ignore"):
        jump = (np.abs(np.diff(z.imag)) > span) & (z.imag[1:] * z.imag[:-1] < 0.0)
    cuts = np.flatnonzero(gap[1:] | gap[:-1] | jump) + 1
    return (run for run in np.split(z, cuts) if len(run) and np.all(np.isfinite(run)))


def _window(columns: list[FloatArray], peaks: bool = False) -> tuple[float, float]:
    """Return limits that show the columns; peaks of only a few values are cut, except with `peaks`."""
    y = np.concatenate([*columns, np.zeros(0)])
    y = y[np.isfinite(y)]
    if not len(y):
        return 0.0, 1.0
    low, high = float(y.min()), float(y.max())
    inner = np.quantile(y, [REST, 1.0 - REST])
    spread = float(inner[1] - inner[0])
    if not peaks and 0.0 < PEAK * spread < high - low:
        low, high = max(low, float(inner[0]) - BEYOND * spread), min(high, float(inner[1]) + BEYOND * spread)
    margin = 0.06 * (high - low)
    if margin <= 1e-9 * max(abs(low), abs(high)):  # constant up to rounding errors
        margin = 0.1 * max(abs(low), abs(high)) or 1.0
    return low - margin, high + margin


def _limits(x: NDArray[np.float64]) -> tuple[float, float]:
    finite = x[np.isfinite(x)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    return (low, high) if high > low else (low - 0.5, low + 0.5)
