"""A whole motion in one call: the steps of a plan over short stretches of rows that stay in the cache.

The scratch `w` holds lanes of WIDTH numbers, one lane a coordinate: HISTORY solved rows, then ROWS
new ones. Operands of a formula are copied to lanes with fixed numbers, so that the compiler knows how
far apart they are and works on several rows at once. The formulas and the tests of doubtful rows
are those of `loci` and `constraints`, which the plain form runs over arrays.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gimcli.kernels.choice import where
from gimcli.kernels.circular import cos_sin
from gimcli.kernels.constraints import angle_error, height_error, span_error
from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.loci import circle_circle, circle_line, doubt, leaps, line_line, tilt
from gimcli.kernels.newton import LAST_SIGN, GroupArrays, RowPosition, StopLimits, couple
from gimcli.mechanism import ANGLE, SPAN, FloatArray, IntArray

HISTORY = 8
ROWS = 512
WIDTH = HISTORY + ROWS
KEPT = 2048
"""Rows after which some are kept to continue from."""

PLACE, ORIENT, TILT, TWO_CIRCLES, CIRCLE_AND_LINE, TWO_LINES, COUPLED = range(7)

# lanes with fixed numbers: operands a..j, results, and what is known of every row
(
    A,
    B,
    C,
    D,
    E,
    F,
    G,
    H,
    I,
    J,
    EX,
    EY,
    BX,
    BY,
    CO,
    SI,
    X,
    Y,
    MEASURE,
    SQUARE,
    NOISE,
    DOUBT,
    TIME,
    ERROR,
    WORK,
    WORST,
) = range(26)
FIXED = 26


class Lanes(NamedTuple):
    """First lanes of what a plan has several of."""

    x: int
    y: int
    rx: int
    ry: int
    values: int
    cos: int
    sin: int
    g: int


class Program(NamedTuple):
    """A plan and the checks of its mechanism as flat arrays; -1 stands for none."""

    steps: IntArray  # (steps, 6) kind, node or register, three operands, branch
    reach: FloatArray  # (steps,) distance of a turned line
    vi: IntArray  # (vectors, 5) u, v, register, actuator, turn
    vz: FloatArray  # (vectors, 2)
    li: IntArray  # (loci, 4) node, offset, normal, actuator
    lv: FloatArray  # (loci, 2) constant, gain
    gi: IntArray  # (groups, 12) base, rows, turning, first and last of nodes, vectors, places, equations
    nodes: IntArray  # arrays of all groups, one after the other
    gvi: IntArray
    gvz: FloatArray
    gpi: IntArray
    gei: IntArray
    gev: FloatArray
    ci: IntArray  # (checks, 6) kind, p, q, first vector, second vector, actuator
    cv: FloatArray  # (checks, 2) constant, gain
    size: float


class Rows(NamedTuple):
    """What a motion asks for and what comes out; row by row."""

    time: FloatArray  # (rows,)
    values: FloatArray  # (actuators, rows)
    z: FloatArray  # (nodes, rows, 2)
    residual: FloatArray  # (rows,)
    work: FloatArray  # (rows,)
    kept: FloatArray  # (entries, lanes) rows to continue from: a ring
    mark: IntArray  # (2,) entries written to the ring, rows since


@stage
def take(lanes: FloatArray, to: int, lane: int, high: int) -> None:
    """Copy a lane."""
    a, b = lanes[to], lanes[lane]
    for r in range(high):
        a[r] = b[r]


@stage
def give(lanes: FloatArray, to: int, lane: int, high: int) -> None:
    """Copy the new rows of a lane: solved ones stay as they are."""
    a, b = lanes[to], lanes[lane]
    for r in range(HISTORY, high):
        a[r] = b[r]


@stage
def subtract(lanes: FloatArray, to: int, plus: int, minus: int, high: int) -> None:
    """Lay out the difference of two lanes."""
    a, b, c = lanes[to], lanes[plus], lanes[minus]
    for r in range(high):
        a[r] = b[r] - c[r]


@stage
def fill(lanes: FloatArray, to: int, value: float, high: int) -> None:
    """Fill a lane."""
    a = lanes[to]
    for r in range(high):
        a[r] = value


@stage
def lay_vector(w: FloatArray, lanes: FloatArray, vi: IntArray, vz: FloatArray, at: Lanes, k: int, high: int) -> None:
    """Lay out vector k in lanes EX and EY."""
    u, v, register, actuator = vi[k, 0], vi[k, 1], vi[k, 2], vi[k, 3]
    zr, zi = vz[k, 0], vz[k, 1]
    if u >= 0:
        subtract(lanes, BX, at.x + v, at.x + u, high)
        subtract(lanes, BY, at.y + v, at.y + u, high)
    elif register >= 0:
        take(lanes, BX, at.rx + register, high)
        take(lanes, BY, at.ry + register, high)
    else:
        fill(lanes, BX, 1.0, high)
        fill(lanes, BY, 0.0, high)
    if actuator >= 0:
        take(lanes, CO, at.cos + actuator, high)
        take(lanes, SI, at.sin + actuator, high)
        turn = vi[k, 4]
        for r in range(high):
            c, s = w[CO * WIDTH + r], w[SI * WIDTH + r] * turn
            a, b = zr * c - zi * s, zr * s + zi * c
            x, y = w[BX * WIDTH + r], w[BY * WIDTH + r]
            w[EX * WIDTH + r] = a * x - b * y
            w[EY * WIDTH + r] = a * y + b * x
    else:
        for r in range(high):
            x, y = w[BX * WIDTH + r], w[BY * WIDTH + r]
            w[EX * WIDTH + r] = zr * x - zi * y
            w[EY * WIDTH + r] = zr * y + zi * x


@stage
def lay_value(lanes: FloatArray, at: Lanes, to: int, constant: float, gain: float, actuator: int, high: int) -> None:
    """Lay out a length that may follow an actuator."""
    if actuator >= 0:
        a, b = lanes[to], lanes[at.values + actuator]
        for r in range(high):
            a[r] = constant + gain * b[r]
    else:
        fill(lanes, to, constant, high)


@stage
def lay_inverse(lanes: FloatArray, at: Lanes, to: int, constant: float, gain: float, actuator: int, high: int) -> None:
    """Lay out one over a length that may follow an actuator."""
    lay_value(lanes, at, to, constant, gain, actuator, high)
    if actuator < 0:
        fill(lanes, to, 1.0 / constant, high)
    else:
        a = lanes[to]
        for r in range(high):
            a[r] = 1.0 / a[r]


@stage
def lay_locus(w: FloatArray, lanes: FloatArray, q: Program, at: Lanes, k: int, to: int, high: int) -> None:
    """Lay out locus k: centre and radius, or a point, the normal and the height of a line."""
    node, offset, normal = q.li[k, 0], q.li[k, 1], q.li[k, 2]
    take(lanes, to, at.x + node, high)
    take(lanes, to + 1, at.y + node, high)
    if offset >= 0:
        lay_vector(w, lanes, q.vi, q.vz, at, offset, high)
        x, y, ex, ey = lanes[to], lanes[to + 1], lanes[EX], lanes[EY]
        for r in range(high):
            x[r] += ex[r]
            y[r] += ey[r]
    if normal >= 0:
        lay_vector(w, lanes, q.vi, q.vz, at, normal, high)
        take(lanes, to + 2, EX, high)
        take(lanes, to + 3, EY, high)
    lay_value(lanes, at, to + 2 if normal < 0 else to + 4, q.lv[k, 0], q.lv[k, 1], q.li[k, 3], high)


@stage
def carry(w: FloatArray, lanes: FloatArray, q: Program, at: Lanes, k: int, high: int) -> None:
    """Carry a node along, or keep a direction in its register."""
    x, y = at.rx + q.steps[k, 1], at.ry + q.steps[k, 1]
    lay_vector(w, lanes, q.vi, q.vz, at, q.steps[k, 3], high)
    if q.steps[k, 0] == PLACE:
        x, y = at.x + q.steps[k, 1], at.y + q.steps[k, 1]
        ex, ey, ax, ay = lanes[EX], lanes[EY], lanes[at.x + q.steps[k, 2]], lanes[at.y + q.steps[k, 2]]
        for r in range(high):
            ex[r] += ax[r]
            ey[r] += ay[r]
        give(lanes, x, EX, high)
        give(lanes, y, EY, high)
    else:  # of the history too: whether lines have turned is found from it
        take(lanes, x, EX, high)
        take(lanes, y, EY, high)


@kernel
def note(w: FloatArray, r: int, x: float, y: float, g: float, g2: float, noise: float) -> None:
    """Keep what two loci give."""
    w[X * WIDTH + r], w[Y * WIDTH + r], w[MEASURE * WIDTH + r] = x, y, g
    w[SQUARE * WIDTH + r], w[NOISE * WIDTH + r] = g2, noise


@stage
def meet_circles(w: FloatArray, sign: float, high: int) -> None:
    """Meet the circles A, B, C and D, E, F; A and B become the way between their centres."""
    for r in range(high):
        x, y, g, g2, noise = circle_circle(
            w[A * WIDTH + r], w[B * WIDTH + r], w[C * WIDTH + r], w[D * WIDTH + r], w[E * WIDTH + r],
            w[F * WIDTH + r], sign,
        )  # fmt: skip
        note(w, r, x, y, g, g2, noise)
    for r in range(high):
        w[A * WIDTH + r] = w[D * WIDTH + r] - w[A * WIDTH + r]
        w[B * WIDTH + r] = w[E * WIDTH + r] - w[B * WIDTH + r]


@stage
def meet_circle_and_line(w: FloatArray, sign: float, high: int) -> None:
    """Meet the circle C, D, E and the line F ... J; A and B become the line's normal."""
    for r in range(high):
        x, y, g, g2, noise = circle_line(
            w[C * WIDTH + r], w[D * WIDTH + r], w[E * WIDTH + r], w[F * WIDTH + r], w[G * WIDTH + r],
            w[H * WIDTH + r], w[I * WIDTH + r], w[J * WIDTH + r], sign,
        )  # fmt: skip
        note(w, r, x, y, g, g2, noise)
    for r in range(high):
        w[A * WIDTH + r] = w[H * WIDTH + r]
        w[B * WIDTH + r] = w[I * WIDTH + r]


