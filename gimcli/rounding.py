"""Numbers for people: rounded relative to the mechanism's size; files and reports for scripts have all digits.

Tables of results as texts have their first rows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gimcli.table import labelled

if TYPE_CHECKING:
    from gimcli.mechanism import Input, Mechanism
    from gimcli.table import Table

DIGITS, LEAST = 6, 4
"""Digits of a number as large as the size that it is relative to, and the fewest of any number."""

ZERO = 1e-9
"""Part of the size below which a number is zero."""

SHOWN = 10
"""Number of rows of a table that `repr` shows."""


def number(value: float, size: float = 0.0) -> str:
    """Return a number rounded relative to a size: zero below 1e-9 of it, four to six digits; "-" if not finite."""
    if not math.isfinite(value):
        return "-"
    if abs(value) <= ZERO * size or value == 0.0:
        return "0"
    digits = DIGITS
    if size > 0.0 and math.isfinite(size):
        digits = max(LEAST, DIGITS + _order(value) - _order(size))
    return f"{value:.{digits}g}"


def round_below(value: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= value * (1.0 + 1e-9))


def round_above(value: float) -> float:
    """Return the least of 1, 2, 2.5 and 5 times a power of ten that is not below a positive value, else 1."""
    power = 10.0 ** math.floor(math.log10(value)) if value > 0.0 else 1.0
    return next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if not factor * power < value * (1.0 - 1e-9))


def greatest(values: Iterable[float]) -> float:
    """Return the largest magnitude of the finite values; 0 if there are none."""
    return max((abs(value) for value in values if math.isfinite(value)), default=0.0)


def length(mechanism: Mechanism, value: float) -> str:
    """Return a coordinate or a length in the file's unit."""
    return number(value, mechanism.size * mechanism.scale)


def spaced(unit: str) -> str:
    """Return a unit after a space; nothing where lengths have no physical unit."""
    return "" if unit == "unit" else f" {unit}"


def length_with_unit(mechanism: Mechanism, value: float) -> str:
    """Return a coordinate or a length in the file's unit, and this unit."""
    return length(mechanism, value) + spaced(mechanism.length_unit)


def input_value(mechanism: Mechanism, name: str, value: float) -> str:
    """Return the value of an actuator in the file's unit."""
    return number(value, _turn(mechanism)) if _actuator(mechanism, name).rotary else length(mechanism, value)


def at_inputs(mechanism: Mechanism, inputs: Mapping[str, float]) -> str:
    """Return values of actuators by their names, with units; without those of followers, which these determine."""
    texts = (
        f"{name} = {input_value(mechanism, name, inputs[name])}{_unit(mechanism, name)}"
        for name in _independent(mechanism, inputs)
    )
    return ", ".join(texts)


def titled(mechanism: Mechanism, inputs: Mapping[str, float]) -> str:
    """Return the name of a mechanism with the values of its actuators."""
    return f"{mechanism.name} at {at_inputs(mechanism, inputs)}" if inputs else mechanism.name


def interval(mechanism: Mechanism, name: str, low: float, high: float, turns: float = 1.0) -> str:
    """Return an interval of an actuator with its unit; "full turn" where it is one or more.

    turns: of the closed curve that has the interval; 0: it is between limits, however wide it is.
    """
    if turns and _actuator(mechanism, name).rotary and abs(high - low) >= _turn(mechanism) * (1.0 - ZERO):
        return "full turn"
    low_text, high_text = (input_value(mechanism, name, value) for value in (low, high))
    return f"{low_text} to {high_text}{_unit(mechanism, name)}"


def intervals(mechanism: Mechanism, spans: Mapping[str, Sequence[float]], turns: float, between: str = ", ") -> str:
    """Return intervals of actuators by their names, without those of followers; `turns`: as for `interval`."""
    named = ((name, spans[name]) for name in _independent(mechanism, spans))
    return between.join(f"{name}: {interval(mechanism, name, low, high, turns)}" for name, (low, high) in named)


def how_it_ends(closed: bool, ended: str, turns: float) -> str:
    """Return whether a circuit is closed, after how many turns, or what ends it."""
    after = f" after {abs(turns):g} turn{'s' * (abs(turns) != 1)}" if turns else ""
    return f"closed{after}" if closed else ended


def _independent(mechanism: Mechanism, names: Iterable[str]) -> list[str]:
    """Return the names without those of actuators that follow others."""
    followers = {mechanism.actuators[coupling.follower].name for coupling in mechanism.couplings}
    return [name for name in names if name not in followers]


def _order(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _turn(mechanism: Mechanism) -> float:
    return 360.0 if mechanism.angle_unit == "deg" else 2.0 * math.pi


def _unit(mechanism: Mechanism, name: str) -> str:
    """Return the unit of an actuator after a space."""
    return spaced(mechanism.unit_of(_actuator(mechanism, name)))


def _actuator(mechanism: Mechanism, name: str) -> Input:
    return next(a for a in mechanism.actuators if a.name == name)


def cells(table: Table) -> list[list[str]]:
    """Return the head and the first rows of a table as texts, and a row of dots if there are more."""
    head = [labelled(c.name, c.unit) for c in table.columns]
    columns = []
    for column in table.columns:
        size = greatest(column.values.tolist()) if column.values.dtype.kind == "f" else 0.0
        columns.append([_cell(value, size) for value in column.values[:SHOWN].tolist()])
    rows = [list(row) for row in zip(*columns, strict=True)]
    return [head, *rows, *([["..."] * len(head)] if len(table) > SHOWN else [])]


def lines(table: Table) -> list[str]:
    """Return the head and the first rows of a table as aligned lines."""
    return aligned(cells(table), str.rjust)


def aligned(rows: Sequence[Sequence[str]], place: Callable[[str, int], str] = str.ljust) -> list[str]:
    """Return rows of texts as lines with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(place(text, width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]


@dataclass(frozen=True)
class Section:
    """A part of a report as texts: a heading, the names and the first rows of columns, how many are left out, warnings.

    Nothing stands above the columns if all names are empty.
    """

    heading: str
    head: tuple[str, ...] = ()
    rows: Sequence[tuple[str, ...]] = ()
    left_out: int = 0
    warnings: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """Return head and rows in aligned columns."""
        return aligned([*([self.head] if any(self.head) else []), *self.rows])


def _cell(value: Any, size: float) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else number(value, size)
    return str(value)
