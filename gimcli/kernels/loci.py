"""Loci and their intersections: every argument is an array over the rows, or a number when compiled.

A locus is the set of possible positions of a node while the other nodes of one constraint are fixed: a circle
(distance) or a line (angle, sliding pair). Two loci intersect in closed form; the sign `s` selects one of two
intersections (+1: to the left of the direction from the first to the second centre, or ahead along the line). Each
function returns x, y and

- `g`, a signed length that distinguishes the two intersections (0 if they coincide),
- `g2`, the square of `g` before the root: negative if the loci do not intersect,
- `noise`, the rounding error of `g2`.
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
"""A row is doubtful unless the other intersection is at least 1 / JUMP times as far from the predicted one."""

STRETCH = 4.0
"""A row is doubtful if its step is longer than this times the step before: the prediction is not reliable."""

NEAR = 0.25
"""A row is doubtful if the two intersections are closer to each other than this fraction of their displacement in a
step: the prediction does not distinguish them."""

DIP = 0.5
"""Twice the greatest distance of the parabola t (t - 1) from its chord between 0 and 1."""

Meeting = tuple[Any, Any, Any, Any, Any]


@kernel
def circle_circle(ax: Any, ay: Any, ra: Any, bx: Any, by: Any, rb: Any, s: float) -> Meeting:
    """Intersect circle (a, ra) with circle (b, rb): RRR dyad.

    Heron's product for the half chord does not lose digits near tangency.
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
    """Intersect circle (a, r) with the line n.(p - q) = d (n a unit vector): RRP dyad."""
    e = nx * (ax - qx) + ny * (ay - qy) - d  # height of the centre over the line
    g2 = (r - e) * (r + e)
    reach = abs(ax - qx) + abs(ay - qy) + abs(d)
    noise = ROUNDINGS * (reach + r) * (abs(r - e) + abs(r + e))
    g = s * np.sqrt(where(g2 > 0.0, g2, 0.0))
    return ax - e * nx + g * ny, ay - e * ny - g * nx, g, g2, noise


@kernel
def line_line(qx: Any, qy: Any, nx: Any, ny: Any, d: Any, px: Any, py: Any, mx: Any, my: Any, e: Any) -> Meeting:
    """Intersect the lines n.(z - q) = d and m.(z - p) = e: PRP dyad; `g` is the sine of their angle."""
    g = nx * my - ny * mx
    safe = where(g == 0.0, 1.0, g)
    e = e + mx * (px - qx) + my * (py - qy)  # second line relative to q
    wx, wy = (my * d - ny * e) / safe, (nx * e - mx * d) / safe
    noise = 2.0 * ROUNDINGS * (abs(d) + abs(e) + abs(wx) + abs(wy) + 1.0)
    return qx + wx, qy + wy, g, g * g, where(g == 0.0, np.inf, noise)


@kernel
def tilt(wx: Any, wy: Any, e: Any, s: float) -> Meeting:
    """Rotate a line so that it passes through a point: RPR dyad, unit direction u with w = u (tau + i e).

    w: vector from a node of the rotating member to the point. e: signed distance of the point from the parallel to the
    line through that node. tau has the sign `s`.
    """
    w2 = wx * wx + wy * wy
    safe = where(w2 > 0.0, w2, 1.0)
    w = np.sqrt(safe)
    g2 = where(w2 > 0.0, (w - e) * (w + e), 0.0)
    noise = ROUNDINGS * (w + abs(e)) * (abs(w - e) + abs(w + e))
    g = s * np.sqrt(where(g2 > 0.0, g2, 0.0))
    return (wx * g + wy * e) / safe, (wy * g - wx * e) / safe, g, g2, noise


@kernel
def intersection_error(g: Any, noise: Any) -> Any:
    """Return the rounding error of an intersection: that of `g` from the one of `g2`."""
    size, least = abs(g), np.sqrt(noise)
    return noise / (2.0 * where(size > least, size, least))


@kernel
def may_jump(now: Any, last: Any, before: Any, step: Any, gap: Any) -> Any:
    """Return whether g may have jumped: it is not clearly closer to its prediction from two rows than -g is."""
    change = step / where(gap == 0.0, 1.0, gap) * (last - before)
    predicted = last + change
    near = where(abs(predicted - now) <= JUMP * abs(predicted + now), False, True)  # true for a NaN
    near = where(abs(now) >= NEAR * abs(change), near, True)
    return where(step <= STRETCH * gap, near, True)


@kernel
def dip(now: Any, last: Any, before: Any, step: Any, gap: Any) -> Any:
    """Return how far a smooth quantity may be from its chord between the last two of three values, with a margin.

    Twice the greatest distance of a parabola through the values at steps `gap` and `step`.
    """
    ratio = step / where(gap == 0.0, 1.0, gap)
    part = step / where(step + gap == 0.0, 1.0, step + gap)
    return DIP * abs(part * (now - last - ratio * (last - before)))
