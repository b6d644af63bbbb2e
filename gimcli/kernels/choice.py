"""Conditional expressions: over arrays when interpreted, over single numbers when compiled.

They allow one formula for both forms: numpy evaluates it for all rows of a block, and the compiled code evaluates it
row by row in a loop that the compiler vectorises.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.kernels.jit import scalar_form


def _either(condition: bool, yes: float, no: float) -> float:
    return yes if condition else no


def _larger(one: float, other: float) -> float:
    return one if one > other else other


def _smaller(one: float, other: float) -> float:
    return one if one < other else other


def _unless(condition: bool) -> float:
    return 0.0 if condition else 1.0


def _mark(condition: bool, marks: float) -> float:
    return 1.0 if condition else marks


@scalar_form(_larger)
def larger(one: Any, other: Any) -> Any:
    """Return the larger of two values; if one is NaN, the other."""
    return np.fmax(one, other)


@scalar_form(_smaller)
def smaller(one: Any, other: Any) -> Any:
    """Return the smaller of two values; if one is NaN, the other."""
    return np.fmin(one, other)


@scalar_form(_unless)
def unless(condition: Any) -> Any:
    """Return 1.0 (or True) where the condition is false, else 0.0 (or False)."""
    return np.logical_not(condition)


@scalar_form(_mark)
def mark(condition: Any, marks: Any) -> Any:
    """Return `marks`, with 1.0 (or True) where the condition is true."""
    return np.logical_or(condition, marks)


@scalar_form(_either)
def where(condition: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where the condition is true, else `no`."""
    return np.where(condition, yes, no)
