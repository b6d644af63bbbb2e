"""Positions over a grid of inputs: in closed form by one compiled call, or by following each line of the grid."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import islice, product
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from gimcli.errors import UnassembledError
from gimcli.kernels import scatter as kernels
from gimcli.kernels.plan_steps import WIDTH
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembly
from gimcli.motion.legs import dense, straight
from gimcli.motion.linked_inputs import followed_line
from gimcli.motion.solve import follower_of, start_position
from gimcli.positions.dispatch import choose, plain
from gimcli.positions.newton import Run
from gimcli.positions.program import by_numbers, plan_program
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import allowed, holds
from gimcli.structure.steps import Plan

if TYPE_CHECKING:
    from concurrent.futures import Executor

Result = TypeVar("Result")

MOST_SIDES = 6
"""Greatest number of steps with two solutions for which all combinations are solved; else only the drawn one."""

POSITION = 4e-7
"""Seconds for a step of one position, interpreted."""

PART = 1 << 15
"""Number of positions in a part of the grid, in closed form."""

STARTS = (0.5, 0.2, 0.8, 0.35, 0.65, 0.05, 0.95)
"""Fractions of a line at which it is started if the position closest to the drawing cannot be assembled."""


@dataclass(frozen=True)
class InputGrid:
    """Inputs evenly spaced over their ranges; the last one changes fastest."""

    low: FloatArray  # (inputs,)
    high: FloatArray
    turning: tuple[bool, ...]  # whether the range is a full turn, so that its end equals its start
    count: int  # number of values of each input that is not constant

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of values of every input; 1 if it is constant."""
        return tuple(self.count if b > a else 1 for a, b in zip(self.low, self.high, strict=True))

    @property
    def rows(self) -> int:
        """Number of positions."""
        return math.prod(self.counts)

    def axis(self, k: int) -> FloatArray:
        """Return the values of an input."""
        return np.linspace(self.low[k], self.high[k], self.counts[k], endpoint=not self.turning[k])

    def values(self, first: int, last: int) -> FloatArray:
        """Return the inputs (inputs, rows) of rows first..last."""
        index = np.unravel_index(np.arange(first, last), self.counts)
        return np.array([self.axis(k)[i] for k, i in enumerate(index)])