@stage
def meet_lines(w: FloatArray, high: int) -> None:
    """Meet the lines A ... E and F ... J; A and B become the sine between them and 0."""
    for r in range(high):
        x, y, g, g2, noise = line_line(
            w[A * WIDTH + r], w[B * WIDTH + r], w[C * WIDTH + r], w[D * WIDTH + r], w[E * WIDTH + r],
            w[F * WIDTH + r], w[G * WIDTH + r], w[H * WIDTH + r], w[I * WIDTH + r], w[J * WIDTH + r],
        )  # fmt: skip
        note(w, r, x, y, g, g2, noise)
    for r in range(high):
        w[A * WIDTH + r] = w[MEASURE * WIDTH + r]
        w[B * WIDTH + r] = 0.0


@stage
def meet(w: FloatArray, lanes: FloatArray, q: Program, at: Lanes, k: int, sign: float, high: int) -> None:
    """Meet two loci; lanes A and B keep what the side refers to."""
    kind, first, second = q.steps[k, 0], q.steps[k, 2], q.steps[k, 3]
    if kind == TWO_CIRCLES:
        lay_locus(w, lanes, q, at, first, A, high)
        lay_locus(w, lanes, q, at, second, D, high)
        meet_circles(w, sign, high)
    elif kind == CIRCLE_AND_LINE:
        lay_locus(w, lanes, q, at, first, C, high)
        lay_locus(w, lanes, q, at, second, F, high)
        meet_circle_and_line(w, sign, high)
    else:
        lay_locus(w, lanes, q, at, first, A, high)
        lay_locus(w, lanes, q, at, second, F, high)
        meet_lines(w, high)


