"""Residuals: the errors of all constraints at given positions, by the names of the model file.

Equations (1) and (2) of Petuya et al. 2004: the greatest relative error of a length and the greatest error of an angle
[rad]; errors of sliding pairs and travels are relative to the size. The constraints are derived from the members, pairs
and actuators of the file, and from the inputs that follow the linkage, independently of the plan and the solvers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gimcli.calculus.numbers import scalar
from gimcli.kernels import constraints
from gimcli.kernels.circular import cos_sin
from gimcli.mechanism import (
    ANGLE,
    FRAME,
    HEIGHT,
    SPAN,
    BoolArray,
    ComplexArray,
    Coupling,
    FloatArray,
    Input,
    Mechanism,
    Member,
    PairRow,
)
from gimcli.structure.carried import carried_direction
from gimcli.structure.derived import derived
from gimcli.structure.rotation import ties
from gimcli.structure.steps import NONE, Value, Vector

SWEPT = 100.0
"""Factor by which the error of a member may exceed that of those of its restrictions that the sweeps impose."""


ZERO = Value(0.0)


@dataclass(frozen=True, eq=False)
class Check:
    """One constraint: the distance of nodes p and q, the angle between two vectors, or the height of p over q.

    The direction of a member is taken from its first node and that of its `base`.
    """

    name: str
    kind: int
    p: int = NONE
    q: int = NONE  # NONE: the origin
    first: Vector | None = None  # ANGLE: the arm; HEIGHT: the normal
    second: Vector | None = None  # ANGLE: required direction of the arm
    value: Value = ZERO  # required length or height, normal frame


@derived
def checks(mechanism: Mechanism) -> tuple[Check, ...]:
    """Return every constraint of a mechanism."""
    return tuple(_checks(mechanism))


def _checks(mechanism: Mechanism) -> Iterator[Check]:
    for member in mechanism.members[FRAME + 1 :]:
        yield from _of_member(mechanism, member)
    for row in mechanism.pairs:
        if row.kind != ANGLE:
            yield _of_row(mechanism, row, NONE)
    for tie in ties(mechanism):  # heights are also satisfied if the body is rotated by 180 deg
        target = carried_direction(mechanism, tie.guide, 1.0).times(tie.turn)
        yield Check(tie.pair, ANGLE, first=carried_direction(mechanism, tie.body, 1.0), second=target)
    for number, actuator in enumerate(mechanism.actuators):
        yield _of_row(mechanism, actuator, number)


def _of_member(mechanism: Mechanism, member: Member) -> Iterator[Check]:
    names, nodes = mechanism.nodes, member.nodes
    shape = member.shape - member.shape[0]
    for k, node in enumerate(nodes[1:], start=1):
        label = member.name if len(nodes) == 2 else f"{member.name} {names[nodes[0]]}-{names[node]}"
        yield Check(label, SPAN, node, nodes[0], value=Value(abs(shape[k])))
        if k > 1:
            label = f"{member.name} {names[nodes[1]]}-{names[nodes[0]]}-{names[node]}"
            arm = Vector(scalar(1.0 / shape[k]), nodes[0], node)
            yield Check(label, ANGLE, first=arm, second=Vector(scalar(1.0 / shape[1]), nodes[0], nodes[1]))


def _of_row(mechanism: Mechanism, row: PairRow, actuator: int) -> Check:
    """Return the constraint of a pair (actuator NONE), or of the actuator of this number."""
    if row.kind == SPAN:
        first, second = row.nodes
        return Check(row.name, SPAN, second, first, value=Value(0.0, actuator))
    if row.kind == HEIGHT:
        return _height(mechanism, row, actuator)
    arm, reference = (carried_direction(mechanism, k, 1.0) for k in row.members)
    return Check(row.name, ANGLE, first=arm.times(row.arm), second=reference.driven(row.reference, actuator, 1))


def _height(mechanism: Mechanism, row: PairRow, actuator: int) -> Check:
    """Return the constraint on the height of a node over the line of a guide."""
    guide = mechanism.members[row.guide]
    origin = NONE if row.guide == FRAME else guide.nodes[0]
    offset = row.point if row.guide == FRAME else row.point - scalar(guide.shape[0])
    height = (offset * row.normal.conjugate()).real
    vector = carried_direction(mechanism, row.guide, 1.0).times(row.normal)
    return Check(row.name, HEIGHT, row.node, origin, vector, value=Value(height, actuator))


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


def coupling_errors(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Yield the name of each input that follows the linkage, and its error (rows,): in rad, or relative to the size.

    An angle that is read from the position is known but for full turns; the nearest is taken.
    """
    for coupling in mechanism.couplings:
        if coupling.reads:
            one = mechanism.actuators[coupling.follower]
            error = _coupling_error(mechanism, coupling, z, inputs)
            yield one.name, error if one.rotary else error / mechanism.size


def _coupling_error(mechanism: Mechanism, coupling: Coupling, z: ComplexArray, inputs: FloatArray) -> FloatArray:
    rest = inputs[coupling.follower] - coupling.phase
    for actuator, ratio in coupling.terms:
        rest = rest - ratio * inputs[actuator]
    turns = []
    for row, ratio in coupling.reads:
        rest = rest - ratio * _value(mechanism, row, z)
        if row.kind == ANGLE:
            turns.append(2.0 * np.pi * abs(ratio))
    for turn in sorted(turns, reverse=True):
        rest = rest - turn * np.round(rest / turn)
    return np.asarray(np.abs(rest))


def _value(mechanism: Mechanism, row: Input, z: ComplexArray) -> FloatArray:
    """Return the quantity (rows,) at positions z (nodes, rows); an angle is in -pi..pi."""
    if row.kind == ANGLE:
        arm, reference = (pose(mechanism, k, z)[1] for k in row.members)
        return np.asarray(np.angle(arm * row.arm * np.conj(reference * row.reference)))
    origin, turn = pose(mechanism, row.guide, z)
    return np.asarray(((z[row.node] - origin - turn * row.point) * np.conj(turn * row.normal)).real)
