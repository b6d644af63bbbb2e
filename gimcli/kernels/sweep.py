"""Sweeps of the Geometrical-Iterative Method: each move places one node on one locus.

    RD   B moves to A + L (B - A) / |B - A|
    RA   B rotates about the vertex onto the ray
    RL   B moves to its foot on the line, or a node of the guide moves until the line passes through B

Source: Petuya et al. 2004, section 3; errors are eqs (1) and (2).

Sweeps that do not converge stop early, with a status: the nodes are where they were one sweep before (stalled) or
several sweeps before (cycling), the error hardly decreases (stalled), or the coordinates are not finite (diverged).
Cycles are detected by Brent's method, with saved positions at sweeps 1, 2, 4, 8 ... Source: Brent, BIT 20 (1980)
176-184, section 2.

Arrays: mi (moves, 9) kind, moved, a, b, value actuator, u, v, turning actuator, turn;
mz (moves, 4) constant, gain, zr, zi.
"""

from __future__ import annotations

import math

from gimcli.kernels.jit import kernel
from gimcli.kernels.vector import stretched, turned, value_at
from gimcli.mechanism import ANGLE, HEIGHT, SPAN, FloatArray, IntArray

AIM = 4

SETTLED, EXHAUSTED, STALLED, CYCLING, DIVERGED = range(5)


@kernel
def turn_onto(x: FloatArray, y: FloatArray, b: int, a: int, ux: float, uy: float) -> None:
    """Rotate node b about node a onto the ray along (ux, uy)."""
    wx, wy = x[b] - x[a], y[b] - y[a]
    u2 = ux * ux + uy * uy
    if u2 == 0.0:  # no direction: the nodes of the arm coincide until another move separates them
        return
    reach = math.sqrt(wx * wx + wy * wy) / math.sqrt(u2)
    x[b], y[b] = x[a] + reach * ux, y[a] + reach * uy


@kernel
def impose(
    k: int, x: FloatArray, y: FloatArray, values: FloatArray, cos: FloatArray, sin: FloatArray, mi: IntArray,
    mz: FloatArray,
) -> None:  # fmt: skip
    """Impose restriction k by moving its node."""
    kind, moved, a, b = mi[k, 0], mi[k, 1], mi[k, 2], mi[k, 3]
    value = value_at(mz[k, 0], mz[k, 1], mi[k, 4], values)
    if kind == SPAN:
        other = a if moved == b else b
        dx, dy = x[moved] - x[other], y[moved] - y[other]
        d = math.sqrt(dx * dx + dy * dy)
        if d == 0.0:  # coincident nodes: any direction, always the same
            dx, d = 1.0, 1.0
        x[moved], y[moved] = x[other] + value / d * dx, y[other] + value / d * dy
        return
    zr, zi = turned(mz[k, 2], mz[k, 3], mi[k, 7], mi[k, 8], cos, sin)
    u, v = mi[k, 5], mi[k, 6]
    wx, wy = stretched(zr, zi, u, v, x, y)
    if kind == ANGLE:
        if moved == b:
            turn_onto(x, y, b, a, wx, wy)
        elif moved == a:
            turn_onto(x, y, a, b, -wx, -wy)
        else:  # a node of the arm u-v: rotated so that the ray passes through b
            ex, ey = x[b] - x[a], y[b] - y[a]
            wx, wy = zr * ex + zi * ey, zr * ey - zi * ex
            if moved == v:
                turn_onto(x, y, v, u, wx, wy)
            else:
                turn_onto(x, y, u, v, -wx, -wy)
    elif kind == HEIGHT:
        norm = math.sqrt(wx * wx + wy * wy)
        if norm == 0.0:
            return
        gap = ((x[b] - x[a]) * wx + (y[b] - y[a]) * wy) / norm - value
        x[b] -= gap * wx / norm
        y[b] -= gap * wy / norm
    else:
        aim(x, y, moved, b, u, v, zr, zi, wx, wy, value)


@kernel
def aim(
    x: FloatArray, y: FloatArray, moved: int, b: int, u: int, v: int, zr: float, zi: float, wx: float, wy: float,
    value: float,
) -> None:  # fmt: skip
    """Move a node of a guide u-v with normal n = z (v - u) by the shortest step after which its line passes through b.

    With f = n.(b - u) - value, v moves along conj(z) (b - u), and u along -conj(z) (b - u) - n.
    """
    px, py = x[b] - x[u], y[b] - y[u]
    f = wx * px + wy * py - value
    gx, gy = zr * px + zi * py, zr * py - zi * px
    if moved == u:
        gx, gy = -gx - wx, -gy - wy
    g2 = gx * gx + gy * gy
    if g2 > 0.0:
        x[moved] -= f * gx / g2
        y[moved] -= f * gy / g2


@kernel
def error_of(
    k: int, x: FloatArray, y: FloatArray, values: FloatArray, cos: FloatArray, sin: FloatArray, mi: IntArray,
    mz: FloatArray, size: float,
) -> float:  # fmt: skip
    """Return the error of restriction k: relative for lengths, the sine of the error for angles."""
    kind, a, b = mi[k, 0], mi[k, 2], mi[k, 3]
    value = value_at(mz[k, 0], mz[k, 1], mi[k, 4], values)
    px, py = x[b] - x[a], y[b] - y[a]
    if kind == SPAN:
        return abs(math.sqrt(px * px + py * py) / value - 1.0)
    zr, zi = turned(mz[k, 2], mz[k, 3], mi[k, 7], mi[k, 8], cos, sin)
    wx, wy = stretched(zr, zi, mi[k, 5], mi[k, 6], x, y)
    norm = math.sqrt(wx * wx + wy * wy)
    if kind == ANGLE:
        both = norm * math.sqrt(px * px + py * py)
        sine, cosine = (wx * py - wy * px) / both, (wx * px + wy * py) / both
        return abs(sine) if cosine > 0.0 else 2.0 - abs(sine)
    return abs((wx * px + wy * py) / norm - value) / size