@dataclass
class Scatterer:
    """Solves the positions of one point over a grid, in independent parts."""

    mechanism: Mechanism
    on: tuple[int, int, complex]  # nodes u, v and a factor: the point is z_u + factor (z_v - z_u)
    grid: InputGrid  # of the inputs that follow no other
    tolerance: float = 1e-10
    run: Run = plain
    plan: Plan = field(init=False)

    def __post_init__(self) -> None:
        self.plan = make_plan(self.mechanism)

    @property
    def closed(self) -> bool:
        """Whether every step of the plan has a closed form, and the linkage turns no gears."""
        return not self.plan.coupled and not self.mechanism.complete

    @property
    def sides(self) -> list[FloatArray]:
        """The combinations of signs (branches,) that are solved; only the drawn one if there are coupled groups."""
        count = self.plan.branches
        if not self.closed or count > MOST_SIDES:
            return [start_position(self.mechanism, self.plan, self.mechanism.drawn_inputs, plain, self.tolerance).signs]
        return [np.array(turn) for turn in product((1.0, -1.0), repeat=count)]

    @property
    def part(self) -> int:
        """Number of rows of a part; without closed form one line: all values of the last input."""
        return PART if self.closed else self.grid.counts[-1]

    @property
    def parts(self) -> int:
        """Number of parts."""
        return -(-self.grid.rows // self.part)

    @property
    def work(self) -> float:
        """Estimated seconds of interpreted work."""
        return self.grid.rows * len(self.sides) * len(self.plan.steps) * POSITION

    def solve(self, number: int) -> ComplexArray:
        """Return the point (sides, rows) of a part, NaN if there is no assembled position."""
        first = number * self.part
        last = min(first + self.part, self.grid.rows)
        values = self._inputs(first, last)
        return self._in_closed_form(values) if self.closed else _line(self, values)[None, :]

    def ready(self) -> None:
        """Compile the kernel before several threads use it."""
        self._in_closed_form(self._inputs(0, 0))

    def _inputs(self, first: int, last: int) -> FloatArray:
        """Return all inputs (actuators, rows) of rows first..last."""
        values = np.zeros((len(self.mechanism.actuators), last - first))
        values[list(self.mechanism.drivers)] = self.grid.values(first, last)
        return self.mechanism.coupled(values)

    def _in_closed_form(self, values: FloatArray) -> ComplexArray:
        program = plan_program(self.mechanism, self.plan)
        compiled, lanes = self.run is not plain, program.lanes(WIDTH)
        w, tables = (lanes.reshape(-1), program.arrays) if compiled else (by_numbers(lanes), program.tables)
        on = np.array([*self.on[:2], self.on[2].real, self.on[2].imag])
        found = np.empty((len(self.sides), values.shape[1], 2))
        bound = allowed(self.mechanism, self.tolerance)
        with np.errstate(all="ignore"):
            for sign, out in zip(self.sides, found, strict=True):
                self.run(kernels.scatter)(w, tables, program.at, values, sign, on, bound, out)
        return np.asarray(found[..., 0] + 1j * found[..., 1])


def cores() -> int:
    """Return the number of processors available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def scattered(job: Scatterer, numbers: Iterable[int], workers: int | None = None) -> Iterator[tuple[int, ComplexArray]]:
    """Yield (number, point) of parts as they are solved, on all cores: in threads if compiled, else in processes."""
    from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

    workers = workers or cores()
    if workers == 1 or (job.run is plain and job.closed):
        yield from ((k, job.solve(k)) for k in numbers)
        return
    if job.closed:
        job.ready()
    pool = ThreadPoolExecutor(workers) if job.closed else ProcessPoolExecutor(workers)
    yield from as_finished(pool, job.solve, numbers, 2 * workers)


def as_finished(
    pool: Executor, call: Callable[[int], Result], numbers: Iterable[int], most: int
) -> Iterator[tuple[int, Result]]:
    """Yield number and result of each call as it is finished, and end the pool; at most `most` wait (memory)."""
    from concurrent.futures import FIRST_COMPLETED, wait

    todo = iter(numbers)
    try:
        waiting = {pool.submit(call, k): k for k in islice(todo, most)}
        while waiting:
            for done in wait(waiting, return_when=FIRST_COMPLETED).done:
                number = waiting.pop(done)
                yield number, done.result()
                waiting |= {pool.submit(call, k): k for k in islice(todo, 1)}
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def with_kernel(job: Scatterer, jit: str, notify: Callable[[str], None] | None = None) -> Scatterer:
    """Choose interpreted or compiled kernels for a job, by its work; lines are short and always interpreted."""
    if job.closed:
        job.run = choose(jit, job.work, notify, ("scatter",))
    return job


def _line(job: Scatterer, values: FloatArray) -> ComplexArray:
    """Return the point (rows,) along a line of inputs (actuators, rows), followed in both senses from a start row."""
    found = np.full(values.shape[1], complex(math.nan, math.nan))
    for k in _entries(job, values):
        if job.mechanism.complete:
            with suppress(UnassembledError):
                return _points(job, *followed_line(job.mechanism, values, k))
            continue
        start = start_position(job.mechanism, job.plan, values[:, k], plain, job.tolerance)
        if start.status is Status.OK and start.gap is None:  # a singular position belongs to several branches
            found[k:] = _followed(job, start, values[:, k:])
            found[: k + 1] = _followed(job, start, values[:, k::-1])[::-1]
            break
    return found


def _entries(job: Scatterer, values: FloatArray) -> list[int]:
    """Return the start rows to try: that closest to the drawn input, then others."""
    rows, last = values.shape[1], job.mechanism.drivers[-1]
    nearest = int(np.argmin(np.abs(values[last] - job.mechanism.drawn_inputs[last])))
    return [nearest, *(min(int(part * rows), rows - 1) for part in STARTS)]


def _followed(job: Scatterer, start: Assembly, inputs: FloatArray) -> ComplexArray:
    """Return the point (rows,) along inputs (actuators, rows) from a start at the first row, NaN beyond a limit."""
    mechanism, rows = job.mechanism, inputs.shape[1]
    z = np.full((len(mechanism.nodes), rows), complex(math.nan, math.nan))
    z[:, 0] = start.row.x + 1j * start.row.y
    if rows > 1:
        leg = straight(mechanism, inputs[:, 0], inputs[:, -1])
        follower, place = follower_of(mechanism, job.plan, leg, plain, job.tolerance), leg.sense * leg.begin
        follower.begin(
            replace(start.row, time=place), start.signs
        )  # its present time is the input of an earlier motion
        grid, own = dense(place, np.linspace(place, leg.goal, rows)[1:], leg.turn)
        path = follower.run_to(grid)
        z[:, 1:] = np.where(path.codes[own] == Status.OK, path.z[:, own], complex(math.nan, math.nan))
    return _points(job, z, inputs)


def _points(job: Scatterer, z: ComplexArray, inputs: FloatArray) -> ComplexArray:
    """Return the point (rows,) of positions (nodes, rows) at inputs (actuators, rows), NaN where they are wrong."""
    good, (u, v, factor) = holds(job.mechanism, z, inputs, job.tolerance), job.on
    return np.where(good, z[u] + factor * (z[v] - z[u]), complex(math.nan, math.nan))
