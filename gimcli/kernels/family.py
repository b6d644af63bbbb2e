"""Follow the motions of many designs under one plan: the start of each, its rows, and where and why it ends.

Each design starts from the nominal start position. If its own start is not found directly, the numbers of the plan
are changed from the nominal ones in steps. A row that is doubtful is approached in smaller steps. Where these become
too small, the motion has reached a limit if the square of the half distance between the two intersections of a dyad
(or the squared determinant of a coupled group) falls linearly to 0; otherwise the design is left to the solver of
single motions. The kernels of this module are always compiled.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gimcli.kernels.jit import kernel, stage
from gimcli.kernels.march import Groups, Rows, begin, group_at, solve_steps
from gimcli.kernels.newton import RowPosition, StopLimits, read_row, volume_at
from gimcli.kernels.plan_steps import (
    COUPLED,
    HISTORY,
    NOISE,
    ROWS,
    SQUARE,
    TIME,
    WORST,
    Lanes,
    Program,
    place,
)
from gimcli.kernels.vector import copy
from gimcli.mechanism import FloatArray, IntArray

FINE = 2.0**-12
"""Step of an approach, relative to the distance of two rows, below which it is examined for a limit."""

FINEST = 2.0**-48
"""Least step: a row may be this close to a limit."""

BEYOND = 6
"""Number of attempts to find a row beyond a limit, each at twice the distance."""

PATH_FINEST = 2.0**-10
"""Least step of the change of the dimensions from the nominal design."""

ATTEMPTS = 400
"""Number of single rows tried for one design, after which it is left to the solver of single motions."""

LONGEST = 2.0 * math.pi / 72.0 * (1.0 + 1e-9)
"""Greatest step of an input between two rows [rad, or sizes of the mechanism]."""

SOLVED, NO_START, AT_LIMIT, CONTRADICTS, CAREFUL = range(5)
"""Outcome of a design: all rows, no start position, rows up to a limit, contradictory constraints, left to others."""


class Tables(NamedTuple):
    """The numbers of a plan for each design; see `families.float_tables`."""

    vz: FloatArray  # (designs, vectors, 2)
    lv: FloatArray  # (designs, loci, 2)
    cv: FloatArray  # (designs, checks, 2)
    reach: FloatArray  # (designs, steps)
    gvz: FloatArray  # (designs, vectors of groups, 2)
    gev: FloatArray  # (designs, equations of groups, 2)
    frame: FloatArray  # (designs, nodes, 2)


class Nominal(NamedTuple):
    """The nominal design: its program, groups and tables (one design), and its solved rows."""

    q: Program
    groups: Groups
    tables: Tables
    held: IntArray  # (frame nodes,)
    rows: FloatArray  # (rows, lanes) lanes of the solved rows; NaN where not solved
    sign: FloatArray  # (branches,)
    determinant: FloatArray  # (groups,)
    scales: FloatArray  # (actuators,) change of an input that counts as 1 rad
    surplus: bool


class RowSolver(NamedTuple):
    """What the solution of rows needs beside program and lanes."""

    room: RowPosition
    limits: StopLimits
    tolerance: float  # of the nodes
    enough: float  # greatest residual of a solved row


class Room(NamedTuple):
    """Scratch arrays for one design."""

    w: FloatArray  # (lanes x WIDTH,)
    lanes: FloatArray  # (lanes, WIDTH) a view of w
    mixed: Tables  # of one design
    determinant: FloatArray  # (groups,)
    note: IntArray  # (2,) the step that was doubtful, and the number of attempts


class FamilyRows(NamedTuple):
    """Results."""

    z: FloatArray  # (designs, nodes, kept rows, 2)
    residual: FloatArray  # (designs, kept rows)
    place: IntArray  # (rows,) number of the kept row, -1 for rows in between
    outcome: IntArray  # (designs,)
    first: IntArray  # (designs,) first solved row
    end: IntArray  # (designs,) end of the solved rows


@kernel
def program_of(q: Program, t: Tables, d: int) -> Program:
    """Return the program of design d."""
    return Program(q.steps, t.reach[d], q.vi, t.vz[d], q.li, t.lv[d], q.ci, t.cv[d], q.size)


@kernel
def groups_of(g: Groups, t: Tables, d: int) -> Groups:
    """Return the coupled groups of design d."""
    return Groups(g.gi, g.nodes, g.vi, t.gvz[d], g.pi, g.ei, t.gev[d])


@kernel
def mix(to: FloatArray, one: FloatArray, other: FloatArray, s: float) -> None:
    """Fill an array with (1 - s) one + s other."""
    a, b, c = to.reshape(-1), one.reshape(-1), other.reshape(-1)
    for k in range(len(a)):
        a[k] = (1.0 - s) * b[k] + s * c[k]


@stage
def mix_tables(to: Tables, one: Tables, other: Tables, d: int, s: float) -> None:
    """Fill the tables of one design between the nominal ones (s = 0) and those of design d (s = 1)."""
    mix(to.vz[0], one.vz[0], other.vz[d], s)
    mix(to.lv[0], one.lv[0], other.lv[d], s)
    mix(to.cv[0], one.cv[0], other.cv[d], s)
    mix(to.reach[0], one.reach[0], other.reach[d], s)
    mix(to.gvz[0], one.gvz[0], other.gvz[d], s)
    mix(to.gev[0], one.gev[0], other.gev[d], s)
    mix(to.frame[0], one.frame[0], other.frame[d], s)


@stage
def advance(
    room: Room, q: Program, groups: Groups, at: Lanes, sign: FloatArray, solver: RowSolver, count: int, followed: bool
) -> int:
    """Solve `count` rows whose times and inputs are in the lanes; return how many are solved and not doubtful."""
    high, room.note[0] = solve_steps(
        room.w, room.lanes, q, groups, at, sign, room.determinant, solver.room, solver.limits, solver.tolerance,
        followed, HISTORY + count,
    )  # fmt: skip
    room.note[1] += 1
    return high - HISTORY


@stage
def hold_frame(lanes: FloatArray, at: Lanes, held: IntArray, frame: FloatArray, first: int, high: int) -> None:
    """Set the nodes of the frame in rows first..high."""
    for n in range(len(held)):
        node = held[n]
        lanes[at.x + node, first:high], lanes[at.y + node, first:high] = frame[node, 0], frame[node, 1]


@stage
def begin_from(lanes: FloatArray, row: FloatArray, time: float) -> None:
    """Make a row (lanes,) the only solved one."""
    for k in range(lanes.shape[0]):
        lanes[k, :HISTORY] = row[k]
    lanes[TIME, :HISTORY] = -math.inf
    lanes[TIME, HISTORY - 1] = time


@stage
def accept(lanes: FloatArray, count: int) -> None:
    """Copy the last solved rows, of which `count` are new, to the start of the lanes."""
    for k in range(lanes.shape[0]):
        for r in range(HISTORY):
            lanes[k, r] = lanes[k, count + r]


@stage
def write(lanes: FloatArray, at: Lanes, found: FamilyRows, d: int, row: int, count: int) -> None:
    """Copy `count` solved rows to the results of design d from `row` on, without those in between."""
    place = found.place
    for node in range(found.z.shape[1]):
        x, y, z = lanes[at.x + node], lanes[at.y + node], found.z[d, node]
        for k in range(count):
            if place[row + k] >= 0:
                z[place[row + k], 0] = x[HISTORY + k]
                z[place[row + k], 1] = y[HISTORY + k]
    worst, residual = lanes[WORST], found.residual[d]
    for k in range(count):
        if place[row + k] >= 0:
            residual[place[row + k]] = worst[HISTORY + k]


@stage
def try_row(
    room: Room, q: Program, groups: Groups, at: Lanes, nominal: Nominal, frame: FloatArray, solver: RowSolver,
    rows: Rows, row: int, followed: bool,
) -> bool:  # fmt: skip
    """Solve one row; return whether it is solved and not doubtful."""
    begin(room.w, room.lanes, at, rows, row, 1)
    hold_frame(room.lanes, at, nominal.held, frame, HISTORY, HISTORY + 1)
    return advance(room, q, groups, at, nominal.sign, solver, 1, followed) == 1


@stage
def start_dyads(
    room: Room, at: Lanes, nominal: Nominal, tables: Tables, d: int, solver: RowSolver, rows: Rows, row: int
) -> int:
    """Solve row `row` of design d of a plan without coupled groups: the branch signs determine it."""
    q, groups = program_of(nominal.q, tables, d), groups_of(nominal.groups, tables, d)
    begin(room.w, room.lanes, at, rows, row, 1)
    hold_frame(room.lanes, at, nominal.held, tables.frame[d], HISTORY, HISTORY + 1)
    for k in range(q.steps.shape[0]):  # whether they have a solution or not
        place(room.w, q, at, k, nominal.sign, HISTORY + 1)
    begin_from(room.lanes, room.lanes[:, HISTORY], rows.time[row])
    if advance(room, q, groups, at, nominal.sign, solver, 1, False) == 1:
        return SOLVED
    return NO_START if room.lanes[SQUARE, HISTORY] < -room.lanes[NOISE, HISTORY] else CAREFUL


@stage
def start_by_steps(
    room: Room, at: Lanes, nominal: Nominal, tables: Tables, d: int, solver: RowSolver, rows: Rows, row: int, k: int,
    one: Rows,
) -> int:  # fmt: skip
    """Solve row `row` of design d from row k of the nominal design, of the same time, along a path in numbers."""
    lanes, origin = room.lanes, nominal.rows[k]
    begin_from(lanes, origin, 0.0)
    copy(room.determinant, nominal.determinant)
    s, h = 0.0, 1.0
    while s < 1.0:
        to = min(s + h, 1.0)
        mix_tables(room.mixed, nominal.tables, tables, d, to)
        one.time[0] = to
        for k in range(one.values.shape[0]):
            one.values[k, 0] = (1.0 - to) * origin[at.values + k] + to * rows.values[k, row]
        q, groups = program_of(nominal.q, room.mixed, 0), groups_of(nominal.groups, room.mixed, 0)
        if try_row(room, q, groups, at, nominal, room.mixed.frame[0], solver, one, 0, s > 0.0):
            if to == 1.0:
                return SOLVED
            accept(lanes, 1)
            s, h = to, 2.0 * h
        else:
            h *= 0.5
            if h < PATH_FINEST:
                return NO_START
    return SOLVED


@stage
def start(
    room: Room, at: Lanes, nominal: Nominal, tables: Tables, d: int, solver: RowSolver, rows: Rows, row: int, k: int,
    one: Rows,
) -> int:  # fmt: skip
    """Solve row `row` of design d; return SOLVED, NO_START or CAREFUL; `one` is scratch for one row."""
    if nominal.groups.gi.shape[0] > 0:
        return start_by_steps(room, at, nominal, tables, d, solver, rows, row, k, one)
    return start_dyads(room, at, nominal, tables, d, solver, rows, row)


@stage
def falls_to_zero(t: tuple[float, float, float], v: tuple[float, float, float]) -> bool:
    """Return whether values v at times t, of which the last is negative, fall linearly through 0."""
    before = (v[1] - v[0]) / (t[1] - t[0])
    after = (v[2] - v[1]) / (t[2] - t[1])
    return before < 0.0 and after < 0.0 and 0.25 * before >= after >= 4.0 * before  # NaN: false


@stage
def ends(room: Room, q: Program, groups: Groups, at: Lanes, solver: RowSolver) -> bool:
    """Return whether the motion has reached a limit between the last solved row and the one that was just tried."""
    lanes, k = room.lanes, room.note[0]
    time = lanes[TIME]
    r = HISTORY
    if q.steps[k, 0] != COUPLED:
        g2 = lanes[SQUARE]
        if not g2[r] < -lanes[NOISE, r]:
            return False
        return falls_to_zero((time[r - 2], time[r - 1], time[r]), (g2[r - 2], g2[r - 1], g2[r]))
    group, s = group_at(groups, q.steps[k, 2]), solver.room
    x, y, rx, ry = lanes[at.x : at.y], lanes[at.y : at.rx], lanes[at.rx : at.ry], lanes[at.ry : at.values]
    values, cos, sin = lanes[at.values : at.cos], lanes[at.cos : at.sin], lanes[at.sin : at.g]
    v0, v1, v2 = 0.0, 0.0, 0.0
    for back in range(3):
        read_row(x, y, rx, ry, values, cos, sin, r - 3 + back, group, s)
        v0, v1, v2 = v1, v2, volume_at(x, y, r - 3 + back, group, s)
    t0, t1, t2 = time[r - 3], time[r - 2], time[r - 1]
    ahead = (t2 - t1) / (t1 - t0)
    square, straight = v1 * v1 + ahead * (v1 * v1 - v0 * v0), v1 + ahead * (v1 - v0)
    fold = abs(square - v2 * v2) <= abs(straight * straight - v2 * v2)
    return v2 < v1 < v0 and fold  # NaN: false


@kernel
def set_row(one: Rows, rows: Rows, row: int, part: float) -> None:
    """Set time and inputs between the row before `row` (part 0) and the row itself (part 1)."""
    a, b = rows.time[row - 1], rows.time[row]
    one.time[0] = b if part == 1.0 else a + part * (b - a)
    for k in range(one.values.shape[0]):
        a, b = rows.values[k, row - 1], rows.values[k, row]
        one.values[k, 0] = b if part == 1.0 else a + part * (b - a)


@stage
def approach(
    room: Room, q: Program, groups: Groups, at: Lanes, nominal: Nominal, frame: FloatArray, solver: RowSolver,
    rows: Rows, row: int, one: Rows, parts: float,
) -> int:  # fmt: skip
    """Solve one row in smaller steps from the row before it; return SOLVED, AT_LIMIT or CAREFUL."""
    lanes = room.lanes
    s, h = 0.0, 1.0 / parts
    while True:
        to = s + h
        if to > 1.0 - 0.25 * FINEST:
            to = 1.0
        set_row(one, rows, row, to)
        if try_row(room, q, groups, at, nominal, frame, solver, one, 0, True):
            if to == 1.0:
                return SOLVED
            accept(lanes, 1)
            s, h = to, min(2.0 * h, 1.0 / parts)
        else:
            if h < 2.0 * FINE and ends(room, q, groups, at, solver):
                return AT_LIMIT
            if h < 2.0 * FINEST:
                break
            h *= 0.5
        if room.note[1] > ATTEMPTS * rows.time.shape[0]:
            return CAREFUL
    for _ in range(BEYOND):  # a row just before a limit is doubtful too: find one beyond it
        if ends(room, q, groups, at, solver):
            return AT_LIMIT
        h *= 2.0
        set_row(one, rows, row, min(s + h, 1.0))
        if try_row(room, q, groups, at, nominal, frame, solver, one, 0, True):
            break
    return CAREFUL


@kernel
def parts_of(rows: Rows, row: int, scales: FloatArray) -> float:
    """Return the number of steps from the row before, so that none is longer than LONGEST."""
    most = 1.0
    for k in range(rows.values.shape[0]):
        most = max(most, math.ceil(abs(rows.values[k, row] - rows.values[k, row - 1]) / (scales[k] * LONGEST)))
    return most


@stage
def follow(
    room: Room, q: Program, groups: Groups, at: Lanes, nominal: Nominal, frame: FloatArray, solver: RowSolver,
    rows: Rows, first: int, one: Rows, found: FamilyRows, d: int,
) -> int:  # fmt: skip
    """Solve the rows after the solved row `first`; set `found.end` and return the outcome."""
    lanes, total = room.lanes, rows.time.shape[0]
    i = first + 1
    outcome = SOLVED
    while i < total:
        run = 0
        while run < ROWS and i + run < total and parts_of(rows, i + run, nominal.scales) == 1.0:
            run += 1
        solved = 0
        if run > 0:
            begin(room.w, lanes, at, rows, i, run)
            hold_frame(lanes, at, nominal.held, frame, HISTORY, HISTORY + run)
            solved = advance(room, q, groups, at, nominal.sign, solver, run, True)
            write(lanes, at, found, d, i, solved)
            accept(lanes, solved)
            i += solved
        if solved == run and i < total:
            run = 0  # the next row needs several steps
        if i < total and (run == 0 or solved < run):
            outcome = approach(
                room, q, groups, at, nominal, frame, solver, rows, i, one, parts_of(rows, i, nominal.scales)
            )
            if outcome != SOLVED:
                break
            write(lanes, at, found, d, i, 1)
            accept(lanes, 1)
            i += 1
    found.end[d] = i
    return outcome


@stage
def judged(found: FamilyRows, d: int, outcome: int, surplus: bool, enough: float) -> int:
    """Return the outcome of a design after the check of all its rows."""
    for r in range(found.first[d], found.end[d]):
        if found.place[r] >= 0 and not found.residual[d, found.place[r]] <= enough:
            found.end[d] = r
            return CONTRADICTS if surplus and r == found.first[d] else CAREFUL
    return outcome


@kernel
def family(
    nominal: Nominal, at: Lanes, tables: Tables, time: FloatArray, inputs: FloatArray, room: Room, solver: RowSolver,
    one: Rows, found: FamilyRows, first: int, end: int, own: IntArray,
) -> None:  # fmt: skip
    """Follow the motions of designs first..end; inputs (designs or 1, actuators, rows) at times (rows,).

    A design starts at the first row in `own` at which it has a position.
    """
    for d in range(first, end):
        rows = Rows(time, inputs[d if inputs.shape[0] > 1 else 0], one.z, one.residual, one.work, one.kept, one.mark)
        room.note[1] = 0
        k, row, skipped = 0, 0, False
        begun = start(room, at, nominal, tables, d, solver, rows, 0, 0, one)
        while k + 1 < own.shape[0] and (begun == NO_START or (begun == CAREFUL and k > 0)):
            skipped = begun == CAREFUL  # a first position at a dead point does not determine the branch
            k += 1
            row = own[k]
            begun = start(room, at, nominal, tables, d, solver, rows, row, k, one)
        found.first[d] = row
        found.end[d] = row
        if begun != SOLVED:
            found.outcome[d] = begun
            continue
        write(room.lanes, at, found, d, row, 1)
        begin_from(room.lanes, room.lanes[:, HISTORY], time[row])
        q, groups = program_of(nominal.q, tables, d), groups_of(nominal.groups, tables, d)
        outcome = follow(room, q, groups, at, nominal, tables.frame[d], solver, rows, row, one, found, d)
        outcome = judged(found, d, outcome, nominal.surplus, solver.enough)
        found.outcome[d] = CAREFUL if skipped else outcome
