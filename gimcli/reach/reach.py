"""Reach of a point with one degree of freedom: its paths, their extent, and the range of the inputs on each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from gimcli.canonical import ranks
from gimcli.errors import UnassembledError, UsageError
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.positions.inputs import law_inputs
from gimcli.progress import Progress, no_progress, spend
from gimcli.reach.arcs import PathArc
from gimcli.reach.boundary import task_of
from gimcli.reach.circuit_paths import StartAssemblies, along_circuits, initial_paths, nearest
from gimcli.reach.critical_curves import CriticalCurve, CriticalPath, CriticalPoint, CriticalWalker, Stratum, split
from gimcli.reach.sampling import Bank
from gimcli.reach.task import FULL, SETTLED, WorkspaceTask, unreached

NOTHING = 1e-13
"""Velocity below which it is rounding."""


@dataclass(frozen=True)
class Interval:
    """Range of an input along a path, rad or lengths in the normal frame."""

    actuator: int
    low: float
    high: float
    full: bool = False  # a full turn
    folds: tuple[float, ...] = ()  # values at which the input reverses


@dataclass(frozen=True, eq=False)
class ReachedPath:
    """One connected path of the point."""

    pieces: tuple[PathArc, ...] = field(repr=False)  # between the extremes of x, y and the inputs
    closed: bool
    intervals: tuple[Interval, ...]
    drawn: bool  # it contains the initial position

    @property
    def x(self) -> FloatArray:
        """Positions (rows, n) along the path."""
        return np.concatenate([piece.branch.x for piece in self.pieces])

    @property
    def length(self) -> float:
        """Length of the path; parts that are traversed twice count twice."""
        return sum(piece.length for piece in self.pieces)

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner (2,) about the path."""
        ends = np.concatenate([piece.y for piece in self.pieces])
        return ends.min(axis=0), ends.max(axis=0)

    def points(self, parts: int = 4) -> FloatArray:
        """Return points (rows, 2) along the path."""
        return np.concatenate([piece.dense(parts) for piece in self.pieces])


@dataclass(frozen=True, eq=False)
class Reach:
    """The paths of a point; the one through the initial position comes first."""

    task: WorkspaceTask = field(repr=False)
    runs: tuple[ReachedPath, ...]
    complete: bool  # all assemblies: it is proved that the paths contain every configuration within the ranges
    start: StartAssemblies | None = None  # of the initial configuration only; None: the paths of all assemblies


def reach(
    mechanism: Mechanism, point: str, orientation: Mapping[str, float] | None = None, progress: Progress = no_progress,
    every: bool = True,
) -> Reach:  # fmt: skip
    """Return the paths of a node or point with one degree of freedom.

    every: of all assemblies; otherwise only those that a single input reaches from the initial configuration.
    Raises UsageError if there are more degrees of freedom, UnassembledError if there is no position.
    """
    task = task_of(mechanism, point, orientation or {})
    if task.freedoms > 1:
        raise UsageError(f"'{point}' reaches a region, with {task.freedoms} degrees of freedom; see `survey`")
    driven, start = len(task.moving) == 1 and not task.orientation, None
    if driven and not every:
        own = initial_paths(task, progress)
        branches, complete, initial, start = own.curves, own.complete, own.initial, own.start
    else:
        if driven:
            branches, complete = along_circuits(task, progress)
        else:  # orientations or several inputs are given: through positions from random starts
            walker = CriticalWalker(task, CriticalPath(Stratum(task.free, task.output[0])))
            branches, complete = walker.take(Bank(task).x), True
        if not branches:
            raise UnassembledError(unreached(task))
        drawn = task.system.coordinates(mechanism.drawn)
        initial = nearest(task, branches, task.coordinates(drawn))
    runs = [_run(task, branch, k == initial) for k, branch in enumerate(branches)]
    good = [run for run in runs if bool(task.fulfilled(run.x).all())]
    if not good:
        raise UnassembledError(f"{mechanism.name}: no path of '{point}' fulfils every constraint within the tolerance")
    order = ranks(np.array([-run.length for run in good]), SETTLED)
    ordered = tuple(good[k] for k in np.lexsort((order, np.array([not run.drawn for run in good]))))
    return Reach(task, ordered, complete and len(good) == len(runs) and not spend(), start)


def _run(task: WorkspaceTask, branch: CriticalCurve, drawn: bool) -> ReachedPath:
    n, table = task.n, task.output[0]

    def tests(knot: CriticalPoint) -> FloatArray:
        rates = np.concatenate([table, task.rates(knot.p[:n])]) @ knot.tangent[:n]
        return np.where(np.abs(rates) < NOTHING, 0.0, rates)

    pieces = split(branch, tests)
    values = [task.inputs(piece.x) for piece in pieces]
    intervals = tuple(_interval(task, k, [v[:, k] for v in values], branch.closed) for k in range(values[0].shape[1]))
    return ReachedPath(tuple(PathArc(piece, *task.output) for piece in pieces), branch.closed, intervals, drawn)


def _interval(task: WorkspaceTask, k: int, values: list[FloatArray], closed: bool) -> Interval:
    """Return the interval of an input from its values along the pieces of a path."""
    rotary = task.mechanism.actuators[k].rotary
    u = np.concatenate(values)
    u = np.unwrap(u) if rotary else u
    ends = np.cumsum([len(v) for v in values])
    low, high = float(u.min()), float(u.max())
    shift = _shift(task, k, low, high) if rotary else 0.0
    if rotary and closed and abs(float(u[-1] - u[0])) >= math.pi * FULL:  # the curve makes turns
        begin = float(law_inputs(task.mechanism)(np.zeros(1))[k, 0])
        return Interval(k, begin, begin + 2.0 * math.pi, True)
    folds = [_fold(u, int(end)) for end in ends[: None if closed else -1]]
    return Interval(k, low + shift, high + shift, False, tuple(sorted({f + shift for f in folds if f is not None})))


def _fold(u: FloatArray, end: int) -> float | None:
    """Return the value of an input at the end of a piece if it reverses there; the last knot is repeated there."""
    here = float(u[end - 1])
    before, after = here - float(u[end - 2]), float(u[(end + 1) % len(u)]) - here
    return here if before * after < 0.0 else None


def _shift(task: WorkspaceTask, k: int, low: float, high: float) -> float:
    """Return the whole turns [rad] that move an interval to the start of the input's law, or near the law."""
    law = law_inputs(task.mechanism)(np.linspace(0.0, 1.0, 33))[k]
    turns = math.floor((float(law[0]) - low) / (2.0 * math.pi) + 1e-9)
    if high + 2.0 * math.pi * turns < float(law[0]) - 1e-9:
        turns = round((0.5 * float(law.min() + law.max()) - 0.5 * (low + high)) / (2.0 * math.pi))
    return 2.0 * math.pi * turns
