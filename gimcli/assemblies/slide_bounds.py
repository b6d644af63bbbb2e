"""How far slides can travel at all: a bound that follows from the lengths alone.

A combination l of the loops with l . U_q = 1 that kills all other slides leaves |s_q| <= |l . C0| + Σ |l . C_c|,
whatever the angles. For a rail on the frame the combination may be of the real and imaginary parts apart, so that
two slides on different rails of the frame are bounded by one loop. No bound exists where rails can be parallel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.assemblies.cosine_rows import GROUND
from gimcli.assemblies.krawczyk import Coefficients
from gimcli.mechanism import ComplexArray, FloatArray


@dataclass(frozen=True)
class ReachConstants:
    """When a combination counts as killing the other slides."""

    leak: float = 1e-9  # of a slide's coefficient; what leaks is accounted for
    margin: float = 1e-6  # of a bound: more than leaks and rounding amount to


CONSTANTS = ReachConstants()


def proved_reach(loops: Coefficients) -> FloatArray:
    """Return a bound of |s| for every slide (q,); infinite where none is known."""
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
    """Return the bound of one slide, and how much of each other slide its combination lets through."""
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
    """Return l (L,) with least-squares l . U_slide = 1 and nothing of the others.

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
