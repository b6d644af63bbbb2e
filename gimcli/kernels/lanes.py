"""Lanes: one coordinate over a short stretch of rows, many of them in one scratch `w` that stays in the cache.

Lane k is w[k WIDTH : (k + 1) WIDTH]; a complex number takes two, one after the other. One source serves both
forms: `rows` is one slice as it stands, so that numpy works on all rows of a lane at once, and the numbers of the
rows when compiled, in loops that vectorise.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.kernels.jit import kernel, scalar_form, stage
from gimcli.mechanism import FloatArray

ROWS = 256
WIDTH = ROWS + 8
"""One line of the cache more than a power of two: lanes do not push each other out."""

LINE = 64
"""Bytes of a line of the cache."""


def aligned(count: int) -> FloatArray:
    """Return zeros that begin where a line of the cache does."""
    room = np.zeros(count + LINE // 8)
    skip = (-room.ctypes.data % LINE) // 8
    return room[skip : skip + count]


@scalar_form(range)
def rows(high: int) -> Any:
    """Return the rows of a stretch: one slice, or their numbers when compiled."""
    return (slice(0, high),)


def _next(r: int) -> int:
    return r + WIDTH


@scalar_form(_next)
def imaginary(r: Any) -> Any:
    """Return where the imaginary part of row r stands."""
    return slice(r.start + WIDTH, r.stop + WIDTH)


@kernel
def real(k: int) -> slice:
    """Return where a lane stands."""
    return slice(k * WIDTH, (k + 1) * WIDTH)


@kernel
def pair(k: int) -> slice:
    """Return where two lanes stand."""
    return slice(k * WIDTH, (k + 2) * WIDTH)


@stage
def fill(w: FloatArray, to: int, value: float, high: int) -> None:
    """Fill a lane."""
    a = w[real(to)]
    for r in rows(high):
        a[r] = value


@stage
def multiply(w: FloatArray, to: int, k: int, high: int) -> None:
    """Multiply by a lane."""
    a, b = w[real(to)], w[real(k)]
    for r in rows(high):
        a[r] *= b[r]


@stage
def add_product(w: FloatArray, to: int, one: int, other: int, factor: float, high: int) -> None:
    """Add `factor` times the product of two lanes."""
    a, b, c = w[real(to)], w[real(one)], w[real(other)]
    for r in rows(high):
        a[r] += factor * (b[r] * c[r])
