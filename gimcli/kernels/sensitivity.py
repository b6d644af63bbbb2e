"""Derivatives of solved positions by the dimensions of a mechanism, for many designs, rows and dimensions in one call.

The steps of a plan are differentiated one after another (implicit function theorem). A step whose equations are
Phi(q, d) = 0, in its own unknowns q and in the nodes and numbers d that are known before it, gives

    Phi_q q' = -Phi_d d'

with one right-hand side for each dimension; the factors of Phi_q are computed once for a row. A derivative that is
zero in all rows is not computed: the lanes of nodes that do not depend on a dimension are replaced by zeros.
Source: Griewank & Walther, Evaluating Derivatives, 2008, chapter 13.
"""

from __future__ import annotations

from typing import NamedTuple

from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.lanes import ROWS, fill, imaginary, pair, real, rows
from gimcli.kernels.plan_steps import COUPLED, ORIENT, PLACE, TILT
from gimcli.kernels.tape import (
    GOOD,
    affine,
    carry,
    circle,
    clear,
    determinant,
    dot,
    factor,
    linear,
    meet,
    read_node,
    read_value,
    scale,
    solve,
    times,
    unit,
    write_angle,
    write_point,
)
from gimcli.mechanism import CLOSURE, SPAN, FloatArray, IntArray

ZERO = 2
ONE = 4
RATE = 6
ARM = 8
SCRATCH = 10
LENGTH = 12
SENSITIVITY_LANES = 14
"""Number of lanes with fixed numbers; GOOD and one spare lane are those of the tape."""


class SensitivityLanes(NamedTuple):
    """Number of the first lane of each kind."""

    place: int  # pairs of the nodes, then of the registers
    rate: int  # the same, their derivatives by one dimension
    turn: int  # pairs exp(i input) of the actuators
    value: int  # inputs
    base: int  # pairs of the vectors: value without the constant factor z
    vector: int  # pairs of the vectors
    arm: int  # pairs of the loci, then of the equations: p - q
    determinant: int  # of the steps
    right: int  # right-hand sides


class Structure(NamedTuple):
    """The steps of a plan and of its coupled groups; nodes, vectors and values are numbered over all groups."""

    nodes: int
    frame: IntArray  # (frame nodes,)
    steps: IntArray  # (steps, 6) as in `Program`
    vi: IntArray  # (vectors, 5) u, v, register, actuator, turn
    li: IntArray  # (loci, 4) node, offset, normal, actuator
    gi: IntArray  # (groups, 11) first and end of bases, places, equations; rows; lanes: gains, factors, scales, scratch
    bases: IntArray
    pi: IntArray  # (places, 3) node, anchor, vector
    ei: IntArray  # (equations, 5) kind, p, q, vector, actuator


class Numbers(NamedTuple):
    """What the dimensions of one design determine: factors of vectors, constants and gains of lengths."""

    vz: FloatArray  # (vectors, 2)
    lv: FloatArray  # (loci + equations, 2)


class Tangents(NamedTuple):
    """Derivatives of the numbers of one design by one dimension."""

    vz: FloatArray  # (vectors, 2)
    lv: FloatArray  # (loci + equations, 2)
    reach: FloatArray  # (steps,)
    frame: FloatArray  # (nodes, 2)
    inputs: FloatArray  # (actuators,)


# -- operations on lanes -----------------------------------------------------------------------------------


@stage
def add_dot(w: FloatArray, to: int, a: int, b: int, high: int) -> None:
    """Add a.b."""
    t, s, u = w[real(to)], w[pair(a)], w[pair(b)]
    for r in rows(high):
        i = imaginary(r)
        t[r] += s[r] * u[r] + s[i] * u[i]


@stage
def add_scaled(w: FloatArray, to: int, a: int, f: float, g: float, high: int) -> None:
    """Add z a."""
    t, s = w[pair(to)], w[pair(a)]
    for r in rows(high):
        i = imaginary(r)
        t[r] += f * s[r] - g * s[i]
        t[i] += f * s[i] + g * s[r]