@stage
def turn_line(w: FloatArray, lanes: FloatArray, q: Program, at: Lanes, k: int, sign: float, high: int) -> None:
    """Turn a line so that it passes a node."""
    a, b, e = q.steps[k, 2], q.steps[k, 3], q.reach[k]
    subtract(lanes, A, at.x + b, at.x + a, high)
    subtract(lanes, B, at.y + b, at.y + a, high)
    for r in range(high):
        x, y, g, g2, noise = tilt(w[A * WIDTH + r], w[B * WIDTH + r], e, sign)
        note(w, r, x, y, g, g2, noise)


@stage
def guard(w: FloatArray, lanes: FloatArray, at: Lanes, branch: int, turning: bool, tolerance: float, high: int) -> int:
    """Return the first row that has no solution, is singular, or may have jumped."""
    new = high - HISTORY
    for k in range(new):
        r = HISTORY + k
        noise = w[NOISE * WIDTH + r]
        error = doubt(w[MEASURE * WIDTH + r], noise)
        w[ERROR * WIDTH + r] = where(error > w[ERROR * WIDTH + r], error, w[ERROR * WIDTH + r])
        w[DOUBT * WIDTH + r] = where((w[SQUARE * WIDTH + r] >= -noise) & (error <= tolerance), 0.0, 1.0)
    if branch >= 0:
        take(lanes, MEASURE, at.g + branch, HISTORY)
        for k in range(new):
            r = HISTORY + k
            leap = leaps(
                w[MEASURE * WIDTH + r], w[MEASURE * WIDTH + r - 1], w[MEASURE * WIDTH + r - 2],
                w[TIME * WIDTH + r] - w[TIME * WIDTH + r - 1], w[TIME * WIDTH + r - 1] - w[TIME * WIDTH + r - 2],
            )  # fmt: skip
            w[DOUBT * WIDTH + r] = where(leap, 1.0, w[DOUBT * WIDTH + r])
        give(lanes, at.g + branch, MEASURE, high)
    if turning:
        for k in range(new):
            r = HISTORY + k
            along = w[A * WIDTH + r] * w[A * WIDTH + r - 1] + w[B * WIDTH + r] * w[B * WIDTH + r - 1]
            w[DOUBT * WIDTH + r] = where(along < 0.0, 1.0, w[DOUBT * WIDTH + r])
    for r in range(HISTORY, high):
        if w[DOUBT * WIDTH + r] != 0.0:
            return r
    return high


