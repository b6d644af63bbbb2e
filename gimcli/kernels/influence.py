"""Positions and first and second influence coefficients of one position, block by block.

The variables v are x and y of all nodes, all readings, and 1. Some are independent: s. The equations are sums of terms
c f(u) v_i v_j; a block of them determines a few variables when those before are known. A block of one node's x and y on
circles or lines is solved in closed form, on the side that the sign of its determinant names; others by
Newton-Raphson. Then, with the block's gradients J factored once,

    J dv/ds_k = -(terms along s_k),   J a = -(second derivatives along v'),   v' = sum of dv/ds_k s'_k

so that `a` are the accelerations without those of s. Source: Durango, Giraldo, Calle & Mesa 2014 (module by
module); Haug, Computer-Aided Kinematics and Dynamics, 1989, eqs 3.6.10 and 3.6.11.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.linear import lu_factor, lu_solve
from gimcli.mechanism import FloatArray, IntArray

NEWTON, LINEAR, PAIR = range(3)
"""How a block is solved."""

ROUNDS = 12
"""Iterations of a block that starts near: it has converged, or the start was not near."""

SETTLED = 1e-9
"""A correction below this is the last: what remains is its square."""

FINEST = 1e-6
"""Shortest step by which a position is followed, of lengths about 1 and rad."""

MEETING = 1e-4
"""Determinant of a block below which its two sides meet there, at a distance of FINEST."""

NONE, WEAKEST, ALL = range(3)
"""Which blocks change their side."""

BEND, CHORD = 0.5, 0.1
"""Greatest change of direction over a step, and of its chord off the mean direction, relative to the direction."""

ROW, FUNCTION, OWNER, FIRST, SECOND, OF_OWNER, OF_FIRST, OF_SECOND = range(8)


class Chart(NamedTuple):
    """Independent variables, and the others in blocks."""

    blocks: IntArray  # (blocks, 5) kind, first and last unknown, first and last term
    unknown: IntArray  # (unknowns,) variables, block after block
    round: FloatArray  # (unknowns,) factor of x^2 + y^2 in the equations, in the order of the unknowns
    ti: IntArray  # (terms, 8) row in the block, function, its variable, two variables; their columns in the block or -1
    tc: FloatArray  # (terms,)
    independent: IntArray  # (k,) variables
    angles: IntArray  # (readings,) 1 for an angle
    first: int  # variable of the first reading


class InfluencePosition(NamedTuple):
    """A position with what is known of it."""

    v: FloatArray  # (variables,)
    b: FloatArray  # (k, variables) dv/ds
    sign: FloatArray  # (blocks,) determinant; of two equations by unit gradients, of more its sign by the least pivot


class InfluenceScratch(NamedTuple):
    """Scratch."""

    f: FloatArray  # (3, functions) the functions and their derivatives
    a: FloatArray  # (n, n)
    order: FloatArray  # (2 n,)
    right: FloatArray  # (n,)
    velocity: FloatArray  # (variables,)
    acceleration: FloatArray  # (variables,)
    step: FloatArray  # (k,)
    weakest: IntArray  # (1,) block with the smallest determinant
    weak: FloatArray  # (3,) that determinant; below which a place is not gone to (0: none); not 0 where that happened


@kernel
def refresh(c: Chart, v: FloatArray, f: FloatArray, reading: int) -> None:
    """Set the functions of a reading."""
    u, k = v[c.first + reading], 1 + 4 * reading
    if c.angles[reading]:
        cos, sin = math.cos(u), math.sin(u)
        f[0, k + 2], f[1, k + 2], f[2, k + 2] = cos, -sin, -cos
        f[0, k + 3], f[1, k + 3], f[2, k + 3] = sin, cos, -sin
    else:
        f[0, k], f[1, k] = u, 1.0
        f[0, k + 1], f[1, k + 1], f[2, k + 1] = u * u, 2.0 * u, 2.0


@kernel
def lay_block(c: Chart, v: FloatArray, g: int, room: InfluenceScratch) -> None:
    """Lay out the values and the gradients of a block's equations."""
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
    """Factor the gradients of a block of more than two; return the sign times the least pivot beside the greatest."""
    sign, least, greatest = lu_factor(a, n, order), math.inf, 0.0
    if sign == 0.0:
        return 0.0
    for i in range(n):
        pivot = 1.0 / abs(order[n + i])
        least, greatest = min(least, pivot), max(greatest, pivot)
    return sign * least / greatest


@stage
def solve_wide(a: FloatArray, n: int, order: FloatArray, right: FloatArray) -> None:
    """Solve with what `factor_wide` left."""
    lu_solve(a, n, order, right)


@kernel
def factor_block(a: FloatArray, n: int, order: FloatArray) -> float:
    """Factor a block's gradients; return what `Place.sign` holds; 0 where it is singular."""
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
    """Solve with what `factor_block` left."""
    if n > 2:
        solve_wide(a, n, order, right)
    elif n == 1:
        right[0] *= a[0, 0]
    else:
        x, y = right[0], right[1]
        right[0], right[1] = a[0, 0] * x + a[0, 1] * y, a[1, 0] * x + a[1, 1] * y


