"""One language of arithmetic: numbers of a model file, and quantities that are kept, plotted, compared and fitted.

    + - * / **  < <= > >= == !=  not and or      arithmetic and conditions
    sqrt(a)  atan2(a, b)  min(a, b, ...)         FUNCTIONS; angles in rad
    min(a)  max  range  mean  rms  first  last   of the rows of a motion
    argmin(a)  argmax  integral                  the input (or time) of an extreme; the integral over it
    at(a, motor=30)                              in the first row with this value of an input
    |a|                                          amount of a number, or of a vector such as P.v
    "text"                                       to compare with a text

The longest known name that begins in a place is read as a name, so that names may contain signs. Nothing else can be
written, so that a text cannot run a program.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

FUNCTIONS = {
    **dict.fromkeys(("abs", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan"), 1),
    "radians": 1, "degrees": 1, "atan2": 2, "hypot": 2, "min": 0, "max": 0,
}  # fmt: skip
"""The functions with their number of arguments; 0: two or more."""

SCALAR: dict[str, Callable[..., Any]] = {
    **{name: getattr(math, name) for name in FUNCTIONS if hasattr(math, name)}, "abs": abs, "min": min, "max": max,
}  # fmt: skip
"""The functions of numbers."""

REDUCTIONS = ("min", "max", "range", "mean", "rms", "first", "last", "argmin", "argmax", "integral")
"""Functions of all rows of a motion."""

REDUCES = " of rows"
"""End of the names of these operations."""

CONSTANTS = {"pi": math.pi, "deg": math.pi / 180.0}
"""The constants; `deg` is one degree in rad."""

OPERATORS: dict[str, Callable[..., Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "**": operator.pow,
    "negative": operator.neg,
}  # fmt: skip


class ExpressionError(ValueError):
    """A text that is no expression, or an expression without a value."""


class PartKind(NamedTuple):
    """What a part of an expression is.

    `unit` is "" if there is none or it is not known, None for a bare number, which takes that of its partner.
    """

    what: str  # "number", "rows" (one value for each row), "text" or "yes" (true or false)
    unit: str | None = ""
    columns: int = 1  # several for a measure or a vector


NUMBER = PartKind("number")


@dataclass(frozen=True)
class Expression:
    """An expression in postfix order, which holds for numbers and any objects with Python's operators.

    `code` has numbers, names, and pairs: an operation with its number of operands, ("text", a text), and ("at", (input,
    value)) before, ("end", 0) after the part that is taken at another position.
    """

    text: str
    code: tuple[Any, ...]
    kind: PartKind = NUMBER

    @property
    def names(self) -> frozenset[str]:
        """The names in it."""
        return frozenset(item for item in self.code if isinstance(item, str))

    @property
    def reduces(self) -> bool:
        """Whether a part of it is one value for all rows."""
        return any(isinstance(item, tuple) and str(item[0]).endswith(REDUCES) for item in self.code)

    def value(self, names: Any, functions: Mapping[str, Callable[..., Any]]) -> Any:
        """Return the value for values of the names; `functions` come before the operators of Python."""
        stack: list[Any] = []
        places = [names]
        for item in self.code:
            if isinstance(item, float):
                stack.append(item)
            elif isinstance(item, str):
                stack.append(places[-1][item])
            elif item[0] == "text":
                stack.append(item[1])
            elif item[0] == "at":
                places.append(places[-1].at(*item[1]))
            elif item[0] == "end":
                places.pop()
            else:
                name, count = item
                stack[-count:] = [(functions.get(name) or OPERATORS[name])(*stack[-count:])]
        return stack[0]

    def number(self, names: Mapping[str, float]) -> float:
        """Return the value for numbers; raise ExpressionError where there is no finite real value."""
        try:
            found = self.value(names, REAL)
        except ZeroDivisionError:
            raise ExpressionError(f"division by zero{self._at(names)}") from None
        except OverflowError:
            raise ExpressionError(f"the value is too large{self._at(names)}") from None
        except ValueError:
            raise ExpressionError(f"it has no real value{self._at(names)}") from None
        if not math.isfinite(found):
            raise ExpressionError(f"the value is too large{self._at(names)}")
        return float(found)

    def _at(self, names: Mapping[str, float]) -> str:
        """Return the values of the first names in the expression."""
        given = ", ".join(f"{name} = {names[name]:g}" for name in sorted(self.names)[:4])
        return f" at {given}" if given else ""


def _real_power(base: float, exponent: float) -> float:
    found = base**exponent
    if isinstance(found, complex):
        raise ValueError
    return float(found)


REAL = {**SCALAR, "**": _real_power}
