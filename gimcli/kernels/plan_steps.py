"""The closed-form steps of a plan and its checks, over a block of rows that fits into the processor cache.

The array `w` consists of lanes, one for each coordinate: HISTORY rows (the last solved ones, if a motion is followed),
then the new rows. Operands of a formula are copied to lanes with fixed numbers, so that the compiler knows their
distances and vectorises the loop. One source serves both forms: when interpreted, numpy processes all rows of a lane
at once, and lanes with fixed numbers are references to other lanes instead of copies.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from gimcli.kernels.choice import larger, mark, smaller, unless, where
from gimcli.kernels.circular import cos_sin
from gimcli.kernels.constraints import angle_error, height_error, span_error
from gimcli.kernels.jit import kernel, scalar_form, stage
from gimcli.kernels.loci import circle_circle, circle_line, dip, intersection_error, line_line, may_jump, tilt
from gimcli.mechanism import ANGLE, SPAN, FloatArray

HISTORY = 8
ROWS = 512
WIDTH = HISTORY + ROWS

LEAST_STEP = 64.0 * float(np.finfo(float).eps)
"""Added to steps, relative to the time: those of a few roundings of the time count as equal."""

PLACE, ORIENT, TILT, TWO_CIRCLES, CIRCLE_AND_LINE, TWO_LINES, COUPLED = range(7)

# lanes with fixed numbers: operands A..J, results, and the state of every row
(
    A, B, C, D, E, F, G, H, I, J, EX, EY, BX, BY, CO, SI, X, Y, MEASURE, SQUARE, NOISE, DOUBT, TIME, ERROR, WORK, WORST,
) = range(26)  # fmt: skip
FIXED = 26

Scratch = Any
"""Interpreted: {WIDTH * number: array over the rows, or constant} of the lanes; compiled: one flat array."""

Table = Any
"""Rows of numbers: an array when compiled, a list when interpreted."""


class Lanes(NamedTuple):
    """Number of the first lane of each kind: coordinates, registers, inputs with cosine and sine, measures g."""

    x: int
    y: int
    rx: int
    ry: int
    values: int
    cos: int
    sin: int
    g: int


class Program(NamedTuple):
    """A plan and the checks of its mechanism as flat tables; -1: none."""

    steps: Table  # (steps, 6) kind, node or register, three operands, branch
    reach: Table  # (steps,) distance e of a TILT
    vi: Table  # (vectors, 5) u, v, register, actuator, turn
    vz: Table  # (vectors, 2)
    li: Table  # (loci, 4) node, offset, normal, actuator
    lv: Table  # (loci, 2) constant, gain
    ci: Table  # (checks, 6) kind, p, q, first vector, second vector, actuator
    cv: Table  # (checks, 2) constant, gain
    size: float


@scalar_form(range)
def rows(high: int) -> Any:
    """Return the row numbers of a block, to be added to a lane's first index; interpreted: only 0, the whole lane."""
    return (0,)


@scalar_form(range)
def new_rows(first: int, high: int) -> Any:
    """Return the rows from `first` on; interpreted: one slice."""
    return (slice(first, high),)


def _index(lane: int, r: int) -> np.uint64:
    return np.uint64(lane * WIDTH + r)


@scalar_form(_index)
def cell(lane: int, r: Any) -> Any:
    """Return the index in `w` of row r of a lane; interpreted: that of the whole lane."""
    return lane * WIDTH


def _row(w: Scratch, lane: int, r: int, n: int) -> Any:
    return w[cell(lane, r - n)]


@scalar_form(_row)
def earlier(w: Scratch, lane: int, r: slice, n: int) -> Any:
    """Return the value of a lane n rows before row r."""
    whole = w[lane * WIDTH]
    return whole[r.start - n : r.stop - n] if getattr(whole, "ndim", 0) else whole  # a constant


def _put(w: Scratch, lane: int, r: int, value: float) -> None:
    w[cell(lane, r)] = value


@scalar_form(_put)
def put(w: Scratch, lane: int, r: slice, value: Any) -> None:
    """Store a value in row r of a lane."""
    w[lane * WIDTH][r] = value


def _back(r: int, n: int) -> int:
    return r - n


@scalar_form(_back)
def before(r: slice, n: int) -> slice:
    """Return the row n rows before row r."""
    return slice(r.start - n, r.stop - n)


def _first(w: Scratch, lane: int, high: int) -> int:
    for r in range(HISTORY, high):
        if w[lane * WIDTH + r] != 0.0:
            return r
    return high


