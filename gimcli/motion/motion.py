"""A motion: finite displacements from the solved start along all the actuators' laws."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.assemble import Assembly
from gimcli.motion.effort import choose, gim_work, plan_work
from gimcli.motion.follow import Follower, Inputs, Path
from gimcli.motion.inputs import law_inputs, pace
from gimcli.motion.options import Options
from gimcli.motion.start import STEPS_A_TURN, leave_singular, start_position
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import allowed, residual
from gimcli.structure.steps import Plan

Tell = Callable[[str], None]
Progress = Callable[[int, int], None]

ALL = [slice(None)]
"""All rows."""


@dataclass(frozen=True)
class Motion:
    """Positions over a motion, in the normal frame."""

    mechanism: Mechanism = field(repr=False)
    time: FloatArray  # (rows,) 0..1
    inputs: FloatArray  # (actuators, rows)
    z: ComplexArray = field(repr=False)  # (nodes, rows), NaN where not solved
    codes: IntArray = field(repr=False)  # (rows,) of Status
    residual: FloatArray  # (rows,) NaN where not solved
    work: FloatArray  # (rows,) sweeps or iterations
    start: ComplexArray = field(repr=False)  # (nodes,) what was found at the start, whatever its status
    worst: str = ""  # the constraint that is worst off where the start could not be assembled
    limit: float | None = None  # time of the limit that was met
    bridged: tuple[float, ...] = ()  # times of the singular positions passed
    exchanged: tuple[float, ...] = ()  # times at which sweeps went on by another sequence
    turned_back: tuple[tuple[float, tuple[float, ...]], ...] = ()  # times and inputs at which these turned back
    parameter: FloatArray | None = field(default=None, repr=False)  # (rows,) of the curve, if it was told by one
    headings: FloatArray | None = field(default=None, repr=False)  # (n + 1, rows) directions along it, if known

    @property
    def solved(self) -> int:
        """Number of rows that are ok."""
        return int(self.good.sum())

    @cached_property
    def good(self) -> NDArray[np.bool_]:
        """Tell of every row whether it is ok."""
        return np.asarray(self.codes == Status.OK)

    @cached_property
    def status(self) -> tuple[Status, ...]:
        """Every row's status."""
        return tuple(Status(int(code)) for code in self.codes)

    @property
    def overall(self) -> Status:
        """OK where every row is, else what ended the first row that is not."""
        bad = self.codes[~self.good]
        return Status(int(bad[0])) if len(bad) else Status.OK

    def rows(self, chosen: IntArray) -> Motion:
        """Return the motion with only some of its rows; its events stay."""
        return replace(
            self, time=self.time[chosen], inputs=self.inputs[:, chosen], z=self.z[:, chosen], codes=self.codes[chosen],
            residual=self.residual[chosen], work=self.work[chosen],
            parameter=None if self.parameter is None else self.parameter[chosen],
            headings=None if self.headings is None else self.headings[:, chosen],
        )  # fmt: skip

    @staticmethod
    def joined(pieces: Sequence[Motion]) -> Motion:
        """Return pieces that follow each other as one motion."""
        first, last = pieces[0], pieces[-1]
        if len(pieces) == 1:
            return first

        def joint(part: str) -> Any:
            return np.concatenate([getattr(piece, part) for piece in pieces], axis=-1)

        return Motion(
            first.mechanism, joint("time"), joint("inputs"), joint("z"), joint("codes"), joint("residual"),
            joint("work"), first.start, first.worst, last.limit, tuple(t for piece in pieces for t in piece.bridged),
            tuple(t for piece in pieces for t in piece.exchanged),
        )  # fmt: skip

    @property
    def first_status(self) -> Status:
        """The status of the start."""
        return Status(int(self.codes[0]))


