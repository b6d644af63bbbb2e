"""Laws of motion of an input as functions of the normalised time 0..1, with derivatives up to the third.

A profile is a function s(t) with s(0) = 0 and s(1) = 1; a law is start + (end - start) s(t). Values are in rad or
lengths of the normal frame. Source: Norton, Cam Design and Manufacturing Handbook, 2002, chapter 2 (3-4-5 polynomial,
cycloidal, harmonic).

In the file, a law starts at `from`, or at the initial value of its input. It ends at `to`, or after the increment
`by`, `turns` or rate x duration. These values are in the file's units; they may be recorded numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.numbers import nominal
from gimcli.input_laws import FloatArray, InputLaw, SummedLaw
from gimcli.model.schema import Actuator, Law, Model
from gimcli.model.units import TURN
from gimcli.numerics.shape_preserving import ShapePreservingCubic

CUBIC = (0.0, 0.0, 3.0, -2.0)
QUINTIC = (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)

REAL = 1e-6
"""Relative imaginary part below which a root may be a double real root; a false root costs one evaluation only."""

TINY = float(np.finfo(float).tiny)
NEGLIGIBLE = 1e-60
"""Coefficient relative to the largest that is treated as 0: its roots are far from 0..1, its reciprocal overflows."""


@dataclass(frozen=True)
class PolynomialLaw(InputLaw):
    """The polynomial c[0] + c[1] t + c[2] t^2 + ..."""

    coefficients: tuple[float, ...]

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative."""
        if order == 0 and self.coefficients == (0.0, 1.0):
            return np.asarray(time)
        falling = np.asarray(self.coefficients[::-1], dtype=float)
        return np.asarray(np.polyval(np.polyder(falling, order) if order else falling, time))

    def stops(self) -> FloatArray:
        """Return the times at which the law may reverse: the real roots of its derivative."""
        if len(self.coefficients) < 3:
            return np.empty(0)
        falling = np.asarray(self.coefficients[::-1], dtype=float)
        slope = np.polyder(falling / max(np.max(np.abs(falling)), TINY))
        slope[np.abs(slope) < NEGLIGIBLE] = 0.0
        found = np.roots(np.trim_zeros(slope, "f"))
        real = found.real[np.abs(found.imag) <= REAL * np.maximum(1.0, np.abs(found))]
        return np.unique(real[(real > 0.0) & (real < 1.0)])


@dataclass(frozen=True)
class Wave(InputLaw):
    """The profile t - sin(2 pi t) / (2 pi) (cycloidal) or (1 - cos(pi t)) / 2 (harmonic)."""

    cycloidal: bool

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative."""
        t = np.asarray(time, dtype=float)
        if self.cycloidal:
            w = 2.0 * np.pi
            straight = t if order == 0 else np.ones_like(t) if order == 1 else np.zeros_like(t)
            return np.asarray(straight - w ** (order - 1) * np.sin(w * t + order * np.pi / 2.0))
        swing = np.pi**order * np.cos(np.pi * t + order * np.pi / 2.0) / 2.0
        return np.asarray((0.5 if order == 0 else 0.0) - swing)


class TableLaw(InputLaw):
    """Shape-preserving cubic interpolation of (time, value) pairs, without overshoot between them."""

    def __init__(self, time: Sequence[float], value: Sequence[float]) -> None:
        self._curve = ShapePreservingCubic((np.asarray(time) - time[0]) / (time[-1] - time[0]), value)

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative."""
        return self._curve(time, order)

    def stops(self) -> FloatArray:
        """Return the inner times of the table: the interpolation is monotonic between two of them."""
        return self._curve.at[1:-1]


PROFILES: dict[str, InputLaw] = {
    "uniform": PolynomialLaw((0.0, 1.0)),
    "cubic": PolynomialLaw(CUBIC),
    "quintic": PolynomialLaw(QUINTIC),
    "cycloidal": Wave(True),
    "harmonic": Wave(False),
}


