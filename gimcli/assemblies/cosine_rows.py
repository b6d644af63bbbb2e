"""Scalar equations Σ_c r cos(φ_c + δ) + Σ_q r s_q cos(φ_rail + δ) + k = 0 that every configuration satisfies.

A combination of the loops that eliminates L - 1 columns has few unknowns (a circuit of the dual of the loop matroid);
its component along a direction of the plane is such an equation. Since combinations are rounded, eliminated
coefficients are not exactly zero; each equation has a slack that covers both.

Boxes are contracted by these equations: the ends of an interval move to the nearest admissible angles. For all values
of the other unknowns in the box, an equation gives an interval for the cosine of one angle, and thus the arcs of
admissible angles. Both ends of the angle's interval move to the nearest points of these arcs; intervals of slides
follow by division. Boxes are columns of arrays (d, B), angles before slides.

Rounding: the bounds of every sum are widened by the slack of the equation, and every new end by a few units in the last
place, so that the result contains that of exact arithmetic.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gimcli.assemblies.loops import GROUND
from gimcli.canonical import TURN
from gimcli.mechanism import ComplexArray, FloatArray, IntArray

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class RowConstants:
    """Constants for the choice of rows and the bounds of their rounding."""

    rank: float = 1e-7  # relative singular value below which eliminated columns count as dependent
    zero: float = 64 * EPS  # relative coefficient that counts as eliminated; its value is added to the slack
    rows: int = 120  # largest number of combinations; those with the fewest unknowns come first
    parallel: float = 0.05  # sine of the angle between two directions below which only one of them is used
    rounding: float = 64 * EPS  # relative to the sum of moduli: about 20 products and sums, and cosines


@dataclass(frozen=True, eq=False)
class CosineRows:
    """Terms of all equations, grouped by equation; n angles, q slides."""

    angles: int  # n
    start: IntArray  # (E,) first term of each equation
    owner: IntArray  # (T,) equation of each term
    angle: IntArray  # (T,) number of the angle, or of the angle of the rail; n for the frame
    slide: IntArray  # (T,) number of the slide, -1 for a term without a slide
    amplitude: FloatArray  # (T,)
    phase: FloatArray  # (T,) [rad]
    constant: FloatArray  # (E,)
    slack: FloatArray  # (E,)


def cosine_rows(
    C0: ComplexArray, C: ComplexArray, U: ComplexArray, rail: IntArray, reach: FloatArray, constants: RowConstants
) -> CosineRows:
    """Return the equations of all combinations with few unknowns, along the directions of their terms."""
    n, q = C.shape[1], U.shape[1]
    columns, weight = np.hstack([C, U]), np.concatenate([np.ones(n), reach])
    angle = np.concatenate([np.arange(n), np.where(rail == GROUND, n, rail)])
    slide = np.concatenate([np.full(n, -1), np.arange(q)])
    moduli = np.abs(C0) + np.abs(columns) @ weight
    terms: list[tuple[int, int, complex]] = []
    constant: list[float] = []
    slack: list[float] = []
    for row, support in _combinations(columns, constants):
        left = row @ columns
        lost = np.abs(np.delete(left, support)) @ np.delete(weight, support)
        for direction in _directions(left[support], constants.parallel):
            terms += [(len(constant), int(c), complex(left[c] * np.conj(direction))) for c in support]
            constant.append(float((row @ C0 * np.conj(direction)).real))
            slack.append(float(lost + constants.rounding * (np.abs(row) @ moduli)))
    owner, column = np.array([t[0] for t in terms]), np.array([t[1] for t in terms])
    value = np.array([t[2] for t in terms])
    start = np.searchsorted(owner, np.arange(len(constant)))
    place = angle[column], slide[column], np.abs(value), np.angle(value)
    return CosineRows(n, start, owner, *place, np.array(constant), np.array(slack))


def _combinations(columns: ComplexArray, constants: RowConstants) -> list[tuple[ComplexArray, IntArray]]:
    """Return combinations of loops and their remaining unknowns, one for each minimal set of unknowns."""
    found: dict[tuple[int, ...], ComplexArray] = {}
    for row in _annihilators(columns, constants.rank):
        size = np.abs(row) @ np.abs(columns)
        support = tuple(np.nonzero(np.abs(row @ columns) > constants.zero * size)[0].tolist())
        if support:
            found.setdefault(support, row)
    return [(found[s], np.array(s)) for s in sorted(found, key=len)[: constants.rows]]


def _annihilators(columns: ComplexArray, rank: float) -> Iterator[ComplexArray]:
    """Yield the single loops, then for every L - 1 independent columns the combination that eliminates them."""
    loops = len(columns)
    yield from np.eye(loops, dtype=complex)
    length = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(length > 0.0, length, 1.0)
    for killed in combinations(range(columns.shape[1]), loops - 1):
        left, values, _ = np.linalg.svd(scaled[:, killed])
        if not killed or values[-1] > rank:
            yield np.conj(left[:, -1])


def _directions(coefficients: ComplexArray, parallel: float) -> list[complex]:
    """Return the directions of the terms and their normals, without almost equal ones."""
    kept: list[complex] = []
    for c in coefficients:
        for direction in (c / abs(c), 1j * c / abs(c)):
            if all(abs((direction * np.conj(k)).imag) > parallel for k in kept):
                kept.append(complex(direction))
    return kept


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