@scalar_form(_first)
def first_marked(w: Scratch, lane: int, high: int) -> int:
    """Return the first new row that is marked in a lane of new rows."""
    marks = w[lane * WIDTH]
    return HISTORY + int(np.argmax(marks)) if marks.any() else high


@stage
def copy_operand(w: Scratch, to: int, lane: int, high: int) -> None:
    """Copy a lane to the operand lane `to`."""
    for r in rows(high):
        w[cell(to, r)] = w[cell(lane, r)]


@stage
def copy_rows(w: Scratch, to: int, lane: int, first: int, high: int) -> None:
    """Copy the rows of a lane from `first` on to lane `to`."""
    for r in new_rows(first, high):
        put(w, to, r, earlier(w, lane, r, 0))


@stage
def add(w: Scratch, to: int, lane: int, high: int) -> None:
    """Add a lane to lane `to`."""
    for r in rows(high):
        w[cell(to, r)] = w[cell(to, r)] + w[cell(lane, r)]


@stage
def subtract(w: Scratch, to: int, plus: int, minus: int, high: int) -> None:
    """Set lane `to` to the difference of two lanes."""
    for r in rows(high):
        w[cell(to, r)] = w[cell(plus, r)] - w[cell(minus, r)]


@stage
def fill(w: Scratch, to: int, value: float, high: int) -> None:
    """Fill a lane with a value."""
    for r in rows(high):
        w[cell(to, r)] = value


@stage
def load_inputs(w: Scratch, at: Lanes, values: FloatArray, done: int, high: int) -> None:
    """Copy the inputs (actuators, rows) from row `done` on into their lanes, and compute their cosines and sines."""
    for a in range(len(values)):
        given = values[a, done : done + high - HISTORY]
        for r in new_rows(HISTORY, high):
            put(w, at.values + a, r, given[before(r, HISTORY)])
        copy_operand(w, A, at.values + a, high)
        for r in rows(high):
            w[CO * WIDTH + r], w[SI * WIDTH + r] = cos_sin(w[A * WIDTH + r])
        copy_rows(w, at.cos + a, CO, HISTORY, high)
        copy_rows(w, at.sin + a, SI, HISTORY, high)


@stage
def compute_vector(w: Scratch, q: Program, at: Lanes, k: int, high: int) -> None:
    """Compute vector k in lanes EX and EY."""
    head = q.vi[k]
    u, v, register, actuator = head[0], head[1], head[2], head[3]
    zr, zi = q.vz[k][0], q.vz[k][1]
    if u >= 0:
        subtract(w, BX, at.x + v, at.x + u, high)
        subtract(w, BY, at.y + v, at.y + u, high)
    elif register >= 0:
        copy_operand(w, BX, at.rx + register, high)
        copy_operand(w, BY, at.ry + register, high)
    else:
        fill(w, BX, 1.0, high)
        fill(w, BY, 0.0, high)
    if actuator >= 0:
        copy_operand(w, CO, at.cos + actuator, high)
        copy_operand(w, SI, at.sin + actuator, high)
        turn = head[4]
        for r in rows(high):
            c, s = w[CO * WIDTH + r], w[SI * WIDTH + r] * turn
            a, b = zr * c - zi * s, zr * s + zi * c
            x, y = w[BX * WIDTH + r], w[BY * WIDTH + r]
            w[EX * WIDTH + r] = a * x - b * y
            w[EY * WIDTH + r] = a * y + b * x
    else:
        for r in rows(high):
            x, y = w[BX * WIDTH + r], w[BY * WIDTH + r]
            w[EX * WIDTH + r] = zr * x - zi * y
            w[EY * WIDTH + r] = zr * y + zi * x


@stage
def compute_value(w: Scratch, at: Lanes, to: int, constant: float, gain: float, actuator: int, high: int) -> None:
    """Compute a length, constant or dependent on an input, in lane `to`."""
    if actuator >= 0:
        for r in rows(high):
            w[cell(to, r)] = constant + gain * w[cell(at.values + actuator, r)]
    else:
        fill(w, to, constant, high)


@stage
def compute_inverse(w: Scratch, at: Lanes, to: int, constant: float, gain: float, actuator: int, high: int) -> None:
    """Compute 1 / length, constant or dependent on an input, in lane `to`."""
    if actuator >= 0:
        compute_value(w, at, to, constant, gain, actuator, high)
        for r in rows(high):
            w[cell(to, r)] = 1.0 / w[cell(to, r)]
    else:
        fill(w, to, 1.0 / constant, high)


