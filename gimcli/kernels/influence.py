"""A position with its first and second influence coefficients, block by block.

The variables v are x and y of all nodes, all readings (values of actuators and gauges), and 1. Some of them, s, are
independent. The equations are sums of terms c f(u) v_i v_j; each block determines a few variables from those of the
blocks before it. A block of two variables x and y on circles or lines is solved in closed form; the sign of its
determinant selects the solution. The other blocks are solved by Newton-Raphson. Then, with the block's Jacobian J
factored once,

    J dv/ds_k = -(terms along s_k),   J a = -(second derivatives along v'),   v' = sum of dv/ds_k s'_k

so that `a` are the accelerations without the terms of s''. Source: Durango, Giraldo, Calle & Mesa 2014 (module by
module); Haug, Computer-Aided Kinematics and Dynamics, 1989, eqs 3.6.10 and 3.6.11.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.linear import lu_factor, lu_solve
from gimcli.kernels.vector import copy
from gimcli.mechanism import FloatArray, IntArray

NEWTON, LINEAR, PAIR = range(3)
"""Methods of solution of a block; PAIR: closed form for two variables on circles or lines."""

ROUNDS = 12
"""Greatest number of iterations of a block; from a close start it converges in fewer."""

SETTLED = 1e-9
"""A correction below this is the last one, as the next would be about its square."""

MOST_TRIES = 10_000
"""Most positions between two states of a motion; a turn of a crank takes about 20."""

FINEST = 1e-6
"""Least step of the independent variables, in the normal frame or rad."""

MEETING = 1e-4
"""Determinant of a block, at a distance of FINEST from a change point, below which its two solutions meet there."""

NONE, WEAKEST, ALL = range(3)
"""The blocks that change to their other solution at a change point."""

BEND, CHORD = 0.5, 0.1
"""Greatest change of the derivatives over a step, and deviation of the chord from their mean, relative."""

ROW, FUNCTION, OWNER, FIRST, SECOND, OF_OWNER, OF_FIRST, OF_SECOND = range(8)


class Chart(NamedTuple):
    """The independent variables, and the blocks that determine the others."""

    blocks: IntArray  # (blocks, 5) method, first and end of its unknowns, first and end of its terms
    unknown: IntArray  # (unknowns,) variables, block after block
    round: FloatArray  # (unknowns,) factor of x^2 + y^2 in the equations, in the order of the unknowns
    ti: IntArray  # (terms, 8) row in the block, function, its variable, two variables; their columns in the block or -1
    tc: FloatArray  # (terms,)
    independent: IntArray  # (k,) variables
    angles: IntArray  # (readings,) 1 for an angle
    first: int  # number of the variable that is the first reading


class InfluencePosition(NamedTuple):
    """A position with its first influence coefficients and the signs of its blocks."""

    v: FloatArray  # (variables,)
    b: FloatArray  # (k, variables) dv/ds
    sign: FloatArray  # (blocks,) determinant: of unit gradients for 2 equations; for more, sign times pivot ratio


class InfluenceScratch(NamedTuple):
    """Scratch arrays, and results of `settle`: velocity, acceleration, weakest, weak."""

    f: FloatArray  # (3, functions) the functions and their derivatives
    a: FloatArray  # (n, n)
    order: FloatArray  # (2 n,)
    right: FloatArray  # (n,)
    velocity: FloatArray  # (variables,)
    acceleration: FloatArray  # (variables,)
    step: FloatArray  # (k,)
    weakest: IntArray  # (2,) block with the smallest determinant; number of positions that `follow` tried so far
    weak: FloatArray  # (3,) that determinant; least one allowed (0: any); nonzero if `follow` stopped at that limit


@kernel
def refresh(c: Chart, v: FloatArray, f: FloatArray, reading: int) -> None:
    """Compute the functions of a reading and their derivatives."""
    u, k = v[c.first + reading], 1 + 4 * reading
    if c.angles[reading]:
        cos, sin = math.cos(u), math.sin(u)
        f[0, k + 2], f[1, k + 2], f[2, k + 2] = cos, -sin, -cos
        f[0, k + 3], f[1, k + 3], f[2, k + 3] = sin, cos, -sin
    else:
        f[0, k], f[1, k] = u, 1.0
        f[0, k + 1], f[1, k + 1], f[2, k + 1] = u * u, 2.0 * u, 2.0


@kernel
def compute_block(c: Chart, v: FloatArray, g: int, room: InfluenceScratch) -> None:
    """Compute the values and the Jacobian of a block's equations."""
    n = c.blocks[g, 2] - c.blocks[g, 1]
    for i in range(n):
        room.right[i] = 0.0
        for j in range(n):
            room.a[i, j] = 0.0
    for t in range(c.blocks[g, 3], c.blocks[g, 4]):
        row, p, i, j = c.ti[t, ROW], c.ti[t, FUNCTION], c.ti[t, FIRST], c.ti[t, SECOND]
        factor, x, y = c.tc[t] * room.f[0, p], v[i], v[j]
        room.right[row] += factor * x * y
        if c.ti[t, OF_FIRST] >= 0:
            room.a[row, c.ti[t, OF_FIRST]] += factor * y
        if c.ti[t, OF_SECOND] >= 0:
            room.a[row, c.ti[t, OF_SECOND]] += factor * x
        if c.ti[t, OF_OWNER] >= 0:
            room.a[row, c.ti[t, OF_OWNER]] += c.tc[t] * room.f[1, p] * x * y


