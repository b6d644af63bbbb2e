"""Errors of the inputs that follow the linkage itself, computed from the members, independently of the solvers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gimcli.mechanism import ANGLE, FRAME, ComplexArray, Coupling, FloatArray, Input, Mechanism


def coupling_errors(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Yield the name of each input that follows the linkage, and its error (rows,): in rad, or relative to the size.

    An angle that is read from the position is known but for full turns; the nearest is taken.
    """
    for coupling in mechanism.couplings:
        if coupling.reads:
            one = mechanism.actuators[coupling.follower]
            error = _error(mechanism, coupling, z, inputs)
            yield one.name, error if one.rotary else error / mechanism.size


def _error(mechanism: Mechanism, coupling: Coupling, z: ComplexArray, inputs: FloatArray) -> FloatArray:
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
        arm, reference = (_turn(mechanism, k, z) for k in row.members)
        return np.asarray(np.angle(arm * row.arm * np.conj(reference * row.reference)))
    turn = _turn(mechanism, row.guide, z)
    guide = mechanism.members[row.guide]
    origin = 0.0 if row.guide == FRAME else z[guide.nodes[0]] - turn * guide.shape[0]
    return np.asarray(((z[row.node] - origin - turn * row.point) * np.conj(turn * row.normal)).real)


def _turn(mechanism: Mechanism, index: int, z: ComplexArray) -> ComplexArray:
    """Return e^(i phi) of a member (rows,)."""
    if index == FRAME:
        return np.ones(z.shape[1], dtype=complex)
    first, far, span = mechanism.members[index].ends
    arm = (z[far] - z[first]) / span
    return np.asarray(arm / np.abs(arm))
