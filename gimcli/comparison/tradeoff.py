"""Speed against accuracy: every method at every tolerance on the user's own motion.

The accuracy is the true error of the traced points, against positions refined to 40 digits. A position
on another branch than that of the continuous motion is not solved, however small its residual is.
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
from gimcli.structure.drive_check import refuse_contradiction
from gimcli.table import Column, Table

ALIKE = 1.15
"""Times that differ by less than this factor count as equal: the more accurate entry is advised."""

KERNELS = ("settle_rows", "follow_bodies", "follow_points")
"""Those that every comparison runs."""

PLAIN, ITERATIONS, RUNS = 1.5e-7, 4, 3
"""Seconds of an operation that is not compiled; iterations and runs that the work is estimated by."""

ROUNDING = 8.0 * float(np.finfo(float).eps)
"""True errors below this are rounding: none is better than another."""

SHARE = 0.08
"""Part of the time for a comparison that one method may take before its finer tolerances are left out."""

TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
DIGITS = (3, 6, 9, 12)
RECORD = (
    "method", "tolerance", "unknowns", "iteration_operations", "iterations", "most_iterations", "paper_operations",
    "operations", "seconds", "error", "solved", "positions", "efficient", "reason",
)  # fmt: skip
"""Names of what a table or a report holds of a method at a tolerance."""
UNITS = {"seconds": "s"}
TIMING = Timing()


@dataclass(frozen=True)
class Entry:
    """One method at one tolerance; numbers are NaN where nothing was solved."""

    method: MotionMethod
    tolerance: float
    unknowns: tuple[int, ...]  # of every system that is solved
    iterations: tuple[float, ...]  # operations of one sweep or iteration, of every system
    work: float  # sweeps or iterations a position, mean; of all systems together
    most: float  # the greatest of them
    paper: float  # operations a position as the paper counts them
    operations: float  # operations a position as they are
    seconds: float  # a position
    error: float  # greatest true error of a traced point, relative to the size
    solved: int
    rows: int  # positions that there are
    reason: str  # why some are missing
    efficient: bool = False  # no other is both faster and more accurate

    @property
    def complete(self) -> bool:
        """Tell whether all positions are solved."""
        return self.solved == self.rows > 0

    @property
    def told(self) -> float:
        """True error as far as it tells methods apart."""
        return max(self.error, ROUNDING)

    @property
    def record(self) -> dict[str, Any]:
        """What a table or a report holds of it, by name."""
        values = (
            self.method.name, self.tolerance, list(self.unknowns), list(self.iterations), self.work, self.most,
            self.paper, self.operations, self.seconds, self.error, self.solved, self.rows, self.efficient, self.reason,
        )  # fmt: skip
        return dict(zip(RECORD, values, strict=True))

    @property
    def drawable(self) -> bool:
        """Tell whether there is a point (time, error) to draw."""
        return math.isfinite(self.error) and self.seconds > 0.0


@dataclass(frozen=True)
class Tradeoff:
    """All methods on one motion."""

    mechanism: Mechanism
    entries: tuple[Entry, ...]
    motion: Motion  # the continuous motion that the truth was refined from
    compiled: bool
    untold: int  # rows that are solved but too near to a singular position for a true error

    @property
    def reached(self) -> bool:
        """Tell whether the continuous motion reaches all rows."""
        return self.motion.solved == len(self.motion.codes)


def tradeoff(
    mechanism: Mechanism, steps: int = 72, tolerances: Sequence[float] = TOLERANCES, jit: str = "auto",
    notify: Notify | None = None, progress: Progress = no_progress, methods: Sequence[MotionMethod] = METHODS,
    timing: Timing = TIMING, seconds: float = math.inf,
) -> Tradeoff:  # fmt: skip
    """Compare methods on the motion along the actuators' laws in some steps.

    seconds: processor time that is meant for it; a method that has taken its share is not run at finer tolerances.
    """
    ready = is_cached(*KERNELS)
    mode = choose(jit, _work(mechanism, steps, len(tolerances)), notify, KERNELS)
    fast = mode is compiled
    share = SHARE * seconds if ready or not fast else math.inf  # a compilation is no method's time
    motion = trace(mechanism, steps, Options(jit="on" if fast else "off"))
    refuse_contradiction(mechanism, motion.start, motion.inputs[:, 0], motion.first_status, Options().tolerance)
    if motion.first_status is not Status.OK:  # nothing to begin from
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
    untold = int((motion.good & ~truth.known)[1:].sum())
    return Tradeoff(mechanism, tuple(mark_efficient(timed)), motion, fast, untold)


def _work(mechanism: Mechanism, steps: int, tolerances: int) -> float:
    """Estimate the seconds that the whole comparison takes without compiling."""
    position = coordinates_cost(AbsoluteCoordinates(mechanism)).operations(ITERATIONS) * PLAIN
    sweeps = gim_work(4 * len(mechanism.nodes), steps)
    return RUNS * tolerances * (2 * sweeps + 2 * steps * position)


def _entries(
    method: MotionMethod, task: MotionTask, truth: Truth, tolerances: Sequence[float], timing: Timing, share: float
) -> Iterator[tuple[Entry, Clock | None]]:
    """Yield a row for every tolerance, or one with the reason where the method cannot do the mechanism."""
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
                clock.whole = time.process_time() - before  # with what is prepared once: too long to be run again
            yield entry, clock
    except StructureError as fault:
        yield _empty(method, math.nan, rows, str(fault)), None


def _left_out(method: MotionMethod, tolerance: float, rows: int, spent: float) -> Entry:
    """Return the entry of a tolerance at which a slow method is not run."""
    return _empty(method, tolerance, rows, f"left out: coarser tolerances took {spent:.1f} s; --seconds allows more")


def _empty(method: MotionMethod, tolerance: float, rows: int, reason: str) -> Entry:
    nan = math.nan
    return Entry(method, tolerance, (), (), nan, nan, nan, nan, nan, nan, 0, rows, reason)


def _entry(method: MotionMethod, tolerance: float, found: Outcome, truth: Truth) -> Entry:
    """Judge what a method gave; the start, which all are given, is left out."""
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
    """Return an entry with its time: of the rows that the method went through, right or not."""
    if clock is None:
        return entry
    return replace(entry, seconds=clock.seconds / max(1, int(clock.outcome.good[1:].sum())))


# -- conclusions ------------------------------------------------------------------------------------


def mark_efficient(entries: Sequence[Entry]) -> list[Entry]:
    """Mark the complete entries that no other complete one beats in both time and error (Pareto's front)."""
    whole = [e for e in entries if e.complete and e.drawable]

    def beaten(e: Entry) -> bool:
        better = [o for o in whole if o.seconds <= e.seconds and o.told <= e.told]
        return any(o.seconds < e.seconds or o.told < e.told for o in better)

    return [replace(e, efficient=e in whole and not beaten(e)) for e in entries]


@dataclass(frozen=True)
class Advice:
    """What to use for some digits."""

    digits: int
    best: Entry | None  # of the methods that the tool offers; None where none reaches the digits
    nearest: Entry | None  # the most accurate of them
    reference: Entry | None  # a reference that is faster still, or reaches what none of them does

    @property
    def text(self) -> str:
        """One sentence."""
        return f"{self.digits} digits: {self._choice()}{self._reference()}."

    def _choice(self) -> str:
        if self.best is not None:
            return (
                f"{self.best.method.options} --tolerance {self.best.tolerance:g} costs least"
                f" ({_time(self.best)} a position, true error {self.best.error:.1e})"
            )
        if self.nearest is None:
            return "no method solves all positions"
        return (
            f"no method reaches them in all positions; {self.nearest.method.options} --tolerance"
            f" {self.nearest.tolerance:g} comes nearest (true error {self.nearest.error:.1e})"
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
    """Return for some digits the fastest method whose true error is below 10^-digits in all positions."""
    whole = [e for e in found.entries if e.complete and e.drawable]
    tools, references = ([e for e in whole if bool(e.method.options) == offered] for offered in (True, False))
    advice = []
    for count in digits:
        best = _fastest(tools, count)
        other = _fastest(references, count)
        if best is not None and other is not None and other.seconds * ALIKE >= best.seconds:
            other = None
        advice.append(Advice(count, best, min(tools, key=lambda e: (e.told, e.seconds), default=None), other))
    return advice


def _fastest(entries: Sequence[Entry], digits: int) -> Entry | None:
    enough = [e for e in entries if e.error < 10.0**-digits]
    least = min((e.seconds for e in enough), default=0.0)
    alike = [e for e in enough if e.seconds <= ALIKE * least]
    return min(alike, key=lambda e: (e.told, e.seconds), default=None)


def tradeoff_table(found: Tradeoff) -> Table:
    """Return one row for every method and tolerance."""
    records = [entry.record for entry in found.entries]
    columns = [Column(name, np.array([_cell(r[name]) for r in records]), UNITS.get(name, "")) for name in RECORD]
    return Table(tuple(columns))


def _cell(value: Any) -> Any:
    """Return a value as it stands in a table."""
    if isinstance(value, list):
        return "+".join(f"{part:.0f}" for part in value)
    return int(value) if isinstance(value, bool) else value
