"""Positions near change points, where the equations alone tell them badly, from polynomials of the input.

At a distance d from a change point velocities are known to eps / d^2 and accelerations to eps / d^3 only. The branch
that is followed is smooth there: in a window about the point all variables are Chebyshev polynomials of the one
independent variable, fitted to places on both sides. What comes out does not depend on the steps of an integrator.
"""

from __future__ import annotations

from typing import NamedTuple

from gimcli.kernels.influence import Place, Room, copy_place
from gimcli.kernels.jit import kernel
from gimcli.mechanism import FloatArray

LEFT, RIGHT = range(2)


class Windows(NamedTuple):
    """Windows of one independent variable, and the places at their edges."""

    bounds: FloatArray  # (windows, 2)
    scale: FloatArray  # (windows, 2) centre and half width of the polynomials' interval
    factors: FloatArray  # (windows, degrees, variables)
    v: FloatArray  # (windows, 2, variables)
    b: FloatArray  # (windows, 2, variables)
    sign: FloatArray  # (windows, 2, blocks)


@kernel
def window_of(windows: Windows, target: float) -> int:
    """Return the window that a value lies in, or -1."""
    for k in range(windows.bounds.shape[0]):
        if windows.bounds[k, LEFT] <= target <= windows.bounds[k, RIGHT]:
            return k
    return -1


@kernel
def stand_at_edge(windows: Windows, k: int, side: int, to: Place) -> None:
    """Set a place to that at the edge of a window."""
    for i in range(to.v.shape[0]):
        to.v[i] = windows.v[k, side, i]
        to.b[0, i] = windows.b[k, side, i]
    for g in range(to.sign.shape[0]):
        to.sign[g] = windows.sign[k, side, g]


@kernel
def begin_beyond(windows: Windows, base: Place, here: float, target: float, last: Place) -> None:
    """Set the last place to where a way to a target begins: beyond the windows that lie on it."""
    copy_place(last, base)
    best, side = -1, RIGHT if target > here else LEFT
    nearest = abs(target - here)
    for k in range(windows.bounds.shape[0]):
        edge = windows.bounds[k, side]
        if (edge - here) * (target - edge) > 0.0 and abs(target - edge) < nearest:
            best, nearest = k, abs(target - edge)
    if best >= 0:
        stand_at_edge(windows, best, side, last)


@kernel
def interpolate(
    windows: Windows, k: int, own: int, target: float, speed: float, to: Place, room: Room
) -> None:  # fmt: skip
    """Find all variables, their velocities, and accelerations without that of the independent one, in a window."""
    x, scale = (target - windows.scale[k, 0]) / windows.scale[k, 1], windows.scale[k, 1]
    w, a = room.velocity, room.acceleration
    side = LEFT if x < 0.0 else RIGHT
    for g in range(to.sign.shape[0]):
        to.sign[g] = windows.sign[k, side, g]
    for i in range(to.v.shape[0]):
        to.v[i], to.b[0, i], a[i] = 0.0, 0.0, 0.0
    t0, t1, t2, u0, u1, u2, last0, last1, last2 = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(windows.factors.shape[1]):
        for i in range(to.v.shape[0]):
            c = windows.factors[k, n, i]
            to.v[i] += c * t0
            to.b[0, i] += c * t1
            a[i] += c * t2
        if n == 0:
            u0, u1, u2 = x, 1.0, 0.0
        else:
            u0 = 2.0 * x * t0 - last0
            u1 = 2.0 * t0 + 2.0 * x * t1 - last1
            u2 = 4.0 * t1 + 2.0 * x * t2 - last2
        last0, last1, last2 = t0, t1, t2
        t0, t1, t2 = u0, u1, u2
    for i in range(to.v.shape[0]):
        to.b[0, i] /= scale
        w[i] = to.b[0, i] * speed
        a[i] *= speed * speed / (scale * scale)
    to.v[own], to.b[0, own], w[own], a[own] = target, 1.0, speed, 0.0
