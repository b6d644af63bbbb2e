"""Choose between two values: over arrays as they stand, between two numbers when compiled.

With it one formula serves both: numpy runs it over all rows of a block, the compiler over one row
in a loop that it vectorises.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.kernels.jit import scalar_form


def _either(condition: bool, yes: float, no: float) -> float:
    return yes if condition else no


def _larger(one: float, other: float) -> float:
    return one if one > other else other


def _unless(condition: bool) -> float:
    return 0.0 if condition else 1.0


def _mark(condition: bool, marks: float) -> float:
    return 1.0 if condition else marks


@scalar_form(_larger)
def larger(one: Any, other: Any) -> Any:
    """Return the larger of two values, the other where one is a NaN."""
    return np.fmax(one, other)


@scalar_form(_unless)
def unless(condition: Any) -> Any:
    """Return marks where the condition does not hold: true or 1.0, else false or 0.0."""
    return np.logical_not(condition)


@scalar_form(_mark)
def mark(condition: Any, marks: Any) -> Any:
    """Return marks, with those where the condition holds."""
    return np.logical_or(condition, marks)


@scalar_form(_either)
def where(condition: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where the condition holds, else `no`."""
    return np.where(condition, yes, no)