def trace(
    mechanism: Mechanism, steps: int, options: Options | None = None, tell: Tell | None = None,
    progress: Progress | None = None,
) -> Motion:  # fmt: skip
    """Follow the actuators' laws in `steps` steps: steps + 1 rows.

    `tell` hears of a compilation, `progress` of rows done and rows in all.
    """
    return next(stream(mechanism, steps, options, tell, progress, rows=steps + 1))


def stream(
    mechanism: Mechanism, steps: int, options: Options | None = None, tell: Tell | None = None,
    progress: Progress | None = None, rows: int = 65536,
) -> Iterator[Motion]:  # fmt: skip
    """Follow the actuators' laws as `trace` does, but yield the motion in pieces of some rows."""
    options = options or Options()
    inputs = law_inputs(mechanism)
    plan = make_plan(mechanism, closed_forms=options.method != "newton")
    run = choose(options.jit, plan_work(plan, max(steps, STEPS_A_TURN)), tell, ("march",))
    begin = inputs(np.zeros(1))[:, 0]
    start = start_position(mechanism, plan, begin, run, options.tolerance)
    follower = Follower(mechanism, plan, inputs, run, options.tolerance)
    way = pace(mechanism, inputs(np.linspace(0.0, 1.0, 65)))
    follower.turn = 1.0 / max(way, 1e-3)
    if start.status is Status.SINGULAR or start.foreseen is not None:
        start = leave_singular(follower, start)
    elif start.status is Status.OK:
        follower.begin(start.row, start.signs)
    pieces = (np.arange(first, min(first + rows, steps + 1)) / steps for first in range(0, steps + 1, rows))
    if start.status is not Status.OK:
        yield from (_nothing(mechanism, time, inputs(time), start) for time in pieces)
        return
    swept = _Swept(mechanism, options, steps + 1, tell) if options.method == "gim" else None
    parts = max(1, math.ceil(way * STEPS_A_TURN / steps))
    done, limit = 0, None
    for time in pieces:
        if progress is not None:
            follower.progress = _heard(progress, done, parts, steps + 1)
        path = _after(mechanism, time, inputs) if limit else _along(follower, time, parts, steps)
        if done == 0:
            path.work[0] = start.work
        path.limit = limit = limit or path.limit
        done += len(time)
        yield _judged(mechanism, plan, path if swept is None else swept.path(path), options)


def _after(mechanism: Mechanism, time: FloatArray, inputs: Inputs) -> Path:
    """Return rows after a limit."""
    path = Path.empty(len(mechanism.nodes), time, inputs(time))
    path.end(0)
    return path