@kernel
def sweep(
    x: FloatArray, y: FloatArray, values: FloatArray, cos: FloatArray, sin: FloatArray, mi: IntArray, mz: FloatArray
) -> None:
    """Impose all restrictions once, in order."""
    for k in range(mi.shape[0]):
        impose(k, x, y, values, cos, sin, mi, mz)


@kernel
def worst_errors(
    x: FloatArray, y: FloatArray, values: FloatArray, cos: FloatArray, sin: FloatArray, mi: IntArray, mz: FloatArray,
    size: float, out: FloatArray,
) -> None:  # fmt: skip
    """Store the errors of eqs (1) and (2) in out[0] and out[1]; a NaN counts as infinite."""
    out[0], out[1] = 0.0, 0.0
    for k in range(mi.shape[0]):
        e = error_of(k, x, y, values, cos, sin, mi, mz, size)
        part = 1 if mi[k, 0] == ANGLE else 0
        if not e <= out[part]:
            out[part] = e if math.isfinite(e) else math.inf


@kernel
def compare_with_mark(x: FloatArray, y: FloatArray, mark: FloatArray, near: float) -> int:
    """Return 1 if the nodes are at the saved positions `mark` (2, nodes), 0 if not, -1 if they are not finite."""
    back = 1
    for k in range(x.shape[0]):
        if not math.isfinite(x[k] + y[k]):
            return -1
        if not (abs(x[k] - mark[0, k]) <= near and abs(y[k] - mark[1, k]) <= near):
            back = 0
    return back


@kernel
def keep(x: FloatArray, y: FloatArray, mark: FloatArray) -> None:
    """Save the positions of the nodes in `mark` (2, nodes)."""
    for k in range(x.shape[0]):
        mark[0, k], mark[1, k] = x[k], y[k]


@kernel
def settle(
    x: FloatArray, y: FloatArray, values: FloatArray, cos: FloatArray, sin: FloatArray, mi: IntArray, mz: FloatArray,
    size: float, limits: FloatArray, mark: FloatArray, history: FloatArray, out: FloatArray,
) -> int:  # fmt: skip
    """Sweep until the errors of eqs (1) and (2) are within the tolerance; return SETTLED or the reason of failure.

    limits: tolerance, number of sweeps, number of sweeps in which the error must decrease, factor of this decrease, and
    distance relative to the size below which positions count as equal. mark (2, nodes): scratch. history (rows, 2):
    errors before the first and after every sweep, as many as fit. out: errors of eqs (1) and (2), number of sweeps.
    """
    worst_errors(x, y, values, cos, sin, mi, mz, size, out)
    if history.shape[0] > 0:
        history[0, 0], history[0, 1] = out[0], out[1]
    done, marked, end = 0, 0, SETTLED
    last = max(out[0], out[1])
    keep(x, y, mark)
    while end == SETTLED and not (out[0] <= limits[0] and out[1] <= limits[0]):
        if done >= limits[1]:
            end = EXHAUSTED
            break
        sweep(x, y, values, cos, sin, mi, mz)
        done += 1
        worst_errors(x, y, values, cos, sin, mi, mz, size, out)
        if done < history.shape[0]:
            history[done, 0], history[done, 1] = out[0], out[1]
        converged = out[0] <= limits[0] and out[1] <= limits[0]
        here = compare_with_mark(x, y, mark, limits[4] * size)
        if here < 0:
            end = DIVERGED
        elif here > 0 and not converged:
            end = STALLED if done - marked == 1 else CYCLING
        if done == 2 * marked or marked == 0:
            keep(x, y, mark)
            marked = done
        if done % limits[2] == 0:
            now = max(out[0], out[1])
            if end == SETTLED and not converged and math.isfinite(last) and not now <= limits[3] * last:
                end = STALLED
            last = now
    out[2] = done
    return end


@kernel
def settle_rows(
    x: FloatArray, y: FloatArray, values: FloatArray, cos: FloatArray, sin: FloatArray, free: IntArray, mi: IntArray,
    mz: FloatArray, size: float, start: int, slow: float, limits: FloatArray, mark: FloatArray, history: FloatArray,
    sweeps: FloatArray, out: FloatArray,
) -> int:  # fmt: skip
    """Solve a motion from row `start` on, each row starting from the one before; return the first row not solved.

    x, y (rows, nodes). free: nodes to be moved; the others are already in place in every row. It also stops after a
    row with more than `slow` sweeps. out: as in `settle`, then the result of `settle` for the last row.
    """
    for r in range(start, x.shape[0]):
        for k in range(free.shape[0]):
            x[r, free[k]], y[r, free[k]] = x[r - 1, free[k]], y[r - 1, free[k]]
        end = settle(x[r], y[r], values[r], cos[r], sin[r], mi, mz, size, limits, mark, history, out)
        sweeps[r] = out[2]
        out[3] = end
        if end != SETTLED:
            return r
        if out[2] > slow:
            return r + 1
    return x.shape[0]
