"""Fit the dimensions of a mechanism to targets."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from gimcli.errors import StructureError, UsageError
from gimcli.families.family import Family
from gimcli.fitting.conditions import DesignQuantities
from gimcli.fitting.constrained import under_conditions
from gimcli.fitting.goal_search import goal_search
from gimcli.fitting.least_squares import FitProblem, Trials
from gimcli.fitting.motion_quantity import MotionQuantity
from gimcli.fitting.search import CONSTANTS, SearchResult, search
from gimcli.fitting.starts import periodic_dimensions
from gimcli.library.fit_check import FittedDesign, GoalChecker, TargetChecker
from gimcli.library.fit_result import FitCounts, FitResult, GoalResult
from gimcli.library.fit_targets import FittedTask, columns_of, task_of
from gimcli.library.inputs import refuse_count, refuse_unmoved
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.progress import Notify, Phases, Progress, no_phases
from gimcli.structure.drive_check import explained

STARTS = 25_000
"""Number of random designs of a search."""

START_STEPS = 72
"""Steps of the motions of random designs for which conditions are computed."""

MOST_STARTS = 10_000_000

MOST_CHECKED = 60
"""Largest number of fitted designs whose real motion is traced."""


def fit(
    mechanism: Mechanism, vary: Mapping[str, tuple[float, float]],
    through: Path | str | Mapping[str, Sequence[float]] | Sequence[Sequence[float]] | None = None, *,
    timing: str = "", point: str = "", output: str = "", goal: str = "", where: str | Sequence[str] = (),
    any_order: bool = False, starts: int = STARTS, seed: int = 0, notify: Notify | None = None,
    progress: Phases = no_phases,
) -> FitResult:  # fmt: skip
    """Find dimensions for which a point, a member or an output passes targets, or for which a goal is least.

    Args:
        mechanism: from `load` or `loads`. For targets it has one actuator. Its dimensions are where the search begins,
            and its configuration is the one that is fitted.
        vary: least and greatest value of each dimension that varies, by name, in the file's units.
        through: targets: a CSV file with a header, or a dict of columns. `x,y`: places of a point; `x,y,x2,y2`: pairs
            of places, both as near as possible; `x,y,angle`: poses of a member; `input,output`: a function. Places and
            poses may have a column `input`. Rows of x and y are also accepted.
        timing: "free": each target has an unknown input, and the targets follow each other in order; "given": the
            inputs are those of the file; "step": only their differences are. By default "given" if there is a column
            `input`, otherwise "free".
        point: the node or point for places and poses; by default the first of `trace`.
        output: the angle or coordinate for a function, such as "rocker.angle" or "P.x".
        goal: instead of targets: a quantity that is least, in the form of `sweep`, such as "-range(P.y)".
        where: conditions on the fitted design, in the form of `sweep`, such as "range(P.y) > 40" or
            "type == 'crank-rocker'"; one text or a list. Inequalities can be active.
        any_order: with timing "free": the targets may follow each other in any order.
        starts: number of random designs.
        seed: seed of the random designs; the same seed gives the same result.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (designs done, all designs).

    Returns:
        A FitResult. `.mechanism` is the fitted mechanism, `.error` the sum of squares (or the goal); `.feasible` is
        False if no design was found whose real motion passes the targets in order on one branch, over the whole law,
        and satisfies the conditions.

    Raises:
        UsageError: an unknown name or an invalid argument.
        StructureError: the mechanism is not fully driven.
    """
    from gimcli.model.dimensions import dimension

    if mechanism.couplings:
        raise StructureError(f"{mechanism.name} has inputs that follow others: `fit` cannot vary it; `gim sweep` can")
    refuse_count("seed", seed, 0, 2**63)
    refuse_count("starts", starts, 1, MOST_STARTS)
    refuse_unmoved(mechanism, "add an actuator")
    lower, upper = _bounds(vary)
    task = None if goal else task_of(mechanism, columns_of(through), timing, point, output, any_order)
    if goal and (through is not None or timing or point or output):
        raise UsageError("goal: a goal takes the place of targets: remove through, timing, point and output")
    names = tuple(dimension(mechanism, name).name for name in vary)
    if len(set(names)) < len(names):
        raise UsageError(f"vary: {', '.join(names)}: a dimension is named twice; remove one")
    with explained(mechanism):
        family = Family(mechanism, names)
    for name in family.without_effect(lower[None], upper[None]):
        raise UsageError(f"vary {name}: it changes no length, shape or law, so that it cannot be fitted; remove it")
    quantities = DesignQuantities(family, [where] if isinstance(where, str) and where else tuple(where), goal)
    report = progress("fitting")
    if task is None:
        return _least_goal(quantities, lower, upper, starts, seed, report)
    problem = _problem(quantities, task, lower, upper, notify)
    return _least_error(quantities, problem, task, starts, seed, report)


def _least_goal(
    quantities: DesignQuantities, lower: FloatArray, upper: FloatArray, starts: int, seed: int, progress: Progress
) -> FitResult:
    """Return the feasible design with the least goal."""
    assert quantities.goal is not None
    search = goal_search(quantities, lower, upper, starts, seed, progress)
    checker, nominal = GoalChecker(quantities), quantities.family.mechanism
    tried = zip(search.designs[:MOST_CHECKED], search.goals.tolist(), strict=False)
    found = next((one for design, goal in tried if (one := checker.checked(design, goal)) is not None), None)
    hits = 0 if found is None else search.same(found.error)
    counts = FitCounts(search.drawn, search.started, hits, seed)
    return GoalResult(nominal, quantities.family.names, found, counts, quantities.goal.text)


def _least_error(
    quantities: DesignQuantities, problem: FitProblem, task: FittedTask, starts: int, seed: int, progress: Progress
) -> FitResult:
    """Return the feasible design with the least error; an exact one ends the search."""
    family, found, counts, reason = quantities.family, None, FitCounts(0, 0, 0, seed), ""
    for last in search(problem, family.nominal, starts, seed):
        progress(last.drawn, starts)
        counts = FitCounts(last.drawn, last.started, 0, seed)
        if not last.exact(problem.zero) and last.drawn < starts:
            continue
        best = under_conditions(problem, quantities, last.trials) if quantities.texts else last.trials
        checker = TargetChecker(problem, task, quantities)
        found, reason = _first_feasible(checker, best), _reason(last, best, checker)
        if found is not None:
            hits = int(replace(last, trials=best).same(found.error - task.targets.constant, problem.zero).sum())
            counts = replace(counts, hits=hits)
            break
    return FitResult(family.mechanism, family.names, found, counts, task, reason)


def _bounds(vary: Mapping[str, tuple[float, float]]) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest values (dimensions,)."""
    if not vary:
        raise UsageError("vary: name at least one dimension and its bounds")
    pairs = []
    for name, bounds in vary.items():
        try:
            low, high = map(float, bounds)
        except (TypeError, ValueError, OverflowError):
            low = high = math.nan
        if not math.isfinite(high - low) or low >= high:
            raise UsageError(f"vary {name}: expected a least and a greater finite value, such as 10 and 60")
        pairs.append((low, high))
    lower, upper = np.array(pairs).T
    return lower, upper


