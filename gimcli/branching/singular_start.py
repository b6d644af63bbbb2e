"""Kind of a singular initial position, determined on the curve that `trace` and `singularities` follow."""

from __future__ import annotations

import numpy as np

from gimcli.branching.singularities import CHANGE, LIMIT, TANGENCY
from gimcli.continuation.branches import departure
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError
from gimcli.mechanism import ComplexArray, Mechanism

SINGULAR = "singular"
"""Kind of a position at which the curve has no unique direction, or that is not on the curve."""


def singular_start(mechanism: Mechanism, z: ComplexArray) -> str:
    """Return the kind (limit, change point, ...) of an assembled position z (nodes,) that inputs do not determine."""
    curve, inputs = PositionCurve(mechanism), mechanism.drawn_inputs
    q = float(inputs[curve.main]) if curve.single else curve.begin()
    if not np.allclose(curve.inputs(q), inputs, rtol=0.0, atol=1e-9):
        return SINGULAR  # the laws of several inputs begin at other values
    try:
        left = departure(curve, z, q)
    except GimError:
        return SINGULAR
    if left.met is not None:
        return CHANGE if left.met.loose or len(left.met.tangents) > 1 else TANGENCY
    return LIMIT if left.limit else SINGULAR
