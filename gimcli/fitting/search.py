"""Global searches: many starts, of which the better ones are refined further, stage by stage; and for the least goal.

A search may end early: after some seconds, or at Ctrl-C; the best designs are then those found so far.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.fitting.conditions import STEPS, DesignQuantities
from gimcli.fitting.constrained import constrained_goal
from gimcli.fitting.least_squares import FitProblem, Trials, joined, refined
from gimcli.fitting.starts import linear_dimensions, moves, random_designs, starts
from gimcli.mechanism import FloatArray
from gimcli.progress import WorkLimit


class SearchStop(WorkLimit):
    """The bound on a search in seconds; the first Ctrl-C reaches it too, and sets `interrupted`."""

    interrupted = False

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Turn the first Ctrl-C into an end of the search; the second one interrupts as usual."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.getsignal(signal.SIGINT)

        def heard(*_: Any) -> None:
            self.interrupted = self.reached = True
            signal.signal(signal.SIGINT, before)

        signal.signal(signal.SIGINT, heard)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)


@dataclass(frozen=True)
class FitSearchConstants:
    """Constants of the search."""

    batch: int = 1000  # random designs in one call
    batches: int = 5  # in one round: these are refined together
    stages: tuple[tuple[int, float], ...] = ((15, 0.4), (25, 0.4), (60, 0.4), (150, 1.0))  # steps, share that remains
    least: int = 20  # trials that remain after each stage, at least
    kept: int = 200  # best trials of all rounds that are kept
    polished: int = 40  # best trials that are refined at the end
    polishing: int = 500  # steps of that; minima in long flat valleys need them
    inputs: int = 12  # rows with which linear dimensions are recognised
    alike: float = 1e-4  # relative difference of the errors, or goals, of one minimum
    goal_steps: int = 72  # of the motions of random designs, for a goal
    improved: int = 12  # best random designs that are improved, for a goal


CONSTANTS = FitSearchConstants()


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The best trials of a search, sorted by their errors."""

    trials: Trials
    drawn: int  # random designs so far
    started: int  # of these, designs that can be assembled and were refined

    def same(self, error: float, zero: float) -> NDArray[np.bool_]:
        """Return which trials have an error; errors below `zero` are equal."""
        return np.asarray(np.abs(self.trials.error - error) <= zero + CONSTANTS.alike * abs(error))

    def exact(self, zero: float) -> bool:
        """Return whether there is an exact fit: more starts cannot improve it."""
        return len(self.trials) > 0 and float(self.trials.error[0]) <= zero


def search(problem: FitProblem, nominal: FloatArray, count: int, seed: int) -> Iterator[SearchResult]:
    """Yield the result after each round of random designs, until there are `count`; the last one is polished.

    The same seed gives the same result. `nominal` is a design that can be assembled.
    """
    generator = np.random.default_rng(seed)
    limits = problem.targets.range
    linear = linear_dimensions(problem.quantity, nominal, problem.lower, problem.upper, limits.grid(CONSTANTS.inputs))
    best, drawn, started = None, 0, 0
    while drawn < count and not (best is not None and problem.stop()):
        begun, more = _begun(problem, linear, generator, count - drawn)
        drawn, started = drawn + more, started + len(begun)
        found = _in_stages(problem, begun)
        found = found[moves(problem, found.designs)] if problem.whole else found
        best = (found if best is None else joined([best, found])).best(CONSTANTS.kept)
        if drawn >= count or problem.stop():
            polished = refined(problem, best[: CONSTANTS.polished], CONSTANTS.polishing)
            polished = polished[moves(problem, polished.designs)] if problem.whole else polished
            best = joined([polished, best[CONSTANTS.polished :]]).best(CONSTANTS.kept)
        best = replace(best, designs=problem.within(best.designs))
        yield SearchResult(best, drawn, started)


def _begun(
    problem: FitProblem, linear: NDArray[np.int64], generator: np.random.Generator, most: int
) -> tuple[Trials, int]:
    """Return the starts of a round, and the number of random designs of which they remain."""
    parts, drawn = [], 0
    while drawn < min(CONSTANTS.batches * CONSTANTS.batch, most):
        count = min(CONSTANTS.batch, most - drawn)
        designs = random_designs(problem.lower, problem.upper, count, generator)
        parts.append(starts(problem, designs, linear, generator))
        drawn += count
        if problem.stop():
            break
    return joined(parts), drawn


def _in_stages(problem: FitProblem, at: Trials) -> Trials:
    """Refine all trials a little, and the better ones further."""
    for steps, share in CONSTANTS.stages:
        at = refined(problem, at, steps).best(max(CONSTANTS.least, int(share * len(at))))
    return at


def goal_search(
    quantities: DesignQuantities, lower: FloatArray, upper: FloatArray, count: int, seed: int,
    progress: Callable[[int, int], None], stop: Callable[[], bool],
) -> SearchResult:  # fmt: skip
    """Return the designs with the least goals that were found, as trials; the same seed gives the same result."""
    generator, dimensions = np.random.default_rng(seed), len(lower)
    best, drawn, started = list[Trials](), 0, 0
    while drawn < count and not (drawn and stop()):
        size = min(CONSTANTS.batch, count - drawn)
        found = _with_goals(quantities, random_designs(lower, upper, size, generator), CONSTANTS.goal_steps)
        drawn, started = drawn + size, started + len(found)
        best = [joined([*best, found]).best(CONSTANTS.improved)]
        progress(drawn, count)
    improved = [constrained_goal(quantities, design, lower, upper) for design in best[0].designs if not stop()]
    every = np.concatenate((best[0].designs, np.reshape(improved, (-1, dimensions))))
    last = _with_goals(quantities, every, STEPS).best(len(every)) if len(every) else best[0]
    return SearchResult(last, drawn, started)


def _with_goals(quantities: DesignQuantities, designs: FloatArray, steps: int) -> Trials:
    """Return designs with their goals as trials; those without a goal are left out."""
    goals, none = quantities.admitted_goals(designs, steps), np.zeros(len(designs))
    return Trials(designs, np.empty((len(designs), 0)), none, goals, none)[np.isfinite(goals)]
