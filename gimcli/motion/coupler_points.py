"""Positions of points of members, computed after the solution."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.structure.carried import carried


def carried_point(mechanism: Mechanism, name: str, z: ComplexArray) -> ComplexArray:
    """Return the path (rows,) of a node or point in a motion z (nodes, rows), in the normal frame."""
    if name in mechanism.nodes:
        return np.asarray(z[mechanism.nodes.index(name)])
    point = next(p for p in mechanism.points if p.name == name)
    return np.asarray(np.broadcast_to(carried(mechanism, z, point.member, point.local), z.shape[1:]))
