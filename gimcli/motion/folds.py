"""Where a rate changes its sign along a circuit; of the parameter's: folds, the limits of the input."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gimcli.motion.circuit import Circuit, Ended, Policy, Walker
from gimcli.motion.curve import Curve
from gimcli.solvers.arclength import Place, pinned
from gimcli.solvers.crossing import Crossing

Rate = Callable[[Place], float]

REST = 1e-9
"""Part of a unit tangent that is none."""


@dataclass(frozen=True)
class Root:
    """Where a rate is 0."""

    index: int  # of the place before
    place: Place
    side: float  # sign of the rate after it
    own: bool  # it is a place of the circuit itself


def roots(circuit: Circuit, rate: Rate) -> Iterator[Root]:
    """Yield where a rate changes its sign."""
    places = circuit.places
    values = np.array([rate(here) for here in places])
    told = np.flatnonzero(np.abs(values) > REST).tolist()
    for i, j in pairwise(told):
        if values[i] * values[j] < 0.0:
            resting = [k for k in range(i + 1, j) if k in circuit.crossings]
            side = float(np.sign(values[j]))
            if resting:
                yield Root(resting[0], places[resting[0]], side, True)
            elif (found := between(circuit, i, j, rate)) is not None:
                yield Root(i, found, side, False)
    if circuit.closed and told and told[0] > 0 and values[told[0]] * values[told[-1]] < 0.0:
        yield Root(0, places[0], float(np.sign(values[told[0]])), True)


def between(circuit: Circuit, i: int, j: int, rate: Rate) -> Place | None:
    """Return where a rate is 0 between two places."""
    here, policy = circuit.places[i], Policy().steps
    step = float((circuit.places[j].p - here.p) @ here.tangent)
    found = pinned(circuit.curve, here, step, rate, policy)
    if found is None:  # the plane through the other place cuts the curve beside it
        found = pinned(circuit.curve, here, 1.5 * step, rate, policy)
    return None if found is None else found[1]


def folds(circuit: Circuit) -> list[Root]:
    """Return where the parameter turns back."""
    return list(roots(circuit, lambda at: float(at.tangent[-1])))


def next_fold(curve: Curve, start: Place, most: int = 200) -> Place | None:
    """Return the first fold after a place along its tangent; None where none is met on so many places."""
    walker = Walker(curve, start, Policy())
    for _ in range(most):
        known = len(walker.places)
        if not walker.go():
            return None
        if any(start.tangent[-1] * there.tangent[-1] < 0.0 for there in walker.places[known:]):
            found = folds(Circuit(curve, tuple(walker.places), walker.crossings, Ended.LONG))
            return found[0].place if found else None
    return None


def next_crossing(curve: Curve, start: Place, until: float, most: int = 200) -> Crossing | None:
    """Return the last crossing from a place along its tangent up to a parameter; None where none is met."""
    walker, sense = Walker(curve, start, Policy()), float(np.sign(until - start.p[-1]))
    for _ in range(most):
        if not walker.go() or sense * (walker.places[-1].p[-1] - until) > 0.0:
            break
    return walker.crossings[max(walker.crossings)] if walker.crossings else None


def folded(circuit: Circuit) -> Circuit:
    """Return the circuit with its folds among its places: between them the parameter goes one way."""
    places, crossings, start = list(circuit.places), dict(circuit.crossings), circuit.start
    for root in reversed([r for r in folds(circuit) if not r.own]):
        places.insert(root.index + 1, root.place)
        crossings = {k + (k > root.index): met for k, met in crossings.items()}
        start += start > root.index
    return replace(circuit, places=tuple(places), crossings=crossings, start=start)
