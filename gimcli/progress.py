"""Who hears how far a long work has come, and what it has to say on the way."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[int, int], None]
"""It hears how much is done, and of how much."""

Phases = Callable[[str], Progress]
"""It hears the name of each phase of the work, and returns what is told of the rows done and of all rows."""

Tell = Callable[[str], None]
"""It hears a line for the user's eyes."""


def unheard(done: int, of: int) -> None:
    """Tell nobody how far the work has come."""


def silent(phase: str) -> Progress:
    """Tell nobody how the work goes on."""
    return unheard