@stage
def factor_wide(a: FloatArray, n: int, order: FloatArray) -> float:
    """Factor the Jacobian of a block of more than two; return the sign times the ratio of least to greatest pivot."""
    sign, least, greatest = lu_factor(a, n, order), math.inf, 0.0
    if sign == 0.0:
        return 0.0
    for i in range(n):
        pivot = 1.0 / abs(order[n + i])
        least, greatest = min(least, pivot), max(greatest, pivot)
    return sign * least / greatest


@kernel
def factor_block(a: FloatArray, n: int, order: FloatArray) -> float:
    """Factor a block's Jacobian; return its entry of `InfluencePosition.sign`, 0 if it is singular."""
    if n > 2:
        return factor_wide(a, n, order)
    if n == 1:
        determinant = a[0, 0]
        a[0, 0] = 1.0 / determinant if determinant != 0.0 else 0.0
        return determinant
    determinant = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    if determinant == 0.0:
        return 0.0
    squares = (a[0, 0] * a[0, 0] + a[0, 1] * a[0, 1]) * (a[1, 0] * a[1, 0] + a[1, 1] * a[1, 1])
    inverse = 1.0 / determinant
    a[0, 0], a[1, 1] = a[1, 1] * inverse, a[0, 0] * inverse
    a[0, 1], a[1, 0] = -a[0, 1] * inverse, -a[1, 0] * inverse
    return determinant / math.sqrt(squares)


@kernel
def solve_block(a: FloatArray, n: int, order: FloatArray, right: FloatArray) -> None:
    """Solve with the factors from `factor_block`."""
    if n > 2:
        lu_solve(a, n, order, right)
    elif n == 1:
        right[0] *= a[0, 0]
    else:
        x, y = right[0], right[1]
        right[0], right[1] = a[0, 0] * x + a[0, 1] * y, a[1, 0] * x + a[1, 1] * y


@kernel
def meet(room: InfluenceScratch, e: float, f: float, sign: float) -> bool:
    """Solve e d.d + a_0.d + r_0 = 0 and f d.d + a_1.d + r_1 = 0 for d; `sign` selects one of two solutions.

    r is replaced by d, and a by the gradients there. A combination of both equations is a line; on the line, the other
    is a quadratic equation. Returns false if there is no solution.
    """
    a, r = room.a, room.right
    if e == 0.0 and f == 0.0:
        determinant = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
        if determinant == 0.0:
            return False
        r[0], r[1] = (a[0, 1] * r[1] - a[1, 1] * r[0]) / determinant, (a[1, 0] * r[0] - a[0, 0] * r[1]) / determinant
        return True
    circle, other, q = (0, 1, e) if e != 0.0 else (1, 0, f)
    part = (f if circle == 0 else e) / q
    nx, ny = a[other, 0] - part * a[circle, 0], a[other, 1] - part * a[circle, 1]
    height = r[other] - part * r[circle]
    length = math.sqrt(nx * nx + ny * ny)
    if not length > 0.0:
        return False
    nx, ny, d = nx / length, ny / length, -height / length
    p = a[circle, 1] * nx - a[circle, 0] * ny
    rest = (q * d + a[circle, 0] * nx + a[circle, 1] * ny) * d + r[circle]
    square = p * p - 4.0 * q * rest
    if not square >= 0.0:
        return False
    root = math.sqrt(square)
    if (sign > 0.0) == (circle == 0):
        root = -root
    t = -2.0 * rest / (p + root) if p * root > 0.0 else (root - p) / (2.0 * q)
    x, y = d * nx - t * ny, d * ny + t * nx
    a[0, 0] += 2.0 * e * x
    a[0, 1] += 2.0 * e * y
    a[1, 0] += 2.0 * f * x
    a[1, 1] += 2.0 * f * y
    r[0], r[1] = x, y
    return True


