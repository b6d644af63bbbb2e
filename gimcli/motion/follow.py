"""Follow a motion from a solved position, on its branch, through singular positions.

Rows are solved in blocks until one is doubtful: it has no solution, may have jumped, or does not reach the tolerance. A
doubtful row is approached on a refined grid. If it is at a limit of the input, or where branches meet, the curve of the
motion (motion_curve) shows whether the motion continues; near the singular position the rows are then those of an arc
of this curve. If the mechanism is too large for it, the position beyond a meeting of branches is extrapolated (leap).
The "time" of a row is the independent variable of the inputs: the coordinate on a leg of the laws, or the time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gimcli.kernels import jit
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.positions import newton
from gimcli.positions.block import NEW, RowBlock, sides
from gimcli.positions.inputs import Inputs
from gimcli.positions.newton import Run
from gimcli.positions.position import Row
from gimcli.positions.program import Marcher, plan_program
from gimcli.status import CHANGE, Status
from gimcli.structure.residual import allowed, residual
from gimcli.structure.steps import Plan

if TYPE_CHECKING:
    from gimcli.continuation.arc import ArcPassage, Gap, Leap
    from gimcli.continuation.bifurcation import Crossing
    from gimcli.motion.motion_curve import MotionCurve

Stop = tuple[float, tuple[float, ...]]
"""Time and inputs (actuators,) at a limit."""


class PassedMeeting(NamedTuple):
    """Where branches meet."""

    z: ComplexArray  # (nodes,)
    inputs: FloatArray  # (actuators,)
    found: Crossing | None  # None: its branches are not known

    @property
    def kind(self) -> str:
        """Whether branches cross there, or there is only one."""
        return CHANGE if self.found is None else self.found.kind


@dataclass
class FollowedPath:
    """The result of following a motion, one row for each given time; z is undefined in rows that are not ok."""

    time: FloatArray  # (rows,)
    inputs: FloatArray  # (actuators, rows)
    z: ComplexArray  # (nodes, rows)
    codes: IntArray  # (rows,) of Status
    residual: FloatArray  # (rows,) NaN where not computed yet, or not solved
    work: FloatArray  # (rows,)
    bridged: list[float] = field(default_factory=list)  # times of the singular positions passed
    meetings: list[PassedMeeting] = field(default_factory=list)  # positions and inputs there
    limit: float | None = None  # time of the limit, or of the last row before a position that could not be passed
    exchanged: list[float] = field(default_factory=list)  # times at which the sequence of the sweeps was exchanged
    touched: list[Stop] = field(default_factory=list)  # limits that a law reaches but does not exceed
    turned_back: list[Stop] = field(default_factory=list)  # limits at which the input reversed
    parameter: FloatArray | None = None  # (rows,) of the curve, if requested

    @staticmethod
    def empty(nodes: int, time: FloatArray, inputs: FloatArray) -> FollowedPath:
        """Return a path without solved rows."""
        rows = len(time)
        z, codes = np.empty((nodes, rows), dtype=complex), np.zeros(rows, dtype=np.int64)
        return FollowedPath(time, inputs, z, codes, np.full(rows, np.nan), np.zeros(rows))  # a NaN fails every check

    def met(self, time: float, gap: Gap, inputs: FloatArray) -> None:
        """Record a meeting of branches that was passed, and its inputs (actuators,)."""
        row = gap.at(gap.centre)
        self.bridged.append(time)
        self.meetings.append(PassedMeeting(row.x + 1j * row.y, inputs, gap.met))

    def end(self, row: int, limit: float) -> None:
        """End the motion before a row, at the time of a limit."""
        self.codes[row:], self.limit = int(Status.LIMIT), limit


@dataclass(frozen=True)
class FollowingConstants:
    """Constants of the path following."""

    rows: int = 2048  # in one block, which then fits into the processor cache
    many: int = 16  # number of rows from which on all are solved in one compiled call
    growth: float = 1.75  # factor of the small steps that lead to the second row
    steps: int = 14  # number of these steps
    first: tuple[float, ...] = (1 / 512, 1 / 64, 1 / 8, 1.0)  # fractions of the first step, if these steps fail
    split: int = 8  # number of parts of an interval that is refined
    resolution: float = 1e-12  # relative accuracy of the location of a limit
    doubtful: int = 100  # most doubtful rows that are refined one after the other; a limit needs 30
    leaps: tuple[float, ...] = (2e-3, 2e-4, 2e-5, 2e-6)  # in turns: distances of rows about a meeting that is leaped
    closure: float = 2e-13  # greatest residual of a position interpolated at a meeting
    agreement: float = 0.2  # greatest relative difference of the position beyond a meeting from its prediction
    loosest: float = 1e-6  # error of the nodes of a coupled group that is allowed near a singular position
    memory: int = 400  # number of solved rows that are kept


class BranchFollower:
    """Follows a branch of a plan, given by its signs and its last solved rows, through the rows of a motion.

    sense: of the parameter of the motion curve with increasing time. Without a motion curve, a position that cannot be
    passed is a limit.
    """

    limit_ahead: ArcPassage | None = None  # the passage towards a limit that the motion is on
    progress: Callable[[int, int], None] | None = None  # called with the rows done and the total
    sense = 1.0
    doubtful = 0  # number of doubtful rows since the last row that was not

    def __init__(
        self, mechanism: Mechanism, plan: Plan, inputs: Inputs, run: Run, tolerance: float,
        motion_curve: Callable[[], MotionCurve] | None = None,
    ) -> None:  # fmt: skip
        self.mechanism, self.plan, self.inputs, self.run = mechanism, plan, inputs, run
        self.constants = FollowingConstants()
        self.tolerance = tolerance * mechanism.size
        self.accuracy = newton.Accuracy(tolerance, mechanism.size, mechanism.shortest)
        self.loose_accuracy = newton.Accuracy(tolerance, mechanism.size, mechanism.shortest, self.constants.loosest)
        self.sign = np.ones(plan.branches)
        self.program = plan_program(mechanism, plan)
        self.determinant = dict.fromkeys(self.program.packed, 0.0)
        self.log: list[Row] = []
        self.bridges: list[Gap] = []  # intervals around singular positions that the motion has passed
        self.lenient = False  # passing a position that cannot be solved to the tolerance
        self._motion_curve = motion_curve
        self.turn = 1.0  # change of the time for one turn of the input, or a travel of 2 pi sizes

    @cached_property
    def motion_curve(self) -> MotionCurve | None:
        """The curve of the motion; None if it is not used."""
        return None if self._motion_curve is None else self._motion_curve()

    def begin(self, row: Row, signs: FloatArray) -> None:
        """Start from a solved position."""
        self.log, self.sign = [row], signs.copy()
        self.determinant = dict.fromkeys(self.program.packed, 0.0)
        self.bridges = []
        self.limit_ahead = None

    def sides(self, row: Row) -> FloatArray:
        """Return the branch signs (branches,) of a row."""
        when = np.array([row.time])
        guess = RowBlock(self.program, when, self.inputs(when))
        guess.x[:, NEW], guess.y[:, NEW] = row.x, row.y
        return sides(guess, self.mechanism.size)

    def evaluate(self, times: FloatArray, history: list[Row], values: FloatArray | None = None) -> RowBlock:
        """Solve rows at times that continue a history; values: their inputs (actuators, rows), if already known."""
        past = self.useful(times, history)
        inputs = self.inputs(np.concatenate([[row.time for row in past], times]))
        if values is not None:
            inputs[:, len(past) :] = values
        block = RowBlock(self.program, times, inputs, past)
        block.lenient = self.lenient
        with np.errstate(all="ignore"):
            self._solve(block)
        return block

    def _solve(self, block: RowBlock) -> None:
        accuracy = self.loose_accuracy if block.lenient else self.accuracy
        for k in range(len(self.plan.steps)):
            if block.end <= NEW:
                return
            packed = self.program.packed.get(k)
            if packed is None:
                block.step(k, self.sign, self.tolerance)
            else:
                self.determinant[k] = block.follow(packed, self.run, self.determinant[k], accuracy)

    def useful(self, times: FloatArray, history: list[Row]) -> list[Row]:
        """Return up to four rows of the history with spacing similar to that of `times`, or the first and the last."""
        step = times[0] - history[-1].time
        chosen = [history[-1]]
        for row in reversed(history[:-1]):
            if len(chosen) == 4:
                break
            if chosen[-1].time - row.time >= 0.5 * step:
                chosen.append(row)
        if len(chosen) == 1 < len(history):
            chosen.append(history[0])
        return chosen[::-1]

    def remember(self, rows: list[Row]) -> None:
        """Append solved rows to the history."""
        self.log += rows
        if len(self.log) > 2 * self.constants.memory:
            del self.log[: -self.constants.memory]

    def enter(self, gap: Gap) -> bool:
        """Start on an arc: towards a limit, or away from a singular position; return whether this is possible."""
        if gap.inwards:
            self.log, self.limit_ahead = [], gap
        elif (out := gap.exit) is not None:
            signs = self.sides(out)
            self.begin(Row(out.time, out.x, out.y, signs * np.abs(out.g)), signs)
        else:
            return False
        self.bridges = [gap]
        return True

    @property
    def reached(self) -> float:
        """The time up to which the motion is solved."""
        return self.limit_ahead.ends[1] if self.limit_ahead is not None else self.log[-1].time

    def gap_at(self, time: float) -> Gap | None:
        """Return the arc that contains a time; None if there is none."""
        return next((gap for gap in reversed(self.bridges) if gap.ends[0] < time < gap.ends[1]), None)

    # -- the whole motion ------------------------------------------------------------------

    def run_to(self, times: FloatArray) -> FollowedPath:
        """Solve rows at increasing times."""
        return self.follow(FollowedPath.empty(len(self.mechanism.nodes), times, self.inputs(times)))

    def follow(self, path: FollowedPath) -> FollowedPath:
        """Solve the rows of a path with increasing times, from the start or from the end of the last call."""
        times, n = path.time, len(path.time)
        i = self._fill(path, 0)
        if i < n and self.limit_ahead is None and len(self.log) == 1:
            i = self._beyond(path, i, self._set_out(float(times[i])))
        while i < n and path.limit is None:
            if self.limit_ahead is not None:
                path.end(i, self.limit_ahead.centre)
                break
            marches = self.run is jit.compiled and n - i >= self.constants.many
            good, doubtful = self._march(path, i) if marches else self._block(path, i)
            i += good
            if self.progress is not None:
                self.progress(i, n)
            if doubtful:
                i = self._beyond(path, i, self._crosses(float(times[i])))
        return path

    def _crosses(self, time: float) -> bool:
        """Pass doubtful rows up to a time; return the success."""
        self.doubtful = 0
        return self._cross(time)

    def _cross(self, time: float) -> bool:
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
            self.doubtful += 1
            finest = grid[good] - self.log[-1].time <= self.constants.resolution * max(1.0, abs(grid[good]))
            hopeless = finest or (block.singular and not self.lenient) or self.doubtful > self.constants.doubtful
            if hopeless or not self._cross(float(grid[good])):
                return False
        return True

    def _approach(self, time: float) -> bool:
        """Solve rows up to a time, near a singular position not to the tolerance; return the success."""
        self.lenient = True
        crossed = self._crosses(time)
        self.lenient = False
        return crossed

    def _leaps(self) -> bool:
        """Leap over a meeting of branches if the curve of the motion is too large; return the success."""
        if self.motion_curve is None or self.motion_curve.curve is not None:
            return False
        centre, saved = self.log[-1].time, (self.sign.copy(), dict(self.determinant), self.log)
        for part in self.constants.leaps:
            found = self._leap(centre, part * self.turn)
            if found is not None and self._closes(found):
                self.bridges.append(found.centred())
                return True
            self.sign, self.determinant, self.log = saved[0].copy(), dict(saved[1]), saved[2]
        return False

    def _leap(self, centre: float, delta: float) -> Leap | None:
        """Return the passage between rows at multiples of a distance from a meeting of branches; None if it fails.

        The position beyond is extrapolated from the rows before; it is solved with the signs of the prediction.
        """
        from gimcli.continuation.arc import BEFORE, Leap, extrapolated

        history = [row for row in self.log if row.time < centre - BEFORE * delta]
        block = self.evaluate(centre + delta * np.arange(-BEFORE, 0.0), history) if history else None
        if block is None or block.end < len(block.time):
            return None
        before = block.rows()
        guess = extrapolated(before, centre + delta)
        self.sign, self.determinant = self.sides(guess), dict.fromkeys(self.determinant, 0.0)
        alone = [Row(before[-1].time, guess.x, guess.y, self.sign * np.abs(guess.g))]  # it predicts the guess
        block = self.evaluate(np.array([guess.time]), alone)
        if block.end < len(block.time):
            return None
        first = block.rows()[0]
        moved = np.nanmax(np.hypot(guess.x - before[-1].x, guess.y - before[-1].y))
        if not np.all(np.hypot(guess.x - first.x, guess.y - first.y) <= self.constants.agreement * moved):
            return None
        turned = np.where(guess.g * first.g < 0.0, -1.0, 1.0)  # if two centres coincided
        self.log = [*(Row(row.time, row.x, row.y, turned * row.g) for row in before), first]
        block = self.evaluate(centre + delta * np.arange(2.0, BEFORE + 1.0), self.log)
        self.log = self.log + block.rows()
        return Leap(centre, self.log) if block.end == len(block.time) else None

    def _closes(self, found: Leap) -> bool:
        """Return whether the position interpolated at the centre is assembled; it is not beyond a limit."""
        row = found.at(found.centre)
        error = residual(self.mechanism, (row.x + 1j * row.y)[:, None], self.inputs(np.array([found.centre]))).total[0]
        return bool(error <= max(self.constants.closure, allowed(self.mechanism, 0.0)))

    def _beyond(self, path: FollowedPath, i: int, crossed: bool) -> int:
        """Fill the rows that have been passed, and return the next row; or end the motion at its limit."""
        if crossed:
            return self._fill(path, i)
        target, bridges = float(path.time[i]), self.bridges
        gap = None
        if self.motion_curve is not None:
            gap = self.motion_curve.ahead(self.log, self.sense, target, self.turn)
        if gap is None or isinstance(gap, float):
            crossed = self._approach(target) or self._leaps()
        else:
            crossed = self._approach(min(target, gap.ends[0]))
            if gap.ends[0] <= self.log[-1].time and self.enter(gap):
                self.bridges, crossed = [*bridges, gap], True
        if crossed:
            return self._fill(path, i)
        last = self.log[-1].time
        path.end(i, max(gap, last) if isinstance(gap, float) else last)
        return i

    def _block(self, path: FollowedPath, i: int) -> tuple[int, bool]:
        """Solve a block of rows from row i on, interpreted; return their number, and whether the next is doubtful."""
        rows = slice(i, i + self.constants.rows)
        block = self.evaluate(path.time[rows], self.log, path.inputs[:, rows])
        good = block.end - NEW
        span, into = slice(NEW, block.end), slice(i, i + good)
        path.z.real[:, into], path.z.imag[:, into] = block.x[:, span], block.y[:, span]
        path.work[into] = block.work[span]
        self.remember(block.rows(8))
        return good, block.end < len(block.time)

    @cached_property
    def _marcher(self) -> Marcher:
        return Marcher(self.program, self.accuracy)

    def _march(self, path: FollowedPath, i: int) -> tuple[int, bool]:
        """Solve all rows from row i on in one compiled call; return their number, and whether the next is doubtful."""
        marcher = self._marcher
        past = self.useful(path.time[i:], self.log)
        marcher.recall(self.inputs(np.array([row.time for row in past])), past)
        determinant = np.array([*self.determinant.values()])
        good, kept = marcher.go(i, path.time, path.inputs, path.z, path.residual, path.work, self.sign, determinant)
        self.determinant = dict(zip(self.determinant, determinant.tolist(), strict=True))
        self.remember([row for row in kept if row.time > self.log[-1].time])
        return good, i + good < len(path.time)

    def _fill(self, path: FollowedPath, i: int) -> int:
        """Fill the rows up to `reached`; return the next row to solve."""
        while i < len(path.time) and path.time[i] <= self.reached:
            row = self.at(float(path.time[i]))
            if not self._is_exact(row):
                row = self._beside(row)
            path.z[:, i] = row.x + 1j * row.y
            path.codes[i] = int(Status.OK if self._is_exact(row) else Status.SINGULAR)
            i += 1
        return i

    def _is_exact(self, row: Row) -> bool:
        """Return whether a row has the tolerance, or is on an arc: then it is as exact as its input."""
        return row.error <= self.tolerance or self.gap_at(row.time) is not None

    def _beside(self, row: Row) -> Row:
        """Return a row near a singular position from the curve of the motion, as its inputs do not determine it."""
        before = [one for one in self.log if one.time < row.time and one.error <= self.tolerance]
        if self.motion_curve is None or not before:
            return row
        gap = self.motion_curve.ahead(before, self.sense, row.time, self.turn)
        if gap is None or isinstance(gap, float) or not gap.ends[0] <= row.time <= gap.ends[1]:
            return row
        self.bridges.append(gap)
        return gap.at(row.time)

    def at(self, time: float) -> Row:
        """Return the row at a time up to `reached`: solved, or interpolated in a bridge."""
        for bridge in reversed(self.bridges):
            if bridge.ends[0] <= time <= bridge.ends[1]:
                return bridge.at(time)
        for row in reversed(self.log):
            if row.time == time:
                return row
        before = [row for row in self.log if row.time < time]
        if not before and self.bridges:  # a rounding error before the start of the first bridge
            return self.bridges[0].at(time)
        return self.evaluate(np.array([time]), before).rows()[0]

    def _solves(self, times: FloatArray) -> bool:
        """Solve rows that only lead to others; return whether all are solved."""
        if self.run is jit.compiled:
            return not self._march(FollowedPath.empty(len(self.mechanism.nodes), times, self.inputs(times)), 0)[1]
        block = self.evaluate(times, self.log)
        self.remember(block.rows())
        return block.end == len(block.time)

    def _set_out(self, time: float) -> bool:
        """Solve the second row in increasing steps from very small ones, because the speed is not known yet."""
        start = self.log[-1].time
        growing = start + (time - start) * self.constants.growth ** np.arange(-self.constants.steps, 1.0)
        growing[-1] = time
        if self._solves(growing):
            return True
        ends = start + (time - start) * np.array(self.constants.first)
        return all(self._crosses(float(end)) for end in ends if end > self.log[-1].time)
