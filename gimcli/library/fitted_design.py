"""The real motion of a fitted mechanism: traced over its law, through the inputs of all targets.

Fitted designs are checked on it: all rows are solved, and the targets are passed in order on one branch.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from gimcli.errors import GimError
from gimcli.families.design_state import position_items
from gimcli.families.family import Family
from gimcli.fitting.conditions import DesignQuantities
from gimcli.fitting.least_squares import FitProblem, Trials
from gimcli.fitting.motion_quantity import MotionQuantity
from gimcli.fitting.targets import TURN, FitRange
from gimcli.input_laws import InputLaw, SummedLaw
from gimcli.library.fit_targets import FittedTask, input_range
from gimcli.library.machines import accepted
from gimcli.library.trace import MotionTraceResult, trace
from gimcli.mechanism import FRAME, FloatArray, IntArray, Mechanism
from gimcli.model.edited_text import written_with
from gimcli.model.read import read_text
from gimcli.positions.inputs import divided
from gimcli.quantities.kinds import quantities_of
from gimcli.quantities.quantity import Item

ROWS = 360
"""Approximate number of rows of the motion."""

TOGETHER = 1e-9
"""Inputs at a smaller distance are one row [rad, or length in the normal frame]."""


@dataclass(frozen=True, eq=False)
class RowsLaw(InputLaw):
    """A law that gives the values of rows at equidistant times."""

    values: FloatArray  # (rows,)

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value, or its derivative with respect to the normalised time."""
        last = len(self.values) - 1
        at = np.asarray(time) * last
        if order == 0:
            return np.interp(at, np.arange(last + 1), self.values)
        slope = np.diff(self.values) * last
        return slope[np.clip(at.astype(int), 0, last - 1)] if order == 1 else np.zeros(np.shape(time))


@dataclass(frozen=True, eq=False)
class FitMotion:
    """The motion of a fitted mechanism, and where it is at the targets."""

    trace: MotionTraceResult
    places: IntArray  # (targets,) rows of the targets
    values: FloatArray  # (targets, components), NaN where not solved; angles in rad

    @property
    def worst_transmission(self) -> float | None:
        """The least distance of all transmission angles from 0 and 180 degrees, in the file's unit; None if none."""
        turn = 180.0 if self.trace.mechanism.angle_unit == "deg" else TURN / 2.0
        table = self.trace.table()
        angles = [table.floats(name) for name in table.names if name.startswith("transmission")]
        worst = [float(np.nanmin(np.minimum(a, turn - a))) for a in angles if np.isfinite(a).any()]
        return min(worst, default=None)


def fit_motion(mechanism: Mechanism, task: FittedTask, inputs: FloatArray) -> FitMotion:
    """Trace a mechanism over its law, from its start, through the inputs (targets,) of the targets."""
    rows, places = _rows(mechanism, input_range(mechanism, task.targets.range.turning), inputs)
    actuators, driver = list(mechanism.actuators), mechanism.drivers[0]
    actuators[driver] = replace(actuators[driver], law=RowsLaw(rows))
    for one in mechanism.couplings:
        law = SummedLaw(tuple((ratio, actuators[k].law) for k, ratio in one.terms), one.phase)
        actuators[one.follower] = replace(actuators[one.follower], law=law)
    own = replace(mechanism, actuators=tuple(actuators))
    own = own if own.complete is None else own.complete(own)
    found = cast(MotionTraceResult, trace(own, len(rows) - 1, measure=_measured(mechanism)))
    values = [_component(found, one)[places] for one in task.components]
    return FitMotion(found, places, np.stack(values, axis=-1))


def law_motion(mechanism: Mechanism) -> FitMotion:
    """Trace a mechanism over its law."""
    found = cast(MotionTraceResult, trace(mechanism, ROWS, measure=_measured(mechanism)))
    return FitMotion(found, np.empty(0, dtype=np.int64), np.empty((0, 0)))