@kernel
def settle_block(c: Chart, v: FloatArray, g: int, sign: float, room: InfluenceScratch) -> float:
    """Solve a block for its variables, starting from their present values; factor its Jacobian at the solution.

    Returns the block's entry of `InfluencePosition.sign`, 0 if no solution was found.
    """
    kind, begin, end = c.blocks[g, 0], c.blocks[g, 1], c.blocks[g, 2]
    n = end - begin
    before, rounds = math.inf, 0
    while True:
        compute_block(c, v, g, room)
        if kind == PAIR:
            if not meet(room, c.round[begin], c.round[begin + 1], sign):
                return 0.0
            v[c.unknown[begin]] += room.right[0]
            v[c.unknown[begin + 1]] += room.right[1]
        determinant = factor_block(room.a, n, room.order)
        if kind == PAIR or determinant == 0.0 or before <= SETTLED:
            return determinant
        solve_block(room.a, n, room.order, room.right)
        greatest = 0.0
        for i in range(n):
            at = c.unknown[begin + i]
            v[at] -= room.right[i]
            greatest = max(greatest, abs(room.right[i]))
            if at >= c.first:
                refresh(c, v, room.f, at - c.first)
        if kind == LINEAR and math.isfinite(greatest):
            return determinant  # its Jacobian is constant
        rounds += 1
        if not math.isfinite(greatest) or greatest > 2.0 * before or rounds > ROUNDS:
            return 0.0
        before = greatest


@kernel
def differentiate_block(c: Chart, to: InfluencePosition, g: int, room: InfluenceScratch) -> None:
    """Compute dv/ds of a block whose Jacobian is factored."""
    begin, n = c.blocks[g, 1], c.blocks[g, 2] - c.blocks[g, 1]
    v, f, right = to.v, room.f, room.right
    for k in range(to.b.shape[0]):
        b = to.b[k]
        for i in range(n):
            right[i] = 0.0
        for t in range(c.blocks[g, 3], c.blocks[g, 4]):
            p, o, i, j = c.ti[t, FUNCTION], c.ti[t, OWNER], c.ti[t, FIRST], c.ti[t, SECOND]
            right[c.ti[t, ROW]] -= c.tc[t] * (f[0, p] * (b[i] * v[j] + v[i] * b[j]) + f[1, p] * b[o] * v[i] * v[j])
        solve_block(room.a, n, room.order, right)
        for i in range(n):
            b[c.unknown[begin + i]] = right[i]


@kernel
def accelerate_block(c: Chart, to: InfluencePosition, g: int, speeds: FloatArray, room: InfluenceScratch) -> None:
    """Compute the velocities of a block, and its accelerations without the terms of s''."""
    begin, n = c.blocks[g, 1], c.blocks[g, 2] - c.blocks[g, 1]
    v, f, right, w, a = to.v, room.f, room.right, room.velocity, room.acceleration
    for i in range(n):
        at = c.unknown[begin + i]
        w[at] = 0.0
        right[i] = 0.0
        for k in range(to.b.shape[0]):
            w[at] += to.b[k, at] * speeds[k]
    for t in range(c.blocks[g, 3], c.blocks[g, 4]):
        p, o, i, j = c.ti[t, FUNCTION], c.ti[t, OWNER], c.ti[t, FIRST], c.ti[t, SECOND]
        x, y, u = v[i], v[j], w[o]
        mixed = f[0, p] * (2.0 * w[i] * w[j] + a[i] * y + x * a[j])
        mixed += f[1, p] * (2.0 * u * (w[i] * y + x * w[j]) + a[o] * x * y)
        right[c.ti[t, ROW]] -= c.tc[t] * (mixed + f[2, p] * u * u * x * y)
    solve_block(room.a, n, room.order, right)
    for i in range(n):
        a[c.unknown[begin + i]] = right[i]


@kernel
def settle(c: Chart, to: InfluencePosition, speeds: FloatArray, room: InfluenceScratch) -> bool:
    """Solve for all variables, starting from their present values and on the sides given by `to.sign`.

    The independent variables in `to.v` are given. Also computes dv/ds, velocities and accelerations. `room.weakest` is
    the block that was not solved, or else the block with the smallest determinant. Returns whether all were solved.
    """
    to.b[:, :], room.velocity[:], room.acceleration[:] = 0.0, 0.0, 0.0
    for k in range(c.independent.shape[0]):
        to.b[k, c.independent[k]], room.velocity[c.independent[k]] = 1.0, speeds[k]
    for r in range(c.angles.shape[0]):
        refresh(c, to.v, room.f, r)
    least = math.inf
    for g in range(c.blocks.shape[0]):
        determinant = settle_block(c, to.v, g, to.sign[g], room)
        if c.blocks[g, 0] != LINEAR and abs(determinant) < least:
            least = abs(determinant)
            room.weakest[0] = g
        if not determinant * to.sign[g] > 0.0:
            room.weakest[0] = g
            return False
        to.sign[g] = determinant
        differentiate_block(c, to, g, room)
        accelerate_block(c, to, g, speeds, room)
    room.weak[0] = least
    return True


