"""Solve a whole motion in one call: the steps of a plan over blocks of rows that fit into the processor cache."""

from __future__ import annotations

from typing import NamedTuple

from gimcli.kernels.jit import kernel, stage, stub
from gimcli.kernels.newton import LAST_SIGN, GroupArrays, RowPosition, StopLimits, solve_group
from gimcli.kernels.plan_steps import (
    COUPLED,
    ERROR,
    HISTORY,
    ROWS,
    TIME,
    WIDTH,
    WORK,
    WORST,
    Lanes,
    Program,
    check,
    fill,
    guard,
    load_inputs,
    place,
)
from gimcli.mechanism import FloatArray, IntArray

KEPT = 2048
"""Number of rows after which the last rows are saved as a restart point."""


class Groups(NamedTuple):
    """The coupled groups of a plan: the arrays of `GroupArrays`, concatenated over all groups."""

    gi: IntArray  # (groups, 11) base, rows, turning, then first and end of nodes, vectors, places, equations
    nodes: IntArray
    vi: IntArray
    vz: FloatArray
    pi: IntArray
    ei: IntArray
    ev: FloatArray


class Rows(NamedTuple):
    """Arguments (time, values) and results (all others) of a motion."""

    time: FloatArray  # (rows,)
    values: FloatArray  # (actuators, rows) inputs
    z: FloatArray  # (nodes, rows, 2)
    residual: FloatArray  # (rows,)
    work: FloatArray  # (rows,) iterations
    kept: FloatArray  # (entries, lanes) saved rows: a ring buffer
    mark: IntArray  # (2,) entries written to the ring buffer, rows since the last one


@kernel
def group_at(groups: Groups, k: int) -> GroupArrays:
    """Return coupled group k."""
    gi, nodes, vi, vz, pi, ei, ev = groups
    return GroupArrays(
        gi[k, 0], gi[k, 1], gi[k, 2] != 0, nodes[gi[k, 3] : gi[k, 4]], vi[gi[k, 5] : gi[k, 6]],
        vz[gi[k, 5] : gi[k, 6]], pi[gi[k, 7] : gi[k, 8]], ei[gi[k, 9] : gi[k, 10]], ev[gi[k, 9] : gi[k, 10]],
    )  # fmt: skip


@stage
def solve_group_rows(
    lanes: FloatArray, group: GroupArrays, at: Lanes, sign: float, room: RowPosition, limits: StopLimits, high: int
) -> int:
    """Solve a coupled group in all rows; return the first row that was not solved reliably."""
    return solve_group(
        lanes[at.x : at.y], lanes[at.y : at.rx], lanes[at.rx : at.ry], lanes[at.ry : at.values],
        lanes[at.values : at.cos], lanes[at.cos : at.sin], lanes[at.sin : at.g], lanes[TIME], HISTORY, high,
        group, room, sign, limits, lanes[WORK], lanes[ERROR], True,
    )  # fmt: skip


@stub(solve_group_rows, "dyads")
def no_group_rows(
    lanes: FloatArray, group: GroupArrays, at: Lanes, sign: float, room: RowPosition, limits: StopLimits, high: int
) -> int:
    """Replace `solve_group_rows` where there is no coupled group."""
    return high


@stage
def begin(w: FloatArray, lanes: FloatArray, at: Lanes, rows: Rows, done: int, count: int) -> None:
    """Copy the times and inputs of the next rows into their lanes, and clear errors and iterations."""
    time, new = lanes[TIME], rows.time[done : done + count]
    for k in range(count):
        time[HISTORY + k] = new[k]
    fill(w, ERROR, 0.0, WIDTH)
    fill(w, WORK, 0.0, WIDTH)
    load_inputs(w, at, rows.values, done, HISTORY + count)


@stage
def finish(lanes: FloatArray, at: Lanes, rows: Rows, done: int, solved: int, iterates: bool) -> None:
    """Copy the solved rows to the results, and the last HISTORY rows to the start of the lanes."""
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
    """Save the last rows as a restart point, every KEPT rows or if forced."""
    rows.mark[1] += solved
    if force or rows.mark[1] >= KEPT:
        rows.mark[1] = 0
        for r in range(HISTORY):
            entry = rows.mark[0] % rows.kept.shape[0]
            for lane in range(lanes.shape[0]):
                rows.kept[entry, lane] = lanes[lane, r]
            rows.mark[0] += 1


@stage
def solve_steps(
    w: FloatArray, lanes: FloatArray, q: Program, groups: Groups, at: Lanes, sign: FloatArray, determinant: FloatArray,
    room: RowPosition, limits: StopLimits, tolerance: float, followed: bool, high: int,
) -> tuple[int, int]:  # fmt: skip
    """Execute all steps for the new rows and check them; return the first row not solved reliably, and the last step.

    `determinant` (groups,) is updated. followed: see `guard`.
    """
    k = -1
    while k + 1 < q.steps.shape[0] and high > HISTORY:
        k += 1
        if q.steps[k, 0] == COUPLED:
            n = q.steps[k, 2]
            high = solve_group_rows(lanes, group_at(groups, n), at, determinant[n], room, limits, high)
            determinant[n] = room.out[LAST_SIGN]
        elif place(w, q, at, k, sign, high):
            high = guard(w, q, at, k, tolerance, followed, high)
    check(w, q, at, high)
    return high, k


@kernel
def march(
    w: FloatArray, lanes: FloatArray, q: Program, groups: Groups, at: Lanes, rows: Rows, first: int,
    sign: FloatArray, determinant: FloatArray, room: RowPosition, limits: StopLimits, tolerance: float,
) -> int:  # fmt: skip
    """Solve rows from `first` on until one is doubtful; return the number of solved rows.

    w and lanes (lanes, WIDTH) are views of the same memory. Their first HISTORY rows are the last solved ones; a time
    of -inf marks a row that does not exist.
    """
    total, done = rows.time.shape[0], first
    while done < total:
        count = min(ROWS, total - done)
        begin(w, lanes, at, rows, done, count)
        high, _ = solve_steps(
            w, lanes, q, groups, at, sign, determinant, room, limits, tolerance, True, HISTORY + count
        )
        solved = high - HISTORY
        finish(lanes, at, rows, done, solved, groups.gi.shape[0] > 0)
        done += solved
        keep(lanes, rows, solved, solved < count or done == total)
        if solved < count:
            break
    return done - first
