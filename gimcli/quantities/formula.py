"""Expressions as quantities, such as `hypot(P.x - 50, P.y)`, and the names that expressions may use."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.language.arrays import ARRAYS
from gimcli.language.expression import Expression, ExpressionError, PartKind
from gimcli.language.reader import ExpressionReader, longest
from gimcli.mechanism import Mechanism
from gimcli.quantities.catalogue import Catalogue, catalogue
from gimcli.quantities.kinds import KINDS, quantities_of
from gimcli.quantities.naming import guess
from gimcli.quantities.quantity import Head, Quantity
from gimcli.quantities.state import State

LISTED = 12
"""Number of names that the message for an unknown name lists."""


class QuantityNames:
    """The quantities of a mechanism as names of expressions."""

    what = "column or measure"

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.catalogue = mechanism, catalogue(mechanism)

    @property
    def words(self) -> list[str]:
        """Names that come first in a message."""
        return []

    def longest(self, text: str) -> str:
        """Return the longest name with which a text begins; "" if it begins with none."""
        return longest(text, lambda name: self.kind(name).what)

    def kind(self, name: str) -> PartKind:
        """Return what a name stands for: one or several columns."""
        items = self.catalogue.find(name)
        return PartKind("rows", items[0].head.unit, len(items)) if items else PartKind("")

    def across(self) -> tuple[str, str]:
        """Return name and unit of the only independent input, or of the time."""
        drivers = self.mechanism.drivers
        name = self.mechanism.actuators[drivers[0]].name if len(drivers) == 1 else "time"
        return name, self.catalogue.rows[name]

    def unknown(self, name: str, rest: str = "") -> UsageError:
        """Return the error for an unknown name, with a similar one."""
        if name.partition(":")[0] in KINDS:
            try:
                quantities_of(self.mechanism, name)
            except UsageError as error:
                return error
        words = [*self.words, *KINDS, *self.catalogue.columns]
        near = guess(name, words)
        if f"{name}.length" in self.words:
            near = f"did you mean '{name}.length'?"
        elif name in self.catalogue.members:
            near = f"did you mean '{name}.angle'?"
        if near.startswith("known:"):
            near = f"known: {', '.join(words[:LISTED])}, ..."
        return UsageError(f"no {self.what} '{name}'; {near}")

    def refuse_value(self, name: str, value: float) -> None:
        """Raise UsageError: a column has all rows."""
        raise UsageError(f"at({name}={value:g}) is one row; a column has all of them")


class Formula(Quantity):
    """An expression of columns, with one value for each row."""

    def __init__(self, known: Catalogue, expression: Expression, name: str = "") -> None:
        self.known, self.expression, self.spec = known, expression, name or expression.text
        self.heads = (Head(self.spec, expression.kind.unit or "", self.spec),)

    def values(self, state: State) -> Sequence[Any]:
        """Return the value of each row."""
        with np.errstate(all="ignore"):
            return [self.expression.value(_Values(self.known, state), ARRAYS)]


class _Values:
    """The values of names in a state."""

    def __init__(self, known: Catalogue, state: State) -> None:
        self.known, self.state = known, state

    def __getitem__(self, name: str) -> Any:
        found = [self.state.value(*item) for item in self.known.find(name)]
        return np.stack(found) if len(found) > 1 else found[0]


def formula(mechanism: Mechanism, text: str, name: str = "", where: str = "measure") -> Formula:
    """Return the quantity of an expression; raise UsageError where it is none, or has no value for each row."""
    try:
        found = ExpressionReader(text, QuantityNames(mechanism)).whole()
        if found.kind.what != "rows" or any(
            isinstance(i, tuple) and str(i[0]).endswith(" of rows") for i in found.code
        ):
            raise ExpressionError("expected a column, with a value for each row, such as hypot(P.x, P.y)")
    except (ExpressionError, UsageError) as error:
        raise UsageError(str(error) if str(error).startswith(where) else f"{where} '{text}': {error}") from None
    return Formula(catalogue(mechanism), found, name)


def asked(mechanism: Mechanism, text: str) -> Sequence[Quantity]:
    """Return the quantities of a text: a kind such as "centre:rod/rocker", a name, or an expression.

    Raises UsageError for other texts.
    """
    found = dict.fromkeys(item.quantity for item in catalogue(mechanism).find(text))
    return list(found) or [formula(mechanism, text)]