@kernel
def is_straight(
    last: InfluencePosition, to: InfluencePosition, step: FloatArray, begin: int, end: int, slowest: float
) -> bool:
    """Return whether variables begin..end continue smoothly from another position, without reversal or jump.

    Changes are relative to the greatest derivative among these variables, but at least `slowest`.
    """
    reach = 0.0
    for k in range(step.shape[0]):
        reach = max(reach, abs(step[k]))
    greatest, bend, off = slowest, 0.0, 0.0
    for i in range(begin, end):
        mean = 0.0
        for k in range(step.shape[0]):
            one, other = last.b[k, i], to.b[k, i]
            mean += 0.5 * (one + other) * step[k]
            greatest = max(greatest, abs(one))
            bend = max(bend, abs(other - one))
        off = max(off, abs(to.v[i] - last.v[i] - mean))
    return bend <= BEND * greatest and off <= CHORD * greatest * reach + SETTLED


@kernel
def copy_place(to: InfluencePosition, of: InfluencePosition) -> None:
    """Copy a position."""
    copy(to.v, of.v)
    for k in range(of.b.shape[0]):
        copy(to.b[k], of.b[k])
    copy(to.sign, of.sign)


@kernel
def try_step(
    c: Chart, last: InfluencePosition, to: InfluencePosition, speeds: FloatArray, room: InfluenceScratch
) -> bool:
    """Take the step `room.step` from the last position; return whether the motion continues smoothly."""
    for i in range(to.v.shape[0]):
        to.v[i] = last.v[i]
        for k in range(room.step.shape[0]):
            to.v[i] += last.b[k, i] * room.step[k]
    if not settle(c, to, speeds, room) or not is_straight(last, to, room.step, 0, c.first, 0.0):
        return False
    return is_straight(last, to, room.step, c.first, to.v.shape[0] - 1, 1.0)  # readings may be at a dead point


@kernel
def follow(
    c: Chart, last: InfluencePosition, to: InfluencePosition, target: FloatArray, speeds: FloatArray,
    room: InfluenceScratch,
) -> bool:  # fmt: skip
    """Follow the motion from position `last` to the independent variables `target`; `last` is moved.

    Steps are halved until the motion continues smoothly. If even the finest step does not, the other side of the
    weakest block is tried, then that of all blocks near a change point: the change point is passed smoothly. If a
    determinant is below the limit `room.weak[1]`, `to` is the first such position and the result is false. It is false
    too if the target is so far that MOST_TRIES positions do not reach it.
    """
    part, flipped, last_try = 1.0, NONE, room.weakest[1] + MOST_TRIES
    while room.weakest[1] < last_try:
        room.weakest[1] += 1
        far = 0.0
        for k in range(target.shape[0]):
            rest = target[k] - last.v[c.independent[k]]
            room.step[k] = part * rest
            far = max(far, abs(room.step[k]))
        if not math.isfinite(far):
            return False
        for g in range(to.sign.shape[0]):
            turned = g == room.weakest[0] if flipped == WEAKEST else abs(last.sign[g]) <= MEETING
            to.sign[g] = -last.sign[g] if flipped != NONE and turned else last.sign[g]
        if try_step(c, last, to, speeds, room):
            if room.weak[0] < room.weak[1]:
                room.weak[2] = 1.0
                return False
            if part == 1.0:
                return True
            copy_place(last, to)
            part, flipped = min(1.0, 2.0 * part / (1.0 - part)), NONE
        elif flipped == ALL:
            return False
        elif far <= FINEST:
            flipped += 1
        else:
            part *= 0.5
    return False


@kernel
def set_signs(c: Chart, to: InfluencePosition, room: InfluenceScratch) -> None:
    """Set `to.sign` of all blocks to the determinants at the present position."""
    for r in range(c.angles.shape[0]):
        refresh(c, to.v, room.f, r)
    for g in range(c.blocks.shape[0]):
        compute_block(c, to.v, g, room)
        n = c.blocks[g, 2] - c.blocks[g, 1]
        determinant = factor_block(room.a, n, room.order)
        to.sign[g] = determinant