@stage
def shift(w: FloatArray, to: int, value: float, high: int) -> None:
    """Add a constant."""
    t = w[real(to)]
    for r in rows(high):
        t[r] += value


@stage
def subtract_dot(w: FloatArray, to: int, a: int, b: int, high: int) -> None:
    """Subtract a.b."""
    t, s, u = w[real(to)], w[pair(a)], w[pair(b)]
    for r in rows(high):
        i = imaginary(r)
        t[r] -= s[r] * u[r] + s[i] * u[i]


@stage
def subtract_product(w: FloatArray, to: int, p: int, q: int, high: int) -> None:
    """Subtract p q."""
    t, s, u = w[real(to)], w[real(p)], w[real(q)]
    for r in rows(high):
        t[r] -= s[r] * u[r]


# -- values of a row ---------------------------------------------------------------------------------------


@stage
def read_inputs(w: FloatArray, at: SensitivityLanes, inputs: FloatArray, done: int, high: int) -> None:
    """Fill the lanes of the inputs, and exp(i input)."""
    for a in range(inputs.shape[0]):
        read_value(w, at.value + a, inputs[a, done : done + high], high)
        circle(w, at.turn + 2 * a, at.value + a, high)


@stage
def turned_by(w: FloatArray, s: Structure, at: SensitivityLanes, k: int, to: int, high: int) -> None:
    """Rotate the pair `to` by the actuator of vector k."""
    actuator = s.vi[k, 3]
    if actuator >= 0:
        scale(w, SCRATCH, to, 1.0, 0.0, high)
        clear(w, to, high)
        times(w, to, at.turn + 2 * actuator, SCRATCH, 1.0, 1.0 * s.vi[k, 4], high)


@stage
def compute_vector(w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, k: int, high: int) -> int:
    """Compute vector k; return its pair."""
    to, u, register = at.base + 2 * k, s.vi[k, 0], s.vi[k, 2]
    if u >= 0:
        linear(w, to, at.place + 2 * s.vi[k, 1], at.place + 2 * u, -1.0, 0.0, high)
    else:
        scale(w, to, at.place + 2 * (s.nodes + register) if register >= 0 else ONE, 1.0, 0.0, high)
    turned_by(w, s, at, k, to, high)
    scale(w, at.vector + 2 * k, to, q.vz[k, 0], q.vz[k, 1], high)
    return at.vector + 2 * k


@stage
def prepare_locus(w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, node: int, k: int, high: int) -> int:
    """Compute the arm p - q of locus k of a node; return the pair of its gradient."""
    arm, offset, normal = at.arm + 2 * k, s.li[k, 1], s.li[k, 2]
    linear(w, arm, at.place + 2 * node, at.place + 2 * s.li[k, 0], -1.0, 0.0, high)
    if offset >= 0:
        add_scaled(w, arm, compute_vector(w, s, at, q, offset, high), -1.0, 0.0, high)
    return compute_vector(w, s, at, q, normal, high) if normal >= 0 else arm


@stage
def prepare_tilt(w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, k: int, high: int) -> None:
    """Compute the direction u of a guide that passes through a node, and 1 / tau in the lane of the determinant."""
    register = at.place + 2 * (s.nodes + s.steps[k, 1])
    unit(w, register, compute_vector(w, s, at, q, s.steps[k, 4], high), high)
    linear(w, RATE, at.place + 2 * s.steps[k, 3], at.place + 2 * s.steps[k, 2], -1.0, 0.0, high)
    scale(w, ARM, register, 0.0, 1.0, high)
    determinant(w, at.determinant + k, RATE, ARM, high)  # (B - A) x i u = (B - A).u


