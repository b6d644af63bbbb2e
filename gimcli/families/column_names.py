"""The names that a kept quantity may use: columns of a motion, measures, varied dimensions and words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.errors import UsageError
from gimcli.language.expression import PartKind
from gimcli.measures import KINDS, measures_of
from gimcli.measures.measure import Head, Measure
from gimcli.measures.naming import guess
from gimcli.mechanism import FRAME, Mechanism
from gimcli.positions.inputs import law_inputs
from gimcli.structure.drive_check import explained
from gimcli.structure.mechanism_types import mechanism_type
from gimcli.table import per_second

SOLVED, REACHABLE, TYPE = WORDS = ("solved", "reachable", "type")
"""Words: number of solved rows, their share, Grashof type of the first four-bar loop."""

LISTED = 12
"""Number of names that the message for an unknown name lists."""

LETTERS = ("", "v", "a", "j")
TURNING = ("angle", "omega", "alpha", "jerk")


@dataclass(frozen=True)
class ColumnNeed:
    """What a column is of: a node or point and its part ("x" or "y"), a member, or an input."""

    unit: str = ""
    order: int = 0  # of derivatives
    point: str = ""
    part: str = ""
    member: int = FRAME
    actuator: int = -1


class ColumnNames:
    """The names that are known for a mechanism and its varied dimensions."""

    def __init__(self, mechanism: Mechanism, dimensions: Sequence[str], by_law: bool = True) -> None:
        self.mechanism, self.dimensions, self._by_law = mechanism, tuple(dimensions), by_law
        self.needs = _needs(mechanism)
        self._measures: dict[str, list[Measure]] = {}

    def longest(self, text: str) -> str:
        """Return the longest name with which a text begins; "" if it begins with none."""
        ends = (k for k in range(len(text), 0, -1) if not (_in_word(text[k - 1 : k]) and _in_word(text[k : k + 1])))
        return next((text[:k] for k in ends if text[k - 1] not in " \t\n(" and self.knows(text[:k])), "")

    def knows(self, name: str) -> bool:
        """Return whether a text is a name."""
        return bool(self.kind(name).what)

    def kind(self, name: str) -> PartKind:
        """Return what a name stands for: a column, or one value of a design."""
        if name in self.needs:
            return PartKind("rows", self.needs[name].unit)
        if name in self.dimensions or name in WORDS:
            return PartKind("text" if name == TYPE and name not in self.dimensions else "number")
        heads = self.heads(name)
        return PartKind("rows", heads[0].unit, len(heads)) if heads else PartKind("")

    def across(self) -> tuple[str, str]:
        """Return name and unit of the only independent input, or of the time."""
        drivers = self.mechanism.drivers
        name = self.mechanism.actuators[drivers[0]].name if len(drivers) == 1 else "time"
        return name, self.needs[name].unit

    def heads(self, name: str) -> list[Head]:
        """Return the columns of a measure, or the one with this name; an empty list if there is none."""
        word = name.partition(":")[0]
        if word not in KINDS:
            return []
        parts = name.split(".")
        for k in range(len(parts), 0, -1):
            found = self.measures(".".join(parts[:k]))
            heads = [head for measure in found for head in measure.heads]
            if k < len(parts):
                heads = [head for head in heads if head.name == name]
            if heads:
                return heads if k < len(parts) or word not in ("advantage",) else heads[:1]
        return []

    def spec(self, name: str) -> str:
        """Return the text of the measure to which a name belongs."""
        parts = name.split(".")
        specs = (".".join(parts[:k]) for k in range(len(parts), 0, -1))
        return next(spec for spec in specs if self.measures(spec))

    def measures(self, spec: str) -> list[Measure]:
        """Return the measures of a text; an empty list if it is none."""
        if spec.partition(":")[0] not in KINDS:
            return []
        if spec not in self._measures:
            try:
                self._measures[spec] = measures_of(self.mechanism, spec)
            except UsageError:
                self._measures[spec] = []
        return self._measures[spec]

    def unknown(self, name: str, rest: str = "") -> UsageError:
        """Return the error for an unknown name, with a similar one."""
        if name.partition(":")[0] in KINDS:
            try:
                measures_of(self.mechanism, name)
            except UsageError as error:
                return error
        words = [*WORDS, *self.dimensions, *KINDS, *self.needs]
        near = guess(name, words)
        if f"{name}.length" in self.dimensions:
            near = f"did you mean '{name}.length'?"
        elif f"{name}.angle" in self.needs:
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


def _in_word(letter: str) -> bool:
    return letter.isalnum() or (letter != "" and letter in "_.:")


def _needs(mechanism: Mechanism) -> dict[str, ColumnNeed]:
    """Return the numeric columns of a motion."""
    length, angle = mechanism.length_unit, mechanism.angle_unit
    needs = {"step": ColumnNeed(), "time": ColumnNeed("s"), "residual": ColumnNeed()}
    needs |= {a.name: ColumnNeed(mechanism.unit_of(a), actuator=k) for k, a in enumerate(mechanism.actuators)}
    for name in dict.fromkeys([*mechanism.traced, *(p.name for p in mechanism.points), *mechanism.nodes]):
        for order, letter in enumerate(LETTERS):
            unit = per_second(length, order) if order else length
            needs |= {f"{name}.{letter}{part}": ColumnNeed(unit, order, name, part) for part in "xy"}
    for number, member in enumerate(mechanism.members[FRAME + 1 :], FRAME + 1):
        for order, word in enumerate(TURNING):
            unit = per_second(angle, order) if order else angle
            needs[f"{member.name}.{word}"] = ColumnNeed(unit, order, member=number)
    return needs
