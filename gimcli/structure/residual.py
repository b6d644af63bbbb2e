"""Residuals: the errors of all constraints at given positions, by the names of the model file.

Equations (1) and (2) of Petuya et al. 2004: the greatest relative error of a length and the greatest error of an angle
[rad]; errors of sliding pairs and travels are relative to the size. They are computed from `checks`, independently of
the plan and the solvers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gimcli.kernels import constraints
from gimcli.kernels.circular import cos_sin
from gimcli.mechanism import ANGLE, FRAME, SPAN, BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.structure.checks import Check, checks
from gimcli.structure.steps import NONE, Vector

SWEPT = 100.0
"""Factor by which the error of a member may exceed that of those of its restrictions that the sweeps impose."""


@dataclass(frozen=True)
class Residual:
    """The greatest errors of each row, and the constraint with the greatest one."""

    lengths: FloatArray  # (rows,) eq. (1), relative, including sliding pairs and travels
    angles: FloatArray  # (rows,) eq. (2) [rad]
    worst: tuple[str, ...]  # (rows,) name of the constraint; "" if names were not requested

    @property
    def total(self) -> FloatArray:
        """The greater of both."""
        return np.maximum(self.lengths, self.angles)


def residual(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, names: bool = False) -> Residual:
    """Return the errors of positions z (nodes, rows) at inputs (actuators, rows).

    A NaN counts as an infinite error. names: also find the constraint with the greatest error.
    """
    rows = z.shape[1]
    lengths, angles = np.zeros(rows), np.zeros(rows)
    worst, peak = [""] * rows, np.full(rows, -1.0)
    with np.errstate(all="ignore"):
        for name, is_angle, error in errors(mechanism, z, inputs):
            error = np.where(np.isfinite(error), error, np.inf)
            np.maximum(angles if is_angle else lengths, error, out=angles if is_angle else lengths)
            if names:
                for k in np.flatnonzero(error > peak):
                    worst[k], peak[k] = name, error[k]
    return Residual(lengths, angles, tuple(worst))


def allowed(mechanism: Mechanism, tolerance: float, swept: bool = False) -> float:
    """Return the greatest residual of an accepted position: the tolerance, but at least the rounding error.

    swept: the position was found by sweeps. They stop by the errors of the restrictions that they impose; the other
    lengths and angles of a member, which the residual includes, may have greater errors.
    """
    rounding = 64.0 * float(np.finfo(float).eps) * mechanism.size / mechanism.shortest
    return max(SWEPT * tolerance if swept else tolerance, rounding)


def holds(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, tolerance: float, swept: bool = False,
    error: FloatArray | None = None,
) -> BoolArray:  # fmt: skip
    """Return (rows,) whether positions z (nodes, rows) at inputs (actuators, rows) satisfy all constraints.

    Every position must pass this check before its status is `ok`. error: the residuals (rows,), if already computed.
    """
    worst = residual(mechanism, z, inputs).total if error is None else error
    return np.asarray(worst <= allowed(mechanism, tolerance, swept))  # a NaN fails


def errors(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> Iterator[tuple[str, bool, FloatArray]]:
    """Yield the name of each constraint, whether it is an angle, and its errors (rows,): relative, or in rad."""
    x, y = np.ascontiguousarray(z.real), np.ascontiguousarray(z.imag)
    cos, sin = cos_sin(inputs)
    for check in checks(mechanism):
        yield check.name, check.kind == ANGLE, _error(check, mechanism.size, x, y, inputs, cos, sin)
    if mechanism.complete is not None:
        from gimcli.structure.coupling_residual import coupling_errors  # imported late: few mechanisms have such gears

        for name, error in coupling_errors(mechanism, z, inputs):
            yield name, True, error


def _error(
    check: Check, size: float, x: FloatArray, y: FloatArray, inputs: FloatArray, cos: FloatArray, sin: FloatArray
) -> FloatArray:
    def value_of(vector: Vector | None) -> tuple[FloatArray | float, FloatArray | float]:
        assert vector is not None
        zr, zi = vector.z.real, vector.z.imag
        if vector.actuator != NONE:
            c, s = cos[vector.actuator], sin[vector.actuator] * vector.turn
            zr, zi = zr * c - zi * s, zr * s + zi * c
        if vector.u == NONE:
            return zr, zi
        bx, by = x[vector.v] - x[vector.u], y[vector.v] - y[vector.u]
        return zr * bx - zi * by, zr * by + zi * bx

    if check.kind == ANGLE:
        return np.asarray(constraints.angle_error(*value_of(check.first), *value_of(check.second)))
    px, py = x[check.p], y[check.p]
    if check.q != NONE:
        px, py = px - x[check.q], py - y[check.q]
    value = check.value.at(inputs)
    if check.kind == SPAN:
        return np.asarray(constraints.span_error(px, py, 1.0 / value))
    return np.asarray(constraints.height_error(*value_of(check.first), px, py, value, size))


def pose(mechanism: Mechanism, index: int, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the origin of a member's own frame (rows,) and e^(i phi) (rows,), from two nodes of the member."""
    member = mechanism.members[index]
    rows = z.shape[1]
    if index == FRAME:
        return np.zeros(rows, dtype=complex), np.ones(rows, dtype=complex)
    shape = member.shape
    far = member.base
    with np.errstate(all="ignore"):  # NaNs are propagated
        unit = (z[member.nodes[far]] - z[member.nodes[0]]) / (shape[far] - shape[0])
        unit = unit / np.abs(unit)
    return z[member.nodes[0]] - unit * shape[0], unit
