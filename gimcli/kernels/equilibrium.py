"""Equilibrium of the bodies of a mechanism, row by row and block by block.

An unknown reaction acts with one sense on a body and with the other on a second body. It is a force d at a node,
with d = z or z (z_v - z_u), made a unit vector where it acts ALONG two nodes, or a couple. In the equations of a body

    x: sum of d_x,   y: sum of d_y,   moment about the body's node r: sum of (p - r) x d

everything has the size of the normal frame; couples are divided by its length unit.
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

KNOWN = -1
"""Column of a term whose unknown an earlier block has found."""


@kernel
def wrench_part(
    axis: int, kind: int, px: float, py: float, rx: float, ry: float, dx: float, dy: float
) -> float:  # fmt: skip
    """Return the part of a reaction in one equation of a body."""
    if kind == COUPLE:
        return 1.0
    if axis == 0:
        return dx
    if axis == 1:
        return dy
    return (px - rx) * dy - (py - ry) * dx


@kernel
def balance_rows(
    x: FloatArray, y: FloatArray, places: IntArray, vectors: FloatArray, terms: IntArray, blocks: IntArray,
    own_rows: IntArray, own_columns: IntArray, right: FloatArray, least: float, a: FloatArray, order: FloatArray,
    b: FloatArray, directions: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Find the reactions `out` (unknowns, rows) that balance `right` (equations, rows); NaN where they are singular.

    x, y (nodes, rows). places (unknowns, 5): kind, node on the one body, node on the other, u, v. vectors: z of each
    (unknowns, 2). terms (., 6): row and column in the block, unknown, axis, sense, node of reference. blocks (., 3):
    size, first and last term. own_rows, own_columns: equations and unknowns, block after block. a, order, b,
    directions: scratch.
    """
    for k in range(x.shape[1]):
        for c in range(places.shape[0]):
            dx, dy = vectors[c, 0], vectors[c, 1]
            u, v = places[c, 3], places[c, 4]
            if u >= 0:
                ex, ey = x[v, k] - x[u, k], y[v, k] - y[u, k]
                dx, dy = dx * ex - dy * ey, dx * ey + dy * ex
            if places[c, 0] == ALONG:
                norm = math.sqrt(dx * dx + dy * dy)
                dx, dy = dx / norm, dy / norm
            directions[c, 0], directions[c, 1] = dx, dy
        first = 0
        for g in range(blocks.shape[0]):
            n = blocks[g, 0]
            for i in range(n):
                b[i] = right[own_rows[first + i], k]
                for j in range(n):
                    a[i, j] = 0.0
            for t in range(blocks[g, 1], blocks[g, 2]):
                i, j, c, axis, sense, r = terms[t]
                p = places[c, 1] if sense > 0 else places[c, 2]
                part = sense * wrench_part(
                    axis, places[c, 0], x[p, k], y[p, k], x[r, k], y[r, k], directions[c, 0], directions[c, 1]
                )
                if j == KNOWN:
                    b[i] -= part * out[c, k]
                else:
                    a[i, j] += part
            good = lu_factor(a, n, order) != 0.0
            greatest, smallest = 0.0, math.inf
            for i in range(n):
                pivot = 1.0 / abs(order[n + i]) if good else 0.0
                greatest, smallest = max(greatest, pivot), min(smallest, pivot)
            if good and smallest > least * greatest:
                lu_solve(a, n, order, b)
            else:
                for i in range(n):
                    b[i] = np.nan
            for i in range(n):
                out[own_columns[first + i], k] = b[i]
            first += n
