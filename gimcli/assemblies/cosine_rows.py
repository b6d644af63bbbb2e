"""Scalar equations Σ_c r cos(φ_c + δ) + Σ_q r s_q cos(φ_rail + δ) + k = 0 that every configuration satisfies.

A combination of the loops that eliminates L - 1 columns has few unknowns (a circuit of the dual of the loop matroid);
its component along a direction of the plane is such an equation. Since combinations are rounded, eliminated
coefficients are not exactly zero; each equation has a slack that covers both.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gimcli.assemblies.loops import GROUND
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
