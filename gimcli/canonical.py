"""One form of results that rounding would decide: angles at the end of their range, and values that are equal.

Rounding differs between processors and versions of libraries; ROUNDING is far above it and far below what users ask.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

ROUNDING = 1e-9
"""Difference below which values count as equal; of angles in turns, of others relative to the greatest value."""

TURN = 2.0 * math.pi


def whole_turns(difference: Any, turn: float = TURN) -> Any:
    """Return how many turns to subtract from a difference (any shape) so that it is in (-turn/2, turn/2]."""
    return np.ceil(difference / turn - 0.5 - ROUNDING) + 0.0


def principal(angle: Any, turn: float = TURN) -> Any:
    """Return angles (any shape) in (-turn/2, turn/2]; one within rounding of an end is at the upper end."""
    return angle - turn * whole_turns(angle, turn)


def beside(angle: Any, near: Any, turn: float = TURN) -> Any:
    """Return angles (any shape) shifted by whole turns into (near - turn/2, near + turn/2]."""
    return angle - turn * whole_turns(angle - near, turn)


def phase(z: Any) -> Any:
    """Return the directions [rad] of vectors (any shape) in (-pi, pi]."""
    return principal(np.angle(z))


def filled(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values (..., rows) with the last known value in rows without one, at the start the first."""
    known = np.isfinite(values)
    last = np.maximum.accumulate(np.where(known, np.arange(values.shape[-1]), -1), axis=-1)
    return np.take_along_axis(values, np.where(last >= 0, last, np.argmax(known, axis=-1)[..., None]), axis=-1)


def counted(angle: NDArray[np.float64], turn: float = TURN, ahead: Any = 0.0) -> NDArray[np.float64]:
    """Return angles (..., rows) with full turns counted; rows without a value stay NaN.

    `ahead` (..., rows - 1) is the approximate change from each row to the next. By default it is 0: the change is then
    taken to be less than half a turn.
    """
    turns = np.cumsum(np.round((ahead - np.diff(filled(angle))) / turn), axis=-1)
    return angle + turn * np.concatenate([np.zeros_like(angle[..., :1]), turns], axis=-1)


def ranks(value: NDArray[np.float64], same: float) -> NDArray[np.int64]:
    """Return the ranks of values (count,); one that is at most `same` above the one below it has the same rank."""
    order = np.argsort(value, kind="stable")
    found = np.zeros(len(value), dtype=np.int64)
    found[order[1:]] = np.cumsum(np.diff(value[order]) > same)
    return found


def first_least(value: NDArray[np.float64], same: float) -> int:
    """Return the index of the least value (count,), the first of those that are equal up to `same`."""
    return int(ranks(value, same).argmin())


def first_greatest(value: NDArray[np.float64]) -> int:
    """Return the index of the greatest finite value (count,), the first of those that are equal; 0 if there is none."""
    known = np.where(np.isfinite(value), value, -np.inf)
    most = float(known.max())
    return int(np.argmax(known >= most - ROUNDING * abs(most)))
