"""Least squares for all rows of lanes at once, by Householder reflections, which need no row exchanges.

A matrix of m by n lanes starts at lane `a`, row by row. `d` is the first of 3 n lanes: 1 / diagonal of R, then the
factors of the reflections, then scratch. Source: Golub & Van Loan, Matrix Computations, 2013, section 5.2.
"""

from __future__ import annotations

import numpy as np

from gimcli.kernels.choice import where
from gimcli.kernels.jit import stage
from gimcli.kernels.lanes import add_product, fill, multiply, real, rows
from gimcli.mechanism import FloatArray


@stage
def normalise(w: FloatArray, a: int, scale: int, m: int, n: int, high: int) -> None:
    """Scale every row of the matrix to length 1; the m lanes from `scale` on are set to 1 / length."""
    for i in range(m):
        fill(w, scale + i, 0.0, high)
        for j in range(n):
            add_product(w, scale + i, a + i * n + j, a + i * n + j, 1.0, high)
        invert_root(w, scale + i, high)
        for j in range(n):
            multiply(w, a + i * n + j, scale + i, high)


@stage
def invert_root(w: FloatArray, k: int, high: int) -> None:
    """Replace a lane of squares s by 1 / sqrt(s), or by 1 where s <= 0."""
    a = w[real(k)]
    for r in rows(high):
        a[r] = 1.0 / np.sqrt(where(a[r] > 0.0, a[r], 1.0))


@stage
def begin_reflection(w: FloatArray, head: int, inverse: int, factor: int, high: int) -> None:
    """Compute the reflection of a column from its first element `head` and its squared length (in `factor`)."""
    a, b, c = w[real(head)], w[real(inverse)], w[real(factor)]
    for r in rows(high):
        norm = np.sqrt(c[r])
        norm = where(a[r] > 0.0, -norm, norm)
        first = a[r] - norm
        b[r] = 1.0 / norm
        c[r] = -1.0 / (norm * first)
        a[r] = first


@stage
def reflect(w: FloatArray, a: int, d: int, k: int, m: int, n: int, to: int, stride: int, dot: int, high: int) -> None:
    """Apply reflection k to the column of lanes to, to + stride, ..."""
    fill(w, dot, 0.0, high)
    for i in range(k, m):
        add_product(w, dot, a + i * n + k, to + i * stride, 1.0, high)
    multiply(w, dot, d + n + k, high)
    for i in range(k, m):
        add_product(w, to + i * stride, a + i * n + k, dot, -1.0, high)


@stage
def factor_rows(w: FloatArray, a: int, d: int, m: int, n: int, dot: int, high: int) -> None:
    """Factor a matrix in place: R above the diagonal, the reflections on and below it; lane `dot` is scratch."""
    for k in range(n):
        fill(w, d + n + k, 0.0, high)
        for i in range(k, m):
            add_product(w, d + n + k, a + i * n + k, a + i * n + k, 1.0, high)
        begin_reflection(w, a + k * n + k, d + k, d + n + k, high)
        for j in range(k + 1, n):
            reflect(w, a, d, k, m, n, a + j, n, dot, high)


@stage
def back_substitute(w: FloatArray, a: int, d: int, n: int, last: int, b: int, high: int) -> None:
    """Solve R x = b for the unknowns up to `last`; the unknowns after it are 0."""
    for k in range(last, -1, -1):
        for j in range(k + 1, last + 1):
            add_product(w, b + k, a + k * n + j, b + j, -1.0, high)
        multiply(w, b + k, d + k, high)


@stage
def solve_rows(w: FloatArray, a: int, d: int, m: int, n: int, b: int, dot: int, high: int) -> None:
    """Solve in the least-squares sense with the factors from `factor_rows`; the first n lanes of b are the solution."""
    for k in range(n):
        reflect(w, a, d, k, m, n, b, 1, dot, high)
    back_substitute(w, a, d, n, n - 1, b, high)


@stage
def inverse_square(w: FloatArray, a: int, d: int, n: int, to: int, high: int) -> None:
    """Fill a lane with the sum of squares of inverse R; 1 / sum bounds the square of the least singular value."""
    fill(w, to, 0.0, high)
    t = d + 2 * n
    for j in range(n):
        for k in range(j):
            fill(w, t + k, 0.0, high)
        fill(w, t + j, 1.0, high)
        back_substitute(w, a, d, n, j, t, high)
        for k in range(j + 1):
            add_product(w, to, t + k, t + k, 1.0, high)
