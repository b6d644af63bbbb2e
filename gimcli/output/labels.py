"""Place names beside their nodes: without overlap, near, and over as few lines as possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gimcli.canonical import first_least
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray
from gimcli.output.picture import Picture, Text
from gimcli.output.style import FONT, INK, LEADER, PAPER, Fill, Pen

LETTERS = {"ijlI|'.,:; ": 0.33, "frtJ()[]-": 0.42, "mMW@%": 1.0, "wOQGHN": 0.82}
"""Widths of letters relative to their size."""

LETTER, CAPITAL, WIDE = 0.64, 0.74, 1.05
"""Width of the other letters, of capitals, and of letters of scripts with wide letters."""

CLEAR = 1.3
"""Free border of a text [pt]."""

NEAR = (4.5, 6.5, 9.0, 11.0)
"""Distances of a text from its node [pt], in the order of preference."""

FAR = (18.0, 24.0, 32.0, 42.0, 54.0, 70.0, 90.0, 115.0)
"""Distances of texts that a thin line joins to their node [pt], for crowded places."""

TURNS = np.exp(1j * np.radians(np.arange(30.0, 390.0, 22.5)))
"""Directions in which a text may be beside its node, in the order of preference."""

DENSITY = 2.0
"""Spacing of the samples of a line [pt]."""

SAME = 1e-6
"""Difference of costs below which offers are equal."""

HIDDEN, OUTSIDE, LEADING, DISTANCE, TURN = 1000.0, 300.0, 25.0, 0.9, 0.03
"""Cost of an overlap with another text, of crossing the border, of a leader, of a point of distance, of a direction."""

PALE = 0.2
"""Cost of a sample of a light line; that of a dark one is 1."""

THICK, TWICE = 1.8, 2.0
"""Lines from this width [pt] on cost more, by this factor."""

MARK = 3.0
"""Cost of a sample of the edge of a mark."""

SWEEPS = 6
"""Largest number of rounds in which texts give way to each other."""


@dataclass(frozen=True)
class _Request:
    """A text to place: centres of its box in the order of preference, with their costs."""

    text: Text  # at its node
    half: complex  # half width and height of its box, data
    offers: ComplexArray
    cost: FloatArray
    leads: BoolArray  # the offers that need a leader


class Labels:
    """Collects texts and writes them together; each avoids the lines and the other texts."""

    def __init__(self, picture: Picture) -> None:
        self._picture = picture
        self._requests: list[_Request] = []

    def beside(self, place: complex, text: str, color: str = INK, size: float = FONT) -> None:
        """Request a text beside a place."""
        half, pt = self._half(text, size), self._picture.frame.point
        aside = np.clip(1.6 * TURNS.real, -1, 1) * half.real + 1j * np.clip(1.6 * TURNS.imag, -1, 1) * half.imag
        steps = (*NEAR, *FAR)
        offers = np.concatenate([place + aside + distance * pt * TURNS for distance in steps])
        away = [DISTANCE * (distance - NEAR[0]) + LEADING * (distance in FAR) for distance in steps]
        cost = np.add.outer(away, TURN * np.arange(len(TURNS))).ravel()
        leads = np.repeat([distance in FAR for distance in steps], len(TURNS))
        self._requests.append(_Request(Text(place, text, size, color), half, offers, cost, leads))

    def at_best(self, offers: ComplexArray, text: str, color: str = INK, size: float = FONT) -> None:
        """Request a text in a ring at one of some places, in the order of preference; it may cover lines."""
        half = self._half(text, size)
        round_half = (max(half.real, half.imag) + 0.22 * size * self._picture.frame.point) * (1 + 1j)
        cost = DISTANCE * np.arange(len(offers), dtype=np.float64)
        leads = np.zeros(len(offers), dtype=bool)
        self._requests.append(
            _Request(Text(0j, text, size, color, ring=True), round_half, np.asarray(offers), cost, leads)
        )

    def write(self) -> None:
        """Place the texts and add them to the picture."""
        if not self._requests:
            return
        ground = _Ground(self._picture)
        costs = [one.cost + ground.cost(one) for one in self._requests]
        chosen = _settled(self._requests, costs, ground.taken)
        for one, best in zip(self._requests, chosen, strict=True):
            at = complex(one.offers[best])
            halo = not one.text.ring and bool(ground.lines(np.array([at]), one.half)[0])
            self._picture.texts.append(replace(one.text, at=at, halo=halo))
            if one.leads[best]:
                self._lead(one.text.at, at, one.half)
        self._requests = []

    def _half(self, text: str, size: float) -> complex:
        """Return half the width and height of a text's box, in data units."""
        size *= self._picture.frame.font
        return complex(*(0.5 * side * self._picture.frame.point for side in extent(text, size)))

    def _lead(self, place: complex, at: complex, half: complex) -> None:
        """Draw a thin line from a node to the box of its text."""
        pt, corner = self._picture.frame.point, at - place
        end = complex(
            np.clip(0.0, corner.real - half.real, corner.real + half.real),
            np.clip(0.0, corner.imag - half.imag, corner.imag + half.imag),
        )
        if abs(end) > 4.0 * pt:
            with self._picture.named("leaders"):
                self._picture.draw(LEADER, [place + 4.0 * pt * end / abs(end), place + end])


