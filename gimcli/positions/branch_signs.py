"""Branch signs: for each step with two solutions, the solution on the side of the initial guess."""

from __future__ import annotations

import numpy as np

from gimcli.kernels import plan_steps as kernels
from gimcli.mechanism import FloatArray
from gimcli.positions.block import NEW, RowBlock

FLAT = 1e-9
"""If a guess is closer to the line between both sides than this, relative to the size, the sign is +1 (left)."""


def sides(guess: RowBlock, size: float) -> FloatArray:
    """Return the branch signs (branches,) of a guess, given in the first new row of a block."""
    signs, q, at = np.ones(len(guess.g)), guess.program.tables, guess.program.at
    with np.errstate(all="ignore"):
        for k, (kind, *_, branch) in enumerate(q.steps):
            if kind == kernels.ORIENT:
                kernels.carry(guess.lanes, q, at, k, NEW + 1)
            elif branch >= 0:
                measure = _drawn_line(guess, k) if kind == kernels.TILT else _drawn_node(guess, k)
                signs[branch] = -1.0 if measure < -FLAT * size else 1.0
    return signs


def _drawn_line(guess: RowBlock, k: int) -> float:
    """Set the direction of a guide (TILT) from its member; return tau, the distance along it, times a length."""
    w, q, at = guess.lanes, guess.program.tables, guess.program.at
    _, register, a, b, along, _ = q.steps[k]
    kernels.compute_vector(w, q, at, along, NEW + 1)
    ux, uy = guess.value(kernels.EX), guess.value(kernels.EY)
    norm = np.sqrt(ux * ux + uy * uy)
    guess.rx[register, NEW], guess.ry[register, NEW] = ux / norm, uy / norm
    wx, wy = guess.x[b, NEW] - guess.x[a, NEW], guess.y[b, NEW] - guess.y[a, NEW]
    return float(ux * wx + uy * wy)


def _drawn_node(guess: RowBlock, k: int) -> float:
    """Return the distance of a node to the left of the line between two centres, or ahead along the line of a locus."""
    w, q, at = guess.lanes, guess.program.tables, guess.program.at
    kind, node, first, second, _, _ = q.steps[k]
    kernels.compute_locus(w, q, at, first, kernels.C, NEW + 1)
    kernels.compute_locus(w, q, at, second, kernels.F, NEW + 1)
    x, y = guess.value(kernels.C), guess.value(kernels.D)
    nx, ny = guess.x[node, NEW] - x, guess.y[node, NEW] - y
    if kind == kernels.TWO_CIRCLES:
        bx, by = guess.value(kernels.F), guess.value(kernels.G)
        return float(((bx - x) * ny - (by - y) * nx) / np.sqrt((bx - x) * (bx - x) + (by - y) * (by - y)))
    return float(guess.value(kernels.I) * nx - guess.value(kernels.H) * ny)
