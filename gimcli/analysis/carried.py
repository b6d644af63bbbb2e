"""Points carried by members: placed after the solution, which they never enter."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.structure.residual import pose


def carried_point(mechanism: Mechanism, name: str, z: ComplexArray) -> ComplexArray:
    """Return the path of a node or point (rows,) in a motion z (nodes, rows), normal frame."""
    if name in mechanism.nodes:
        return np.asarray(z[mechanism.nodes.index(name)])
    point = next(p for p in mechanism.points if p.name == name)
    origin, unit = pose(mechanism, point.member, z)
    return np.asarray(origin + unit * point.local)
