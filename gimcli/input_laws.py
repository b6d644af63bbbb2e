"""Laws of inputs: functions of the normalised time 0..1 (rad, or length in the normal frame)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SAMPLES = 1025
"""Times between which the derivative of a sum of laws is searched for changes of its sign."""


class InputLaw(Protocol):
    """The input of an actuator as a function of the normalised time 0..1 (rad, or length in the normal frame)."""

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value (`order` 0) or its derivative of that order with respect to the normalised time."""

    def stops(self) -> FloatArray:
        """Return the times at which the law may stop or reverse, by default none; it is monotonic between them."""
        return np.empty(0)


@dataclass(frozen=True)
class ConstantLaw(InputLaw):
    """The law of a constant input; gauges, which have no law of their own, also use it."""

    value: float = 0.0

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value, or zeros."""
        return np.full(np.shape(time), 0.0 if order else self.value)


@dataclass(frozen=True)
class SummedLaw(InputLaw):
    """The law of an input that follows others, or of one in another unit: phase + sum of ratio times law."""

    terms: tuple[tuple[float, InputLaw], ...]
    phase: float = 0.0

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative by the normalised time."""
        t = np.asarray(time, dtype=float)
        total = np.full(t.shape, 0.0 if order else float(self.phase))
        for ratio, law in self.terms:
            total = total + ratio * law(t, order)
        return np.asarray(total)

    def stops(self) -> FloatArray:
        """Return the times at which the law may reverse: those of its terms, and roots of its derivative between."""
        found = [law.stops() for _, law in self.terms]
        if len(self.terms) > 1:
            from gimcli.numerics.along import sign_changes

            grid = np.unique(np.concatenate([np.linspace(0.0, 1.0, SAMPLES), *found]))
            found.append(sign_changes(lambda time: self(time, 1), grid))
        return np.unique(np.concatenate([np.empty(0), *found]))


@dataclass(frozen=True)
class LaterLaw:
    """A law from the normalised time `first` on, at which its own time is 0."""

    law: InputLaw
    first: float

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative by the time of this law."""
        left = 1.0 - self.first
        return np.asarray(left**order * self.law(np.minimum(self.first + left * np.asarray(time), 1.0), order))

    def stops(self) -> FloatArray:
        """Return the times at which the law may reverse."""
        found = self.law.stops()
        return np.asarray((found[found > self.first] - self.first) / (1.0 - self.first))
