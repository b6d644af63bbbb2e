"""Small dense linear algebra: LU with partial pivoting, and least squares by Householder reflections.

LAPACK is not used because interpreted and compiled code would not give identical bits.
"""

from __future__ import annotations

import math

from gimcli.kernels.jit import kernel, stage
from gimcli.mechanism import FloatArray


@kernel
def lu_factor(a: FloatArray, n: int, order: FloatArray) -> float:
    """Factor a[:n, :n] in place; return the sign of the determinant, 0 if it is singular.

    order (2 n,): result, the row exchanges, then 1 / pivot of each row.
    """
    sign = 1.0
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[p, k]):
                p = i
        order[k] = p
        if not abs(a[p, k]) > 1e-300:
            return 0.0
        if p != k:
            sign = -sign
            for j in range(n):
                a[k, j], a[p, j] = a[p, j], a[k, j]
        if a[k, k] < 0.0:
            sign = -sign
        order[n + k] = 1.0 / a[k, k]
        for i in range(k + 1, n):
            f = a[i, k] * order[n + k]
            a[i, k] = f
            if f != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= f * a[k, j]
    return sign


@stage
def lu_solve(a: FloatArray, n: int, order: FloatArray, b: FloatArray) -> None:
    """Solve with the factors from `lu_factor`; b is overwritten by the solution."""
    for k in range(n):  # all exchanges first, as in both factors
        p = int(order[k])
        if p != k:
            b[k], b[p] = b[p], b[k]
    for k in range(1, n):
        total = b[k]
        for i in range(k):
            total -= a[k, i] * b[i]
        b[k] = total
    for k in range(n - 1, -1, -1):
        total = b[k]
        for j in range(k + 1, n):
            total -= a[k, j] * b[j]
        b[k] = total * order[n + k]


@kernel
def qr_factor(a: FloatArray, m: int, n: int, diagonal: FloatArray) -> float:
    """Reduce a[:m, :n] in place to triangular form by reflections; return 1, or 0 if a column vanishes."""
    for k in range(n):
        norm = 0.0
        for i in range(k, m):
            norm += a[i, k] * a[i, k]
        norm = math.sqrt(norm)
        if not norm > 1e-300:
            return 0.0
        if a[k, k] > 0.0:
            norm = -norm
        diagonal[k] = norm
        a[k, k] -= norm
        scale = -1.0 / (norm * a[k, k])
        for j in range(k + 1, n):
            dot = 0.0
            for i in range(k, m):
                dot += a[i, k] * a[i, j]
            dot *= scale
            for i in range(k, m):
                a[i, j] -= dot * a[i, k]
    return 1.0


@kernel
def qr_solve(a: FloatArray, m: int, n: int, diagonal: FloatArray, b: FloatArray) -> None:
    """Solve in the least-squares sense with the factors from `qr_factor`; b[:n] is overwritten by the solution."""
    for k in range(n):
        dot = 0.0
        for i in range(k, m):
            dot += a[i, k] * b[i]
        dot *= -1.0 / (diagonal[k] * a[k, k])
        for i in range(k, m):
            b[i] -= dot * a[i, k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k, j] * b[j]
        b[k] /= diagonal[k]