@stage
def compute_locus(w: Scratch, q: Program, at: Lanes, k: int, to: int, high: int) -> None:
    """Compute locus k in lanes from `to` on: centre and radius, or point, normal and height of a line."""
    head = q.li[k]
    node, offset, normal = head[0], head[1], head[2]
    copy_operand(w, to, at.x + node, high)
    copy_operand(w, to + 1, at.y + node, high)
    if offset >= 0:
        compute_vector(w, q, at, offset, high)
        add(w, to, EX, high)
        add(w, to + 1, EY, high)
    if normal >= 0:
        compute_vector(w, q, at, normal, high)
        copy_operand(w, to + 2, EX, high)
        copy_operand(w, to + 3, EY, high)
    compute_value(w, at, to + 2 if normal < 0 else to + 4, q.lv[k][0], q.lv[k][1], head[3], high)


@stage
def carry(w: Scratch, q: Program, at: Lanes, k: int, high: int) -> None:
    """Place a carried node (PLACE), or store a direction in its register (ORIENT)."""
    head = q.steps[k]
    compute_vector(w, q, at, head[3], high)
    if head[0] == PLACE:
        add(w, EX, at.x + head[2], high)
        add(w, EY, at.y + head[2], high)
        copy_rows(w, at.x + head[1], EX, HISTORY, high)
        copy_rows(w, at.y + head[1], EY, HISTORY, high)
    else:  # in the history too, from which reversed lines are detected
        copy_rows(w, at.rx + head[1], EX, 0, high)
        copy_rows(w, at.ry + head[1], EY, 0, high)


@kernel
def store(w: Scratch, r: Any, x: Any, y: Any, g: Any, g2: Any, noise: Any) -> None:
    """Store the result of an intersection of two loci."""
    w[X * WIDTH + r], w[Y * WIDTH + r], w[MEASURE * WIDTH + r] = x, y, g
    w[SQUARE * WIDTH + r], w[NOISE * WIDTH + r] = g2, noise


@stage
def meet_circles(w: Scratch, sign: float, high: int) -> None:
    """Intersect the circles A, B, C and D, E, F; A and B become the vector between their centres."""
    for r in rows(high):
        x, y, g, g2, noise = circle_circle(
            w[A * WIDTH + r], w[B * WIDTH + r], w[C * WIDTH + r], w[D * WIDTH + r], w[E * WIDTH + r],
            w[F * WIDTH + r], sign,
        )  # fmt: skip
        store(w, r, x, y, g, g2, noise)
    for r in rows(high):
        w[A * WIDTH + r] = w[D * WIDTH + r] - w[A * WIDTH + r]
        w[B * WIDTH + r] = w[E * WIDTH + r] - w[B * WIDTH + r]


@stage
def meet_circle_and_line(w: Scratch, sign: float, high: int) -> None:
    """Intersect the circle C, D, E and the line F ... J; A and B become the line's normal."""
    for r in rows(high):
        x, y, g, g2, noise = circle_line(
            w[C * WIDTH + r], w[D * WIDTH + r], w[E * WIDTH + r], w[F * WIDTH + r], w[G * WIDTH + r],
            w[H * WIDTH + r], w[I * WIDTH + r], w[J * WIDTH + r], sign,
        )  # fmt: skip
        store(w, r, x, y, g, g2, noise)
    for r in rows(high):
        w[A * WIDTH + r] = w[H * WIDTH + r]
        w[B * WIDTH + r] = w[I * WIDTH + r]


@stage
def meet_lines(w: Scratch, high: int) -> None:
    """Intersect the lines A ... E and F ... J; A and B become the sine of their angle and 0."""
    for r in rows(high):
        x, y, g, g2, noise = line_line(
            w[A * WIDTH + r], w[B * WIDTH + r], w[C * WIDTH + r], w[D * WIDTH + r], w[E * WIDTH + r],
            w[F * WIDTH + r], w[G * WIDTH + r], w[H * WIDTH + r], w[I * WIDTH + r], w[J * WIDTH + r],
        )  # fmt: skip
        store(w, r, x, y, g, g2, noise)
    for r in rows(high):
        w[A * WIDTH + r] = w[MEASURE * WIDTH + r]
        w[B * WIDTH + r] = 0.0


