"""Where a rate changes its sign along a circuit; of the parameter's: folds, the limits of the input."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gimcli.continuation.arclength import CurvePoint, correct, pinned, place
from gimcli.continuation.circuit import STEPS, Circuit
from gimcli.continuation.curve import PositionCurve

Rate = Callable[[CurvePoint], float]

REST = 1e-9
"""Part of a unit tangent that is none."""


@dataclass(frozen=True)
class Root:
    """Where a rate is 0."""

    index: int  # of the place before
    place: CurvePoint
    side: float  # sign of the rate after it
    own: bool  # it is a place of the circuit itself


def roots(circuit: Circuit, rate: Rate) -> Iterator[Root]:
    """Yield where a rate changes its sign."""
    places = circuit.places
    values = np.array([rate(here) for here in places])
    moving = np.flatnonzero(np.abs(values) > REST).tolist()
    for i, j in pairwise(moving):
        if values[i] * values[j] < 0.0:
            resting = [k for k in range(i + 1, j) if k in circuit.crossings]
            side = float(np.sign(values[j]))
            if resting:
                yield Root(resting[0], places[resting[0]], side, True)
            elif (found := between(circuit, i, j, rate)) is not None:
                yield Root(i, found, side, False)
    if circuit.closed and moving and moving[0] > 0 and values[moving[0]] * values[moving[-1]] < 0.0:
        yield Root(0, places[0], float(np.sign(values[moving[0]])), True)


def between(circuit: Circuit, i: int, j: int, rate: Rate) -> CurvePoint | None:
    """Return where a rate is 0 between two places."""
    here = circuit.places[i]
    step = float((circuit.places[j].p - here.p) @ here.tangent)
    found = pinned(circuit.curve, here, step, rate, STEPS)
    if found is None:  # the plane through the other place cuts the curve beside it
        found = pinned(circuit.curve, here, 1.5 * step, rate, STEPS)
    return None if found is None else found[1]


def folds(circuit: Circuit) -> list[Root]:
    """Return where the parameter turns back."""
    return list(roots(circuit, lambda at: float(at.tangent[-1])))


def fold_beside(curve: PositionCurve, here: CurvePoint, reach: float) -> CurvePoint | None:
    """Return the limit of the parameter within a distance of a place, on either side; None where there is none."""

    def rate(at: CurvePoint) -> float:
        return float(at.tangent[-1])

    behind = correct(curve, here.p - reach * here.tangent, STEPS, here.tangent)
    if behind is None:
        return None
    back = place(curve, behind, here.tangent)
    found = pinned(curve, back, 2.0 * reach, rate, STEPS)
    return None if found is None else found[1]
