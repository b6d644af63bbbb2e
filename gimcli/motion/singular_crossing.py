"""Pass a doubtful row: by an ever finer grid, or straight through a singular position.

What cannot be solved on the finest grid is a limit of the input, or a position where two branches meet. Then the
position beyond it is extrapolated from four before it and solved there; the rows in between are interpolated over
both sides, for at the singular position itself the equations determine a node to only half the digits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gimcli.continuation.gap_interpolation import GapInterpolation, lagrange
from gimcli.mechanism import FloatArray
from gimcli.motion.branch_state import BranchState
from gimcli.positions.block import NEW, RowBlock
from gimcli.positions.row import Row
from gimcli.structure.residual import allowed, residual
from gimcli.structure.steps import NONE

MOST = 100
"""Doubtful rows passed one by one before the curve of the motion is asked: a limit or a meeting takes 30."""


class SingularCrossing:
    """Takes the state of a branch past rows that are doubtful; ends early where the curve of the motion is known."""

    def __init__(self, state: BranchState, knows_curve: Callable[[], bool]) -> None:
        self.state, self.knows_curve, self.doubtful = state, knows_curve, 0

    def cross(self, time: float) -> bool:
        """Go on from the last row to a time on an ever finer grid; the log then ends there or beyond."""
        state = self.state
        start = state.log[-1].time
        grid = start + (time - start) * np.arange(1, state.constants.split + 1) / state.constants.split
        grid[-1] = time
        while len(grid := grid[grid > state.log[-1].time]):
            block = state.evaluate(grid, state.log)
            state.remember(block.rows())
            good = block.end - NEW
            if good == len(grid):
                break
            if not self._pass(float(grid[good]), block):
                return False
        return True

    def _pass(self, target: float, block: RowBlock) -> bool:
        """Get past a doubtful row: by a leap where two branches meet, else on a finer grid."""
        state = self.state
        self.doubtful += 1
        if self.doubtful > MOST and self.knows_curve():
            return False
        gap = target - state.log[-1].time
        if block.singular:
            meeting = self._meeting(block.weak_branch, target)
            if meeting is not None and self._leap(meeting):
                return True
            if meeting is not None and not state.lenient and self._shorter(meeting) and gap > self._shortest:
                return self.cross(target)  # from nearer by
            if not state.lenient:
                state.lenient = True
                done = self.cross(target)
                state.lenient = False
                return done
        if gap <= state.constants.resolution * max(1.0, abs(target)):
            return not block.singular and not block.blocked and self._leap(0.5 * (target + state.log[-1].time))
        return self.cross(target)

    def _meeting(self, branch: int, target: float) -> float | None:
        """Return the time near `target` at which two branches cannot be distinguished, None where they always can.

        The measure of a step does not depend on the side that is taken: it is sampled ever finer.
        """
        state = self.state
        start = state.log[-1].time
        if branch == NONE:  # a coupled group: only the landing decides
            return 0.5 * (start + target)
        low, high = start, max(target, start + state.constants.window * state.turn)
        for _ in range(state.constants.zooms):
            grid = np.linspace(low, high, 4 * state.constants.split + 1)[1:]
            quality = self._quality(branch, grid)
            if not np.any(np.isfinite(quality)):
                return None
            k = int(np.nanargmin(quality))
            if quality[k] < -1.0:
                return None
            step = grid[1] - grid[0]
            low, high = max(start, grid[k] - step), grid[k] + step
        return float(grid[k]) if quality[k] <= state.constants.meeting else None

    def _quality(self, branch: int, times: FloatArray) -> FloatArray:
        state = self.state
        lenient, state.lenient = state.lenient, True
        block = state.evaluate(times, state.log)
        state.lenient = lenient
        return block.quality.get(branch, np.array([np.nan]))

    def _leap(self, centre: float) -> bool:
        """Pass a singular position: solve beyond it what is predicted from before it."""
        state = self.state
        gap = abs(centre - state.log[-1].time)
        return any(
            self._bridge(centre, part * state.turn) for part in state.constants.leaps if gap <= 0.5 * part * state.turn
        )

    @property
    def _shortest(self) -> float:
        return 0.5 * self.state.constants.leaps[-1] * self.state.turn

    def _shorter(self, centre: float) -> bool:
        """Return whether leaps that are too short for the distance to a singular position are left to be tried."""
        return bool(abs(centre - self.state.log[-1].time) > self._shortest)

    def _bridge(self, centre: float, delta: float) -> bool:
        state = self.state
        saved = state.sign.copy(), dict(state.determinant), state.log, state.lenient
        state.lenient = False
        before = self._uniform(centre + delta * np.arange(-4.0, 0.0))
        done = before is not None and self._land(centre, delta, before) and self._closes()
        state.lenient = saved[3]
        if not done:
            state.sign, state.determinant, state.log = saved[:3]
            del state.bridges[state.passed :]
        state.passed = len(state.bridges)
        return done

    def _closes(self) -> bool:
        """Return whether the mechanism is assembled at the singular position itself: no limit was leapt over."""
        state = self.state
        bridge = state.bridges[-1]
        row, when = bridge.at(bridge.centre), np.array([bridge.centre])
        found = residual(state.mechanism, (row.x + 1j * row.y)[:, None], state.inputs(when))
        return bool(found.total[0] <= max(state.constants.closure, allowed(state.mechanism, 0.0)))

    def _uniform(self, times: FloatArray) -> list[Row] | None:
        state = self.state
        history = [row for row in state.log if row.time < times[0]]
        if not history:
            return None
        block = state.evaluate(times, history)
        return block.rows() if block.end == len(block.time) else None

    def _land(self, centre: float, delta: float, before: list[Row]) -> bool:
        """Solve beyond a singular position with the signs predicted there."""
        state = self.state
        when = [row.time for row in before]
        weights = lagrange(when, centre + delta)
        predicted = Row(
            centre + delta,
            *(sum(w * getattr(row, part) for w, row in zip(weights, before, strict=True)) for part in "xyg"),
        )
        state.sign = state.sides(predicted)
        state.determinant = dict.fromkeys(state.determinant, 0.0)
        block = state.evaluate(np.array([centre + delta]), self._fan(before, predicted))
        if block.end < len(block.time):
            return False
        first = block.rows()[0]
        distance = np.hypot(predicted.x - before[-1].x, predicted.y - before[-1].y)
        miss = np.hypot(predicted.x - first.x, predicted.y - first.y)
        if not np.all(miss <= state.constants.agreement * np.nanmax(distance)):
            return False
        turned = np.where(predicted.g * first.g < 0.0, -1.0, 1.0)  # where two centres have met
        rows = [*(Row(row.time, row.x, row.y, turned * row.g) for row in before), first]
        block = state.evaluate(centre + delta * np.arange(2.0, 5.0), rows)
        if block.end < len(block.time):
            return False
        state.log = rows + block.rows()
        bridge = GapInterpolation(centre, state.log.copy())
        state.bridges.append(GapInterpolation(bridge.turning(), bridge.rows))
        return True

    def _fan(self, before: list[Row], predicted: Row) -> list[Row]:
        """Return a history whose extrapolation is what is predicted: it turns on the spot."""
        state = self.state
        return [Row(before[-1].time, predicted.x, predicted.y, state.sign * np.abs(predicted.g))]
