"""Equilibrium of the bodies of a mechanism, row by row and block by block.

An unknown reaction acts on two bodies with opposite senses; a unit of it may exert couples too. It is a couple, or a
force at a node with direction d = z or d = z (z_v - z_u), which is normalised if it acts ALONG two nodes. The equations
of a body are

    x: sum of d_x,   y: sum of d_y,   moment about the body's node r: sum of (p - r) x d

Lengths are in the normal frame; couples are divided by its length unit.
"""

from __future__ import annotations

import math

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


@kernel
def balance_rows(
    x: FloatArray, y: FloatArray, vectors: FloatArray, turned: IntArray, terms: IntArray, factors: FloatArray,
    blocks: IntArray, own_rows: IntArray, own_columns: IntArray, right: FloatArray, least: float, a: FloatArray,
    order: FloatArray, b: FloatArray, directions: FloatArray, out: FloatArray, weakest: FloatArray,
) -> None:  # fmt: skip
    """Compute reactions `out` (unknowns, rows) that balance `right` (equations, rows); NaN if a block is singular.

    x, y (nodes, rows): positions. vectors (1 or rows, unknowns, 2): z. turned (., 4): unknown with d other than z, u,
    v, and 1 to normalise d. terms (., 6): row and column in the block, unknown, axis, node of action, node of
    reference. factors (terms,): 1 or -1, for couples any number. blocks (., 3): size, first and end of its terms.
    own_rows, own_columns: equations and unknowns, block after block. a, order, b, directions (unknowns, 2): scratch.
    weakest (rows,): result, the least ratio of smallest to greatest pivot of a block.
    """
    for k in range(x.shape[1]):
        z = vectors[k % vectors.shape[0]]
        for c in range(z.shape[0]):
            directions[c, 0], directions[c, 1] = z[c, 0], z[c, 1]
        for t in range(turned.shape[0]):
            c, u, v = turned[t, 0], turned[t, 1], turned[t, 2]
            ex, ey = x[v, k] - x[u, k], y[v, k] - y[u, k]
            dx, dy = z[c, 0] * ex - z[c, 1] * ey, z[c, 0] * ey + z[c, 1] * ex
            norm = math.sqrt(dx * dx + dy * dy) if turned[t, 3] == 1 else 1.0
            directions[c, 0], directions[c, 1] = dx / norm, dy / norm
        first, weak = 0, 1.0
        for g in range(blocks.shape[0]):
            n = blocks[g, 0]
            for i in range(n):
                b[i] = right[own_rows[first + i], k]
                for j in range(n):
                    a[i, j] = 0.0
            for t in range(blocks[g, 1], blocks[g, 2]):
                i, j, c, axis, p, r = terms[t, 0], terms[t, 1], terms[t, 2], terms[t, 3], terms[t, 4], terms[t, 5]
                if axis == MOMENT:
                    part = (x[p, k] - x[r, k]) * directions[c, 1] - (y[p, k] - y[r, k]) * directions[c, 0]
                else:
                    part = 1.0 if axis == TURN else directions[c, axis]
                part *= factors[t]
                if j == KNOWN:
                    b[i] -= part * out[c, k]
                else:
                    a[i, j] += part
            if n == 1:
                weak = min(weak, abs(a[0, 0]))
                b[0] = b[0] / a[0, 0] if abs(a[0, 0]) > least else np.nan
            else:
                weak = min(weak, solve_block(a, n, order, b, least))
            for i in range(n):
                out[own_columns[first + i], k] = b[i]
            first += n
        weakest[k] = weak
