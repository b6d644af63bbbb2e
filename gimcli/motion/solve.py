"""Solve one position at given inputs, by any method."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembler, Assembly
from gimcli.motion.side_by_side import machine_inputs, whole_positions
from gimcli.motion.start import random_guess, start_position
from gimcli.positions.dispatch import choose, gim_work, plan_work
from gimcli.positions.options import Options
from gimcli.positions.position import Position
from gimcli.status import Status
from gimcli.structure.drive_check import require_driven_if_doubtful
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import Residual, holds, residual


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
    return _checked(mechanism, inputs, found, options)


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


def _checked(mechanism: Mechanism, inputs: FloatArray, found: Assembly, options: Options) -> Position:
    z = found.row.x + 1j * found.row.y
    check = residual(mechanism, z[:, None], inputs[:, None], names=True)
    status = found.status
    if status is Status.OK and not _holds(mechanism, z, inputs, options, check):
        status = Status.CONTRADICTORY if found.surplus else Status.NOT_CONVERGED
    return Position(mechanism, inputs, z, status, check, int(found.work), None, options)


def _by_sweeps(
    mechanism: Mechanism, inputs: FloatArray, guess: ComplexArray, options: Options, history: bool
) -> Position:
    from gimcli.gim.sweeper import Sweeper

    sweeper = Sweeper(mechanism, options, choose(options.jit, 0.0))
    sweeper.run = choose(options.jit, gim_work(len(sweeper.moves), 10))
    done = sweeper.settle(inputs, guess, options.sweeps + 1 if history else 0)
    require_driven_if_doubtful(mechanism, sweeper.plan, done.good)
    check = residual(mechanism, done.z[:, None], inputs[:, None], names=True)
    status = done.status
    if done.good and not _holds(mechanism, done.z, inputs, options, check):
        status = Status.CONTRADICTORY if sweeper.plan.surplus > 0 else Status.JUMPED
    return Position(mechanism, inputs, done.z, status, check, done.sweeps, done.history if history else None, options)


def _holds(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, options: Options, check: Residual) -> bool:
    swept = options.method == "gim"
    return bool(holds(mechanism, z[:, None], inputs[:, None], options.tolerance, swept, check.total)[0])
