"""Numbers that record the arithmetic applied to them, so that it can be repeated for other values.

A model that is compiled and planned once with `Recorded` numbers in place of its dimensions leaves a `Recording`: the
list of the operations that lead from the dimensions to the numbers of the plan. `Recording.evaluate` repeats them for
many designs at once, `Recording.tangents` differentiates them. Comparisons use the nominal values: what the dimensions
decide about the structure is decided by the nominal design.
"""

from __future__ import annotations

import cmath
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

Rule = Callable[..., Any]

OPERATIONS: dict[str, tuple[Rule, Rule]] = {
    "add": (np.add, lambda a, b, da, db: da + db),
    "subtract": (np.subtract, lambda a, b, da, db: da - db),
    "multiply": (np.multiply, lambda a, b, da, db: da * b + a * db),
    "divide": (np.divide, lambda a, b, da, db: (da - a / b * db) / b),
    "power": (np.power, lambda a, b, da, db: _power_slope(a, b, da, db)),
    "conjugate": (np.conjugate, lambda a, da: np.conjugate(da)),
    "real": (np.real, lambda a, da: np.real(da)),
    "imag": (np.imag, lambda a, da: np.imag(da)),
    "abs": (np.abs, lambda a, da: np.real(np.conjugate(a) * da) / np.abs(a)),
    "phase": (np.angle, lambda a, da: np.imag(da / a)),
    "sqrt": (np.sqrt, lambda a, da: da / (2.0 * np.sqrt(a))),
    "exp": (np.exp, lambda a, da: da * np.exp(a)),
    "log": (np.log, lambda a, da: da / a),
    "sin": (np.sin, lambda a, da: da * np.cos(a)),
    "cos": (np.cos, lambda a, da: -da * np.sin(a)),
    "tan": (np.tan, lambda a, da: da / np.cos(a) ** 2),
    "asin": (np.arcsin, lambda a, da: da / np.sqrt(1.0 - a * a)),
    "acos": (np.arccos, lambda a, da: -da / np.sqrt(1.0 - a * a)),
    "atan": (np.arctan, lambda a, da: da / (1.0 + a * a)),
    "atan2": (np.arctan2, lambda a, b, da, db: (b * da - a * db) / (a * a + b * b)),
    "hypot": (np.hypot, lambda a, b, da, db: (a * da + b * db) / np.hypot(a, b)),
    "minimum": (np.minimum, lambda a, b, da, db: np.where(a <= b, da, db)),
    "maximum": (np.maximum, lambda a, b, da, db: np.where(a >= b, da, db)),
}
"""Each operation: its value, and its derivative from the operands and their derivatives."""


def _power_slope(a: Any, b: Any, da: Any, db: Any) -> Any:
    slope = b * np.power(a, b - 1.0) * da
    return slope if np.ndim(db) == 0 and db == 0.0 else slope + np.power(a, b) * np.log(a) * db


def _operator(name: str) -> tuple[Callable[[Recorded, Any], Any], Callable[[Recorded, Any], Any]]:
    """Return an operator that records an operation, and the one with the operands exchanged."""
    return (
        lambda self, other: self.recording.apply(name, self, other),
        lambda self, other: self.recording.apply(name, other, self),
    )


def _comparison(compare: Callable[[Any, Any], bool]) -> Callable[[Any, Any], bool]:
    """Return an operator that compares nominal values."""
    return lambda self, other: bool(compare(self.value, nominal(other)))


class Recorded:
    """A number with its nominal value and its place in a recording."""

    __slots__ = ("place", "recording", "value")

    def __init__(self, recording: Recording, place: int, value: Any) -> None:
        self.recording, self.place, self.value = recording, place, value

    __add__, __radd__ = _operator("add")
    __sub__, __rsub__ = _operator("subtract")
    __mul__, __rmul__ = _operator("multiply")
    __truediv__, __rtruediv__ = _operator("divide")
    __pow__, __rpow__ = _operator("power")

    def __neg__(self) -> Any:
        return self.recording.apply("multiply", -1.0, self)

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return self.recording.apply("abs", self)

    def conjugate(self) -> Any:
        """Return the complex conjugate."""
        return self.recording.apply("conjugate", self)

    @property
    def real(self) -> Any:
        """The real part."""
        return self.recording.apply("real", self) if isinstance(self.value, complex) else self

    @property
    def imag(self) -> Any:
        """The imaginary part."""
        return self.recording.apply("imag", self) if isinstance(self.value, complex) else 0.0

    __eq__ = _comparison(operator.eq)
    __lt__, __le__ = _comparison(operator.lt), _comparison(operator.le)
    __gt__, __ge__ = _comparison(operator.gt), _comparison(operator.ge)

    def __hash__(self) -> int:
        return hash(self.value)

    def __bool__(self) -> bool:
        return bool(self.value)

    def __float__(self) -> float:
        raise TypeError("a recorded number has no single value; use `nominal`")

    __complex__ = __int__ = __float__


