"""Place names where they hide no lines and no other names."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray
from gimcli.output.picture import Picture, Text
from gimcli.output.style import FONT, INK

LETTER = 0.64
"""Width of a letter relative to its size."""

CLEAR = 1.3
"""Free border of a text [pt]."""

DENSITY = 2.0
"""Spacing of the samples of a line [pt]."""


class Labels:
    """Places texts one after another; each avoids the lines and the earlier texts."""

    def __init__(self, picture: Picture) -> None:
        self._picture = picture
        self._lines = _samples(picture)
        self._boxes = np.zeros((0, 4))  # (texts, left right bottom top)

    def beside(self, place: complex, text: str, color: str = INK, size: float = FONT) -> None:
        """Write a text as close to a place as possible."""
        turns = np.exp(1j * np.radians(np.arange(30.0, 390.0, 22.5)))
        width, height = _extent(text, size)
        steps = [
            distance * turns + 0.5 * width * turns.real + 0.5j * height * turns.imag
            for distance in (5.0, 8.0, 12.0, 17.0, 23.0, 30.0)
        ]
        offers = place + np.concatenate(steps) * self._picture.frame.point
        self.at_best(offers, text, color, size)

    def at_best(
        self, offers: NDArray[Any], text: str, color: str = INK, size: float = FONT, ring: bool = False
    ) -> None:
        """Write a text at the best of some places, the first of equal ones; `ring` draws a circle around it."""
        width, height = _extent(text, size)
        if ring:
            width = height = max(width, height) + 0.45 * size
        half = 0.5 * complex(width, height) * self._picture.frame.point
        low, high = offers - half, offers + half
        boxes = np.column_stack((low.real, high.real, low.imag, high.imag))
        best = int(np.argmin(self._cost(boxes, ring)))
        self._boxes = np.vstack((self._boxes, boxes[best]))
        self._picture.texts.append(Text(complex(offers[best]), text, size, color, ring))

    def _cost(self, boxes: NDArray[np.float64], ring: bool) -> NDArray[np.float64]:
        """Return the cost of each box: high for hidden texts, then outside the border, then for hidden lines.

        Rings may be on lines.
        """
        low, high = self._picture.frame.low, self._picture.frame.high
        outside = (boxes[:, 0] < low.real) | (boxes[:, 1] > high.real)
        outside |= (boxes[:, 2] < low.imag) | (boxes[:, 3] > high.imag)
        hidden = _overlaps(boxes, self._boxes)
        lines = 0.0 if ring else 4.0 * _inside(boxes, self._lines)
        return 1000.0 * hidden + 300.0 * outside + lines + 0.05 * np.arange(len(boxes))


def _extent(text: str, size: float) -> tuple[float, float]:
    return LETTER * size * max(1, len(text)) + 2 * CLEAR, size + 2 * CLEAR


def _overlaps(boxes: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return for each box the number of other boxes that it overlaps."""
    a, b = boxes[:, None, :], others[None, :, :]
    aside = (a[..., 0] >= b[..., 1]) | (a[..., 1] <= b[..., 0])
    above = (a[..., 2] >= b[..., 3]) | (a[..., 3] <= b[..., 2])
    return np.asarray(np.sum(~(aside | above), axis=1), dtype=np.float64)


def _inside(boxes: NDArray[np.float64], z: ComplexArray) -> NDArray[np.float64]:
    """Return for each box the number of points in it."""
    across = (z.real > boxes[:, :1]) & (z.real < boxes[:, 1:2])
    upward = (z.imag > boxes[:, 2:3]) & (z.imag < boxes[:, 3:])
    return np.asarray(np.sum(across & upward, axis=1), dtype=np.float64)


def _samples(picture: Picture) -> ComplexArray:
    """Return points along all lines, outlines and marks of a picture, in steps of `DENSITY`."""
    step = DENSITY * picture.frame.point
    paths = [path for group in picture.strokes.values() for path in group]
    paths += [np.append(area, area[:1]) for group in picture.areas.values() for area in group]
    marks = [np.array(group) for group in picture.marks.values()]
    pieces = [_along(path, step) for path in paths if len(path) > 1]
    return np.concatenate([*pieces, *marks, np.zeros(0, dtype=np.complex128)])


def _along(path: ComplexArray, step: float) -> ComplexArray:
    finite = path[np.isfinite(path)]
    if len(finite) > 60:  # the points of a curve are already close together
        return finite[:: max(1, len(finite) // 600)]
    lengths = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(finite)))))
    if len(finite) == 0 or lengths[-1] == 0.0:
        return finite
    at = np.linspace(0.0, lengths[-1], min(400, 2 + int(lengths[-1] / step)))
    return np.interp(at, lengths, finite.real) + 1j * np.interp(at, lengths, finite.imag)
