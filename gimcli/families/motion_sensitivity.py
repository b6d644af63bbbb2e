"""Derivatives of numbers of a whole motion, such as range(P.y): expressions of columns, in dual numbers.

By the envelope theorem, the derivative of a least or greatest value is that of the quantity in the row of this value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual, first_of
from gimcli.canonical import TURN
from gimcli.errors import UsageError
from gimcli.families.design_sensitivity import QuantitySlopes
from gimcli.families.design_state import position_items
from gimcli.families.quantity_text import TYPE, ColumnNames, KeptQuantity, quantity
from gimcli.language.arrays import ARRAYS
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.quantities.quantity import Item
from gimcli.rates.derivatives import ORDERS


@dataclass(frozen=True)
class MotionNumber:
    """A number of a whole motion, and the quantities of its columns: their places in a list of all."""

    kept: KeptQuantity
    columns: Mapping[str, Sequence[int]]

    @property
    def name(self) -> str:
        """The text, such as max(P.y)."""
        return self.kept.text

    @property
    def unit(self) -> str:
        """The unit; "" if it has none or it is not known."""
        return self.kept.unit

    def with_slopes(self, items: Sequence[Item], rows: QuantitySlopes) -> tuple[float, FloatArray]:
        """Return the number and its derivatives (dimensions,) from the solved rows of a motion."""
        with np.errstate(all="ignore"):
            found = self.kept.expression.value(_DualColumns(self, items, rows), ARRAYS)
        return first_of(found, rows.slopes.shape[1])


class _DualColumns:
    """The columns of one motion in dual numbers."""

    def __init__(self, own: MotionNumber, items: Sequence[Item], rows: QuantitySlopes) -> None:
        self._own, self._items, self._rows = own, items, rows

    def __getitem__(self, name: str) -> Any:
        """Return a column (1, rows), or those of a measure (columns, 1, rows); raise UsageError for other names."""
        if name not in self._own.columns:
            raise UsageError(f"of '{self._own.name}': '{name}' has no derivatives; use columns such as P.y")
        columns = []
        for k in self._own.columns[name]:
            values, one = self._rows.values[k], self._items[k]
            if one.quantity.circular:
                values = np.unwrap(values, period=360.0 if one.head.unit == "deg" else TURN)
            columns.append(Dual(values[None], self._rows.slopes[k][:, None]))
        return np.stack(columns) if len(columns) > 1 else columns[0]

    def at(self, actuator: str, value: float) -> Any:
        """Raise UsageError: a position is requested by its input value."""
        raise UsageError(
            f"of '{self._own.name}': at({actuator}={value:g}) is not possible here; ask for the column in the"
            f" position {actuator}={value:g}"
        )


def motion_number(mechanism: Mechanism, text: str, items: list[Item]) -> MotionNumber:
    """Return the number of a motion that a text describes; the quantities of its columns are added to the list.

    Raises UsageError for another text, or for columns without exact derivatives, such as velocities.
    """
    kept = quantity(text, ColumnNames(mechanism, ()), ("number",), "of")
    columns: dict[str, list[int]] = {}
    for name in sorted(kept.names):
        if name == TYPE:
            continue
        own = position_items(mechanism, name, len(ORDERS))
        columns[name] = list(range(len(items), len(items) + len(own)))
        items += own
    return MotionNumber(kept, columns)
