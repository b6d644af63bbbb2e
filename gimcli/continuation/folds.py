"""Sign changes of a rate along a circuit; those of the parameter's rate are folds: limits of the input."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gimcli.continuation.arclength import CurvePoint, correct, place, sign_change
from gimcli.continuation.circuit import STEPS, Circuit
from gimcli.continuation.curve import PositionCurve

Rate = Callable[[CurvePoint], float]

REST = 1e-9
"""A component of a unit tangent below this is 0."""


@dataclass(frozen=True)
class Root:
    """A point at which a rate is 0."""

    index: int  # of the point of the circuit before it
    place: CurvePoint
    side: float  # sign of the rate after it


def roots(circuit: Circuit, rate: Rate) -> Iterator[Root]:
    """Yield the points at which a rate changes its sign."""
    places = circuit.places
    values = np.array([rate(here) for here in places])
    moving = np.flatnonzero(np.abs(values) > REST).tolist()
    for i, j in pairwise(moving):
        if values[i] * values[j] < 0.0:
            resting = [k for k in range(i + 1, j) if k in circuit.crossings]
            side = float(np.sign(values[j]))
            if resting:
                yield Root(resting[0], places[resting[0]], side)
            elif (found := between(circuit, i, j, rate)) is not None:
                yield Root(i, found, side)
    if circuit.closed and moving and moving[0] > 0 and values[moving[0]] * values[moving[-1]] < 0.0:
        yield Root(0, places[0], float(np.sign(values[moving[0]])))


def between(circuit: Circuit, i: int, j: int, rate: Rate) -> CurvePoint | None:
    """Return the point between points i and j at which a rate is 0; None if it is not found."""
    here = circuit.places[i]
    step = float((circuit.places[j].p - here.p) @ here.tangent)
    found = sign_change(circuit.curve, here, step, rate, STEPS)
    if found is None:  # the point may be beyond the plane through the other point
        found = sign_change(circuit.curve, here, 1.5 * step, rate, STEPS)
    return found


def folds(circuit: Circuit) -> list[Root]:
    """Return the points at which the parameter reverses."""
    return list(roots(circuit, lambda at: float(at.tangent[-1])))


def fold_beside(curve: PositionCurve, here: CurvePoint, reach: float) -> CurvePoint | None:
    """Return the limit of the parameter within a distance `reach` of a point, on either side; None if there is none."""

    def rate(at: CurvePoint) -> float:
        return float(at.tangent[-1])

    behind = correct(curve, here.p - reach * here.tangent, STEPS, here.tangent)
    if behind is None:
        return None
    return sign_change(curve, place(curve, behind, here.tangent), 2.0 * reach, rate, STEPS)
