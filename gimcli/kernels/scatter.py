"""Positions of a plan in closed form for many independent inputs, without following a motion."""

from __future__ import annotations

import numpy as np

from gimcli.kernels.choice import where
from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.plan_steps import (
    DOUBT,
    HISTORY,
    NOISE,
    ROWS,
    SQUARE,
    WIDTH,
    WORST,
    A,
    B,
    Lanes,
    Program,
    Scratch,
    before,
    check,
    earlier,
    fill,
    load_inputs,
    new_rows,
    place,
    rows,
    subtract,
)
from gimcli.mechanism import FloatArray


@stage
def write_positions(w: Scratch, at: Lanes, on: FloatArray, bound: float, out: FloatArray, high: int) -> None:
    """Write the positions of the point (rows, 2), NaN where the loci of a step do not intersect or a check fails."""
    u, v = int(on[0]), int(on[1])
    subtract(w, A, at.x + v, at.x + u, high)
    subtract(w, B, at.y + v, at.y + u, high)
    for r in new_rows(HISTORY, high):
        good = (earlier(w, DOUBT, r, 0) == 0.0) & (earlier(w, WORST, r, 0) <= bound)
        x, y, dx, dy = earlier(w, at.x + u, r, 0), earlier(w, at.y + u, r, 0), earlier(w, A, r, 0), earlier(w, B, r, 0)
        out[before(r, HISTORY), 0] = where(good, x + on[2] * dx - on[3] * dy, np.nan)
        out[before(r, HISTORY), 1] = where(good, y + on[2] * dy + on[3] * dx, np.nan)


@kernel
def scatter(
    w: Scratch, q: Program, at: Lanes, values: FloatArray, sign: FloatArray, on: FloatArray, bound: float,
    out: FloatArray,
) -> None:  # fmt: skip
    """Write the positions of a point (rows, 2) for inputs (actuators, rows), NaN where there is no assembled position.

    The point is z_u + (on_2 + i on_3) (z_v - z_u) for nodes u = on_0 and v = on_1. `w` contains the frame's nodes.
    """
    for done in range(0, values.shape[1], ROWS):
        high = HISTORY + min(ROWS, values.shape[1] - done)
        load_inputs(w, at, values, done, high)
        fill(w, DOUBT, 0.0, high)
        for k in range(len(q.steps)):
            if place(w, q, at, k, sign, high):
                for r in rows(high):
                    g2, noise, doubt = w[SQUARE * WIDTH + r], w[NOISE * WIDTH + r], w[DOUBT * WIDTH + r]
                    w[DOUBT * WIDTH + r] = where(g2 >= -noise, doubt, 1.0)
        check(w, q, at, high)
        write_positions(w, at, on, bound, out[done : done + high - HISTORY], high)
