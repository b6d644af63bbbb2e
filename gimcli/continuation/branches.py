"""All circuits that meet: from every position at which branches cross, each branch is followed as its own circuit.

A circuit passes smoothly through the crossings on it, so that each branch belongs to one circuit only.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from gimcli.continuation.arclength import CurvePoint, place
from gimcli.continuation.bifurcation import Crossing
from gimcli.continuation.circuit import (
    CIRCUIT,
    RESTS,
    Circuit,
    follow_circuit,
    landed,
    near,
    ordered,
    oriented,
    rolled,
    start_place,
)
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import UnassembledError
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.positions.inputs import BEYOND
from gimcli.positions.options import TOLERANCE
from gimcli.progress import Progress, no_progress, spend
from gimcli.status import Status
from gimcli.structure.residual import holds

MOST = 24
"""Greatest number of circuits that are followed."""

SAME = 1e-6
"""Distance below which two crossings are the same; those of touching branches are known to only half the digits."""


ALIGNED = 0.9999
"""Cosine above which the direction of a circuit is that of a branch tangent."""


@dataclass
class BranchPoint:
    """A singular position at which branches meet, and the circuit on each of its branches."""

    met: Crossing
    tangents: tuple[FloatArray, ...]
    taken: list[int | None]  # number, from 0, of the circuit along each tangent

    def take(self, tangent: FloatArray, circuit: int) -> None:
        """Record that a circuit has a tangent."""
        for k, own in enumerate(self.tangents):
            if abs(float(own @ tangent)) > ALIGNED:
                self.taken[k] = circuit


@dataclass(frozen=True)
class Branches:
    """Circuits that meet, the drawn one first, and where they meet."""

    circuits: tuple[Circuit, ...]
    knots: tuple[BranchPoint, ...]
    complete: bool  # whether all branches were followed


@dataclass(frozen=True)
class Departure:
    """A start position and the directions (n + 1,) of the curves through it, in which a motion can leave it."""

    curve: PositionCurve = field(repr=False)
    place: CurvePoint
    first: FloatArray | None  # the default direction; None if none is determined
    met: Crossing | None = None  # if branches meet there
    limit: bool = False  # whether the input reverses there

    @cached_property
    def directions(self) -> tuple[FloatArray, ...]:
        """All directions, the first one first."""
        if self.first is None or not (self.limit or self.met):
            return () if self.first is None else (self.first,)
        others = [-self.first] if self.met is None else ordered(self.curve, self.met)
        return (self.first, *(v for v in others if self.limit or abs(float(v @ self.first)) < ALIGNED))


def departure(curve: PositionCurve, z: ComplexArray, q: float, along: FloatArray | None = None) -> Departure:
    """Return the directions in which a motion can leave positions z (nodes,) at parameter q, in the sense of the laws.

    The first direction is the default: that of the branch along which a motion arrived (`along`, (n + 1,)), if one did;
    else that of the branch on which an input moves the members least. At a limit it is the direction in which the first
    member that rotates does so counter-clockwise.
    """
    here, met = start_place(curve, z, q)
    if met is not None:
        aside = here.p - met.p
        if along is None and abs(aside[-1]) > BEYOND * max(1.0, abs(q)):
            along = aside  # it is near the meeting, on one of the branches
        return Departure(curve, here, _first(curve, met, along), met)
    if here.regular <= CIRCUIT.singular:
        return Departure(curve, here, None)
    first = oriented(curve, here.p, here.tangent)
    if abs(first[-1]) > RESTS:
        return Departure(curve, here, first)
    if along is not None and first @ along > 0.0:
        first = -first  # a motion that arrived at a limit reverses
    return Departure(curve, here, first, limit=True)


def _first(curve: PositionCurve, met: Crossing, along: FloatArray | None) -> FloatArray | None:
    """Return the tangent of the branch closest to `along`, or of that on which an input moves the members least."""
    if along is None and met.lost == 1:
        return next(iter(ordered(curve, met)), None)
    alone = np.append(np.zeros(curve.system.n), curve.forward())
    found = met.near(alone if along is None else along)
    return next(iter(ordered(curve, met)), None) if found is None else oriented(curve, met.p, found)


def first_circuit(curve: PositionCurve, z: ComplexArray, q: float, along: FloatArray | None = None) -> Circuit:
    """Return the circuit through positions z (nodes,) at parameter q; from a singular position, on its first branch.

    along: the direction (n + 1,) of a motion that arrived there. Raises UnassembledError if no branch can be followed.
    """
    start = departure(curve, z, q, along)
    for k in range(MOST):
        direction = start.first if k == 0 else dict(enumerate(start.directions)).get(k)
        if direction is None:
            break
        if start.met is None:
            found: Circuit | None = follow_circuit(curve, place(curve, start.place.p, direction))
        else:
            found = _from(curve, start.met, direction)
        if found is not None and fulfilled(found):
            return found
    raise UnassembledError(f"{curve.mechanism.name}: {Status.SINGULAR.text}")


def fulfilled(circuit: Circuit) -> bool:
    """Return whether all points of a circuit satisfy the constraints, except points far outside the mechanism."""
    inside = near(circuit)
    p = circuit.p[:, inside | ~inside.any()]
    return bool(holds(circuit.mechanism, circuit.curve.nodes(p), circuit.curve.inputs(p), TOLERANCE).all())


def all_circuits(
    first: Circuit,
    progress: Progress = no_progress,
    most: int = MOST,
) -> Branches:
    """Follow all circuits that meet the first one, directly or by others.

    progress: called with the number of circuits, and this number plus that of the branches to be followed.
    """
    circuits, knots = [first], list[BranchPoint]()
    _note(first, 0, knots)
    complete = True
    k = 0
    while k < len(knots):
        knot = knots[k]
        k += 1
        for index, tangent in enumerate(knot.tangents):
            if knot.taken[index] is not None:
                continue
            if len(circuits) == most or spend():
                complete = False
                break
            found = _from(first.curve, knot.met, tangent)
            if found is None:
                continue
            if not fulfilled(found):
                complete = False
                continue
            knot.taken[index] = len(circuits)
            circuits.append(found)
            _note(found, len(circuits) - 1, knots)
            progress(len(circuits), len(circuits) + sum(own.taken.count(None) for own in knots))
    return Branches(tuple(circuits), tuple(knots), complete)


def _note(circuit: Circuit, number: int, knots: list[BranchPoint]) -> None:
    """Record the crossings on a circuit."""
    for index, met in circuit.crossings.items():
        if len(met.tangents) < 2:
            continue
        apart = [float(np.linalg.norm(circuit.curve.apart(met.p, knot.met.p))) for knot in knots]
        if min(apart, default=1.0) > SAME:
            knots.append(BranchPoint(met, ordered(circuit.curve, met), [None] * len(met.tangents)))
            apart.append(0.0)
        knots[int(np.argmin(apart))].take(circuit.places[index].tangent, number)


def leaving(curve: PositionCurve, met: Crossing, ahead: FloatArray) -> Circuit | None:
    """Return the circuit that leaves a crossing along a tangent; None if it cannot be followed."""
    start = landed(curve, met, ahead)
    if start is None:
        return None
    circuit = follow_circuit(curve, start)
    same = [k for k, own in circuit.crossings.items() if np.linalg.norm(own.p[:-1] - met.p[:-1]) <= SAME]
    before = [k for k in same if k < circuit.start]
    if circuit.closed and same:
        return rolled(circuit, max(same), 0)
    return replace(circuit, start=max(before)) if before else circuit


def _from(curve: PositionCurve, met: Crossing, tangent: FloatArray) -> Circuit | None:
    """Return the circuit along a tangent of a crossing, followed in the sense of the laws if possible."""
    sense = -1.0 if tangent[-1] * curve.forward() < -CIRCUIT.singular else 1.0
    ahead = leaving(curve, met, sense * tangent)
    return ahead if ahead is not None else leaving(curve, met, -sense * tangent)
