"""The methods that are compared: the solution of a motion, its operations, and runs that are timed.

What is timed is the same for all methods: from one assembled start the motion is solved to and fro, positions only, and
every row is checked. The run of a call is a call for the first step only: its time is the fixed part of any call.

Textbook Newton-Raphson in the coordinates of multibody programs (`COORDINATES`) is a reference implementation: the
whole mechanism is one system of equations that includes the drivers. Each row starts from the previous one. The
iteration stops when no correction exceeds the tolerance (lengths relative to the mechanism's size, angles in rad), like
the Newton-Raphson that Petuya et al. 2004 compare their method with.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from gimcli.comparison.bodies import AbsoluteCoordinates
from gimcli.comparison.coordinates import JointCoordinates, NaturalCoordinates
from gimcli.comparison.operations import Cost, coordinates_cost, plan_cost, sweep_cost
from gimcli.gim.sequence_switching import SwitchingState
from gimcli.gim.sweeper import Sweeper
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.assemble import Assembly
from gimcli.motion.follow import BranchFollower, FollowedPath
from gimcli.motion.legs import STEPS_A_TURN
from gimcli.motion.motion import checked, stream, trace
from gimcli.motion.solve import start_position
from gimcli.positions.inputs import law_inputs, pace
from gimcli.positions.newton import Run
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import residual
from gimcli.structure.steps import Plan


@dataclass(frozen=True)
class Followed:
    """The positions of a motion that were computed by `follow`."""

    z: ComplexArray  # (nodes, rows), NaN where not solved
    iterations: FloatArray  # (rows,)
    good: BoolArray  # (rows,) whether the iteration converged


Coordinates = JointCoordinates | AbsoluteCoordinates | NaturalCoordinates
"""A mechanism in one kind of coordinates."""

COORDINATES: dict[str, Callable[[Mechanism], Coordinates]] = {
    "joint": JointCoordinates,
    "absolute": AbsoluteCoordinates,
    "natural": NaturalCoordinates,
}


def follow(
    system: Coordinates, inputs: FloatArray, start: ComplexArray, tolerance: float, run: Run, most: int = 50,
    length: float | None = None,
) -> Followed:  # fmt: skip
    """Solve inputs (actuators, rows) from an assembled position (nodes,), each row from the previous one.

    most: iterations of a position. length: that to which lengths are relative [normal frame], by default the size.
    """
    with np.errstate(all="ignore"):
        z, iterations, converged = system.follow(inputs, start, tolerance, length or system.mechanism.size, most, run)
    good = (converged == 1.0) & np.all(np.isfinite(z), axis=0)
    z[:, ~good] = complex(np.nan, np.nan)
    return Followed(z, iterations, good)


@dataclass(frozen=True)
class MotionTask:
    """A motion to be solved from an assembled start."""

    mechanism: Mechanism
    steps: int
    inputs: FloatArray  # (actuators, rows)
    z: ComplexArray  # (nodes, rows) positions of the continuous motion
    run: Run
    jit: str  # "on" or "off"

    @cached_property
    def turn(self) -> float:
        """The time in which an input makes one turn."""
        turns = pace(self.mechanism, law_inputs(self.mechanism)(np.linspace(0.0, 1.0, 65)))
        return 1.0 / max(turns, np.finfo(float).tiny)

    @property
    def parts(self) -> int:
        """Number of rows that path following solves per step of the user."""
        return max(1, math.ceil(STEPS_A_TURN / self.turn / self.steps))

    @cached_property
    def reached(self) -> int:
        """Number of the steps that the continuous motion reaches."""
        return int(np.flatnonzero(np.isfinite(self.z).all(axis=0))[-1])

    def laps(self, count: int) -> IntArray:
        """Return the numbers of the rows of `count` motions to and fro, without the first row."""
        there = np.arange(1, self.reached + 1)
        return np.tile(np.concatenate([there, there[::-1] - 1]), count)

    def check(self, z: ComplexArray, inputs: FloatArray) -> int:
        """Compute the residual of positions (nodes, rows), as every motion does; return the number of rows."""
        with np.errstate(all="ignore"):
            return len(residual(self.mechanism, z, inputs).total)


@dataclass(frozen=True)
class Outcome:
    """Result of one method for one motion and one tolerance."""

    z: ComplexArray  # (nodes, rows), NaN where not solved
    good: BoolArray  # (rows,) whether the row was solved
    work: FloatArray  # (rows,) sweeps or iterations
    cost: Cost
    run: Callable[[int], int]  # solves the motion to and fro; returns the number of positions
    call: Callable[[], object]  # a call for the first step
    reason: str = ""  # status word of the missing rows


@dataclass(frozen=True)
class MotionMethod:
    """A method of `gim`, or a reference method that only this comparison has."""

    name: str
    label: str
    options: str  # options of the command line that select the method; "" for a reference
    prepare: Callable[[MotionTask], Sweeps | Following | Reference]


SLOWER = 8
"""Steps in which the speed of a motion to and fro falls to 0 before it turns back, as predictions expect."""


class Sweeps:
    """The Geometrical-Iterative Method with the sequence that a strategy finds."""

    def __init__(self, task: MotionTask, strategy: str) -> None:
        self.task, self.strategy = task, strategy
        self.sweeper = Sweeper(task.mechanism, self._options(1.0), task.run)
        self.sequence, self.moves = self.sweeper.sequence, self.sweeper.moves

    def _options(self, tolerance: float) -> Options:
        return Options("gim", self.strategy, tolerance, self.task.jit)

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion by `trace`; only the sweeps and the checks are timed, not the motion that they follow."""
        task, options = self.task, self._options(tolerance)
        motion = trace(task.mechanism, task.steps, options)
        self._set(options)
        first = self.sweeper.settle(task.inputs[:, 0], task.mechanism.drawn).z

        def run(count: int) -> int:
            self._set(options)
            rows = np.append(0, task.laps(count))
            found = SwitchingState(self.sweeper, task.inputs[:, rows], task.z[:, rows]).run(first)
            solved = found.codes == Status.OK
            return max(1, task.check(found.z[:, solved], task.inputs[:, rows[solved]]) - 1)

        cost, reason = sweep_cost(task.mechanism, self.moves), missing_reason(motion.overall, motion.good)
        return Outcome(motion.z, motion.good, motion.work, cost, run, first_step(task, options), reason)

    def _set(self, options: Options) -> None:
        self.sweeper.options, self.sweeper.sequence, self.sweeper.moves = options, self.sequence, self.moves


