"""Conditional expressions: over arrays when interpreted, over single numbers when compiled.

They allow one formula for both forms: numpy evaluates it for all rows of a block, and the compiled code evaluates it
row by row in a loop that the compiler vectorises.
"""

from __future__ import annotations

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


larger = scalar_form(_larger)(np.fmax)
"""The larger of two values; if one is NaN, the other."""

smaller = scalar_form(_smaller)(np.fmin)
"""The smaller of two values; if one is NaN, the other."""

unless = scalar_form(_unless)(np.logical_not)
"""1.0 (or True) where the condition is false, else 0.0 (or False)."""

mark = scalar_form(_mark)(np.logical_or)
"""`marks`, with 1.0 (or True) where the condition is true: of a condition and marks."""

where = scalar_form(_either)(np.where)
"""`yes` where the condition is true, else `no`: of a condition, yes and no."""
