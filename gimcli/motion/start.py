"""The start of a motion: assembled on the drawn branch, then moved to the inputs asked for."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembler, Assembly
from gimcli.motion.bridge import Bridge, Row
from gimcli.motion.follow import Follower, Foreseen
from gimcli.motion.inputs import nearest_turns, pace, straight_inputs
from gimcli.solvers.newton import Run
from gimcli.status import Status
from gimcli.structure.steps import Plan

STEPS_A_TURN = 90
"""Rows are solved at least this densely inside, whatever the user asks to see."""


def start_position(mechanism: Mechanism, plan: Plan, inputs: FloatArray, run: Run, tolerance: float) -> Assembly:
    """Assemble at given inputs on the branch that is drawn.

    The drawn position is assembled at its own inputs and moved to those asked for, so that the
    result does not depend on how far they are; where that cannot be done, the guess is taken as it is.
    """
    assembler = Assembler(mechanism, plan, run, tolerance)
    begin = nearest_turns(mechanism, drawn_inputs(mechanism), inputs)
    if not np.array_equal(begin, inputs):
        first = assembler.assemble(begin, mechanism.drawn)
        if first.status is Status.OK:
            moved = _move(mechanism, plan, first, begin, inputs, run, tolerance)
            if moved is not None:
                return moved
    return assembler.assemble(inputs, mechanism.drawn)


def leave_singular(follower: Follower, start: Assembly) -> Assembly:
    """Let a motion leave a singular start; return it told from the rows after it, or as it was."""
    mechanism = follower.mechanism
    assembler = Assembler(mechanism, follower.plan, follower.run, follower.accuracy.tolerance)
    position = start.row.x + 1j * start.row.y if start.status is Status.OK else mechanism.drawn
    foreseen = start.foreseen or (lambda inputs: position)  # no motion has led here: the branch on which least moves
    flat = np.flatnonzero(~(start.quality > follower.policy.meeting))

    def branches(inputs: FloatArray, time: float) -> list[tuple[Row, FloatArray]]:
        found = []
        for turn in product((1.0, -1.0), repeat=min(len(flat), 4)):
            signs = start.signs.copy()
            signs[flat[:4]] = turn
            tried = assembler.assemble(inputs, position, time, signs)
            if tried.status is Status.OK:
                found.append((tried.row, signs))
        return found

    if not follower.leave(branches, foreseen):
        return start
    row = follower.at(0.0)
    return Assembly(Status.OK, row, follower.sign.copy(), follower.tolerance, start.work, start.surplus)


def drawn_inputs(mechanism: Mechanism) -> FloatArray:
    """Return the inputs as drawn."""
    return np.array([a.drawn for a in mechanism.actuators], dtype=float)


def random_guess(mechanism: Mechanism, seed: int) -> ComplexArray:
    """Return nodes strewn evenly over a square of twice the size about the frame; the frame stays."""
    generator = np.random.default_rng(seed)
    fixed = list(mechanism.members[FRAME].nodes)
    centre = mechanism.drawn[fixed].mean() if fixed else mechanism.drawn.mean()
    spread = generator.uniform(-1.0, 1.0, (2, len(mechanism.nodes))) * mechanism.size
    guess = centre + spread[0] + 1j * spread[1]
    guess[fixed] = mechanism.drawn[fixed]
    return np.asarray(guess)


def moved(
    mechanism: Mechanism, plan: Plan, z: ComplexArray, begin: FloatArray, end: FloatArray, run: Run, tolerance: float
) -> ComplexArray | None:
    """Return positions (nodes,) after a straight run of the inputs from an assembled one; None where it is stopped."""
    first = Assembler(mechanism, plan, run, tolerance).assemble(begin, z)
    if first.status is not Status.OK:
        return None
    there = _move(mechanism, plan, first, begin, end, run, tolerance)
    return None if there is None else np.asarray(there.row.x + 1j * there.row.y)


def _move(
    mechanism: Mechanism, plan: Plan, first: Assembly, begin: FloatArray, end: FloatArray, run: Run, tolerance: float
) -> Assembly | None:
    follower = Follower(mechanism, plan, straight_inputs(begin, end), run, tolerance)
    way = pace(mechanism, np.stack([begin, end], axis=1))
    follower.turn = 1.0 / max(way, 1e-3)
    follower.begin(first.row, first.signs)
    steps = max(8, math.ceil(way * STEPS_A_TURN))
    path = follower.follow(np.arange(1, steps + 1) / steps)
    if path.codes[-1] != Status.OK:
        return None
    row = follower.at(1.0)
    quality, foreseen = np.full(plan.branches, np.inf), None
    for bridge in follower.bridges[-1:]:
        if bridge.times[3] < 1.0 < bridge.times[4]:  # the motion may go back from here or straight on
            quality[list(bridge.flipped)] = 0.0
            foreseen = _along_bridge(bridge, begin, end)
    row.time = 0.0
    work = first.work + float(path.work.sum())
    return Assembly(Status.OK, row, follower.sign.copy(), row.error, work, first.surplus, quality, foreseen)


def _along_bridge(bridge: Bridge, begin: FloatArray, end: FloatArray) -> Foreseen:
    """Return the positions that continue a straight run of the inputs through its singular end."""
    way = end - begin

    def foreseen(inputs: FloatArray) -> ComplexArray:
        row = bridge.at(1.0 + float((inputs - end) @ way) / float(way @ way))
        return np.asarray(row.x + 1j * row.y)

    return foreseen
