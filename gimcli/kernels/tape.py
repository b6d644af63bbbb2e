"""A tape: a list of operations on lanes without branches, recorded once for a plan and executed for blocks of rows.

Operands are lanes: a, b, c complex (two lanes), p, q real; z = f + i g is a constant. Each operation fills its own
lane; the ADD_ operations add to it. Lane GOOD is 0, or NaN in rows that have no position or are singular.

Source of the term: Griewank & Walther, Evaluating Derivatives, 2008, chapter 4.
"""

from __future__ import annotations

import numpy as np

from gimcli.kernels.choice import where
from gimcli.kernels.circular import cos_sin
from gimcli.kernels.equilibrium import combine, eliminate, quotient, resolve
from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.lanes import ROWS, add_product, fill, imaginary, multiply, pair, real, rows
from gimcli.kernels.reflections import factor_rows, inverse_square, normalise, solve_rows
from gimcli.mechanism import FloatArray, IntArray

(
    SCALE,  # z a
    LINEAR,  # a + z b
    CARRY,  # a + z (b - c)
    TIMES,  # f a b
    ADD_TIMES,  # add f a b
    CONJUGATE,  # f conj(a) b
    ADD_CONJUGATE,
    DOT,  # f a.b, real
    ADD_DOT,
    PRODUCT,  # f p q
    ADD_PRODUCT,
    AFFINE,  # f + g p
    TURN,  # f i p b
    ADD_TURN,
    COS_SIN,  # exp(i p)
    UNIT,  # a / |a|
    INVERSE,  # 1 / |a|^2
    ACROSS,  # (a x b) p
    DETERMINANT,  # 1 / (a x b); NaN if a and b are nearly parallel
    MEET,  # r with a.r = -p, b.r = -q
    NODE,  # position of a node
    VALUE,  # an input
    FACTOR,  # factor the Jacobian of a group
    SOLVE,  # solve the equations of a group
    WRITE_POINT,  # write a to the results
    WRITE_ANGLE,  # write p to the results
    COMBINE,  # f p + g q
    QUOTIENT,  # f p / q
    ROOT,  # square root of p
    PHASE,  # the angle of a
    FOLLOW,  # p with full turns so that it has no jumps from row to row, from f on
    ELIMINATE,  # solve the equations of a block
    RESOLVE,  # solve them for another right side
    ADD_ACROSS,
) = range(34)

GOOD, SPARE, LANES = range(3)
"""Lanes with fixed numbers, and their number."""

SINGULAR = 1e-8
"""Ratio of least to greatest singular value, for gradients of length 1, below which velocities are not determined."""


@stage
def scale(w: FloatArray, to: int, a: int, f: float, g: float, high: int) -> None:
    """Fill with z a."""
    t, s = w[pair(to)], w[pair(a)]
    for r in rows(high):
        i = imaginary(r)
        t[r] = f * s[r] - g * s[i]
        t[i] = f * s[i] + g * s[r]


@stage
def linear(w: FloatArray, to: int, a: int, b: int, f: float, g: float, high: int) -> None:
    """Fill with a + z b."""
    t, s, u = w[pair(to)], w[pair(a)], w[pair(b)]
    for r in rows(high):
        i = imaginary(r)
        t[r] = s[r] + (f * u[r] - g * u[i])
        t[i] = s[i] + (f * u[i] + g * u[r])


@stage
def carry(w: FloatArray, to: int, a: int, b: int, c: int, f: float, g: float, high: int) -> None:
    """Fill with a + z (b - c)."""
    t, s, u, v = w[pair(to)], w[pair(a)], w[pair(b)], w[pair(c)]
    for r in rows(high):
        i = imaginary(r)
        x, y = u[r] - v[r], u[i] - v[i]
        t[r] = s[r] + (f * x - g * y)
        t[i] = s[i] + (f * y + g * x)


@stage
def times(w: FloatArray, to: int, a: int, b: int, f: float, turn: float, high: int) -> None:
    """Add f a b, or f conj(a) b if `turn` is -1."""
    t, s, u = w[pair(to)], w[pair(a)], w[pair(b)]
    for r in rows(high):
        i = imaginary(r)
        x, y = f * s[r], f * turn * s[i]
        t[r] += x * u[r] - y * u[i]
        t[i] += x * u[i] + y * u[r]


