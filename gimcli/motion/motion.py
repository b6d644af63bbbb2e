"""A motion: positions along the laws of all actuators, from the solved start position."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.assemble import Assembly
from gimcli.motion.follow import FollowedPath, PassedMeeting, Stop
from gimcli.motion.law_follower import LawFollower
from gimcli.motion.legs import STEPS_A_TURN
from gimcli.motion.side_by_side import side_by_side
from gimcli.motion.solve import moved, start_position
from gimcli.positions.dispatch import choose, gim_work, plain, plan_work, with_earlier
from gimcli.positions.inputs import law_inputs
from gimcli.positions.newton import Run
from gimcli.positions.options import Options
from gimcli.progress import Notify, Progress
from gimcli.status import Status
from gimcli.structure.derived import derived
from gimcli.structure.drive_check import require_driven_if_doubtful
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import allowed, coupling_errors, holds, residual
from gimcli.structure.steps import Plan

EVENTS = ("touched", "bridged", "meetings", "exchanged", "turned_back")
"""Fields of a motion that list its events."""


PIECE = 65536
"""Number of rows that are solved together, to limit memory."""


@dataclass(frozen=True)
class Motion:
    """The positions of a motion, in the normal frame, with their status and events."""

    mechanism: Mechanism = field(repr=False)
    time: FloatArray  # (rows,) 0..1
    inputs: FloatArray  # (actuators, rows)
    z: ComplexArray = field(repr=False)  # (nodes, rows), NaN where not solved
    codes: IntArray = field(repr=False)  # (rows,) of Status
    residual: FloatArray  # (rows,) NaN where not solved
    work: FloatArray  # (rows,) number of sweeps or iterations
    start: ComplexArray = field(repr=False)  # (nodes,) last iterate at the start, whatever its status
    worst: str = ""  # if the start could not be assembled: the constraint with the greatest error
    limit: float | None = None  # time of the first limit that the law exceeds
    touched: tuple[Stop, ...] = ()  # limits that the law reaches but does not exceed
    bridged: tuple[float, ...] = ()  # times of the singular positions passed
    meetings: tuple[PassedMeeting, ...] = field(default=(), repr=False)  # positions and inputs there
    exchanged: tuple[float, ...] = ()  # times at which the sequence of the sweeps was exchanged
    turned_back: tuple[Stop, ...] = ()  # limits at which the input reversed
    parameter: FloatArray | None = field(default=None, repr=False)  # (rows,) of the curve, if one was followed
    headings: FloatArray | None = field(default=None, repr=False)  # (n + 1, rows) tangents of the curve, if known
    parts: tuple[Motion, ...] = field(default=(), repr=False)  # of independent machines, if there are several
    options: Options | None = field(default=None, repr=False)

    @property
    def machines(self) -> tuple[Motion, ...]:
        """The motions of the independent machines; itself if there is one."""
        return self.parts or (self,)

    @property
    def solved(self) -> int:
        """Number of rows that are solved."""
        return int(self.good.sum())

    @cached_property
    def good(self) -> BoolArray:
        """(rows,) whether the position is solved."""
        return np.asarray(self.codes <= Status.TANGENT)

    @cached_property
    def status(self) -> tuple[Status, ...]:
        """The status of every row."""
        return tuple(Status(int(code)) for code in self.codes)

    @property
    def overall(self) -> Status:
        """The status of the first row that is not solved; else OK, or TANGENT if a row is."""
        bad = self.codes[~self.good]
        return Status(int(bad[0] if len(bad) else np.max(self.codes)))

    def rows(self, chosen: IntArray) -> Motion:
        """Return the motion with only the chosen rows, and all its events."""
        return replace(
            self, time=self.time[chosen], inputs=self.inputs[:, chosen], z=self.z[:, chosen], codes=self.codes[chosen],
            residual=self.residual[chosen], work=self.work[chosen],
            parameter=None if self.parameter is None else self.parameter[chosen],
            headings=None if self.headings is None else self.headings[:, chosen],
            parts=tuple(part.rows(chosen) for part in self.parts),
        )  # fmt: skip

    @staticmethod
    def joined(pieces: Sequence[Motion]) -> Motion:
        """Join successive pieces to one motion."""
        first = pieces[0]
        if len(pieces) == 1:
            return first

        def joint(part: str) -> Any:
            return np.concatenate([getattr(piece, part) for piece in pieces], axis=-1)

        events: dict[str, Any] = {name: tuple(t for piece in pieces for t in getattr(piece, name)) for name in EVENTS}
        return replace(
            first, time=joint("time"), inputs=joint("inputs"), z=joint("z"), codes=joint("codes"),
            residual=joint("residual"), work=joint("work"),
            limit=next((piece.limit for piece in pieces if piece.limit is not None), None),
            parts=tuple(Motion.joined(own) for own in zip(*(piece.parts for piece in pieces), strict=True)), **events,
        )  # fmt: skip

    @property
    def first_status(self) -> Status:
        """The status of the start."""
        return Status(int(self.codes[0]))


def trace(
    mechanism: Mechanism, steps: int, options: Options | None = None, notify: Notify | None = None,
    progress: Progress | None = None, at_limit: str = "stop", branch: int = 1,
) -> Motion:  # fmt: skip
    """Follow the actuators' laws in `steps` steps: steps + 1 rows.

    `notify` is called before a compilation, `progress` with the rows done and the total. `at_limit`: stop, skip or
    reverse. `branch`: number of the branch to follow at the first change point. Raises UsageError if there is no such
    branch, or if the input cannot drive it.
    """
    return next(stream(mechanism, steps, options, notify, progress, steps + 1, at_limit, branch))


def stream(
    mechanism: Mechanism, steps: int, options: Options | None = None, notify: Notify | None = None,
    progress: Progress | None = None, rows: int = PIECE, at_limit: str = "stop", branch: int = 1,
    between: Callable[[FloatArray], FloatArray] | None = None,
) -> Iterator[Motion]:  # fmt: skip
    """Follow the actuators' laws like `trace`, but yield the motion in pieces of `rows` rows.

    `between` adds rows: it returns consecutive times (rows,) with others between them.
    """
    options = options or Options()
    if len(mechanism.machines) > 1 and not options.moves:
        every = [one.mechanism for one in mechanism.machines]
        for own in every:
            require_driven_if_doubtful(own, make_plan(own), regular=bool(own.actuators))
        begun = [stream(own, steps, options, notify, progress, rows, at_limit, branch, between) for own in every]
        yield from (side_by_side(mechanism, pieces) for pieces in zip(*begun, strict=True))
        return
    inputs, pieces = law_inputs(mechanism), _pieces(steps, rows, between)
    plan = make_plan(mechanism, closed_forms=options.method != "newton")
    if mechanism.complete is not None:
        yield from _along_linkage(mechanism, plan, pieces, options, notify, steps, at_limit, branch)
        return
    kernels, work = kernel_names(plan), plan_work(plan, max(steps, STEPS_A_TURN))
    run = choose(options.jit, with_earlier(work, kernels) if notify is None else work, notify, kernels)
    start = _start(mechanism, plan, run, options.tolerance)
    require_driven_if_doubtful(mechanism, plan, start.regular)
    follower = LawFollower(mechanism, plan, run, options.tolerance, at_limit, branch)
    swept = _Swept(mechanism, options, steps + 1, notify) if options.method == "gim" else None
    last: tuple[ComplexArray, FloatArray] | None = None  # of a mechanism that is tangent in every position
    for first, time in pieces:
        path = FollowedPath.empty(len(mechanism.nodes), time, inputs(time))
        if at_limit == "reverse":
            path.parameter = np.full(len(time), math.nan)
        if first == 0:
            start = follower.begin(start, path)
        if start.status is Status.TANGENT:
            last = last or (start.row.x + 1j * start.row.y, path.inputs[:, 0])
            motion = _tangent(mechanism, path, *last, options.tolerance)
            last = motion.z[:, -1], motion.inputs[:, -1]
            yield motion
            continue
        if start.status is not Status.OK:
            yield _unsolved(mechanism, time, path.inputs, start)
            continue
        if progress is not None:
            follower.progress = _with_offset(progress, first, steps + 1)
        follower.go(path)
        if first == 0:
            path.work[0] = start.work
        if first + rows > steps:
            follower.check_branch_taken()
        motion = checked(mechanism, plan, path if swept is None else swept.path(path), options)
        yield motion if at_limit != "skip" or follower.on_line else _skipped(motion, options)


def _pieces(
    steps: int, rows: int, between: Callable[[FloatArray], FloatArray] | None
) -> Iterator[tuple[int, FloatArray]]:  # fmt: skip
    """Yield the number of the first step and the times of each piece."""
    for first in range(0, steps + 1, rows):
        time = np.arange(max(first - 1, 0), min(first + rows, steps + 1)) / steps
        yield first, (time if between is None else between(time))[first > 0 :]


def _along_linkage(
    mechanism: Mechanism, plan: Plan, pieces: Iterator[tuple[int, FloatArray]], options: Options,
    notify: Notify | None, steps: int, at_limit: str, branch: int,
) -> Iterator[Motion]:  # fmt: skip
    """Yield the pieces of a motion whose inputs follow the linkage: it is followed as a curve, with these inputs."""
    from gimcli.motion.linked_inputs import linked_motion  # imported late: few mechanisms have such inputs

    if branch > 1:
        raise UsageError("branch: where the linkage turns gears, use `gim trace --circuit --branch`")
    require_driven_if_doubtful(mechanism, plan, regular=True)
    motion, last = linked_motion(mechanism, at_limit == "reverse"), -1.0
    swept = _Swept(mechanism, options, steps + 1, notify) if options.method == "gim" else None
    for _, time in pieces:
        path = FollowedPath.empty(len(mechanism.nodes), time, law_inputs(mechanism)(time))
        motion.solve(path, at_limit == "skip", last)
        yield checked(mechanism, plan, path if swept is None else swept.path(path), options)
        last = float(time[-1])


def motion_at(mechanism: Mechanism, inputs: FloatArray, options: Options) -> Motion:
    """Return rows of a mechanism whose linkage turns gears at inputs (actuators, rows) of its one moving driver.

    The inputs are within its law; those that follow the linkage do not count.
    """
    from gimcli.motion.linked_inputs import linked_motion

    motion, time = linked_motion(mechanism, False), np.linspace(0.0, 1.0, inputs.shape[1])
    path = FollowedPath.empty(len(mechanism.nodes), time, inputs.copy())
    motion.place(path, inputs[motion.curve.main])
    return checked(mechanism, make_plan(mechanism), path, options)


def _start(mechanism: Mechanism, plan: Plan, run: Run, tolerance: float) -> Assembly:
    """Return the start of the motion along the laws; a regular one is found once for a mechanism."""
    known, key = _starts(mechanism), (plan, tolerance)
    found = known.get(key)
    if found is None:
        found = start_position(mechanism, plan, mechanism.start_inputs, run, tolerance)
        if found.regular:
            known[key] = found
    return replace(found, row=replace(found.row))  # the motion sets the time of its first row


@derived
def _starts(mechanism: Mechanism) -> dict[tuple[Plan, float], Assembly]:
    """Return the regular starts found so far, by plan and tolerance."""
    return {}


def kernel_names(plan: Plan) -> tuple[str, ...]:
    """Return the names of the compiled kernels that a motion uses."""
    return ("march", "solve_group") if plan.coupled else ("march_dyads",)


def _with_offset(progress: Progress, done: int, total: int) -> Progress:
    """Return the progress callback for the rows of a piece that starts after `done` rows."""
    return lambda rows, _: progress(done + rows, total)


def _unsolved(mechanism: Mechanism, time: FloatArray, values: FloatArray, start: Assembly) -> Motion:
    """Return a motion of empty rows, with the status of the start that was not found."""
    rows = len(time)
    empty = np.full((len(mechanism.nodes), rows), complex(math.nan, math.nan))
    z = start.row.x + 1j * start.row.y
    worst = residual(mechanism, z[:, None], values[:, :1], names=True).worst[0]
    codes = np.full(rows, int(start.status))
    return Motion(mechanism, time, values, empty, codes, np.full(rows, math.nan), np.zeros(rows), z, worst)


def _tangent(
    mechanism: Mechanism, path: FollowedPath, here: ComplexArray, begin: FloatArray, tolerance: float
) -> Motion:  # fmt: skip
    """Return the motion of a mechanism that is tangent in every position, from a position at inputs `begin`."""
    from gimcli.structure.tangency import tangent_positions

    z = tangent_positions(mechanism, here, begin, path.inputs, tolerance)
    error = residual(mechanism, z, path.inputs).total
    codes = np.where(np.isfinite(error), int(Status.TANGENT), int(Status.LIMIT))
    return Motion(mechanism, path.time, path.inputs, z, codes, error, np.zeros(len(path.time)), here)


def _skipped(motion: Motion, options: Options) -> Motion:
    """Return a motion of several inputs with further rows solved, if they are reached from the last solved row.

    The inputs change linearly from the last solved row to such a row.
    """
    mechanism, plan = motion.mechanism, make_plan(motion.mechanism)
    z, codes, error = motion.z.copy(), motion.codes.copy(), motion.residual.copy()
    if motion.first_status is not Status.OK:
        return motion
    last = int(np.flatnonzero(motion.good)[-1])
    for k in range(last + 1, len(codes)):
        found = moved(
            mechanism, plan, z[:, last], motion.inputs[:, last], motion.inputs[:, k], plain, options.tolerance
        )
        if found is None:
            continue
        own = residual(mechanism, found[:, None], motion.inputs[:, k : k + 1]).total
        if holds(mechanism, found[:, None], motion.inputs[:, k : k + 1], options.tolerance, error=own)[0]:
            z[:, k], codes[k], error[k], last = found, int(Status.OK), float(own[0]), k
    return replace(motion, z=z, codes=codes, residual=error)


class _Swept:
    """Solves all rows by sweeps; the continuous motion shows whether they are on its branch."""

    def __init__(self, mechanism: Mechanism, options: Options, rows: int, notify: Notify | None) -> None:
        from gimcli.gim.sweeper import Sweeper

        self.mechanism, self.options = mechanism, options
        self.sweeper = Sweeper(mechanism, options, choose("off", 0.0))
        self.sweeper.run = choose(options.jit, gim_work(len(self.sweeper.moves), rows), notify, ("settle_rows",))
        self.status = Status.OK  # of the last row
        self.last: tuple[FloatArray, ComplexArray] | None = None  # its inputs and positions (·, 1)

    def path(self, path: FollowedPath) -> FollowedPath:
        """Return the path with its positions solved by sweeps."""
        from gimcli.gim.sequence_switching import SwitchingState

        good = path.codes == Status.OK
        rows = int(np.flatnonzero(good)[-1]) + 1 if good.any() else 0
        z, codes, work, exchanged = np.full_like(path.z, np.nan), path.codes.copy(), np.zeros(len(path.time)), []
        codes[good] = int(self.status)
        if rows and self.status is Status.OK:
            inputs, exact = path.inputs[:, :rows], path.z[:, :rows]
            lead = 0 if self.last is None else 1
            if self.last is not None:
                inputs, exact = np.hstack([self.last[0], inputs]), np.hstack([self.last[1], exact])
            swept = SwitchingState(self.sweeper, inputs, exact).run(None if self.last is None else self.last[1][:, 0])
            z[:, :rows], work[:rows] = swept.z[:, lead:], swept.work[lead:]
            codes[:rows] = np.where(good[:rows], self._reasons(swept.codes, exact, inputs)[lead:], codes[:rows])
            exchanged = [float(path.time[max(0, k - lead)]) for k in swept.exchanged]
            self.last, self.status = (inputs[:, -1:], z[:, rows - 1 : rows]), Status(int(swept.codes[-1]))
        empty = np.full(len(path.time), math.nan)
        return replace(path, z=z, codes=codes, residual=empty, work=work, exchanged=exchanged)

    def _reasons(self, codes: IntArray, exact: ComplexArray, inputs: FloatArray) -> IntArray:
        """Return the status of unsolved rows; sweeps that stall may be due to a contradiction."""
        if not self.sweeper.plan.surplus:
            return codes
        error = residual(self.mechanism, exact, inputs).total
        contradicts = (codes != Status.OK) & ~(error <= allowed(self.mechanism, self.options.tolerance))
        return np.where(contradicts, int(Status.CONTRADICTORY), codes)


def checked(mechanism: Mechanism, plan: Plan, path: FollowedPath, options: Options) -> Motion:
    """Check every row by a residual that is independent of the solution; rows that fail become empty."""
    z, codes, start = path.z, path.codes, path.z[:, 0].copy()
    error, swept = path.residual, options.method == "gim"
    if np.isnan(np.max(error)):  # not computed yet
        rows = np.flatnonzero(np.isnan(error))
        error[rows] = residual(mechanism, z[:, rows], path.inputs[:, rows]).total
    with np.errstate(all="ignore"):  # rows without a position
        for _, own in coupling_errors(mechanism, z, path.inputs):
            np.maximum(error, own, out=error)
    good = holds(mechanism, z, path.inputs, options.tolerance, swept, error)
    if not good.all():
        bad_sum = Status.CONTRADICTORY if plan.surplus > 0 else Status.NOT_CONVERGED
        codes[~good & (codes == Status.OK)] = int(bad_sum)
    if codes.any():
        bad = codes != Status.OK
        z[:, bad] = complex(math.nan, math.nan)
        error[bad] = math.nan
    worst = ""
    if codes[0] != Status.OK:
        worst = residual(mechanism, start[:, None], path.inputs[:, :1], names=True).worst[0]
    return Motion(
        mechanism, path.time, path.inputs, z, codes, error, path.work, start, worst, path.limit, tuple(path.touched),
        tuple(path.bridged), tuple(path.meetings), tuple(path.exchanged), tuple(path.turned_back), path.parameter,
        options=options,
    )  # fmt: skip
