"""A kept quantity: an expression of columns with one value for each design, and the names that it may use."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.errors import UsageError
from gimcli.language.expression import Expression, ExpressionError, PartKind
from gimcli.language.reader import LONGEST, NAMED, ExpressionReader
from gimcli.mechanism import Mechanism
from gimcli.nearest import guess
from gimcli.positions.inputs import law_inputs
from gimcli.quantities.catalogue import Catalogue
from gimcli.quantities.forces import ForceQuantity
from gimcli.quantities.state import Needs
from gimcli.structure.drive_check import explained
from gimcli.structure.mechanism_types import mechanism_type

SOLVED, REACHABLE, TYPE = WORDS = ("solved", "reachable", "type")
"""Words: number of solved rows, their share, Grashof type of the first four-bar loop."""


class ColumnNames(Catalogue):
    """The names that are known for a mechanism and its varied dimensions."""

    what = "column, measure or dimension"

    def __init__(self, mechanism: Mechanism, dimensions: Sequence[str], by_law: bool = True) -> None:
        super().__init__(mechanism)
        self.dimensions, self._by_law = tuple(dimensions), by_law
        self.words = (*WORDS, *dimensions)
        self.used: set[str] = set()  # names in the texts of quantities that were read

    def kind(self, name: str) -> PartKind:
        """Return what a name stands for: one or several columns, or one value of a design."""
        found = super().kind(name)
        if found.what or name not in self.words:
            return found
        return PartKind("number" if name != TYPE or TYPE in self.dimensions else "text")

    def refuse_value(self, name: str, value: float) -> None:
        """Raise UsageError if a name is not an actuator, or if its law does not have the value."""
        names = [a.name for a in self.mechanism.actuators]
        if name not in names:
            raise UsageError(f"at({name}={value:g}): no actuator '{name}'; {guess(name, names)}")
        if not self._by_law:
            return
        k = names.index(name)
        law = law_inputs(self.mechanism)(np.linspace(0.0, 1.0, 1001))[k]
        low, high = self.mechanism.value_to_file(k, law).min(), self.mechanism.value_to_file(k, law).max()
        if not low - 1e-9 * (high - low) <= value <= high + 1e-9 * (high - low):
            raise UsageError(f"at({name}={value:g}): the law of {name} is {low:g} to {high:g}")

    @property
    def forced(self) -> bool:
        """Whether the names that are used need forces."""
        used = [item.quantity for name in sorted(self.used) for item in self.find(name)]
        return any(isinstance(one, ForceQuantity) or Needs(self.mechanism, [one]).forced for one in used)

    def check_type(self) -> None:
        """Raise UsageError if there is no four-bar loop, which has a Grashof type."""
        with explained(self.mechanism):
            if not any(loop.four_bar for loop in mechanism_type(self.mechanism, self.mechanism.drawn).loops):
                raise UsageError(f"type: {self.mechanism.name} has no four-bar loop with the frame")


def quantity(text: str, names: ColumnNames, kinds: tuple[str, ...] = ("number", "text"), where: str = "") -> Expression:
    """Return the quantity of a text; raise UsageError where it is no expression, or not of one of some kinds."""
    try:
        found = ExpressionReader(text, names).whole()
        if found.kind.what == "rows" and "rows" not in kinds:
            raise ExpressionError(f"the column has a value for every row; write for example min({text.strip()})")
        if found.kind.columns > 1:
            raise ExpressionError(f"it has {found.kind.columns} columns; name one of them")
        if found.kind.what not in kinds:
            example = ", such as min(P.y) > 10" if "yes" in kinds else ""
            raise ExpressionError(f"expected {NAMED[kinds[0]]}{example}, got {NAMED[found.kind.what]}")
    except (ExpressionError, UsageError) as error:
        raise UsageError(f"{where} '{text if len(text) <= LONGEST else text[:40]}': {error}".lstrip()) from None
    names.used |= found.names
    return found


def texts_of(keep: Sequence[str], names: ColumnNames) -> tuple[str, ...]:
    """Return the texts of quantities, several of which may be in one text, separated by commas."""
    found: list[str] = []
    for text in keep:
        try:
            found += ExpressionReader(text, names).texts()
        except (ExpressionError, UsageError) as error:
            raise UsageError(f"keep '{text if len(text) <= LONGEST else text[:40]}': {error}") from None
    return tuple(dict.fromkeys(" ".join(text.split()) for text in found))
