"""One swing of Watt's six-bar at tolerance 1e-9: `gim` compared with the same equation written by hand.

By hand: closed-form dyads, exact dJ/dq, numba; integrated by scipy's DOP853, and by a compiled DOP853. Both compute no
events, rows, energies, branches or dead points. One process, one thread, CPU time, best of 9.

Run: python tests/benchmarks/swing.py
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numba
import numpy as np
from scipy.integrate import DOP853, solve_ivp

from gimcli import Mechanism, load
from gimcli.dynamics.simulation import Settings, Simulation, simulate
from gimcli.kernels.jit import compiled

MODEL = Path(__file__).parents[2] / "models" / "watt_durango.yaml"
HALF_PERIOD = 1.79687375203394
STANDSTILL = math.radians(406.279660669895)
START = math.radians(120.0)
REPEATS = 9
A, B, E3, E5 = (np.ascontiguousarray(t) for t in (DOP853.A, DOP853.B, DOP853.E3, DOP853.E5))


@numba.njit
def meet(ax, ay, r, bx, by, s, side):
    dx, dy = bx - ax, by - ay
    d2 = dx * dx + dy * dy
    along = 0.5 * (1.0 + (r * r - s * s) / d2)
    across = side * math.sqrt(r * r / d2 - along * along)
    return ax + along * dx - across * dy, ay + along * dy + across * dx


@numba.njit
def turns(px, py, qx, qy, rx, ry):
    """Return w1 and w2 with i w1 p - i w2 q = r."""
    det = px * qy - py * qx
    return (rx * qx + ry * qy) / det, (rx * px + ry * py) / det


@numba.njit
def alpha(theta, omega):
    """Return the angular acceleration of the crank."""
    c, s = math.cos(theta), math.sin(theta)
    bx, by = meet(c, s, 1.5, 1.6, 0.0, 1.5, 1.0)
    cx, cy, dx, dy = 0.5 * (c + bx), 0.5 * (s + by), 0.5 * (1.6 + bx), 0.5 * by
    ex, ey = meet(cx, cy, 1.0, dx, dy, 1.0, 1.0)
    px, py, qx, qy = bx - c, by - s, bx - 1.6, by
    w3, w4 = turns(px, py, qx, qy, s, -c)
    e3, e4 = turns(px, py, qx, qy, c + w3 * w3 * px - w4 * w4 * qx, s + w3 * w3 * py - w4 * w4 * qy)
    vcx, vcy, vdx, vdy = -s - 0.5 * w3 * py, c + 0.5 * w3 * px, -0.5 * w4 * qy, 0.5 * w4 * qx
    acx = -c - 0.5 * (e3 * py + w3 * w3 * px)
    acy = -s + 0.5 * (e3 * px - w3 * w3 * py)
    adx, ady = -0.5 * (e4 * qy + w4 * w4 * qx), 0.5 * (e4 * qx - w4 * w4 * qy)
    ux, uy, vx, vy = ex - cx, ey - cy, ex - dx, ey - dy
    w5, w6 = turns(ux, uy, vx, vy, vdx - vcx, vdy - vcy)
    e5, e6 = turns(
        ux, uy, vx, vy, adx - acx + w5 * w5 * ux - w6 * w6 * vx, ady - acy + w5 * w5 * uy - w6 * w6 * vy
    )  # fmt: skip
    v5x, v5y, v6x, v6y = vcx - 0.5 * w5 * uy, vcy + 0.5 * w5 * ux, vdx - 0.5 * w6 * vy, vdy + 0.5 * w6 * vx
    a5x, a5y = acx - 0.5 * (e5 * uy + w5 * w5 * ux), acy + 0.5 * (e5 * ux - w5 * w5 * uy)
    a6x, a6y = adx - 0.5 * (e6 * vy + w6 * w6 * vx), ady + 0.5 * (e6 * vx - w6 * w6 * vy)
    j = 0.0833 + 0.25 + 1.5 * (vcx * vcx + vcy * vcy + vdx * vdx + vdy * vdy) + 0.2813 * (w3 * w3 + w4 * w4)
    j += v5x * v5x + v5y * v5y + v6x * v6x + v6y * v6y + 0.0833 * (w5 * w5 + w6 * w6)
    h = 1.5 * (vcx * acx + vcy * acy + vdx * adx + vdy * ady) + 0.2813 * (w3 * e3 + w4 * e4)
    h += v5x * a5x + v5y * a5y + v6x * a6x + v6y * a6y + 0.0833 * (w5 * e5 + w6 * e6)
    tau = -9.81 * (0.5 * c + 1.5 * (vcy + vdy) + v5y + v6y)
    return (tau - h * omega * omega) / j


@numba.njit
def integrate(theta, omega, end, rtol, atol, step, a, b, e3, e5):
    """Integrate by the same DOP853, compiled; return the state at the end and the number of steps."""
    k = np.empty((13, 2))
    k[0, 0], k[0, 1] = omega, alpha(theta, omega)
    t, steps = 0.0, 0
    while t < end:
        rejected = False
        while True:
            h = min(step, end - t)
            for m in range(1, 13):
                row = b if m == 12 else a[m]
                x, y = 0.0, 0.0
                for i in range(m):
                    x += row[i] * k[i, 0]
                    y += row[i] * k[i, 1]
                k[m, 0], k[m, 1] = omega + h * y, alpha(theta + h * x, omega + h * y)
            p, q = theta + h * x, omega + h * y
            five, three = 0.0, 0.0
            for i in range(2):
                scale = atol + rtol * (max(abs(theta), abs(p)) if i == 0 else max(abs(omega), abs(q)))
                u, v = 0.0, 0.0
                for m in range(13):
                    u += e5[m] * k[m, i]
                    v += e3[m] * k[m, i]
                five += (u / scale) ** 2
                three += (v / scale) ** 2
            error = h * five / math.sqrt((five + 0.01 * three) * 2.0) if five > 0.0 else 0.0
            if error < 1.0:
                break
            step = h * max(0.2, 0.9 * error**-0.125)
            rejected = True
        factor = min(10.0, 0.9 * error**-0.125) if error > 0.0 else 10.0
        step = h * (min(1.0, factor) if rejected else factor)
        t, theta, omega, steps = t + h, p, q, steps + 1
        k[0, 0], k[0, 1] = k[12, 0], k[12, 1]
    return theta, omega, steps


def by_scipy() -> float:
    """Return the angle at the end by scipy's integrator."""
    found = solve_ivp(
        lambda _, y: (y[1], alpha(y[0], y[1])), (0.0, HALF_PERIOD), [START, 0.0], "DOP853", rtol=1e-9, atol=1e-10
    )
    return float(found.y[0, -1])


