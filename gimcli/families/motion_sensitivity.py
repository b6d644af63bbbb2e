"""Derivatives of numbers of a whole motion, such as range(P.y): expressions of columns, in dual numbers.

By the envelope theorem, the derivative of a least or greatest value is that of the quantity in the row of this value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.dual import Dual, first_of
from gimcli.canonical import TURN
from gimcli.errors import UsageError
from gimcli.families.design_sensitivity import QuantitySlopes
from gimcli.families.design_state import position_items
from gimcli.families.quantity_text import ColumnNames, quantity
from gimcli.language.arrays import ARRAYS
from gimcli.language.expression import Expression
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.quantities.quantity import Item
from gimcli.rates.derivatives import ORDERS


class MotionNumber(NamedTuple):
    """A number of a whole motion, and the quantities of its columns: their places in a list of all."""

    kept: Expression
    columns: Mapping[str, Sequence[int]]

    def with_slopes(self, items: Sequence[Item], rows: QuantitySlopes) -> tuple[float, FloatArray]:
        """Return the number and its derivatives (dimensions,) from the solved rows of a motion."""
        columns: dict[str, Any] = {}
        for name, places in self.columns.items():
            found = [_column(items[k], rows.values[k], rows.slopes[k]) for k in places]
            columns[name] = np.stack(found) if len(found) > 1 else found[0]
        with np.errstate(all="ignore"):
            return first_of(self.kept.value(columns, ARRAYS), rows.slopes.shape[1])


def _column(item: Item, values: FloatArray, slopes: FloatArray) -> Any:
    """Return a column of one motion in dual numbers (1, rows)."""
    if item.quantity.circular:
        values = np.unwrap(values, period=360.0 if item.head.unit == "deg" else TURN)
    return Dual(values[None], slopes[:, None])


def motion_number(mechanism: Mechanism, text: str, items: list[Item]) -> MotionNumber:
    """Return the number of a motion that a text describes; the quantities of its columns are added to the list.

    Raises UsageError for another text, or for columns without exact derivatives, such as velocities.
    """
    kept, columns = quantity(text, _RowNames(mechanism, ()), ("number",), "of"), dict[str, list[int]]()
    for name in sorted(kept.names):
        own = position_items(mechanism, name, len(ORDERS))
        columns[name] = list(range(len(items), len(items) + len(own)))
        items += own
    return MotionNumber(kept, columns)


class _RowNames(ColumnNames):
    """The names of columns of all rows."""

    def refuse_value(self, name: str, value: float) -> None:
        """Raise UsageError: a position is requested by its input value."""
        super().refuse_value(name, value)
        raise UsageError(
            f"at({name}={value:g}) is not possible here; ask for the column in the position {name}={value:g}"
        )
