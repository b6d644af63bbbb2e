"""The names that a kept quantity may use: quantities of a motion, varied dimensions and words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.errors import UsageError
from gimcli.language.expression import PartKind
from gimcli.language.reader import longest
from gimcli.mechanism import Mechanism
from gimcli.positions.inputs import law_inputs
from gimcli.quantities import KINDS, quantities_of
from gimcli.quantities.catalogue import catalogue
from gimcli.quantities.naming import guess
from gimcli.structure.drive_check import explained
from gimcli.structure.mechanism_types import mechanism_type

SOLVED, REACHABLE, TYPE = WORDS = ("solved", "reachable", "type")
"""Words: number of solved rows, their share, Grashof type of the first four-bar loop."""

LISTED = 12
"""Number of names that the message for an unknown name lists."""


class ColumnNames:
    """The names that are known for a mechanism and its varied dimensions."""

    def __init__(self, mechanism: Mechanism, dimensions: Sequence[str], by_law: bool = True) -> None:
        self.mechanism, self.dimensions, self._by_law = mechanism, tuple(dimensions), by_law
        self.catalogue = catalogue(mechanism)

    def longest(self, text: str) -> str:
        """Return the longest name with which a text begins; "" if it begins with none."""
        return longest(text, lambda name: self.kind(name).what)

    def kind(self, name: str) -> PartKind:
        """Return what a name stands for: one or several columns, or one value of a design."""
        items = self.catalogue.find(name)
        if items:
            return PartKind("rows", items[0].head.unit, len(items))
        known = name in (*self.dimensions, *WORDS)
        return PartKind(("number" if name != TYPE or TYPE in self.dimensions else "text") if known else "")

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
        words = [*WORDS, *self.dimensions, *KINDS, *self.catalogue.columns]
        near = guess(name, words)
        if f"{name}.length" in self.dimensions:
            near = f"did you mean '{name}.length'?"
        elif name in self.catalogue.members:
            near = f"did you mean '{name}.angle'?"
        if near.startswith("known:"):
            near = f"known: {', '.join(words[:LISTED])}, ..."
        return UsageError(f"no column, measure or dimension '{name}'; {near}")

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

    def check_type(self) -> None:
        """Raise UsageError if there is no four-bar loop, which has a Grashof type."""
        with explained(self.mechanism):
            if not any(loop.four_bar for loop in mechanism_type(self.mechanism, self.mechanism.drawn).loops):
                raise UsageError(f"type: {self.mechanism.name} has no four-bar loop with the frame")
