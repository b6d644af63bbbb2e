"""Callbacks that report the progress of long computations."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Progress = Callable[[int, int], None]
"""Called with the number of rows done and the total number of rows."""

Phases = Callable[[str], Progress]
"""Called with the name of each phase of a computation; returns the callback for the progress of that phase."""

Notify = Callable[[str], None]
"""Called with a one-line notice for the user."""


class WorkLimit:
    """The bound on a computation, in units of work and in seconds; `reached` is whether it ended there."""

    def __init__(
        self, most: float = math.inf, seconds: float | None = None, outer: WorkLimit | None = None
    ) -> None:  # fmt: skip
        self.most, self.outer, self.spent, self.reached = most, outer, 0, False
        self.end = math.inf if seconds is None else time.monotonic() + seconds

    def spend(self, work: int = 0) -> bool:
        """Count work; return whether the computation shall end now."""
        self.spent += work
        above = self.outer is not None and self.outer.spend(work)
        self.reached = self.reached or above or self.spent > self.most or time.monotonic() > self.end
        return self.reached


WORK = 100_000
"""Most positions of curves that a search evaluates; those of the shipped models need up to 12 000."""

_LIMIT: ContextVar[WorkLimit | None] = ContextVar("limit", default=None)


@contextmanager
def limited(most: float = math.inf, seconds: float | None = None) -> Iterator[WorkLimit]:
    """Bound the work of the searches within, which count it by `spend`; that of an outer call holds too."""
    limit = WorkLimit(most, seconds, _LIMIT.get())
    token = _LIMIT.set(limit)
    try:
        yield limit
    finally:
        _LIMIT.reset(token)


def spend(work: int = 0) -> bool:
    """Count work, in positions of a curve; return whether the computation shall end now, with what was found."""
    limit = _LIMIT.get()
    return limit is not None and limit.spend(work)


def no_progress(done: int, of: int) -> None:
    """Report nothing."""


def no_phases(phase: str) -> Progress:
    """Report nothing of any phase."""
    return no_progress