def _heard(progress: Progress, done: int, parts: int, total: int) -> Progress:
    """Return what hears of the rows of a piece."""
    return lambda rows, _: progress(done + rows // parts, total)


def _nothing(mechanism: Mechanism, time: FloatArray, values: FloatArray, start: Assembly) -> Motion:
    """Return a motion without a start: every row keeps its reason."""
    rows = len(time)
    empty = np.full((len(mechanism.nodes), rows), complex(math.nan, math.nan))
    z = start.row.x + 1j * start.row.y
    worst = residual(mechanism, z[:, None], values[:, :1], names=True).worst[0]
    codes = np.full(rows, int(start.status))
    return Motion(mechanism, time, values, empty, codes, np.full(rows, math.nan), np.zeros(rows), z, worst)


def _along(follower: Follower, time: FloatArray, parts: int, steps: int) -> Path:
    """Follow some rows, each step in some parts."""
    if parts == 1:
        return follower.follow(time)
    first = round(float(time[0]) * steps)
    fine = np.arange(max(0, (first - 1) * parts + 1), (first + len(time) - 1) * parts + 1) / (parts * steps)
    own = slice((len(fine) - 1) % parts, None, parts)
    fine[own] = time
    path = follower.follow(fine)
    work = np.add.reduceat(path.work, np.maximum(np.arange(len(time)) * parts + own.start - parts + 1, 0))
    return Path(
        time, path.inputs[:, own], path.z[:, own], path.codes[own], np.empty(len(time)), work, ALL, path.bridged,
        path.limit,
    )  # fmt: skip


class _Swept:
    """Solves all rows by sweeps; the continuous motion tells whether they stayed on its branch."""

    def __init__(self, mechanism: Mechanism, options: Options, rows: int, tell: Tell | None) -> None:
        from gimcli.motion.sweeping import Sweeper

        self.mechanism, self.options = mechanism, options
        self.sweeper = Sweeper(mechanism, options, choose("off", 0.0))
        self.sweeper.run = choose(options.jit, gim_work(len(self.sweeper.moves), rows), tell, ("settle_rows",))
        self.status = Status.OK  # how the last row ended
        self.last: tuple[FloatArray, ComplexArray] | None = None  # inputs and positions (·, 1) there

    def path(self, path: Path) -> Path:
        """Return the path with its positions solved anew."""
        from gimcli.motion.exchange import Passage

        good = path.codes == Status.OK
        rows = int(np.flatnonzero(good)[-1]) + 1 if good.any() else 0
        z, codes, work, exchanged = np.full_like(path.z, np.nan), path.codes.copy(), np.zeros(len(path.time)), []
        codes[good] = int(self.status)
        if rows and self.status is Status.OK:
            inputs, exact = path.inputs[:, :rows], path.z[:, :rows]
            lead = 0 if self.last is None else 1
            if self.last is not None:
                inputs, exact = np.hstack([self.last[0], inputs]), np.hstack([self.last[1], exact])
            swept = Passage(self.sweeper, inputs, exact).run(None if self.last is None else self.last[1][:, 0])
            z[:, :rows], work[:rows] = swept.z[:, lead:], swept.work[lead:]
            codes[:rows] = np.where(good[:rows], self._reasons(swept.codes, exact, inputs)[lead:], codes[:rows])
            exchanged = [float(path.time[max(0, k - lead)]) for k in swept.exchanged]
            self.last, self.status = (inputs[:, -1:], z[:, rows - 1 : rows]), Status(int(swept.codes[-1]))
        return Path(path.time, path.inputs, z, codes, path.residual, work, ALL, path.bridged, path.limit, exchanged)

    def _reasons(self, codes: IntArray, exact: ComplexArray, inputs: FloatArray) -> IntArray:
        """Return why rows were not solved: sweeps stall on a contradiction too."""
        if not self.sweeper.plan.surplus:
            return codes
        error = residual(self.mechanism, exact, inputs).total
        contradicts = (codes != Status.OK) & ~(error <= allowed(self.mechanism, self.options.tolerance))
        return np.where(contradicts, int(Status.CONTRADICTORY), codes)


def _judged(mechanism: Mechanism, plan: Plan, path: Path, options: Options) -> Motion:
    """Check every row by a residual that nothing of the solution enters; empty those that fail."""
    z, codes, start = path.z, path.codes, path.z[:, 0].copy()
    error, bound = path.residual, allowed(mechanism, options.tolerance, options.method == "gim")
    for rows in path.unchecked:
        error[rows] = residual(mechanism, z[:, rows], path.inputs[:, rows]).total
    if not np.max(error) <= bound:
        bad_sum = Status.CONTRADICTORY if plan.surplus > 0 else Status.NOT_CONVERGED
        codes[~(error <= bound) & (codes == Status.OK)] = int(bad_sum)
    if codes.any():
        bad = codes != Status.OK
        z[:, bad] = complex(math.nan, math.nan)
        error[bad] = math.nan
    worst = ""
    if codes[0] != Status.OK:
        worst = residual(mechanism, start[:, None], path.inputs[:, :1], names=True).worst[0]
    return Motion(
        mechanism,
        path.time,
        path.inputs,
        z,
        codes,
        error,
        path.work,
        start,
        worst,
        path.limit,
        tuple(path.bridged),
        tuple(path.exchanged),
    )
