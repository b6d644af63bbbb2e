"""Conditions on designs, such as `range(P.y) > 40`, and how far a design is from them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.calculus.dual import first_of
from gimcli.families.design_columns import DesignColumns
from gimcli.families.family import Family
from gimcli.families.quantity_text import REACHABLE, TYPE, ColumnNames, quantity
from gimcli.language.arrays import strict
from gimcli.language.expression import Expression
from gimcli.mechanism import FloatArray

STEPS = 360
"""Steps of the motions for which conditions and goals are computed."""

ROOM = 1e-7
"""Margins are less by this part of the bound, so that rounding does not violate it."""


def _margin(sense: float, one: Any, two: Any) -> Any:
    """Return by how much an inequality is satisfied, less than the room for rounding."""
    return sense * (one - two) - ROOM * (1.0 + np.abs(two))


MARGINS = {sign: partial(_margin, 1.0 if sign[0] == ">" else -1.0) for sign in ("<", "<=", ">", ">=")}


class DesignQuantities:
    """Conditions and a goal, in the form of `gim sweep`, for the designs of a family."""

    def __init__(self, family: Family, where: Sequence[str] = (), goal: str = "") -> None:
        """Read the texts; raise UsageError where one is not valid."""
        self.family, self.texts = family, tuple(where)
        names = self.names = ColumnNames(family.mechanism, family.names)
        self.tests = [quantity(text, names, ("yes",), "where") for text in where]
        self.goal = quantity(goal, names, ("number",), "goal") if goal else None
        self.margins = [test for test in self.tests if test.code[-1][0] in MARGINS]
        self.goals = [self.goal] if self.goal else []
        used = frozenset[str]().union(*(q.names for q in [*self.tests, *([self.goal] if self.goal else [])]))
        if TYPE in used:
            names.check_type()
        self._reachable = REACHABLE in used
        self._last: tuple[Any, DesignColumns] | None = None

    def hold(self, designs: FloatArray, steps: int = STEPS) -> NDArray[np.bool_]:
        """Return which designs (designs,) satisfy all conditions."""
        good = np.ones(len(designs), dtype=bool)
        for test in self.tests if len(designs) else ():
            good &= np.broadcast_to(self._columns(designs, steps).of(test), len(designs))
        return good

    def admitted_goals(self, designs: FloatArray, steps: int) -> FloatArray:
        """Return the goal (designs,); NaN for designs that do not move over the whole law, or violate a condition."""
        assert self.goal is not None
        columns = self._columns(designs, steps)
        good = columns.solved.good.all(axis=1) & self.hold(designs, steps)
        goals = np.broadcast_to(np.asarray(columns.of(self.goal), dtype=float), len(designs))
        return np.where(good & np.isfinite(goals), goals, np.nan)

    def numbers(self, expressions: Sequence[Expression], designs: FloatArray) -> FloatArray:
        """Return numbers of designs (designs, expressions); NaN or infinite where they are not defined.

        The number of an inequality is by how much its bound is exceeded; negative: it is violated.
        """
        found = self._found(expressions, self._columns(designs, STEPS))
        return np.stack([np.broadcast_to(np.ravel(one), len(designs)) for one in found], axis=1)

    def slopes(self, expressions: Sequence[Expression], design: FloatArray) -> FloatArray:
        """Return the exact derivatives of numbers of a design (expressions, dimensions); NaN where there are none.

        Raises ApartError if one has none.
        """
        columns = DesignColumns(self._columns(design[None], STEPS).solved, self.names, dual=True)
        return np.array([first_of(one, len(design))[1] for one in self._found(expressions, columns)])

    def _found(self, expressions: Sequence[Expression], columns: DesignColumns) -> list[Any]:
        with np.errstate(all="ignore"):
            functions = strict(columns.lacks)
            return [one.value(columns, functions | (MARGINS if one in self.margins else {})) for one in expressions]

    def _columns(self, designs: FloatArray, steps: int) -> DesignColumns:
        key = steps, designs.shape, designs.tobytes()
        if self._last is None or self._last[0] != key:  # a design is asked for its goal, margins and derivatives
            options: dict[str, Any] = {"reachable": self._reachable, "jit": "on"}
            self._last = key, DesignColumns(self.family.solve(designs, steps, **options), self.names)
        return self._last[1]
