"""Every constraint of a mechanism by the user's name, and how far positions are from it.

Equations (1) and (2) of Petuya et al. 2004: the greatest relative error of a length and the
greatest error of an angle [rad]; errors of sliding pairs and travels are relative to the size.
They are computed from the members as written, not from the plan: nothing of the solution enters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, Drive, FloatArray, Mechanism, Member

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


def errors(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> Iterator[tuple[str, bool, FloatArray]]:
    """Yield name, whether it is an angle, and the error of each constraint (rows,)."""
    for member in mechanism.members[FRAME + 1 :]:
        yield from _member_errors(mechanism, member, z)
    for slide in mechanism.slides:
        origin, unit = pose(mechanism, slide.member, z)
        offset = (z[slide.node] - origin) * np.conj(unit * slide.direction) - slide.point / slide.direction
        yield slide.name, False, np.abs(offset.imag) / mechanism.size
    for number, actuator in enumerate(mechanism.actuators):
        value = inputs[number]
        if actuator.drive is Drive.DISTANCE:
            yield actuator.name, False, np.abs(np.abs(z[actuator.b] - z[actuator.a]) / value - 1.0)
        elif actuator.drive is Drive.TRAVEL:
            origin, unit = pose(mechanism, actuator.reference_member, z)
            along = (z[actuator.a] - origin) * np.conj(unit * actuator.direction)
            travel = (along - actuator.point / actuator.direction).real
            yield actuator.name, False, np.abs(travel - value) / mechanism.size
        else:
            _, arm = pose(mechanism, actuator.arm_member, z)
            _, reference = pose(mechanism, actuator.reference_member, z)
            turned = arm * actuator.arm_direction * np.conj(reference * actuator.reference_direction)
            yield actuator.name, True, angle_error(turned * np.exp(-1j * value))


def _member_errors(mechanism: Mechanism, member: Member, z: ComplexArray) -> Iterator[tuple[str, bool, FloatArray]]:
    first, names = member.nodes[0], mechanism.nodes
    arm, shape = z[member.nodes[1]] - z[first], member.shape - member.shape[0]
    for k, node in enumerate(member.nodes[1:], start=1):
        other = z[node] - z[first]
        label = member.name if len(member.nodes) == 2 else f"{member.name} {names[first]}-{names[node]}"
        yield label, False, np.abs(np.abs(other) / abs(shape[k]) - 1.0)
        if k > 1:
            label = f"{member.name} {names[member.nodes[1]]}-{names[first]}-{names[node]}"
            yield label, True, angle_error(other * np.conj(arm) * np.conj(shape[k] * np.conj(shape[1])))


def pose(mechanism: Mechanism, index: int, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return where a member's own origin is and e^(i phi), over rows; from its two nodes farthest apart."""
    member = mechanism.members[index]
    rows = z.shape[1]
    if index == FRAME:
        return np.zeros(rows, dtype=complex), np.ones(rows, dtype=complex)
    shape = member.shape
    far = int(np.argmax(np.abs(shape - shape[0])))
    with np.errstate(all="ignore"):  # a NaN stays one
        unit = (z[member.nodes[far]] - z[member.nodes[0]]) / (shape[far] - shape[0])
        unit = unit / np.abs(unit)
    return z[member.nodes[0]] - unit * shape[0], unit


def angle_error(turn: ComplexArray) -> FloatArray:
    """Return |angle| of a complex number that should point along +x, in rad."""
    return np.asarray(np.abs(np.angle(turn)))
