"""The text of a kept quantity: arithmetic of columns, reduced to one number for each design.

    min(COLUMN)  max  range  mean  rms      of the solved rows; COLUMN may be arithmetic of columns
    at(COLUMN, motor=30)                    at the first position with this value of an input
    NAME                                    solved, reachable, type, or a varied dimension
    + - * / **  < <= > >= == !=  and or not  FUNCTION(...)  "text"

Names of a model may contain signs. The longest text that is a known name is read as a name.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from gimcli.errors import UsageError
from gimcli.families.column_names import ColumnNames
from gimcli.mechanism import FloatArray

MOST_LETTERS, MOST_LEVELS = 1000, 50
"""Largest length of a text, and of its brackets inside one another."""

REDUCTIONS = ("min", "max", "range", "mean", "rms")
"""Reductions of the rows of a column to one number."""

FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": np.abs, "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2, "hypot": np.hypot,
    "radians": np.radians, "degrees": np.degrees,
}  # fmt: skip
"""Functions of numbers; angles in rad."""

TWO = ("atan2", "hypot")
"""Functions of two numbers."""

OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "**": np.power, "<": np.less,
    "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "==": np.equal, "!=": np.not_equal,
}  # fmt: skip

NUMBER = re.compile(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
WORD = re.compile(r"[^\W\d]\w*")
NAMED = re.compile(r"[a-z]+:[^\s()+*<>=!,]+|[^\s()+*/<>=!,]+")


class Values(Protocol):
    """The values of names for some designs."""

    def rows(self, name: str) -> FloatArray:
        """Return a column, or the columns of a measure (designs, rows, columns)."""

    def number(self, name: str) -> Any:
        """Return a number or a text of each design (designs,)."""

    def at(self, actuator: str, value: float) -> Values:
        """Return the values at one position: where an input first has a value [file's unit]."""


@dataclass(frozen=True)
class QuantityPart:
    """A part of a quantity; `kind` is "rows", "number", "text" or "yes" (true or false)."""

    kind: str
    find: Callable[[Values], Any]
    unit: str = ""
    names: frozenset[str] = frozenset()
    columns: int = 1


@dataclass(frozen=True)
class KeptQuantity:
    """One value of each design, as it is written."""

    text: str
    part: QuantityPart

    @property
    def names(self) -> frozenset[str]:
        """The names that it uses."""
        return self.part.names

    @property
    def kind(self) -> str:
        """The kind: "number", "text" or "yes"."""
        return self.part.kind

    @property
    def unit(self) -> str:
        """The unit; "" if it has none, or if it is not known."""
        return self.part.unit

    def values(self, values: Values) -> Any:
        """Return the value of each design (designs,); NaN where it is not defined.

        A condition is True only where all values that decide it are defined.
        """
        with np.errstate(all="ignore"):
            found = self.part.find(values)
            if self.kind == "yes":
                return np.equal(found, 1.0)
            return found if self.kind == "text" else np.where(np.isfinite(found), found, np.nan)


def quantity(
    text: str, names: ColumnNames, kinds: tuple[str, ...] = ("number", "text"), where: str = ""
) -> KeptQuantity:
    """Return the quantity of a text; raise UsageError where it is not of the form above."""
    reader = _QuantityReader(text, names, where)
    part = reader.whole()
    if part.kind == "rows":
        raise reader.error(f"the column has a value for every row; write for example min({text.strip()})")
    if part.kind not in kinds:
        expected = "a comparison, such as min(P.y) > 10" if "yes" in kinds else "a number"
        raise reader.error(f"expected {expected}")
    return KeptQuantity(" ".join(text.split()), part)


class _QuantityReader:
    """Reads the text from left to right, one method for each level of precedence."""

    def __init__(self, text: str, names: ColumnNames, where: str) -> None:
        self.text, self.names, self.where, self.place, self.level = text, names, where, 0, 0

    def error(self, what: str) -> UsageError:
        return UsageError(f"{self.where} '{self.text}': {what}".lstrip())

    def whole(self) -> QuantityPart:
        if len(self.text) > MOST_LETTERS:
            raise UsageError(f"{self.where}: a text of {len(self.text)} letters; at most {MOST_LETTERS} are possible")
        found = self.either()
        if self._rest():
            rest = self._rest()
            hint = "; the sign of equality is ==" if rest.startswith("=") else ""
            raise self.error(f"expected the end or an operator, got '{rest}'{hint}")
        return found

    def either(self) -> QuantityPart:
        return self._chain(self.both, ("or",), "yes")

    def both(self) -> QuantityPart:
        return self._chain(self.negation, ("and",), "yes")

    def negation(self) -> QuantityPart:
        if not self._takes("not"):
            return self.comparison()
        part = self._of_kind(self.negation(), "yes")
        return QuantityPart("yes", lambda v: 1.0 - part.find(v), names=part.names)

    def comparison(self) -> QuantityPart:
        first = self.sum()
        sign = next((s for s in ("<=", ">=", "==", "!=", "<", ">") if self._takes(s)), "")
        if not sign:
            return first
        second = self.sum()
        if "text" in (first.kind, second.kind):
            if first.kind != second.kind or sign not in ("==", "!="):
                raise self.error("a text can only be compared with a text, by == or !=")
        else:
            first, second = self._of_kind(first, "number"), self._of_kind(second, "number")
        return QuantityPart("yes", _compared(sign, first, second), names=first.names | second.names)

    def sum(self) -> QuantityPart:
        return self._chain(self.product, ("+", "-"))

    def product(self) -> QuantityPart:
        return self._chain(self.signed, ("*", "/"))

    def signed(self) -> QuantityPart:
        if self._takes("-"):
            part = self._numeric(self._deeper(self.signed))
            return QuantityPart(part.kind, lambda v: np.negative(part.find(v)), part.unit, part.names, part.columns)
        return self._deeper(self.signed) if self._takes("+") else self.power()

    def power(self) -> QuantityPart:
        base = self.atom()
        return self._pair("**", base, self._deeper(self.signed)) if self._takes("**") else base

    def atom(self) -> QuantityPart:
        rest = self._rest()
        name = self._name()
        if name:
            return self._named(name)
        number, word = NUMBER.match(rest), WORD.match(rest)
        if number is not None:
            self.place += number.end()
            value = float(number[0])
            return QuantityPart("number", lambda _: value)
        if rest[:1] in ("'", '"') and rest[0] in rest[1:]:
            text = rest[1 : rest.index(rest[0], 1)]
            self.place += len(text) + 2
            return QuantityPart("text", lambda _: text)
        if self._takes("("):
            found = self._deeper(self.either)
            self._need(")")
            return found
        if word is not None and rest[word.end() :].lstrip()[:1] == "(":
            self.place += word.end()
            return self._deeper(lambda: self._call(word[0]))
        if word is not None and word[0] == "pi":
            self.place += 2
            return QuantityPart("number", lambda _: math.pi)
        other = NAMED.match(rest)
        if other is not None:
            raise self.error(str(self.names.unknown(other[0])))
        raise self.error(f"expected a name or number, got {_quoted(rest)}")

    def _call(self, word: str) -> QuantityPart:
        if word not in (*REDUCTIONS, "at", *FUNCTIONS):
            known = ", ".join((*REDUCTIONS, "at", *FUNCTIONS))
            raise self.error(f"no function '{word}'; known: {known}")
        self._need("(")
        first = self._numeric(self.sum())
        if word == "at":
            return self._at(first)
        if word in REDUCTIONS:
            found = self._reduced(word, first)
        elif word in TWO:
            self._need(",")
            found = self._joined(first, self._numeric(self.sum()), FUNCTIONS[word])
        else:
            unit = first.unit if word == "abs" else ""
            find = FUNCTIONS[word]
            found = QuantityPart(first.kind, lambda v: find(first.find(v)), unit, first.names, first.columns)
        self._need(")")
        return found

    def _reduced(self, word: str, part: QuantityPart) -> QuantityPart:
        if part.kind != "rows":
            raise self.error(f"{word}() takes a column, such as {word}(P.y)")
        if part.columns != 1 and word not in ("min", "max"):
            raise self.error(f"{word}() takes one column, but a measure here has {part.columns}; name one of them")
        reduction = _REDUCED[word]
        return QuantityPart("number", lambda v: reduction(part.find(v)), part.unit, part.names)

    def _at(self, part: QuantityPart) -> QuantityPart:
        if part.kind != "rows":
            raise self.error("at() takes a column, such as at(P.y, motor=30)")
        if part.columns != 1:
            raise self.error(f"at() takes one column, but a measure here has {part.columns}; name one of them")
        self._need(",")
        actuator, equals, _ = self._rest().partition("=")
        if not equals:
            raise self.error("at() needs the value of an input, such as at(P.y, motor=30)")
        self.place += len(actuator) + 1
        sign = -1.0 if self._takes("-") else 1.0
        number = NUMBER.match(self._rest())
        if number is None:
            raise self.error(f"expected a number after '{actuator.strip()}='")
        self.place += number.end()
        self._need(")")
        name, value = actuator.strip(), sign * float(number[0])
        try:
            self.names.check_input(name, value)
        except UsageError as error:
            raise self.error(str(error)) from None
        return QuantityPart("number", lambda v: part.find(v.at(name, value))[:, 0, 0], part.unit, part.names)

    def _named(self, name: str) -> QuantityPart:
        self.place += len(name)
        kind, unit = self.names.kind(name), self.names.unit(name)
        if kind == "rows":
            return QuantityPart("rows", lambda v: v.rows(name), unit, frozenset({name}), self.names.columns(name))
        return QuantityPart(kind, lambda v: v.number(name), unit, frozenset({name}))

    def _chain(self, inner: Callable[[], QuantityPart], signs: tuple[str, ...], kind: str = "") -> QuantityPart:
        found = inner()
        while sign := next((s for s in signs if self._takes(s)), ""):
            second = inner()
            if kind:
                first, second = self._of_kind(found, kind), self._of_kind(second, kind)
                found = QuantityPart(kind, _joint(sign, first, second), names=first.names | second.names)
            else:
                found = self._pair(sign, found, second)
        return found

    def _pair(self, sign: str, first: QuantityPart, second: QuantityPart) -> QuantityPart:
        return self._joined(self._numeric(first), self._numeric(second), OPERATORS[sign], sign in ("+", "-"))

    def _joined(
        self, first: QuantityPart, second: QuantityPart, find: Callable[..., Any], alike: bool = False
    ) -> QuantityPart:
        if 1 not in (first.columns, second.columns):
            raise self.error("two measures of several columns cannot be combined; name their columns")
        kind = "rows" if "rows" in (first.kind, second.kind) else "number"
        unit = first.unit if alike and first.unit == second.unit else ""
        columns = max(first.columns, second.columns)

        def found(values: Values) -> Any:
            one, two = first.find(values), second.find(values)
            if first.kind != second.kind:  # a number of each design with a column
                one, two = (_column(x) if p.kind == "number" else x for x, p in ((one, first), (two, second)))
            return find(one, two)

        return QuantityPart(kind, found, unit, first.names | second.names, columns)

    def _numeric(self, part: QuantityPart) -> QuantityPart:
        if part.kind not in ("number", "rows"):
            raise self.error(f"expected a number, got {'a text' if part.kind == 'text' else 'a comparison'}")
        return part

    def _of_kind(self, part: QuantityPart, kind: str) -> QuantityPart:
        if part.kind == "rows":
            raise self.error("a column has a value for every row; write for example min(COLUMN)")
        if part.kind != kind:
            raise self.error("expected a comparison" if kind == "yes" else "expected a number")
        return part

    def _deeper(self, read: Callable[[], QuantityPart]) -> QuantityPart:
        self.level += 1
        if self.level > MOST_LEVELS:
            raise self.error(f"more than {MOST_LEVELS} brackets or signs inside one another")
        found = read()
        self.level -= 1
        return found

    def _name(self) -> str:
        """Return the longest known name that begins here; "" if there is none."""
        rest = self._rest()
        for end in range(len(rest), 0, -1):
            ends = end == len(rest) or not (_is_word(rest[end - 1]) and _is_word(rest[end]))
            if ends and rest[end - 1] not in " \t\n(" and self.names.kind(rest[:end]):
                return rest[:end]
        return ""

    def _takes(self, sign: str) -> bool:
        """Skip a sign or a word that begins here; return whether it was skipped."""
        rest = self._rest()
        word = WORD.match(rest)
        longer = sign.isalpha() and word is not None and word[0] != sign
        if not rest.startswith(sign) or longer or (sign == "*" and rest.startswith("**")):
            return False
        self.place += len(sign)
        return True

    def _need(self, sign: str) -> None:
        if not self._takes(sign):
            raise self.error(f"expected '{sign}', got {_quoted(self._rest())}")

    def _rest(self) -> str:
        while self.place < len(self.text) and self.text[self.place].isspace():
            self.place += 1
        return self.text[self.place :]


def _quoted(rest: str) -> str:
    return f"'{rest}'" if rest else "the end"


def _is_word(sign: str) -> bool:
    return sign.isalnum() or sign in "_.:"


def _column(number: Any) -> Any:
    """Return numbers (designs,) as a column with one row."""
    return number[:, None, None] if isinstance(number, np.ndarray) else number


def _compared(sign: str, first: QuantityPart, second: QuantityPart) -> Callable[[Values], Any]:
    """Return a comparison: 1 for true, 0 for false, NaN where a side is not defined."""

    def found(values: Values) -> Any:
        one, two = first.find(values), second.find(values)
        known = first.kind == "text" or np.isfinite(one) & np.isfinite(two)
        return np.where(known, OPERATORS[sign](one, two), np.nan)

    return found


def _joint(sign: str, first: QuantityPart, second: QuantityPart) -> Callable[[Values], Any]:
    """Return two conditions joined by `and` or `or` (Kleene's logic): a side that decides alone needs no other."""
    decides = float(sign == "or")

    def found(values: Values) -> Any:
        one, two = first.find(values), second.find(values)
        return np.where((one == decides) | (two == decides), decides, one * two)

    return found


def least(rows: FloatArray) -> FloatArray:
    """Return the least finite value of each design (designs,)."""
    return np.asarray(np.fmin.reduce(np.fmin.reduce(rows, axis=2), axis=1))


def greatest(rows: FloatArray) -> FloatArray:
    """Return the greatest value of each design (designs,)."""
    return np.asarray(np.fmax.reduce(np.fmax.reduce(rows, axis=2), axis=1))


def _known(values: Any) -> Any:
    """Return which values are finite; dual numbers are always known."""
    return np.isfinite(values) if values.dtype.kind == "f" else np.ones(values.shape, dtype=bool)


def mean(rows: FloatArray) -> FloatArray:
    """Return the mean of the rows that have a value (designs,)."""
    known = _known(rows[:, :, 0])
    return np.asarray(np.where(known, rows[:, :, 0], 0.0).sum(axis=1) / known.sum(axis=1))


_REDUCED: dict[str, Callable[[FloatArray], FloatArray]] = {
    "min": least, "max": greatest, "range": lambda rows: greatest(rows) - least(rows), "mean": mean,
    "rms": lambda rows: np.sqrt(mean(rows**2)),
}  # fmt: skip
