"""Newton-Raphson on the base nodes of a coupled group, row after row of a motion.

With base nodes b and carried nodes linear in them, p = C b + c, the equations are

    distance   |q - p|^2 - L^2 = 0, divided by 2 L
    line       n.(p - q) - d = 0,   n = w (V - U) or a known direction
    closure    p - q - w (V - U) = 0

and their gradients follow from the complex coefficients C. The factors of the Jacobian are reused while the nodes move
little (simplified Newton). The ratio of two corrections with the same factors is the contraction; it shows whether the
start was close enough (Deuflhard 2011, section 2.1).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gimcli.kernels.jit import kernel, stage, stub
from gimcli.kernels.linear import lu_factor, lu_solve, qr_factor, qr_solve
from gimcli.kernels.vector import stretched, turned, value_at
from gimcli.mechanism import CLOSURE, HEIGHT, SPAN, FloatArray, IntArray

RENEWED = 128
"""Number of rows after which the factors are always renewed, so that results do not depend on the block length."""

SLOW = 0.02
"""Contraction above which the factors are renewed."""

FALL = 0.2
"""A row is doubtful if the determinant falls below this fraction of that in the row before: branches may meet between
the two rows, and be too close to be distinguished by the prediction. (The determinant is used because the least pivot
is discontinuous where the order of the pivots changes; their product is continuous.)"""

LIKE = 0.4
"""Least ratio of two steps in one extrapolation: behind a singular position a step is half the one before."""

SAME_STEP = 1e-6
"""Relative difference up to which time steps count as equal."""


class GroupArrays(NamedTuple):
    """A coupled group; its nodes are numbered in the order base, carried, known."""

    base: int  # number of base nodes
    rows: int  # number of scalar equations
    turning: bool  # an actuator rotates a carrying vector: C differs from row to row
    nodes: IntArray  # (nodes,) numbers in the mechanism
    vi: IntArray  # (vectors, 5) u, v, register, actuator, turn
    vz: FloatArray  # (vectors, 2)
    pi: IntArray  # (places, 3) node, anchor, vector
    ei: IntArray  # (equations, 5) kind, p, q, vector, actuator
    ev: FloatArray  # (equations, 2) constant, gain


class StopLimits(NamedTuple):
    """Stopping criteria; lengths in the normal frame."""

    finest: float  # a row is solved if the correction is below this
    iterations: int
    first: float  # greatest first correction
    contraction: float  # greatest ratio of two corrections
    pivot: float  # least pivot
    rounding: float  # rounding error of an equation
    reach: float  # factors are reused while the displacement of the nodes is below this times the least pivot


class RowPosition(NamedTuple):
    """One row of a group: given and unknown quantities, and scratch arrays."""

    x: FloatArray  # (nodes,) by local numbers
    y: FloatArray
    dx: FloatArray  # (registers,)
    dy: FloatArray
    values: FloatArray  # (actuators,)
    cos: FloatArray
    sin: FloatArray
    cr: FloatArray  # (nodes, base) C
    ci: FloatArray
    j: FloatArray  # (equations, 2 base) gradients, then their factors
    f: FloatArray  # (equations,)
    order: FloatArray  # (4 base,) of the factors
    fx: FloatArray  # (base,) position at which the factors were computed
    fy: FloatArray
    weights: FloatArray  # (4,) of the extrapolation
    out: FloatArray  # (8,) results, see ITERATIONS to SINGULAR


ITERATIONS, ERROR, SIGN, FIRST, PIVOT, VOLUME, LAST_SIGN, SINGULAR = range(8)
"""Entries of `out`: number of iterations, estimated error, sign of the determinant (0: no factors), first correction,
least pivot, |determinant|, sign at the last solved row, 1 if the row is singular to the tolerance."""


def room(groups: Sequence[GroupArrays], registers: int, actuators: int) -> RowPosition:
    """Return scratch arrays for one row, large enough for any of the groups."""
    nodes = max((len(g.nodes) for g in groups), default=0)
    nb, m = max((g.base for g in groups), default=0), max((g.rows for g in groups), default=0)
    return RowPosition(
        np.zeros(nodes), np.zeros(nodes), np.zeros(registers), np.zeros(registers), np.zeros(actuators),
        np.zeros(actuators), np.zeros(actuators), np.zeros((nodes, nb)), np.zeros((nodes, nb)), np.zeros((m, 2 * nb)),
        np.zeros(m), np.zeros(4 * nb), np.zeros(nb), np.zeros(nb), np.zeros(4), np.zeros(8),
    )  # fmt: skip


@kernel
def vector_at(g: GroupArrays, p: RowPosition, k: int) -> tuple[float, float]:
    """Return the value of vector k in a row."""
    zr, zi = turned(g.vz[k, 0], g.vz[k, 1], g.vi[k, 3], g.vi[k, 4], p.cos, p.sin)
    register = g.vi[k, 2]
    if register >= 0:
        bx, by = p.dx[register], p.dy[register]
        return zr * bx - zi * by, zr * by + zi * bx
    return stretched(zr, zi, g.vi[k, 0], g.vi[k, 1], p.x, p.y)


@kernel
def carry(g: GroupArrays, p: RowPosition) -> None:
    """Compute the positions of the carried nodes."""
    for k in range(g.pi.shape[0]):
        ex, ey = vector_at(g, p, g.pi[k, 2])
        p.x[g.pi[k, 0]] = p.x[g.pi[k, 1]] + ex
        p.y[g.pi[k, 0]] = p.y[g.pi[k, 1]] + ey


@kernel
def clear(g: GroupArrays, p: RowPosition) -> None:
    """Initialise the scratch arrays for a group."""
    p.out[SIGN] = 0.0
    for k in range(len(g.nodes)):
        for b in range(g.base):
            p.cr[k, b], p.ci[k, b] = 1.0 if k == b else 0.0, 0.0


@stage
def coefficients(g: GroupArrays, p: RowPosition) -> None:
    """Fill C (nodes, base nodes): base rows are the unit matrix, known nodes have zeros."""
    for k in range(g.pi.shape[0]):
        node, anchor, w = g.pi[k, 0], g.pi[k, 1], g.pi[k, 2]
        zr, zi = turned(g.vz[w, 0], g.vz[w, 1], g.vi[w, 3], g.vi[w, 4], p.cos, p.sin)
        u, v = g.vi[w, 0], g.vi[w, 1]
        for b in range(g.base):
            p.cr[node, b] = p.cr[anchor, b]
            p.ci[node, b] = p.ci[anchor, b]
            if u >= 0:
                er, ei = p.cr[v, b] - p.cr[u, b], p.ci[v, b] - p.ci[u, b]
                p.cr[node, b] += zr * er - zi * ei
                p.ci[node, b] += zr * ei + zi * er


@kernel
def equations(g: GroupArrays, s: RowPosition) -> None:
    """Fill the residuals f (lengths)."""
    row = 0
    for k in range(g.ei.shape[0]):
        p, q = g.ei[k, 1], g.ei[k, 2]
        px, py = s.x[p] - s.x[q], s.y[p] - s.y[q]
        value = value_at(g.ev[k, 0], g.ev[k, 1], g.ei[k, 4], s.values)
        if g.ei[k, 0] == SPAN:
            s.f[row] = (px * px + py * py - value * value) / (2.0 * value)
        else:
            nx, ny = vector_at(g, s, g.ei[k, 3])
            if g.ei[k, 0] == HEIGHT:
                s.f[row] = nx * px + ny * py - value
            else:
                s.f[row] = px - nx
                row += 1
                s.f[row] = py - ny
        row += 1


@stage
def jacobian(g: GroupArrays, s: RowPosition) -> None:
    """Fill the gradients j (equations, 2 x base nodes) by the coordinates of the base nodes."""
    j, cr, ci = s.j, s.cr, s.ci
    row = 0
    for k in range(g.ei.shape[0]):
        kind, p, q, w = g.ei[k, 0], g.ei[k, 1], g.ei[k, 2], g.ei[k, 3]
        px, py = s.x[p] - s.x[q], s.y[p] - s.y[q]
        value = value_at(g.ev[k, 0], g.ev[k, 1], g.ei[k, 4], s.values)
        nx, ny, zr, zi, u, v = 0.0, 0.0, 0.0, 0.0, -1, -1
        if kind != SPAN:
            nx, ny = vector_at(g, s, w)
            zr, zi = turned(g.vz[w, 0], g.vz[w, 1], g.vi[w, 3], g.vi[w, 4], s.cos, s.sin)
            u, v = g.vi[w, 0], g.vi[w, 1]
        for b in range(g.base):
            gr, gi = cr[p, b] - cr[q, b], ci[p, b] - ci[q, b]
            er, ee = 0.0, 0.0
            if u >= 0:
                hr, hi = cr[v, b] - cr[u, b], ci[v, b] - ci[u, b]
                er, ee = zr * hr - zi * hi, zr * hi + zi * hr
            if kind == SPAN:
                j[row, 2 * b] = (px * gr + py * gi) / value
                j[row, 2 * b + 1] = (py * gr - px * gi) / value
            elif kind == HEIGHT:
                j[row, 2 * b] = nx * gr + ny * gi + px * er + py * ee
                j[row, 2 * b + 1] = ny * gr - nx * gi + py * er - px * ee
            else:
                j[row, 2 * b] = gr - er
                j[row, 2 * b + 1] = ee - gi
                j[row + 1, 2 * b] = gi - ee
                j[row + 1, 2 * b + 1] = gr - er
        row += 2 if kind == CLOSURE else 1


@kernel
def move(g: GroupArrays, p: RowPosition) -> float:
    """Subtract the correction f from the base nodes; return the greatest displacement of a node."""
    worst = 0.0
    for b in range(g.base):
        sx, sy = p.f[2 * b], p.f[2 * b + 1]
        p.x[b] -= sx
        p.y[b] -= sy
        square = sx * sx + sy * sy
        if not square <= worst:  # a NaN is kept
            worst = square
    return math.sqrt(worst)


@stage
def factor(g: GroupArrays, p: RowPosition) -> None:
    """Fill and factor the Jacobian; store sign and size of the determinant, and the least pivot, in `out`."""
    jacobian(g, p)
    m, n = g.rows, 2 * g.base
    sign = lu_factor(p.j, n, p.order) if m == n else qr_factor(p.j, m, n, p.order)
    least, volume = 0.0, 0.0
    if sign != 0.0:
        least, volume = math.inf, 1.0
        for k in range(n):
            pivot = abs(p.j[k, k]) if m == n else abs(p.order[k])
            volume *= pivot
            if pivot < least:
                least = pivot
    p.out[SIGN], p.out[PIVOT], p.out[VOLUME] = sign, least, volume
    for b in range(g.base):
        p.fx[b], p.fy[b] = p.x[b], p.y[b]


@kernel
def can_reuse(g: GroupArrays, p: RowPosition, limits: StopLimits) -> bool:
    """Return whether the factors can be reused: the nodes moved so little that the Jacobian cannot be singular."""
    if p.out[SIGN] == 0.0:
        return False
    reach = limits.reach * p.out[PIVOT]
    displacement = 0.0
    for b in range(g.base):
        displacement += abs(p.x[b] - p.fx[b]) + abs(p.y[b] - p.fy[b])
    return displacement <= reach


@kernel
def newton(g: GroupArrays, p: RowPosition, limits: StopLimits) -> bool:
    """Solve one row, starting from the base nodes in x, y; return whether it converged."""
    m, n, out = g.rows, 2 * g.base, p.out
    out[ITERATIONS], out[SINGULAR] = 0.0, 0.0
    previous, fresh = math.inf, False
    carry(g, p)
    slow = not can_reuse(g, p, limits)
    for i in range(limits.iterations):
        out[ITERATIONS] += 1.0
        equations(g, p)
        if slow:
            factor(g, p)
            previous, fresh = math.inf, True
            if not out[PIVOT] >= limits.pivot:
                out[SINGULAR] = 1.0
                return False
        if m == n:
            lu_solve(p.j, n, p.order, p.f)
        else:
            qr_solve(p.j, m, n, p.order, p.f)
        length = move(g, p)
        if i == 0:
            out[FIRST] = length
        if not length <= limits.first:
            return False
        carry(g, p)
        noise = limits.rounding / out[PIVOT]  # rounding error of a correction
        finest = max(limits.finest, noise)
        out[ERROR] = max(length, noise)
        if length <= finest:
            return True
        if fresh and previous > 1e4 * finest and length > limits.contraction * previous:
            return False
        slow = length > SLOW * previous
        previous = length
    return False


@kernel
def predict(x: FloatArray, y: FloatArray, time: FloatArray, r: int, g: GroupArrays, p: RowPosition) -> float:
    """Extrapolate the base nodes to row r by a polynomial through up to four rows before it, of similar spacing.

    Returns the predicted length of the step, infinite if only one row is available.
    """
    weights = p.weights
    count = extrapolation_weights(time, r, weights)
    r1, r2, r3, r4 = r - 1, max(r - 2, 0), max(r - 3, 0), max(r - 4, 0)
    w1, w2, w3, w4 = weights[0], weights[1], weights[2], weights[3]
    square = 0.0
    for b in range(g.base):
        node = g.nodes[b]
        sx = w1 * x[node, r1] + w2 * x[node, r2] + w3 * x[node, r3] + w4 * x[node, r4]
        sy = w1 * y[node, r1] + w2 * y[node, r2] + w3 * y[node, r3] + w4 * y[node, r4]
        p.x[b], p.y[b] = sx, sy
        sx -= x[node, r - 1]
        sy -= y[node, r - 1]
        square = max(square, sx * sx + sy * sy)
    return math.inf if count == 1 else math.sqrt(square)


@kernel
def start_from(x: FloatArray, y: FloatArray, r: int, g: GroupArrays, p: RowPosition) -> float:
    """Start row r at the present positions of its base nodes, without prediction; return infinity."""
    for b in range(g.base):
        p.x[b], p.y[b] = x[g.nodes[b], r], y[g.nodes[b], r]
    return math.inf


@kernel
def volume_at(x: FloatArray, y: FloatArray, r: int, g: GroupArrays, p: RowPosition) -> float:
    """Return |determinant| in a solved row, after `read_row`."""
    start_from(x, y, r, g, p)
    coefficients(g, p)
    carry(g, p)
    factor(g, p)
    return p.out[VOLUME]


@stub(volume_at, "dyads")
def no_volume(x: FloatArray, y: FloatArray, r: int, g: GroupArrays, p: RowPosition) -> float:
    """Replace `volume_at` where there is no coupled group."""
    return 0.0


@kernel
def extrapolation_weights(time: FloatArray, r: int, weights: FloatArray) -> int:
    """Fill the weights (4,) of the rows before row r in the extrapolation; return the number of rows used."""
    step = time[r] - time[r - 1]
    count, even = 1, True
    while count < 4 and r - count - 1 >= 0:
        gap = time[r - count] - time[r - count - 1]
        if gap == 0.0 or not LIKE * gap <= step <= gap / LIKE:
            break
        even = even and abs(step - gap) <= SAME_STEP * step
        count += 1
    if count == 4 and even:
        weights[0], weights[1], weights[2], weights[3] = 4.0, -6.0, 4.0, -1.0
        return count
    for i in range(1, 5):
        weight = 1.0 if i <= count else 0.0
        for k in range(1, count + 1):
            if k != i and i <= count:
                weight *= (time[r] - time[r - k]) / (time[r - i] - time[r - k])
        weights[i - 1] = weight
    return count


@kernel
def read_row(
    x: FloatArray, y: FloatArray, rx: FloatArray, ry: FloatArray, values: FloatArray, cos: FloatArray,
    sin: FloatArray, r: int, g: GroupArrays, p: RowPosition,
) -> None:  # fmt: skip
    """Copy the known nodes, directions and inputs of row r into p."""
    for k in range(g.base + g.pi.shape[0], len(g.nodes)):
        p.x[k], p.y[k] = x[g.nodes[k], r], y[g.nodes[k], r]
    for k in range(len(p.dx)):
        p.dx[k], p.dy[k] = rx[k, r], ry[k, r]
    for k in range(len(p.values)):
        p.values[k], p.cos[k], p.sin[k] = values[k, r], cos[k, r], sin[k, r]


@kernel
def write_row(x: FloatArray, y: FloatArray, r: int, g: GroupArrays, p: RowPosition) -> None:
    """Copy the group's nodes from p to row r."""
    for k in range(g.base + g.pi.shape[0]):
        x[g.nodes[k], r], y[g.nodes[k], r] = p.x[k], p.y[k]


