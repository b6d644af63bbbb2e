"""Equilibrium of the bodies of a mechanism: the forms of its terms, and the solution of a block for all rows of lanes.

An unknown reaction acts on two bodies with opposite senses; a unit of it may exert couples too. It is a couple, or a
force at a node with direction d = z or d = z (z_v - z_u), which is normalised if it acts ALONG two nodes. The equations
of a body are

    x: sum of d_x,   y: sum of d_y,   moment about the body's node r: sum of (p - r) x d

Lengths are in the normal frame; couples are divided by its length unit.
"""

from __future__ import annotations

import numpy as np

from gimcli.kernels.choice import larger, smaller, where
from gimcli.kernels.jit import stage
from gimcli.kernels.lanes import add_product, fill, multiply, real, rows
from gimcli.mechanism import FloatArray

PUSH, ALONG, COUPLE = range(3)

X, Y, MOMENT, TURN = range(4)
"""TURN: a couple in the equation of moments; its coefficient is its factor."""

SINGULAR = 1e-10
"""Ratio of least to greatest pivot of a scaled block below which its reactions are undetermined."""


@stage
def combine(w: FloatArray, to: int, p: int, q: int, f: float, g: float, high: int) -> None:
    """Fill a lane with f p + g q."""
    t, a, b = w[real(to)], w[real(p)], w[real(q)]
    for r in rows(high):
        t[r] = f * a[r] + g * b[r]


@stage
def quotient(w: FloatArray, to: int, p: int, q: int, f: float, high: int) -> None:
    """Fill a lane with f p / q."""
    t, a, b = w[real(to)], w[real(p)], w[real(q)]
    for r in rows(high):
        t[r] = f * a[r] / b[r]


@stage
def exceed(w: FloatArray, to: int, p: int, q: int, high: int) -> None:
    """Fill a lane with |q| - |p|."""
    t, a, b = w[real(to)], w[real(p)], w[real(q)]
    for r in rows(high):
        t[r] = abs(b[r]) - abs(a[r])


@stage
def exchange(w: FloatArray, greater: int, p: int, q: int, high: int) -> None:
    """Exchange two lanes in the rows where lane `greater` is positive."""
    t, a, b = w[real(greater)], w[real(p)], w[real(q)]
    for r in rows(high):
        first = where(t[r] > 0.0, b[r], a[r])
        b[r] = where(t[r] > 0.0, a[r], b[r])
        a[r] = first


@stage
def note_pivot(w: FloatArray, pivot: int, least: int, high: int) -> None:
    """Enter a pivot into lane `least`, the least one, and the lane after it, the greatest one."""
    a, low, top = w[real(pivot)], w[real(least)], w[real(least + 1)]
    for r in rows(high):
        low[r], top[r] = smaller(abs(a[r]), low[r]), larger(abs(a[r]), top[r])


@stage
def judge(w: FloatArray, least: int, weak: int, high: int) -> None:
    """Enter the ratio of the pivots into lane `weak`; lane `least` becomes 1, or NaN where the block is singular."""
    low, top, ratio = w[real(least)], w[real(least + 1)], w[real(weak)]
    for r in rows(high):
        own = low[r] / where(top[r] > 0.0, top[r], np.inf)
        ratio[r] = smaller(own, ratio[r])
        low[r] = where(own > SINGULAR, 1.0, np.nan)


@stage
def eliminate(w: FloatArray, b: int, a: int, n: int, least: int, weak: int, high: int) -> None:
    """Solve the block of n by n lanes from `a` on, with partial pivoting in each row, in place of b.

    NaN where it is singular. Lane `weak`: least ratio of pivots so far; that of a single equation is its pivot, at most
    1. `least` is the first of 2 + n (n - 1) / 2 lanes which, with the factors in place of the block, are what `resolve`
    needs.
    """
    swap = least + 2
    fill(w, least, np.inf, high)
    fill(w, least + 1, 1.0 if n == 1 else 0.0, high)
    for k in range(n):
        row = a + k * n
        for i in range(k + 1, n):
            other = a + i * n
            exceed(w, swap, row + k, other + k, high)
            for j in range(k, n):
                exchange(w, swap, row + j, other + j, high)
            swap += 1
        note_pivot(w, row + k, least, high)
        for i in range(k + 1, n):
            other = a + i * n
            quotient(w, other + k, other + k, row + k, 1.0, high)
            for j in range(k + 1, n):
                add_product(w, other + j, other + k, row + j, -1.0, high)
    judge(w, least, weak, high)
    resolve(w, b, a, n, least, high)


@stage
def resolve(w: FloatArray, b: int, a: int, n: int, least: int, high: int) -> None:
    """Solve a block that `eliminate` has factored, in place of another right side b."""
    swap = least + 2
    for k in range(n):
        for i in range(k + 1, n):
            exchange(w, swap, b + k, b + i, high)
            swap += 1
        for i in range(k + 1, n):
            add_product(w, b + i, a + i * n + k, b + k, -1.0, high)
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            add_product(w, b + k, a + k * n + j, b + j, -1.0, high)
        quotient(w, b + k, b + k, a + k * n + k, 1.0, high)
    for k in range(n):
        multiply(w, b + k, least, high)
