"""Where an input has a given value along the motions of many designs."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from gimcli.mechanism import FloatArray, IntArray

EXACT = 1e-9
"""Share of a step within which a row has the value."""

HALVINGS = 52
"""Number of times that an interval of time is halved: as many as a number has binary digits."""


class InputCrossing(NamedTuple):
    """The step of each design in which an input first reaches a value, and the share of the step before it."""

    step: IntArray  # (designs,), -1: the value is not reached
    share: FloatArray  # (designs,) 0..1

    @property
    def between(self) -> IntArray:
        """The designs in which the value lies between two rows."""
        inside = (self.step >= 0) & (np.minimum(self.share, 1.0 - self.share) > EXACT)
        return np.flatnonzero(inside)

    @property
    def row(self) -> IntArray:
        """The row that has the value, if the row after the step is moved there; -1 if there is none."""
        return np.where(self.step < 0, -1, self.step + (self.share > EXACT))


def first_crossing(values: FloatArray, value: float) -> InputCrossing:
    """Return where values (designs, rows) first reach a value."""
    first, second = values[:, :-1] - value, values[:, 1:] - value
    reach = EXACT * np.abs(second - first)
    inside = (np.minimum(first, second) <= reach) & (np.maximum(first, second) >= -reach) & (first != second)
    step = np.where(inside.any(axis=1), inside.argmax(axis=1), -1)
    one, two = (np.take_along_axis(part, np.maximum(step, 0)[:, None], axis=1)[:, 0] for part in (first, second))
    with np.errstate(all="ignore"):
        return InputCrossing(step, np.clip(np.where(one == two, 0.0, one / (one - two)), 0.0, 1.0))


def times_of(
    values_at: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray, value: float
) -> FloatArray:
    """Return the times (designs,) between two rows at which an input has a value, by bisection.

    `values_at` returns the input of each design at a time of its own.
    """
    start = values_at(low) - value
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = (values_at(middle) - value) * start > 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return 0.5 * (low + high)
