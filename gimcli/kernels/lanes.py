"""Lanes: each holds one number over a block of rows; all lanes are in one array `w` that fits into the cache.

Lane k is w[k WIDTH : (k + 1) WIDTH]; a complex number takes two consecutive lanes. One source serves both forms: when
interpreted, `rows` is one slice and numpy processes all rows of a lane at once; when compiled, it is the row numbers,
in a loop that the compiler vectorises.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.kernels.jit import kernel, scalar_form, stage
from gimcli.mechanism import FloatArray

ROWS = 256
WIDTH = ROWS + 8
"""One cache line more than a power of two, so that lanes do not evict each other from the cache."""

LINE = 64
"""Bytes of a cache line."""


def aligned(count: int) -> FloatArray:
    """Return an array of zeros, aligned to a cache line."""
    room = np.zeros(count + LINE // 8)
    skip = (-room.ctypes.data % LINE) // 8
    return room[skip : skip + count]


@scalar_form(range)
def rows(high: int) -> Any:
    """Return the rows of a block: one slice, or the row numbers when compiled."""
    return (slice(0, high),)


def _next(r: int) -> int:
    return r + WIDTH


@scalar_form(_next)
def imaginary(r: Any) -> Any:
    """Return the index of the imaginary part of row r."""
    return slice(r.start + WIDTH, r.stop + WIDTH)


@kernel
def real(k: int) -> slice:
    """Return the slice of lane k."""
    return slice(k * WIDTH, (k + 1) * WIDTH)


@kernel
def pair(k: int) -> slice:
    """Return the slice of lanes k and k + 1."""
    return slice(k * WIDTH, (k + 2) * WIDTH)


@stage
def fill(w: FloatArray, to: int, value: float, high: int) -> None:
    """Fill lane `to` with a value."""
    a = w[real(to)]
    for r in rows(high):
        a[r] = value


@stage
def multiply(w: FloatArray, to: int, k: int, high: int) -> None:
    """Multiply lane `to` by lane k."""
    a, b = w[real(to)], w[real(k)]
    for r in rows(high):
        a[r] *= b[r]


@stage
def add_product(w: FloatArray, to: int, one: int, other: int, factor: float, high: int) -> None:
    """Add `factor` times the product of two lanes to lane `to`."""
    a, b, c = w[real(to)], w[real(one)], w[real(other)]
    for r in rows(high):
        a[r] += factor * (b[r] * c[r])
