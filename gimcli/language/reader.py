"""Reads an expression from left to right, by the precedence of its operators."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from gimcli.errors import refuse
from gimcli.language.expression import CONSTANTS, FUNCTIONS, REDUCES, REDUCTIONS, Expression, ExpressionError, PartKind

LONGEST, DEEPEST = 1000, 50
"""Most characters of a text, and most brackets, signs and powers inside one another."""

COMPARISONS = ("<=", ">=", "==", "!=", "<", ">")
NOT, SIGN, POWER = 3, 7, 8
PRECEDENCE = {
    "or": 1, "and": 2, **dict.fromkeys(COMPARISONS, 4), "+": 5, "-": 5, "**": POWER, "*": 6, "/": 6,
}  # fmt: skip
"""The precedence of operators between two operands."""

OPERATOR = re.compile(r"\s*(or\b|and\b|<=|>=|==|!=|<|>|\+|-|\*\*|\*|/)")

DIGITS = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
NUMBER, SIGNED, WORD = re.compile(DIGITS), re.compile(rf"\s*[-+]?{DIGITS}\s*"), re.compile(r"[^\W\d]\w*")
CALLED = re.compile(rf"({WORD.pattern})\s*\(")
OTHER = re.compile(r"[a-z]+:[^\s()+*<>=!,|]+|[^\W\d][^\s()+*/<>=!,|-]*")
"""A word that is no name."""


class KnownNames(ABC):
    """The names that an expression may use."""

    def longest(self, text: str) -> str:
        """Return the longest name with which a text begins; "" if it begins with none."""
        return longest(text, lambda name: self.kind(name).what)

    @abstractmethod
    def kind(self, name: str) -> PartKind:
        """Return what a name stands for."""

    def code(self, name: str) -> Sequence[Any]:
        """Return the code of a name: the name itself, or the expression that it is short for."""
        return (name,)

    @abstractmethod
    def unknown(self, word: str, rest: str) -> Exception:
        """Return the error for a word that is no name; `rest` is the text from it on."""

    def across(self) -> tuple[str, str]:
        """Return name and unit of the variable of integrals: the only input, or the time; empty without rows."""
        return "", ""

    def refuse_value(self, actuator: str, value: float) -> None:  # noqa: B027  # without rows there are none
        """Raise an error if a name is no input, or if the input does not have the value."""


def longest(text: str, knows: Callable[[str], Any]) -> str:
    """Return the longest name with which a text begins, not in the middle of a word; "" if it begins with none."""
    ends = (k for k in range(len(text), 0, -1) if not (_in_word(text[k - 1 : k]) and _in_word(text[k : k + 1])))
    return next((text[:k] for k in ends if text[k - 1] not in " \t\n(" and knows(text[:k])), "")


def _in_word(letter: str) -> bool:
    return letter.isalnum() or (letter != "" and letter in "_.:")


_refuse = partial(refuse, error=ExpressionError)

NAMED = {"text": "a text", "yes": "a comparison", "rows": "a column", "number": "a number"}


class ExpressionReader:
    """Reads a text from left to right, by the precedence of its operators."""

    def __init__(self, text: str, names: KnownNames) -> None:
        _refuse((len(text) > LONGEST, f"{len(text)} characters are too many; at most {LONGEST} are read"))
        self.text, self.names = text, names
        self.place = self.depth = 0
        self.code: list[Any] = []

    def whole(self) -> Expression:
        """Return the expression of the whole text; raise ExpressionError where it is none."""
        kind = self.operation()
        self.end()
        return Expression(" ".join(self.text.split()), tuple(self.code), kind)

    def texts(self) -> list[str]:
        """Return the texts of expressions that are separated by commas; raise ExpressionError where they are none."""
        found, start = list[str](), 0
        while True:
            self.operation()
            found.append(self.text[start : self.place].strip())
            if not self.takes(","):
                self.end()
                return found
            start = self.place

    def end(self) -> None:
        """Raise ExpressionError if there is more text."""
        if self.rest():
            hint = "; the sign of equality is ==" if self.rest()[0] == "=" else ""
            hint = "; write ** for a power" if self.rest()[0] == "^" else hint
            raise ExpressionError(f"expected the end or an operator, got {self._got()}{hint}")

    def operand(self) -> Expression:
        """Return the next number, name, function, amount, or expression in brackets, for texts that join such."""
        self.rest()
        self.code, start = [], self.place
        kind = self._numeric(self._signed())
        return Expression(self.text[start : self.place].strip(), tuple(self.code), kind)

    def operation(self, least: int = 0) -> PartKind:
        """Read operands that are joined by operators of at least some precedence."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise ExpressionError(f"nested too deeply: more than {DEEPEST} brackets or signs inside one another")
        found = self._signed()
        while (sign := OPERATOR.match(self.text, self.place)) and PRECEDENCE[sign[1]] >= least:
            self.place = sign.end()
            second = self.operation(SIGN if sign[1] == "**" else PRECEDENCE[sign[1]] + 1)
            found = self._joined(sign[1], found, second)
        self.depth -= 1
        return found

    def _signed(self) -> PartKind:
        rest = self.rest()
        if rest.startswith("not") and not self.names.longest(rest) and self.takes("not"):
            self._expect(self.operation(NOT), "yes")
            return self._applied("not", 1, PartKind("yes"))
        if rest[:1] not in ("+", "-"):
            return self._operand(rest)
        negative = not self.takes("+") and self.takes("-")
        found = self._numeric(self.operation(SIGN))
        return self._applied("negative", 1, found) if negative else found

    def _operand(self, rest: str) -> PartKind:
        name, called = self.names.longest(rest), CALLED.match(rest)
        if called is not None and (not name or called[1] == name):
            self.place += called.end(1)
            return self._call(called[1])
        if name:
            code = self.names.code(name)
            self.code += code[:-1]
            return self._pushed(name, code[-1], self.names.kind(name))
        number = NUMBER.match(rest)
        if number is not None:
            return self._pushed(number[0], float(number[0]), PartKind("number", None))
        if rest[:1] in ("'", '"') and rest[0] in rest[1:]:
            text = rest[1 : rest.index(rest[0], 1)]
            return self._pushed(f"'{text}'", ("text", text), PartKind("text"))
        if self.takes("("):
            return self._closed(self.operation(), ")")
        if self.takes("|"):
            return self._amount(self._closed(self._numeric(self.operation()), "|"))
        word = WORD.match(rest)
        if word is not None and word[0] in CONSTANTS:
            return self._pushed(word[0], CONSTANTS[word[0]], PartKind("number", None))
        other = OTHER.match(rest)
        if other is not None:
            raise self.names.unknown(other[0], rest)
        raise ExpressionError(f"expected a name or number, got {self._got()}")

    def _amount(self, kind: PartKind) -> PartKind:
        if kind.columns > 2:
            raise ExpressionError(
                "| | takes a number or a vector, but a measure here has more columns; name one of them"
            )
        return self._applied("hypot of columns" if kind.columns == 2 else "abs", 1, kind._replace(columns=1))

    def _call(self, word: str) -> PartKind:
        if word not in (*REDUCTIONS, "at", *FUNCTIONS):
            known = ", ".join(dict.fromkeys((*REDUCTIONS, "at", *FUNCTIONS)))
            raise ExpressionError(f"no function '{word}'; known: {known}")
        self.need("(")
        start = len(self.code)
        kinds = [self._numeric(self.operation())]
        if word == "at":
            return self._at(start, kinds[0])
        while self.takes(","):
            kinds.append(self._numeric(self.operation()))
        self.need(")")
        if word in REDUCTIONS and len(kinds) == 1:
            return self._reduced(word, kinds[0])
        wanted, count = FUNCTIONS.get(word, 1), len(kinds)
        if count != (wanted or max(count, 2)):
            least = "at least 2 arguments" if not wanted else f"{wanted} argument{'s' * (wanted > 1)}"
            raise ExpressionError(f"{word} needs {least}, got {count}")
        if word in ("radians", "degrees"):
            self.code.append(CONSTANTS["deg"] if word == "radians" else 180.0 / math.pi)
            return self._applied("*", 2, kinds[0]._replace(unit=""))
        found = kinds[0]
        for other in kinds[1:]:
            found = self._together(found, other, word if word != "atan2" else "")
        unit = found.unit if word in ("abs", "hypot", "min", "max") else _root(found.unit) if word == "sqrt" else ""
        return self._applied(word, count, found._replace(unit=unit))

    def _reduced(self, word: str, kind: PartKind) -> PartKind:
        if kind.what != "rows":
            least = "" if word not in FUNCTIONS else f", or {word} needs at least 2 arguments"
            raise ExpressionError(f"{word}() takes a column, such as {word}(P.y){least}")
        if kind.columns != 1 and word not in ("min", "max"):
            raise ExpressionError(f"{word}() takes one column, but a measure here has {kind.columns}; name one of them")
        unit, count = kind.unit, 1
        if word in ("argmin", "argmax", "integral"):
            across, own = self.names.across()
            self.code.append(across)
            unit, count = (own if word != "integral" else unit and f"{unit} {own}"), 2
        return self._applied(word + REDUCES, count, PartKind("number", unit))

    def _at(self, start: int, kind: PartKind) -> PartKind:
        _refuse(
            (kind.what != "rows", "at() takes a column, such as at(P.y, motor=30)"),
            (kind.columns != 1, f"at() takes one column, but a measure here has {kind.columns}; name one of them"),
            (
                Expression("", tuple(self.code[start:])).reduces,
                "at() takes a column: write a number of all rows, such as max(P.y), outside of it",
            ),
        )
        self.need(",")
        actuator, equals, _ = self.rest().partition("=")
        _refuse((not equals, "at() needs the value of an input, such as at(P.y, motor=30)"))
        self.place += len(actuator) + 1
        sign, number = -1.0 if self.takes("-") else 1.0, NUMBER.match(self.rest())
        if number is None:
            raise ExpressionError(f"expected a number after '{actuator.strip()}='")
        self.place += number.end()
        self.need(")")
        where = actuator.strip(), sign * float(number[0])
        self.names.refuse_value(*where)
        self.code.insert(start, ("at", where))
        self.code.append(("end", 0))
        return PartKind("number", kind.unit)

    def _joined(self, sign: str, first: PartKind, second: PartKind) -> PartKind:
        if sign in ("and", "or"):
            self._expect(first, "yes")
            self._expect(second, "yes")
            return self._applied(sign, 2, PartKind("yes"))
        if sign in COMPARISONS and "text" in (first.what, second.what):
            if first.what != second.what or sign not in ("==", "!="):
                raise ExpressionError("a text can only be compared with a text, by == or !=")
            return self._applied(f"text {sign}", 2, PartKind("yes"))
        if sign in COMPARISONS:
            self._together(self._expect(first, "number"), self._expect(second, "number"), sign)
            return self._applied(sign, 2, PartKind("yes"))
        found = self._together(self._numeric(first), self._numeric(second), sign if sign in "+-" else "")
        return self._applied(sign, 2, found if sign in "+-" or not found.unit else found._replace(unit=""))

    def _together(self, first: PartKind, second: PartKind, alike: str) -> PartKind:
        """Return the kind of two numbers or columns that are combined; `alike` names what needs equal units."""
        if 1 not in (first.columns, second.columns):
            raise ExpressionError("two measures of several columns cannot be combined; name their columns")
        units = {first.unit, second.unit} - {None}
        _refuse((alike and len(units - {""}) > 1, f"{alike} needs equal units, got {first.unit} and {second.unit}"))
        unit = None if not units else units.pop() if len(units) == 1 and alike else ""
        what = "rows" if "rows" in (first.what, second.what) else "number"
        return PartKind(what, unit, max(first.columns, second.columns))

    def _numeric(self, kind: PartKind) -> PartKind:
        return self._expect(kind, "number", "rows")

    def _expect(self, kind: PartKind, *what: str) -> PartKind:
        if kind.what == "rows" and "rows" not in what:
            raise ExpressionError("a column has a value for every row; write for example min(COLUMN)")
        if kind.what not in what:
            raise ExpressionError(f"expected {NAMED[what[0]]}, got {NAMED[kind.what]}")
        return kind

    def _applied(self, name: str, count: int, kind: PartKind) -> PartKind:
        self.code.append((name, count))
        return kind

    def _pushed(self, text: str, item: Any, kind: PartKind) -> PartKind:
        self.place += len(text)
        self.code.append(item)
        return kind

    def _closed(self, kind: PartKind, sign: str) -> PartKind:
        self.need(sign)
        return kind

    def takes(self, sign: str) -> bool:
        """Skip a sign or a word that begins here; return whether it was skipped."""
        rest = self.rest()
        word = WORD.match(rest) if sign.isalpha() else None
        longer = word is not None and word[0] != sign
        if not rest.startswith(sign) or longer or (sign == "*" and rest.startswith("**")):
            return False
        self.place += len(sign)
        return True

    def need(self, sign: str) -> None:
        """Skip a sign; raise ExpressionError if there is another one."""
        if not self.takes(sign):
            raise ExpressionError(f"expected '{sign}', got {self._got()}")

    def rest(self) -> str:
        """Return the text that is left, from its first letter on."""
        found = self.text[self.place :].lstrip()
        self.place = len(self.text) - len(found)
        return found

    def _got(self) -> str:
        return f"'{self.rest()}'" if self.rest() else "the end"


def _root(unit: str | None) -> str | None:
    """Return the unit of a square root; "" where it has no name."""
    return unit and (unit.removesuffix("^2") if unit.endswith("^2") else "")