@stage
def prepare(w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, high: int) -> None:
    """Compute the vectors of all steps and the factors of their gradients."""
    loci = s.li.shape[0]
    for k in range(s.steps.shape[0]):
        kind = s.steps[k, 0]
        if kind == PLACE:
            compute_vector(w, s, at, q, s.steps[k, 3], high)
        elif kind == ORIENT:
            found = compute_vector(w, s, at, q, s.steps[k, 3], high)
            scale(w, at.place + 2 * (s.nodes + s.steps[k, 1]), found, 1.0, 0.0, high)
        elif kind == TILT:
            prepare_tilt(w, s, at, q, k, high)
        elif kind == COUPLED:
            prepare_group(w, s, at, q, s.steps[k, 2], loci, high)
        else:
            first = prepare_locus(w, s, at, q, s.steps[k, 1], s.steps[k, 2], high)
            second = prepare_locus(w, s, at, q, s.steps[k, 1], s.steps[k, 3], high)
            determinant(w, at.determinant + k, first, second, high)


# -- coupled groups: values --------------------------------------------------------------------------------


@kernel
def gain_lane(s: Structure, g: int, node: int, b: int) -> int:
    """Return the pair of the complex factor by which a node of group g changes with base node number b."""
    first, end = s.gi[g, 0], s.gi[g, 1]
    for k in range(first, end):
        if s.bases[k] == node:
            return ONE if k - first == b else ZERO
    for k in range(s.gi[g, 2], s.gi[g, 3]):
        if s.pi[k, 0] == node:
            return s.gi[g, 7] + 2 * ((k - s.gi[g, 2]) * (end - first) + b)
    return ZERO


@stage
def vector_gain(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, g: int, k: int, b: int, to: int, high: int
) -> None:
    """Fill a pair with the complex factor by which vector k changes with base node number b."""
    if s.vi[k, 0] < 0:
        clear(w, to, high)
        return
    linear(w, RATE, gain_lane(s, g, s.vi[k, 1], b), gain_lane(s, g, s.vi[k, 0], b), -1.0, 0.0, high)
    turned_by(w, s, at, k, RATE, high)
    scale(w, to, RATE, q.vz[k, 0], q.vz[k, 1], high)


@stage
def put_gradient(w: FloatArray, lane: int, a: int, b: int, high: int) -> None:
    """Add conj(a) b, as two real numbers, to two lanes."""
    times(w, lane, a, b, 1.0, -1.0, high)


@stage
def equation_gradients(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, g: int, k: int, arm: int, row: int, high: int
) -> None:  # fmt: skip
    """Fill the gradients of equation k, one row of the matrix from lane `row` on (two for a closure)."""
    kind, vector = s.ei[k, 0], s.ei[k, 3]
    count = s.gi[g, 1] - s.gi[g, 0]
    for b in range(count):
        linear(w, LENGTH, gain_lane(s, g, s.ei[k, 1], b), gain_lane(s, g, s.ei[k, 2], b), -1.0, 0.0, high)
        to = row + 2 * b
        clear(w, to, high)
        if kind == SPAN:
            put_gradient(w, to, LENGTH, arm, high)
            continue
        vector_gain(w, s, at, q, g, vector, b, ARM, high)
        if kind == CLOSURE:
            linear(w, RATE, LENGTH, ARM, -1.0, 0.0, high)
            put_gradient(w, to, RATE, ONE, high)
            clear(w, to + 2 * count, high)
            scale(w, SCRATCH, ONE, 0.0, 1.0, high)
            put_gradient(w, to + 2 * count, RATE, SCRATCH, high)
        else:
            put_gradient(w, to, LENGTH, at.vector + 2 * vector, high)
            put_gradient(w, to, ARM, arm, high)


