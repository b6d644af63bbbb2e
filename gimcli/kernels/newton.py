"""Newton-Raphson on the base nodes of a coupled group, row after row of a motion.

With base nodes b and carried nodes linear in them, p = C b + c, the equations are

    distance   |q - p|^2 - L^2 = 0, divided by 2 L
    line       n.(p - q) - d = 0,   n = w (V - U) or a known direction
    closure    p - q - w (V - U) = 0

and their gradients follow from the complex coefficients C. Each step is Newton's, then one more
with the same factors: its length estimates the error that the first left behind, and the ratio of
the two is the contraction that tells whether the start was near enough (Deuflhard).

Arrays: x, y (rows, nodes) positions in local numbers, base nodes first; dx, dy (rows, registers);
values, cos, sin (rows, actuators); vi (vectors, 5) u, v, register, actuator, turn; vz (vectors, 2);
pi (places, 3) node, anchor, vector; ei (equations, 5) kind, p, q, vector, actuator;
ev (equations, 2) constant, gain; time (rows,).
"""

from __future__ import annotations

import math

import numpy as np

from gimcli.kernels.jit import kernel
from gimcli.kernels.linear import lu_factor, lu_solve, qr_factor, qr_solve
from gimcli.kernels.vector import turned
from gimcli.mechanism import FloatArray, IntArray

DISTANCE = 0
LINE = 1
CLOSURE = 2


@kernel
def vector_at(
    k: int,
    vi: IntArray,
    vz: FloatArray,
    x: FloatArray,
    y: FloatArray,
    dx: FloatArray,
    dy: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
) -> tuple[float, float]:
    """Return vector k at a row's positions and directions."""
    zr, zi = turned(vz[k, 0], vz[k, 1], vi[k, 3], vi[k, 4], cos, sin)
    u = vi[k, 0]
    if u >= 0:
        v = vi[k, 1]
        bx, by = x[v] - x[u], y[v] - y[u]
    elif vi[k, 2] >= 0:
        bx, by = dx[vi[k, 2]], dy[vi[k, 2]]
    else:
        return zr, zi
    return zr * bx - zi * by, zr * by + zi * bx


@kernel
def carry(
    x: FloatArray,
    y: FloatArray,
    dx: FloatArray,
    dy: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
    vi: IntArray,
    vz: FloatArray,
    pi: IntArray,
) -> None:
    """Carry the nodes that are linear in the base nodes."""
    for k in range(pi.shape[0]):
        ex, ey = vector_at(pi[k, 2], vi, vz, x, y, dx, dy, cos, sin)
        x[pi[k, 0]] = x[pi[k, 1]] + ex
        y[pi[k, 0]] = y[pi[k, 1]] + ey


@kernel
def coefficients(
    cr: FloatArray, ci: FloatArray, cos: FloatArray, sin: FloatArray, vi: IntArray, vz: FloatArray, pi: IntArray
) -> None:
    """Fill C (nodes, base nodes): base rows are the unit matrix, known nodes have zeros."""
    nb = cr.shape[1]
    for k in range(pi.shape[0]):
        node, anchor, w = pi[k, 0], pi[k, 1], pi[k, 2]
        zr, zi = turned(vz[w, 0], vz[w, 1], vi[w, 3], vi[w, 4], cos, sin)
        u, v = vi[w, 0], vi[w, 1]
        for j in range(nb):
            cr[node, j] = cr[anchor, j]
            ci[node, j] = ci[anchor, j]
            if u >= 0:
                er, ei = cr[v, j] - cr[u, j], ci[v, j] - ci[u, j]
                cr[node, j] += zr * er - zi * ei
                ci[node, j] += zr * ei + zi * er


@kernel
def equations(
    x: FloatArray,
    y: FloatArray,
    dx: FloatArray,
    dy: FloatArray,
    values: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
    vi: IntArray,
    vz: FloatArray,
    ei: IntArray,
    ev: FloatArray,
    f: FloatArray,
) -> None:
    """Fill the residuals f (lengths)."""
    row = 0
    for k in range(ei.shape[0]):
        p, q = ei[k, 1], ei[k, 2]
        px, py = x[p] - x[q], y[p] - y[q]
        value = ev[k, 0]
        if ei[k, 4] >= 0:
            value += ev[k, 1] * values[ei[k, 4]]
        if ei[k, 0] == DISTANCE:
            f[row] = (px * px + py * py - value * value) / (2.0 * value)
        else:
            nx, ny = vector_at(ei[k, 3], vi, vz, x, y, dx, dy, cos, sin)
            if ei[k, 0] == LINE:
                f[row] = nx * px + ny * py - value
            else:
                f[row] = px - nx
                row += 1
                f[row] = py - ny
        row += 1


