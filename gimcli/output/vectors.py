"""Velocities and accelerations at one pose as arrows, each kind with its own scale bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import ComplexArray
from gimcli.output.labels import extent
from gimcli.output.picture import Picture, Text
from gimcli.output.style import FONT, LONGEST_VECTOR, Fill, Pen
from gimcli.output.symbols import arrow_lines
from gimcli.rounding import round_below

NOTHING = 1e-9
"""Vectors below this part of the largest one, or of the drawing's longer side per second, are not drawn."""

SHORT, HEAD = 5.0, 7.0
"""Length of an arrow [pt] below which it is drawn without a head, and size of the heads of long arrows."""

BAR = 0.1
"""Distance of the scale bars, relative to the longer side of the drawing."""

PENS = (Pen(1.5, "#20508c", layer=9), Pen(1.2, "#a50f15", (4.0, 2.0), layer=9))
HEADS = (Fill("#20508c", "#20508c", 0.3, layer=9), Fill("white", "#a50f15", 0.9, layer=9))


@dataclass(frozen=True)
class Arrows:
    """One kind of vectors at places, in the file's units."""

    name: str
    unit: str
    vectors: Mapping[str, tuple[complex, complex]]  # place and vector, by the name of the point

    @property
    def greatest(self) -> float:
        """The largest magnitude."""
        return max((abs(vector) for _, vector in self.vectors.values()), default=0.0)


class Field:
    """Arrows of one or more kinds, and their scales."""

    def __init__(self, kinds: Sequence[Arrows], shown: ComplexArray) -> None:
        z = shown[np.isfinite(shown)] if np.isfinite(shown).any() else np.zeros(1, dtype=complex)
        self.corner = complex(z.real.min(), z.imag.min())
        self.side = max(float(np.ptp(z.real)), float(np.ptp(z.imag)))
        self.kinds = [kind for kind in kinds if kind.greatest > NOTHING * self.side]

    def scale(self, kind: Arrows) -> float:
        """Return the length of an arrow for one unit of its vector."""
        return LONGEST_VECTOR * self.side / kind.greatest

    def extent(self) -> ComplexArray:
        """Return the tips of the arrows and the ends of the scale bars."""
        tips = [z + self.scale(kind) * v for kind in self.kinds for z, v in kind.vectors.values()]
        low = min([self.corner.imag, *(tip.imag for tip in tips)])
        self.corner = complex(self.corner.real, low)
        bars = [self._bar(k, kind)[0] for k, kind in enumerate(self.kinds)]
        return np.array([*tips, *(end for bar in bars for end in bar)], dtype=np.complex128)

    def _bar(self, row: int, kind: Arrows) -> tuple[tuple[complex, complex], float]:
        """Return the ends of a scale bar and the round value of its length."""
        value = round_below(kind.greatest)
        start = self.corner - 1j * BAR * self.side * (row + 1)
        return (start, start + self.scale(kind) * value), value

    def draw(self, picture: Picture) -> None:
        """Draw the arrows and the scale bars."""
        for row, kind in enumerate(self.kinds):
            pen, head = PENS[row % len(PENS)], HEADS[row % len(HEADS)]
            for z, v in kind.vectors.values():
                _arrow(picture, z, self.scale(kind) * v, pen, head, kind.greatest * NOTHING < abs(v))
            (start, end), value = self._bar(row, kind)
            _arrow(picture, start, end - start, pen, head, True)
            picture.texts.append(_beside(picture, end, f"{kind.name} {value:g} {kind.unit}"))


def _beside(picture: Picture, end: complex, text: str) -> Text:
    """Return the text behind the end of a scale bar, as small as the room requires."""
    frame = picture.frame
    at = end + 6.0 * frame.point
    room = (frame.high.real - at.real) / frame.point / extent(text, FONT * frame.font)[0]
    return Text(at, text, FONT * max(0.4, min(1.0, room)), begins=True)


def _arrow(picture: Picture, start: complex, vector: complex, pen: Pen, head: Fill, visible: bool) -> None:
    if not visible or not np.isfinite(vector):
        return
    length = abs(vector) / picture.frame.point
    path = np.array([start, start + vector])
    if length >= SHORT:
        path, tip = arrow_lines(path, min(HEAD, length) * picture.frame.point)
        picture.draw(head, tip)
    picture.draw(pen, path)
