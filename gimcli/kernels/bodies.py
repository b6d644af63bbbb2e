"""Pairs between rigid bodies: equations and gradients, in absolute and in joint coordinates.

A body has its origin o and its angle phi; a point fixed in it is p = o + e^(i phi) z. Body 0 is the frame.

    coincident   p - q = 0                        two rows
    on a line    n.(p - q) - d = 0                n fixed in the second body, d constant or a travel
    angle        phi - psi - c - v = 0            modulo 2 pi
    distance     (|p - q|^2 - v^2) / 2 v = 0

Every row has at most six partial derivatives, by o and phi of its two bodies. Absolute coordinates use them directly.
In joint coordinates they are summed along the chains of the tree; each variable rotates all bodies behind its joint
about a point, or translates them.

Source: Fraczek & Wojtyra, lecture notes on multibody methods; Nikravesh, Computer-Aided Analysis of
Mechanical Systems, 1988, chapters 4 and 6.

Arrays: pose (bodies, 5) x, y, phi, cos, sin; bi (bodies, 2) first column and whether the body turns;
pi (pairs, 4) kind, body, body, actuator; pz (pairs, 7) point, point, normal, constant;
g (rows, 6) partial derivatives, gb (rows, 2) the two bodies of each row.
"""

from __future__ import annotations

import math

from gimcli.kernels.jit import kernel
from gimcli.mechanism import FloatArray, IntArray

COINCIDENT, ON_LINE, ANGLE, DISTANCE = range(4)
"""Kinds of pairs, as above."""

HINGE, RAM, FREE = range(3)
"""Kinds of joints of the tree: one that turns or slides, a linear actuator (variable direction), no joint."""

TURN = 2.0 * math.pi


@kernel
def place_bodies(q: FloatArray, bi: IntArray, pose: FloatArray) -> None:
    """Compute the pose of every body from absolute coordinates."""
    for b in range(1, bi.shape[0]):
        c = bi[b, 0]
        pose[b, 0], pose[b, 1] = q[c], q[c + 1]
        if bi[b, 1] == 1:
            pose[b, 2] = q[c + 2]
            pose[b, 3], pose[b, 4] = math.cos(q[c + 2]), math.sin(q[c + 2])


@kernel
def joint_value(q: FloatArray, values: FloatArray, constant: float, variable: int, actuator: int, turn: int) -> float:
    """Return a joint's angle or travel: a constant plus a variable or an input."""
    if variable >= 0:
        return constant + q[variable]
    if actuator >= 0:
        return constant + values[actuator] * turn
    return constant


@kernel
def place_tree(
    q: FloatArray, values: FloatArray, ji: IntArray, jz: FloatArray, pose: FloatArray, v: FloatArray
) -> None:
    """Compute the poses along the tree; fill v (variables, 3): 1 and the centre of a rotation, or 0 and a translation.

    ji (joints, 9): parent, child, kind, then variable, actuator and sense of the angle, then of the travel.
    jz (joints, 10): point and direction in the parent, then in the child, then the constants.
    """
    for k in range(ji.shape[0]):
        p, c = ji[k, 0], ji[k, 1]
        angle = joint_value(q, values, jz[k, 8], ji[k, 3], ji[k, 4], ji[k, 5])
        co, si = pose[p, 3], pose[p, 4]
        ax, ay = jz[k, 0], jz[k, 1]
        ex, ey = 0.0, 0.0  # direction of the travel, in the parent
        if ji[k, 2] == RAM:
            s = q[ji[k, 6]]
            reach = values[ji[k, 7]]
            ex, ey = -reach * math.sin(s), reach * math.cos(s)
            ax, ay = ax + ey, ay - ex
        elif ji[k, 2] == FREE:
            ax, ay = q[ji[k, 6]], q[ji[k, 6] + 1]
        else:
            s = joint_value(q, values, jz[k, 9], ji[k, 6], ji[k, 7], ji[k, 8])
            ex, ey = jz[k, 2], jz[k, 3]
            ax, ay = ax + s * ex, ay + s * ey
        px, py = pose[p, 0] + co * ax - si * ay, pose[p, 1] + si * ax + co * ay
        tx, ty = co * ex - si * ey, si * ex + co * ey
        pose[c, 2] = pose[p, 2] + angle
        co, si = math.cos(pose[c, 2]), math.sin(pose[c, 2])
        pose[c, 3], pose[c, 4] = co, si
        bx, by = jz[k, 4], jz[k, 5]
        if ji[k, 2] == HINGE:
            bx, by = bx + s * jz[k, 6], by + s * jz[k, 7]
            tx, ty = tx - co * jz[k, 6] + si * jz[k, 7], ty - si * jz[k, 6] - co * jz[k, 7]
        pose[c, 0], pose[c, 1] = px - co * bx + si * by, py - si * bx - co * by
        if ji[k, 3] >= 0:
            v[ji[k, 3], 0], v[ji[k, 3], 1], v[ji[k, 3], 2] = 1.0, px, py
        if ji[k, 2] == FREE:
            v[ji[k, 6], 0], v[ji[k, 6], 1], v[ji[k, 6], 2] = 0.0, 1.0, 0.0
            v[ji[k, 6] + 1, 0], v[ji[k, 6] + 1, 1], v[ji[k, 6] + 1, 2] = 0.0, 0.0, 1.0
        elif ji[k, 6] >= 0:
            v[ji[k, 6], 0], v[ji[k, 6], 1], v[ji[k, 6], 2] = 0.0, tx, ty


