"""Dimensions that redundant constraints fix: a change of one of them alone contradicts the other dimensions."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.families.position_state import PositionState
from gimcli.families.sensitivity import BoolArray
from gimcli.kernels.plan_steps import Program
from gimcli.mechanism import ANGLE, SPAN
from gimcli.positions.program import plan_program
from gimcli.structure.plan import make_plan

FIXED = 1e-6
"""Derivative of a constraint's error, relative to the largest one of a node, above which the constraint is violated."""


def contradicting(at: PositionState) -> BoolArray:
    """Return for each dimension whether, to first order, its change violates a constraint in a row.

    `at` has one design in dual numbers, with the derivatives by the dimensions.
    """
    most = np.maximum(np.abs(at.z.slopes).max(axis=(2, 3))[:, 0], 1.0 / at.mechanism.scale)
    tables = plan_program(at.mechanism, make_plan(at.mechanism)).tables
    worst = np.zeros(len(most))
    for number in range(len(tables.ci)):
        worst = np.maximum(worst, np.abs(_error(tables, number, at).slopes).max(axis=(1, 2)))
    return np.asarray(worst > FIXED * most)


def _error(tables: Program, number: int, at: PositionState) -> Any:
    """Return the error of a constraint (1, rows) as a length, up to a constant."""
    kind, p, q, first, second, _ = tables.ci[number]
    if kind == ANGLE:
        return at.mechanism.size * np.angle(_vector(tables, first, at) / _vector(tables, second, at))
    arm = at.z[:, p] - (at.z[:, q] if q >= 0 else 0.0)
    value = at.tables.cv[:, number, :1]
    if kind == SPAN:
        return abs(arm) - value
    normal = _vector(tables, first, at)
    return (np.conj(normal / abs(normal)) * arm).real - value


def _vector(tables: Program, number: int, at: PositionState) -> Any:
    """Return a vector of the plan (1, rows): a factor times the vector between two nodes, or times 1 on the frame."""
    u, v = tables.vi[number][:2]
    factor = at.tables.vz[:, number, 0] + 1j * at.tables.vz[:, number, 1]
    return factor[:, None] * (at.z[:, int(v)] - at.z[:, int(u)] if u >= 0 else np.ones(at.z.shape[-1]))
