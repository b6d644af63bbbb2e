"""Fit the dimensions of a mechanism to targets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from gimcli.errors import UsageError
from gimcli.families.family import Family
from gimcli.fitting.least_squares import FitProblem, Trials
from gimcli.fitting.motion_quantity import MotionQuantity
from gimcli.fitting.search import CONSTANTS, SearchResult, search
from gimcli.fitting.starts import periodic_dimensions
from gimcli.library.fit_check import DesignChecker, FittedDesign
from gimcli.library.fit_result import FitResult
from gimcli.library.fit_targets import FittedTask, columns_of, task_of
from gimcli.library.inputs import refuse_count, refuse_unmoved
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.progress import Notify, Phases, Progress, no_phases
from gimcli.structure.drive_check import explained

STARTS = 20_000
"""Number of random designs of a search."""

MOST_STARTS = 10_000_000

MOST_CHECKED = 60
"""Largest number of fitted designs whose real motion is traced."""


def fit(
    mechanism: Mechanism, vary: Mapping[str, tuple[float, float]],
    through: Path | str | Mapping[str, Sequence[float]] | Sequence[Sequence[float]], *, timing: str = "",
    point: str = "", output: str = "", starts: int = STARTS, seed: int = 0, notify: Notify | None = None,
    progress: Phases = no_phases,
) -> FitResult:  # fmt: skip
    """Find dimensions for which a point, a member or an output passes targets.

    Args:
        mechanism: from `load` or `loads`; it has one actuator. Its dimensions are where the search begins, and its
            configuration is the one that is fitted.
        vary: least and greatest value of each dimension that varies, by name, in the file's units.
        through: targets: a CSV file with a header, or a dict of columns. `x,y`: places of a point; `x,y,x2,y2`: pairs
            of places, both as near as possible; `x,y,angle`: poses of a member; `input,output`: a function. Places and
            poses may have a column `input`. Rows of x and y are also accepted.
        timing: "free": each target has an unknown input, and the targets follow each other in order; "given": the
            inputs are those of the file; "step": only their differences are. By default "given" if there is a column
            `input`, otherwise "free".
        point: the node or point for places and poses; by default the first of `trace`.
        output: the angle or coordinate for a function, such as "rocker.angle" or "P.x".
        starts: number of random designs.
        seed: seed of the random designs; the same seed gives the same result.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (designs done, all designs).

    Returns:
        A FitResult. `.mechanism` is the fitted mechanism, `.error` the sum of squares; `.feasible` is False if no
        design was found whose real motion passes the targets in order on one branch.

    Raises:
        UsageError: an unknown name or an invalid argument.
        StructureError: the mechanism is not fully driven.
    """
    refuse_count("seed", seed, 0, 2**63)
    refuse_count("starts", starts, 1, MOST_STARTS)
    refuse_unmoved(mechanism, "add an actuator")
    lower, upper = _bounds(vary)
    task = task_of(mechanism, columns_of(through), timing, point, output)
    with explained(mechanism):
        family = Family(mechanism, tuple(vary))
    problem = _problem(family, task, lower, upper, notify)
    found = last = None
    count = 0
    for last in _rounds(problem, family, starts, seed, progress("fitting")):
        if last.exact(problem.zero) or last.drawn >= starts:
            found, count = _first_feasible(DesignChecker(family, problem, task), last.trials)
            if found is not None:
                break
    assert last is not None
    return FitResult(mechanism, task, tuple(vary), found, last, count, problem.zero, seed)


def _bounds(vary: Mapping[str, tuple[float, float]]) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest values (dimensions,)."""
    if not vary:
        raise UsageError("vary: name at least one dimension and its bounds")
    for name, bounds in vary.items():
        if len(bounds) != 2 or not all(map(math.isfinite, bounds)) or bounds[0] >= bounds[1]:
            raise UsageError(f"vary {name}: expected a least and a greater finite value, such as 10 and 60")
    pairs = np.array([list(map(float, bounds)) for bounds in vary.values()])
    return pairs[:, 0], pairs[:, 1]


def _problem(
    family: Family, task: FittedTask, lower: FloatArray, upper: FloatArray, notify: Notify | None
) -> FitProblem:
    quantity = MotionQuantity(family, task.components, notify)
    rows = task.targets.range.grid(CONSTANTS.inputs)
    periodic = periodic_dimensions(quantity, family.nominal, lower, upper, rows)
    return FitProblem(quantity, task.targets, lower, upper, periodic)


def _rounds(problem: FitProblem, family: Family, starts: int, seed: int, progress: Progress) -> Iterator[SearchResult]:
    """Yield the result of each round of a search; report its progress."""
    progress(0, starts)
    for found in search(problem, family.nominal, starts, seed):
        progress(found.drawn, starts)
        yield found


def _first_feasible(checker: DesignChecker, at: Trials) -> tuple[FittedDesign | None, int]:
    """Return the feasible design with the least error, and the number of designs that were traced."""
    count = min(len(at), MOST_CHECKED)
    for k in range(count):
        found = checker.checked(at[k : k + 1])
        if found is not None:
            return found, k + 1
    return None, count