class Following:
    """Path following of this library: Newton-Raphson on base nodes, with or without closed forms."""

    def __init__(self, task: MotionTask, method: str) -> None:
        self.task, self.method = task, method

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion by `trace`."""
        task = self.task
        options = Options(self.method, tolerance=tolerance, jit=task.jit)
        motion = trace(task.mechanism, task.steps, options)

        cost = plan_cost(task.mechanism, self._plan(), task.parts)
        reason, call = missing_reason(motion.overall, motion.good), first_step(task, options)
        start = start_position(task.mechanism, self._plan(), task.inputs[:, 0], task.run, tolerance)
        run: Callable[[int], int] = partial(self._follow, start, options)
        if not (start.regular and start.gap is None and run(1)):
            run = partial(self._again, options)
        return Outcome(motion.z, motion.good, motion.work, cost, run, call, reason)

    def _again(self, options: Options, count: int) -> int:
        """Trace the whole motion, which passes singular positions; return the number of positions."""
        return sum(trace(self.task.mechanism, self.task.steps, options).solved for _ in range(count))

    def _follow(self, start: Assembly, options: Options, count: int) -> int:
        """Follow the motion to and fro, smoothly where it turns back; return the number of checked positions."""
        task, plan, step = self.task, self._plan(), 1.0 / self.task.steps
        slow = min(SLOWER, task.reached)
        end, ramp = task.reached * step, slow * step
        half, law = end + ramp, law_inputs(task.mechanism)

        def inputs(time: FloatArray) -> FloatArray:
            there = np.mod(time, 2.0 * half)
            there = np.minimum(there, 2.0 * half - there)
            left = np.maximum(ramp - np.minimum(there, half - there), 0.0)  # of the time in which it is slower
            place = np.where(there < 0.5 * half, 1.0, -1.0) * left * left / (2.0 * ramp) + there - 0.5 * ramp
            return law(np.clip(place, 0.0, end))

        rows = 2 * (task.reached + slow)
        lap = np.arange(1.0, rows * task.parts + 1.0) * (step / task.parts)
        time = (np.arange(count)[:, None] * (2.0 * half) + lap).ravel()
        follower = BranchFollower(task.mechanism, plan, inputs, task.run, options.tolerance)
        follower.turn = task.turn
        follower.begin(replace(start.row, time=0.0), start.signs)
        path = follower.follow(FollowedPath.empty(len(task.mechanism.nodes), time, np.tile(inputs(lap), count)))
        return count * rows if checked(task.mechanism, plan, path, options).good.all() else 0

    def _plan(self) -> Plan:
        return make_plan(self.task.mechanism, closed_forms=self.method != "newton")


class Reference:
    """Textbook Newton-Raphson in the coordinates of multibody programs."""

    def __init__(self, task: MotionTask, coordinates: str) -> None:
        self.task = task
        self.make: Callable[[Mechanism], Coordinates] = COORDINATES[coordinates]
        self.system = self.make(task.mechanism)

    def solve(self, tolerance: float) -> Outcome:
        """Solve the motion from its assembled start, each row from the previous one."""
        task = self.task

        def solved(rows: IntArray, system: Coordinates) -> Followed:
            return follow(system, task.inputs[:, rows], task.z[:, 0], tolerance, task.run)

        def run(count: int) -> int:
            rows = task.laps(count)
            found = solved(rows, self.system)
            return max(1, task.check(found.z[:, found.good], task.inputs[:, rows[found.good]]))

        def call() -> None:
            found = solved(np.arange(2), self.make(task.mechanism))
            task.check(found.z, task.inputs[:, :2])

        found = solved(np.arange(task.inputs.shape[1]), self.system)
        reason = missing_reason(Status.NOT_CONVERGED, found.good)
        return Outcome(found.z, found.good, found.iterations, coordinates_cost(self.system), run, call, reason)


def first_step(task: MotionTask, options: Options) -> Callable[[], object]:
    """Return a call for the first step of a motion."""
    return lambda: next(stream(task.mechanism, task.steps, options, rows=2))


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