@stage
def prepare_group(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, g: int, loci: int, high: int
) -> None:  # fmt: skip
    """Compute the vectors of a coupled group, and fill and factor its Jacobian."""
    count = s.gi[g, 1] - s.gi[g, 0]
    for k in range(s.gi[g, 2], s.gi[g, 3]):
        compute_vector(w, s, at, q, s.pi[k, 2], high)
        for b in range(count):
            vector_gain(w, s, at, q, g, s.pi[k, 2], b, ARM, high)
            to = gain_lane(s, g, s.pi[k, 0], b)
            linear(w, to, ARM, gain_lane(s, g, s.pi[k, 1], b), 1.0, 0.0, high)
    row = s.gi[g, 8]
    for k in range(s.gi[g, 4], s.gi[g, 5]):
        arm = at.arm + 2 * (loci + k)
        linear(w, arm, at.place + 2 * s.ei[k, 1], at.place + 2 * s.ei[k, 2], -1.0, 0.0, high)
        if s.ei[k, 3] >= 0:
            compute_vector(w, s, at, q, s.ei[k, 3], high)
        equation_gradients(w, s, at, q, g, k, arm, row, high)
        row += (4 if s.ei[k, 0] == CLOSURE else 2) * count
    factor(w, s.gi[g, 8], s.gi[g, 9], s.gi[g, 10], s.gi[g, 6], 2 * count, high)


# -- derivatives by one dimension --------------------------------------------------------------------------


@kernel
def rate_lane(at: SensitivityLanes, live: IntArray, n: int) -> int:
    """Return the pair of the derivative of node (or nodes + register) n."""
    return at.rate + 2 * n if live[n] != 0 else ZERO


@kernel
def vector_moves(s: Structure, live: IntArray, d: Tangents, k: int) -> bool:
    """Return whether vector k depends on the dimension."""
    u, register, actuator = s.vi[k, 0], s.vi[k, 2], s.vi[k, 3]
    moves = d.vz[k, 0] != 0.0 or d.vz[k, 1] != 0.0
    if u >= 0:
        moves = moves or live[u] != 0 or live[s.vi[k, 1]] != 0
    elif register >= 0:
        moves = moves or live[s.nodes + register] != 0
    return moves or (actuator >= 0 and d.inputs[actuator] != 0.0)


@stage
def vector_rate(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, d: Tangents, live: IntArray, k: int, to: int,
    high: int,
) -> None:  # fmt: skip
    """Compute the derivative of vector k: z' b + z b' + i turn theta' z b, with its base b."""
    u, register, actuator = s.vi[k, 0], s.vi[k, 2], s.vi[k, 3]
    v = s.vi[k, 1]
    if u >= 0 and (live[u] != 0 or live[v] != 0):
        linear(w, RATE, rate_lane(at, live, v), rate_lane(at, live, u), -1.0, 0.0, high)
        turned_by(w, s, at, k, RATE, high)
        scale(w, to, RATE, q.vz[k, 0], q.vz[k, 1], high)
    elif u < 0 and register >= 0 and live[s.nodes + register] != 0:
        scale(w, RATE, rate_lane(at, live, s.nodes + register), 1.0, 0.0, high)
        turned_by(w, s, at, k, RATE, high)
        scale(w, to, RATE, q.vz[k, 0], q.vz[k, 1], high)
    else:
        clear(w, to, high)
    if d.vz[k, 0] != 0.0 or d.vz[k, 1] != 0.0:
        add_scaled(w, to, at.base + 2 * k, d.vz[k, 0], d.vz[k, 1], high)
    if actuator >= 0 and d.inputs[actuator] != 0.0:
        add_scaled(w, to, at.vector + 2 * k, 0.0, s.vi[k, 4] * d.inputs[actuator], high)


