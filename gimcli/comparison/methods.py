"""The methods that are compared: how each solves a motion, what it costs, and how long it takes.

Timed is the way from the start to the last position: processor time, which other programs do not add
to, the least of some runs in rounds over all methods, so that a slow moment of the machine does not fall
on one of them. Not timed are what a method
prepares once (plan, sequence, equations) and the assembly of the start.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gimcli.comparison.operations import Cost, coordinates_cost, plan_cost, sweep_cost
from gimcli.comparison.textbook_coordinates import COORDINATES, Coordinates, Followed, follow
from gimcli.gim.sequence_switching import SwitchingState
from gimcli.gim.sweeper import Sweeper
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
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
    """How often a run is repeated for its time."""

    rounds: int = 3
    repeats: int = 40  # in one round, at the most
    budget: float = 0.05  # s after which no further run is made in a round
    total: float = 1.0  # s that the rounds of all methods may take together, about

    def shared(self, clocks: int) -> Timing:
        """Return the timing whose budget leaves its part to each of some clocks."""
        return replace(self, budget=min(self.budget, self.total / max(1, self.rounds * clocks)))


@dataclass(frozen=True)
class MotionTask:
    """A motion to be solved; the start has been assembled."""

    mechanism: Mechanism
    steps: int
    inputs: FloatArray  # (actuators, rows)
    z: ComplexArray  # (nodes, rows) the continuous motion
    run: Run
    jit: str  # "on" or "off"

    @property
    def parts(self) -> int:
        """Number of rows that path following solves for one of the user's steps."""
        way = pace(self.mechanism, law_inputs(self.mechanism)(np.linspace(0.0, 1.0, 65)))
        return max(1, math.ceil(way * STEPS_A_TURN / self.steps))


@dataclass(frozen=True)
class Outcome:
    """What a method gave for one motion and one tolerance."""

    z: ComplexArray  # (nodes, rows), NaN where not solved
    good: NDArray[np.bool_]  # (rows,)
    work: FloatArray  # (rows,) sweeps or iterations
    cost: Cost
    run: Callable[[], object]  # does it again, for the time
    prepare: Callable[[], object] | None = None  # what of this is preparation
    reason: str = ""  # why rows are missing


class Solver(Protocol):
    """A method prepared for a motion."""

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion to a tolerance."""
        ...


@dataclass(frozen=True)
class MotionMethod:
    """A method by name: what the tool offers, or a reference that this comparison alone has."""

    name: str
    label: str
    options: str  # of the command line; "" for a reference
    prepare: Callable[[MotionTask], Solver]


class Clock:
    """Least times of a run, and of what of it is preparation."""

    def __init__(self, outcome: Outcome, timing: Timing) -> None:
        self.outcome, self.timing = outcome, timing
        self.whole, self.preparation = math.inf, math.inf

    def round(self) -> None:
        """Time one round."""
        self.whole = min(self.whole, fastest(self.outcome.run, self.timing))
        if self.outcome.prepare is not None:
            self.preparation = min(self.preparation, fastest(self.outcome.prepare, self.timing))

    @property
    def long(self) -> bool:
        """Tell whether one run alone exceeds what all rounds may take: a second round tells nothing new."""
        return math.isfinite(self.whole) and self.whole > self.timing.rounds * self.timing.budget

    @property
    def seconds(self) -> float:
        """Time of the whole motion [s]."""
        taken_off = self.preparation if math.isfinite(self.preparation) else 0.0
        return max(self.whole - taken_off, 0.0)


def fastest(run: Callable[[], object], timing: Timing) -> float:
    """Return the least processor time of some runs [s]."""
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
    """The Geometrical-Iterative Method with the sequence of a strategy."""

    def __init__(self, task: MotionTask, strategy: str) -> None:
        self.task, self.strategy = task, strategy
        self.sweeper = Sweeper(task.mechanism, self._options(1.0), task.run)
        self.sequence, self.moves = self.sweeper.sequence, self.sweeper.moves

    def _options(self, tolerance: float) -> Options:
        return Options("gim", self.strategy, tolerance, self.task.jit)

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion by `trace`; time the sweeps alone."""
        task, options = self.task, self._options(tolerance)
        motion = trace(task.mechanism, task.steps, options)
        self._take(options)
        first = self.sweeper.settle(task.inputs[:, 0], task.mechanism.drawn).z

        def run() -> None:
            self._take(options)
            SwitchingState(self.sweeper, task.inputs, task.z).run(first)

        cost, reason = sweep_cost(task.mechanism, self.moves), told(motion.overall, motion.good)
        return Outcome(motion.z, motion.good, motion.work, cost, run, reason=reason)

    def _take(self, options: Options) -> None:
        self.sweeper.options, self.sweeper.sequence, self.sweeper.moves = options, self.sequence, self.moves


class Following:
    """The library's path following: Newton-Raphson on base nodes, with closed forms or without."""

    def __init__(self, task: MotionTask, method: str) -> None:
        self.task, self.method = task, method

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion by `trace`; what it prepares is timed apart and taken off."""
        task = self.task
        options = Options(self.method, tolerance=tolerance, jit=task.jit)
        motion = trace(task.mechanism, task.steps, options)

        def run() -> Motion:
            return trace(task.mechanism, task.steps, options)

        def prepare() -> Assembly:
            return start_position(task.mechanism, self._plan(), task.inputs[:, 0], task.run, tolerance)

        cost, reason = plan_cost(task.mechanism, self._plan(), task.parts), told(motion.overall, motion.good)
        return Outcome(motion.z, motion.good, motion.work, cost, run, prepare, reason)

    def _plan(self) -> Plan:
        return make_plan(self.task.mechanism, closed_forms=self.method != "newton")


class Reference:
    """Textbook Newton-Raphson in the coordinates of multibody programs."""

    def __init__(self, task: MotionTask, coordinates: str) -> None:
        self.task = task
        self.system: Coordinates = COORDINATES[coordinates](task.mechanism)

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion from its assembled start, each row from the one before."""
        task = self.task

        def run() -> Followed:
            return follow(self.system, task.inputs, task.z[:, 0], tolerance, task.run)

        found = run()
        reason = told(Status.NOT_CONVERGED, found.good)
        cost = coordinates_cost(self.system)
        return Outcome(found.z, found.good, found.iterations, cost, run, reason=reason)


def told(status: Status, good: NDArray[np.bool_]) -> str:
    """Return the word for what ended the first row that is missing, "" where none is."""
    return "" if good.all() else status.word


METHODS: tuple[MotionMethod, ...] = (
    *(
        MotionMethod(f"gim-{name}", f"gim, {name}", f"--method gim --strategy {name}", partial(Sweeps, strategy=name))
        for name in ("classic", "spectral")
    ),
    *(MotionMethod(name, name, f"--method {name}", partial(Following, method=name)) for name in ("newton", "auto")),
    *(MotionMethod(name, f"{name} coordinates", "", partial(Reference, coordinates=name)) for name in COORDINATES),
)
"""All methods, in the order in which they are told."""
