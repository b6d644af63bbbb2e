"""A motion: finite displacements from the solved start along all the actuators' laws."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembler, Assembly
from gimcli.motion.follow import Follower, Path
from gimcli.motion.inputs import law_inputs, nearest_turns, pace, straight_inputs
from gimcli.solvers.newton import Run
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import residual
from gimcli.structure.steps import Plan

STEPS_A_TURN = 90
"""Rows are solved at least this densely inside, whatever the user asks to see."""


@dataclass(frozen=True)
class Motion:
    """Positions over a motion, in the normal frame."""

    mechanism: Mechanism = field(repr=False)
    plan: Plan = field(repr=False)
    time: FloatArray  # (rows,) 0..1
    inputs: FloatArray  # (actuators, rows)
    z: ComplexArray = field(repr=False)  # (nodes, rows), NaN where not solved
    status: tuple[Status, ...]
    residual: FloatArray
    work: FloatArray  # sweeps or iterations
    worst: str = ""  # the constraint that is worst off where nothing could be assembled
    limit: float | None = None  # time of the limit that was met
    bridged: tuple[float, ...] = ()  # times of the singular positions passed


def plain(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Run a kernel as it stands."""
    return kernel


def start_position(
    mechanism: Mechanism, plan: Plan, inputs: FloatArray, run: Run, tolerance: float
) -> tuple[Assembly, str]:
    """Assemble at given inputs on the branch that is drawn.

    The drawn position is assembled at its own inputs and moved to those asked for; where that
    cannot be done the guess is taken as it is. Returns the worst constraint with a failure.
    """
    assembler = Assembler(mechanism, plan, run, tolerance)
    drawn = np.array([a.drawn for a in mechanism.actuators], dtype=float)
    begin = nearest_turns(mechanism, drawn, inputs)
    if not np.array_equal(begin, inputs):
        first = assembler.assemble(begin, mechanism.drawn)
        if first.status is Status.OK:
            moved = _move(mechanism, plan, first, begin, inputs, run, tolerance)
            if moved is not None:
                return moved, ""
    direct = assembler.assemble(inputs, mechanism.drawn)
    worst = ""
    if direct.status is not Status.OK:
        z = _fallback(direct, mechanism)
        worst = residual(mechanism, z[:, None], inputs[:, None], names=True).worst[0]
    return direct, worst


def _fallback(assembly: Assembly, mechanism: Mechanism) -> ComplexArray:
    z = assembly.row.x + 1j * assembly.row.y
    return np.where(np.isfinite(z), z, mechanism.drawn)


def _move(
    mechanism: Mechanism, plan: Plan, first: Assembly, begin: FloatArray, end: FloatArray, run: Run, tolerance: float
) -> Assembly | None:
    follower = Follower(mechanism, plan, straight_inputs(begin, end), run, tolerance)
    way = pace(mechanism, np.stack([begin, end], axis=1))
    follower.turn = 1.0 / max(way, 1e-3)
    follower.begin(first.row, first.signs)
    path = follower.follow(np.arange(1, (n := max(8, math.ceil(way * STEPS_A_TURN))) + 1) / n)
    if path.limit is not None or path.status[-1] != Status.OK:
        return None
    row = follower.log[-1]
    if row.time != 1.0:
        row = follower._at(1.0)
    row.time = 0.0
    return Assembly(Status.OK, row, follower.sign.copy(), float(path.error[-1]), first.work + float(path.work.sum()))


def trace(mechanism: Mechanism, steps: int, tolerance: float = 1e-10, run: Run = plain) -> Motion:
    """Follow the actuators' laws in `steps` steps."""
    plan = make_plan(mechanism)
    time = np.arange(steps + 1) / steps
    inputs = law_inputs(mechanism)
    values = inputs(time)
    start, worst = start_position(mechanism, plan, values[:, 0], run, tolerance)
    nodes = len(mechanism.nodes)
    z = np.full((nodes, steps + 1), complex(math.nan, math.nan))
    if start.status is not Status.OK:
        status = (start.status, *(Status.LIMIT,) * steps)
        empty = np.full(steps + 1, math.nan)
        return Motion(mechanism, plan, time, values, z, status, empty, np.zeros(steps + 1), worst)
    z[:, 0] = start.row.x + 1j * start.row.y
    path, follower = _along(mechanism, plan, start, inputs, time, run, tolerance)
    z[:, 1:] = path.x + 1j * path.y
    error = residual(mechanism, z, values).total
    statuses = [start.status, *(Status(int(s)) for s in path.status)]
    check = 10.0 * tolerance
    for k in np.flatnonzero(~(error <= check)):
        if statuses[k] is Status.OK:
            statuses[k] = Status.CONTRADICTORY if plan.surplus > 0 else Status.NOT_CONVERGED
    solved = np.array([s is Status.OK for s in statuses])
    z[:, ~solved] = complex(math.nan, math.nan)
    error[~solved] = math.nan
    work = np.concatenate([[start.work], path.work])
    return Motion(
        mechanism, plan, time, values, z, tuple(statuses), error, work, "", path.limit, tuple(path.bridged)
    )


def _along(
    mechanism: Mechanism, plan: Plan, start: Assembly, inputs: Any, time: FloatArray, run: Run, tolerance: float
) -> tuple[Path, Follower]:
    follower = Follower(mechanism, plan, inputs, run, tolerance)
    way = pace(mechanism, inputs(np.linspace(0.0, 1.0, 65)))
    follower.turn = 1.0 / max(way, 1e-3)
    follower.begin(start.row, start.signs)
    steps = len(time) - 1
    parts = max(1, math.ceil(way * STEPS_A_TURN / steps))
    fine = np.arange(1, parts * steps + 1) / (parts * steps)
    fine[parts - 1 :: parts] = time[1:]
    path = follower.follow(fine)
    if parts > 1:
        rows = slice(parts - 1, None, parts)
        work = path.work.reshape(steps, parts).sum(axis=1)
        path = Path(
            path.x[:, rows], path.y[:, rows], path.status[rows], path.error[rows], work, path.bridged, path.limit
        )
    return path, follower
