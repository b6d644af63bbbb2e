"""Arithmetic in place of a number of the model file, such as `2*a + 3` with the parameter `a`.

The grammar is that of Python's arithmetic: `+ - * / **`, signs, parentheses, the functions of `FUNCTIONS` and the
constants of `CONSTANTS`. Nothing else can be written, so that a model file cannot run a program.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

LONGEST, DEEPEST = 1000, 20
"""Most characters of a formula, and most levels of its parentheses, signs and powers."""
FUNCTIONS: dict[str, Callable[..., float]] = {
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "asin": math.asin, "acos": math.acos, "atan": math.atan,
    "atan2": math.atan2, "sqrt": math.sqrt, "exp": math.exp, "log": math.log, "abs": abs, "hypot": math.hypot,
    "min": min, "max": max,
}  # fmt: skip
"""The functions of formulas; angles are in rad."""
CONSTANTS = {"pi": math.pi, "deg": math.pi / 180.0}
WORDS = (*FUNCTIONS, *CONSTANTS)
"""The constants of formulas (`deg` is one degree in rad), and all words that are not parameters."""
OPERATORS: dict[str, Callable[..., Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "**": operator.pow,
    "negative": operator.neg,
}  # fmt: skip


def _real_power(base: float, exponent: float) -> float:
    found = base**exponent
    if isinstance(found, complex):
        raise ValueError
    return float(found)


REAL = {**FUNCTIONS, "**": _real_power}
PAIRED, MANY = ("atan2", "hypot"), ("min", "max")
"""Functions of two arguments, and of two or more; the others have one."""

_DIGITS = r"((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)"
_TOKEN = re.compile(rf"\s*(?:{_DIGITS}|([^\W\d]\w*)|(\*\*|\S))")
_NUMBER = re.compile(rf"\s*[-+]?{_DIGITS}\s*")
_WORD = re.compile(r"[^\W\d]\w*$")


class FormulaError(ValueError):
    """A text that is no formula, or a formula without a value."""


class UnknownNameError(FormulaError):
    """A word in a formula that is not a parameter."""

    def __init__(self, word: str) -> None:
        super().__init__(f"'{word}' is not a parameter")
        self.word = word


@dataclass(frozen=True)
class Formula:
    """A formula in postfix order: numbers, names of parameters, and operations with their count of operands."""

    text: str
    code: tuple[float | str | tuple[str, int], ...]
    names: frozenset[str]  # of the parameters in it

    def value(self, names: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> Any:
        """Return the value for values of the parameters: numbers, or any objects with Python's operators."""
        stack: list[Any] = []
        for item in self.code:
            if isinstance(item, float):
                stack.append(item)
            elif isinstance(item, str):
                stack.append(names[item])
            else:
                name, count = item
                apply = functions.get(name) or OPERATORS[name]
                stack[-count:] = [apply(*stack[-count:])]
        return stack[0]

    def number(self, names: Mapping[str, float]) -> float:
        """Return the value for numbers; raise FormulaError where there is no finite real value."""
        try:
            found = self.value(names, REAL)
        except ZeroDivisionError:
            raise FormulaError(f"division by zero{self._at(names)}") from None
        except OverflowError:
            raise FormulaError(f"the value is too large{self._at(names)}") from None
        except ValueError:
            raise FormulaError(f"it has no real value{self._at(names)}") from None
        if not math.isfinite(found):
            raise FormulaError(f"the value is too large{self._at(names)}")
        return float(found)

    def _at(self, names: Mapping[str, float]) -> str:
        """Return the values of the first parameters in the formula."""
        given = ", ".join(f"{name} = {names[name]:g}" for name in sorted(self.names)[:4])
        return f" at {given}" if given else ""


def is_name(word: str) -> bool:
    """Return whether a word can be the name of a parameter."""
    return _WORD.match(word) is not None and word not in FUNCTIONS and word not in CONSTANTS


