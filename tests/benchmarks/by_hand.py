"""Programs that a user could write by hand for one mechanism: numba loops with the same dimensions and law.

Mechanisms of dyads: intersections of circles in closed form, sine and cosine at each step. Coupled ones: Newton-Raphson
in natural coordinates (the six coordinates of the three nodes of a ternary member), each step started
from the cubic through the last four positions, with a 6 by 6 elimination that allocates nothing.

Everything is in the file's units; results are arrays (points, 2, rows).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

ENOUGH = 1e-6
"""Correction, relative to the size, after which the remaining error (its square) is below 1e-10."""

TURN = 2.0 * math.pi


@njit
def meet(ax, ay, ra, bx, by, rb):
    """Return the intersection of circle (a, ra) with circle (b, rb), to the left of a -> b."""
    dx, dy = bx - ax, by - ay
    d2 = dx * dx + dy * dy
    along = 0.5 * (1.0 + (ra - rb) * (ra + rb) / d2)
    across = math.sqrt(ra * ra / d2 - along * along)
    return ax + along * dx - across * dy, ay + along * dy + across * dx


@njit
def crank_rocker(steps, everything):
    """Trace P and B; with `everything` also A."""
    out = np.empty((3 if everything else 2, 2, steps + 1))
    for k in range(steps + 1):
        angle = TURN * k / steps
        ax, ay = 40.0 * math.cos(angle), 40.0 * math.sin(angle)
        bx, by = meet(ax, ay, 120.0, 100.0, 0.0, 80.0)
        ux, uy = (bx - ax) / 120.0, (by - ay) / 120.0
        out[0, 0, k], out[0, 1, k] = ax + 60.0 * ux - 40.0 * uy, ay + 60.0 * uy + 40.0 * ux
        out[1, 0, k], out[1, 1, k] = bx, by
        if everything:
            out[2, 0, k], out[2, 1, k] = ax, ay
    return out


@njit
def jansen(steps, everything):
    """Trace the foot; with `everything` also the five moving nodes."""
    out = np.empty((6 if everything else 1, 2, steps + 1))
    gx, gy = -38.0, -7.8
    for k in range(steps + 1):
        angle = TURN * k / steps
        ax, ay = 15.0 * math.cos(angle), 15.0 * math.sin(angle)
        bx, by = meet(gx, gy, 41.5, ax, ay, 50.0)
        ux, uy = (bx - gx) / 41.5, (by - gy) / 41.5
        cx = gx + 2.6098795180722933 * ux - 40.01497880670621 * uy
        cy = gy + 2.6098795180722933 * uy + 40.01497880670621 * ux
        dx, dy = meet(ax, ay, 61.9, gx, gy, 39.3)
        ex, ey = meet(dx, dy, 36.7, cx, cy, 39.4)
        vx, vy = (ex - dx) / 36.7, (ey - dy) / 36.7
        out[0, 0, k] = dx - 7.746594005449595 * vx - 48.38378118041967 * vy
        out[0, 1, k] = dy - 7.746594005449595 * vy + 48.38378118041967 * vx
        if everything:
            out[1, 0, k], out[1, 1, k] = ax, ay
            out[2, 0, k], out[2, 1, k] = bx, by
            out[3, 0, k], out[3, 1, k] = cx, cy
            out[4, 0, k], out[4, 1, k] = dx, dy
            out[5, 0, k], out[5, 1, k] = ex, ey
    return out


@njit
def solve_6(a):
    """Solve the 6 by 6 system a[:, :6] s = a[:, 6] in place by elimination with pivots; the solution is in a[:, 6]."""
    for k in range(6):
        p, peak = k, abs(a[k, k])
        for i in range(k + 1, 6):
            if abs(a[i, k]) > peak:
                p, peak = i, abs(a[i, k])
        if p != k:
            for j in range(k, 7):
                a[k, j], a[p, j] = a[p, j], a[k, j]
        inverse = 1.0 / a[k, k]
        for i in range(k + 1, 6):
            f = a[i, k] * inverse
            if f != 0.0:
                for j in range(k + 1, 7):
                    a[i, j] -= f * a[k, j]
    for k in range(5, -1, -1):
        s = a[k, 6]
        for j in range(k + 1, 6):
            s -= a[k, j] * a[j, 6]
        a[k, 6] = s / a[k, k]


@njit
def triangle_and_legs(a, q, legs, sides, feet):
    """Fill the rows of the three legs (foot to node) and three sides; the last column is half the error of squares."""
    for i in range(6):
        for j in range(6):
            a[i, j] = 0.0
    for i in range(3):
        dx, dy = q[2 * i] - feet[2 * i], q[2 * i + 1] - feet[2 * i + 1]
        a[i, 2 * i], a[i, 2 * i + 1] = dx, dy
        a[i, 6] = 0.5 * (dx * dx + dy * dy - legs[i] * legs[i])
    for i in range(3):
        j = (i + 1) % 3
        dx, dy = q[2 * j] - q[2 * i], q[2 * j + 1] - q[2 * i + 1]
        a[3 + i, 2 * j], a[3 + i, 2 * j + 1] = dx, dy
        a[3 + i, 2 * i], a[3 + i, 2 * i + 1] = -dx, -dy
        a[3 + i, 6] = 0.5 * (dx * dx + dy * dy - sides[i] * sides[i])


@njit
def settle(a, q, legs, sides, feet, enough):
    """Correct q until a correction is so small that the next one is not needed."""
    for _ in range(50):
        triangle_and_legs(a, q, legs, sides, feet)
        solve_6(a)
        worst = 0.0
        for i in range(6):
            q[i] -= a[i, 6]
            worst = max(worst, abs(a[i, 6]))
        if worst <= enough:
            return


@njit
def follow(q, past, k):
    """Store position k - 1 as the last of four; start position k from the polynomial through the stored ones."""
    for i in range(6):
        past[3, i], past[2, i], past[1, i] = past[2, i], past[1, i], past[0, i]
        past[0, i] = q[i]
        if k >= 4:
            q[i] = 4.0 * (past[0, i] + past[2, i]) - 6.0 * past[1, i] - past[3, i]
        elif k == 3:
            q[i] = 3.0 * (past[0, i] - past[1, i]) + past[2, i]
        elif k == 2:
            q[i] = 2.0 * past[0, i] - past[1, i]


@njit
def stephenson(steps, everything, q, first):
    """Trace C, E, F from the drawn B, C, E and the drawn angle of FG; with `everything` also B.

    The legs are D-C, F-E and A-B.
    """
    out = np.empty((4 if everything else 3, 2, steps + 1))
    a, past = np.empty((6, 7)), np.empty((4, 6))
    legs = (math.sqrt(229.0), math.sqrt(634.0), math.sqrt(148.0))
    sides = (math.sqrt(149.0), math.sqrt(530.0), math.sqrt(481.0))  # C-E, E-B, B-C
    reach = math.sqrt(229.0)
    feet = np.array([23.0, 10.0, 0.0, 0.0, 7.0, 4.0])
    for k in range(steps + 1):
        angle = first + TURN * k / steps
        feet[2], feet[3] = 45.0 + reach * math.cos(angle), 17.0 + reach * math.sin(angle)
        if k:
            follow(q, past, k)
        settle(a, q, legs, sides, feet, ENOUGH * 35.0)
        out[0, 0, k], out[0, 1, k] = q[0], q[1]
        out[1, 0, k], out[1, 1, k] = q[2], q[3]
        out[2, 0, k], out[2, 1, k] = feet[2], feet[3]
        if everything:
            out[3, 0, k], out[3, 1, k] = q[4], q[5]
    return out


@njit
def platform(steps, everything, q):
    """Trace the platform's centre M from the drawn corners; with `everything` also corners and elbows."""
    out = np.empty((7 if everything else 1, 2, steps + 1))
    a, past, feet = np.empty((6, 7)), np.empty((4, 6)), np.empty(6)
    legs, side = (6.0, 6.0, 6.0), 5.196152422706632
    sides = (side, side, side)
    pivots = (-8.660254037844386, -5.0, 8.660254037844386, -5.0, 0.0, 10.0)
    begin, end = (76.0, -164.0, -35.0), (60.0, -150.0, -50.0)
    for k in range(steps + 1):
        for i in range(3):
            angle = math.radians(begin[i] + (end[i] - begin[i]) * (k / steps))
            feet[2 * i], feet[2 * i + 1] = (
                pivots[2 * i] + 6.0 * math.cos(angle),
                pivots[2 * i + 1] + 6.0 * math.sin(angle),
            )
        if k:
            follow(q, past, k)
        settle(a, q, legs, sides, feet, ENOUGH * 20.0)
        ux, uy = (q[2] - q[0]) / side, (q[3] - q[1]) / side
        out[0, 0, k] = q[0] + 2.598076211353316 * ux - 1.5 * uy
        out[0, 1, k] = q[1] + 2.598076211353316 * uy + 1.5 * ux
        if everything:
            for i in range(3):
                out[1 + i, 0, k], out[1 + i, 1, k] = q[2 * i], q[2 * i + 1]
                out[4 + i, 0, k], out[4 + i, 1, k] = feet[2 * i], feet[2 * i + 1]
    return out


DRAWN_STEPHENSON = (25.0, 25.0, 18.0, 35.0, 5.0, 16.0)
DRAWN_PLATFORM = (-1.7483, -1.6863, 3.3443, -0.6539, -0.0960, 3.2402)


def trace(name: str, steps: int, everything: bool = False) -> np.ndarray:
    """Return the traced points of a shipped model (points, 2, rows), in the order of its `trace`."""
    if name == "crank_rocker":
        return crank_rocker(steps, everything)
    if name == "jansen":
        return jansen(steps, everything)
    if name == "stephenson_3_far":
        return stephenson(steps, everything, np.array(DRAWN_STEPHENSON), math.atan2(32.0 - 17.0, 43.0 - 45.0))
    return platform(steps, everything, np.array(DRAWN_PLATFORM))
