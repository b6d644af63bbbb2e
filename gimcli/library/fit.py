"""Fit the dimensions of a mechanism to targets."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from gimcli.errors import ModelError, UsageError, refuse
from gimcli.families.family import Family
from gimcli.fitting.conditions import DesignQuantities
from gimcli.fitting.constrained import under_conditions
from gimcli.fitting.least_squares import FitProblem, Trials, undetermined
from gimcli.fitting.motion_quantity import MotionQuantity, varied_ends
from gimcli.fitting.search import CONSTANTS, SearchResult, SearchStop, goal_search, search
from gimcli.fitting.starts import periodic_dimensions
from gimcli.fitting.targets import FREE, TIMINGS, TURN
from gimcli.library.fit_result import FitCounts, FitResult, GoalResult
from gimcli.library.fit_targets import FittedTask, columns_of, input_range, task_of
from gimcli.library.fitted_design import FittedDesign, GoalChecker, TargetChecker
from gimcli.library.inputs import OneOf, Range, Seed, refuse_unmoved
from gimcli.library.machines import accepted, driven_machines, for_each_machine
from gimcli.mechanism import FloatArray, Machine, Mechanism
from gimcli.model.dimensions import written
from gimcli.progress import Notify, Phases, Progress, WorkLimit, no_phases
from gimcli.status import Status

STARTS = 25_000
"""Number of random designs of a search."""

START_STEPS = 72
"""Steps of the motions of random designs for which conditions are computed."""

MOST_STARTS = 10_000_000

SAME_LAW = 1e-9
"""Change of a law, relative to its largest value or to a turn, that counts as rounding."""

NOTICES = 10.0
"""Seconds between two notices of the best value so far."""

MOST_CHECKED = 60
"""Largest number of fitted designs whose real motion is traced."""


def _machine(mechanism: Mechanism, given: dict[str, Any]) -> list[Machine]:
    """Return the machine that has all dimensions; raise UsageError if several have some of them."""
    names = [written(mechanism).dimension(name).name for name in given["vary"]]
    found = [m for m in driven_machines(mechanism) if all(accepted(m.mechanism.written.dimension, n) for n in names)]
    refuse(
        (
            len(found) != 1,
            f"vary {', '.join(names)}: a fit is of one machine; vary dimensions that only one machine has",
        )
    )
    return found


@for_each_machine(_machine)
def fit(
    mechanism: Mechanism, vary: Mapping[str, tuple[float, float]],
    through: Path | str | Mapping[str, Sequence[float]] | Sequence[Sequence[float]] | None = None, *,
    timing: Annotated[str, OneOf(TIMINGS)] = "", point: str = "", output: str = "", goal: str = "",
    where: str | Sequence[str] = (), any_order: bool = False,
    starts: Annotated[int, Range(1, MOST_STARTS)] = STARTS, seed: Seed = 0, notify: Notify | None = None,
    progress: Phases = no_phases, seconds: float | None = None,
) -> FitResult:  # fmt: skip
    """Find dimensions for which a point, a member or an output passes targets, or for which a goal is least.

    Args:
        mechanism: from `load` or `loads`; of several machines the one that has all dimensions. For targets it has one
            actuator. Its dimensions are where the search begins, and its configuration is the one that is fitted.
        vary: least and greatest value of each dimension that varies, by name, in the file's units.
        through: targets: a CSV file with a header, or a dict of columns. `x,y`: places of a point; `x,y,x2,y2`: pairs
            of places, both as near as possible; `x,y,angle`: poses of a member; `input,output`: a function. Places and
            poses may have a column `input`. Rows of x and y are also accepted.
        timing: "free": each target has an unknown input, and the targets follow each other in order; "given": the
            inputs are those of the file; "step": only their differences are. By default "given" if there is a column
            `input`, otherwise "free".
        point: node or point for places and poses, by default the first of `trace`.
        output: angle or coordinate for a function, such as "rocker.angle" or "P.x".
        goal: quantity that is least, instead of targets, such as "-range(P.y)"; in the form of `sweep`.
        where: conditions on the fitted design, in the form of `sweep`, such as "range(P.y) > 40" or
            "type == 'crank-rocker'"; one text or a list. Inequalities can be active.
        any_order: with `timing` "free": the targets may follow each other in any order.
        starts: number of random designs.
        seed: seed of the random designs; the same seed gives the same result.
        notify: function of a text; called with notices, such as the start of a compilation.
        seconds: the search ends after this time with the best design found; by default it has no such end. Ctrl-C
            ends it in the same way.
        progress: function of the name of a phase; returns a function of (designs done, all designs).

    Returns:
        A FitResult. `.mechanism` is the fitted mechanism, `.error` the sum of squares (or the goal); `.feasible` is
        False if no design was found whose real motion passes the targets in order on one branch, over the whole law,
        and satisfies the conditions.

    Raises:
        UsageError: an unknown name or an invalid argument.
        StructureError: the mechanism is not fully driven.
    """
    refuse_unmoved(mechanism, "add an actuator")
    lower, upper = _bounds(vary)
    task = None if goal else task_of(mechanism, columns_of(through), timing, point, output, any_order)
    names = tuple(written(mechanism).dimension(name).name for name in vary)
    refuse(
        (
            goal and (through is not None or timing or point or output),
            "goal: a goal takes the place of targets: remove through, timing, point and output",
        ),
        (len(set(names)) < len(names), f"vary: {', '.join(names)}: a dimension is named twice; remove one"),
    )
    family = Family(mechanism, names)
    _refuse_other_laws(family, lower, upper)
    quantities = DesignQuantities(family, [where] if isinstance(where, str) and where else tuple(where), goal)
    for name in family.without_effect(lower[None], upper[None], forces=quantities.names.forced):
        raise UsageError(f"vary {name}: it changes no length, shape or law, so that it cannot be fitted; remove it")
    report = progress("fitting")
    stop = SearchStop(seconds=seconds)
    if task is None:
        with stop.listening():
            return _least_goal(quantities, lower, upper, starts, seed, report, stop)
    task, varied = _with_law(family, task, lower, upper)
    problem = _problem(quantities, task, lower, upper, notify, varied, stop)
    with stop.listening():
        return _least_error(quantities, problem, task, starts, seed, report, notify, stop)


def _least_goal(
    quantities: DesignQuantities, lower: FloatArray, upper: FloatArray, starts: int, seed: int, progress: Progress,
    stop: SearchStop,
) -> FitResult:  # fmt: skip
    """Return the feasible design with the least goal."""
    assert quantities.goal is not None
    search = goal_search(quantities, lower, upper, starts, seed, progress, stop.spend)
    found, family = _first_feasible(GoalChecker(quantities), search.trials), quantities.family
    hits = 0 if found is None else int(search.same(found.error, 0.0).sum())
    counts = FitCounts(search.drawn, search.started, hits, seed, _ended(stop))
    stand = _stand(found, family.names, lower, upper)
    return GoalResult(family.mechanism, family.names, found, counts, stand=stand, goal=quantities.goal.text)


def _least_error(
    quantities: DesignQuantities, problem: FitProblem, task: FittedTask, starts: int, seed: int, progress: Progress,
    notify: Notify | None, stop: SearchStop,
) -> FitResult:  # fmt: skip
    """Return the feasible design with the least error; an exact one ends the search."""
    family, found, counts, reason = quantities.family, None, FitCounts(0, 0, 0, seed), ""
    free: tuple[str, ...] = ()
    due = WorkLimit(seconds=NOTICES)
    for last in search(problem, family.nominal, starts, seed):
        progress(last.drawn, starts)
        counts = FitCounts(last.drawn, last.started, 0, seed, _ended(stop))
        if notify is not None and due.spend() and len(last.trials):
            due = WorkLimit(seconds=NOTICES)
            best_yet = last.trials.error[0] + task.targets.constant
            notify(f"fitting: {last.drawn} of {starts} random designs, least sum of squares so far {best_yet:.6g}")
        if not last.exact(problem.zero) and last.drawn < starts and not stop.spend():
            continue
        best = under_conditions(problem, quantities, last.trials) if quantities.texts else last.trials
        checker = TargetChecker(problem, task, quantities)
        found, reason = _first_feasible(checker, best), _reason(last, best, checker)
        if found is not None:
            hits = int(replace(last, trials=best).same(found.error - task.targets.constant, problem.zero).sum())
            counts = replace(counts, hits=hits, ended=_ended(stop))
            free = undetermined(problem, best, found.design, family.names)
            break
    stand = _stand(found, family.names, problem.least, problem.most)
    return FitResult(family.mechanism, family.names, found, counts, task, reason, stand, free)


def _ended(stop: SearchStop) -> str:
    """Return how a search ended: the word of a status, or "interrupted"."""
    return "interrupted" if stop.interrupted else (Status.WORK_LIMIT if stop.reached else Status.OK).word


def _stand(
    found: FittedDesign | None, names: Sequence[str], lower: FloatArray, upper: FloatArray
) -> tuple[str, ...]:  # fmt: skip
    """Return the names of the dimensions that stand on a bound."""
    if found is None:
        return ()
    with np.errstate(invalid="ignore"):
        room = np.where(np.isfinite(upper - lower), SAME_LAW * (upper - lower), 0.0)
    on = (found.design <= lower + room) | (found.design >= upper - room)
    return tuple(name for name, one in zip(names, on, strict=True) if one)


def _bounds(vary: Mapping[str, tuple[float, float]]) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest values (dimensions,)."""
    refuse((not vary, "vary: name at least one dimension and its bounds"))
    pairs = []
    for name, bounds in vary.items():
        try:
            low, high = map(float, bounds)
        except (TypeError, ValueError, OverflowError):
            low = high = math.nan
        wrong = f"vary {name}: expected a least and a greater finite value, such as 10 and 60"
        refuse((not 0.0 < high - low < math.inf, wrong))
        pairs.append((low, high))
    lower, upper = np.array(pairs).T
    return lower, upper


