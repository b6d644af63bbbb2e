"""Global search for the least goal: random designs, of which the best are improved under the conditions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gimcli.fitting.conditions import STEPS, DesignQuantities
from gimcli.fitting.constrained import constrained_goal
from gimcli.fitting.starts import random_designs
from gimcli.mechanism import FloatArray


@dataclass(frozen=True)
class GoalSearchConstants:
    """Constants of the search."""

    batch: int = 1000  # random designs in one call
    steps: int = 72  # of the motions of random designs
    improved: int = 12  # best random designs that are improved
    alike: float = 1e-4  # relative difference of the goals of one minimum


CONSTANTS = GoalSearchConstants()


@dataclass(frozen=True, eq=False)
class GoalSearchResult:
    """The best designs of a search, sorted by their goals."""

    designs: FloatArray  # (designs, dimensions) file's units
    goals: FloatArray  # (designs,)
    drawn: int  # random designs
    started: int  # of these, designs that move over the whole law and satisfy the conditions

    def same(self, goal: float) -> int:
        """Return the number of designs with a goal."""
        return int(np.sum(np.abs(self.goals - goal) <= CONSTANTS.alike * abs(goal)))


def goal_search(
    quantities: DesignQuantities, lower: FloatArray, upper: FloatArray, count: int, seed: int,
    progress: Callable[[int, int], None], stop: Callable[[], bool],
) -> GoalSearchResult:  # fmt: skip
    """Return the designs with the least goals that were found; the same seed gives the same result."""
    generator, dimensions = np.random.default_rng(seed), len(lower)
    best, least, drawn, started = np.empty((0, dimensions)), np.empty(0), 0, 0
    while drawn < count and not (drawn and stop()):
        size = min(CONSTANTS.batch, count - drawn)
        designs = random_designs(lower, upper, size, generator)
        goals = quantities.admitted_goals(designs, CONSTANTS.steps)
        drawn, started = drawn + size, started + int(np.isfinite(goals).sum())
        best, least = _least(np.concatenate((best, designs)), np.concatenate((least, goals)), CONSTANTS.improved)
        progress(drawn, count)
    improved = [constrained_goal(quantities, design, lower, upper) for design in best if not stop()]
    every = np.concatenate((best, np.reshape(improved, (-1, dimensions))))
    goals = quantities.admitted_goals(every, STEPS) if len(every) else least
    return GoalSearchResult(*_least(every, goals, len(every)), drawn, started)


def _least(designs: FloatArray, goals: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return the designs with the least goals, and these; designs without a goal are left out."""
    order = np.argsort(goals, kind="stable")[: min(count, int(np.isfinite(goals).sum()))]
    return designs[order], goals[order]
