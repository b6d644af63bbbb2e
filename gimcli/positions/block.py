"""A block of rows of a motion, as the lanes (arrays) that the solvers read and fill.

The rows before NEW are the last solved ones, from which the branch is continued; a time of -inf marks a missing row.

Branch signs choose, for each step with two solutions, that on the side of the initial guess.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.kernels import loci, newton, plan_steps as kernels
from gimcli.kernels.circular import cos_sin
from gimcli.kernels.plan_steps import MEASURE, NOISE, SQUARE
from gimcli.mechanism import FloatArray
from gimcli.positions.newton import Accuracy, NewtonConstants, Packed, Run
from gimcli.positions.position import Row
from gimcli.positions.program import PlanProgram, by_numbers

FLAT = 1e-9
"""If a guess is closer to the line between both sides than this, relative to the size, the sign is +1 (left)."""


def sides(guess: RowBlock, size: float) -> FloatArray:
    """Return the branch signs (branches,) of a guess, given in the first new row of a block."""
    signs, q, at = np.ones(len(guess.g)), guess.program.tables, guess.program.at
    with np.errstate(all="ignore"):
        for k, (kind, *_, branch) in enumerate(q.steps):
            if kind == kernels.ORIENT:
                kernels.carry(guess.lanes, q, at, k, NEW + 1)
            elif branch >= 0:
                measure = _drawn_line(guess, k) if kind == kernels.TILT else _drawn_node(guess, k)
                signs[branch] = -1.0 if measure < -FLAT * size else 1.0
    return signs


def _drawn_line(guess: RowBlock, k: int) -> float:
    """Set the direction of a guide (TILT) from its member; return tau, the distance along it, times a length."""
    w, q, at = guess.lanes, guess.program.tables, guess.program.at
    _, register, a, b, along, _ = q.steps[k]
    kernels.compute_vector(w, q, at, along, NEW + 1)
    ux, uy = guess.value(kernels.EX), guess.value(kernels.EY)
    norm = np.sqrt(ux * ux + uy * uy)
    guess.rx[register, NEW], guess.ry[register, NEW] = ux / norm, uy / norm
    wx, wy = guess.x[b, NEW] - guess.x[a, NEW], guess.y[b, NEW] - guess.y[a, NEW]
    return float(ux * wx + uy * wy)


def _drawn_node(guess: RowBlock, k: int) -> float:
    """Return the distance of a node to the left of the line between two centres, or ahead along the line of a locus."""
    w, q, at = guess.lanes, guess.program.tables, guess.program.at
    kind, node, first, second, _, _ = q.steps[k]
    kernels.compute_locus(w, q, at, first, kernels.C, NEW + 1)
    kernels.compute_locus(w, q, at, second, kernels.F, NEW + 1)
    x, y = guess.value(kernels.C), guess.value(kernels.D)
    nx, ny = guess.x[node, NEW] - x, guess.y[node, NEW] - y
    if kind == kernels.TWO_CIRCLES:
        bx, by = guess.value(kernels.F), guess.value(kernels.G)
        return float(((bx - x) * ny - (by - y) * nx) / np.sqrt((bx - x) * (bx - x) + (by - y) * (by - y)))
    return float(guess.value(kernels.I) * nx - guess.value(kernels.H) * ny)


NEW = kernels.HISTORY
"""First row to solve."""


class RowBlock:
    """A block of rows; `end` is reduced to the first row that could not be solved reliably."""

    def __init__(self, program: PlanProgram, time: FloatArray, inputs: FloatArray, history: Sequence[Row] = ()) -> None:
        """Create a block for times (rows,) and solved rows before them; inputs (actuators, rows of both together)."""
        self.program, at, w = program, program.at, program.lanes(NEW + len(time))
        self.lanes: dict[int, Any] = by_numbers(w)
        self.time, self.error, self.work = w[kernels.TIME], w[kernels.ERROR], w[kernels.WORK]
        self.x, self.y, self.g = w[at.x : at.y], w[at.y : at.rx], w[at.g :]  # (nodes, rows), (branches, rows)
        self.rx, self.ry = w[at.rx : at.ry], w[at.ry : at.values]  # (registers, rows) directions
        self.inputs, self.cos, self.sin = w[at.values : at.cos], w[at.cos : at.sin], w[at.sin : at.g]
        self.followed = len(history) > 0
        program.recall(w, history)
        self.time[NEW:], self.inputs[:, NEW - len(history) :] = time, inputs
        self.cos[:], self.sin[:] = cos_sin(self.inputs)
        self.end = NEW + len(time)
        self.blocked = False  # the row at `end` has no solution
        self.singular = False  # the row at `end` is solved, but not to the tolerance
        self.lenient = False  # ignore the tolerance; a row only has to distinguish the branches

    def step(self, k: int, sign: FloatArray, tolerance: float) -> None:
        """Execute closed-form step k; the block ends before a row without solution, a singular or a jumped one."""
        w, q, at = self.lanes, self.program.tables, self.program.at
        if not kernels.place(w, q, at, k, sign, self.end):
            return
        end = kernels.guard(w, q, at, k, math.inf if self.lenient else tolerance, self.followed, self.end)
        if self.lenient:
            end = min(end, self._distinguished())
        if end < self.end:
            g, g2, noise = (self.value(lane, end) for lane in (MEASURE, SQUARE, NOISE))
            blocked = not g2 >= -noise
            singular = g2 / noise <= 1.0 if self.lenient else not loci.intersection_error(g, noise) <= tolerance
            self.stop(end, bool(blocked), bool(singular and not blocked))

    def value(self, lane: int, row: int = NEW) -> Any:
        """Return the value of a lane in a row."""
        whole = self.lanes[lane * kernels.WIDTH]
        return whole[row] if getattr(whole, "ndim", 0) else whole

    def _distinguished(self) -> int:
        """Return the first row in which the two solutions of the last step cannot be distinguished.

        They are not distinguished if the square of the measure is not above its rounding error.
        """
        g2, noise = (kernels.earlier(self.lanes, lane, slice(NEW, self.end), 0) for lane in (SQUARE, NOISE))
        return NEW + int(np.argmax(np.append(g2 / noise <= 1.0, True)))

    def follow(self, packed: Packed, run: Run, sign: float, accuracy: Accuracy) -> float:
        """Solve a coupled group in all rows; return the sign of the determinant at the last solved row."""
        constants = NewtonConstants()
        limits, room = constants.limits(accuracy, constants.iterations, near=True), self._room(packed)
        stop = run(newton.solve_group)(
            *self._known, self.time, NEW, self.end, packed.arrays, room, sign, limits, self.work, self.error, True
        )
        self.stop(stop, singular=bool(room.out[newton.SINGULAR]))
        return float(room.out[newton.LAST_SIGN])

    def settle(self, packed: Packed, run: Run, accuracy: Accuracy) -> bool:
        """Solve a coupled group in the first new row, starting from its base nodes; return whether it converged."""
        constants = NewtonConstants()
        limits, room = constants.limits(accuracy, constants.far, near=False), self._room(packed)
        with np.errstate(all="ignore"):
            stop = run(newton.solve_group)(
                *self._known, self.time, NEW, NEW + 1, packed.arrays, room, 0.0, limits, self.work, self.error, False
            )
        good = bool(stop > NEW)
        self.singular = bool(room.out[newton.SINGULAR]) and not good
        return good

    def carry(self, packed: Packed) -> None:
        """Compute the carried nodes of a group from its base nodes, in the first new row."""
        group, room = packed.arrays, self._room(packed)
        known: tuple[Any, ...] = (*self._known, NEW, group, room)
        newton.read_row(*known)
        newton.start_from(self.x, self.y, NEW, group, room)
        newton.carry(group, room)
        newton.write_row(self.x, self.y, NEW, group, room)

    def _room(self, packed: Packed) -> newton.RowPosition:
        return newton.room([packed.arrays], len(self.rx), len(self.inputs))

    @property
    def _known(self) -> tuple[Any, ...]:
        return self.x, self.y, self.rx, self.ry, self.inputs, self.cos, self.sin

    def stop(self, row: int, blocked: bool = False, singular: bool = False) -> None:
        """End the block before a row, unless it ends earlier."""
        if row < self.end:
            self.end, self.blocked, self.singular = row, blocked, singular

    def rows(self, last: int | None = None) -> list[Row]:
        """Return the solved rows, or only the `last` ones of them."""
        span = slice(NEW if last is None else max(NEW, self.end - last), self.end)
        time, error = self.time[span].tolist(), self.error[span].tolist()
        x, y, g = (part[:, span].T.copy() for part in (self.x, self.y, self.g))
        return [Row(time[k], x[k], y[k], g[k], error[k]) for k in range(len(time))]
