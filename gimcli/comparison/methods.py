"""The methods that are compared: the solution of a motion, its operations and its time.

The time is the processor time from the assembled start to the last position, because other programs do not add to
it. It is the least of several runs. The runs are made in rounds over all methods, so that a slowdown of the machine
affects all methods alike. The preparation of a method (plan, sequence, equations) and the assembly of the start are
not timed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from gimcli.comparison.operations import Cost, coordinates_cost, plan_cost, sweep_cost
from gimcli.comparison.textbook_coordinates import COORDINATES, Coordinates, Followed, follow
from gimcli.gim.sequence_switching import SwitchingState
from gimcli.gim.sweeper import Sweeper
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembly
from gimcli.motion.legs import STEPS_A_TURN
from gimcli.motion.motion import Motion, trace
from gimcli.motion.start import start_position
from gimcli.positions.inputs import law_inputs, pace
from gimcli.positions.newton import Run
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.steps import Plan


@dataclass(frozen=True)
class Timing:
    """Repetitions of a run for the measurement of its time."""

    rounds: int = 3
    repeats: int = 40  # runs in one round, at most
    budget: float = 0.05  # [s] processor time after which a round makes no further run
    total: float = 1.0  # [s] approximate limit for the rounds of all methods together

    def shared(self, clocks: int) -> Timing:
        """Return the timing with the total time divided among a number of clocks."""
        return replace(self, budget=min(self.budget, self.total / max(1, self.rounds * clocks)))


@dataclass(frozen=True)
class MotionTask:
    """A motion to be solved from an assembled start."""

    mechanism: Mechanism
    steps: int
    inputs: FloatArray  # (actuators, rows)
    z: ComplexArray  # (nodes, rows) positions of the continuous motion
    run: Run
    jit: str  # "on" or "off"

    @property
    def parts(self) -> int:
        """Number of rows that path following solves per step of the user."""
        turns = pace(self.mechanism, law_inputs(self.mechanism)(np.linspace(0.0, 1.0, 65)))
        return max(1, math.ceil(turns * STEPS_A_TURN / self.steps))


@dataclass(frozen=True)
class Outcome:
    """Result of one method for one motion and one tolerance."""

    z: ComplexArray  # (nodes, rows), NaN where not solved
    good: BoolArray  # (rows,) whether the row was solved
    work: FloatArray  # (rows,) sweeps or iterations
    cost: Cost
    run: Callable[[], object]  # repeats the solution, to measure its time
    prepare: Callable[[], object] | None = None  # the part of `run` that is preparation
    reason: str = ""  # status word of the missing rows


class Solver(Protocol):
    """A method prepared for a motion."""

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion to a tolerance."""


@dataclass(frozen=True)
class MotionMethod:
    """A method of `gim`, or a reference method that only this comparison has."""

    name: str
    label: str
    options: str  # options of the command line that select the method; "" for a reference
    prepare: Callable[[MotionTask], Solver]


class Clock:
    """The least time of a run and the least time of its preparation."""

    def __init__(self, outcome: Outcome, timing: Timing) -> None:
        self.outcome, self.timing = outcome, timing
        self.whole, self.preparation = math.inf, math.inf

    def round(self) -> None:
        """Measure one round."""
        self.whole = min(self.whole, fastest(self.outcome.run, self.timing))
        if self.outcome.prepare is not None:
            self.preparation = min(self.preparation, fastest(self.outcome.prepare, self.timing))

    @property
    def long(self) -> bool:
        """Return whether one run takes longer than the budget of all rounds; a second round is then not made."""
        return math.isfinite(self.whole) and self.whole > self.timing.rounds * self.timing.budget

    @property
    def seconds(self) -> float:
        """Time of the whole motion without preparation [s]."""
        preparation = self.preparation if math.isfinite(self.preparation) else 0.0
        return max(self.whole - preparation, 0.0)


def fastest(run: Callable[[], object], timing: Timing) -> float:
    """Return the least processor time of several runs [s]."""
    best, total = math.inf, 0.0
    for _ in range(timing.repeats):
        begin = time.process_time()
        run()
        taken = time.process_time() - begin
        best, total = min(best, taken), total + taken
        if total > timing.budget:
            break
    return best


class Sweeps:
    """The Geometrical-Iterative Method with the sequence that a strategy finds."""

    def __init__(self, task: MotionTask, strategy: str) -> None:
        self.task, self.strategy = task, strategy
        self.sweeper = Sweeper(task.mechanism, self._options(1.0), task.run)
        self.sequence, self.moves = self.sweeper.sequence, self.sweeper.moves

    def _options(self, tolerance: float) -> Options:
        return Options("gim", self.strategy, tolerance, self.task.jit)

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion by `trace`; only the sweeps are timed."""
        task, options = self.task, self._options(tolerance)
        motion = trace(task.mechanism, task.steps, options)
        self._set(options)
        first = self.sweeper.settle(task.inputs[:, 0], task.mechanism.drawn).z

        def run() -> None:
            self._set(options)
            SwitchingState(self.sweeper, task.inputs, task.z).run(first)

        cost, reason = sweep_cost(task.mechanism, self.moves), missing_reason(motion.overall, motion.good)
        return Outcome(motion.z, motion.good, motion.work, cost, run, reason=reason)

    def _set(self, options: Options) -> None:
        self.sweeper.options, self.sweeper.sequence, self.sweeper.moves = options, self.sequence, self.moves


class Following:
    """Path following of this library: Newton-Raphson on base nodes, with or without closed forms."""

    def __init__(self, task: MotionTask, method: str) -> None:
        self.task, self.method = task, method

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion by `trace`; the preparation is timed separately and subtracted."""
        task = self.task
        options = Options(self.method, tolerance=tolerance, jit=task.jit)
        motion = trace(task.mechanism, task.steps, options)

        def run() -> Motion:
            return trace(task.mechanism, task.steps, options)

        def prepare() -> Assembly:
            return start_position(task.mechanism, self._plan(), task.inputs[:, 0], task.run, tolerance)

        cost = plan_cost(task.mechanism, self._plan(), task.parts)
        reason = missing_reason(motion.overall, motion.good)
        return Outcome(motion.z, motion.good, motion.work, cost, run, prepare, reason)

    def _plan(self) -> Plan:
        return make_plan(self.task.mechanism, closed_forms=self.method != "newton")


class Reference:
    """Textbook Newton-Raphson in the coordinates of multibody programs."""

    def __init__(self, task: MotionTask, coordinates: str) -> None:
        self.task = task
        self.system: Coordinates = COORDINATES[coordinates](task.mechanism)

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion from its assembled start, each row from the previous one."""
        task = self.task

        def run() -> Followed:
            return follow(self.system, task.inputs, task.z[:, 0], tolerance, task.run)

        found = run()
        reason = missing_reason(Status.NOT_CONVERGED, found.good)
        return Outcome(found.z, found.good, found.iterations, coordinates_cost(self.system), run, reason=reason)


def missing_reason(status: Status, good: BoolArray) -> str:
    """Return the status word if a row was not solved, "" if all rows were solved."""
    return "" if good.all() else status.word


METHODS: tuple[MotionMethod, ...] = (
    *(
        MotionMethod(f"gim-{name}", f"gim, {name}", f"--method gim --strategy {name}", partial(Sweeps, strategy=name))
        for name in ("classic", "spectral")
    ),
    *(MotionMethod(name, name, f"--method {name}", partial(Following, method=name)) for name in ("newton", "auto")),
    *(MotionMethod(name, f"{name} coordinates", "", partial(Reference, coordinates=name)) for name in COORDINATES),
)
"""All methods, in the order of the report."""
