"""Speed and accuracy: each method at each tolerance on the motion of a model.

The accuracy is the true error: the distance of the traced points from positions refined to 40 digits. A position on
another branch than that of the continuous motion counts as not solved, even if its residual is small.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gimcli.comparison.absolute import AbsoluteCoordinates
from gimcli.comparison.methods import METHODS, Clock, MotionMethod, MotionTask, Outcome, Timing
from gimcli.comparison.operations import coordinates_cost
from gimcli.comparison.true_error import Truth, refine
from gimcli.errors import StructureError
from gimcli.kernels.jit import compiled, is_cached
from gimcli.mechanism import Mechanism
from gimcli.motion.motion import Motion, trace
from gimcli.positions.dispatch import choose, gim_work
from gimcli.positions.options import Options
from gimcli.progress import Notify, Progress, no_progress
from gimcli.status import Status
from gimcli.structure.drive_check import require_consistent
from gimcli.table import Column, Table

EQUAL_TIMES = 1.15
"""Times that differ by less than this factor count as equal; the more accurate entry is then recommended."""

KERNELS = ("settle_rows", "follow_bodies", "follow_points")
"""Kernels that every comparison uses."""

PLAIN, ITERATIONS, RUNS = 1.5e-7, 4, 3
"""Estimate of the work: seconds per operation without compilation, iterations per position, runs per method."""

ROUNDING = 8.0 * float(np.finfo(float).eps)
"""True errors below this are rounding errors; they count as equal."""

SHARE = 0.08
"""Fraction of the time limit that one method may take before its finer tolerances are left out."""

TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
DIGITS = (3, 6, 9, 12)
RECORD = (
    "method", "tolerance", "unknowns", "iteration_operations", "iterations", "most_iterations", "paper_operations",
    "operations", "seconds", "error", "solved", "positions", "efficient", "reason",
)  # fmt: skip
"""Columns of the table and keys of the report for one method at one tolerance."""
UNITS = {"seconds": "s"}
TIMING = Timing()


@dataclass(frozen=True)
class Entry:
    """Result of one method at one tolerance; the numbers are NaN if no position was solved."""

    method: MotionMethod
    tolerance: float
    unknowns: tuple[int, ...]  # of each system that is solved
    iterations: tuple[float, ...]  # operations of one sweep or iteration, of each system
    work: float  # mean number of sweeps or iterations per position, all systems together
    most: float  # largest number of sweeps or iterations of a position
    paper: float  # operations per position as the paper counts them
    operations: float  # actual operations per position
    seconds: float  # [s] per position
    error: float  # largest true error of a traced point, relative to the size
    solved: int  # positions that the method solved
    rows: int  # all positions that have a true position
    reason: str  # cause of the missing positions
    efficient: bool = False  # no other entry is both faster and more accurate

    @property
    def complete(self) -> bool:
        """Return whether all positions are solved."""
        return self.solved == self.rows > 0

    @property
    def compared_error(self) -> float:
        """True error for the comparison with other entries; not less than rounding."""
        return max(self.error, ROUNDING)

    @property
    def record(self) -> dict[str, Any]:
        """Values of the entry by the names in `RECORD`."""
        values = (
            self.method.name, self.tolerance, list(self.unknowns), list(self.iterations), self.work, self.most,
            self.paper, self.operations, self.seconds, self.error, self.solved, self.rows, self.efficient, self.reason,
        )  # fmt: skip
        return dict(zip(RECORD, values, strict=True))

    @property
    def drawable(self) -> bool:
        """Return whether time and error can be drawn as a point."""
        return math.isfinite(self.error) and self.seconds > 0.0


@dataclass(frozen=True)
class Tradeoff:
    """Results of all methods on one motion."""

    mechanism: Mechanism
    entries: tuple[Entry, ...]
    motion: Motion  # the continuous motion from which the true positions were refined
    compiled: bool
    unrefined: int  # rows that are solved, but too near to a singular position to determine a true error

    @property
    def reached(self) -> bool:
        """Return whether the continuous motion reaches all rows."""
        return self.motion.solved == len(self.motion.codes)


def tradeoff(
    mechanism: Mechanism, steps: int = 72, tolerances: Sequence[float] = TOLERANCES, jit: str = "auto",
    notify: Notify | None = None, progress: Progress = no_progress, methods: Sequence[MotionMethod] = METHODS,
    timing: Timing = TIMING, seconds: float = math.inf,
) -> Tradeoff:  # fmt: skip
    """Compare methods on the motion that the laws of the actuators define, in `steps` steps.

    seconds: intended processor time [s]; a method that has used its share is not run at finer tolerances.
    Raises StructureError if the constraints contradict each other.
    """
    ready = is_cached(*KERNELS)
    mode = choose(jit, _work(mechanism, steps, len(tolerances)), notify, KERNELS)
    fast = mode is compiled
    share = SHARE * seconds if ready or not fast else math.inf  # the time of a compilation is not charged to a method
    motion = trace(mechanism, steps, Options(jit="on" if fast else "off"))
    require_consistent(mechanism, motion.start, motion.inputs[:, 0], motion.first_status, Options().tolerance)
    if motion.first_status is not Status.OK:  # there is no start position
        methods = ()
    truth = refine(mechanism, motion.z, motion.inputs, motion.good)
    task = MotionTask(mechanism, steps, motion.inputs, motion.z, mode, "on" if fast else "off")
    total = len(methods) * len(tolerances)

    def part(done: int) -> None:
        progress(done, (1 + timing.rounds) * total)

    entries: list[tuple[Entry, Clock | None]] = []
    for method in methods:
        for found in _entries(method, task, truth, tolerances, timing, share):
            entries.append(found)
            part(len(entries))
    clocks = [clock for _, clock in entries if clock is not None]
    shared = timing.shared(sum(1 + (clock.outcome.prepare is not None) for clock in clocks))
    for each in clocks:
        each.timing = shared
    for number in range(timing.rounds):
        for k, (_, clock) in enumerate(entries, start=1):
            if clock is not None and not clock.long:
                clock.round()
            part((1 + number) * total + k)
    part((1 + timing.rounds) * total)
    timed = [_timed(entry, clock) for entry, clock in entries]
    unrefined = int((motion.good & ~truth.known)[1:].sum())
    return Tradeoff(mechanism, tuple(mark_efficient(timed)), motion, fast, unrefined)


def _work(mechanism: Mechanism, steps: int, tolerances: int) -> float:
    """Return the estimated time of the comparison without compilation [s]."""
    position = coordinates_cost(AbsoluteCoordinates(mechanism)).operations(ITERATIONS) * PLAIN
    sweeps = gim_work(4 * len(mechanism.nodes), steps)
    return RUNS * tolerances * (2 * sweeps + 2 * steps * position)


def _entries(
    method: MotionMethod, task: MotionTask, truth: Truth, tolerances: Sequence[float], timing: Timing, share: float
) -> Iterator[tuple[Entry, Clock | None]]:
    """Yield an entry for each tolerance, or one with the reason if the method does not apply to the mechanism."""
    rows = int(truth.known[1:].sum())
    try:
        began = time.process_time()
        solver = method.prepare(task)
        for finer, tolerance in enumerate(sorted(tolerances, reverse=True)):
            before = time.process_time()
            if finer and before - began > share:
                yield _left_out(method, tolerance, rows, before - began), None
                continue
            found = solver.solve(tolerance)
            entry = _entry(method, tolerance, found, truth)
            clock = Clock(found, timing) if entry.solved else None
            if clock is not None and time.process_time() - before > share:
                clock.whole = time.process_time() - before  # includes the preparation: too long to be repeated
            yield entry, clock
    except StructureError as error:
        yield _empty(method, math.nan, rows, str(error)), None


def _left_out(method: MotionMethod, tolerance: float, rows: int, spent: float) -> Entry:
    """Return the entry for a tolerance at which a slow method is not run."""
    return _empty(method, tolerance, rows, f"left out: coarser tolerances took {spent:.1f} s; --seconds allows more")


def _empty(method: MotionMethod, tolerance: float, rows: int, reason: str) -> Entry:
    nan = math.nan
    return Entry(method, tolerance, (), (), nan, nan, nan, nan, nan, nan, 0, rows, reason)


def _entry(method: MotionMethod, tolerance: float, found: Outcome, truth: Truth) -> Entry:
    """Return the entry for the result of a method; the start is left out because all methods are given it."""
    with np.errstate(all="ignore"):
        error = truth.errors(found.z)
    offered = found.good & truth.known
    right = offered & truth.same_branch(found.z, error)
    offered[0] = right[0] = False
    rows, solved, jumped = int(truth.known[1:].sum()), int(right.sum()), int((offered & ~right).sum())
    reason = "; ".join(([f"{jumped} on another branch"] if jumped else []) + ([found.reason] if found.reason else []))
    work, most, worst = math.nan, math.nan, math.nan
    if solved:
        work, most = float(np.mean(found.work[right])), float(np.max(found.work[right]))
        worst = float(np.max(error[right]))
    return Entry(
        method, tolerance, found.cost.unknowns, found.cost.iterations, work, most, found.cost.paper * work,
        found.cost.operations(work), math.nan, worst, solved, rows, reason,
    )  # fmt: skip


def _timed(entry: Entry, clock: Clock | None) -> Entry:
    """Return an entry with its time per row; rows on another branch count too."""
    if clock is None:
        return entry
    return replace(entry, seconds=clock.seconds / max(1, int(clock.outcome.good[1:].sum())))


# -- recommendations --------------------------------------------------------------------------------


def mark_efficient(entries: Sequence[Entry]) -> list[Entry]:
    """Mark the efficient entries: the Pareto front in time and error of the entries that solve all positions."""
    whole = [e for e in entries if e.complete and e.drawable]

    def dominated(e: Entry) -> bool:
        others = [o for o in whole if o.seconds <= e.seconds and o.compared_error <= e.compared_error]
        return any(o.seconds < e.seconds or o.compared_error < e.compared_error for o in others)

    return [replace(e, efficient=e in whole and not dominated(e)) for e in entries]


@dataclass(frozen=True)
class Advice:
    """The recommended method for a number of correct digits."""

    digits: int
    best: Entry | None  # the fastest method of `gim`; None if none reaches the digits
    nearest: Entry | None  # the most accurate method of `gim`
    reference: Entry | None  # a reference method that is faster, or that alone reaches the digits

    @property
    def text(self) -> str:
        """The recommendation in one sentence."""
        return f"{self.digits} digits: {self._choice()}{self._reference()}."

    def _choice(self) -> str:
        if self.best is not None:
            return (
                f"{self.best.method.options} --tolerance {self.best.tolerance:g} is fastest"
                f" ({_time(self.best)} per position, true error {self.best.error:.1e})"
            )
        if self.nearest is None:
            return "no method solves all positions"
        return (
            f"no method reaches this accuracy in all positions; the most accurate is {self.nearest.method.options}"
            f" --tolerance {self.nearest.tolerance:g} (true error {self.nearest.error:.1e})"
        )

    def _reference(self) -> str:
        if self.reference is None:
            return ""
        return (
            f"; textbook Newton-Raphson in {self.reference.method.label} takes {_time(self.reference)}"
            f" (tolerance {self.reference.tolerance:g}, true error {self.reference.error:.1e})"
        )


def _time(entry: Entry) -> str:
    micro = 1e6 * entry.seconds
    return f"{micro:.3g} µs" if micro < 1e3 else f"{micro / 1e3:.3g} ms"


def advise(found: Tradeoff, digits: Sequence[int] = DIGITS) -> list[Advice]:
    """Return for each number of digits the fastest method with true errors below 10^-digits in all positions."""
    whole = [e for e in found.entries if e.complete and e.drawable]
    tools, references = ([e for e in whole if bool(e.method.options) == offered] for offered in (True, False))
    advice = []
    for count in digits:
        best = _fastest(tools, count)
        other = _fastest(references, count)
        if best is not None and other is not None and other.seconds * EQUAL_TIMES >= best.seconds:
            other = None
        advice.append(Advice(count, best, _most_accurate(tools), other))
    return advice


def _fastest(entries: Sequence[Entry], digits: int) -> Entry | None:
    enough = [e for e in entries if e.error < 10.0**-digits]
    least = min((e.seconds for e in enough), default=0.0)
    return _most_accurate([e for e in enough if e.seconds <= EQUAL_TIMES * least])


def _most_accurate(entries: Sequence[Entry]) -> Entry | None:
    return min(entries, key=lambda e: (e.compared_error, e.seconds), default=None)


def tradeoff_table(found: Tradeoff) -> Table:
    """Return a table with one row for each method and tolerance."""
    records = [entry.record for entry in found.entries]
    columns = [Column(name, np.array([_cell(r[name]) for r in records]), UNITS.get(name, "")) for name in RECORD]
    return Table(tuple(columns))


def _cell(value: Any) -> Any:
    """Return a value in the form for the table."""
    if isinstance(value, list):
        return "+".join(f"{part:.0f}" for part in value)
    return int(value) if isinstance(value, bool) else value
