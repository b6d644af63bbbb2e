"""Where an input has a given value along the motions of many designs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gimcli.mechanism import FloatArray, IntArray

EXACT = 1e-9
"""Share of a step within which a row has the value."""


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


def moved_rows(values: FloatArray, crossing: InputCrossing) -> FloatArray:
    """Return values (designs, ..., rows) of which the rows after the steps are moved to the crossing, linearly."""
    found = values.copy()
    designs = crossing.between
    step, share = crossing.step[designs], crossing.share[designs]
    before, after = values[designs, ..., step], values[designs, ..., step + 1]
    found[designs, ..., step + 1] = before + share.reshape(-1, *[1] * (before.ndim - 1)) * (after - before)
    return found