@stage
def meet(w: Scratch, q: Program, at: Lanes, k: int, sign: float, high: int) -> None:
    """Intersect the two loci of a step; lanes A and B become the direction that the sign of the branch refers to."""
    head = q.steps[k]
    kind, first, second = head[0], head[2], head[3]
    if kind == TWO_CIRCLES:
        compute_locus(w, q, at, first, A, high)
        compute_locus(w, q, at, second, D, high)
        meet_circles(w, sign, high)
    elif kind == CIRCLE_AND_LINE:
        compute_locus(w, q, at, first, C, high)
        compute_locus(w, q, at, second, F, high)
        meet_circle_and_line(w, sign, high)
    else:
        compute_locus(w, q, at, first, A, high)
        compute_locus(w, q, at, second, F, high)
        meet_lines(w, high)


@stage
def turn_line(w: Scratch, q: Program, at: Lanes, k: int, sign: float, high: int) -> None:
    """Compute the direction of a guide that passes through a node (TILT)."""
    a, b, e = q.steps[k][2], q.steps[k][3], q.reach[k]
    subtract(w, A, at.x + b, at.x + a, high)
    subtract(w, B, at.y + b, at.y + a, high)
    for r in rows(high):
        x, y, g, g2, noise = tilt(w[A * WIDTH + r], w[B * WIDTH + r], e, sign)
        store(w, r, x, y, g, g2, noise)


@stage
def place(w: Scratch, q: Program, at: Lanes, k: int, sign: FloatArray, high: int) -> bool:
    """Execute closed-form step k; return whether it may have no solution, or two."""
    kind, node, branch = q.steps[k][0], q.steps[k][1], q.steps[k][5]
    if kind in (PLACE, ORIENT):
        carry(w, q, at, k, high)
        return False
    side = sign[branch] if branch >= 0 else 1.0
    if kind == TILT:
        turn_line(w, q, at, k, side, high)
        copy_rows(w, at.rx + node, X, 0, high)  # in the history too, as in `carry`
        copy_rows(w, at.ry + node, Y, 0, high)
    else:
        meet(w, q, at, k, side, high)
        copy_rows(w, at.x + node, X, HISTORY, high)
        copy_rows(w, at.y + node, Y, HISTORY, high)
    if branch >= 0:
        copy_rows(w, at.g + branch, MEASURE, HISTORY, high)
    return True


def _next(w: Scratch, lane: int, r: int, high: int) -> float:
    return w[cell(lane, r + 1)] if r + 1 < high else 0.0


@scalar_form(_next)
def later(w: Scratch, lane: int, r: slice, high: int) -> Any:
    """Return the value of a lane of new rows one row after row r, 0 after the last one."""
    return np.append(w[lane * WIDTH][1:], 0.0)


@stage
def stay_within(w: Scratch, circles: bool, high: int) -> None:
    """Mark rows before which the loci of the last step may not have met since the row before.

    Two circles meet while the squared distance of their centres is between the squares of the difference and the sum
    of their radii, a circle and a line while g2 is positive. These quantities are smooth: three rows show how far they
    may be from the chord between two rows.
    """
    for r in rows(high):
        if circles:
            w[EX * WIDTH + r] = w[A * WIDTH + r] * w[A * WIDTH + r] + w[B * WIDTH + r] * w[B * WIDTH + r]
        else:
            w[EX * WIDTH + r] = w[SQUARE * WIDTH + r]
    for r in new_rows(HISTORY, high):
        time, last = earlier(w, TIME, r, 0), earlier(w, TIME, r, 1)
        w[cell(EY, r)] = dip(
            earlier(w, EX, r, 0), earlier(w, EX, r, 1), earlier(w, EX, r, 2),
            time - last, last - earlier(w, TIME, r, 2),
        )  # fmt: skip
    for r in new_rows(HISTORY, high):
        now, last = earlier(w, EX, r, 0), earlier(w, EX, r, 1)
        far = larger(w[cell(EY, r)], later(w, EY, r, high))
        if circles:
            one, other = earlier(w, C, r, 0), earlier(w, F, r, 0)
            least, most = (one - other) * (one - other), (one + other) * (one + other)
            w[cell(DOUBT, r)] = mark(larger(now, last) + far >= most, w[cell(DOUBT, r)])
            w[cell(DOUBT, r)] = mark(smaller(now, last) - far <= least, w[cell(DOUBT, r)])
        else:
            w[cell(DOUBT, r)] = mark(smaller(now, last) <= far, w[cell(DOUBT, r)])


