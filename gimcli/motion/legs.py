"""The legs of the laws: intervals between two reversals, in which a motion follows its curve in one sense.

Inputs on a straight line (a single input always is) are followed by the parameter of the line instead of the time: the
start, the dwells and the stops of a law then have no influence. Beyond the end of a leg the inputs are extrapolated,
so that a singular position at the end is recognised; the next leg returns along the same curve. Inputs that are not on
a line are followed by the time, in one leg.

The *coordinate* s = sense * parameter of a leg increases with the time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gimcli.mechanism import FloatArray, IntArray, Mechanism
from gimcli.positions.inputs import InputLine, divided, input_line, law_inputs, law_times, line_through, pace, scales
from gimcli.structure.derived import derived

DWELL = 8.0 * float(np.finfo(float).eps)
"""A change of a law below this, relative to its values, is 0."""

SLOWEST = 1e-3
"""Laws with a smaller change, in turns, count as constant."""

STEPS_A_TURN = 90
"""Least number of rows solved for one turn, whatever number the user requests."""

ROUND = 1e-9
"""Relative excess of a step that is due to rounding."""


@dataclass(frozen=True)
class Leg:
    """A leg of the laws; its coordinate s = sense * parameter increases with the time.

    The parameter is that of the line, or the time; it is mirrored after the input has reversed at a limit.
    """

    mechanism: Mechanism
    line: InputLine | None
    first: float  # time 0..1 at the start
    last: float  # time at the end
    begin: float  # parameter at the start
    end: float  # parameter at the end
    mirror: float = 1.0  # parameter = mirror * parameter of the laws + shift
    shift: float = 0.0

    @property
    def sense(self) -> float:
        """1.0 if the parameter increases, -1.0 if it decreases."""
        return 1.0 if self.end >= self.begin else -1.0

    @property
    def mirrored(self) -> bool:
        """Whether the input has reversed at a limit."""
        return self.mirror != 1.0 or self.shift != 0.0

    @property
    def goal(self) -> float:
        """The coordinate at which the leg ends."""
        return self.sense * self.end

    @property
    def turn(self) -> float:
        """The change of the coordinate for one turn of the input that changes most, or a travel of 2 pi sizes."""
        if self.line is None:
            return 1.0 / max(pace(self.mechanism, law_inputs(self.mechanism)(law_times(self.mechanism))), SLOWEST)
        return 2.0 * math.pi * float(scales(self.mechanism)[self.line.main])

    def parameter(self, time: FloatArray) -> FloatArray:
        """Return the parameter (rows,) at times."""
        own = time if self.line is None else self.mechanism.actuators[self.line.main].law(time)
        return np.asarray(self.mirror * own + self.shift if self.mirrored else own)

    def places(self, time: FloatArray, values: FloatArray | None = None) -> FloatArray:
        """Return non-decreasing coordinates (rows,) at times of the leg; values: inputs (actuators, rows), if known."""
        known = values if self.line is not None and not self.mirrored else None
        own = self.parameter(time) if known is None or self.line is None else known[self.line.main]
        s = own if self.sense > 0.0 else -own
        if len(s) and (s[0] < self.sense * self.begin or s[-1] > self.goal or np.any(s[1:] < s[:-1])):
            s = np.clip(np.maximum.accumulate(s), self.sense * self.begin, self.goal)  # rounding errors
        return np.asarray(s)

    def inputs(self, s: FloatArray) -> FloatArray:
        """Return the inputs (actuators, rows) at coordinates, which may be beyond the ends of the leg."""
        q = self.sense * s
        return law_inputs(self.mechanism)(q) if self.line is None else self.line.at(q)

    def values(self, time: FloatArray) -> FloatArray:
        """Return the inputs (actuators, rows) at times of the leg."""
        return self.inputs(self.sense * self.parameter(time)) if self.mirrored else law_inputs(self.mechanism)(time)

    def time_at(self, s: float) -> float:
        """Return the first time of the leg at which it reaches a coordinate."""
        from gimcli.numerics.along import bisected

        begin, end = self.places(np.array([self.first, self.last])).tolist()
        if not begin < s <= end:
            return self.first if begin >= s else self.last
        return bisected(lambda time: self.places(np.array([time]))[0] >= s, self.first, self.last)[1]

    def reflected(self, at: float, time: float | None = None) -> Leg:
        """Return the leg mirrored at a parameter at which the input reverses; if `time` is given, from then on."""
        begin = 2.0 * at - self.begin if time is None else at
        return replace(
            self, first=self.first if time is None else time, begin=begin, end=2.0 * at - self.end,
            mirror=-self.mirror, shift=2.0 * at - self.shift,
        )  # fmt: skip


def straight(mechanism: Mechanism, begin: FloatArray, end: FloatArray) -> Leg:
    """Return the leg on which inputs (actuators,) change linearly from `begin` to `end`.

    If both are equal, the leg has length 0 and the direction of the laws.
    """
    line = line_through(mechanism, np.stack([begin, end], axis=1))
    if line is None:
        change = np.diff(law_inputs(mechanism)(np.array([0.0, 1.0])), axis=1)[:, 0]
        ahead = begin + (change if np.any(change) else scales(mechanism))
        line = line_through(mechanism, np.stack([begin, ahead], axis=1))
    assert line is not None
    return Leg(mechanism, line, 0.0, 1.0, float(begin[line.main]), float(end[line.main]))


def fine(step: float, turn: float) -> bool:
    """Return whether a step is short enough to be solved without rows in between."""
    return step * (STEPS_A_TURN / turn) <= 1.0 + ROUND


def dense(start: float, places: FloatArray, turn: float, least: int = 1) -> tuple[FloatArray, IntArray]:
    """Return a refined grid of increasing coordinates, and the indices (places,) of the given ones in it.

    Every step, from `start` on, has at least `least` parts, none longer than 1 / STEPS_A_TURN of a turn.
    """
    ends = np.concatenate([[min(start, places[0])], places])
    parts = np.maximum(np.ceil(np.diff(ends) * (STEPS_A_TURN / turn) - ROUND), least).astype(np.int64)
    return divided(ends, parts)[1:], np.cumsum(parts) - 1


@derived
def legs(mechanism: Mechanism) -> tuple[Leg, ...]:
    """Return the legs of the laws, in the order of time."""
    line = input_line(mechanism)
    if line is None:
        values = law_inputs(mechanism)(law_times(mechanism))
        still = len(values) > 0 and np.all(values == values[:, :1])
        return (straight(mechanism, values[:, 0], values[:, 0]) if still else Leg(mechanism, None, 0.0, 1.0, 0.0, 1.0),)
    law = mechanism.actuators[line.main].law
    stops = [a.law.stops() for a in mechanism.actuators]
    times = np.array(sorted({0.0, 1.0, *np.concatenate(stops).tolist()}))
    values = law(times)
    ends = _turnings(values, DWELL * float(np.max(np.abs(values), initial=0.0)))
    return tuple(Leg(mechanism, line, *times[[i, j]].tolist(), *values[[i, j]].tolist()) for i, j in pairwise(ends))


def _turnings(values: FloatArray, least: float) -> Sequence[int]:
    """Return the indices of the first and the last value, and of those at which they reverse by more than `least`."""
    found, sense, far = [0], 0.0, 0
    for k in range(1, len(values)):
        ahead = float(values[k] - values[far])
        if not sense and abs(ahead) > least:
            sense = math.copysign(1.0, ahead)
        if sense * ahead >= 0.0:
            far = k  # still the same sense; a dwell belongs to the leg before it
        elif abs(ahead) > least:
            found.append(far)
            sense, far = -sense, k
    return [*found, len(values) - 1]