@kernel
def pair_rows(
    values: FloatArray, pi: IntArray, pz: FloatArray, pose: FloatArray, f: FloatArray, g: FloatArray, gb: IntArray
) -> None:
    """Fill the residuals f, their partial derivatives g and the bodies gb of each row."""
    row = 0
    for k in range(pi.shape[0]):
        kind, a, b = pi[k, 0], pi[k, 1], pi[k, 2]
        gb[row, 0], gb[row, 1] = a, b
        value = pz[k, 6]
        if pi[k, 3] >= 0:
            value += values[pi[k, 3]]
        if kind == ANGLE:
            e = pose[a, 2] - pose[b, 2] - value
            f[row] = e - TURN * math.floor(e / TURN + 0.5)
            g[row, 2], g[row, 5] = 1.0, -1.0
            row += 1
            continue
        rx, ry = pose[a, 3] * pz[k, 0] - pose[a, 4] * pz[k, 1], pose[a, 4] * pz[k, 0] + pose[a, 3] * pz[k, 1]
        sx, sy = pose[b, 3] * pz[k, 2] - pose[b, 4] * pz[k, 3], pose[b, 4] * pz[k, 2] + pose[b, 3] * pz[k, 3]
        dx, dy = pose[a, 0] + rx - pose[b, 0] - sx, pose[a, 1] + ry - pose[b, 1] - sy
        if kind == COINCIDENT:
            f[row], f[row + 1] = dx, dy
            g[row, 0], g[row, 2], g[row, 3], g[row, 5] = 1.0, -ry, -1.0, sy
            gb[row + 1, 0], gb[row + 1, 1] = a, b
            g[row + 1, 1], g[row + 1, 2], g[row + 1, 4], g[row + 1, 5] = 1.0, rx, -1.0, -sx
            row += 2
            continue
        turning = 0.0  # derivative by the rotation of the normal with its body
        if kind == ON_LINE:
            nx, ny = pose[b, 3] * pz[k, 4] - pose[b, 4] * pz[k, 5], pose[b, 4] * pz[k, 4] + pose[b, 3] * pz[k, 5]
            f[row] = nx * dx + ny * dy - value
            turning = nx * dy - ny * dx
        else:
            nx, ny = dx / value, dy / value
            f[row] = 0.5 * (nx * dx + ny * dy - value)
        g[row, 0], g[row, 1], g[row, 2] = nx, ny, ny * rx - nx * ry
        g[row, 3], g[row, 4], g[row, 5] = -nx, -ny, turning + nx * sy - ny * sx
        row += 1


@kernel
def absolute_rows(g: FloatArray, gb: IntArray, bi: IntArray, j: FloatArray) -> None:
    """Write the partial derivatives into the columns of the absolute coordinates."""
    j[:, :] = 0.0
    for row in range(gb.shape[0]):
        for side in range(2):
            b = gb[row, side]
            if b > 0:
                c = bi[b, 0]
                j[row, c], j[row, c + 1] = g[row, 3 * side], g[row, 3 * side + 1]
                if bi[b, 1] == 1:
                    j[row, c + 2] = g[row, 3 * side + 2]


@kernel
def chain_column(
    row: int, k: int, gx: float, gy: float, gp: float, x: float, y: float, v: FloatArray, j: FloatArray
) -> None:
    """Add the derivative of a row by variable k, through a body at (x, y) with partial derivatives gx, gy, gp."""
    if v[k, 0] == 1.0:
        j[row, k] += gy * (x - v[k, 1]) - gx * (y - v[k, 2]) + gp
    else:
        j[row, k] += gx * v[k, 1] + gy * v[k, 2]


@kernel
def joint_rows(
    g: FloatArray, gb: IntArray, ji: IntArray, above: IntArray, pose: FloatArray, v: FloatArray, j: FloatArray
) -> None:
    """Sum the partial derivatives along the chains; above (bodies,): the joint between each body and its parent."""
    j[:, :] = 0.0
    for row in range(gb.shape[0]):
        for side in range(2):
            b = gb[row, side]
            gx, gy, gp = g[row, 3 * side], g[row, 3 * side + 1], g[row, 3 * side + 2]
            x, y = pose[b, 0], pose[b, 1]
            while b > 0:
                k = above[b]
                if ji[k, 3] >= 0:
                    chain_column(row, ji[k, 3], gx, gy, gp, x, y, v, j)
                if ji[k, 2] != HINGE or ji[k, 6] >= 0:
                    chain_column(row, ji[k, 6], gx, gy, gp, x, y, v, j)
                if ji[k, 2] == FREE:
                    chain_column(row, ji[k, 6] + 1, gx, gy, gp, x, y, v, j)
                b = ji[k, 0]