@kernel
def group_at(q: Program, k: int) -> GroupArrays:
    """Return a coupled group."""
    gi = q.gi
    return GroupArrays(
        gi[k, 0], gi[k, 1], gi[k, 2] != 0, q.nodes[gi[k, 3] : gi[k, 4]], q.gvi[gi[k, 5] : gi[k, 6]],
        q.gvz[gi[k, 5] : gi[k, 6]], q.gpi[gi[k, 7] : gi[k, 8]], q.gei[gi[k, 9] : gi[k, 10]],
        q.gev[gi[k, 9] : gi[k, 10]],
    )  # fmt: skip


@stage
def settle_group(
    lanes: FloatArray,
    q: Program,
    at: Lanes,
    k: int,
    determinant: FloatArray,
    room: RowPosition,
    limits: StopLimits,
    high: int,
) -> int:
    """Settle a coupled group in all rows; return the first that did not settle safely."""
    stop = couple(
        lanes[at.x : at.y], lanes[at.y : at.rx], lanes[at.rx : at.ry], lanes[at.ry : at.values],
        lanes[at.values : at.cos], lanes[at.cos : at.sin], lanes[at.sin : at.g], lanes[TIME], HISTORY, high,
        group_at(q, k), room, determinant[k], limits, lanes[WORK], lanes[ERROR], True,
    )  # fmt: skip
    determinant[k] = room.out[LAST_SIGN]
    return stop