@stage
def carry_rate(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, d: Tangents, live: IntArray, node: int,
    anchor: int, k: int, high: int,
) -> None:  # fmt: skip
    """Compute the derivative of a node: that of its anchor plus that of vector k."""
    if not (live[anchor] != 0 or vector_moves(s, live, d, k)):
        return
    to, u, v = at.rate + 2 * node, s.vi[k, 0], s.vi[k, 1]
    live[node] = 1
    if u >= 0 and s.vi[k, 3] < 0:
        carry(
            w, to, rate_lane(at, live, anchor), rate_lane(at, live, v), rate_lane(at, live, u), q.vz[k, 0], q.vz[k, 1],
            high,
        )  # fmt: skip
        if d.vz[k, 0] != 0.0 or d.vz[k, 1] != 0.0:
            add_scaled(w, to, at.base + 2 * k, d.vz[k, 0], d.vz[k, 1], high)
    else:
        vector_rate(w, s, at, q, d, live, k, ARM, high)
        linear(w, to, rate_lane(at, live, anchor), ARM, 1.0, 0.0, high)


@stage
def subtract_length(
    w: FloatArray, at: SensitivityLanes, q: Numbers, d: Tangents, to: int, n: int, actuator: int, squared: bool,
    high: int,
) -> None:  # fmt: skip
    """Subtract the derivative of length n, or of half its square."""
    change, gain = d.lv[n, 0], 0.0
    if actuator >= 0:
        change += q.lv[n, 1] * d.inputs[actuator]
        gain = d.lv[n, 1]
    if change == 0.0 and gain == 0.0:
        return
    if actuator < 0:
        shift(w, to, -change * (q.lv[n, 0] if squared else 1.0), high)
        return
    affine(w, LENGTH, at.value + actuator, change, gain, high)
    if squared:
        affine(w, SCRATCH, at.value + actuator, q.lv[n, 0], q.lv[n, 1], high)
    else:
        fill(w, SCRATCH, 1.0, high)
    subtract_product(w, to, LENGTH, SCRATCH, high)


@stage
def locus_rate(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, d: Tangents, live: IntArray, k: int, to: int,
    high: int,
) -> bool:  # fmt: skip
    """Fill a lane with Phi_d d' of locus k; return whether it can differ from 0."""
    node, offset, normal, actuator = s.li[k, 0], s.li[k, 1], s.li[k, 2], s.li[k, 3]
    shifts, turns = offset >= 0 and vector_moves(s, live, d, offset), normal >= 0 and vector_moves(s, live, d, normal)
    longer = d.lv[k, 0] != 0.0 or (actuator >= 0 and (d.lv[k, 1] != 0.0 or d.inputs[actuator] != 0.0))
    gradient = at.vector + 2 * normal if normal >= 0 else at.arm + 2 * k
    if live[node] != 0:
        dot(w, to, gradient, rate_lane(at, live, node), -1.0, high)
    else:
        fill(w, to, 0.0, high)
    if shifts:
        vector_rate(w, s, at, q, d, live, offset, ARM, high)
        subtract_dot(w, to, gradient, ARM, high)
    if turns:
        vector_rate(w, s, at, q, d, live, normal, ARM, high)
        add_dot(w, to, at.arm + 2 * k, ARM, high)
    if longer:
        subtract_length(w, at, q, d, to, k, actuator, normal < 0, high)
    return live[node] != 0 or shifts or turns or longer


@stage
def dyad_rate(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, d: Tangents, live: IntArray, k: int, high: int
) -> None:  # fmt: skip
    """Compute the derivative of a node on two loci."""
    node, first, second = s.steps[k, 1], s.steps[k, 2], s.steps[k, 3]
    moves = locus_rate(w, s, at, q, d, live, first, at.right, high)
    moves = locus_rate(w, s, at, q, d, live, second, at.right + 1, high) or moves
    if moves:
        live[node] = 1
        one = at.vector + 2 * s.li[first, 2] if s.li[first, 2] >= 0 else at.arm + 2 * first
        other = at.vector + 2 * s.li[second, 2] if s.li[second, 2] >= 0 else at.arm + 2 * second
        meet(w, at.rate + 2 * node, one, other, at.right, at.determinant + k, high)


