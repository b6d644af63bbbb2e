"""Loci and their intersections: every argument is an array over the rows, or a number when compiled.

A locus is where a node may stand while the other nodes of one constraint stand still: a circle
(distance) or a line (angle, sliding pair). Two loci meet in closed form; which of two meeting
points is taken is the sign `s` (+1: to the left of the direction from the first to the second
centre, or ahead along the line). Each function returns the coordinates and

- `g`, the signed measure that tells the two meeting points apart (0 where they meet), and
- `g2`, its square before the root: negative where the loci do not meet, and
- `noise`, the rounding error of `g2`,

all three as lengths or squares of lengths.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.kernels.choice import where
from gimcli.kernels.jit import kernel

EPS = float(np.finfo(float).eps)
ROUNDINGS = 4.0 * EPS
"""Relative error allowed for a sum of a few lengths."""

JUMP = 0.5
"""A row is doubtful when the other solution is not at least 1 / JUMP times as far from the one predicted."""

STRETCH = 4.0
"""A step this much longer than the one before it is not predicted from it, and doubtful."""

NEAR = 0.25
"""A row is doubtful where the two solutions are nearer to each other than this part of how far they move in a step:
the prediction does not tell them apart there."""

Meeting = tuple[Any, Any, Any, Any, Any]


@kernel
def circle_circle(ax: Any, ay: Any, ra: Any, bx: Any, by: Any, rb: Any, s: float) -> Meeting:
    """Meet circle (a, ra) with circle (b, rb): RRR dyad.

    The half chord comes from Heron's product, which keeps its digits near tangency.
    """
    dx, dy = bx - ax, by - ay
    d2 = dx * dx + dy * dy
    d = np.sqrt(d2)
    total = ra + rb + d
    f1, f3, f4 = ra + rb - d, d - ra + rb, d + ra - rb
    inverse = 1.0 / where(d2 > 0.0, d2, 1.0)
    quarter = 0.25 * inverse
    g2 = f1 * total * f3 * f4 * quarter
    noise = ROUNDINGS * total * total * (abs(f3 * f4) + abs(f1 * f4) + abs(f1 * f3)) * quarter
    noise = where(d2 > 0.0, noise, np.inf)
    g = s * np.sqrt(where(g2 > 0.0, g2, 0.0))
    along = (ra - rb) * (ra + rb) * inverse * 0.5 + 0.5
    across = g * d * inverse
    return ax + along * dx - across * dy, ay + along * dy + across * dx, g, g2, noise


@kernel
def circle_line(ax: Any, ay: Any, r: Any, qx: Any, qy: Any, nx: Any, ny: Any, d: Any, s: float) -> Meeting:
    """Meet circle (a, r) with the line n.(p - q) = d (n a unit vector): RRP dyad."""
    e = nx * (ax - qx) + ny * (ay - qy) - d  # height of the centre over the line
    g2 = (r - e) * (r + e)
    reach = abs(ax - qx) + abs(ay - qy) + abs(d)
    noise = ROUNDINGS * (reach + r) * (abs(r - e) + abs(r + e))
    g = s * np.sqrt(where(g2 > 0.0, g2, 0.0))
    return ax - e * nx + g * ny, ay - e * ny - g * nx, g, g2, noise


@kernel
def line_line(qx: Any, qy: Any, nx: Any, ny: Any, d: Any, px: Any, py: Any, mx: Any, my: Any, e: Any) -> Meeting:
    """Meet the lines n.(z - q) = d and m.(z - p) = e: PRP dyad; `g` is the sine between them."""
    g = nx * my - ny * mx
    safe = where(g == 0.0, 1.0, g)
    e = e + mx * (px - qx) + my * (py - qy)  # second line seen from q
    wx, wy = (my * d - ny * e) / safe, (nx * e - mx * d) / safe
    noise = 2.0 * ROUNDINGS * (abs(d) + abs(e) + abs(wx) + abs(wy) + 1.0)
    return qx + wx, qy + wy, g, g * g, where(g == 0.0, np.inf, noise)


@kernel
def tilt(wx: Any, wy: Any, e: Any, s: float) -> Meeting:
    """Turn a line so that it passes a point: unit direction u with w = u (tau + i e), RPR dyad.

    `w` runs from a node of the turning member to the point, `e` is the signed distance of the
    point from the line, parallel to it, through that node; tau has the sign `s`.
    """
    w2 = wx * wx + wy * wy
    safe = where(w2 > 0.0, w2, 1.0)
    w = np.sqrt(safe)
    g2 = where(w2 > 0.0, (w - e) * (w + e), 0.0)
    noise = ROUNDINGS * (w + abs(e)) * (abs(w - e) + abs(w + e))
    g = s * np.sqrt(where(g2 > 0.0, g2, 0.0))
    return (wx * g + wy * e) / safe, (wy * g - wx * e) / safe, g, g2, noise


@kernel
def doubt(g: Any, noise: Any) -> Any:
    """Return the error of a meeting point."""
    size, least = abs(g), np.sqrt(noise)
    return noise / (2.0 * where(size > least, size, least))


@kernel
def leaps(now: Any, last: Any, before: Any, step: Any, gap: Any) -> Any:
    """Return whether a measure is not clearly nearer to the one predicted from two rows than its mirror is."""
    change = step / where(gap == 0.0, 1.0, gap) * (last - before)
    predicted = last + change
    near = where(abs(predicted - now) <= JUMP * abs(predicted + now), False, True)  # a NaN leaps
    near = where(abs(now) >= NEAR * abs(change), near, True)
    return where(step <= STRETCH * gap, near, True)
