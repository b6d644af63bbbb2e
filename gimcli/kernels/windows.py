"""Positions near change points, where the equations are ill-conditioned, by interpolation between both sides.

At a distance d from a change point the errors of velocities are about eps / d^2 and those of accelerations eps / d^3.
The branch itself is smooth there. A window is a slab around the change point; inside it, position, velocities and
accelerations are interpolated along the line through the target and across the window, between positions outside it on
both sides. The result does not depend on the steps of the integrator.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gimcli.kernels.influence import Chart, InfluencePosition, InfluenceScratch, copy_place, follow
from gimcli.kernels.jit import kernel, stage
from gimcli.mechanism import FloatArray

NODES = 7
"""Number of interpolation positions on each side."""

ASIDE = 0.3
"""Greatest distance from the normal through a window's centre, in the normal frame or rad."""

FLOOR = 0.5
"""Least determinant of the interpolation positions, relative to the edges: change points lie on curved surfaces."""

LEFT, RIGHT = range(2)

TOGETHER = 2.0
"""Value of `room.weak[2]` if a window cannot be used because another change point crosses it."""


class Windows(NamedTuple):
    """Slabs |normal . (s - centre)| <= half of the independent variables s about change points, and their edges."""

    centre: FloatArray  # (windows, k)
    normal: FloatArray  # (windows, k) of length 1
    half: FloatArray  # (windows,)
    weakest: FloatArray  # (windows,) least determinant at the edges
    offsets: FloatArray  # (windows, 2, NODES) of the interpolation positions from the centre, from the edge outwards
    weights: FloatArray  # (windows, 2, NODES) of the interpolation polynomial
    v: FloatArray  # (windows, 2, variables) positions at the edges
    b: FloatArray  # (windows, 2, k, variables)
    sign: FloatArray  # (windows, 2, blocks)
    total: FloatArray  # (k + 3, variables) scratch
    target: FloatArray  # (k,) scratch


@kernel
def offset_of(w: Windows, n: int, s: FloatArray) -> float:
    """Return the signed distance of s from the middle plane of a window."""
    offset = 0.0
    for k in range(w.centre.shape[1]):
        offset += w.normal[n, k] * (s[k] - w.centre[n, k])
    return offset


@kernel
def is_beside(w: Windows, n: int, s: FloatArray, offset: float) -> bool:
    """Return whether s is near the normal through a window's centre."""
    square = 0.0
    for k in range(w.centre.shape[1]):
        square += (s[k] - w.centre[n, k]) ** 2
    return square - offset * offset <= ASIDE * ASIDE


@kernel
def window_of(w: Windows, s: FloatArray) -> int:
    """Return the number of the window that contains s, or -1."""
    for n in range(w.half.shape[0]):
        offset = offset_of(w, n, s)
        if abs(offset) <= w.half[n] and is_beside(w, n, s, offset):
            return n
    return -1


@kernel
def move_to_edge(w: Windows, n: int, side: int, to: InfluencePosition) -> None:
    """Set a position to that at the edge of a window."""
    copy_place(to, InfluencePosition(w.v[n, side], w.b[n, side], w.sign[n, side]))


@kernel
def begin_beyond(c: Chart, w: Windows, base: InfluencePosition, target: FloatArray, last: InfluencePosition) -> None:
    """Set `last` to the position from which a target can be followed: behind the windows on the straight path to it."""
    copy_place(last, base)
    here, passed = w.target, 0.0
    for k in range(target.shape[0]):
        here[k] = base.v[c.independent[k]]
    within = window_of(w, here)
    if within >= 0:
        move_to_edge(w, within, LEFT if offset_of(w, within, target) < 0.0 else RIGHT, last)
    for n in range(w.half.shape[0]):
        begin, end = offset_of(w, n, here), offset_of(w, n, target)
        side = RIGHT if end > begin else LEFT
        edge = w.half[n] if side == RIGHT else -w.half[n]
        if not (edge - begin) * (end - edge) > 0.0:
            continue
        part = (edge - begin) / (end - begin)
        for k in range(target.shape[0]):
            w.total[0, k] = here[k] + part * (target[k] - here[k])
        if part > passed and is_beside(w, n, w.total[0], edge):
            passed = part
            move_to_edge(w, n, side, last)


@kernel
def weight_of(w: Windows, n: int, side: int, i: int, offset: float) -> float:
    """Return the weight of position i of a side in the interpolation polynomial of a window."""
    weight = w.weights[n, side, i]
    for other in range(2):
        for j in range(NODES):
            if other != side or j != i:
                weight *= offset - w.offsets[n, other, j]
    return weight


@stage
def interpolate(
    c: Chart, w: Windows, n: int, target: FloatArray, speeds: FloatArray, last: InfluencePosition,
    to: InfluencePosition, room: InfluenceScratch
) -> bool:  # fmt: skip
    """Interpolate all variables, their velocities, and accelerations (without the terms of s'') in a window.

    Returns false if an interpolation position is not found or is near another change point; then `room.weak[2]` is
    TOGETHER and `to` is at the edge.
    """
    offset, size, allowed = offset_of(w, n, target), target.shape[0], room.weak[1]
    least = math.inf
    w.total[:, :] = 0.0
    room.weak[1] = FLOOR * w.weakest[n]
    for side in range(2):
        move_to_edge(w, n, side, last)
        for j in range(NODES):
            for k in range(size):
                w.target[k] = target[k] + (w.offsets[n, side, j] - offset) * w.normal[n, k]
            if not follow(c, last, to, w.target, speeds, room):
                for k in range(size):
                    w.target[k] = target[k] + (w.offsets[n, side, 0] - offset) * w.normal[n, k]
                move_to_edge(w, n, side, last)
                room.weak[1] = 0.0
                follow(c, last, to, w.target, speeds, room)
                room.weak[1], room.weak[2] = allowed, TOGETHER
                return False
            copy_place(last, to)
            weight = weight_of(w, n, side, j, offset)
            least = min(least, room.weak[0])
            for i in c.unknown:
                w.total[size, i] += weight * to.v[i]
                w.total[size + 1, i] += weight * room.velocity[i]
                w.total[size + 2, i] += weight * room.acceleration[i]
                for k in range(size):
                    w.total[k, i] += weight * to.b[k, i]
    room.weak[0], room.weak[1] = least, allowed
    move_to_edge(w, n, LEFT if offset < 0.0 else RIGHT, to)
    for i in c.unknown:
        to.v[i], room.velocity[i], room.acceleration[i] = w.total[size, i], w.total[size + 1, i], w.total[size + 2, i]
        for k in range(size):
            to.b[k, i] = w.total[k, i]
    for k in range(size):
        to.v[c.independent[k]] = target[k]
    return True
