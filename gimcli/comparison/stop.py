"""Stopping test of the Newton-Raphson iterations in textbook coordinates."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Stop:
    """Stop when no correction exceeds `tolerance`: angles in rad, lengths relative to `length`."""

    tolerance: float
    length: float  # normal frame
    iterations: int  # maximum number for one position