@kernel
def meet(room: InfluenceScratch, e: float, f: float, sign: float) -> bool:
    """Move to where e d.d + a_0.d + r_0 = 0 and f d.d + a_1.d + r_1 = 0 meet, on the side of a sign; r becomes d.

    The gradients become those there. One less a part of the other is a line; on it, a quadratic equation.
    """
    a, r = room.a, room.right
    if e == 0.0 and f == 0.0:
        determinant = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
        if determinant == 0.0:
            return False
        r[0], r[1] = (a[0, 1] * r[1] - a[1, 1] * r[0]) / determinant, (a[1, 0] * r[0] - a[0, 0] * r[1]) / determinant
        return True
    ring, other, q = (0, 1, e) if e != 0.0 else (1, 0, f)
    part = (f if ring == 0 else e) / q
    nx, ny, height = a[other, 0] - part * a[ring, 0], a[other, 1] - part * a[ring, 1], r[other] - part * r[ring]
    length = math.sqrt(nx * nx + ny * ny)
    if not length > 0.0:
        return False
    nx, ny, d = nx / length, ny / length, -height / length
    p = a[ring, 1] * nx - a[ring, 0] * ny
    rest = (q * d + a[ring, 0] * nx + a[ring, 1] * ny) * d + r[ring]
    square = p * p - 4.0 * q * rest
    if not square >= 0.0:
        return False
    root = math.sqrt(square)
    if (sign > 0.0) == (ring == 0):
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
    """Find the variables of a block near where they are; factor its gradients there.

    Returns what `Place.sign` holds, 0 where nothing was found.
    """
    kind, begin, end = c.blocks[g, 0], c.blocks[g, 1], c.blocks[g, 2]
    n = end - begin
    before, rounds = math.inf, 0
    while True:
        lay_block(c, v, g, room)
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
            return determinant  # its gradients are the same everywhere
        rounds += 1
        if not math.isfinite(greatest) or greatest > 2.0 * before or rounds > ROUNDS:
            return 0.0
        before = greatest


@kernel
def differentiate_block(c: Chart, to: InfluencePosition, g: int, room: InfluenceScratch) -> None:
    """Find dv/ds of a block whose gradients are factored."""
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
    """Find the velocities of a block, and its accelerations without those of s."""
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
    """Find all variables near where they are, on the sides that the signs name, and their derivatives.

    The independent variables of `to.v` are given. Where a block is not found, `weakest` names it; else that with the
    smallest determinant. Velocities and accelerations are left in the room.
    """
    for k in range(c.independent.shape[0]):
        at = c.independent[k]
        for i in range(to.v.shape[0]):
            to.b[k, i] = 0.0
        to.b[k, at] = 1.0
    for i in range(to.v.shape[0]):
        room.velocity[i] = 0.0
        room.acceleration[i] = 0.0
    for k in range(c.independent.shape[0]):
        room.velocity[c.independent[k]] = speeds[k]
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
    """Return whether some variables continue those of another position smoothly: neither a turn nor another branch.

    Their rates are held against the greatest among them, and against `slowest`.
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
    for i in range(of.v.shape[0]):
        to.v[i] = of.v[i]
        for k in range(of.b.shape[0]):
            to.b[k, i] = of.b[k, i]
    for g in range(of.sign.shape[0]):
        to.sign[g] = of.sign[g]


@kernel
def try_step(
    c: Chart, last: InfluencePosition, to: InfluencePosition, speeds: FloatArray, room: InfluenceScratch
) -> bool:
    """Take a step from the last place, of what `room.step` says, if it leads straight on."""
    for i in range(to.v.shape[0]):
        to.v[i] = last.v[i]
        for k in range(room.step.shape[0]):
            to.v[i] += last.b[k, i] * room.step[k]
    if not settle(c, to, speeds, room) or not is_straight(last, to, room.step, 0, c.first, 0.0):
        return False
    return is_straight(last, to, room.step, c.first, to.v.shape[0] - 1, 1.0)  # readings may rest: inputs' dead point


@kernel
def follow(
    c: Chart, last: InfluencePosition, to: InfluencePosition, target: FloatArray, speeds: FloatArray,
    room: InfluenceScratch,
) -> bool:  # fmt: skip
    """Follow the motion from the last place to independent variables `target`; `last` moves along.

    Steps are halved until they lead straight on. Where not even the finest does, the other side of the weakest block
    may, or of all that are near a change point: this is passed straight through. Where `room.weak` forbids places so
    near, `to` is left at the first of them.
    """
    part, flipped = 1.0, NONE
    while True:
        far = 0.0
        for k in range(target.shape[0]):
            way = target[k] - last.v[c.independent[k]]
            room.step[k] = part * way
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


@kernel
def stand(c: Chart, to: InfluencePosition, room: InfluenceScratch) -> None:
    """Set the signs of all blocks to those of the place where they are."""
    for r in range(c.angles.shape[0]):
        refresh(c, to.v, room.f, r)
    for g in range(c.blocks.shape[0]):
        lay_block(c, to.v, g, room)
        n = c.blocks[g, 2] - c.blocks[g, 1]
        determinant = factor_block(room.a, n, room.order)
        to.sign[g] = determinant