@stage
def turned_direction(w: FloatArray, to: int, u: int, s: int, inverse: int, reach: float, high: int) -> None:
    """Fill with u' = i u (u x s' - e') / tau, the derivative of the direction of a guide."""
    t, a, b, c = w[pair(to)], w[pair(u)], w[pair(s)], w[real(inverse)]
    for r in rows(high):
        i = imaginary(r)
        angle = (a[r] * b[i] - a[i] * b[r] - reach) * c[r]
        t[r] = -angle * a[i]
        t[i] = angle * a[r]


@stage
def tilt_rate(
    w: FloatArray, s: Structure, at: SensitivityLanes, d: Tangents, live: IntArray, k: int, high: int
) -> None:  # fmt: skip
    """Compute the derivative of the direction of a guide that passes through a node."""
    register, a, b = s.nodes + s.steps[k, 1], s.steps[k, 2], s.steps[k, 3]
    if live[a] != 0 or live[b] != 0 or d.reach[k] != 0.0:
        live[register] = 1
        linear(w, RATE, rate_lane(at, live, b), rate_lane(at, live, a), -1.0, 0.0, high)
        turned_direction(
            w, at.rate + 2 * register, at.place + 2 * register, RATE, at.determinant + k, d.reach[k], high
        )  # fmt: skip


@stage
def equation_rate(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, d: Tangents, live: IntArray, k: int, to: int,
    high: int,
) -> bool:  # fmt: skip
    """Fill a lane, two for a closure, with Phi_d d' of equation k of a group; return whether it can differ from 0."""
    kind, p, o, vector, actuator = s.ei[k, 0], s.ei[k, 1], s.ei[k, 2], s.ei[k, 3], s.ei[k, 4]
    n, arm = s.li.shape[0] + k, at.arm + 2 * (s.li.shape[0] + k)
    moves, turns = live[p] != 0 or live[o] != 0, vector >= 0 and vector_moves(s, live, d, vector)
    longer = d.lv[n, 0] != 0.0 or (actuator >= 0 and (d.lv[n, 1] != 0.0 or d.inputs[actuator] != 0.0))
    linear(w, SCRATCH, rate_lane(at, live, p), rate_lane(at, live, o), -1.0, 0.0, high)
    if kind == CLOSURE:
        scale(w, to, SCRATCH, 1.0, 0.0, high)
        if turns:
            vector_rate(w, s, at, q, d, live, vector, ARM, high)
            add_scaled(w, to, ARM, -1.0, 0.0, high)
        return moves or turns
    dot(w, to, arm if kind == SPAN else at.vector + 2 * vector, SCRATCH, 1.0, high)
    if turns:
        vector_rate(w, s, at, q, d, live, vector, ARM, high)
        add_dot(w, to, arm, ARM, high)
    if longer:
        subtract_length(w, at, q, d, to, n, actuator, kind == SPAN, high)
    return moves or turns or longer


@stage
def group_rate(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, d: Tangents, live: IntArray, g: int, high: int
) -> None:  # fmt: skip
    """Compute the derivatives of the nodes of a coupled group."""
    first, end, m = s.gi[g, 0], s.gi[g, 1], s.gi[g, 6]
    for k in range(s.gi[g, 2], s.gi[g, 3]):
        carry_rate(w, s, at, q, d, live, s.pi[k, 0], s.pi[k, 1], s.pi[k, 2], high)
    to, moves = at.right, False
    for k in range(s.gi[g, 4], s.gi[g, 5]):
        moves = equation_rate(w, s, at, q, d, live, k, to, high) or moves
        to += 2 if s.ei[k, 0] == CLOSURE else 1
    if moves:
        solve(w, at.right, s.gi[g, 8], s.gi[g, 9], s.gi[g, 10], m, 2 * (end - first), high)
        for k in range(first, end):
            live[s.bases[k]] = 1
            scale(w, at.rate + 2 * s.bases[k], at.right + 2 * (k - first), -1.0, 0.0, high)
        for k in range(s.gi[g, 2], s.gi[g, 3]):
            carry_rate(w, s, at, q, d, live, s.pi[k, 0], s.pi[k, 1], s.pi[k, 2], high)