def extent(text: str, size: float) -> tuple[float, float]:
    """Return the width and height [pt] that a text of a size needs."""
    return size * max(0.5, sum(map(_letter, text))) + 2 * CLEAR, size + 2 * CLEAR


def _letter(letter: str) -> float:
    usual = WIDE if ord(letter) >= 0x2E80 else CAPITAL if letter.isupper() else LETTER
    return next((width for letters, width in LETTERS.items() if letter in letters), usual)


def _settled(requests: Sequence[_Request], costs: Sequence[FloatArray], taken: FloatArray) -> list[int]:
    """Return the offer of each request: the cheapest one; texts that overlap give way until none changes."""
    boxes = [_boxes(one.offers, one.half) for one in requests]
    costs = [cost + HIDDEN * _overlaps(own, taken) for cost, own in zip(costs, boxes, strict=True)]
    chosen = [first_least(cost, SAME) for cost in costs]
    for _ in range(SWEEPS):
        before = list(chosen)
        for k, cost in enumerate(costs):
            others = np.array([boxes[j][chosen[j]] for j in range(len(requests)) if j != k]).reshape(-1, 4)
            chosen[k] = first_least(cost + HIDDEN * _overlaps(boxes[k], others), SAME)
        if chosen == before:
            break
    return chosen


def _boxes(centres: ComplexArray, half: complex) -> FloatArray:
    """Return left, right, bottom, top (centres, 4)."""
    low, high = centres - half, centres + half
    return np.column_stack((low.real, high.real, low.imag, high.imag))


def _overlaps(boxes: FloatArray, others: FloatArray) -> FloatArray:
    """Return for each box the number of other boxes that it overlaps."""
    a, b = boxes[:, None, :], others[None, :, :]
    aside = (a[..., 0] >= b[..., 1]) | (a[..., 1] <= b[..., 0])
    above = (a[..., 2] >= b[..., 3]) | (a[..., 3] <= b[..., 2])
    return np.asarray(np.sum(~(aside | above), axis=1), dtype=np.float64)


