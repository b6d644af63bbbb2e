"""All circuits that meet: from every position at which branches cross, each branch is followed as a circuit of its own.

A circuit goes straight through the crossings on its way, so that a branch belongs to one circuit only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.errors import StructureError
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.motion.circuit import Circuit, Policy, follow_circuit, landed, rolled, start_place
from gimcli.motion.curve import Curve
from gimcli.solvers.crossing import Crossing

MOST = 24
"""Circuits that are followed."""

SAME = 1e-6
"""Distance below which two crossings are one: they are known to the last digits, those that touch to half of them."""

ALIGNED = 0.9999
"""Cosine above which a circuit goes along a branch's tangent."""


@dataclass
class Knot:
    """A singular position at which branches meet, and which circuit (from 0) goes along each of its tangents."""

    met: Crossing
    taken: list[int | None] = field(default_factory=list)

    def take(self, tangent: FloatArray, circuit: int) -> None:
        """Note that a circuit goes along a tangent."""
        for k, own in enumerate(self.met.tangents):
            if abs(float(own @ tangent)) > ALIGNED:
                self.taken[k] = circuit


@dataclass(frozen=True)
class Branches:
    """Circuits that meet, the drawn one first, and where they meet."""

    circuits: tuple[Circuit, ...]
    knots: tuple[Knot, ...]
    complete: bool  # no branch was left out


def first_circuit(
    curve: Curve, z: ComplexArray, q: float, policy: Policy | None = None,
    progress: Callable[[float], None] | None = None,
) -> Circuit:  # fmt: skip
    """Return the circuit through positions z (nodes,) at a parameter; a singular start is left on its first branch.

    Raises StructureError where the start cannot be left.
    """
    policy = policy or Policy()
    start, met = start_place(curve, z, q, policy)
    if met is None:
        if start.regular <= policy.singular:
            raise _stuck(curve, "tells no way on")
        return follow_circuit(curve, start, policy, progress=progress)
    for tangent in met.tangents:
        found = _from(curve, met, tangent, policy, progress)
        if found is not None:
            return found
    raise _stuck(curve, "is left by no branch")


def _stuck(curve: Curve, what: str) -> StructureError:
    name = curve.mechanism.name
    return StructureError(f"{name}: the start is a singular position that {what}; start the law elsewhere")


def all_circuits(
    first: Circuit, policy: Policy | None = None, progress: Callable[[float], None] | None = None, most: int = MOST
) -> Branches:
    """Follow all circuits that meet the first one, or each other."""
    policy = policy or Policy()
    circuits, knots = [first], list[Knot]()
    _note(first, 0, knots)
    complete = True
    k = 0
    while k < len(knots):
        knot = knots[k]
        k += 1
        for index, tangent in enumerate(knot.met.tangents):
            if knot.taken[index] is not None:
                continue
            if len(circuits) == most:
                complete = False
                break
            found = _from(first.curve, knot.met, tangent, policy, progress)
            if found is None:
                continue
            knot.taken[index] = len(circuits)
            circuits.append(found)
            _note(found, len(circuits) - 1, knots)
    return Branches(tuple(circuits), tuple(knots), complete)


def _note(circuit: Circuit, number: int, knots: list[Knot]) -> None:
    """Note the crossings that a circuit goes through."""
    for index, met in circuit.crossings.items():
        if len(met.tangents) < 2:
            continue
        apart = [float(np.linalg.norm(circuit.curve.apart(met.p, knot.met.p))) for knot in knots]
        if min(apart, default=1.0) > SAME:
            knots.append(Knot(met, [None] * len(met.tangents)))
            apart.append(0.0)
        knots[int(np.argmin(apart))].take(circuit.places[index].tangent, number)


def leaving(
    curve: Curve, met: Crossing, ahead: FloatArray, policy: Policy, progress: Callable[[float], None] | None = None
) -> Circuit | None:
    """Return the circuit that leaves a crossing along a tangent and is followed from there; None where none does."""
    start = landed(curve, met, ahead, policy)
    if start is None:
        return None
    circuit = follow_circuit(curve, start, policy, progress=progress)
    same = [k for k, own in circuit.crossings.items() if np.linalg.norm(own.p[:-1] - met.p[:-1]) <= SAME]
    before = [k for k in same if k < circuit.start]
    if circuit.closed and same:
        return rolled(circuit, max(same), 0)
    return replace(circuit, start=max(before)) if before else circuit


def _from(
    curve: Curve, met: Crossing, tangent: FloatArray, policy: Policy, progress: Callable[[float], None] | None
) -> Circuit | None:
    """Return the circuit that leaves a crossing along a tangent, in the sense of the laws where it has one."""
    sense = -1.0 if tangent[-1] * curve.forward() < -policy.singular else 1.0
    ahead = leaving(curve, met, sense * tangent, policy, progress)
    return ahead if ahead is not None else leaving(curve, met, -sense * tangent, policy, progress)
