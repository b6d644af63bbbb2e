"""What kind of singular position a mechanism is drawn in, by the curve that `trace` and `singularities` follow."""

from __future__ import annotations

import numpy as np

from gimcli.branching.singularities import CHANGE, LIMIT, TANGENCY
from gimcli.continuation.branches import departure
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError
from gimcli.mechanism import ComplexArray, Mechanism

SINGULAR = "singular"
"""Kind of a position that the curve does not leave in one direction, or that is not on it."""


def singular_start(mechanism: Mechanism, z: ComplexArray) -> str:
    """Return the kind of an assembled position z (nodes,) that its inputs do not determine: limit, change point, ..."""
    curve, inputs = PositionCurve(mechanism), mechanism.drawn_inputs
    q = float(inputs[0]) if curve.single else curve.begin()
    if not np.allclose(curve.inputs(q), inputs, rtol=0.0, atol=1e-9):
        return SINGULAR  # several inputs whose laws begin elsewhere
    try:
        left = departure(curve, z, q)
    except GimError:
        return SINGULAR
    if left.met is not None:
        return CHANGE if left.met.loose or len(left.met.tangents) > 1 else TANGENCY
    return LIMIT if left.limit else SINGULAR