@kernel
def jacobian(
    x: FloatArray,
    y: FloatArray,
    dx: FloatArray,
    dy: FloatArray,
    values: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
    vi: IntArray,
    vz: FloatArray,
    ei: IntArray,
    ev: FloatArray,
    cr: FloatArray,
    ci: FloatArray,
    j: FloatArray,
) -> None:
    """Fill the gradients j (equations, 2 x base nodes) by the coordinates of the base nodes."""
    nb = cr.shape[1]
    row = 0
    for k in range(ei.shape[0]):
        kind, p, q, w = ei[k, 0], ei[k, 1], ei[k, 2], ei[k, 3]
        px, py = x[p] - x[q], y[p] - y[q]
        value = ev[k, 0]
        if ei[k, 4] >= 0:
            value += ev[k, 1] * values[ei[k, 4]]
        nx, ny, zr, zi, u, v = 0.0, 0.0, 0.0, 0.0, -1, -1
        if kind != DISTANCE:
            nx, ny = vector_at(w, vi, vz, x, y, dx, dy, cos, sin)
            zr, zi = turned(vz[w, 0], vz[w, 1], vi[w, 3], vi[w, 4], cos, sin)
            u, v = vi[w, 0], vi[w, 1]
        for b in range(nb):
            gr, gi = cr[p, b] - cr[q, b], ci[p, b] - ci[q, b]
            er, ee = 0.0, 0.0
            if u >= 0:
                hr, hi = cr[v, b] - cr[u, b], ci[v, b] - ci[u, b]
                er, ee = zr * hr - zi * hi, zr * hi + zi * hr
            if kind == DISTANCE:
                j[row, 2 * b] = (px * gr + py * gi) / value
                j[row, 2 * b + 1] = (py * gr - px * gi) / value
            elif kind == LINE:
                j[row, 2 * b] = nx * gr + ny * gi + px * er + py * ee
                j[row, 2 * b + 1] = ny * gr - nx * gi + py * er - px * ee
            else:
                j[row, 2 * b] = gr - er
                j[row, 2 * b + 1] = ee - gi
                j[row + 1, 2 * b] = gi - ee
                j[row + 1, 2 * b + 1] = gr - er
        row += 2 if kind == CLOSURE else 1


@kernel
def move(x: FloatArray, y: FloatArray, f: FloatArray, nb: int) -> float:
    """Subtract a correction from the base nodes; return its greatest length."""
    worst = 0.0
    for b in range(nb):
        sx, sy = f[2 * b], f[2 * b + 1]
        x[b] -= sx
        y[b] -= sy
        length = math.sqrt(sx * sx + sy * sy)
        if not length <= worst:  # a NaN stays
            worst = length
    return worst


@kernel
def least_pivot(j: FloatArray, n: int, diagonal: FloatArray, square: bool) -> float:
    """Return the smallest pivot of a factored table: a bound on how far it is from singular."""
    least = abs(j[0, 0]) if square else abs(diagonal[0])
    for k in range(1, n):
        pivot = abs(j[k, k]) if square else abs(diagonal[k])
        if pivot < least:
            least = pivot
    return least


@kernel
def newton(
    x: FloatArray,
    y: FloatArray,
    dx: FloatArray,
    dy: FloatArray,
    values: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
    vi: IntArray,
    vz: FloatArray,
    pi: IntArray,
    ei: IntArray,
    ev: FloatArray,
    cr: FloatArray,
    ci: FloatArray,
    j: FloatArray,
    f: FloatArray,
    order: FloatArray,
    limits: FloatArray,
    out: FloatArray,
) -> bool:
    """Settle one row from the base nodes in x, y; return whether it did.

    limits: tolerance, iterations, greatest first step, greatest contraction, least pivot, rounding.
    out: iterations, estimated error, sign of the determinant, first step, contraction, sign at the
    last good row, 1 where the row is singular to the tolerance.
    """
    nb, m, n = cr.shape[1], f.shape[0], 2 * cr.shape[1]
    out[0], out[4], out[6] = 0.0, 0.0, 0.0
    carry(x, y, dx, dy, cos, sin, vi, vz, pi)
    coefficients(cr, ci, cos, sin, vi, vz, pi)
    for _ in range(int(limits[1])):
        out[0] += 1.0
        equations(x, y, dx, dy, values, cos, sin, vi, vz, ei, ev, f)
        jacobian(x, y, dx, dy, values, cos, sin, vi, vz, ei, ev, cr, ci, j)
        sign = lu_factor(j, n, order) if m == n else qr_factor(j, m, n, order)
        out[2] = sign
        pivot = least_pivot(j, n, order, m == n) if sign != 0.0 else 0.0
        if not pivot >= limits[4]:
            out[6] = 1.0
            return False
        finest = max(limits[0], limits[5] / pivot)  # what rounding leaves of a correction
        if m == n:
            lu_solve(j, n, order, f)
        else:
            qr_solve(j, m, n, order, f)
        first = move(x, y, f, nb)
        if out[0] == 1.0:
            out[3] = first
        if not first <= limits[2]:
            return False
        carry(x, y, dx, dy, cos, sin, vi, vz, pi)
        equations(x, y, dx, dy, values, cos, sin, vi, vz, ei, ev, f)
        if m == n:
            lu_solve(j, n, order, f)
        else:
            qr_solve(j, m, n, order, f)
        second = move(x, y, f, nb)
        carry(x, y, dx, dy, cos, sin, vi, vz, pi)
        out[1] = max(second, limits[5] / pivot)
        if first > 1e4 * finest and second > limits[3] * first:
            out[4] = second / first
            return False
        if second <= finest:
            return True
    return False


