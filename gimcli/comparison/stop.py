"""When the textbook iteration ends."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Stop:
    """No unknown is corrected by more than `tolerance`: angles in rad, lengths relative to `length`."""

    tolerance: float
    length: float  # normal frame
    iterations: int  # at the most, for one position
