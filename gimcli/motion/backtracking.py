"""Backtracking over the choices of a plan that cannot be assembled from a random start.

The choices are the sides of dyads and guides, and the start of each coupled group, which may converge to different
configurations. The last choice is changed first (depth-first search).
"""

from __future__ import annotations

from collections.abc import Callable

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.positions.block import NEW, RowBlock
from gimcli.structure.steps import NONE

TURNS = 1024
"""Greatest number of changed choices."""

CHANCES = 40
"""Greatest number of random starts of each group, if a later step cannot be assembled."""

RandomPlaces = Callable[[int], ComplexArray]
"""Returns a number of random positions."""


class Backtracking:
    """The remaining choices: other sides of dyads, and other starts of groups."""

    def __init__(self, signs: FloatArray, drawn: RowBlock, random: RandomPlaces) -> None:
        self.program, self.signs, self.drawn, self.random = drawn.program, signs, drawn, random
        self.begun, self.turns = signs.copy(), TURNS
        self.chances = dict.fromkeys(self.program.packed, CHANCES)

    def other(self, k: int) -> int:
        """Change the last changeable choice before step k, reset those after it; return its step, or NONE."""
        self.turns -= 1
        for earlier in range(k - 1, NONE, -1) if self.turns > 0 else ():
            if self._changed(earlier):
                return earlier
        return NONE

    def _changed(self, k: int) -> bool:
        branch = self.program.tables.steps[k][5]
        if self.chances.get(k, 0):
            base = list(self.program.packed[k].group.base)
            places = self.random(len(base))
            self.drawn.x[base, NEW], self.drawn.y[base, NEW] = places.real, places.imag
            self.chances[k] -= 1
            return True
        if branch != NONE:
            first = self.signs[branch] == self.begun[branch]
            self.signs[branch] *= -1.0  # back to the first side if both have been tried
            return bool(first)
        return False
