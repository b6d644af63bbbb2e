"""The picture of time and accuracy: one curve for each method, and the efficient front."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.output.picture import HIGHEST, WIDEST, Frame, Picture, Sheet
from gimcli.output.style import PAPER, Mark, Pen, curve_pen

SHAPES = ("o", "s", "^", "D", "v", "P", "X")
"""Shapes of the marks of the methods."""

FRONT, ON_FRONT = Pen(7.0, "#d2d2d2", layer=1), Mark("o", 12.0, "#d2d2d2", "#d2d2d2", layer=1)

MICROSECONDS = 6.0
"""Decimal logarithm of the microseconds in a second."""


def tradeoff_sheet(curves: Mapping[str, FloatArray], front: FloatArray, title: str, steps: int) -> Sheet:
    """Return the error over the time of a position, and over that of a call of `steps` steps.

    `curves` are arrays (tolerances, 4) of both times [s], error and whether all positions were solved, by method;
    front: those of the efficient entries (entries, 3).
    """
    parts = [{name: one[:, [k, 2, 3]] for name, one in curves.items()} for k in (0, 1)]
    upper = tradeoff_picture(parts[0], front[:, [0, 2]], "time of a position [µs]")
    lower = tradeoff_picture(parts[1], front[:0, 1:], f"time of a call of {steps} steps [µs]")
    lower.legend.clear()  # that of the upper one
    return Sheet(title, (upper, lower))


def tradeoff_picture(curves: Mapping[str, FloatArray], front: FloatArray, label: str) -> Picture:
    """Return the error over the time, both logarithmic; hollow marks: not all positions were solved.

    `curves` are arrays (tolerances, 3) of time [s], error and whether all positions were solved, by method.
    """
    places = {name: _place(points) for name, points in curves.items()}
    labels = (label, "largest true error of a traced point / size of the mechanism")
    picture = Picture("", _window(list(places.values())), labels, logarithmic=True, logarithmic_x=True)
    efficient = _place(front)
    efficient = efficient[np.argsort(efficient.real)]
    picture.draw(FRONT, efficient)
    picture.draw(ON_FRONT, *efficient.tolist())
    for index, (name, points) in enumerate(curves.items()):
        _draw_method(picture, index, name, places[name], points[:, 2] == 1.0)
    picture.legend.append(("efficient front", (FRONT, ON_FRONT)))
    if any(np.any(points[:, 2] != 1.0) for points in curves.values()):
        picture.legend.append(("hollow: positions missing", Mark(SHAPES[0], 5.0, PAPER)))
    return picture


def _draw_method(picture: Picture, index: int, name: str, places: ComplexArray, whole: np.ndarray) -> None:
    pen, shape = curve_pen(index), SHAPES[index % len(SHAPES)]
    full = Mark(shape, 5.0, pen.color, pen.color, 0.8)
    picture.draw(pen, places)
    picture.draw(full, *places[whole].tolist())
    picture.draw(Mark(shape, 5.0, PAPER, pen.color, 1.0), *places[~whole].tolist())
    picture.legend.append((name, (pen, full)))


def _place(points: FloatArray) -> ComplexArray:
    """Return log10(time) + i log10(error) of points (points, 2 or 3); 0 is replaced by the smallest float."""
    least = float(np.finfo(float).tiny)
    seconds, error = (np.log10(np.maximum(points[:, k], least)) for k in (0, 1))
    return np.asarray(seconds + MICROSECONDS + 1j * error)


def _window(curves: list[ComplexArray]) -> Frame:
    """Return a window from one power of ten to another, with some space around the marks."""
    z = np.concatenate([*curves, np.zeros(0, dtype=complex)])
    z = z if len(z) else np.array([0.0j, 2.0 - 16.0j])
    low = complex(np.floor(z.real.min() - 0.05), np.floor(z.imag.min() - 0.2))
    high = complex(np.ceil(z.real.max() + 0.05), np.ceil(z.imag.max() + 0.2))
    return Frame(low, high, WIDEST, 0.8 * HIGHEST)
