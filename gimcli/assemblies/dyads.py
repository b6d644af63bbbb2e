"""The two configurations of a dyad in closed form, for many dyads at once.

RRR: C0 + C1 theta_1 + C2 theta_2 = 0, a triangle; RRP: |C0 + U s| = |C1|; RPR: |C1 + U s| = |C0|; PRP: linear.
The roots are complex if the dyad cannot be assembled.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.assemblies.certificate import Proven, prove
from gimcli.assemblies.loops import GROUND, LoopFamily
from gimcli.assemblies.root_paths import corrected
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray

MARGIN = 1e-12
"""Gap of a triangle, relative to its sides, above which it has no real configuration; smaller gaps are rounding."""

CLOSED = 1
"""Newton corrections after a closed form; one removes the error of cancellation."""


@dataclass(frozen=True)
class DyadRoots:
    """Both roots of some dyads, in the order of signs + and -; a PRP has one root."""

    proven: Proven  # (dyads roots) rows, grouped by dyad
    each: int  # number of roots of a dyad
    apart: BoolArray  # (dyads,) whether it cannot be assembled, by more than rounding
    free: BoolArray  # (dyads,) whether it is folded and can rotate freely


def dyad_roots(family: LoopFamily, H: ComplexArray) -> DyadRoots:
    """Return the roots of dyads H (dyads, 2, 1, 1 + n + q)."""
    c = H[:, 0, 0]
    with np.errstate(all="ignore"):
        if family.angles == 0:
            w, gap, size = _double_slide(c, H[:, 1, 0]), np.full(len(c), np.inf), np.ones(len(c))
            free = np.zeros(len(c), dtype=bool)
        else:
            w, gap, size, free = _triangle(c) if family.angles == 2 else _slide(c, int(family.rail[0]))
        each = w.shape[1]
        rows, repeated = w.reshape(len(c) * each, w.shape[2]), np.repeat(H, each, axis=0)
        better = corrected(family, repeated, rows, CLOSED)
        rows = np.where((np.abs(better - rows) < MARGIN**0.5).all(axis=1)[:, None], better, rows)
    return DyadRoots(prove(family, repeated, rows), each, gap < -MARGIN * size, free)


def _triangle(c: ComplexArray) -> tuple[ComplexArray, FloatArray, FloatArray, BoolArray]:
    """Return the roots of triangles (dyads, 2, 2), their gaps, their sizes, and which of them can rotate freely."""
    a, b, d = np.abs(c[:, 0]), np.abs(c[:, 1]), np.abs(c[:, 2])
    size = a + b + d
    gap = np.minimum(np.minimum(a + b - d, b + d - a), d + a - b)
    area = _root(size * (a + b - d) * (b + d - a) * (d + a - b))  # 4 times the triangle's
    middle = (d - b) * (d + b) - a * a
    sign = np.array([1.0, -1.0])
    first = (middle[:, None] + 1j * sign * area[:, None]) / (2.0 * c[:, 1] * c[:, 0].conj())[:, None]
    second = -(c[:, :1] + c[:, 1:2] * first) / c[:, 2:]
    real = (gap >= 0.0)[:, None]
    w = np.stack([_log(first, real), _log(second, real)], axis=2)
    return w, gap, size, a < MARGIN * size


def _slide(c: ComplexArray, rail: int) -> tuple[ComplexArray, FloatArray, FloatArray, BoolArray]:
    """Return the roots of dyads with one slide (dyads, 2, 2), and the other values as for triangles."""
    carrier, arm = (c[:, 0], c[:, 1]) if rail == GROUND else (c[:, 1], c[:, 0])
    u = c[:, 2]
    seen = carrier * u.conj() / np.abs(u)
    reach = np.abs(arm)
    gap = reach - np.abs(seen.imag)
    half = _root((reach - seen.imag) * (reach + seen.imag))
    s = (-seen.real[:, None] + np.array([1.0, -1.0]) * half[:, None]) / np.abs(u)[:, None]
    line = carrier[:, None] + u[:, None] * s
    turn = -line / arm[:, None] if rail == GROUND else -arm[:, None] / line
    size = np.abs(carrier) + reach + np.finfo(float).tiny
    w = np.stack([_log(turn, (gap >= 0.0)[:, None]), s], axis=2)
    free = reach < MARGIN * size
    return w, gap, size, free & (rail != GROUND) & (np.abs(seen.imag) < MARGIN * size)


def _double_slide(f: ComplexArray, g: ComplexArray) -> ComplexArray:
    """Return the root of dyads with two slides (dyads, 1, 2)."""
    determinant = f[:, 1] * g[:, 2] - f[:, 2] * g[:, 1]
    first = (f[:, 2] * g[:, 0] - f[:, 0] * g[:, 2]) / determinant
    second = (f[:, 0] * g[:, 1] - f[:, 1] * g[:, 0]) / determinant
    return np.stack([first, second], axis=1)[:, None, :]


def _root(x: FloatArray) -> ComplexArray:
    return np.asarray(np.sqrt(x.astype(complex)))


def _log(z: ComplexArray, real: BoolArray) -> ComplexArray:
    """Return the logarithm, exactly imaginary for real roots."""
    w = np.log(z)
    return np.where(real, 1j * w.imag, w)
