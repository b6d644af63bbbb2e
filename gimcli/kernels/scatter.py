"""Independent positions of a plan in closed form, one row after another: nothing is followed, nothing predicted."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gimcli.kernels.circular import cos_sin
from gimcli.kernels.constraints import angle_error, height_error, span_error
from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.loci import circle_circle, circle_line, line_line, tilt
from gimcli.kernels.march import CIRCLE_AND_LINE, ORIENT, PLACE, TILT, TWO_CIRCLES, Program
from gimcli.mechanism import ANGLE, SPAN, FloatArray

AX, AY, AC, AD, AE, BX, BY, BC, BD, BE, EX, EY = range(12)
"""Operands in the scratch `e`: two loci (point, then radius, or normal and height), and a vector."""


class Scratch(NamedTuple):
    """One position at a time."""

    x: FloatArray  # (nodes,) the frame's are given
    y: FloatArray
    rx: FloatArray  # (registers,) directions
    ry: FloatArray
    u: FloatArray  # (actuators,)
    cos: FloatArray
    sin: FloatArray
    e: FloatArray  # (12,) operands


@stage
def vector(q: Program, s: Scratch, k: int) -> None:
    """Put vector k into the operands."""
    zr, zi, actuator = q.vz[k, 0], q.vz[k, 1], q.vi[k, 3]
    if actuator >= 0:
        c, si = s.cos[actuator], s.sin[actuator] * q.vi[k, 4]
        zr, zi = zr * c - zi * si, zr * si + zi * c
    bx, by = 1.0, 0.0
    if q.vi[k, 0] >= 0:
        bx, by = s.x[q.vi[k, 1]] - s.x[q.vi[k, 0]], s.y[q.vi[k, 1]] - s.y[q.vi[k, 0]]
    elif q.vi[k, 2] >= 0:
        bx, by = s.rx[q.vi[k, 2]], s.ry[q.vi[k, 2]]
    s.e[EX], s.e[EY] = zr * bx - zi * by, zr * by + zi * bx


@kernel
def length(constant: float, gain: float, actuator: int, s: Scratch) -> float:
    """Return a length that may follow an actuator."""
    return constant + gain * s.u[actuator] if actuator >= 0 else constant


@stage
def locus(q: Program, s: Scratch, k: int, to: int) -> None:
    """Put locus k into the operands."""
    s.e[to], s.e[to + 1] = s.x[q.li[k, 0]], s.y[q.li[k, 0]]
    if q.li[k, 1] >= 0:
        vector(q, s, q.li[k, 1])
        s.e[to] += s.e[EX]
        s.e[to + 1] += s.e[EY]
    value = length(q.lv[k, 0], q.lv[k, 1], q.li[k, 3], s)
    if q.li[k, 2] >= 0:
        vector(q, s, q.li[k, 2])
        s.e[to + 2], s.e[to + 3], s.e[to + 4] = s.e[EX], s.e[EY], value
    else:
        s.e[to + 2] = value


@stage
def meet(q: Program, s: Scratch, k: int, sign: float) -> bool:
    """Place a node where two loci meet; return whether they do."""
    kind, node, e = q.steps[k, 0], q.steps[k, 1], s.e
    locus(q, s, q.steps[k, 2], AX)
    locus(q, s, q.steps[k, 3], BX)
    if kind == TWO_CIRCLES:
        x, y, _, g2, noise = circle_circle(e[AX], e[AY], e[AC], e[BX], e[BY], e[BC], sign)
    elif kind == CIRCLE_AND_LINE:
        x, y, _, g2, noise = circle_line(e[AX], e[AY], e[AC], e[BX], e[BY], e[BC], e[BD], e[BE], sign)
    else:
        x, y, _, g2, noise = line_line(
            e[AX], e[AY], e[AC], e[AD], e[AE], e[BX], e[BY], e[BC], e[BD], e[BE]
        )  # fmt: skip
    s.x[node], s.y[node] = x, y
    return g2 >= -noise


@stage
def position(q: Program, s: Scratch, sign: FloatArray) -> bool:
    """Place all nodes; return whether they can be."""
    for k in range(q.steps.shape[0]):
        kind, to, branch = q.steps[k, 0], q.steps[k, 1], q.steps[k, 5]
        side = sign[branch] if branch >= 0 else 1.0
        if kind == PLACE:
            vector(q, s, q.steps[k, 3])
            anchor = q.steps[k, 2]
            s.x[to], s.y[to] = s.x[anchor] + s.e[EX], s.y[anchor] + s.e[EY]
        elif kind == ORIENT:
            vector(q, s, q.steps[k, 3])
            s.rx[to], s.ry[to] = s.e[EX], s.e[EY]
        elif kind == TILT:
            a, b = q.steps[k, 2], q.steps[k, 3]
            ux, uy, _, g2, noise = tilt(s.x[b] - s.x[a], s.y[b] - s.y[a], q.reach[k], side)
            s.rx[to], s.ry[to] = ux, uy
            if not g2 >= -noise:
                return False
        elif not meet(q, s, k, side):
            return False
    return True


@stage
def worst(q: Program, s: Scratch) -> float:
    """Return the greatest error of the constraints as written in the model; a NaN is infinite."""
    most = 0.0
    for k in range(q.ci.shape[0]):
        kind, p, o = q.ci[k, 0], q.ci[k, 1], q.ci[k, 2]
        if kind == ANGLE:
            vector(q, s, q.ci[k, 3])
            ax, ay = s.e[EX], s.e[EY]
            vector(q, s, q.ci[k, 4])
            error = angle_error(ax, ay, s.e[EX], s.e[EY])
        else:
            dx, dy = s.x[p], s.y[p]
            if o >= 0:
                dx, dy = dx - s.x[o], dy - s.y[o]
            value = length(q.cv[k, 0], q.cv[k, 1], q.ci[k, 5], s)
            if kind == SPAN:
                error = span_error(dx, dy, 1.0 / value)
            else:
                vector(q, s, q.ci[k, 3])
                error = height_error(s.e[EX], s.e[EY], dx, dy, value, q.size)
        if not error <= most:
            most = error if error <= math.inf else math.inf
    return most


@kernel
def scatter(
    q: Program, s: Scratch, values: FloatArray, sign: FloatArray, on: FloatArray, bound: float, out: FloatArray
) -> int:
    """Fill the point (rows, 2) at inputs (actuators, rows), NaN where nothing is assembled; return how many are.

    The point is z_u + (on_2 + i on_3) (z_v - z_u) for nodes u = on_0 and v = on_1.
    """
    done, u, v = 0, int(on[0]), int(on[1])
    for row in range(values.shape[1]):
        for k in range(values.shape[0]):
            s.u[k] = values[k, row]
            s.cos[k], s.sin[k] = cos_sin(values[k, row])
        out[row, 0] = out[row, 1] = np.nan
        if position(q, s, sign) and worst(q, s) <= bound:
            dx, dy = s.x[v] - s.x[u], s.y[v] - s.y[u]
            out[row, 0] = s.x[u] + on[2] * dx - on[3] * dy
            out[row, 1] = s.y[u] + on[2] * dy + on[3] * dx
            done += 1
    return done