class Recording:
    """The operations that lead from some variables to other numbers."""

    def __init__(self) -> None:
        self.steps: list[tuple[str, tuple[Any, ...]]] = []  # operation and operands: numbers, or places in this list
        self._known: dict[Any, Recorded] = {}
        self.variables: list[Recorded] = []

    def variable(self, value: float) -> Recorded:
        """Return a new variable with a nominal value."""
        number = Recorded(self, len(self.steps), float(value))
        self.steps.append(("variable", (len(self.variables),)))
        self.variables.append(number)
        return number

    def apply(self, name: str, *operands: Any) -> Any:
        """Record an operation and return its result; the same operation on the same operands is recorded once."""
        if any(isinstance(one, np.ndarray) and one.ndim for one in operands):
            return NotImplemented  # numpy applies the operation to each element
        plain = [one.value if isinstance(one, Recorded) else _number(one) for one in operands]
        key = (
            name,
            *((1, o.place) if isinstance(o, Recorded) else (0, p) for o, p in zip(operands, plain, strict=True)),
        )
        found = self._known.get(key)
        if found is None:
            value = OPERATIONS[name][0](*plain)
            found = Recorded(self, len(self.steps), complex(value) if np.iscomplexobj(value) else float(value))
            self.steps.append(
                (name, tuple(o if isinstance(o, Recorded) else p for o, p in zip(operands, plain, strict=True)))
            )
            self._known[key] = found
        return found

    def evaluate(self, values: Any, wanted: Sequence[int]) -> dict[int, Any]:
        """Return the numbers at places `wanted` of the recording for values (variables, designs) of the variables."""
        done: dict[int, Any] = {}
        with np.errstate(all="ignore"):
            for place in self._needed(wanted):
                name, operands = self.steps[place]
                if name == "variable":
                    done[place] = values[operands[0]]
                else:
                    done[place] = OPERATIONS[name][0](
                        *(done[o.place] if isinstance(o, Recorded) else o for o in operands)
                    )
        return {place: done[place] for place in wanted}

    def tangents(self, values: Any, wanted: Sequence[int]) -> tuple[dict[int, Any], dict[int, Any]]:
        """Return the numbers at places `wanted`, and their derivatives (variables, designs) by the variables.

        values: (variables, designs).
        """
        done: dict[int, Any] = {}
        slopes: dict[int, Any] = {}
        count = len(self.variables)
        with np.errstate(all="ignore"):
            for place in self._needed(wanted):
                name, operands = self.steps[place]
                if name == "variable":
                    done[place] = values[operands[0]]
                    slopes[place] = np.zeros((count, *np.shape(done[place])))
                    slopes[place][operands[0]] = 1.0
                    continue
                value, slope = OPERATIONS[name]
                own = [done[o.place] if isinstance(o, Recorded) else o for o in operands]
                done[place] = value(*own)
                slopes[place] = slope(*own, *(slopes[o.place] if isinstance(o, Recorded) else 0.0 for o in operands))
        return {p: done[p] for p in wanted}, {p: slopes[p] for p in wanted}

    def _needed(self, wanted: Sequence[int]) -> list[int]:
        """Return the places on which the wanted ones depend, in order."""
        needed, todo = set(wanted), list(wanted)
        while todo:
            name, operands = self.steps[todo.pop()]
            for one in operands if name != "variable" else ():
                if isinstance(one, Recorded) and one.place not in needed:
                    needed.add(one.place)
                    todo.append(one.place)
        return sorted(needed)


def _number(value: Any) -> Any:
    return complex(value) if isinstance(value, complex) else float(value)


def nominal(value: Any) -> Any:
    """Return a number, or the nominal value of a recorded one."""
    return value.value if isinstance(value, Recorded) else value


def scalar(value: Any) -> Any:
    """Return a Python complex, or the recorded number."""
    return value if isinstance(value, Recorded) else complex(value)


def places(pairs: Sequence[Sequence[Any]]) -> Any:
    """Return coordinate pairs as an array of complex numbers, of objects if any is recorded."""
    return array(
        [x + 1j * y if isinstance(x, Recorded) or isinstance(y, Recorded) else complex(x, y) for x, y in pairs]
    )


def array(values: Sequence[Any]) -> Any:
    """Return an array of complex numbers, of objects if any is recorded."""
    if any(isinstance(value, Recorded) for value in values):
        found = np.empty(len(values), dtype=object)
        found[:] = values
        return found
    return np.array(values, dtype=complex)


def phase(value: Any) -> Any:
    """Return the angle of a complex number [rad]."""
    return value.recording.apply("phase", value) if isinstance(value, Recorded) else cmath.phase(value)


def _recorded(name: str, plain: Rule) -> Rule:
    def function(*operands: Any) -> Any:
        first = next((one for one in operands if isinstance(one, Recorded)), None)
        return plain(*operands) if first is None else first.recording.apply(name, *operands)

    return function


def _folded(pair: Rule) -> Rule:
    def function(*operands: Any) -> Any:
        found = operands[0]
        for one in operands[1:]:
            found = pair(found, one)
        return found

    return function


FUNCTIONS: Mapping[str, Rule] = {
    **{name: _recorded(name, getattr(math, name)) for name in (
        "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "hypot",
    )},
    "abs": abs,
    "min": _folded(_recorded("minimum", min)),
    "max": _folded(_recorded("maximum", max)),
}  # fmt: skip
"""The functions of arithmetic in a model file, for plain and recorded numbers."""