@dataclass(frozen=True)
class RunLaw(InputLaw):
    """The law start + (end - start) profile(t); both end values are exact."""

    start: float
    end: float
    profile: InputLaw

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative by the normalised time."""
        t = np.asarray(time, dtype=float)
        run = np.atleast_1d((self.end - self.start) * self.profile(t, order))
        if order == 0:  # profiles begin with 0 exactly
            run += self.start
            run[np.atleast_1d(t == 1.0)] = self.end
        return run.reshape(t.shape)

    def stops(self) -> FloatArray:
        """Return the times at which the profile may reverse."""
        return self.profile.stops()


def scaled(law: InputLaw, factor: float) -> InputLaw:
    """Return a law times a factor; a law with two ends keeps them, as they may vary."""
    if isinstance(law, RunLaw):
        return replace(law, start=factor * law.start, end=factor * law.end)
    return SummedLaw(((factor, law),))


class Sampled(ShapePreservingCubic):
    """Shape-preserving cubic interpolation of samples; constant before the first sample and after the last."""

    def __call__(self, at: FloatArray, order: int = 0) -> FloatArray:
        """Return the interpolated value at each abscissa, or its derivative between the first and the last."""
        return super().__call__(np.clip(at, self.at[0], self.at[-1]), order)

    def slope(self, at: FloatArray) -> FloatArray:
        """Return the derivative of the interpolated value; 0 before the first sample and after the last."""
        return np.where((self.at[0] < at) & (at < self.at[-1]), self(at, 1), 0.0)


# -- ends and durations -------------------------------------------------------------------------


class RunTime(NamedTuple):
    """The duration that the rate of an input gives [s]."""

    actuator: str
    seconds: Any
    text: str  # the keys that it follows from


def ended(law: Law) -> bool:
    """Return whether a law has an end, so that a polynomial in it goes from 0 to 1."""
    return law.rate is not None or law.end is not None


def increment(law: Law, turn: float, duration: Any | None) -> Any | None:
    """Return the increment of a law without `to`; None if the law has no end.

    Args:
        law: the law.
        turn: one turn in the file's unit of angle; 0 for a linear input.
        duration: duration of the motion [s]; None if it follows from the rate itself.
    """
    if law.by is not None:
        return law.by
    if law.turns is not None:
        return turn * law.turns * _sense(law)
    if law.rate is not None:
        return turn * _sense(law) if duration is None else law.rate * duration
    return None


def run_times(model: Model, initial: Callable[[str, Actuator], Any | None], timed: bool) -> list[RunTime]:
    """Return the durations that the rates of a model give.

    Args:
        model: the model.
        initial: function that returns the initial value of an actuator (the file's unit), or None.
        timed: whether `duration` or a table gives the duration.

    Returns:
        One for each rate with `to`, `by` or `turns`; if there is none, and nothing else gives the duration, one turn
        for each rotary input with a rate.
    """
    turn = TURN[model.units.angle]
    laws = ((name, a, a.law, a.law.rate) for name, a in model.actuators.items() if a.law is not None)
    rated = [(name, a, law, rate) for name, a, law, rate in laws if rate is not None and nominal(rate)]
    found = list[RunTime]()
    for name, actuator, law, rate in rated:
        change = increment(law, turn * actuator.rotary, 0.0)
        if law.to is not None:
            start = initial(name, actuator) if law.from_ is None else law.from_
            change = None if start is None else law.to - start
        if law.end is not None and change is not None:
            change = -change if nominal(change) < 0.0 < nominal(rate) else change  # a positive rate is a speed
            found.append(RunTime(name, change / rate, f"`{law.end}` at this `rate`"))
    if found or timed:
        return found
    return [
        RunTime(name, turn * _sense(law) / rate, "one turn") for name, actuator, law, rate in rated if actuator.rotary
    ]


def _sense(law: Law) -> float:
    """Return 1, or -1 for a law that runs clockwise."""
    return -1.0 if law.rate is not None and nominal(law.rate) < 0.0 else 1.0
