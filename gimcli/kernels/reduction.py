"""Masses and forces reduced to the independent variables s, at a position with known influence coefficients.

    M = sum of m B'B + J w w',   h = sum of m B'a + J w alpha,   Q = sum of B'F + w T

B: influence coefficients of a centre of mass (complex); w: angular influence coefficients; a and alpha: the
accelerations without the terms of s''. The equations of motion are M s'' + h = Q, in J per unit of s. Source: Durango,
Giraldo, Calle & Mesa 2014, eqs 3-6, here reduced directly to the independent variables.
"""

from __future__ import annotations

from typing import NamedTuple

from gimcli.kernels.influence import Chart, InfluencePosition, InfluenceScratch, follow
from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.laws import damper, drive, spring
from gimcli.kernels.linear import lu_factor, lu_solve
from gimcli.kernels.windows import Windows, begin_beyond, interpolate, window_of
from gimcli.mechanism import FloatArray, IntArray

KINETIC, POTENTIAL, DISSIPATED, SUPPLIED = range(4)
"""Entries of `Reduced.energy`: kinetic and potential energy [J], dissipated and supplied power [W]."""

ENERGIES = 4

SINGULAR = 1e-14
"""A reduced inertia below this fraction of the greatest is 0."""


class Acting(NamedTuple):
    """Masses and loads in flat arrays; a point of a member is p = node u + z (node v - node u)."""

    metre: float  # m per unit of the normal frame
    units: FloatArray  # (variables,) m per unit of a variable; 1 for an angle
    masses: IntArray  # (., 2) u, v
    mass: FloatArray  # (., 5) z, mass, moment of inertia, square of the distance of u and v
    gravity: FloatArray  # (2,)
    loads: IntArray  # (., 3) u, v, 1 if the force rotates with the member
    load: FloatArray  # (., 6) z, force, torque, square of the distance of u and v
    springs: IntArray  # (., 2) variable, 1 for a distance of two nodes
    spring: FloatArray  # (., parameters) `SpringForce.law`
    dampers: IntArray  # (.,) variable
    damper: FloatArray  # (.,) damping
    rubs: IntArray  # (., 4) u, v of the one member, u, v of the other; -1 for the frame
    rub: FloatArray  # (., 3) damping, squares of the distances of u and v
    motors: IntArray  # (.,) variable
    motor: FloatArray  # (., 2) effort, idle speed (0: none)
    rotors: IntArray  # (.,) variable
    rotor: FloatArray  # (.,) inertia on the variable, J per square of its rate


class Reduced(NamedTuple):
    """The equations of motion in the independent variables, and energies."""

    m: FloatArray  # (k, k) M
    h: FloatArray  # (k,)
    q: FloatArray  # (k,) Q
    energy: FloatArray  # (ENERGIES,)
    effort: FloatArray  # (variables,) of springs, dampers and free inputs, J per unit of the variable


@kernel
def carry(x: FloatArray, u: int, v: int, zr: float, zi: float) -> tuple[float, float]:
    """Return x and y of the point u + z (v - u)."""
    ex, ey = x[2 * v] - x[2 * u], x[2 * v + 1] - x[2 * u + 1]
    return x[2 * u] + zr * ex - zi * ey, x[2 * u + 1] + zr * ey + zi * ex


@kernel
def turn(x: FloatArray, w: FloatArray, u: int, v: int, square: float) -> float:
    """Return the angular rate of a member: cross product of the arm and its rate, by the square of its length."""
    if u < 0:
        return 0.0
    ex, ey = x[2 * v] - x[2 * u], x[2 * v + 1] - x[2 * u + 1]
    return (ex * (w[2 * v + 1] - w[2 * u + 1]) - ey * (w[2 * v] - w[2 * u])) / square


@kernel
def pin_speed(p: Acting, v: FloatArray, w: FloatArray, i: int) -> float:
    """Return the relative angular rate in a pin with friction."""
    one = turn(v, w, p.rubs[i, 0], p.rubs[i, 1], p.rub[i, 1])
    return one - turn(v, w, p.rubs[i, 2], p.rubs[i, 3], p.rub[i, 2])