@kernel
def predict(x: FloatArray, y: FloatArray, time: FloatArray, r: int, nb: int) -> float:
    """Start row r by the polynomial through the rows before it, up to four of like spacing.

    Returns the length of the step foreseen, infinite where only one row is behind.
    """
    count = 1
    step = time[r] - time[r - 1]
    while count < 4 and r - count - 1 >= 0:
        gap = time[r - count] - time[r - count - 1]
        if gap == 0.0 or not 0.5 <= step / gap <= 2.0:
            break
        count += 1
    for b in range(nb):
        x[r, b], y[r, b] = 0.0, 0.0
    for i in range(1, count + 1):
        weight = 1.0
        for k in range(1, count + 1):
            if k != i:
                weight *= (time[r] - time[r - k]) / (time[r - i] - time[r - k])
        for b in range(nb):
            x[r, b] += weight * x[r - i, b]
            y[r, b] += weight * y[r - i, b]
    if count == 1:
        return math.inf
    way = 0.0
    for b in range(nb):
        sx, sy = x[r, b] - x[r - 1, b], y[r, b] - y[r - 1, b]
        way = max(way, math.sqrt(sx * sx + sy * sy))
    return way


@kernel
def newton_rows(
    x: FloatArray,
    y: FloatArray,
    dx: FloatArray,
    dy: FloatArray,
    values: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
    vi: IntArray,
    vz: FloatArray,
    pi: IntArray,
    ei: IntArray,
    ev: FloatArray,
    nb: int,
    time: FloatArray,
    start: int,
    sign: float,
    limits: FloatArray,
    iterations: FloatArray,
    errors: FloatArray,
    out: FloatArray,
) -> int:
    """Follow a motion from row `start` on; return the first row that did not settle safely.

    `sign` is the determinant's sign on this branch (0: not known yet); a change is not safe. out[5]
    is the sign at the last row that is.
    """
    rows, nodes = x.shape
    m = 0
    for k in range(ei.shape[0]):
        m += 2 if ei[k, 0] == CLOSURE else 1
    cr, ci = np.zeros((nodes, nb)), np.zeros((nodes, nb))
    for b in range(nb):
        cr[b, b] = 1.0
    j, f, order = np.zeros((m, 2 * nb)), np.zeros(m), np.zeros(2 * nb)
    out[5] = sign
    for r in range(start, rows):
        way = predict(x, y, time, r, nb)
        good = newton(
            x[r], y[r], dx[r], dy[r], values[r], cos[r], sin[r], vi, vz, pi, ei, ev, cr, ci, j, f, order, limits, out
        )
        iterations[r], errors[r] = out[0], out[1]
        turned = m == 2 * nb and sign != 0.0 and out[2] != sign
        if not good or turned or out[3] > 0.5 * way + 0.05 * limits[2]:  # not where it was foreseen
            return r
        sign = out[2]
        out[5] = sign
    return rows


@kernel
def newton_once(
    x: FloatArray,
    y: FloatArray,
    dx: FloatArray,
    dy: FloatArray,
    values: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
    vi: IntArray,
    vz: FloatArray,
    pi: IntArray,
    ei: IntArray,
    ev: FloatArray,
    nb: int,
    limits: FloatArray,
    out: FloatArray,
) -> bool:
    """Settle a single row from the base nodes given; return whether it did."""
    m = 0
    for k in range(ei.shape[0]):
        m += 2 if ei[k, 0] == CLOSURE else 1
    cr, ci = np.zeros((x.shape[0], nb)), np.zeros((x.shape[0], nb))
    for b in range(nb):
        cr[b, b] = 1.0
    j, f, order = np.zeros((m, 2 * nb)), np.zeros(m), np.zeros(2 * nb)
    return newton(x, y, dx, dy, values, cos, sin, vi, vz, pi, ei, ev, cr, ci, j, f, order, limits, out)