def _problem(
    quantities: DesignQuantities, task: FittedTask, lower: FloatArray, upper: FloatArray, notify: Notify | None
) -> FitProblem:
    family = quantities.family
    quantity = MotionQuantity(family, task.components, notify)
    rows = task.targets.range.grid(CONSTANTS.inputs)
    periodic = periodic_dimensions(quantity, family.nominal, lower, upper, rows)
    admits = partial(quantities.hold, steps=START_STEPS) if quantities.texts else None
    return FitProblem(quantity, task.targets, lower, upper, periodic, admits=admits)


def _first_feasible(checker: TargetChecker, at: Trials) -> FittedDesign | None:
    """Return the feasible design with the least error."""
    tried = (checker.checked(at[k : k + 1]) for k in range(min(len(at), MOST_CHECKED)))
    return next((found for found in tried if found is not None), None)


def _reason(last: SearchResult, best: Trials, checker: TargetChecker) -> str:
    """Return why no design is feasible."""
    if not last.started:
        conditions = " and satisfies the conditions" if checker.quantities.texts else ""
        return f"none of them moves over the whole law{conditions}"
    if not len(best):
        return "no fit satisfies the conditions" if checker.quantities.texts else "no fit moves over the whole law"
    return "of the best fits " + ", ".join(f"{count} {reason}" for reason, count in checker.refused.most_common())
