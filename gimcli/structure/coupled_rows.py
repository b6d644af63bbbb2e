"""Couplings of inputs as constraints of the positions: their values and gradients, for rank and mobility."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import ANGLE, FRAME, SPAN, ComplexArray, Coupling, Mechanism, PairRow

LARGEST = 1000
"""Greatest denominator of a ratio that counts as rational, and its rounding error."""
EXACT = 1e-12


class CoupledRow:
    """The constraint of a follower: its quantity minus ratio times those of its leaders, relative to the drawing."""

    def __init__(self, mechanism: Mechanism, coupling: Coupling) -> None:
        self.mechanism, self.name = mechanism, mechanism.actuators[coupling.follower].name
        leaders = [(mechanism.actuators[k], -ratio) for k, ratio in coupling.terms]
        read = [(row, -ratio) for row, ratio in coupling.reads]
        self.terms: list[tuple[PairRow, float]] = [(mechanism.actuators[coupling.follower], 1.0), *leaders, *read]
        self.drawn = [quantity(mechanism, row, mechanism.drawn) for row, _ in self.terms]

    def gradient(self, z: ComplexArray) -> dict[int, complex]:
        """Return {node: g} with d(value) = sum Re(conj(g) dz)."""
        total: dict[int, complex] = {}
        for row, factor in self.terms:
            for node, g in quantity_gradient(self.mechanism, row, z).items():
                total[node] = total.get(node, 0.0) + factor * g
        return total

    def measure(self, z: ComplexArray) -> float:
        """Return the value; it is 0 at the drawing, and angles differ from it by less than half a turn."""
        value = 0.0
        for (row, factor), drawn in zip(self.terms, self.drawn, strict=True):
            change = quantity(self.mechanism, row, z) - drawn
            if row.rotary:
                change -= 2.0 * np.pi * round(change / (2.0 * np.pi))
            value += factor * change
        return value


def quantity(mechanism: Mechanism, row: PairRow, z: ComplexArray) -> float:
    """Return the angle (-pi..pi), distance or travel that an input drives, at positions z (nodes,)."""
    if row.kind == SPAN:
        return float(abs(z[row.nodes[1]] - z[row.nodes[0]]))
    if row.kind == ANGLE:
        arm, reference = (_turn(mechanism, k, z) for k in row.members)
        return float(np.angle(arm * row.arm * np.conj(reference * row.reference)))
    turn, origin = _turn(mechanism, row.guide, z), _origin(mechanism, row.guide, z)
    return float((np.conj(turn * row.normal) * (z[row.node] - origin - turn * row.point)).real)


def quantity_gradient(mechanism: Mechanism, row: PairRow, z: ComplexArray) -> dict[int, complex]:
    """Return {node: g} with d(quantity) = sum Re(conj(g) dz)."""
    if row.kind == SPAN:
        first, second = row.nodes
        n = complex(z[second] - z[first]) / abs(z[second] - z[first])
        return {second: n, first: -n}
    total: dict[int, complex] = {}

    def add(node: int, g: complex) -> None:
        total[node] = total.get(node, 0.0) + g

    def add_turn(member: int, factor: float) -> None:
        if member != FRAME:
            first, far, _ = mechanism.members[member].ends
            arm = complex(z[far] - z[first])
            add(far, factor * 1j * arm / abs(arm) ** 2)
            add(first, -factor * 1j * arm / abs(arm) ** 2)

    if row.kind == ANGLE:
        for member, factor in zip(row.members, (1.0, -1.0), strict=True):
            add_turn(member, factor)
        return total
    across = complex(_turn(mechanism, row.guide, z) * row.normal)
    add(row.node, across)
    if row.guide != FRAME:
        base = mechanism.members[row.guide].nodes[0]
        add(base, -across)
        add_turn(row.guide, (across.conjugate() * complex(z[row.node] - z[base])).imag)
    return total


def _turn(mechanism: Mechanism, index: int, z: ComplexArray) -> complex:
    """Return e^(i phi) of a member."""
    if index == FRAME:
        return 1.0 + 0.0j
    first, far, span = mechanism.members[index].ends
    arm = complex(z[far] - z[first]) / span
    return arm / abs(arm)


def _origin(mechanism: Mechanism, index: int, z: ComplexArray) -> complex:
    if index == FRAME:
        return 0.0j
    member = mechanism.members[index]
    return complex(z[member.nodes[0]]) - _turn(mechanism, index, z) * complex(member.shape[0])


def turns_until_repeated(mechanism: Mechanism) -> int | None:
    """Return after how many turns of the only rotary driver all followers are back, modulo turns; None if never.

    Without followers, or with several drivers, one turn.
    """
    if len(mechanism.drivers) != 1 or not mechanism.actuators[mechanism.drivers[0]].rotary:
        return 1
    from fractions import Fraction  # imported late: it takes as long as a short motion

    turns = 1
    for k, (ratio,) in enumerate(mechanism.following.tolist()):
        if mechanism.actuators[k].rotary:
            found = Fraction(ratio).limit_denominator(LARGEST)
            if abs(float(found) - ratio) > EXACT * max(1.0, abs(ratio)):
                return None
            turns = int(np.lcm(turns, found.denominator))
    return turns
