"""Conditions on designs, such as `range(P.y) > 40`, and how far a design is from them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.errors import UsageError
from gimcli.families.column_names import REACHABLE, TYPE, ColumnNames
from gimcli.families.design_columns import DesignColumns
from gimcli.families.design_motions import DesignMotions
from gimcli.families.family import Family
from gimcli.families.quantity_text import KeptQuantity, quantity
from gimcli.mechanism import FloatArray

STEPS = 360
"""Steps of the motions for which conditions and goals are computed."""

ROOM = 1e-7
"""Margins are less by this part of the bound, so that rounding does not violate it."""

INEQUALITY = re.compile(r"([^<>=!]+)(<=?|>=?)([^<>=!]+)")


class DesignQuantities:
    """Conditions and a goal, in the form of `gim sweep`, for the designs of a family."""

    def __init__(self, family: Family, where: Sequence[str] = (), goal: str = "") -> None:
        """Read the texts; raise UsageError where one is not valid."""
        self.family, self.texts = family, tuple(where)
        names = self._names = ColumnNames(family.mechanism, family.names)
        self.tests = [quantity(text, names, ("yes",), "where") for text in where]
        self.goal = quantity(goal, names, ("number",), "goal") if goal else None
        self._margins = [pair for text in where if (pair := _sides(text, names)) is not None]
        used = frozenset[str]().union(*(q.names for q in [*self.tests, *([self.goal] if self.goal else [])]))
        if TYPE in used:
            names.check_type()
        self._reachable = REACHABLE in used

    def hold(self, designs: FloatArray, steps: int = STEPS) -> NDArray[np.bool_]:
        """Return which designs (designs,) satisfy all conditions."""
        good = np.ones(len(designs), dtype=bool)
        if self.tests and len(designs):
            columns = self._columns(designs, steps)
            for test in self.tests:
                good &= np.broadcast_to(test.values(columns), len(designs))
        return good

    def goals(self, designs: FloatArray, steps: int = STEPS) -> FloatArray:
        """Return the goal (designs,); NaN where it is not defined."""
        assert self.goal is not None
        return np.broadcast_to(np.asarray(self.goal.values(self._columns(designs, steps)), dtype=float), len(designs))

    def admitted_goals(self, designs: FloatArray, steps: int) -> FloatArray:
        """Return the goal (designs,); NaN for designs that do not move over the whole law, or violate a condition."""
        assert self.goal is not None
        columns = self._columns(designs, steps)
        good = columns.solved.good.all(axis=1)
        for test in self.tests:
            good &= np.broadcast_to(test.values(columns), len(designs))
        goals = np.broadcast_to(np.asarray(self.goal.values(columns), dtype=float), len(designs))
        return np.where(good & np.isfinite(goals), goals, np.nan)

    def margins(self, designs: FloatArray) -> FloatArray:
        """Return by how much designs exceed the bounds of inequalities (designs, inequalities); negative: violated."""
        columns = self._columns(designs, STEPS)
        found = [np.empty((len(designs), 0))]
        for one, other, sense in self._margins:
            first, second = (np.asarray(side.values(columns), dtype=float) for side in (one, other))
            margin = sense * (first - second) - ROOM * (1.0 + np.abs(second))
            found.append(np.broadcast_to(margin, len(designs))[:, None])
        return np.concatenate(found, axis=1)

    @property
    def inequalities(self) -> int:
        """The number of conditions that are inequalities; for the others there is no margin."""
        return len(self._margins)

    def _columns(self, designs: FloatArray, steps: int) -> DesignColumns:
        options: dict[str, Any] = {"reachable": self._reachable, "jit": "on"}
        solved = self.family.solve(designs, steps, **options)
        return DesignColumns(DesignMotions(self.family, solved, options), self._names)


def _sides(text: str, names: ColumnNames) -> tuple[KeptQuantity, KeptQuantity, float] | None:
    """Return the sides of an inequality and its sense; None for other conditions."""
    found = INEQUALITY.fullmatch(text)
    if found is None:
        return None
    try:
        one, other = (quantity(side, names, ("number",), "where") for side in found.group(1, 3))
    except UsageError:  # the sign is inside a part of the text, such as brackets
        return None
    return one, other, 1.0 if found[2].startswith(">") else -1.0
