"""Kind of a singular initial position, determined on the curve that `trace` and `singularities` follow."""

from __future__ import annotations

import numpy as np

from gimcli.branching.singularities import LIMIT
from gimcli.continuation.branches import departure
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.positions.options import TOLERANCE
from gimcli.structure.tangency import tangent_position

SINGULAR = "singular"
"""Kind of a position at which the curve has no unique direction, or that is not on the curve."""

TANGENT = "tangent"
"""Kind of a position that is a double root of the equations, as those near it."""


def singular_start(mechanism: Mechanism, z: ComplexArray) -> str:
    """Return the kind (limit, change point, ...) of an assembled position z (nodes,) that inputs do not determine."""
    curve, inputs = PositionCurve(mechanism), mechanism.drawn_inputs
    if tangent_position(mechanism, z, inputs, TOLERANCE) is not None:
        return TANGENT
    q = float(inputs[curve.main]) if curve.single else curve.begin()
    if not np.allclose(curve.inputs(q), inputs, rtol=0.0, atol=1e-9):
        return SINGULAR  # the laws of several inputs begin at other values
    try:
        left = departure(curve, z, q)
    except GimError:
        return SINGULAR
    if left.met is not None:
        return left.met.kind
    return LIMIT if left.limit else SINGULAR