@stage
def step(
    w: FloatArray, lanes: FloatArray, q: Program, at: Lanes, k: int, sign: FloatArray, tolerance: float, high: int
) -> int:
    """Take one step of the plan in closed form; return the first row that it could not solve safely."""
    kind, node, branch = q.steps[k, 0], q.steps[k, 1], q.steps[k, 5]
    if kind in (PLACE, ORIENT):
        carry(w, lanes, q, at, k, high)
        return high
    x, y = (at.rx + node, at.ry + node) if kind == TILT else (at.x + node, at.y + node)
    s = sign[branch] if branch >= 0 else 1.0
    if kind == TILT:
        turn_line(w, lanes, q, at, k, s, high)
        take(lanes, x, X, high)  # of the history too, as `carry`
        take(lanes, y, Y, high)
    else:
        meet(w, lanes, q, at, k, s, high)
        give(lanes, x, X, high)
        give(lanes, y, Y, high)
    return guard(w, lanes, at, branch, kind != TILT, tolerance, high)


@stage
def check_angle(w: FloatArray, high: int) -> None:
    """Fill the angles between A, B and EX, EY."""
    for r in range(high):
        w[X * WIDTH + r] = angle_error(w[A * WIDTH + r], w[B * WIDTH + r], w[EX * WIDTH + r], w[EY * WIDTH + r])


@stage
def check_span(w: FloatArray, high: int) -> None:
    """Fill the errors of the length of A, B, one over which is C."""
    for r in range(high):
        w[X * WIDTH + r] = span_error(w[A * WIDTH + r], w[B * WIDTH + r], w[C * WIDTH + r])


@stage
def check_height(w: FloatArray, size: float, high: int) -> None:
    """Fill the errors of the height C of A, B over the normal EX, EY."""
    for r in range(high):
        w[X * WIDTH + r] = height_error(
            w[EX * WIDTH + r], w[EY * WIDTH + r], w[A * WIDTH + r], w[B * WIDTH + r], w[C * WIDTH + r], size
        )


@stage
def check(w: FloatArray, lanes: FloatArray, q: Program, at: Lanes, high: int) -> None:
    """Fill the worst error of all constraints, as written in the model."""
    fill(lanes, WORST, 0.0, high)
    for k in range(q.ci.shape[0]):
        kind, p, o = q.ci[k, 0], q.ci[k, 1], q.ci[k, 2]
        if kind == ANGLE:
            lay_vector(w, lanes, q.vi, q.vz, at, q.ci[k, 3], high)
            take(lanes, A, EX, high)
            take(lanes, B, EY, high)
            lay_vector(w, lanes, q.vi, q.vz, at, q.ci[k, 4], high)
            check_angle(w, high)
        else:
            if o >= 0:
                subtract(lanes, A, at.x + p, at.x + o, high)
                subtract(lanes, B, at.y + p, at.y + o, high)
            else:
                take(lanes, A, at.x + p, high)
                take(lanes, B, at.y + p, high)
            if kind == SPAN:
                lay_inverse(lanes, at, C, q.cv[k, 0], q.cv[k, 1], q.ci[k, 5], high)
                check_span(w, high)
            else:
                lay_value(lanes, at, C, q.cv[k, 0], q.cv[k, 1], q.ci[k, 5], high)
                lay_vector(w, lanes, q.vi, q.vz, at, q.ci[k, 3], high)
                check_height(w, q.size, high)
        for r in range(high):
            error, worst = w[X * WIDTH + r], w[WORST * WIDTH + r]
            w[WORST * WIDTH + r] = where(error <= worst, worst, where(error <= math.inf, error, math.inf))


