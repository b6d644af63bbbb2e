"""The operations of a tape on any numbers: arrays over rows, or dual numbers with derivatives by the dimensions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import nominal
from gimcli.kernels import tape as kernels
from gimcli.mechanism import IntArray

Lanes = dict[int, Any]


def tape_values(heads: IntArray, factors: Sequence[Sequence[Any]], w: Lanes, z: Any, given: Any) -> tuple[Any, Any]:
    """Return points[slot, point] and angles[slot, member] (rows,) as dicts.

    factors (operations, 2) and the constants in the lanes w: numbers. z[node] and given[slot, actuator] (rows,).
    """
    points: dict[tuple[int, int], Any] = {}
    angles: dict[tuple[int, int], Any] = {}

    def pair(k: int) -> Any:
        return w[k] + 1j * w[k + 1]

    for head, (f, g) in zip(heads.tolist(), factors, strict=True):
        op, to, a, b, *more = head
        if op == kernels.WRITE_POINT:
            points[a, b] = pair(to)
        elif op == kernels.WRITE_ANGLE:
            angles[a, b] = w[to]
        elif op == kernels.FACTOR:
            pass
        elif op == kernels.SOLVE:
            m, n = int(nominal(f)), int(nominal(g))
            _solve(w, to, a, m, n)
        elif op in REAL:
            w[to] = REAL[op](w, pair, f, g, a, b, *more) + (w[to] if op in ADDED else 0.0)
        else:
            if op == kernels.NODE:
                found = z[a]
            elif op == kernels.VALUE:
                w[to] = given[a, b]
                continue
            else:
                found = COMPLEX[op](w, pair, f + 1j * g, a, b, *more) + (pair(to) if op in ADDED else 0.0)
            w[to], w[to + 1] = found.real, found.imag
    return points, angles


Operation = Callable[..., Any]

REAL: dict[int, Operation] = {
    kernels.DOT: lambda w, pair, f, g, a, b, *_: f * (w[a] * w[b] + w[a + 1] * w[b + 1]),
    kernels.PRODUCT: lambda w, pair, f, g, a, b, *_: f * w[a] * w[b],
    kernels.AFFINE: lambda w, pair, f, g, a, *_: f + g * w[a],
    kernels.INVERSE: lambda w, pair, f, g, a, *_: 1.0 / (w[a] * w[a] + w[a + 1] * w[a + 1]),
    kernels.ACROSS: lambda w, pair, f, g, a, b, c, _: _cross(w, a, b) * w[c],
    kernels.DETERMINANT: lambda w, pair, f, g, a, b, *_: 1.0 / _cross(w, a, b),
}
"""Operations with a real result."""
REAL |= {kernels.ADD_DOT: REAL[kernels.DOT], kernels.ADD_PRODUCT: REAL[kernels.PRODUCT]}

COMPLEX: dict[int, Operation] = {
    kernels.SCALE: lambda w, pair, z, a, *_: z * pair(a),
    kernels.LINEAR: lambda w, pair, z, a, b, *_: pair(a) + z * pair(b),
    kernels.CARRY: lambda w, pair, z, a, b, c, _: pair(a) + z * (pair(b) - pair(c)),
    kernels.TIMES: lambda w, pair, z, a, b, *_: z.real * pair(a) * pair(b),
    kernels.CONJUGATE: lambda w, pair, z, a, b, *_: z.real * pair(a).conjugate() * pair(b),
    kernels.TURN: lambda w, pair, z, a, b, *_: z.real * 1j * w[a] * pair(b),
    kernels.COS_SIN: lambda w, pair, z, a, *_: np.cos(w[a]) + 1j * np.sin(w[a]),
    kernels.UNIT: lambda w, pair, z, a, *_: pair(a) / abs(pair(a)),
    kernels.MEET: lambda w, pair, z, a, b, c, d: 1j * (w[c] * pair(b) - w[c + 1] * pair(a)) * w[d],
    kernels.NEGATIVE: lambda w, pair, z, a, *_: -pair(a),
}
"""Operations with a complex result."""
COMPLEX |= {
    kernels.ADD_TIMES: COMPLEX[kernels.TIMES],
    kernels.ADD_CONJUGATE: COMPLEX[kernels.CONJUGATE],
    kernels.ADD_TURN: COMPLEX[kernels.TURN],
}

ADDED = {
    kernels.ADD_DOT, kernels.ADD_PRODUCT, kernels.ADD_TIMES, kernels.ADD_CONJUGATE, kernels.ADD_TURN,
}  # fmt: skip
"""Operations that add to their lanes."""


def _cross(w: Lanes, a: int, b: int) -> Any:
    return w[a] * w[b + 1] - w[a + 1] * w[b]


def _solve(w: Lanes, right: int, a: int, m: int, n: int) -> None:
    """Solve the equations A x = b of a group in place of b; the derivatives are those of A x' = b' - A' x."""
    some = sum((0.0 * w[right + k] for k in range(m)), 0.0)
    table, own = (
        np.stack([w[k] + some for k in range(first, first + count)]) for first, count in ((a, m * n), (right, m))
    )
    known = np.nan_to_num(np.moveaxis(nominal(table).reshape(m, n, -1), 2, 0))
    inverse = np.linalg.pinv(known)
    found = np.einsum("rnm,mr->nr", inverse, nominal(own))
    if isinstance(own, Dual):
        moved = own.slopes - np.einsum("tmnr,nr->tmr", table.slopes.reshape(-1, m, n, found.shape[1]), found)
        found = Dual(found, np.einsum("rnm,tmr->tnr", inverse, moved))
    for k in range(n):
        w[right + k] = found[k]
