"""Newton-Raphson in absolute, joint or natural coordinates, row after row of a motion.

The textbook iteration: every row starts from the row before it and ends when no correction exceeds the tolerance. If
there are more equations than unknowns, they are solved in the least-squares sense.

Source: Garcia de Jalon & Bayo 1994, section 3.2; Fraczek & Wojtyra, lecture notes on multibody methods.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gimcli.kernels.bodies import absolute_rows, joint_rows, pair_rows, place_bodies, place_tree
from gimcli.kernels.jit import kernel
from gimcli.kernels.linear import lu_factor, lu_solve, qr_factor, qr_solve
from gimcli.kernels.points import move_points, point_rows
from gimcli.kernels.vector import copy
from gimcli.mechanism import FloatArray, IntArray


class CoordinateScratch(NamedTuple):
    """Scratch arrays (kernels allocate no memory)."""

    j: FloatArray  # (equations, unknowns) gradients, then their factors
    f: FloatArray  # (equations,)
    order: FloatArray  # (2 unknowns,) of the factors
    last: FloatArray  # (unknowns,) at the last solved row
    g: FloatArray  # (equations, 6) partial derivatives by two bodies
    gb: IntArray  # (equations, 2) numbers of these bodies
    v: FloatArray  # (unknowns, 3) rotations and translations of the joint variables


def room(equations: int, unknowns: int) -> CoordinateScratch:
    """Return scratch arrays for a system."""
    return CoordinateScratch(
        np.zeros((equations, unknowns)), np.zeros(equations), np.zeros(2 * unknowns), np.zeros(unknowns),
        np.zeros((equations, 6)), np.zeros((equations, 2), dtype=np.int64), np.zeros((unknowns, 3)),
    )  # fmt: skip


@kernel
def correct(q: FloatArray, j: FloatArray, f: FloatArray, order: FloatArray, weight: FloatArray) -> float:
    """Correct the unknowns once; return the greatest weighted correction, infinite if the system is singular."""
    m, n = j.shape
    if m < n:
        return math.inf
    regular = lu_factor(j, n, order) if m == n else qr_factor(j, m, n, order)
    if regular == 0.0:
        return math.inf
    if m == n:
        lu_solve(j, n, order, f)
    else:
        qr_solve(j, m, n, order, f)
    worst = 0.0
    for k in range(n):
        q[k] -= f[k]
        step = abs(f[k]) * weight[k]
        if not step <= worst:  # a NaN is kept
            worst = step
    return worst if math.isfinite(worst) else math.inf


@kernel
def gradients(
    q: FloatArray, values: FloatArray, bi: IntArray, pi: IntArray, pz: FloatArray, ji: IntArray, jz: FloatArray,
    above: IntArray, room: CoordinateScratch, pose: FloatArray,
) -> None:  # fmt: skip
    """Compute the poses (bodies, 5), the residuals and their gradients at q; see `follow_bodies`."""
    if ji.shape[0] > 0:
        place_tree(q, values, ji, jz, pose, room.v)
    else:
        place_bodies(q, bi, pose)
    pair_rows(values, pi, pz, pose, room.f, room.g, room.gb)
    if ji.shape[0] > 0:
        joint_rows(room.g, room.gb, ji, above, pose, room.v, room.j)
    else:
        absolute_rows(room.g, room.gb, bi, room.j)


@kernel
def follow_bodies(
    q: FloatArray, values: FloatArray, bi: IntArray, pi: IntArray, pz: FloatArray, ji: IntArray, jz: FloatArray,
    above: IntArray, room: CoordinateScratch, weight: FloatArray, tolerance: float, most: int, pose: FloatArray,
    iterations: FloatArray, good: FloatArray,
) -> None:  # fmt: skip
    """Solve a motion in joint coordinates if there are joints, else in absolute coordinates.

    q (unknowns,): start position. values (rows, actuators): inputs. Results: pose (rows, bodies, 5), iterations (rows,)
    and good (rows,). After a row that fails, the next one starts from the last solved row.
    """
    j, f, order, last, v = room.j, room.f, room.order, room.last, room.v
    copy(last, q)
    for r in range(values.shape[0]):
        copy(q, last)
        done, step = 0, math.inf
        while done < most and step > tolerance:
            gradients(q, values[r], bi, pi, pz, ji, jz, above, room, pose[r])
            step = correct(q, j, f, order, weight)
            done += 1
            if step == math.inf:
                break
        iterations[r] = done
        good[r] = 1.0 if step <= tolerance else 0.0
        if step <= tolerance:
            copy(last, q)
            if ji.shape[0] > 0:
                place_tree(q, values[r], ji, jz, pose[r], v)
            else:
                place_bodies(q, bi, pose[r])


@kernel
def follow_points(
    q: FloatArray, values: FloatArray, cos: FloatArray, sin: FloatArray, ei: IntArray, ez: FloatArray, col: IntArray,
    room: CoordinateScratch, weight: FloatArray, tolerance: float, most: int, x: FloatArray, y: FloatArray,
    iterations: FloatArray, good: FloatArray,
) -> None:  # fmt: skip
    """Solve a motion in natural coordinates, like `follow_bodies`; results: x, y (rows, nodes), iterations, good.

    cos, sin (rows, actuators): of the inputs.
    """
    j, f, order, last = room.j, room.f, room.order, room.last
    copy(last, q)
    for r in range(values.shape[0]):
        copy(q, last)
        done, step = 0, math.inf
        while done < most and step > tolerance:
            move_points(q, col, x[r], y[r])
            point_rows(x[r], y[r], values[r], cos[r], sin[r], ei, ez, col, f, j)
            step = correct(q, j, f, order, weight)
            done += 1
            if step == math.inf:
                break
        iterations[r] = done
        good[r] = 1.0 if step <= tolerance else 0.0
        if step <= tolerance:
            copy(last, q)
            move_points(q, col, x[r], y[r])
