"""Choice between interpreted and compiled kernels, from the estimated work."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from gimcli.kernels import jit
from gimcli.positions.newton import Run
from gimcli.structure.steps import Plan

WORTH = 0.5
"""Seconds of interpreted work above which loading compiled kernels saves time."""

COMPILING = 8.0
"""Seconds of interpreted work above which compiling kernels saves time."""

COMPILES = "compiling the solver for this machine, once ..."
NOT_KEPT = "not cached: no cache folder is private to you; set XDG_CACHE_HOME to one (chmod 700)"


def plain(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel unchanged: it runs interpreted."""
    return kernel


def plan_work(plan: Plan, rows: int) -> float:
    """Estimate the seconds that the rows of a motion take interpreted."""
    work = rows * 1e-7 * len(plan.steps)
    for group in plan.coupled:
        n, m = 2 * len(group.base), sum(e.rows for e in group.equations)
        work += rows * (1e-4 + 1.2e-5 * m * n + 2e-7 * n**3)
    return work


def gim_work(moves: int, rows: int) -> float:
    """Estimate the seconds that the sweeps of all rows take interpreted."""
    return rows * 20 * moves * 5e-6


def choose(mode: str, work: float, notify: Callable[[str], None] | None = None, kernels: Sequence[str] = ()) -> Run:
    """Return the function that makes a kernel runnable: unchanged or compiled.

    mode: auto, on or off. work: estimated seconds interpreted. notify: called before a compilation. kernels: names of
    the kernels that will be used.
    """
    if mode == "off" or (mode == "auto" and work < WORTH):
        return plain
    if mode == "on" and notify is None:
        return jit.compiled
    cached = jit.is_cached(*kernels)
    if mode == "auto" and not cached and work < COMPILING:
        return plain
    if notify is not None and not cached:
        notify(COMPILES if jit.cache_folder() else f"{COMPILES} {NOT_KEPT}")
    return jit.compiled


def with_earlier(work: float, kernels: tuple[str, ...]) -> float:
    """Return the work of this job and of the earlier ones in this process that use the same kernels.

    A program may solve many small motions; their rows have the same bits, interpreted or compiled.
    """
    _done[kernels] = _done.get(kernels, 0.0) + work
    return _done[kernels]


_done: dict[tuple[str, ...], float] = {}