def _rows(mechanism: Mechanism, limits: FitRange, inputs: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the inputs of the rows, which include those of the targets, and the rows of the targets."""
    first, last = (float(v) for v in mechanism.actuators[mechanism.drivers[0]].law(np.array([0.0, 1.0])))
    sense = -1.0 if last < first else 1.0
    begin, span = (
        (first, TURN) if limits.turning else (limits.low if sense > 0.0 else limits.high, limits.high - limits.low)
    )
    along = (inputs - begin) * sense
    along = along % TURN if limits.turning else np.clip(along, 0.0, span)
    stops = np.unique(np.concatenate(([0.0, span], along)))
    stops = stops[np.concatenate(([True], np.diff(stops) > TOGETHER))]
    counts = np.maximum(1, np.ceil(np.diff(stops) / span * ROWS).astype(int))
    places = np.concatenate(([0], np.cumsum(counts)))
    nearest = np.argmin(np.abs(stops[:, None] - along), axis=0)
    return begin + sense * divided(stops, counts), places[nearest]


def _component(found: MotionTraceResult, one: Item) -> FloatArray:
    """Return a component (rows,) of a motion; angles in rad."""
    values = np.asarray(found[one.head.name])
    return np.radians(values) if one.quantity.circular and one.head.unit == "deg" else values


def _measured(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the measure of the transmission angles, if the mechanism has any."""
    return ("transmission",) * accepted(quantities_of, mechanism, "transmission")


AGREEMENT = 1e-6
"""Largest distance, relative to the size, of the real motion from the positions of the fit."""


@dataclass(frozen=True, eq=False)
class FittedDesign:
    """A design whose real motion was traced."""

    mechanism: Mechanism
    changes: dict[str, float]  # dimensions that differ from the model file: those that vary, and initial coordinates
    design: FloatArray  # (dimensions,)
    inputs: FloatArray  # (targets,) rad, or length in the normal frame
    motion: FitMotion
    error: float  # sum of squares on the real motion, with its constant


class DesignChecker:
    """Makes models of designs, and checks their conditions on these models."""

    def __init__(self, quantities: DesignQuantities) -> None:
        self.quantities, self.family = quantities, quantities.family

    def models(self, design: FloatArray) -> Iterator[tuple[dict[str, float], Mechanism]]:
        """Yield the changes of a design (dimensions,) and its mechanism, then those with other initial coordinates."""
        own = dict(zip(self.family.names, (design + 0.0).tolist(), strict=True))  # no -0.0
        for changes in (own, own | self._coordinates(design)):
            with suppress(GimError):
                yield changes, self._written(changes)

    def _written(self, changes: dict[str, float]) -> Mechanism:
        """Return the mechanism of the text that a fitted file has; of a model without a file, that with the changes."""
        nominal = self.family.mechanism
        if nominal.path is None:
            return _as_written(nominal).with_(changes)
        read = read_text(written_with(nominal, changes), nominal.written.source.folder)
        read = next(one.mechanism for one in read.machines if one.mechanism.nodes == nominal.nodes)
        read = replace(read, name=nominal.name, files=nominal.files, path=nominal.path)
        return read if nominal.complete is None else nominal.complete(read)

    def quantities_of(self, mechanism: Mechanism) -> tuple[bool, float]:
        """Return whether a mechanism satisfies all conditions, and its goal, if there is one."""
        given = self.quantities
        family = Family(mechanism, self.family.names)
        own = DesignQuantities(family, given.texts, given.goal.text if given.goal else "")
        held = bool(own.hold(family.nominal[None])[0])
        return held, float(own.numbers(own.goals, family.nominal[None])[0, 0]) if given.goal else math.nan

    def _coordinates(self, design: FloatArray) -> dict[str, float]:
        """Return the initial coordinates of moving nodes, and `at` of points, at the start of the law.

        Only those that are plain numbers in the file and do not vary.
        """
        mechanism, written = self.family.mechanism, self.family.mechanism.written
        moving = [n for k, n in enumerate(mechanism.nodes) if k not in mechanism.members[FRAME].nodes]
        moving = [name for name in moving if name not in written.model.open.parts]
        drawn = [p.name for p in mechanism.points if p.member != FRAME and written.model.points[p.name].at is not None]
        parts = [item for name in (*moving, *drawn) for item in position_items(mechanism, name)]
        if not parts or self.family.linked:
            return {}
        quantity = MotionQuantity(self.family, parts)
        values = quantity.values(design[None], mechanism.start_inputs[None, list(mechanism.drivers)])[0, 0]
        named = {one.head.name: float(v) for one, v in zip(parts, values, strict=True)}
        return {
            name: value for name, value in named.items()
            if math.isfinite(value) and name not in self.family.names and not written.dimension(name).formula
        }  # fmt: skip


def _as_written(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism in the initial configuration that its model gives: a fitted file has no other one."""
    from gimcli.library.sides import compiled  # imported late: it lists configurations

    plain = compiled(mechanism, mechanism.written.model)
    return plain if mechanism.complete is None else mechanism.complete(plain)


class GoalChecker(DesignChecker):
    """Checks designs on their real motion over the law, and their goals."""

    def checked(self, trial: Trials) -> FittedDesign | None:
        """Return a fitted design; None if it does not move over the whole law with its goal under the conditions."""
        design, goal = trial.designs[0], float(trial.error[0])
        for changes, mechanism in self.models(design):
            with suppress(GimError):
                motion = law_motion(mechanism)
                held, found = self.quantities_of(mechanism)
                if motion.trace.complete and held and abs(found - goal) <= AGREEMENT * (1.0 + abs(goal)):
                    return FittedDesign(mechanism, changes, design, np.empty(0), motion, found)
        return None


class TargetChecker(DesignChecker):
    """Checks designs on their real motion through the targets."""

    def __init__(self, problem: FitProblem, task: FittedTask, quantities: DesignQuantities) -> None:
        super().__init__(quantities)
        self.problem, self.task = problem, task
        self.refused: Counter[str] = Counter()

    def checked(self, trial: Trials) -> FittedDesign | None:
        """Return a fitted design; None if its motion does not pass the targets in order on one branch."""
        inputs = self.problem.inputs(trial.designs, trial.own)
        actual = self.problem.quantity.inputs(trial.designs, inputs)[0]
        reason = "violate a limit of the model file"
        expected = self.problem.quantity.values(trial.designs, inputs)[0]
        for changes, mechanism in self.models(trial.designs[0]):
            with suppress(GimError):
                motion = fit_motion(mechanism, self.task, actual)
                reason = self._reason(trial, inputs, mechanism, motion, expected)
                if not reason:
                    residual = self.task.targets.residuals(motion.values)
                    error = float(np.sum(residual**2)) + self.task.targets.constant
                    return FittedDesign(mechanism, changes, trial.designs[0], actual, motion, error)
        self.refused[reason] += 1
        return None

    def _reason(
        self, trial: Trials, inputs: FloatArray, mechanism: Mechanism, motion: FitMotion, expected: FloatArray
    ) -> str:
        """Return why a design is not feasible; "" if it is."""
        if trial.sense[0] and not self.task.targets.ordered(inputs, trial.sense).all():
            return "pass the targets in another order"
        if not motion.trace.complete:
            return "do not move over the whole law"
        if not self._agree(motion.values, expected):
            return "pass the targets on another branch than that of the model file"
        return "violate a condition" if self.quantities.texts and not self.quantities_of(mechanism)[0] else ""

    def _agree(self, values: FloatArray, expected: FloatArray) -> bool:
        """Return whether the real motion is on the branch of the fit."""
        targets, size = self.task.targets, self.family.mechanism.size * self.family.mechanism.scale
        turns = np.rint((values - expected) / (2.0 * math.pi)) * 2.0 * math.pi
        distance = np.abs(values - expected - np.where(targets.circular > 0.0, turns, 0.0))
        return bool(np.all(distance <= AGREEMENT * np.where(targets.circular > 0.0, 1.0, size)))