def _with_law(family: Family, task: FittedTask, lower: FloatArray, upper: FloatArray) -> tuple[FittedTask, bool]:
    """Return the task with the range of a law that varies, and whether targets have places in the law of each design.

    They have none where the law is a full turn for all designs: its start alone decides nothing.
    """
    ends = varied_ends(family, lower, upper)
    turning = task.targets.range.turning and bool(np.all(np.abs(ends[:, 1] - ends[:, 0]) >= TURN * (1.0 - SAME_LAW)))
    if turning or not np.ptp(ends, axis=0).any():
        return task, False
    if task.targets.timing != FREE:
        count = len(family.names)
        names = [n for k, n in enumerate(family.names) if np.ptp(ends[[0, 1 + k, 1 + count + k]], axis=0).any()]
        raise UsageError(
            f"vary {', '.join(names)}: the targets give the inputs, so that the law cannot vary; remove it"
        )
    limits = input_range(family.mechanism, turning=False)
    return replace(task, targets=replace(task.targets, range=limits)), True


def _refuse_other_laws(family: Family, lower: FloatArray, upper: FloatArray) -> None:
    """Raise UsageError for a dimension that changes a law by more than its ends."""
    time = np.linspace(0.0, 1.0, START_STEPS + 1)
    for k, name in enumerate(family.names):
        for bound in (lower[k], upper[k]):
            design = family.nominal.copy()
            design[k] = bound
            with suppress(ModelError):
                own = family.mechanism.with_({name: float(bound)})
                law = np.array([own.actuators[k].law(time) for k in own.drivers])
                assumed = family.law_inputs(time, family.tables(design[None]))[0][list(own.drivers)]
                refuse(
                    (
                        np.max(np.abs(law - assumed)) > SAME_LAW * (1.0 + np.max(np.abs(law))),
                        f"vary {name}: it changes the form of the law, which a fit cannot vary; remove it",
                    )
                )


def _problem(
    quantities: DesignQuantities, task: FittedTask, lower: FloatArray, upper: FloatArray, notify: Notify | None,
    varied: bool, stop: SearchStop,
) -> FitProblem:  # fmt: skip
    family = quantities.family
    quantity = MotionQuantity(family, task.components, notify, along_law=varied)
    rows = task.targets.range.grid(CONSTANTS.inputs)
    periodic = periodic_dimensions(quantity, family.nominal, lower, upper, rows)
    admits = partial(quantities.hold, steps=START_STEPS) if quantities.texts else None
    return FitProblem(quantity, task.targets, lower, upper, periodic, admits=admits, stop=stop.spend)


def _first_feasible(checker: GoalChecker | TargetChecker, at: Trials) -> FittedDesign | None:
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
