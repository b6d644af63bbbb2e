"""A motion along the legs of its laws: reversals of the laws, limits, and meetings of branches.

`stop`: rows after the limit are empty. `skip`: rows that the input cannot reach are empty; later rows that it can reach
again are solved, between the same limits as before. `reverse`: the input reverses at the limit and the motion continues
through it, along the legs mirrored at the limit. The branch is chosen at the first change point (which may be the start
position); at later change points, and on the return, the motion continues smoothly.
"""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from gimcli.canonical import TURN
from gimcli.errors import UsageError
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.assemble import Assembly
from gimcli.motion.follow import BranchFollower, FollowedPath
from gimcli.motion.legs import Leg, dense, fine, legs
from gimcli.motion.solve import follower_of, on_gap, settled
from gimcli.positions.inputs import BEYOND
from gimcli.positions.newton import Run
from gimcli.progress import Progress
from gimcli.status import Status
from gimcli.structure.steps import Plan

if TYPE_CHECKING:
    from gimcli.continuation.arc import ArcPassage, Gap

SAME = 1e-6
"""In turns: meetings of branches that are closer are the same."""


class LawFollower:
    """The state of a motion along the legs of its laws."""

    def __init__(
        self, mechanism: Mechanism, plan: Plan, run: Run, tolerance: float, at_limit: str = "stop", branch: int = 1
    ) -> None:
        self.mechanism, self.at_limit, self.branch = mechanism, at_limit, branch
        self.plan, self.run, self.tolerance = plan, run, tolerance
        self.legs = deque(legs(mechanism))
        self.leg = self.legs.popleft()
        self.follower: BranchFollower = self.follow(self.leg)
        self.place = self.leg.sense * self.leg.begin  # coordinate on the leg up to which rows are solved
        self.ended: Status | None = None  # status of all rows after this coordinate
        self.waiting: tuple[float, Gap] | None = None  # time at which the input is reachable again, and the gap there
        self.noted: list[float] = []  # coordinates on the leg of the meetings of branches that have been recorded
        self.progress: Progress | None = None

    def follow(self, leg: Leg) -> BranchFollower:
        """Return the follower of a leg."""
        return follower_of(self.mechanism, self.plan, leg, self.run, self.tolerance)

    @property
    def on_line(self) -> bool:
        """Whether the inputs are on one line."""
        return self.leg.line is not None

    # -- the start ----------------------------------------------------------------------

    def begin(self, start: Assembly, path: FollowedPath) -> Assembly:
        """Start from an assembled position; return it as the motion uses it, and record a singular position there."""
        gap = self._first_gap(start)
        if gap is None and start.status is Status.OK and start.gap is None:
            start.row.time = self.place
            self.follower.begin(start.row, start.signs)
            return start
        if gap is None:
            return self._undetermined(start)
        if self._is_at(gap):
            if gap.limit:
                self._touch(path, gap, 0.0)
            self._note(path, gap)
        elif gap.centre < self.place:
            self.noted.append(gap.centre)
        if not self.follower.enter(gap):
            return self._undetermined(start)
        start.row.time = self.place
        return on_gap(gap, start)

    @staticmethod
    def _undetermined(start: Assembly) -> Assembly:
        """Return a start from which the motion is not determined, with its status."""
        status = Status.SINGULAR if start.status is Status.OK else start.status
        return Assembly(status, start.row, start.signs, start.error, start.work, start.surplus)

    def _first_gap(self, start: Assembly) -> Gap | None:
        """Return the gap at the start position, on the chosen branch, if it is singular."""
        gap, leg = start.gap, self.leg
        if start.status is not Status.SINGULAR and gap is None:
            return None
        single = len(self.mechanism.actuators) == 1
        if gap is not None and single:  # the gap is already on the curve of the motion
            gap = gap if leg.sense > 0.0 else gap.mirrored()
            if self.branch == 1 or not self._is_at(gap):
                return gap
            if gap.limit:
                return self._other_arc(gap)
        motion_curve = self.follower.motion_curve
        if motion_curve is None or motion_curve.curve is None:
            return None
        from gimcli.motion.motion_curve import arrival

        along = arrival(motion_curve.curve, start, single)
        return self._around(settled(self.mechanism, start), self.place, along)

    def _other_arc(self, gap: ArcPassage) -> ArcPassage:
        """Return the gap on the other of the two arcs that meet at a limit."""
        if self.branch > 2:
            raise UsageError(f"branch {self.branch}: only 2 arcs meet at the start position, which is a limit")
        self.branch = 1
        return gap.other_side().mirrored()

    def _is_at(self, gap: Gap) -> bool:
        """Return whether the present position is the singular position of a gap."""
        return abs(gap.centre - self.place) <= BEYOND * max(1.0, abs(self.place))

    # -- rows ---------------------------------------------------------------------------

    def go(self, path: FollowedPath) -> None:
        """Solve the next rows (`time` and `inputs` of the path are given), and record the events."""
        i, n = 0, len(path.time)
        while i < n:
            if self.ended is not None:
                path.codes[i:] = int(self.ended)
                self._mirror(path, i, n)
                return
            if self.waiting is not None:
                i = self._wait(path, i)
                continue
            j = n if not self.legs else i + int(np.searchsorted(path.time[i:], self.leg.last, side="right"))
            i = self._rows(path, i, j)
            if i == j < n and self.ended is None and self.waiting is None:
                self._next_leg(path)

    def _rows(self, path: FollowedPath, i: int, j: int) -> int:
        """Solve rows i..j of the leg; return the first row that is not solved yet."""
        if i == j:
            return i
        leg = self.leg
        self._mirror(path, i, j)
        s = leg.places(path.time[i:j], path.inputs[:, i:j])
        self._set_progress(i, j)
        sub, number = self._follow(path, slice(i, j), s)
        turning = self._change_branch(path)
        upto = self._copy(path, i, j, sub, number)
        if turning is not None:
            return min(upto, i + int(np.searchsorted(s, turning, side="right")))
        self.place = float(s[upto - 1 - i]) if upto > i else self.place
        self._note(path)
        if sub.limit is not None:
            self._blocked(path, sub, upto)
        elif path.time[j - 1] == leg.last:
            self._come_to_end(path)
        return upto

    def _follow(self, path: FollowedPath, rows: slice, s: FloatArray) -> tuple[FollowedPath, IntArray | None]:
        """Solve some rows at coordinates s (rows,); return the path, and the rows' indices in it if it is refined."""
        step = np.diff(s)
        longest = max(float(np.max(step, initial=0.0)), float(s[0]) - self.place)
        if len(s) == len(path.time) and np.min(step, initial=1.0) > 0.0 and fine(longest, self.leg.turn):
            whole = FollowedPath(s, path.inputs, path.z, path.codes, path.residual, path.work)
            return self.follower.follow(whole), None
        new = np.append(True, step > 0.0)
        grid, own = dense(self.place, s[new], self.leg.turn)
        values = self.leg.inputs(grid)
        values[:, own] = path.inputs[:, rows][:, new]
        return self.follower.follow(FollowedPath.empty(len(path.z), grid, values)), own[np.cumsum(new) - 1]

    def _copy(self, path: FollowedPath, i: int, j: int, sub: FollowedPath, number: IntArray | None) -> int:
        """Copy a followed path to rows i..j; return the first row beyond a limit, or j."""
        if number is not None:
            path.z[:, i:j], path.codes[i:j] = sub.z[:, number], sub.codes[number]
            path.residual[i:j] = sub.residual[number]
            total = np.append(0.0, np.cumsum(sub.work))
            path.work[i:j] = np.diff(total[np.append(0, number + 1)])
        bad = np.flatnonzero(path.codes[i:j] == Status.LIMIT) if sub.limit is not None else path.codes[:0]
        return i + int(bad[0]) if len(bad) else j

    def _mirror(self, path: FollowedPath, i: int, j: int) -> None:
        """Set the inputs and the parameter of rows, which differ from the laws after the input has reversed."""
        if path.parameter is not None:
            path.inputs[:, i:j] = self.leg.values(path.time[i:j])
            curve = None if self.on_line or self.follower.motion_curve is None else self.follower.motion_curve.curve
            path.parameter[i:j] = self.leg.parameter(path.time[i:j]) * (1.0 if curve is None else curve.span)

    def _set_progress(self, i: int, j: int) -> None:
        if self.progress is not None:
            progress = self.progress
            self.follower.progress = lambda rows, of: progress(i + (j - i) * rows // max(of, 1), j)

    # -- reversals of the laws -----------------------------------------------------------

    def _next_leg(self, path: FollowedPath) -> None:
        """Follow the motion to the end of the leg, and start the next one."""
        follower, leg = self.follower, self.leg
        if follower.reached < leg.goal:
            sub = follower.run_to(dense(self.place, np.array([leg.goal]), leg.turn)[0])
            turning = self._change_branch(path)
            if turning is not None:
                self._next_leg(path)
                return
            if sub.limit is not None:
                self.place = min(leg.goal, sub.limit)
                self._note(path)
                self._blocked(path, sub, len(path.time))
                return
        self.place = leg.goal
        self._note(path)
        self._come_to_end(path)
        self._enter(self.legs.popleft(), follower.gap_at(leg.goal), leg.goal)

    def _enter(self, leg: Leg, gap: Gap | None, goal: float) -> None:
        """Start the next leg, which returns from the end of the last one."""
        before, self.leg = self.follower, leg
        if gap is not None:
            self._resume(leg.sense * leg.begin, gap.mirrored())
            if -gap.centre <= self.place or self._is_at(gap.mirrored()):
                self.noted.append(-gap.centre)
            return
        row = before.at(goal)
        self.follower, self.place, self.noted = self.follow(leg), leg.sense * leg.begin, []
        row.time = self.place
        self.follower.begin(row, before.sign)

    def _resume(self, place: float, gap: Gap) -> None:
        """Continue the motion on the leg from a coordinate that is in a gap."""
        self.follower, self.place, self.noted = self.follow(self.leg), place, []
        self.ended = None if self.follower.enter(gap) else Status.SINGULAR

    def _come_to_end(self, path: FollowedPath) -> None:
        """Record whether the leg ends at a limit."""
        gap = self.follower.gap_at(self.leg.goal)
        if gap is not None and gap.limit and self._is_at(gap):
            self._touch(path, gap, self.leg.last)

    def _touch(self, path: FollowedPath, gap: Gap, time: float) -> None:
        """Record that the law reaches a limit at a time, but does not exceed it."""
        if time not in [known for known, _ in path.touched]:
            path.touched.append((time, tuple(self.leg.inputs(np.array([gap.centre]))[:, 0].tolist())))

    def _note(self, path: FollowedPath, *gaps: Gap) -> None:
        """Record the meetings of branches that the motion has reached, each once."""
        for gap in gaps or self.follower.bridges:
            if self._is_new(gap, self.place):
                self.noted.append(gap.centre)
                path.met(self.leg.time_at(gap.centre), gap, self.leg.inputs(np.array([gap.centre]))[:, 0])

    def _is_new(self, gap: Gap, place: float) -> bool:
        """Return whether a gap is a meeting of branches, reached at a coordinate and not recorded yet."""
        near = SAME * self.leg.turn
        known = gap.limit or any(abs(gap.centre - centre) <= near for centre in self.noted)
        return not known and gap.centre <= place + BEYOND * max(1.0, abs(place))

    # -- branches ------------------------------------------------------------------------

    def _change_branch(self, path: FollowedPath) -> float | None:
        """Change to the chosen branch at the first change point; return its coordinate, None if none was reached."""
        if self.branch == 1:
            return None
        met = [gap for gap in self.follower.bridges if self._is_new(gap, self.leg.goal)]
        if not met:
            return None
        gap, motion_curve = met[0], self.follower.motion_curve
        assert motion_curve is not None
        from gimcli.motion.motion_curve import direction

        row = gap.at(gap.centre)
        along = None if motion_curve.curve is None else direction(motion_curve.curve, gap, self.leg.sense)
        found = self._around(row.x + 1j * row.y, gap.centre, along)
        self.follower, self.place = self.follow(self.leg), gap.centre
        if found is None or not self.follower.enter(found):
            raise UsageError("branch: the branch cannot be followed from the change point")
        self._note(path, gap)
        return gap.centre

    def _around(self, z: ComplexArray, place: float, along: FloatArray | None) -> Gap | None:
        """Return the passage of a singular position on the chosen branch; None if there is none."""
        motion_curve, branch = self.follower.motion_curve, self.branch
        self.branch = 1
        return None if motion_curve is None else motion_curve.around(z, place, self.leg.sense, branch, along)

    def check_branch_taken(self) -> None:
        """Raise UsageError if no change point was reached at which the chosen branch could be followed."""
        if self.branch > 1:
            raise UsageError(f"branch {self.branch}: the law reaches no change point; see `gim singularities`")

    # -- limits --------------------------------------------------------------------------

    def _blocked(self, path: FollowedPath, sub: FollowedPath, row: int) -> None:
        """Stop, skip or reverse at a limit."""
        assert sub.limit is not None
        limit, leg, time = self.follower.limit_ahead, self.leg, self.leg.time_at(sub.limit)
        if path.limit is None:
            path.limit = time
        self.ended = Status.LIMIT
        if row < len(path.time) and sub.codes[-1] != Status.LIMIT:
            self.ended = Status(int(sub.codes[-1]))
        if limit is None:
            return
        if self.at_limit == "reverse":
            q = leg.sense * limit.centre
            path.turned_back.append((time, tuple(leg.inputs(np.array([limit.centre]))[:, 0].tolist())))
            self.legs = deque(later.reflected(q) for later in self.legs)
            self.leg = leg.reflected(q, time)
            self._resume(self.leg.sense * self.leg.begin, limit.other_side())
        elif self.at_limit == "skip" and leg.line is not None:
            self.waiting = self._back(limit, time)
            self.ended = None if self.waiting is not None else Status.LIMIT

    def _back(self, limit: ArcPassage, time: float) -> tuple[float, Gap] | None:
        """Return the time at which the law returns to the interval between limits that it has left, and the passage."""
        passages = [limit.mirrored()]
        turning = len(self.mechanism.actuators) == 1 and self.mechanism.actuators[0].rotary
        other = (
            self.follower.motion_curve.other_end(limit) if turning and self.follower.motion_curve is not None else None
        )
        if other is not None and abs(other.q - limit.q) < TURN:
            passages.append(other)
        wraps = len(passages) > 1
        for leg in (self.leg, *self.legs):
            begin = max(
                leg.sense * leg.begin,
                leg.sense * float(leg.parameter(np.array([time]))[0]) if leg is self.leg else -math.inf,
            )
            for passage in passages:
                if passage.sense != leg.sense:
                    continue
                rounds = math.ceil((begin - passage.centre) / TURN) if wraps else 0
                entry = passage.centre + rounds * TURN
                if begin <= entry <= leg.goal:
                    while self.leg is not leg:
                        self.leg = self.legs.popleft()
                    return leg.time_at(entry), passage.shifted(rounds * leg.sense * TURN)
        return None

    def _wait(self, path: FollowedPath, i: int) -> int:
        """Leave rows empty until the input is reachable again; return the first row that is."""
        assert self.waiting is not None
        time, gap = self.waiting
        j = i + int(np.searchsorted(path.time[i:], time, side="left"))
        path.codes[i:j] = int(Status.LIMIT)
        if j < len(path.time):
            self.waiting = None
            self._resume(gap.centre, gap)
        return j
