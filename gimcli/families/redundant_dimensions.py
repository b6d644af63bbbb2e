"""Dimensions that redundant constraints fix: a change of one of them alone contradicts the other dimensions."""

from __future__ import annotations

import numpy as np

from gimcli.families.position_quantities import GuideNormal, NodeArrow, PositionSlopes, PositionState
from gimcli.families.sensitivity import BoolArray
from gimcli.kernels.plan_steps import Program
from gimcli.mechanism import ANGLE, SPAN, FloatArray, Mechanism
from gimcli.positions.program import plan_program
from gimcli.structure.plan import make_plan

FIXED = 1e-6
"""Derivative of a constraint's error, relative to the largest one of a node, above which the constraint is violated."""


def contradicting(mechanism: Mechanism, at: PositionState, by: PositionSlopes) -> BoolArray:
    """Return for each dimension whether, to first order, its change violates a constraint in a row."""
    most = np.maximum(np.abs(by.z).max(axis=(2, 3))[0], 1.0 / mechanism.scale)
    worst = np.zeros(len(most))
    for number in range(len(plan_program(mechanism, make_plan(mechanism)).tables.ci)):
        worst = np.maximum(worst, np.abs(_error_slope(mechanism, number, at, by)).max(axis=1))
    return np.asarray(worst > FIXED * most)


def _error_slope(mechanism: Mechanism, number: int, at: PositionState, by: PositionSlopes) -> FloatArray:
    """Return the derivatives (dimensions, rows) of the error of a constraint, as a length."""
    tables = plan_program(mechanism, make_plan(mechanism)).tables
    kind, p, q, first, second, _ = tables.ci[number]
    if kind == ANGLE:
        turning = [_vector(tables, k).turning(at, by)[0] for k in (first, second)]
        return np.asarray(mechanism.size * (turning[0] - turning[1]))
    arm, change = at.z[0, p], by.z[0, :, p]
    if q >= 0:
        arm, change = arm - at.z[0, q], change - by.z[0, :, q]
    value = by.tables.cv[0, :, number, :1]
    if kind == SPAN:
        return np.asarray((np.conj(arm) * change).real / np.abs(arm) - value)
    vector = _vector(tables, first)
    normal = vector.value(at)[0]
    turned = 1j * normal * vector.turning(at, by)[0]
    return np.asarray((np.conj(normal) * change).real + (np.conj(turned) * arm).real - value)


def _vector(tables: Program, number: int) -> GuideNormal:
    u, v = tables.vi[number][:2]
    return GuideNormal(number, NodeArrow(int(u), int(v)) if u >= 0 else None)
