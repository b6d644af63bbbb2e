"""Places and directions that members carry, and the quantities that gauges and actuators measure.

The positions z[node] of the nodes are complex numbers, arrays of them, or numbers with derivatives; the results are of
the same kind.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.calculus.numbers import phase, scalar
from gimcli.canonical import beside
from gimcli.mechanism import FRAME, SPAN, ComplexArray, FloatArray, Mechanism, PairRow
from gimcli.structure.steps import Vector


def carried_direction(mechanism: Mechanism, index: int, direction: complex) -> Vector:
    """Return a direction in a member's own frame as a vector that moves with the member."""
    if index == FRAME:
        return Vector(direction)
    u, v, span = mechanism.members[index].ends
    return Vector(direction / span, u, v)


def carried_point(mechanism: Mechanism, name: str, z: ComplexArray) -> ComplexArray:
    """Return the path (rows,) of a node or point in a motion z (nodes, rows), in the normal frame."""
    if name in mechanism.nodes:
        return np.asarray(z[mechanism.nodes.index(name)])
    point = next(p for p in mechanism.points if p.name == name)
    return np.asarray(np.broadcast_to(carried(mechanism, z, point.member, point.local), z.shape[1:]))


def carried(mechanism: Mechanism, z: Any, index: int, local: complex) -> Any:
    """Return the place of a point of a member, given in the member's own frame; one of the frame is a constant."""
    if index == FRAME:
        return local
    member = mechanism.members[index]
    u, v, span = member.ends
    share = (local - scalar(member.shape[0])) / span
    at_first = isinstance(share, complex) and share == 0.0
    return z[u] if at_first else z[u] + (z[v] - z[u]) * share


def unit_of(mechanism: Mechanism, z: Any, index: int) -> Any:
    """Return e^(i phi) of a member."""
    if index == FRAME:
        return np.complex128(1.0)
    u, v, span = mechanism.members[index].ends
    return (z[v] - z[u]) * (1.0 / span)


def turn_rates(mechanism: Mechanism, z: ComplexArray, rates: ComplexArray) -> FloatArray:
    """Return the rotations (..., members) [rad] of all members but the frame for rates (..., nodes) at z (nodes,)."""
    u, v = np.array([member.ends[:2] for member in mechanism.members[FRAME + 1 :]], dtype=int).reshape(-1, 2).T
    arm = z[v] - z[u]
    return np.asarray((np.conj(arm) * (rates[..., v] - rates[..., u])).imag / np.abs(arm) ** 2)


def turned(mechanism: Mechanism, gauge: PairRow, z: Any) -> Any:
    """Return e^(i angle) of the angle that a gauge or an actuator measures."""
    reference = unit_of(mechanism, z, gauge.guide) * scalar(gauge.reference)
    return unit_of(mechanism, z, gauge.members[0]) * scalar(gauge.arm) * reference.conjugate()


def height(mechanism: Mechanism, gauge: PairRow, z: Any) -> Any:
    """Return the height of a node over a line of a member that a gauge or an actuator measures."""
    unit = unit_of(mechanism, z, gauge.guide) * scalar(gauge.normal)
    return ((z[gauge.node] - carried(mechanism, z, gauge.guide, gauge.point)) * unit.conjugate()).real


def measured(mechanism: Mechanism, gauge: PairRow, z: Any) -> Any:
    """Return the quantity of a gauge or an actuator."""
    if gauge.rotary:
        return phase(turned(mechanism, gauge, z))
    if gauge.kind == SPAN:
        arm = z[gauge.nodes[1]] - z[gauge.node]
        return np.sqrt((arm * arm.conjugate()).real)
    return height(mechanism, gauge, z)


def read_inputs(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> FloatArray:
    """Return inputs (actuators,) in which those that follow the linkage have the values that z (nodes,) gives.

    Angles of the linkage are within half a turn of the drawn ones.
    """
    found = np.array(inputs)
    for coupling in mechanism.couplings:
        if coupling.reads:
            read = [(measured(mechanism, row, z), row, ratio) for row, ratio in coupling.reads]
            own = sum(ratio * (beside(value, row.drawn) if row.rotary else value) for value, row, ratio in read)
            found[coupling.follower] = coupling.phase + own + sum(ratio * found[k] for k, ratio in coupling.terms)
    return found
