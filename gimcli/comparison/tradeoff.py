"""Speed and accuracy: each method at each tolerance on the motion of a model.

The accuracy is the true error: the distance of the traced points from positions refined to 40 digits. A position on
another branch than that of the continuous motion counts as not solved, even if its residual is small. Times are
measured, with their spread; between tolerances of one method the counted operations decide, which do not vary.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gimcli.comparison.bodies import AbsoluteCoordinates
from gimcli.comparison.methods import METHODS, MotionMethod, MotionTask, Outcome
from gimcli.comparison.operations import coordinates_cost
from gimcli.comparison.timing import TIMING, Measured, Timing, measure
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

EQUAL_WORK = 1.15
"""Operations that differ by less than this factor count as equal; the more accurate tolerance is then recommended."""

STEPS = 90
"""Steps of the motion, by default: path following needs no rows in between for one turn."""

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
    time: Measured  # of a position
    fixed: Measured  # of a call for the first step
    steps: int  # of the motion
    error: float  # largest true error of a traced point, relative to the size
    solved: int  # positions that the method solved
    rows: int  # all positions that have a true position
    reason: str  # cause of the missing positions
    efficient: bool = False  # no other entry is both faster and more accurate

    @property
    def call(self) -> float:
        """Time of a call for the whole motion [s]: its fixed part and its positions."""
        return self.fixed.seconds + self.steps * self.time.seconds

    @property
    def complete(self) -> bool:
        """Return whether all positions are solved."""
        return self.solved == self.rows > 0

    @property
    def compared_error(self) -> float:
        """True error for the comparison with other entries; not less than rounding."""
        return max(self.error, ROUNDING)

    @property
    def drawable(self) -> bool:
        """Return whether time and error can be drawn as a point."""
        return math.isfinite(self.error) and self.time.seconds > 0.0


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
    mechanism: Mechanism, steps: int = STEPS, tolerances: Sequence[float] = TOLERANCES, jit: str = "auto",
    notify: Notify | None = None, progress: Progress = no_progress, timing: Timing = TIMING, seconds: float = math.inf,
    methods: Sequence[MotionMethod] = METHODS,
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

    found: list[tuple[Entry, Outcome | None]] = []
    for method in methods:
        for one in _entries(method, task, truth, tolerances, share):
            found.append(one)
            progress(len(found), 2 * total)
    timed = {k: outcome for k, (_, outcome) in enumerate(found) if outcome is not None}
    calls = measure([partial(_calls, one.call) for one in timed.values()], replace(timing, least=timing.least / 4.0))
    runs = [one.run for one in timed.values()]
    times = measure(runs, timing, lambda done, rounds: progress(total + total * done // rounds, 2 * total))
    entries = [entry for entry, _ in found]
    for k, of_position, of_call in zip(timed, times, calls, strict=True):
        entries[k] = replace(entries[k], time=of_position, fixed=of_call)
    unrefined = int((motion.good & ~truth.known)[1:].sum())
    return Tradeoff(mechanism, tuple(mark_efficient(entries)), motion, fast, unrefined)


def _work(mechanism: Mechanism, steps: int, tolerances: int) -> float:
    """Return the estimated time of the comparison without compilation [s]."""
    position = coordinates_cost(AbsoluteCoordinates(mechanism)).operations(ITERATIONS) * PLAIN
    sweeps = gim_work(4 * len(mechanism.nodes), steps)
    return RUNS * tolerances * (2 * sweeps + 2 * steps * position)


def _calls(call: Callable[[], object], count: int) -> int:
    """Repeat a call; return the number of repetitions."""
    for _ in range(count):
        call()
    return count


def _entries(
    method: MotionMethod, task: MotionTask, truth: Truth, tolerances: Sequence[float], share: float
) -> Iterator[tuple[Entry, Outcome | None]]:
    """Yield an entry for each tolerance, or one with the reason if the method does not apply to the mechanism."""
    rows = int(truth.known[1:].sum())
    try:
        began = time.process_time()
        solver = method.prepare(task)
        for finer, tolerance in enumerate(sorted(tolerances, reverse=True)):
            before = time.process_time()
            if finer and before - began > share:
                why = f"left out: coarser tolerances took {before - began:.1f} s; more `seconds` allow it"
                yield _empty(method, tolerance, rows, why), None
                continue
            found = solver.solve(tolerance)
            entry = _entry(method, tolerance, found, truth)
            yield entry, found if entry.solved else None
    except StructureError as error:
        yield _empty(method, math.nan, rows, str(error)), None


def _empty(method: MotionMethod, tolerance: float, rows: int, reason: str) -> Entry:
    none = (math.nan,) * 4
    return Entry(method, tolerance, (), (), *none, Measured(), Measured(), 0, math.nan, 0, rows, reason)


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
        found.cost.operations(work), Measured(), Measured(), found.z.shape[1] - 1, worst, solved, rows, reason,
    )  # fmt: skip


# -- recommendations --------------------------------------------------------------------------------


def mark_efficient(entries: Sequence[Entry]) -> list[Entry]:
    """Mark the entries that no other one dominates: none is faster without being less accurate, or the reverse."""
    whole = [e for e in entries if e.complete and e.drawable]

    def dominates(o: Entry, e: Entry) -> bool:
        if o.compared_error == e.compared_error:
            return o.time.is_less(e.time)
        return o.compared_error < e.compared_error and (o.time.seconds <= e.time.seconds or o.time.ties(e.time))

    return [replace(e, efficient=e in whole and not any(dominates(o, e) for o in whole)) for e in entries]


@dataclass(frozen=True)
class Advice:
    """The recommended method for a number of correct digits."""

    digits: int
    best: Entry | None  # the fastest method of `gim`; None if none reaches the digits
    nearest: Entry | None  # the most accurate method of `gim`
    reference: Entry | None  # a reference method that is faster, or that alone reaches the digits
    before: Advice | None = None  # that for fewer digits

    @property
    def price(self) -> float | None:
        """Time of a position for each further digit since the advice before [s]; 0 if it is within the spread."""
        if self.best is None or self.before is None or self.before.best is None:
            return None
        one, other = self.best.time, self.before.best.time
        return 0.0 if one.ties(other) else (one.seconds - other.seconds) / (self.digits - self.before.digits)

    @property
    def text(self) -> str:
        """The recommendation in a few sentences."""
        return f"{self.digits} digits: {self._choice()}{self._reference()}.{self._price()}"

    def _choice(self) -> str:
        best, nearest = self.best, self.nearest
        if best is not None:
            return (
                f"{best.method.options} --tolerance {best.tolerance:g} is fastest: {_time(best.time.seconds)} a"
                f" position, {_time(best.call)} a call of {best.steps} steps (true error {best.error:.1e})"
            )
        if nearest is None:
            return "no method solves all positions"
        return (
            f"no method reaches this accuracy in all positions; the most accurate is {nearest.method.options}"
            f" --tolerance {nearest.tolerance:g} (true error {nearest.error:.1e})"
        )

    def _reference(self) -> str:
        other = self.reference
        if other is None:
            return ""
        return (
            f"; textbook Newton-Raphson in {other.method.label} takes {_time(other.time.seconds)} a position"
            f" (tolerance {other.tolerance:g}, true error {other.error:.1e})"
        )

    def _price(self) -> str:
        if self.price is None or self.before is None or self.best is None:
            return ""
        if self.price == 0.0:
            return f" The same time as for {self.before.digits} digits, within the spread."
        less, price = "less " if self.price < 0.0 else "", abs(self.price)
        return (
            f" Each digit beyond {self.before.digits}: {_time(price)} {less}a position,"
            f" {_time(price * self.best.steps)} {less}a call."
        )


def _time(seconds: float) -> str:
    """Return a time to three digits, "not measured" if the clock did not show it."""
    if not math.isfinite(seconds):
        return "a time not measured for"
    micro = 1e6 * seconds
    return f"{micro:.3g} µs" if micro < 1e3 else f"{micro / 1e3:.3g} ms"


def advise(found: Tradeoff, digits: Sequence[int] = DIGITS) -> list[Advice]:
    """Return for each number of digits the fastest method with true errors below 10^-digits in all positions.

    Of methods that tie, the later one in `METHODS` is recommended.
    """
    whole = [e for e in found.entries if e.complete]
    tools, references = ([e for e in whole if bool(e.method.options) == offered] for offered in (True, False))
    accurate = min(tools, key=lambda e: (e.compared_error, e.time.seconds), default=None)
    advice: list[Advice] = []
    for count in sorted(digits):
        best, other = _fastest(tools, count), _fastest(references, count)
        if best is not None and other is not None and not other.time.is_less(best.time):
            other = None
        advice.append(Advice(count, best, accurate, other, advice[-1] if advice else None))
    return advice


def _fastest(entries: Sequence[Entry], digits: int) -> Entry | None:
    """Return the entry to recommend: of each method the tolerance of least work, then the method of least time."""
    enough: dict[str, list[Entry]] = {}
    for entry in entries:
        if entry.error < 10.0**-digits:
            enough.setdefault(entry.method.name, []).append(entry)
    chosen = [_tolerance(own, digits) for own in enough.values()]
    least = min(chosen, key=lambda e: e.time.seconds if e.drawable else math.inf, default=None)
    return next((e for e in reversed(chosen) if e is least or (least is not None and e.time.ties(least.time))), None)


def _tolerance(entries: Sequence[Entry], digits: int) -> Entry:
    """Return the entry of one method whose tolerance to recommend: the most accurate of those of least work.

    Of equally accurate ones it is the coarsest tolerance that is not coarser than the digits.
    """
    least = min(e.operations for e in entries)
    near = [e for e in entries if e.operations <= EQUAL_WORK * least]
    return min(near, key=lambda e: (e.compared_error, max(e.tolerance, 10.0**-digits), -e.tolerance))