@stage
def guard(w: Scratch, q: Program, at: Lanes, k: int, tolerance: float, followed: bool, high: int) -> int:
    """Return the first row in which step k has no solution, is singular, or may have jumped to another branch.

    followed: the row before the first new one is solved, so that jumps can be detected.
    """
    for r in new_rows(HISTORY, high):
        noise = earlier(w, NOISE, r, 0)
        error = intersection_error(earlier(w, MEASURE, r, 0), noise)
        put(w, ERROR, r, larger(error, earlier(w, ERROR, r, 0)))
        w[cell(DOUBT, r)] = unless((earlier(w, SQUARE, r, 0) >= -noise) & (error <= tolerance))
    branch = q.steps[k][5]
    if branch >= 0 and followed:
        copy_rows(w, MEASURE, at.g + branch, 0, HISTORY)
        for r in new_rows(HISTORY, high):
            time, last = earlier(w, TIME, r, 0), earlier(w, TIME, r, 1)
            least = LEAST_STEP * abs(time)
            leap = may_jump(
                earlier(w, MEASURE, r, 0), earlier(w, MEASURE, r, 1), earlier(w, MEASURE, r, 2),
                time - last + least, last - earlier(w, TIME, r, 2) + least,
            )  # fmt: skip
            w[cell(DOUBT, r)] = mark(leap, w[cell(DOUBT, r)])
        if tolerance < math.inf:
            stay_within(w, q.steps[k][0] == TWO_CIRCLES, high)
    if q.steps[k][0] != TILT:
        for r in new_rows(HISTORY, high):
            along = earlier(w, A, r, 0) * earlier(w, A, r, 1) + earlier(w, B, r, 0) * earlier(w, B, r, 1)
            w[cell(DOUBT, r)] = mark(along < 0.0, w[cell(DOUBT, r)])
    return first_marked(w, DOUBT, high)


@stage
def check_angle(w: Scratch, high: int) -> None:
    """Compute, in lane X, the angles between the vectors A, B and EX, EY."""
    for r in rows(high):
        w[X * WIDTH + r] = angle_error(w[A * WIDTH + r], w[B * WIDTH + r], w[EX * WIDTH + r], w[EY * WIDTH + r])


@stage
def check_span(w: Scratch, high: int) -> None:
    """Compute, in lane X, the errors of the length of the vector A, B; C is 1 / length."""
    for r in rows(high):
        w[X * WIDTH + r] = span_error(w[A * WIDTH + r], w[B * WIDTH + r], w[C * WIDTH + r])


@stage
def check_height(w: Scratch, size: float, high: int) -> None:
    """Compute, in lane X, the errors of the height C of A, B along the normal EX, EY."""
    for r in rows(high):
        w[X * WIDTH + r] = height_error(
            w[EX * WIDTH + r], w[EY * WIDTH + r], w[A * WIDTH + r], w[B * WIDTH + r], w[C * WIDTH + r], size
        )  # fmt: skip


@stage
def check(w: Scratch, q: Program, at: Lanes, high: int) -> None:
    """Compute, in lane WORST, the greatest error of all constraints in `Program.ci`, independently of the steps."""
    fill(w, WORST, 0.0, high)
    for k in range(len(q.ci)):
        head, value = q.ci[k], q.cv[k]
        kind, p, o = head[0], head[1], head[2]
        if kind == ANGLE:
            compute_vector(w, q, at, head[3], high)
            copy_operand(w, A, EX, high)
            copy_operand(w, B, EY, high)
            compute_vector(w, q, at, head[4], high)
            check_angle(w, high)
        else:
            if o >= 0:
                subtract(w, A, at.x + p, at.x + o, high)
                subtract(w, B, at.y + p, at.y + o, high)
            else:
                copy_operand(w, A, at.x + p, high)
                copy_operand(w, B, at.y + p, high)
            if kind == SPAN:
                compute_inverse(w, at, C, value[0], value[1], head[5], high)
                check_span(w, high)
            else:
                compute_value(w, at, C, value[0], value[1], head[5], high)
                compute_vector(w, q, at, head[3], high)
                check_height(w, q.size, high)
        for r in rows(high):
            error, worst = w[X * WIDTH + r], w[WORST * WIDTH + r]
            w[WORST * WIDTH + r] = where(error <= worst, worst, where(error <= math.inf, error, math.inf))
