"""Callbacks that report the progress of long computations."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

Progress = Callable[[int, int], None]
"""Called with the number of rows done and the total number of rows."""

Phases = Callable[[str], Progress]
"""Called with the name of each phase of a computation; returns the callback for the progress of that phase."""

Notify = Callable[[str], None]
"""Called with a one-line notice for the user."""


def deadline(seconds: float | None) -> Callable[[], bool]:
    """Return a function that says whether `seconds` have passed since this call; None: they never pass."""
    end = math.inf if seconds is None else time.monotonic() + seconds
    return lambda: time.monotonic() > end


def never() -> bool:
    """Return that no deadline has passed."""
    return False


def no_progress(done: int, of: int) -> None:
    """Report nothing."""


def no_phases(phase: str) -> Progress:
    """Report nothing of any phase."""
    return no_progress