@kernel
def load_force(p: Acting, v: FloatArray, i: int) -> tuple[float, float]:
    """Return the force of a load [N], without its factor."""
    fx, fy = p.load[i, 2], p.load[i, 3]
    if p.loads[i, 2]:
        n, f = p.loads[i, 0], p.loads[i, 1]
        ex, ey = v[2 * f] - v[2 * n], v[2 * f + 1] - v[2 * n + 1]
        return fx * ex - fy * ey, fx * ey + fy * ex
    return fx, fy


@stage
def reduce_masses(p: Acting, at: InfluencePosition, room: InfluenceScratch, out: Reduced) -> None:
    """Add the inertia and the weight of the masses."""
    v, b, w, a, metre = at.v, at.b, room.velocity, room.acceleration, p.metre
    gx, gy = p.gravity[0] * metre, p.gravity[1] * metre
    for i in range(p.masses.shape[0]):
        n, f = p.masses[i, 0], p.masses[i, 1]
        zr, zi, moment, square = p.mass[i, 0], p.mass[i, 1], p.mass[i, 3], p.mass[i, 4]
        mass, weight = p.mass[i, 2] * metre * metre, p.mass[i, 2]
        x, y = carry(v, n, f, zr, zi)
        out.energy[POTENTIAL] -= weight * (gx * x + gy * y)
        x, y = carry(w, n, f, zr, zi)
        omega = turn(v, w, n, f, square)
        out.energy[KINETIC] += 0.5 * (mass * (x * x + y * y) + moment * omega * omega)
        ax, ay = carry(a, n, f, zr, zi)
        alpha = turn(v, a, n, f, square)
        for k in range(b.shape[0]):
            bx, by = carry(b[k], n, f, zr, zi)
            t = turn(v, b[k], n, f, square)
            out.q[k] += weight * (gx * bx + gy * by)
            out.h[k] += mass * (bx * ax + by * ay) + moment * t * alpha
            for j in range(k + 1):
                cx, cy = carry(b[j], n, f, zr, zi)
                out.m[k, j] += mass * (bx * cx + by * cy) + moment * t * turn(v, b[j], n, f, square)


@stage
def reduce_loads(p: Acting, at: InfluencePosition, room: InfluenceScratch, factors: FloatArray, out: Reduced) -> None:
    """Add forces and torques."""
    v, b, w = at.v, at.b, room.velocity
    for i in range(p.loads.shape[0]):
        n, f, square = p.loads[i, 0], p.loads[i, 1], p.load[i, 5]
        zr, zi, torque = p.load[i, 0], p.load[i, 1], p.load[i, 4] * factors[i]
        fx, fy = load_force(p, v, i)
        fx, fy = fx * p.metre * factors[i], fy * p.metre * factors[i]
        for k in range(b.shape[0]):
            bx, by = carry(b[k], n, f, zr, zi)
            out.q[k] += fx * bx + fy * by + torque * turn(v, b[k], n, f, square)
        x, y = carry(w, n, f, zr, zi)
        out.energy[SUPPLIED] += fx * x + fy * y + torque * turn(v, w, n, f, square)


@kernel
def sense_of(v: FloatArray, r: int, distance: int) -> float:
    """Return -1 for a distance of nodes beyond the place where they coincide, whose length is -v[r]; else 1."""
    return -1.0 if distance and v[r] < 0.0 else 1.0


@kernel
def act_on(at: InfluencePosition, r: int, effort: float, out: Reduced) -> None:
    """Add an effort on a variable."""
    out.effort[r] += effort
    for k in range(at.b.shape[0]):
        out.q[k] += effort * at.b[k, r]


@stage
def reduce_gauges(p: Acting, at: InfluencePosition, room: InfluenceScratch, out: Reduced) -> None:
    """Add springs, dampers and the driving efforts of free inputs."""
    v, w = at.v, room.velocity
    for i in range(p.springs.shape[0]):
        r = p.springs[i, 0]
        sense = sense_of(v, r, p.springs[i, 1])
        energy, effort, _ = spring(p.spring[i], sense * v[r], p.units[r])
        out.energy[POTENTIAL] += energy
        act_on(at, r, sense * effort, out)
    for i in range(p.dampers.shape[0]):
        r = p.dampers[i]
        effort = damper(p.damper[i], w[r], p.units[r])
        out.energy[DISSIPATED] -= effort * w[r]
        act_on(at, r, effort, out)
    for i in range(p.motors.shape[0]):
        r = p.motors[i]
        effort = drive(p.motor[i, 0] * p.units[r], p.motor[i, 1], w[r])
        out.energy[SUPPLIED] += effort * w[r]
        act_on(at, r, effort, out)


