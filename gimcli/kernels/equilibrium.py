"""Equilibrium of the bodies of a mechanism, row by row and block by block.

An unknown reaction acts on two bodies with opposite senses; a unit of it may exert couples too. It is a couple, or a
force at a node with direction d = z or d = z (z_v - z_u), which is normalised if it acts ALONG two nodes. The equations
of a body are

    x: sum of d_x,   y: sum of d_y,   moment about the body's node r: sum of (p - r) x d

Lengths are in the normal frame; couples are divided by its length unit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gimcli.kernels.jit import kernel
from gimcli.kernels.linear import lu_factor, lu_solve
from gimcli.mechanism import FloatArray, IntArray

PUSH = 0
ALONG = 1
COUPLE = 2

X = 0
Y = 1
MOMENT = 2
TURN = 3
"""A couple in the equation of moments; its coefficient is its factor."""

KNOWN = -1
"""Column of a term whose unknown was determined by an earlier block."""


@kernel
def solve_block(a: FloatArray, n: int, order: FloatArray, b: FloatArray, least: float) -> float:
    """Solve a block; return the ratio of its least pivot to its greatest. The solution is NaN if it is <= `least`."""
    greatest, smallest = 0.0, 0.0
    if lu_factor(a, n, order) != 0.0:
        smallest = math.inf
        for i in range(n):
            pivot = 1.0 / abs(order[n + i])
            greatest, smallest = max(greatest, pivot), min(smallest, pivot)
    if smallest > least * greatest:
        lu_solve(a, n, order, b)
    else:
        for i in range(n):
            b[i] = np.nan
    return smallest / greatest if greatest > 0.0 else 0.0


ROWS = 128
"""Rows of a piece: each term is computed for all of them before the next one."""


class BalanceScratch(NamedTuple):
    """Scratch arrays for blocks of at most `widest` equations."""

    directions: FloatArray  # (unknowns, 2, ROWS) d
    a: FloatArray  # (widest, widest, ROWS)
    b: FloatArray  # (widest, ROWS)
    weak: FloatArray  # (ROWS,)
    block: FloatArray  # (widest, widest) of one row
    order: FloatArray  # (2 widest,)
    side: FloatArray  # (widest,)


@kernel
def solve_rows(s: BalanceScratch, n: int, rows: int, least: float) -> None:
    """Solve a block in the rows of a piece, in place of b; NaN where it is singular."""
    for r in range(rows):
        if n == 1:
            pivot = s.a[0, 0, r]
            s.weak[r] = min(s.weak[r], abs(pivot))
            s.b[0, r] = s.b[0, r] / pivot if abs(pivot) > least else np.nan
            continue
        for i in range(n):
            s.side[i] = s.b[i, r]
            for j in range(n):
                s.block[i, j] = s.a[i, j, r]
        s.weak[r] = min(s.weak[r], solve_block(s.block, n, s.order, s.side, least))
        for i in range(n):
            s.b[i, r] = s.side[i]


@kernel
def balance_rows(
    x: FloatArray, y: FloatArray, vectors: FloatArray, turned: IntArray, terms: IntArray, factors: FloatArray,
    blocks: IntArray, own_rows: IntArray, own_columns: IntArray, right: FloatArray, least: float, s: BalanceScratch,
    out: FloatArray, weakest: FloatArray,
) -> None:  # fmt: skip
    """Compute reactions `out` (unknowns, rows) that balance `right` (equations, rows); NaN if a block is singular.

    x, y (nodes, rows): positions. vectors (1 or rows, unknowns, 2): z. turned (., 4): unknown with d other than z, u,
    v, and 1 to normalise d. terms (., 6): row and column in the block, unknown, axis, node of action, node of
    reference. factors (terms,): 1 or -1, for couples any number. blocks (., 3): size, first and end of its terms.
    own_rows, own_columns: equations and unknowns, block after block. weakest (rows,): result, the least ratio of
    smallest to greatest pivot of a block.
    """
    for start in range(0, x.shape[1], ROWS):
        rows = min(ROWS, x.shape[1] - start)
        for r in range(rows):
            s.weak[r] = 1.0
            z = vectors[(start + r) % vectors.shape[0]]
            for c in range(z.shape[0]):
                s.directions[c, 0, r], s.directions[c, 1, r] = z[c, 0], z[c, 1]
        for t in range(turned.shape[0]):
            c, u, v = turned[t, 0], turned[t, 1], turned[t, 2]
            for r in range(rows):
                ex, ey = x[v, start + r] - x[u, start + r], y[v, start + r] - y[u, start + r]
                zx, zy = s.directions[c, 0, r], s.directions[c, 1, r]
                dx, dy = zx * ex - zy * ey, zx * ey + zy * ex
                norm = math.sqrt(dx * dx + dy * dy) if turned[t, 3] == 1 else 1.0
                s.directions[c, 0, r], s.directions[c, 1, r] = dx / norm, dy / norm
        first = 0
        for g in range(blocks.shape[0]):
            n = blocks[g, 0]
            for i in range(n):
                for r in range(rows):
                    s.b[i, r] = right[own_rows[first + i], start + r]
                    for j in range(n):
                        s.a[i, j, r] = 0.0
            for t in range(blocks[g, 1], blocks[g, 2]):
                i, j, c, axis, p, q = terms[t, 0], terms[t, 1], terms[t, 2], terms[t, 3], terms[t, 4], terms[t, 5]
                for r in range(rows):
                    k = start + r
                    if axis == MOMENT:
                        part = (x[p, k] - x[q, k]) * s.directions[c, 1, r] - (y[p, k] - y[q, k]) * s.directions[c, 0, r]
                    else:
                        part = 1.0 if axis == TURN else s.directions[c, axis, r]
                    part *= factors[t]
                    if j == KNOWN:
                        s.b[i, r] -= part * out[c, k]
                    else:
                        s.a[i, j, r] += part
            solve_rows(s, n, rows, least)
            for i in range(n):
                for r in range(rows):
                    out[own_columns[first + i], start + r] = s.b[i, r]
            first += n
        for r in range(rows):
            weakest[start + r] = s.weak[r]
