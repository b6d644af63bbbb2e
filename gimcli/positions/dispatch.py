"""Plain or compiled: the choice is made from the amount of work."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from gimcli.kernels import jit
from gimcli.positions.newton import Run
from gimcli.structure.steps import Plan

WORTH = 1.5
"""Seconds of plain work above which loading compiled kernels pays."""

COMPILING = 20.0
"""Seconds of plain work above which compiling them pays."""

COMPILES = "compiling the solver for this machine, once ..."
NOT_KEPT = "not kept: no cache folder that you alone may write to; set XDG_CACHE_HOME to one (chmod 700)"


def plain(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Run a kernel as it stands."""
    return kernel


def plan_work(plan: Plan, rows: int) -> float:
    """Estimate the seconds that the rows of a motion take without compiling."""
    work = rows * 1e-7 * len(plan.steps)
    for group in plan.coupled:
        n, m = 2 * len(group.base), sum(e.rows for e in group.equations)
        work += rows * (1e-4 + 1.2e-5 * m * n + 2e-7 * n**3)
    return work


def gim_work(moves: int, rows: int) -> float:
    """Estimate the seconds that sweeping takes without compiling."""
    return rows * 20 * moves * 5e-6


def choose(mode: str, work: float, notify: Callable[[str], None] | None = None, kernels: Sequence[str] = ()) -> Run:
    """Return how to run some kernels, by name: `mode` auto, on or off; `notify` is called before a compilation."""
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
