"""Times of runs, each repeated until it takes some milliseconds, in rounds that alternate between all runs.

A slowdown of the machine then affects all alike. The time is the median of the rounds; its spread is that of their
middle half. Differences within the spread are ties.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.progress import Progress, no_progress

Clock = Callable[[], float]
"""Returns a time [s]."""


@dataclass(frozen=True)
class Timing:
    """How runs are measured."""

    clock: Clock = time.process_time  # other programs do not add to the processor time
    rounds: int = 5
    fewest: int = 3  # rounds of a run that takes its share of the total; with fewer samples a time is not known
    long: float = 0.1  # s: a run that takes longer is made once
    alone: float = 0.5  # spread of a time from one run, relative to it
    least: float = max(8e-3, 20.0 * time.get_clock_info("process_time").resolution)  # s that a run takes at least
    most: int = 1 << 14  # repetitions in a run
    patience: float = 0.5  # s after which a run has no further repetitions, whatever the clock shows
    total: float = 3.0  # s for all runs together, which sets the number of rounds
    floor: float = 0.05  # least spread, relative to the time


TIMING = Timing()


@dataclass(frozen=True)
class Measured:
    """The time of one unit of a run, such as a position [s], and its spread [s]; NaN if the clock does not show it."""

    seconds: float = math.nan
    spread: float = math.nan

    def ties(self, other: Measured) -> bool:
        """Return whether the difference is within the spread, or not known."""
        return not abs(self.seconds - other.seconds) > self.spread + other.spread

    def is_less(self, other: Measured) -> bool:
        """Return whether it is less, and not a tie."""
        return self.seconds < other.seconds and not self.ties(other)


@dataclass
class _Run:
    """A run, how often it is repeated for one sample, and the samples [s a unit]."""

    repeat: Callable[[int], int]  # repeats the run; returns the number of units
    timing: Timing
    count: int = 1
    taken: float = 0.0  # s of the last sample
    samples: list[float] = field(default_factory=list)

    def sample(self) -> float:
        """Take a sample; return its time."""
        begin = self.timing.clock()
        units = self.repeat(self.count)
        self.taken = self.timing.clock() - begin
        if self.taken > 0.0:
            self.samples.append(self.taken / units)
        return self.taken

    def calibrate(self) -> None:
        """Set the number of repetitions."""
        timing, began = self.timing, time.monotonic()
        while self.sample() < timing.least and self.count < timing.most and time.monotonic() - began < timing.patience:
            wanted = self.count * 1.2 * timing.least / self.taken if self.taken > 0.0 else 0.0
            self.count = min(timing.most, max(2 * self.count, math.ceil(min(wanted, 16.0 * self.count))))
        if not self.is_long:
            self.samples.clear()

    @property
    def is_long(self) -> bool:
        """Whether one run takes so long that it is not repeated."""
        return self.count == 1 and self.taken > self.timing.long

    def result(self) -> Measured:
        """Return the median and the spread; a clock that often stands still shows nothing."""
        if self.is_long:
            return Measured(self.samples[0], self.timing.alone * self.samples[0])
        if len(self.samples) < min(self.timing.fewest, self.timing.rounds):
            return Measured()
        low, middle, high = np.quantile(self.samples, (0.25, 0.5, 0.75)).tolist()
        return Measured(middle, max(high - low, self.timing.floor * middle))


def measure(
    runs: Sequence[Callable[[int], int]], timing: Timing = TIMING, progress: Progress = no_progress
) -> list[Measured]:
    """Return the time of a unit of each run; a run repeats itself, and returns the number of units."""
    todo = [_Run(run, timing) for run in runs]
    for run in todo:
        run.calibrate()
    share = timing.total / max(1, len(todo))
    rounds = [
        timing.rounds if run.taken * timing.rounds <= share else min(timing.fewest, timing.rounds) for run in todo
    ]
    for number in range(timing.rounds):
        for k in range(len(todo)) if number % 2 else reversed(range(len(todo))):
            if number < rounds[k] and not todo[k].is_long:
                todo[k].sample()
        progress(number + 1, timing.rounds)
    return [run.result() for run in todo]