def by_hand() -> float:
    """Return the angle at the end by the compiled integrator."""
    return float(integrate(START, 0.0, HALF_PERIOD, 1e-9, 1e-10, 1e-2, A, B, E3, E5)[0])


def by_gim(mechanism: Mechanism) -> Simulation:
    """Simulate the swing by `gim`."""
    return simulate(mechanism, np.array([0.0, HALF_PERIOD]), Settings(), compiled)


def best(work: Callable[[], object]) -> float:
    """Return the best CPU time [s]."""
    took = []
    for _ in range(REPEATS):
        begin = time.thread_time()
        work()
        took.append(time.thread_time() - begin)
    return min(took)


def a_swing(mechanism: Mechanism) -> float:
    """Return the CPU time of one more swing [s]: 41 swings in one call minus one swing, divided by 40."""
    one, many = (np.array([0.0, swings * HALF_PERIOD]) for swings in (1.0, 41.0))
    calls = [best(partial(simulate, mechanism, times, Settings(), compiled)) for times in (one, many)]
    return (calls[1] - calls[0]) / 40.0


def main() -> None:
    """Measure and print."""
    mechanism = load(MODEL)
    errors = [by_scipy() - STANDSTILL, by_hand() - STANDSTILL, float(by_gim(mechanism).inputs[0, 0, -1]) - STANDSTILL]
    scipy, hand, gim = best(by_scipy), best(by_hand), best(lambda: by_gim(mechanism))
    swing = a_swing(mechanism)
    print("one swing of Watt's six-bar at 1e-9        CPU time   error [rad]")
    print(f"by hand, numba, scipy's DOP853           {1e3 * scipy:8.2f} ms   {errors[0]:+.1e}")
    print(f"by hand, numba, compiled DOP853          {1e3 * hand:8.2f} ms   {errors[1]:+.1e}")
    print(f"gim, whole call                          {1e3 * gim:8.2f} ms   {errors[2]:+.1e}")
    print(f"gim, a further swing of the same call    {1e3 * swing:8.2f} ms")
    print(f"ratio of whole calls: {gim / scipy:.2f} to scipy's, {gim / hand:.1f} to the compiled one")
    print(f"ratio of a further swing: {swing / scipy:.2f} to scipy's, {swing / hand:.1f} to the compiled one")


if __name__ == "__main__":
    main()
