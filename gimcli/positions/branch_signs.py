"""On which side of its loci a node is drawn: the sign of a step with two solutions."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import FloatArray
from gimcli.positions import closed_forms
from gimcli.positions.block import RowBlock
from gimcli.structure.steps import NONE, Circle, Dyad, Line, Orient, Plan, Tilt

FLAT = 1e-9
"""A guess whose side is smaller than this, relative to the size, has no side: left is taken."""


def sides(plan: Plan, guess: RowBlock, size: float) -> FloatArray:
    """Return the signs of all steps with two solutions for a guess in row 0 of a block."""
    signs = np.ones(plan.branches)
    with np.errstate(all="ignore"):
        for step in plan.steps:
            if isinstance(step, Orient):
                closed_forms.orient(step, guess)
            elif isinstance(step, Tilt):
                signs[step.branch] = tilt_side(step, guess, size)
                rows = slice(0, 1)
                ux, uy = guess.vector(step.along, rows)
                norm = np.sqrt(ux * ux + uy * uy)
                guess.rx[step.register, rows], guess.ry[step.register, rows] = ux / norm, uy / norm
            elif isinstance(step, Dyad) and step.branch != NONE:
                signs[step.branch] = dyad_side(step, guess, size)
    return signs


def tilt_side(step: Tilt, guess: RowBlock, size: float) -> float:
    """Return the side of a turned line: ahead if it is drawn towards its point."""
    rows = slice(0, 1)
    ux, uy = guess.vector(step.along, rows)
    wx, wy = guess.x[step.b, rows] - guess.x[step.a, rows], guess.y[step.b, rows] - guess.y[step.a, rows]
    return _sign(float((ux * wx + uy * wy)[0]), size)


def dyad_side(step: Dyad, guess: RowBlock, size: float) -> float:
    """Return the side of a node: left of the centres' line, or ahead along a line."""
    first, second, rows = step.first, step.second, slice(0, 1)
    if isinstance(first, Line):
        first, second = second, first
    assert isinstance(first, Circle)
    x, y, _ = closed_forms.circle(first, guess, rows)
    nx, ny = guess.x[step.node, rows] - x, guess.y[step.node, rows] - y
    if isinstance(second, Circle):
        bx, by, _ = closed_forms.circle(second, guess, rows)
        measure = ((bx - x) * ny - (by - y) * nx) / np.sqrt((bx - x) ** 2 + (by - y) ** 2)
    else:
        normal = closed_forms.line(second, guess, rows)
        measure = normal[3] * nx - normal[2] * ny
    return _sign(float(measure[0]), size)


def _sign(measure: float, size: float) -> float:
    return -1.0 if measure < -FLAT * size else 1.0
