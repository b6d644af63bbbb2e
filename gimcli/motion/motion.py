"""A motion: finite displacements from the solved start along all the actuators' laws."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.assemble import Assembly
from gimcli.motion.effort import choose, gim_work, newton_work
from gimcli.motion.follow import Follower, Path
from gimcli.motion.inputs import law_inputs, pace
from gimcli.motion.options import Options
from gimcli.motion.start import STEPS_A_TURN, leave_singular, start_position
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import allowed, residual
from gimcli.structure.steps import Plan

Tell = Callable[[str], None]
Progress = Callable[[int, int], None]


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
    options = options or Options()
    time = np.arange(steps + 1) / steps
    inputs = law_inputs(mechanism)
    plan = make_plan(mechanism, closed_forms=options.method != "newton")
    run = choose(options.jit, newton_work(plan, max(steps, STEPS_A_TURN)), tell)
    values = inputs(time)
    start = start_position(mechanism, plan, values[:, 0], run, options.tolerance)
    follower = Follower(mechanism, plan, inputs, run, options.tolerance)
    follower.progress = progress
    way = pace(mechanism, inputs(np.linspace(0.0, 1.0, 65)))
    follower.turn = 1.0 / max(way, 1e-3)
    if start.status is Status.SINGULAR or start.foreseen is not None:
        start = leave_singular(follower, start)
    elif start.status is Status.OK:
        follower.begin(start.row, start.signs)
    if start.status is not Status.OK:
        return _nothing(mechanism, time, values, start)
    path = _along(follower, time, max(1, math.ceil(way * STEPS_A_TURN / steps)))
    z = np.concatenate([(start.row.x + 1j * start.row.y)[:, None], path.x + 1j * path.y], axis=1)
    codes = np.concatenate([[int(start.status)], path.status]).astype(np.int64)
    work = np.concatenate([[start.work], path.work])
    if options.method != "gim":
        return _judged(mechanism, plan, time, values, z, codes, work, path, options)
    z, codes, work, rows = _swept(mechanism, values, z, codes, options, tell)
    motion = _judged(mechanism, plan, time, values, z, codes, work, path, options)
    return replace(motion, exchanged=tuple(float(time[k]) for k in rows))


def _nothing(mechanism: Mechanism, time: FloatArray, values: FloatArray, start: Assembly) -> Motion:
    """Return a motion without a start: every row keeps its reason."""
    rows = len(time)
    empty = np.full((len(mechanism.nodes), rows), complex(math.nan, math.nan))
    z = start.row.x + 1j * start.row.y
    worst = residual(mechanism, z[:, None], values[:, :1], names=True).worst[0]
    return Motion(
        mechanism,
        time,
        values,
        empty,
        np.full(rows, int(start.status)),
        np.full(rows, math.nan),
        np.zeros(rows),
        z,
        worst,
    )


def _along(follower: Follower, time: FloatArray, parts: int) -> Path:
    """Follow the rows after the first, each step in some parts."""
    steps = len(time) - 1
    if parts == 1:
        return follower.follow(time[1:])
    fine = np.arange(1, parts * steps + 1) / (parts * steps)
    fine[parts - 1 :: parts] = time[1:]
    path = follower.follow(fine)
    rows = slice(parts - 1, None, parts)
    work = path.work.reshape(steps, parts).sum(axis=1)
    return Path(path.x[:, rows], path.y[:, rows], path.status[rows], path.error[rows], work, path.bridged, path.limit)


def _swept(
    mechanism: Mechanism,
    values: FloatArray,
    z: ComplexArray,
    codes: IntArray,
    options: Options,
    tell: Tell | None,
) -> tuple[ComplexArray, IntArray, FloatArray, list[int]]:
    """Solve all rows by sweeps; the continuous motion z tells whether they stayed on its branch.

    Returns the rows after which the sequence was exchanged too.
    """
    from gimcli.motion.exchange import Passage
    from gimcli.motion.sweeping import Sweeper

    sweeper = Sweeper(mechanism, options, choose("off", 0.0))
    sweeper.run = choose(options.jit, gim_work(len(sweeper.moves), values.shape[1]), tell)
    good = codes == Status.OK
    rows = int(np.flatnonzero(good)[-1]) + 1 if good.any() else 0
    swept = Passage(sweeper, values[:, :rows], z[:, :rows]).run()
    exact, z, codes, work = z, z.copy(), codes.copy(), np.zeros(len(codes))
    z[:, :rows], work[:rows] = swept.z, swept.work
    unsolved = swept.codes
    if sweeper.plan.surplus:  # sweeps stall on a contradiction too
        error = residual(mechanism, exact[:, :rows], values[:, :rows]).total
        contradicts = (unsolved != Status.OK) & ~(error <= allowed(mechanism, options.tolerance))
        unsolved = np.where(contradicts, int(Status.CONTRADICTORY), unsolved)
    codes[:rows] = np.where(good[:rows], unsolved, codes[:rows])
    return z, codes, work, swept.exchanged


def _judged(
    mechanism: Mechanism,
    plan: Plan,
    time: FloatArray,
    values: FloatArray,
    z: ComplexArray,
    codes: IntArray,
    work: FloatArray,
    path: Path,
    options: Options,
) -> Motion:
    """Check every row by a residual that nothing of the solution enters; empty those that fail."""
    start, error = z[:, 0].copy(), residual(mechanism, z, values).total
    wrong = ~(error <= allowed(mechanism, options.tolerance, options.method == "gim"))
    bad_sum = Status.CONTRADICTORY if plan.surplus > 0 else Status.NOT_CONVERGED
    codes = np.where(wrong & (codes == Status.OK), int(bad_sum), codes)
    bad = codes != Status.OK
    z[:, bad] = complex(math.nan, math.nan)
    error = np.where(bad, math.nan, error)
    worst = ""
    if bad[0]:
        worst = residual(mechanism, start[:, None], values[:, :1], names=True).worst[0]
    return Motion(mechanism, time, values, z, codes, error, work, start, worst, path.limit, tuple(path.bridged))
