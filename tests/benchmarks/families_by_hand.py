"""Loops that a user could write by hand for many designs of one mechanism: numba, without any check.

Designs are rows of lengths, all other dimensions are those of the models; results are arrays (designs, nodes, 2, rows).
"""

from __future__ import annotations

import math

import by_hand
import numpy as np
from numba import njit


@njit
def crank_rocker(designs, steps):
    """Return A, B and P for lengths of crank, coupler and rocker."""
    out = np.empty((len(designs), 3, 2, steps + 1))
    for d in range(len(designs)):
        crank, coupler, rocker = designs[d]
        for k in range(steps + 1):
            angle = by_hand.TURN * k / steps
            ax, ay = crank * math.cos(angle), crank * math.sin(angle)
            bx, by = by_hand.meet(ax, ay, coupler, 100.0, 0.0, rocker)
            ux, uy = (bx - ax) / coupler, (by - ay) / coupler
            out[d, 0, 0, k], out[d, 0, 1, k] = ax, ay
            out[d, 1, 0, k], out[d, 1, 1, k] = bx, by
            out[d, 2, 0, k], out[d, 2, 1, k] = ax + 60.0 * ux - 40.0 * uy, ay + 60.0 * uy + 40.0 * ux
    return out


@njit
def jansen(designs, steps):
    """Return J1, J2, J3, J4, J5 for lengths of m, j, k, c, f and g."""
    out = np.empty((len(designs), 5, 2, steps + 1))
    gx, gy = -38.0, -7.8
    for i in range(len(designs)):
        m, j, k, c, f, g = designs[i]
        for r in range(steps + 1):
            angle = by_hand.TURN * r / steps
            ax, ay = m * math.cos(angle), m * math.sin(angle)
            bx, by = by_hand.meet(gx, gy, 41.5, ax, ay, j)
            ux, uy = (bx - gx) / 41.5, (by - gy) / 41.5
            cx = gx + 2.6098795180722933 * ux - 40.01497880670621 * uy
            cy = gy + 2.6098795180722933 * uy + 40.01497880670621 * ux
            dx, dy = by_hand.meet(ax, ay, k, gx, gy, c)
            ex, ey = by_hand.meet(dx, dy, g, cx, cy, f)
            out[i, 0, 0, r], out[i, 0, 1, r] = ax, ay
            out[i, 1, 0, r], out[i, 1, 1, r] = bx, by
            out[i, 2, 0, r], out[i, 2, 1, r] = cx, cy
            out[i, 3, 0, r], out[i, 3, 1, r] = dx, dy
            out[i, 4, 0, r], out[i, 4, 1, r] = ex, ey
    return out


@njit
def triads(designs, drawn, pivots, begin, end, sides, enough, steps):
    """Return the corners of a triangle on three legs for lengths of three bars at the triangle and of three cranks.

    A crank of length 0 is a fixed pivot. Each design starts from the drawn corners (6,).
    """
    out = np.empty((len(designs), 3, 2, steps + 1))
    a, past, feet, q = np.empty((6, 7)), np.empty((4, 6)), np.empty(6), np.empty(6)
    for d in range(len(designs)):
        legs, cranks = designs[d, :3], designs[d, 3:]
        q[:] = drawn
        for k in range(steps + 1):
            for i in range(3):
                angle = begin[i] + (end[i] - begin[i]) * (k / steps)
                feet[2 * i] = pivots[2 * i] + cranks[i] * math.cos(angle)
                feet[2 * i + 1] = pivots[2 * i + 1] + cranks[i] * math.sin(angle)
            if k:
                by_hand.follow(q, past, k)
            by_hand.settle(a, q, legs, sides, feet, enough)
            for i in range(3):
                out[d, i, 0, k], out[d, i, 1, k] = q[2 * i], q[2 * i + 1]
    return out


def stephenson(designs, steps):
    """Return C, E, B for lengths of CD, EF, AB and FG."""
    begin = math.atan2(15.0, -2.0)
    cranks = np.zeros((len(designs), 6))
    cranks[:, :3], cranks[:, 4] = designs[:, :3], designs[:, 3]
    return triads(
        cranks, np.array(by_hand.DRAWN_STEPHENSON), np.array([23.0, 10.0, 45.0, 17.0, 7.0, 4.0]), np.full(3, begin),
        np.full(3, begin + by_hand.TURN), np.sqrt([149.0, 530.0, 481.0]), by_hand.ENOUGH * 35.0, steps,
    )  # fmt: skip


def platform(designs, steps):
    """Return C0, C1, C2 for lengths of the distal and the proximal links."""
    side = 5.196152422706632
    corner = math.hypot(2.598076211353316, 4.5)
    return triads(
        designs, np.array(by_hand.DRAWN_PLATFORM),
        np.array([-8.660254037844386, -5.0, 8.660254037844386, -5.0, 0.0, 10.0]), np.radians([76.0, -164.0, -35.0]),
        np.radians([60.0, -150.0, -50.0]), np.array([side, corner, corner]), by_hand.ENOUGH * 20.0, steps,
    )  # fmt: skip
