"""The real motion of a fitted mechanism: traced over its law, through the inputs of all targets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from gimcli.errors import UsageError
from gimcli.fitting.targets import TURN, FitRange
from gimcli.library.fit_targets import FittedTask, input_range
from gimcli.library.trace import MotionTraceResult, trace
from gimcli.mechanism import FloatArray, IntArray, Mechanism
from gimcli.quantities.kinds import quantities_of
from gimcli.quantities.quantity import Item

ROWS = 360
"""Approximate number of rows of the motion."""

TOGETHER = 1e-9
"""Inputs at a smaller distance are one row [rad, or length in the normal frame]."""


@dataclass(frozen=True, eq=False)
class RowsLaw:
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

    def stops(self) -> FloatArray:
        """Return an empty array: the input always moves on."""
        return np.empty(0)


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
    actuator = replace(mechanism.actuators[0], law=RowsLaw(rows))
    own = replace(mechanism, actuators=(actuator,))
    found = cast(MotionTraceResult, trace(own, len(rows) - 1, measure=_measured(mechanism)))
    values = [_component(found, one)[places] for one in task.components]
    return FitMotion(found, places, np.stack(values, axis=-1))


def law_motion(mechanism: Mechanism) -> FitMotion:
    """Trace a mechanism over its law."""
    found = cast(MotionTraceResult, trace(mechanism, ROWS, measure=_measured(mechanism)))
    return FitMotion(found, np.empty(0, dtype=np.int64), np.empty((0, 0)))


def _rows(mechanism: Mechanism, limits: FitRange, inputs: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the inputs of the rows, which include those of the targets, and the rows of the targets."""
    first, last = (float(v) for v in mechanism.actuators[0].law(np.array([0.0, 1.0])))
    sense = -1.0 if last < first else 1.0
    begin, span = (
        (first, TURN) if limits.turning else (limits.low if sense > 0.0 else limits.high, limits.high - limits.low)
    )
    along = (inputs - begin) * sense
    along = along % TURN if limits.turning else np.clip(along, 0.0, span)
    stops = np.unique(np.concatenate(([0.0, span], along)))
    stops = stops[np.concatenate(([True], np.diff(stops) > TOGETHER))]
    counts = np.maximum(1, np.ceil(np.diff(stops) / span * ROWS).astype(int))
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(stops, stops[1:], counts, strict=False)]
    places = np.concatenate(([0], np.cumsum(counts)))
    nearest = np.argmin(np.abs(stops[:, None] - along), axis=0)
    return begin + sense * np.append(np.concatenate(parts), stops[-1]), places[nearest]


def column_of(found: MotionTraceResult, one: Item) -> FloatArray:
    """Return a quantity (rows,) of a motion in the file's unit."""
    return np.asarray(found[one.head.name])


def _component(found: MotionTraceResult, one: Item) -> FloatArray:
    """Return a component (rows,) of a motion; angles in rad."""
    values = column_of(found, one)
    return np.radians(values) if one.quantity.circular and one.head.unit == "deg" else values


def _measured(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the measure of the transmission angles, if the mechanism has any."""
    try:
        quantities_of(mechanism, "transmission")
    except UsageError:
        return ()
    return ("transmission",)
