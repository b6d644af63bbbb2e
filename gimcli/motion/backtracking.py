"""What is left to try where the steps of a plan have led nowhere, from a random start.

The choices are the sides of dyads and turned lines, and the start of a coupled group, which settles in one
of several configurations. The last choice is changed first: a search in depth.
"""

from __future__ import annotations

from collections.abc import Callable

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.positions.block import NEW, RowBlock
from gimcli.structure.steps import NONE

TURNS = 1024
"""Sides that are exchanged before dyads count as impossible to assemble."""

CHANCES = 40
"""Times that a group is started elsewhere because what hangs on it cannot be assembled."""

RandomPlaces = Callable[[int], ComplexArray]
"""Gives so many places anywhere."""


class Backtracking:
    """What is left to try where steps have led nowhere: other sides, and other starts of groups."""

    def __init__(self, signs: FloatArray, drawn: RowBlock, random: RandomPlaces) -> None:
        self.program, self.signs, self.drawn, self.random = drawn.program, signs, drawn, random
        self.begun, self.turns = signs.copy(), TURNS
        self.chances = dict.fromkeys(self.program.packed, CHANCES)

    def other(self, k: int) -> int:
        """Change the last choice before step k that can be, reset those after it; return its step or NONE."""
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
            self.signs[branch] *= -1.0  # back to the side begun with, if both have been tried
            return bool(first)
        return False