@stage
def reduce_friction(p: Acting, at: InfluencePosition, room: InfluenceScratch, out: Reduced) -> None:
    """Add viscous friction in revolute pairs."""
    for i in range(p.rubs.shape[0]):
        speed = pin_speed(p, at.v, room.velocity, i)
        moment = damper(p.rub[i, 0], speed, 1.0)
        out.energy[DISSIPATED] -= moment * speed
        for k in range(at.b.shape[0]):
            out.q[k] += moment * pin_speed(p, at.v, at.b[k], i)


@stage
def reduce_rotors(p: Acting, at: InfluencePosition, room: InfluenceScratch, out: Reduced) -> None:
    """Add the inertia of the motors' rotors."""
    b = at.b
    for i in range(p.rotors.shape[0]):
        r, inertia = p.rotors[i], p.rotor[i]
        out.energy[KINETIC] += 0.5 * inertia * room.velocity[r] * room.velocity[r]
        for k in range(b.shape[0]):
            out.h[k] += inertia * b[k, r] * room.acceleration[r]
            for j in range(k + 1):
                out.m[k, j] += inertia * b[k, r] * b[j, r]


@kernel
def reduce(p: Acting, at: InfluencePosition, room: InfluenceScratch, factors: FloatArray, out: Reduced) -> None:
    """Reduce all masses and loads."""
    out.m[:, :], out.h[:], out.q[:], out.energy[:], out.effort[:] = 0.0, 0.0, 0.0, 0.0, 0.0
    reduce_masses(p, at, room, out)
    reduce_loads(p, at, room, factors, out)
    reduce_gauges(p, at, room, out)
    reduce_friction(p, at, room, out)
    reduce_rotors(p, at, room, out)
    for k in range(at.b.shape[0]):
        for j in range(k):
            out.m[j, k] = out.m[k, j]


@kernel
def accelerate(out: Reduced, free: int, given: FloatArray, room: InfluenceScratch, gain: FloatArray) -> bool:
    """Compute the accelerations `gain` (k,): of the first `free` independent variables; the others are given.

    For the given ones, `out.q` is replaced by the efforts that they need. Returns false if M is singular.
    """
    size = out.h.shape[0]
    greatest = 0.0
    for k in range(free, size):
        gain[k] = given[k]
    for k in range(free):
        right = out.q[k] - out.h[k]
        for j in range(free, size):
            right -= out.m[k, j] * given[j]
        room.right[k] = right
        greatest = max(greatest, abs(out.m[k, k]))
        for j in range(free):
            room.a[k, j] = out.m[k, j]
    if free and not greatest > 0.0:
        return False
    if lu_factor(room.a, free, room.order) <= 0.0:
        return False
    for k in range(free):
        if not room.order[free + k] * SINGULAR * greatest < 1.0:
            return False
    lu_solve(room.a, free, room.order, room.right)
    for k in range(free):
        gain[k] = room.right[k]
    for k in range(free, size):
        effort = out.h[k] - out.q[k]
        for j in range(size):
            effort += out.m[k, j] * gain[j]
        out.q[k] = effort
    return True


@stage
def move(
    c: Chart, p: Acting, base: InfluencePosition, last: InfluencePosition, at: InfluencePosition, windows: Windows,
    target: FloatArray, speeds: FloatArray,
    given: FloatArray, free: int, factors: FloatArray, room: InfluenceScratch, out: Reduced, gain: FloatArray,
) -> bool:  # fmt: skip
    """Follow the motion from `base` to a state, and compute its accelerations; return whether both succeeded."""
    within = window_of(windows, target)
    if within >= 0:
        if not interpolate(c, windows, within, target, speeds, last, at, room):
            return False
    else:
        begin_beyond(c, windows, base, target, last)
        if not follow(c, last, at, target, speeds, room):
            return False
    reduce(p, at, room, factors, out)
    if not accelerate(out, free, given, room, gain):
        return False
    for k in range(free, speeds.shape[0]):
        out.energy[SUPPLIED] += out.q[k] * speeds[k]
    return True
