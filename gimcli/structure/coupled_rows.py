"""Couplings of inputs as constraints of the positions: their values and gradients, for rank and mobility."""

from __future__ import annotations

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.mechanism import FRAME, ComplexArray, Coupling, FloatArray, Mechanism, PairRow
from gimcli.structure.carried import measured

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
        self.drawn = [measured(mechanism, row, mechanism.drawn) for row, _ in self.terms]

    def gradient(self, z: ComplexArray, _: FloatArray) -> dict[int, complex]:
        """Return {node: g} with d(value) = sum Re(conj(g) dz)."""
        total: dict[int, complex] = {}
        for row, factor in self.terms:
            for node, g in measured_gradient(self.mechanism, row, z).items():
                total[node] = total.get(node, 0.0) + factor * g
        return total

    def measure(self, z: ComplexArray, _: FloatArray) -> float:
        """Return the value; it is 0 at the drawing, and angles differ from it by less than half a turn."""
        value = 0.0
        for (row, factor), drawn in zip(self.terms, self.drawn, strict=True):
            change = measured(self.mechanism, row, z) - drawn
            if row.rotary:
                change -= 2.0 * np.pi * round(change / (2.0 * np.pi))
            value += factor * change
        return value


def measured_gradient(mechanism: Mechanism, row: PairRow, z: ComplexArray) -> dict[int, complex]:
    """Return {node: g} with d(quantity) = sum Re(conj(g) dz)."""
    arms = [n for k in row.members if k != FRAME for n in mechanism.members[k].ends[:2]]
    nodes = list(dict.fromkeys((*row.nodes, *arms)))
    seeds = np.kron(np.eye(len(nodes)), [1.0, 1.0j])  # x and y of each node
    moving = {node: Dual(z[node], seed) for node, seed in zip(nodes, seeds, strict=True)}
    slopes = measured(mechanism, row, moving).slopes
    return dict(zip(nodes, (slopes[0::2] + 1j * slopes[1::2]).tolist(), strict=True))


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