class _Ground:
    """What texts should not cover: lines and marks, as sums over cells of one point, and the texts that are there."""

    def __init__(self, picture: Picture) -> None:
        frame = picture.frame
        self.low, self.high, self.pt = frame.low, frame.high, frame.point
        z, weight = _samples(picture)
        size = (self.high - self.low) / self.pt
        shape = int(np.ceil(size.real)) + 1, int(np.ceil(size.imag)) + 1
        cell = (z - self.low) / self.pt
        inside = (cell.real >= 0) & (cell.imag >= 0) & (cell.real < shape[0]) & (cell.imag < shape[1])
        index = cell.real[inside].astype(int) * shape[1] + cell.imag[inside].astype(int)
        count = np.bincount(index, weight[inside], shape[0] * shape[1]).reshape(shape)
        self._sums = np.pad(count.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        sizes = [extent(text.text, text.size * frame.font) for text in picture.texts]
        texts = [
            (text.at + (0.5 * size[0] * self.pt if text.begins else 0.0), size)
            for text, size in zip(picture.texts, sizes, strict=True)
        ]
        boxes = [_boxes(np.array([at]), 0.5 * complex(*size) * self.pt)[0] for at, size in texts]
        self.taken = np.array(boxes).reshape(-1, 4)

    def lines(self, centres: ComplexArray, half: complex) -> FloatArray:
        """Return the cost of the lines and marks in boxes of a size around some centres."""
        boxes = _boxes(centres, half)
        across = ((boxes[:, :2] - self.low.real) / self.pt + 0.5).astype(int).clip(0, self._sums.shape[0] - 1)
        upward = ((boxes[:, 2:] - self.low.imag) / self.pt + 0.5).astype(int).clip(0, self._sums.shape[1] - 1)
        (a, b), (c, d) = across.T, upward.T
        found = self._sums[b, d] - self._sums[a, d] - self._sums[b, c] + self._sums[a, c]
        return np.asarray(np.maximum(found, 0.0).round(6))

    def cost(self, request: _Request) -> FloatArray:
        """Return the cost of each offer of a request; rings may be on lines."""
        boxes = _boxes(request.offers, request.half)
        outside = (boxes[:, 0] < self.low.real) | (boxes[:, 1] > self.high.real)
        outside |= (boxes[:, 2] < self.low.imag) | (boxes[:, 3] > self.high.imag)
        lines = 0.0 if request.text.ring else self.lines(request.offers, request.half)
        return np.asarray(OUTSIDE * outside + lines)


def _samples(picture: Picture) -> tuple[ComplexArray, FloatArray]:
    """Return points along all lines, outlines and marks of a picture, and their weights."""
    pt, ring = picture.frame.point, np.exp(2j * np.pi * np.arange(8) / 8)
    parts = []
    for style, z in picture.drawn.items():
        if isinstance(style, Pen):
            own = _weight(style.color) * (TWICE if style.width >= THICK else 1.0)
            parts += [(_along(path, DENSITY * pt), own) for path in z]
        elif isinstance(style, Fill):
            parts += [(_along(np.append(area, area[:1]), DENSITY * pt), _weight(style.edge)) for area in z]
        else:
            edge = np.add.outer(np.array(z), 0.5 * style.size * pt * ring).ravel()
            parts.append((edge, MARK * _weight(style.edge)))
    points = np.concatenate([*(part for part, _ in parts), np.zeros(0, dtype=np.complex128)])
    weight = np.concatenate([*(np.full(len(part), own) for part, own in parts), np.zeros(0)])
    good = np.isfinite(points)
    return points[good], weight[good]


def _weight(color: str) -> float:
    """Return the cost of covering a line of a colour: low for light colours."""
    if not color.startswith("#"):
        return 0.0 if color in ("none", PAPER) else 1.0
    light = sum(int(color[k : k + 2], 16) for k in (1, 3, 5)) / 765.0
    return PALE if light > 0.6 else 1.0


def _along(path: ComplexArray, step: float) -> ComplexArray:
    finite = path[np.isfinite(path)]
    if len(finite) > 60:  # the points of a curve are already close together
        return finite[:: max(1, len(finite) // 600)]
    lengths = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(finite)))))
    if len(finite) == 0 or lengths[-1] == 0.0:
        return finite
    at = np.linspace(0.0, lengths[-1], min(400, 2 + int(lengths[-1] / step)))
    return np.interp(at, lengths, finite.real) + 1j * np.interp(at, lengths, finite.imag)