@stage
def turns(w: FloatArray, high: int) -> None:
    """Fill cosines and sines of the angles A."""
    for r in range(high):
        w[CO * WIDTH + r], w[SI * WIDTH + r] = cos_sin(w[A * WIDTH + r])


@stage
def begin(w: FloatArray, lanes: FloatArray, at: Lanes, rows: Rows, done: int, count: int) -> None:
    """Lay out what is given of the next rows."""
    time, new = lanes[TIME], rows.time[done : done + count]
    for k in range(count):
        time[HISTORY + k] = new[k]
    fill(lanes, ERROR, 0.0, WIDTH)
    fill(lanes, WORK, 0.0, WIDTH)
    for a in range(rows.values.shape[0]):
        value, given = lanes[at.values + a], rows.values[a, done : done + count]
        for k in range(count):
            value[HISTORY + k] = given[k]
        take(lanes, A, at.values + a, HISTORY + count)
        turns(w, HISTORY + count)
        give(lanes, at.cos + a, CO, HISTORY + count)
        give(lanes, at.sin + a, SI, HISTORY + count)


@stage
def finish(lanes: FloatArray, at: Lanes, rows: Rows, done: int, solved: int, iterates: bool) -> None:
    """Write the solved rows out, and make the last of them the history of what is to come."""
    for node in range(rows.z.shape[0]):
        x, y, z = lanes[at.x + node], lanes[at.y + node], rows.z[node, done : done + solved]
        for k in range(solved):
            z[k, 0] = x[HISTORY + k]
            z[k, 1] = y[HISTORY + k]
    worst, residual = lanes[WORST], rows.residual[done : done + solved]
    for k in range(solved):
        residual[k] = worst[HISTORY + k]
    if iterates:
        work, spent = lanes[WORK], rows.work[done : done + solved]
        for k in range(solved):
            spent[k] = work[HISTORY + k]
    for lane in range(lanes.shape[0]):
        for r in range(HISTORY):
            lanes[lane, r] = lanes[lane, solved + r]


@stage
def keep(lanes: FloatArray, rows: Rows, solved: int, force: bool) -> None:
    """Keep the last rows now and then, to continue from."""
    rows.mark[1] += solved
    if force or rows.mark[1] >= KEPT:
        rows.mark[1] = 0
        for r in range(HISTORY):
            entry = rows.mark[0] % rows.kept.shape[0]
            for lane in range(lanes.shape[0]):
                rows.kept[entry, lane] = lanes[lane, r]
            rows.mark[0] += 1


@kernel
def march(
    w: FloatArray, lanes: FloatArray, q: Program, at: Lanes, rows: Rows, first: int, sign: FloatArray,
    determinant: FloatArray, room: RowPosition, limits: StopLimits, tolerance: float,
) -> int:  # fmt: skip
    """Solve rows from `first` on until one is doubtful; return how many were solved.

    w and lanes (lanes, WIDTH) are one memory; their first HISTORY rows are solved (a time of -inf: not there).
    """
    total, done = rows.time.shape[0], first
    while done < total:
        count = min(ROWS, total - done)
        high = HISTORY + count
        begin(w, lanes, at, rows, done, count)
        for k in range(q.steps.shape[0]):
            if q.steps[k, 0] == COUPLED:
                high = settle_group(lanes, q, at, q.steps[k, 2], determinant, room, limits, high)
            else:
                high = step(w, lanes, q, at, k, sign, tolerance, high)
            if high == HISTORY:
                break
        check(w, lanes, q, at, high)
        solved = high - HISTORY
        finish(lanes, at, rows, done, solved, q.gi.shape[0] > 0)
        done += solved
        keep(lanes, rows, solved, solved < count or done == total)
        if solved < count:
            break
    return done - first
