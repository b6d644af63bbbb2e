"""Solve one position at given inputs, by any method; the start position of a motion.

It is assembled on the drawn branch, then moved to the given inputs.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembler, Assembly
from gimcli.motion.follow import BranchFollower
from gimcli.motion.legs import Leg, dense, straight
from gimcli.motion.side_by_side import machine_inputs, whole_positions
from gimcli.positions.dispatch import choose, gim_work, plan_work
from gimcli.positions.inputs import nearest_turns
from gimcli.positions.newton import Run
from gimcli.positions.options import Options
from gimcli.positions.position import Position
from gimcli.status import Status
from gimcli.structure.drive_check import require_driven_if_doubtful
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import holds, residual
from gimcli.structure.steps import Plan

if TYPE_CHECKING:
    from gimcli.continuation.arc import Gap
    from gimcli.motion.motion_curve import MotionCurve

DRAWN = 1e-12
"""Residual below which the drawn position itself is assembled."""

CLOSE, NEAR = 1e-10, 1e-6
"""Difference from the drawn inputs [rad, or normal length] that is rounding of the coordinates, and the distance of the
nodes from the drawn position, relative to the size, within which the position is then on the drawn branch."""


def start_position(mechanism: Mechanism, plan: Plan, inputs: FloatArray, run: Run, tolerance: float) -> Assembly:
    """Assemble at given inputs (actuators,) on the drawn branch.

    The drawn position is assembled at its own inputs and moved to the given ones, so that the result does not depend on
    their distance. If this fails, the drawing is used as guess at the given inputs. A singular position is also solved
    if the curve of the motion determines it; the motion then continues with an increasing parameter (input value).
    """
    assembler = Assembler(mechanism, plan, run, tolerance)
    begin = nearest_turns(mechanism, mechanism.drawn_inputs, inputs)
    if not np.array_equal(begin, inputs):
        if np.max(np.abs(begin - inputs)) <= CLOSE:
            found = assembler.assemble(inputs, mechanism.drawn)
            if (
                found.regular
                and np.max(mechanism.apart(settled(mechanism, found), mechanism.drawn)) <= NEAR * mechanism.size
            ):
                return found
        leg = straight(mechanism, begin, inputs)
        first = _assembled(assembler, leg)
        moved = _move(mechanism, plan, first, leg, run, tolerance) if first.status is Status.OK else None
        if moved is not None:
            if moved.gap is not None and leg.sense < 0.0:
                moved.gap = moved.gap.mirrored()  # in the sense of increasing parameters
            return moved
    if not len(inputs):
        return assembler.assemble(inputs, mechanism.drawn)
    return _assembled(assembler, straight(mechanism, inputs, inputs))


def _assembled(assembler: Assembler, leg: Leg) -> Assembly:
    """Assemble the drawn position at the start of a leg; if it is singular, on the curve of the leg."""
    mechanism, at = assembler.mechanism, leg.sense * leg.begin
    found = assembler.assemble(leg.inputs(np.array([at]))[:, 0], mechanism.drawn, at)
    if found.status is not Status.SINGULAR:
        return found
    from gimcli.structure.tangency import tangent_position  # imported only if the position is singular

    drawn, inputs = mechanism.drawn[:, None], leg.inputs(np.array([at]))
    exact = holds(mechanism, drawn, inputs, DRAWN)[0]  # then it is more accurate than the assembled position
    z = mechanism.drawn if exact else settled(mechanism, found)
    tangent = tangent_position(mechanism, z, inputs[:, 0], assembler.accuracy.tolerance)
    if tangent is not None:
        row = replace(found.row, x=tangent.real.copy(), y=tangent.imag.copy())
        return replace(found, status=Status.TANGENT, row=row)
    gap = _motion_curve(leg, assembler).around(z, at, leg.sense)
    return found if gap is None else on_gap(gap, found)


def settled(mechanism: Mechanism, found: Assembly) -> ComplexArray:
    """Return the positions (nodes,) of an assembly; nodes that were not placed are as drawn."""
    z = found.row.x + 1j * found.row.y
    return np.where(np.isfinite(z), z, mechanism.drawn)


def on_gap(gap: Gap, found: Assembly) -> Assembly:
    """Return an assembly at the interpolated position of a gap."""
    row = gap.at(found.row.time)
    return Assembly(Status.OK, row, found.signs, row.error, found.work, found.surplus, gap)


def random_guess(mechanism: Mechanism, seed: int) -> ComplexArray:
    """Return random positions (nodes,), uniform in a square of twice the size around the frame; the frame is kept."""
    generator = np.random.default_rng(seed)
    fixed = list(mechanism.members[FRAME].nodes)
    centre = mechanism.centre if fixed else mechanism.drawn.mean()
    near = [n for n in range(len(mechanism.nodes)) if n not in mechanism.remote]
    spread = generator.uniform(-1.0, 1.0, (2, len(near))) * mechanism.size
    guess = mechanism.drawn.copy()
    guess[near] = centre + spread[0] + 1j * spread[1]
    guess[fixed] = mechanism.drawn[fixed]
    return np.asarray(guess)


def moved(
    mechanism: Mechanism, plan: Plan, z: ComplexArray, begin: FloatArray, end: FloatArray, run: Run, tolerance: float
) -> ComplexArray | None:
    """Return the positions (nodes,) after a linear change of the inputs from an assembled position; None if blocked."""
    leg = straight(mechanism, begin, end)
    first = Assembler(mechanism, plan, run, tolerance).assemble(begin, z, leg.sense * leg.begin)
    there = _move(mechanism, plan, first, leg, run, tolerance) if first.status is Status.OK else None
    return None if there is None else np.asarray(there.row.x + 1j * there.row.y)


def _motion_curve(leg: Leg, assembler: Assembler) -> MotionCurve:
    from gimcli.motion.motion_curve import MotionCurve  # imported only if a row is doubtful

    return MotionCurve(leg.line, assembler)


def follower_of(mechanism: Mechanism, plan: Plan, leg: Leg, run: Run, tolerance: float) -> BranchFollower:
    """Return the follower of a leg."""
    motion_curve = partial(_motion_curve, leg, Assembler(mechanism, plan, run, tolerance))
    follower = BranchFollower(mechanism, plan, leg.inputs, run, tolerance, motion_curve)
    follower.turn, follower.sense = leg.turn, leg.sense
    return follower


def _move(mechanism: Mechanism, plan: Plan, first: Assembly, leg: Leg, run: Run, tolerance: float) -> Assembly | None:
    """Return the assembly at the end of a leg; None if the motion is blocked before."""
    follower = follower_of(mechanism, plan, leg, run, tolerance)
    if first.gap is None:
        follower.begin(first.row, first.signs)
    elif not follower.enter(first.gap):
        return None
    grid, _ = dense(leg.sense * leg.begin, np.array([leg.goal]), leg.turn, 8)
    path = follower.run_to(grid)
    if path.codes[-1] != Status.OK:
        return None
    row = follower.at(leg.goal)
    work = first.work + float(path.work.sum())
    gap = follower.gap_at(leg.goal)
    return Assembly(Status.OK, row, follower.sign.copy(), row.error, work, first.surplus, gap, came=True)


def solve(mechanism: Mechanism, inputs: FloatArray, options: Options, history: bool = False) -> Position:
    """Solve the position problem at inputs (actuators,); history: keep the errors of the sweeps (method gim).

    Raises StructureError if the mechanism is over-driven or not fully driven.
    """
    if len(mechanism.machines) > 1 and not (history or options.moves):
        return _of_machines(mechanism, inputs, options)
    guess = mechanism.drawn if options.seed is None else random_guess(mechanism, options.seed)
    if options.method == "gim":
        return _by_sweeps(mechanism, inputs, guess, options, history)
    plan = make_plan(mechanism, closed_forms=options.method == "auto")
    run = choose(options.jit, plan_work(plan, 50))
    if options.seed is None:
        found = start_position(mechanism, plan, inputs, run, options.tolerance)
    else:
        found = Assembler(mechanism, plan, run, options.tolerance, anywhere=True).assemble(inputs, guess)
    require_driven_if_doubtful(mechanism, plan, found.regular)
    failed = Status.CONTRADICTORY if found.surplus else Status.NOT_CONVERGED
    return _checked(mechanism, inputs, found.row.x + 1j * found.row.y, found.status, failed, options, int(found.work))


def _of_machines(mechanism: Mechanism, inputs: FloatArray, options: Options) -> Position:
    """Return the positions of all machines as one, with the worst status and the greatest errors."""
    found = [
        solve(one.mechanism, machine_inputs(mechanism, one, inputs), options) for one in mechanism.machines
    ]  # fmt: skip
    worst = max(found, key=lambda one: (one.status, one.residual.total[0]))
    z = whole_positions(mechanism, [one.z for one in found])
    known = whole_positions(mechanism, [one.z * (1.0 if one.status.solved else np.nan) for one in found])
    sweeps = sum(one.sweeps for one in found)
    return Position(mechanism, inputs, z, worst.status, worst.residual, sweeps, None, options, known)


def _checked(
    mechanism: Mechanism, inputs: FloatArray, z: ComplexArray, status: Status, failed: Status, options: Options,
    sweeps: int, history: FloatArray | None = None,
) -> Position:  # fmt: skip
    """Return a solution z (nodes,) as a position; its status is `failed` if an independent check fails."""
    check = residual(mechanism, z[:, None], inputs[:, None], names=True)
    swept = options.method == "gim"
    if status is Status.OK and not holds(mechanism, z[:, None], inputs[:, None], options.tolerance, swept, check.total):
        status = failed
    return Position(mechanism, inputs, z, status, check, sweeps, history, options)


def _by_sweeps(
    mechanism: Mechanism, inputs: FloatArray, guess: ComplexArray, options: Options, history: bool
) -> Position:
    from gimcli.gim.sweeper import Sweeper

    sweeper = Sweeper(mechanism, options, choose(options.jit, 0.0))
    sweeper.run = choose(options.jit, gim_work(len(sweeper.moves), 10))
    done = sweeper.settle(inputs, guess, options.sweeps + 1 if history else 0)
    require_driven_if_doubtful(mechanism, sweeper.plan, done.good)
    failed = Status.CONTRADICTORY if sweeper.plan.surplus > 0 else Status.JUMPED
    kept = done.history if history else None
    return _checked(mechanism, inputs, done.z, done.status, failed, options, done.sweeps, kept)
