"""Passage of doubtful rows: by a refined grid, or through a singular position.

A row that cannot be solved on the finest grid is at a limit of the input, or at a position where two branches meet. The
position beyond it is then extrapolated from four positions before it and solved. The rows in between are interpolated
from both sides, because at the singular position the equations determine a node to only half the digits.
"""

from __future__ import annotations

import numpy as np

from gimcli.continuation.gap_interpolation import GapInterpolation
from gimcli.mechanism import FloatArray
from gimcli.motion.branch_state import BranchState
from gimcli.numerics.interpolation import lagrange
from gimcli.positions.block import NEW, RowBlock
from gimcli.positions.position import Row
from gimcli.structure.residual import allowed, residual
from gimcli.structure.steps import NONE

MOST = 100
"""Number of doubtful rows after which the curve of the motion is used instead; a limit or a meeting needs 30."""


class SingularCrossing(BranchState):
    """The state of a branch that passes doubtful rows; it gives up early if the curve of the motion is available."""

    doubtful = 0  # number of doubtful rows since the last row that was not

    def cross(self, time: float) -> bool:
        """Solve rows from the last one to a time on a refined grid; return whether the log reaches that time."""
        start = self.log[-1].time
        grid = start + (time - start) * np.arange(1, self.constants.split + 1) / self.constants.split
        grid[-1] = time
        while len(grid := grid[grid > self.log[-1].time]):
            block = self.evaluate(grid, self.log)
            self.remember(block.rows())
            good = block.end - NEW
            if good == len(grid):
                break
            if not self._pass(float(grid[good]), block):
                return False
        return True

    def _pass(self, target: float, block: RowBlock) -> bool:
        """Pass a doubtful row: by a bridge where two branches meet, else on a finer grid; return the success."""
        self.doubtful += 1
        if self.doubtful > MOST and self.motion_curve is not None and self.motion_curve.curve is not None:
            return False
        gap = target - self.log[-1].time
        if block.singular:
            meeting = self._meeting(block.weak_branch, target)
            if meeting is not None and self._leap(meeting):
                return True
            if meeting is not None and not self.lenient and self._shorter(meeting) and gap > self._shortest:
                return self.cross(target)  # approach it more closely
            if not self.lenient:
                self.lenient = True
                done = self.cross(target)
                self.lenient = False
                return done
        if gap <= self.constants.resolution * max(1.0, abs(target)):
            return not block.singular and not block.blocked and self._leap(0.5 * (target + self.log[-1].time))
        return self.cross(target)

    def _meeting(self, branch: int, target: float) -> float | None:
        """Return the time near `target` at which two branches cannot be distinguished, None if they always can.

        The quality of a step does not depend on the chosen side; it is sampled on refined grids.
        """
        start = self.log[-1].time
        if branch == NONE:  # a coupled group: only the position beyond it shows whether branches meet
            return 0.5 * (start + target)
        low, high = start, max(target, start + self.constants.window * self.turn)
        for _ in range(self.constants.zooms):
            grid = np.linspace(low, high, 4 * self.constants.split + 1)[1:]
            quality = self._quality(branch, grid)
            if not np.any(np.isfinite(quality)):
                return None
            k = int(np.nanargmin(quality))
            if quality[k] < -1.0:
                return None
            step = grid[1] - grid[0]
            low, high = max(start, grid[k] - step), grid[k] + step
        return float(grid[k]) if quality[k] <= self.constants.meeting else None

    def _quality(self, branch: int, times: FloatArray) -> FloatArray:
        lenient, self.lenient = self.lenient, True
        block = self.evaluate(times, self.log)
        self.lenient = lenient
        return block.quality.get(branch, np.array([np.nan]))

    def _leap(self, centre: float) -> bool:
        """Pass a singular position by a bridge of one of several widths; return the success."""
        gap = abs(centre - self.log[-1].time)
        return any(
            self._bridge(centre, part * self.turn) for part in self.constants.leaps if gap <= 0.5 * part * self.turn
        )

    @property
    def _shortest(self) -> float:
        return 0.5 * self.constants.leaps[-1] * self.turn

    def _shorter(self, centre: float) -> bool:
        """Return whether narrower bridges exist for which the singular position is still too far away."""
        return bool(abs(centre - self.log[-1].time) > self._shortest)

    def _bridge(self, centre: float, delta: float) -> bool:
        saved = self.sign.copy(), dict(self.determinant), self.log, self.lenient
        self.lenient = False
        before = self._uniform(centre + delta * np.arange(-4.0, 0.0))
        done = before is not None and self._land(centre, delta, before) and self._closes()
        self.lenient = saved[3]
        if not done:
            self.sign, self.determinant, self.log = saved[:3]
            del self.bridges[self.passed :]
        self.passed = len(self.bridges)
        return done

    def _closes(self) -> bool:
        """Return whether the interpolated position at the centre is assembled; it is not if a limit was jumped over."""
        bridge = self.bridges[-1]
        row, when = bridge.at(bridge.centre), np.array([bridge.centre])
        found = residual(self.mechanism, (row.x + 1j * row.y)[:, None], self.inputs(when))
        return bool(found.total[0] <= max(self.constants.closure, allowed(self.mechanism, 0.0)))

    def _uniform(self, times: FloatArray) -> list[Row] | None:
        history = [row for row in self.log if row.time < times[0]]
        if not history:
            return None
        block = self.evaluate(times, history)
        return block.rows() if block.end == len(block.time) else None

    def _land(self, centre: float, delta: float, before: list[Row]) -> bool:
        """Solve the positions beyond a singular one with the predicted signs, and add the bridge."""
        when = [row.time for row in before]
        weights = lagrange(when, centre + delta)
        predicted = Row(
            centre + delta,
            *(sum(w * getattr(row, part) for w, row in zip(weights, before, strict=True)) for part in "xyg"),
        )
        self.sign = self.sides(predicted)
        self.determinant = dict.fromkeys(self.determinant, 0.0)
        block = self.evaluate(np.array([centre + delta]), self._fan(before, predicted))
        if block.end < len(block.time):
            return False
        first = block.rows()[0]
        distance = np.hypot(predicted.x - before[-1].x, predicted.y - before[-1].y)
        miss = np.hypot(predicted.x - first.x, predicted.y - first.y)
        if not np.all(miss <= self.constants.agreement * np.nanmax(distance)):
            return False
        turned = np.where(predicted.g * first.g < 0.0, -1.0, 1.0)  # if two centres coincided
        rows = [*(Row(row.time, row.x, row.y, turned * row.g) for row in before), first]
        block = self.evaluate(centre + delta * np.arange(2.0, 5.0), rows)
        if block.end < len(block.time):
            return False
        self.log = rows + block.rows()
        bridge = GapInterpolation(centre, self.log.copy())
        self.bridges.append(GapInterpolation(bridge.turning(), bridge.rows))
        return True

    def _fan(self, before: list[Row], predicted: Row) -> list[Row]:
        """Return a history of one row, so that its extrapolation is the predicted position."""
        return [Row(before[-1].time, predicted.x, predicted.y, self.sign * np.abs(predicted.g))]
