"""Every constraint of a mechanism by the user's name, and how far positions are from it.

Equations (1) and (2) of Petuya et al. 2004: the greatest relative error of a length and the
greatest error of an angle [rad]; errors of sliding pairs and travels are relative to the size.
They are computed from the members as written, not from the plan: nothing of the solution enters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimcli.kernels import constraints
from gimcli.kernels.circular import cos_sin
from gimcli.mechanism import ANGLE, FRAME, SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.structure.checks import Check, checks, farthest
from gimcli.structure.steps import NONE, Vector

SWEPT = 100.0
"""What an error of the restrictions imposed may be worth in those of a member that are not."""


@dataclass(frozen=True)
class Residual:
    """The worst error of each row, and which constraint has it."""

    lengths: FloatArray  # (rows,) eq. (1), with slides and travels
    angles: FloatArray  # (rows,) eq. (2)
    worst: tuple[str, ...]  # (rows,) names

    @property
    def total(self) -> FloatArray:
        """The greater of both."""
        return np.maximum(self.lengths, self.angles)


def residual(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, names: bool = False) -> Residual:
    """Return the errors of positions z (nodes, rows) at inputs (actuators, rows).

    A NaN counts as an infinite error. `names` asks for the worst constraint too.
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
    """Return the residual up to which a position is right: the tolerance, or what rounding leaves of it.

    Sweeps end by the restrictions of their own sequence; a member's other lengths and angles, which
    are told here, may then be off by more.
    """
    rounding = 64.0 * float(np.finfo(float).eps) * mechanism.size / mechanism.shortest
    return max(SWEPT * tolerance if swept else tolerance, rounding)


def holds(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, tolerance: float, swept: bool = False,
    error: FloatArray | None = None,
) -> NDArray[np.bool_]:  # fmt: skip
    """Tell of positions z (nodes, rows) at inputs (actuators, rows) whether they fulfil every constraint.

    The gate that every position passes before it is given out as good. `error`: their residuals (rows,), where they
    are known from the same checks.
    """
    worst = residual(mechanism, z, inputs).total if error is None else error
    return np.asarray(worst <= allowed(mechanism, tolerance, swept))  # a NaN fails


def errors(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> Iterator[tuple[str, bool, FloatArray]]:
    """Yield name, whether it is an angle, and the error of each constraint (rows,)."""
    x, y = np.ascontiguousarray(z.real), np.ascontiguousarray(z.imag)
    cos, sin = cos_sin(inputs)
    for check in checks(mechanism):
        yield check.name, check.kind == ANGLE, _error(check, mechanism.size, x, y, inputs, cos, sin)


def _error(
    check: Check, size: float, x: FloatArray, y: FloatArray, inputs: FloatArray, cos: FloatArray, sin: FloatArray
) -> FloatArray:
    def laid(vector: Vector | None) -> tuple[FloatArray | float, FloatArray | float]:
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
        return np.asarray(constraints.angle_error(*laid(check.first), *laid(check.second)))
    px, py = x[check.p], y[check.p]
    if check.q != NONE:
        px, py = px - x[check.q], py - y[check.q]
    value = check.value.at(inputs)
    if check.kind == SPAN:
        return np.asarray(constraints.span_error(px, py, 1.0 / value))
    return np.asarray(constraints.height_error(*laid(check.first), px, py, value, size))


def pose(mechanism: Mechanism, index: int, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return where a member's own origin is and e^(i phi), over rows; from its two nodes farthest apart."""
    member = mechanism.members[index]
    rows = z.shape[1]
    if index == FRAME:
        return np.zeros(rows, dtype=complex), np.ones(rows, dtype=complex)
    shape = member.shape
    far = farthest(member)
    with np.errstate(all="ignore"):  # a NaN stays one
        unit = (z[member.nodes[far]] - z[member.nodes[0]]) / (shape[far] - shape[0])
        unit = unit / np.abs(unit)
    return z[member.nodes[0]] - unit * shape[0], unit
