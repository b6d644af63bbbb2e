"""Contraction of boxes by scalar equations: the ends of an interval move to the nearest admissible angles.

For all values of the other unknowns in the box, an equation gives an interval for the cosine of one angle, and thus the
arcs of admissible angles. Both ends of the angle's interval move to the nearest points of these arcs; intervals of
slides follow by division.
Boxes are columns of arrays (d, B), angles before slides.

Rounding: the bounds of every sum are widened by the slack of the equation, and every new end by a few units in the last
place, so that the result contains that of exact arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.assemblies.cosine_rows import EPS, CosineRows
from gimcli.canonical import TURN
from gimcli.mechanism import FloatArray


@dataclass(frozen=True)
class ContractionConstants:
    """Bounds of rounding, and the size of the arrays."""

    angle: float = 64 * EPS  # rad: angles are below 4 pi, inverse cosines are accurate to a few units in the last place
    cosine: float = 16 * EPS  # error of a cosine
    relative: float = 8 * EPS  # relative rounding of a slide's bounds: a division and a subtraction
    elements: int = 60_000  # terms times boxes per call, so that temporary arrays fit into the cache


CONSTANTS = ContractionConstants()


def contract(rows: CosineRows, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return boxes (d, B) without the parts that the equations exclude; low > high in empty boxes."""
    new_low, new_high = low.copy(), high.copy()
    step = max(1, CONSTANTS.elements // max(1, len(rows.owner)))
    for first in range(0, low.shape[1], step):
        part = slice(first, first + step)
        _contract(rows, new_low[:, part], new_high[:, part])
    return new_low, new_high


def _contract(rows: CosineRows, low: FloatArray, high: FloatArray) -> None:
    """Contract boxes in place."""
    n = rows.angles
    start, end = _end_cosines(rows, low[:n]), _end_cosines(rows, high[:n])
    least, most = _ranges(rows, low[:n], high[:n], start, end)
    small, large = _terms(rows, least, most, low[n:], high[n:])
    bottom = np.add.reduceat(small, rows.start, axis=0) + (rows.constant - rows.slack)[:, None]
    top = np.add.reduceat(large, rows.start, axis=0) + (rows.constant + rows.slack)[:, None]
    empty = ((bottom > 0.0) | (top < 0.0)).any(axis=0)
    from_, to = large - top[rows.owner], small - bottom[rows.owner]  # bounds of each term from the other terms
    _advance(rows, low, high, start, end, from_, to)
    _divide(rows, low[n:], high[n:], least, most, from_, to)
    low[:, empty], high[:, empty] = 1.0, -1.0


def _end_cosines(rows: CosineRows, ends: FloatArray) -> FloatArray:
    """Return cos(φ + δ) of every term (T, B)."""
    cos, sin = _frame(np.cos(ends), 1.0), _frame(np.sin(ends), 0.0)
    return np.asarray(cos[rows.angle] * np.cos(rows.phase)[:, None] - sin[rows.angle] * np.sin(rows.phase)[:, None])


def _frame(values: FloatArray, value: float) -> FloatArray:
    """Return the rows of the angles with a last one for the frame."""
    return np.vstack([values, np.full((1, values.shape[1]), value)])


def _ranges(
    rows: CosineRows, low: FloatArray, high: FloatArray, start: FloatArray, end: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return bounds of cos(φ + δ) of every term (T, B)."""
    half = _frame(np.minimum(0.5 * (high - low), np.pi), 0.0)
    middle = _end_cosines(rows, 0.5 * (low + high))
    reached = (np.cos(half) - CONSTANTS.cosine)[rows.angle]
    least = np.where(middle <= -reached, -1.0, np.minimum(start, end))
    return least, np.where(middle >= reached, 1.0, np.maximum(start, end))


def _terms(
    rows: CosineRows, least: FloatArray, most: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return bounds of every term (T, B)."""
    small, large = rows.amplitude[:, None] * least, rows.amplitude[:, None] * most
    sliding = np.nonzero(rows.slide >= 0)[0]
    if len(sliding):
        a, b = low[rows.slide[sliding]], high[rows.slide[sliding]]
        products = [small[sliding] * a, small[sliding] * b, large[sliding] * a, large[sliding] * b]
        small[sliding], large[sliding] = np.minimum.reduce(products), np.maximum.reduce(products)
    return small, large


def _advance(
    rows: CosineRows, low: FloatArray, high: FloatArray, start: FloatArray, end: FloatArray, from_: FloatArray,
    to: FloatArray,
) -> None:  # fmt: skip
    """Advance the ends of the angles' intervals in place."""
    turning = np.nonzero(rows.slide < 0)[0]
    scale = rows.amplitude[turning, None]
    least, most = from_[turning] / scale, to[turning] / scale
    angle, phase = rows.angle[turning], rows.phase[turning, None]
    forth = _shift(low[angle] + phase, start[turning], least, most)
    back = _shift(-(high[angle] + phase), end[turning], least, most)
    for c in range(rows.angles):
        own = np.nonzero(angle == c)[0]
        if len(own):
            low[c] += forth[own].max(axis=0)
            high[c] -= back[own].max(axis=0)


def _shift(angle: FloatArray, cosine: FloatArray, least: FloatArray, most: FloatArray) -> FloatArray:
    """Return the least increase of angles for which least <= cos <= most; more than a turn if there is none."""
    shift = np.zeros_like(cosine)
    above, below = np.nonzero(cosine > most), np.nonzero(cosine < least)
    shift[above] = np.arccos(np.maximum(most[above], -1.0)) - _wrap(angle[above])
    wrapped = _wrap(angle[below])
    limit = np.arccos(np.minimum(least[below], 1.0))
    shift[below] = np.where(wrapped > 0.0, TURN, 0.0) - limit - wrapped
    shift = np.maximum(shift - CONSTANTS.angle, 0.0)
    shift[(most < -1.0) | (least > 1.0)] = 2 * TURN
    return shift


def _wrap(angle: FloatArray) -> FloatArray:
    """Return angles in [-pi, pi]."""
    return np.asarray(angle - TURN * np.round(angle / TURN))


def _divide(
    rows: CosineRows, low: FloatArray, high: FloatArray, least: FloatArray, most: FloatArray, from_: FloatArray,
    to: FloatArray,
) -> None:  # fmt: skip
    """Narrow the intervals of the slides in place, where the factor of the slide is not 0."""
    for slide in range(len(low)):
        own = np.nonzero(rows.slide == slide)[0]
        scale = rows.amplitude[own, None]
        a, b = (least[own] - CONSTANTS.cosine) * scale, (most[own] + CONSTANTS.cosine) * scale
        firm = (a > 0.0) | (b < 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            quotients = [from_[own] / a, from_[own] / b, to[own] / a, to[own] / b]
        small, large = np.minimum.reduce(quotients), np.maximum.reduce(quotients)
        margin = CONSTANTS.relative * (np.abs(small) + np.abs(large))
        low[slide] = np.maximum(low[slide], np.where(firm, small - margin, -np.inf).max(axis=0, initial=-np.inf))
        high[slide] = np.minimum(high[slide], np.where(firm, large + margin, np.inf).min(axis=0, initial=np.inf))
