"""Natural coordinates: equations in the coordinates of the points of a mechanism, and their gradients.

    distance   (|p - q|^2 - v^2) / 2 v = 0
    rigid      p - q - w (v - u) = 0              the other points of a member, linear; two rows
    line       n.(p - q) - d = 0                  n = w (v - u), or a known direction

Driven angles are lines too: the component of the member's direction perpendicular to the driven ray is 0.

Source: Garcia de Jalon & Bayo, Kinematic and Dynamic Simulation of Multibody Systems, 1994, chapter 2.

Arrays: x, y (nodes,); col (nodes,) first column of a node, negative if it is known; ei (equations, 8)
kind, p, q, u, v, value actuator, turning actuator, sense; ez (equations, 3) w, constant.
"""

from __future__ import annotations

from gimcli.kernels.jit import kernel
from gimcli.kernels.vector import stretched, turned
from gimcli.mechanism import FloatArray, IntArray

DISTANCE, RIGID, LINE = range(3)


@kernel
def move_points(q: FloatArray, col: IntArray, x: FloatArray, y: FloatArray) -> None:
    """Copy the unknowns to the coordinates of the points."""
    for n in range(col.shape[0]):
        if col[n] >= 0:
            x[n], y[n] = q[col[n]], q[col[n] + 1]


@kernel
def add_gradient(j: FloatArray, row: int, c: int, gx: float, gy: float) -> None:
    """Add a gradient in the columns c and c + 1 of a point, if it is free (c >= 0)."""
    if c >= 0:
        j[row, c] += gx
        j[row, c + 1] += gy


@kernel
def point_rows(
    x: FloatArray, y: FloatArray, values: FloatArray, cos: FloatArray, sin: FloatArray, ei: IntArray, ez: FloatArray,
    col: IntArray, f: FloatArray, j: FloatArray,
) -> None:  # fmt: skip
    """Fill the residuals f and their gradients j."""
    j[:, :] = 0.0
    row = 0
    for k in range(ei.shape[0]):
        kind, p, q, u, v = ei[k, 0], ei[k, 1], ei[k, 2], ei[k, 3], ei[k, 4]
        dx, dy = x[p] - x[q], y[p] - y[q]
        value = ez[k, 2]
        if ei[k, 5] >= 0:
            value += values[ei[k, 5]]
        if kind == DISTANCE:
            nx, ny = dx / value, dy / value
            f[row] = 0.5 * (nx * dx + ny * dy - value)
            add_gradient(j, row, col[p], nx, ny)
            add_gradient(j, row, col[q], -nx, -ny)
            row += 1
            continue
        zr, zi = turned(ez[k, 0], ez[k, 1], ei[k, 6], ei[k, 7], cos, sin)
        nx, ny = stretched(zr, zi, u, v, x, y)
        if kind == RIGID:
            f[row], f[row + 1] = dx - nx, dy - ny
            for r in range(2):
                wx, wy = (zr, -zi) if r == 0 else (zi, zr)
                gx, gy = (1.0, 0.0) if r == 0 else (0.0, 1.0)
                add_gradient(j, row + r, col[p], gx, gy)
                add_gradient(j, row + r, col[q], -gx, -gy)
                add_gradient(j, row + r, col[v], -wx, -wy)
                add_gradient(j, row + r, col[u], wx, wy)
            row += 2
            continue
        f[row] = nx * dx + ny * dy - value
        add_gradient(j, row, col[p], nx, ny)
        add_gradient(j, row, col[q], -nx, -ny)
        if u >= 0:
            wx, wy = zr * dx + zi * dy, zr * dy - zi * dx
            add_gradient(j, row, col[v], wx, wy)
            add_gradient(j, row, col[u], -wx, -wy)
        row += 1