@stage
def add_dot(w: FloatArray, to: int, a: int, b: int, f: float, high: int) -> None:
    """Add f a.b."""
    t, s, u = w[real(to)], w[pair(a)], w[pair(b)]
    for r in rows(high):
        i = imaginary(r)
        t[r] += f * (s[r] * u[r] + s[i] * u[i])


@stage
def affine(w: FloatArray, to: int, p: int, f: float, g: float, high: int) -> None:
    """Fill with f + g p."""
    t, s = w[real(to)], w[real(p)]
    for r in rows(high):
        t[r] = f + g * s[r]


@stage
def turn(w: FloatArray, to: int, p: int, b: int, f: float, high: int) -> None:
    """Add f i p b."""
    t, s, u = w[pair(to)], w[real(p)], w[pair(b)]
    for r in rows(high):
        i = imaginary(r)
        x = f * s[r]
        t[r] -= x * u[i]
        t[i] += x * u[r]


@stage
def circle(w: FloatArray, to: int, p: int, high: int) -> None:
    """Fill with exp(i p)."""
    t, s = w[pair(to)], w[real(p)]
    for r in rows(high):
        t[r], t[imaginary(r)] = cos_sin(s[r])


@stage
def unit(w: FloatArray, to: int, a: int, high: int) -> None:
    """Fill with a / |a|."""
    t, s = w[pair(to)], w[pair(a)]
    for r in rows(high):
        i = imaginary(r)
        x = 1.0 / np.sqrt(s[r] * s[r] + s[i] * s[i])
        t[r] = x * s[r]
        t[i] = x * s[i]


@stage
def inverse(w: FloatArray, to: int, a: int, high: int) -> None:
    """Fill with 1 / |a|^2."""
    t, s = w[real(to)], w[pair(a)]
    for r in rows(high):
        i = imaginary(r)
        t[r] = 1.0 / (s[r] * s[r] + s[i] * s[i])


@stage
def across(w: FloatArray, to: int, a: int, b: int, p: int, high: int) -> None:
    """Add (a x b) p."""
    t, s, u, v = w[real(to)], w[pair(a)], w[pair(b)], w[real(p)]
    for r in rows(high):
        i = imaginary(r)
        t[r] += (s[r] * u[i] - s[i] * u[r]) * v[r]


@stage
def determinant(w: FloatArray, to: int, a: int, b: int, high: int) -> None:
    """Fill with 1 / (a x b), and with NaN (also in GOOD) where a and b are nearly parallel.

    For two unit vectors at a small angle, the ratio of least to greatest singular value is half the angle.
    """
    t, s, u, good = w[real(to)], w[pair(a)], w[pair(b)], w[real(GOOD)]
    least = 4.0 * SINGULAR * SINGULAR
    for r in rows(high):
        i = imaginary(r)
        det = s[r] * u[i] - s[i] * u[r]
        square = (s[r] * s[r] + s[i] * s[i]) * (u[r] * u[r] + u[i] * u[i])
        t[r] = where(det * det > least * square, 1.0 / det, np.nan)
        good[r] += 0.0 * t[r]


@stage
def meet(w: FloatArray, to: int, a: int, b: int, p: int, det: int, high: int) -> None:
    """Fill with r so that a.r = -p and b.r = -q; q is the lane after p, lane `det` is 1 / (a x b)."""
    t, s, u, v, d = w[pair(to)], w[pair(a)], w[pair(b)], w[pair(p)], w[real(det)]
    for r in rows(high):
        i = imaginary(r)
        t[r] = (v[i] * s[i] - v[r] * u[i]) * d[r]
        t[i] = (v[r] * u[r] - v[i] * s[r]) * d[r]


@stage
def read_node(w: FloatArray, to: int, z: FloatArray, high: int) -> None:
    """Fill with positions (rows, 2)."""
    t, good = w[pair(to)], w[real(GOOD)]
    for r in rows(high):
        t[r] = z[r, 0]
        t[imaginary(r)] = z[r, 1]
    for r in rows(high):
        good[r] += 0.0 * (t[r] + t[imaginary(r)])