@stage
def differentiate(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, d: Tangents, live: IntArray, high: int
) -> None:  # fmt: skip
    """Compute the derivatives of all nodes by one dimension."""
    live[:] = 0
    for n in s.frame:
        if d.frame[n, 0] != 0.0 or d.frame[n, 1] != 0.0:
            live[n] = 1
            fill(w, at.rate + 2 * n, d.frame[n, 0], high)
            fill(w, at.rate + 2 * n + 1, d.frame[n, 1], high)
    for k in range(s.steps.shape[0]):
        kind = s.steps[k, 0]
        if kind == PLACE:
            carry_rate(w, s, at, q, d, live, s.steps[k, 1], s.steps[k, 2], s.steps[k, 3], high)
        elif kind == ORIENT:
            vector, register = s.steps[k, 3], s.nodes + s.steps[k, 1]
            if vector_moves(s, live, d, vector):
                vector_rate(w, s, at, q, d, live, vector, at.rate + 2 * register, high)
                live[register] = 1
        elif kind == TILT:
            tilt_rate(w, s, at, d, live, k, high)
        elif kind == COUPLED:
            group_rate(w, s, at, q, d, live, s.steps[k, 2], high)
        else:
            dyad_rate(w, s, at, q, d, live, k, high)


# -- all designs -------------------------------------------------------------------------------------------


@stage
def write(
    w: FloatArray, at: SensitivityLanes, live: IntArray, wanted: IntArray, out: FloatArray, done: int, high: int
) -> None:  # fmt: skip
    """Copy the derivatives of the wanted nodes to `out` (wanted, rows, 2); those that are zero are not written."""
    for n in range(len(wanted)):
        if live[wanted[n]] != 0:
            write_point(w, at.rate + 2 * wanted[n], out[n, done : done + high], high)


@stage
def differentiate_all(
    w: FloatArray, s: Structure, at: SensitivityLanes, q: Numbers, d: Tangents, z: FloatArray, inputs: FloatArray,
    live: IntArray, wanted: IntArray, out: FloatArray, good: FloatArray,
) -> None:  # fmt: skip
    """Differentiate the wanted nodes in the rows of all designs by all dimensions.

    q and d have the leading axes (designs,) and (designs, dimensions), `d.inputs` only (dimensions,). z (designs,
    nodes, rows, 2), inputs (designs, actuators, rows). Results: out (designs, dimensions, wanted, rows, 2), zeros on
    entry, and good (designs, rows): 0, or NaN where the derivatives are not determined.
    """
    fill(w, ZERO, 0.0, ROWS)
    fill(w, ZERO + 1, 0.0, ROWS)
    fill(w, ONE, 1.0, ROWS)
    fill(w, ONE + 1, 0.0, ROWS)
    for n in range(out.shape[0]):
        own, given = Numbers(q.vz[n], q.lv[n]), inputs[n]
        done, end = 0, out.shape[3]
        while done < end:
            high = min(ROWS, end - done)
            fill(w, GOOD, 0.0, high)
            for node in range(s.nodes):
                read_node(w, at.place + 2 * node, z[n, node, done : done + high], high)
            read_inputs(w, at, given, done, high)
            prepare(w, s, at, own, high)
            for k in range(out.shape[1]):
                one = Tangents(d.vz[n, k], d.lv[n, k], d.reach[n, k], d.frame[n, k], d.inputs[k])
                differentiate(w, s, at, own, one, live, high)
                write(w, at, live, wanted, out[n, k], done, high)
            write_angle(w, ZERO, good[n, done : done + high], high)
            done += high
