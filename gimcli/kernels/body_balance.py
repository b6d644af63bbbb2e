"""Equilibrium of all bodies in one state of a simulation, with accelerations among the unknowns, and dry friction.

The unknowns x are the reactions, the efforts of the inputs that follow laws, and the accelerations s'' of the free
independent variables. With the equations of equilibrium E (`gimcli.kernels.equilibrium`) and the inertia forces I of
unit accelerations,

    E x - I s'' = i - w - E e + E f

i: inertia forces while s'' is 0; w: weight and loads; e: efforts of springs, dampers and free inputs; f: friction
forces and moments, opposite to the sliding. So x and s'' are linear in f, while f depends on x:

    f_j = s_j |y_j|,   y = y0 + G f

s: shares of the full friction (-1..1); y: a pin force times the radius of its friction circle, or mu times the normal
force and the moment of a guide; |y|: the length, or the greater of the two. Newton's method uses the slopes of the
piece on which f lies. Without friction its Jacobian is 1; a solution that is connected to it has a positive
determinant.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gimcli.kernels.equilibrium import MOMENT, X
from gimcli.kernels.influence import InfluencePosition, InfluenceScratch
from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.laws import damper
from gimcli.kernels.linear import lu_factor, lu_solve
from gimcli.kernels.reduction import Acting, carry, load_force, pin_speed, sense_of, turn
from gimcli.kernels.vector import copy
from gimcli.mechanism import FloatArray, IntArray

PIN, GUIDE = range(2)
"""Kinds of contacts: a pin, and a guide."""

ROUNDS, HALVINGS = 40, 12
"""Most iterations, and most halvings of a correction that increases the error; a few suffice for small friction."""

EXACT, ACCEPTED = 1e-13, 1e-11
"""Errors relative to the greatest reaction: at which the iteration ends, and of a solution that is accepted."""

PARTS = 16
"""Steps of the shares from 0 to 1 where the iteration fails at once."""


class BalancedBodies(NamedTuple):
    """The equations; the columns are reactions, actuators and gauges, and moments in pins."""

    terms: IntArray  # (., 5) row, column, axis (TURN: a couple), node of action, node of reference
    factors: FloatArray  # (terms,) 1 or -1, of couples any number
    vectors: FloatArray  # (columns, 2) z
    turned: IntArray  # (., 4) column, u, v, and 1 to normalise the direction z (v - u)
    unknown: IntArray  # (columns,) number among the unknowns, or -1
    contact: IntArray  # (columns,) number of the contact with this friction, or -1
    masses: IntArray  # (masses, 3) row of the body's first equation or -1, its node of reference, 1 with a moment
    loads: IntArray  # (loads, 3)
    readings: IntArray  # (readings, 2) column or -1, 1 for a distance of two nodes
    couples: IntArray  # (rubs,) columns of the moments in pins
    rotors: IntArray  # (., 2) number of a rotor, column of an actuator that turns it
    rotor_ratio: FloatArray  # (.,) rate of the rotor's input by that of the actuator: 1, or the ratio of a follower
    first: int  # number of the variable that is the first reading


class Contacts(NamedTuple):
    """The pairs with dry friction."""

    kind: IntArray  # (contacts,)
    speed: IntArray  # (contacts,) number of its moment in `Acting.rubs`, or variable of the travel


class BalanceRoom(NamedTuple):
    """Results of `fill`, and scratch arrays."""

    directions: FloatArray  # (columns, 2)
    efforts: FloatArray  # (columns,) N, or N x length of the normal frame
    gains: FloatArray  # (columns, unknowns + free) derivatives of the efforts by the unknowns
    matrix: FloatArray  # (equations, unknowns + free)
    sides: FloatArray  # (equations, 1 + contacts)
    rest: FloatArray  # (variables,) accelerations while s'' is 0


class LoopRoom(NamedTuple):
    """Results of `find_friction`, and scratch arrays."""

    speed: FloatArray  # (contacts,) rad/s, or lengths of the normal frame per s
    share: FloatArray  # (contacts,)
    y: FloatArray  # (contacts, 2, 1 + contacts) y0 and G
    f: FloatArray  # (contacts,) N x length of the normal frame, or N
    size: FloatArray  # (contacts,) |y|
    slope: FloatArray  # (contacts, 2) of |y| by y
    a: FloatArray  # (contacts, contacts)
    order: FloatArray  # (2 contacts,)
    step: FloatArray  # (contacts,)
    trial: FloatArray  # (contacts,)


@kernel
def act(
    table: FloatArray, column: int, body: IntArray, v: FloatArray, x: float, y: float, fx: float, fy: float, m: float
) -> None:
    """Add a force at (x, y) and a moment on a body to a column of a table."""
    row = body[0]
    if row < 0:
        return
    table[row, column] += fx
    table[row + 1, column] += fy
    if body[2]:
        r = body[1]
        table[row + 2, column] += (x - v[2 * r]) * fy - (y - v[2 * r + 1]) * fx + m


@stage
def fill_bodies(
    b: BalancedBodies, p: Acting, at: InfluencePosition, free: int, factors: FloatArray, out: BalanceRoom
) -> None:  # fmt: skip
    """Add inertia forces, weight and loads."""
    v, metre, unknowns = at.v, p.metre, out.matrix.shape[1] - free
    for i in range(p.masses.shape[0]):
        n, f, zr, zi = p.masses[i, 0], p.masses[i, 1], p.mass[i, 0], p.mass[i, 1]
        mass, moment, square, body = p.mass[i, 2] * metre, p.mass[i, 3] / metre, p.mass[i, 4], b.masses[i]
        x, y = carry(v, n, f, zr, zi)
        ax, ay = carry(out.rest, n, f, zr, zi)
        weight = p.mass[i, 2]
        fx, fy = mass * ax - weight * p.gravity[0], mass * ay - weight * p.gravity[1]
        act(out.sides, 0, body, v, x, y, fx, fy, moment * turn(v, out.rest, n, f, square))
        for k in range(free):
            ax, ay = carry(at.b[k], n, f, zr, zi)
            spin = moment * turn(v, at.b[k], n, f, square)
            act(out.matrix, unknowns + k, body, v, x, y, -mass * ax, -mass * ay, -spin)
    for i in range(p.loads.shape[0]):
        fx, fy = load_force(p, v, i)
        x, y = carry(v, p.loads[i, 0], p.loads[i, 1], p.load[i, 0], p.load[i, 1])
        torque = p.load[i, 4] / metre
        act(out.sides, 0, b.loads[i], v, x, y, -fx * factors[i], -fy * factors[i], -torque * factors[i])


@stage
def fill_efforts(
    b: BalancedBodies, p: Acting, at: InfluencePosition, w: FloatArray, free: int, known: FloatArray, out: BalanceRoom
) -> None:
    """Compute the efforts of the readings, of rotors, and of viscous friction in pins, while s'' is 0; and by s''."""
    v, unknowns = at.v, out.matrix.shape[1] - free
    for i in range(b.readings.shape[0]):
        c, r = b.readings[i, 0], b.first + i
        if c >= 0:
            out.efforts[c] = sense_of(v, r, b.readings[i, 1]) * known[r] / p.metre
            for k in range(free):
                out.gains[c, unknowns + k] = 0.0
    for i in range(b.rotors.shape[0]):
        c, r = b.rotors[i, 1], p.rotors[b.rotors[i, 0]]
        inertia = b.rotor_ratio[i] * p.rotor[b.rotors[i, 0]] / p.metre
        out.efforts[c] -= inertia * out.rest[r]
        for k in range(free):
            out.gains[c, unknowns + k] -= inertia * at.b[k, r]
    for i in range(p.rubs.shape[0]):
        out.efforts[b.couples[i]] = damper(p.rub[i, 0], pin_speed(p, v, w, i), 1.0) / p.metre


@kernel
def entry(b: BalancedBodies, t: int, v: FloatArray, directions: FloatArray) -> float:
    """Return an entry of E."""
    c, axis, n, r = b.terms[t, 1], b.terms[t, 2], b.terms[t, 3], b.terms[t, 4]
    part, dx, dy = 1.0, directions[c, 0], directions[c, 1]
    if axis == MOMENT:
        part = (v[2 * n] - v[2 * r]) * dy - (v[2 * n + 1] - v[2 * r + 1]) * dx
    elif axis < MOMENT:
        part = dx if axis == X else dy
    return b.factors[t] * part


@kernel
def fill(
    b: BalancedBodies, p: Acting, at: InfluencePosition, room: InfluenceScratch, given: FloatArray, factors: FloatArray,
    known: FloatArray, out: BalanceRoom,
) -> None:  # fmt: skip
    """Compute the matrix and the right sides of the state in `at` and `room`.

    given: accelerations of the inputs that follow laws, the last independent variables. known: efforts on the
    variables (`Reduced.effort`).
    """
    v = at.v
    free = at.b.shape[0] - given.shape[0]
    for i in range(v.shape[0]):
        out.rest[i] = room.acceleration[i]
        for k in range(given.shape[0]):
            out.rest[i] += given[k] * at.b[free + k, i]
    out.matrix[:, :], out.sides[:, :] = 0.0, 0.0
    for c in range(b.vectors.shape[0]):
        out.directions[c, 0], out.directions[c, 1] = b.vectors[c, 0], b.vectors[c, 1]
    for t in range(b.turned.shape[0]):
        c, i, j = b.turned[t, 0], b.turned[t, 1], b.turned[t, 2]
        ex, ey = v[2 * j] - v[2 * i], v[2 * j + 1] - v[2 * i + 1]
        dx, dy = b.vectors[c, 0] * ex - b.vectors[c, 1] * ey, b.vectors[c, 0] * ey + b.vectors[c, 1] * ex
        norm = math.sqrt(dx * dx + dy * dy) if b.turned[t, 3] == 1 else 1.0
        out.directions[c, 0], out.directions[c, 1] = dx / norm, dy / norm
    fill_efforts(b, p, at, room.velocity, free, known, out)
    for t in range(b.terms.shape[0]):
        row, c, part = b.terms[t, 0], b.terms[t, 1], entry(b, t, v, out.directions)
        if b.unknown[c] >= 0:
            out.matrix[row, b.unknown[c]] += part
        else:
            out.sides[row, 0] -= part * out.efforts[c]
            for j in range(out.matrix.shape[1]):
                out.matrix[row, j] += part * out.gains[c, j]
        if b.contact[c] >= 0:
            out.sides[row, 1 + b.contact[c]] += part
    fill_bodies(b, p, at, free, factors, out)


@kernel
def miss_of(kind: IntArray, part: float, f: FloatArray, room: LoopRoom) -> tuple[float, float]:
    """Compute |y| and its slopes at f; return the greatest error of the equations, and the greatest |y|."""
    worst, greatest = 0.0, 0.0
    for k in range(kind.shape[0]):
        one, other = room.y[k, 0, 0], room.y[k, 1, 0]
        for j in range(f.shape[0]):
            one += room.y[k, 0, 1 + j] * f[j]
            other += room.y[k, 1, 1 + j] * f[j]
        room.slope[k, 0], room.slope[k, 1] = 0.0, 0.0
        if kind[k] == PIN:
            size = math.sqrt(one * one + other * other)
            if size > 0.0:
                room.slope[k, 0], room.slope[k, 1] = one / size, other / size
        elif abs(one) >= abs(other):
            size, room.slope[k, 0] = abs(one), 1.0 if one >= 0.0 else -1.0
        else:
            size, room.slope[k, 1] = abs(other), 1.0 if other >= 0.0 else -1.0
        room.size[k] = size
        greatest = max(greatest, size)
        error = abs(f[k] - part * room.share[k] * size)
        if not error <= worst:
            worst = error
    return worst, greatest


@stage
def settle_friction(kind: IntArray, part: float, room: LoopRoom) -> bool:
    """Solve for `room.f`, starting from its present values, with `part` of the shares.

    Returns whether a solution was found, with a positive determinant.
    """
    n = kind.shape[0]
    error, greatest = miss_of(kind, part, room.f, room)
    rounds, improves = 0, True
    while True:
        for k in range(n):
            for j in range(n):
                slope = room.slope[k, 0] * room.y[k, 0, 1 + j] + room.slope[k, 1] * room.y[k, 1, 1 + j]
                room.a[k, j] = (1.0 if j == k else 0.0) - part * room.share[k] * slope
            room.step[k] = part * room.share[k] * room.size[k] - room.f[k]
        sign = lu_factor(room.a, n, room.order)
        if error <= EXACT * greatest or not improves or rounds >= ROUNDS or sign == 0.0:
            return bool(error <= ACCEPTED * greatest and sign > 0.0)
        lu_solve(room.a, n, room.order, room.step)
        length, before = 1.0, error
        for _ in range(HALVINGS):
            for k in range(n):
                room.trial[k] = room.f[k] + length * room.step[k]
            error, greatest = miss_of(kind, part, room.trial, room)
            if error < before:
                break
            length *= 0.5
        improves = error < before
        if improves:
            copy(room.f, room.trial)
        else:
            error, greatest = miss_of(kind, part, room.f, room)
        rounds += 1


@kernel
def find_friction(
    c: Contacts, p: Acting, at: InfluencePosition, velocity: FloatArray, slip: float, room: LoopRoom
) -> bool:
    """Compute the friction `room.f` (contacts,), starting from its present values; return whether it was found."""
    for k in range(c.kind.shape[0]):
        i = c.speed[k]
        room.speed[k] = pin_speed(p, at.v, velocity, i) if c.kind[k] == PIN else velocity[i]
        room.share[k] = math.tanh(room.speed[k] / slip)
    if settle_friction(c.kind, 1.0, room):
        return True
    room.f[:] = 0.0
    done, i = True, 0
    while done and i < PARTS:
        i += 1
        done = settle_friction(c.kind, i / PARTS, room)
    return done