@stage
def read_value(w: FloatArray, to: int, value: FloatArray, high: int) -> None:
    """Fill with an input (rows,)."""
    t = w[real(to)]
    for r in rows(high):
        t[r] = value[r]


@stage
def factor(w: FloatArray, a: int, scales: int, d: int, m: int, n: int, high: int) -> None:
    """Factor the m by n Jacobian of a group, with rows scaled to length 1; lane GOOD is NaN where it is singular.

    By Frobenius norms, the greatest singular value is at most sqrt(m), and 1 / least at most the norm of inverse R.
    """
    normalise(w, a, scales, m, n, high)
    factor_rows(w, a, d, m, n, SPARE, high)
    inverse_square(w, a, d, n, SPARE, high)
    t, good = w[real(SPARE)], w[real(GOOD)]
    most = 1.0 / (SINGULAR * SINGULAR * m)
    for r in rows(high):
        good[r] += where(t[r] < most, 0.0, np.nan)


@stage
def solve(w: FloatArray, b: int, a: int, scales: int, d: int, m: int, n: int, high: int) -> None:
    """Solve the equations of a group with right-hand sides b."""
    for k in range(m):
        multiply(w, b + k, scales + k, high)
    solve_rows(w, a, d, m, n, b, SPARE, high)


@stage
def write_point(w: FloatArray, a: int, out: FloatArray, high: int) -> None:
    """Copy a complex lane to `out` (rows, 2)."""
    s, good = w[pair(a)], w[real(GOOD)]
    for r in rows(high):
        out[r, 0] = s[r] + good[r]
        out[r, 1] = s[imaginary(r)] + good[r]


@stage
def write_angle(w: FloatArray, p: int, out: FloatArray, high: int) -> None:
    """Copy a real lane to `out` (rows,)."""
    s, good = w[real(p)], w[real(GOOD)]
    for r in rows(high):
        out[r] = s[r] + good[r]


@stage
def root(w: FloatArray, to: int, p: int, high: int) -> None:
    """Fill with the square root of p."""
    t, s = w[real(to)], w[real(p)]
    for r in rows(high):
        t[r] = np.sqrt(s[r])


@stage
def phase(w: FloatArray, to: int, a: int, high: int) -> None:
    """Fill with the angle of a."""
    t, s = w[real(to)], w[pair(a)]
    for r in rows(high):
        t[r] = np.arctan2(s[imaginary(r)], s[r])


@stage
def follow(w: FloatArray, to: int, p: int, start: float, begins: bool, high: int) -> None:
    """Fill with p and full turns, each within half a turn of the one before; of the first block's first, of `start`.

    The last one is kept behind the rows.
    """
    t, s = w[real(to)], w[real(p)]
    if begins:
        t[ROWS] = start
    for r in range(high):
        t[r] = s[r] + 2.0 * np.pi * np.rint((t[ROWS] - s[r]) / (2.0 * np.pi))
        if np.isfinite(t[r]):
            t[ROWS] = t[r]


@kernel
def clear(w: FloatArray, to: int, high: int) -> None:
    """Fill two lanes with 0."""
    fill(w, to, 0.0, high)
    fill(w, to + 1, 0.0, high)


@stage
def multiply_lanes(w: FloatArray, head: IntArray, f: float, g: float, high: int) -> None:
    """Run an operation that multiplies complex numbers, or a real and a complex one."""
    op, to, a, b = head[0], head[1], head[2], head[3]
    if op in (TIMES, CONJUGATE, TURN):
        clear(w, to, high)
    if op in (TURN, ADD_TURN):
        turn(w, to, a, b, f, high)
    else:
        times(w, to, a, b, f, 1.0 if op in (TIMES, ADD_TIMES) else -1.0, high)


@stage
def make_real(w: FloatArray, head: IntArray, f: float, g: float, high: int) -> None:
    """Run an operation that gives a real number."""
    op, to, a, b, c = head[0], head[1], head[2], head[3], head[4]
    if op in (DOT, ACROSS, PRODUCT):
        fill(w, to, 0.0, high)
    if op in (DOT, ADD_DOT):
        add_dot(w, to, a, b, f, high)
    elif op == AFFINE:
        affine(w, to, a, f, g, high)
    elif op in (ACROSS, ADD_ACROSS):
        across(w, to, a, b, c, high)
    elif op == INVERSE:
        inverse(w, to, a, high)
    elif op == DETERMINANT:
        determinant(w, to, a, b, high)
    else:
        add_product(w, to, a, b, f, high)