@stage
def solve_group(
    x: FloatArray, y: FloatArray, rx: FloatArray, ry: FloatArray, values: FloatArray, cos: FloatArray,
    sin: FloatArray, time: FloatArray, start: int, end: int, g: GroupArrays, p: RowPosition, sign: float,
    limits: StopLimits,
    iterations: FloatArray, errors: FloatArray, predicted: bool,
) -> int:  # fmt: skip
    """Solve rows start..end of a motion; return the first row that was not solved reliably, or `end`.

    x, y (nodes, rows), rx, ry (registers, rows), values, cos, sin (actuators, rows). sign: sign of the determinant on
    this branch (0: unknown); a row with another sign, or with a much smaller determinant, is not reliable. predicted:
    rows start from the extrapolation of the rows before them, else from the present positions of their base nodes.
    """
    clear(g, p)
    stop, volume = end, 0.0
    if predicted:
        read_row(x, y, rx, ry, values, cos, sin, start - 1, g, p)
        volume = volume_at(x, y, start - 1, g, p)
    for r in range(start, end):
        read_row(x, y, rx, ry, values, cos, sin, r, g, p)
        if g.turning or r == start:
            coefficients(g, p)
        if (r - start) % RENEWED == 0:
            p.out[SIGN] = 0.0
        length = predict(x, y, time, r, g, p) if predicted else start_from(x, y, r, g, p)
        good = newton(g, p, limits)
        write_row(x, y, r, g, p)
        iterations[r] += p.out[ITERATIONS]
        errors[r] = max(errors[r], p.out[ERROR])
        over = g.rows == 2 * g.base and sign != 0.0 and p.out[SIGN] != sign
        over = over or p.out[VOLUME] < FALL * volume
        if not good or over or p.out[FIRST] > 0.5 * length + 0.05 * limits.first:  # far from the prediction
            stop = r
            break
        sign, volume = p.out[SIGN], p.out[VOLUME]
    p.out[LAST_SIGN] = sign
    return stop