def is_number(text: str) -> bool:
    """Return whether a text is a number, not a formula."""
    return _NUMBER.fullmatch(text) is not None


def parsed(text: str, names: Mapping[str, Any]) -> Formula:
    """Return the formula of a text whose parameters are among `names`; raise FormulaError if it is none."""
    if len(text) > LONGEST:
        raise FormulaError(f"{len(text)} characters are too many for a formula; at most {LONGEST} are read")
    return _Parser(text, names).formula()


class _Parser:
    """Reads a formula by recursive descent: sum, product, sign, power, operand."""

    def __init__(self, text: str, names: Mapping[str, Any]) -> None:
        self.text, self.names = text, names
        self.tokens = [match.groups("") for match in _TOKEN.finditer(text)]  # number, word, sign
        self.place = self.depth = 0
        self.code: list[float | str | tuple[str, int]] = []

    def formula(self) -> Formula:
        """Return the whole formula."""
        self.sum()
        if self.place < len(self.tokens):
            raise self.unexpected()
        return Formula(self.text.strip(), tuple(self.code), frozenset(c for c in self.code if isinstance(c, str)))

    def unexpected(self) -> FormulaError:
        """Return the error at the next token."""
        found = "".join(self.tokens[self.place]) if self.place < len(self.tokens) else ""
        cure = "; write ** for a power" if found == "^" else ""
        return FormulaError(f"unexpected '{found}'{cure}" if found else "the formula is not complete")

    def take(self, *signs: str) -> str:
        """Return the next sign and pass it if it is one of some signs; else an empty text."""
        sign = self.tokens[self.place][2] if self.place < len(self.tokens) else ""
        if sign and sign in signs:
            self.place += 1
            return sign
        return ""

    def need(self, sign: str) -> None:
        """Pass a sign."""
        if not self.take(sign):
            raise self.unexpected()

    def sum(self) -> None:
        """Read terms joined by + and -."""
        self.product()
        while sign := self.take("+", "-"):
            self.product()
            self.code.append((sign, 2))

    def product(self) -> None:
        """Read factors joined by * and /."""
        self.sign()
        while sign := self.take("*", "/"):
            self.sign()
            self.code.append((sign, 2))

    def sign(self) -> None:
        """Read a power with its signs."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise FormulaError(f"the formula is nested too deeply; at most {DEEPEST} levels are read")
        sign = self.take("+", "-")
        if sign:
            self.sign()
            self.code += [("negative", 1)] * (sign == "-")
        else:
            self.power()
        self.depth -= 1

    def power(self) -> None:
        """Read an operand and its exponent: 2**-1 is 0.5, -2**2 is -4, 2**3**2 is 512."""
        self.operand()
        if self.take("**"):
            self.sign()
            self.code.append(("**", 2))

    def operand(self) -> None:
        """Read a number, a parameter, a constant, a function or a sum in parentheses."""
        number, word, _ = self.tokens[self.place] if self.place < len(self.tokens) else ("", "", "")
        if number:
            self.code.append(float(number))
        elif not word:
            self.need("(")
            self.sum()
            self.need(")")
            return
        self.place += 1
        if word in FUNCTIONS:
            self.call(word)
        elif word in CONSTANTS:
            self.code.append(CONSTANTS[word])
        elif word:
            self.refuse_unknown(word)
            self.code.append(word)

    def call(self, name: str) -> None:
        """Read the arguments of a function."""
        self.need("(")
        self.sum()
        count = 1
        while self.take(","):
            self.sum()
            count += 1
        self.need(")")
        wanted = 2 if name in PAIRED + MANY else 1
        if count < wanted or (count > wanted and name not in MANY):
            least = "at least " * (name in MANY)
            raise FormulaError(f"{name} needs {least}{wanted} argument{'s' * (wanted > 1)}, got {count}")
        self.code.append((name, count))

    def refuse_unknown(self, word: str) -> None:
        """Raise FormulaError for a word that is not a parameter."""
        if word not in self.names:
            raise UnknownNameError(word)