@stage
def make_complex(w: FloatArray, head: IntArray, f: float, g: float, high: int) -> None:
    """Run any other operation that gives a complex number, or several."""
    op, to, a, b, c, d = head[0], head[1], head[2], head[3], head[4], head[5]
    if op == LINEAR:
        linear(w, to, a, b, f, g, high)
    elif op == SCALE:
        scale(w, to, a, f, g, high)
    elif op == CARRY:
        carry(w, to, a, b, c, f, g, high)
    elif op == MEET:
        meet(w, to, a, b, c, d, high)
    elif op == COS_SIN:
        circle(w, to, a, high)
    elif op == UNIT:
        unit(w, to, a, high)
    elif op == FACTOR:
        factor(w, to, a, b, c, d, high)
    else:
        solve(w, to, a, b, c, int(f), int(g), high)


@stage
def make_force(w: FloatArray, head: IntArray, f: float, g: float, begins: bool, high: int) -> None:
    """Run an operation of the formulas of forces."""
    op, to, a, b, c = head[0], head[1], head[2], head[3], head[4]
    if op == COMBINE:
        combine(w, to, a, b, f, g, high)
    elif op == QUOTIENT:
        quotient(w, to, a, b, f, high)
    elif op == ROOT:
        root(w, to, a, high)
    elif op == PHASE:
        phase(w, to, a, high)
    elif op == FOLLOW:
        follow(w, to, a, f, begins, high)
    elif op == RESOLVE:
        resolve(w, to, a, int(f), b, high)
    else:
        eliminate(w, to, a, int(f), b, c, high)


@stage
def play(
    w: FloatArray, heads: IntArray, factors: FloatArray, z: FloatArray, given: FloatArray, points: FloatArray,
    angles: FloatArray,
) -> None:  # fmt: skip
    """Execute a tape for all rows.

    z (nodes, rows, 2): positions. given (slots, actuators, rows): inputs and their derivatives. Results: points (slots,
    points, rows, 2) and angles (slots, members, rows). w: the lanes; constants are already in it.
    """
    done, end = 0, z.shape[1]
    while done < end:
        high = min(ROWS, end - done)
        fill(w, GOOD, 0.0, high)
        for k in range(heads.shape[0]):
            head = heads[k]
            op, to, a, b = head[0], head[1], head[2], head[3]
            f, g = factors[k, 0], factors[k, 1]
            if op in (TIMES, ADD_TIMES, CONJUGATE, ADD_CONJUGATE, TURN, ADD_TURN):
                multiply_lanes(w, head, f, g, high)
            elif op in (DOT, ADD_DOT, PRODUCT, ADD_PRODUCT, AFFINE, ACROSS, ADD_ACROSS, INVERSE, DETERMINANT):
                make_real(w, head, f, g, high)
            elif op == NODE:
                read_node(w, to, z[a, done : done + high], high)
            elif op == VALUE:
                read_value(w, to, given[a, b, done : done + high], high)
            elif op == WRITE_POINT:
                write_point(w, to, points[a, b, done : done + high], high)
            elif op == WRITE_ANGLE:
                write_angle(w, to, angles[a, b, done : done + high], high)
            elif op >= COMBINE:
                make_force(w, head, f, g, done == 0, high)
            else:
                make_complex(w, head, f, g, high)
        done += high


@stage
def play_designs(
    w: FloatArray, heads: IntArray, first: int, constants: FloatArray, factors: FloatArray, z: FloatArray,
    given: FloatArray, points: FloatArray, angles: FloatArray,
) -> None:  # fmt: skip
    """Execute a tape for all rows of many designs.

    constants (designs, lanes): numbers of the lanes from `first` on. factors (designs, operations, 2). z, points and
    angles are those of `play` with a leading axis of designs, given (designs or 1, slots, actuators, rows).
    """
    for n in range(z.shape[0]):
        for k in range(constants.shape[1]):
            fill(w, first + k, constants[n, k], min(ROWS, z.shape[2]))
        play(w, heads, factors[n], z[n], given[n % given.shape[0]], points[n], angles[n])
