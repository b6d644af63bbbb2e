"""Bounds for the travels of slides that follow from the lengths alone.

A combination l of the loops with l . U_q = 1 that eliminates all other slides gives |s_q| <= |l . C0| + Σ |l . C_c|
for all angles. For a rail on the frame real and imaginary parts can be combined separately, so that one loop bounds two
slides on different rails of the frame. There is no bound if rails can become parallel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.assemblies.loops import GROUND, Coefficients
from gimcli.mechanism import ComplexArray, FloatArray


@dataclass(frozen=True)
class ReachConstants:
    """Tolerances of the elimination."""

    leak: float = 1e-9  # largest remaining coefficient of an eliminated slide; its effect is included
    margin: float = 1e-6  # relative margin of a bound, greater than the effects of leaks and rounding


CONSTANTS = ReachConstants()


def proved_reach(loops: Coefficients) -> FloatArray:
    """Return a bound of |s| for every slide (q,); infinite if none is known."""
    q = loops.U.shape[1]
    pairs = [_bound(loops, slide) for slide in range(q)]
    bound, leak = np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs]).reshape(q, q)
    with np.errstate(invalid="ignore"):
        leaks = np.where(leak > 0.0, leak * bound, 0.0).sum(axis=1)
    sure = np.isfinite(bound) & (leaks <= 0.5 * CONSTANTS.margin * bound) & (leak.sum(axis=1) < CONSTANTS.margin)
    size = np.abs(loops.C0).sum() + np.abs(loops.C).sum()
    floor = CONSTANTS.margin * size / np.maximum(np.abs(loops.U).max(axis=0, initial=0.0), np.finfo(float).tiny)
    return np.asarray(np.where(sure, bound * (1.0 + CONSTANTS.margin) + floor, np.inf))


def _bound(loops: Coefficients, slide: int) -> tuple[float, FloatArray]:
    """Return the bound of one slide, and the remaining coefficients of the other slides in its combination."""
    q = loops.U.shape[1]
    combination = _combination(loops, slide)
    through = combination @ loops.U
    leak = np.where(loops.rail == GROUND, np.abs(through.real), np.abs(through))
    if loops.rail[slide] != GROUND:
        leak = np.abs(through)
    own = abs(through[slide].real if loops.rail[slide] == GROUND else through[slide])
    leak[slide] = 0.0
    size = np.abs(combination) @ np.abs(loops.U)
    if not own > 0.5 or np.any(leak > CONSTANTS.leak * np.maximum(size, 1.0)):
        return np.inf, np.zeros(q)
    return float(np.abs(combination @ loops.C0) + np.abs(combination @ loops.C).sum()) / own, leak / own


def _combination(loops: Coefficients, slide: int) -> ComplexArray:
    """Return l (L,) with l . U_slide = 1 and 0 for the others, in the least-squares sense.

    For a rail on the frame only the real part of l . f is used.
    """
    if loops.rail[slide] != GROUND:
        return np.asarray(np.linalg.pinv(loops.U)[slide])
    count = len(loops.C0)
    columns, target = [], []
    for other in range(loops.U.shape[1]):
        turns = (1.0,) if loops.rail[other] == GROUND else (1.0, 1j)
        for turn in turns:
            column = loops.U[:, other] * turn
            columns.append(np.concatenate([column.real, -column.imag]))
            target.append(1.0 if other == slide else 0.0)
    y = np.linalg.pinv(np.array(columns)) @ np.array(target)
    return np.asarray(y[:count] + 1j * y[count:])
