"""Positions of points of members, computed after the solution."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, Mechanism
from gimcli.structure.residual import pose


def carried_point(mechanism: Mechanism, name: str, z: ComplexArray) -> ComplexArray:
    """Return the path (rows,) of a node or point in a motion z (nodes, rows), in the normal frame."""
    if name in mechanism.nodes:
        return np.asarray(z[mechanism.nodes.index(name)])
    point = next(p for p in mechanism.points if p.name == name)
    member = mechanism.members[point.member]
    if point.member == FRAME or len(member.nodes) < 2:
        origin, unit = pose(mechanism, point.member, z)
        return np.asarray(origin + unit * point.local)
    far, first = member.base, member.shape[0]
    along = z[member.nodes[far]] - z[member.nodes[0]]
    along *= (point.local - first) / (member.shape[far] - first)
    along += z[member.nodes[0]]
    return np.asarray(along)
