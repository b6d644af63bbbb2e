"""Numbers that record the arithmetic applied to them, so that it can be repeated for other values.

A model that is compiled and planned once with `Recorded` numbers in place of its dimensions leaves a `Recording`: the
list of the operations that lead from the dimensions to the numbers of the plan. `Recording.evaluate` repeats them for
many designs at once, `Recording.tangents` differentiates them. Comparisons use the nominal values: what the dimensions
decide about the structure is decided by the nominal design.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import RuleNumber, nominal
from gimcli.calculus.rules import RULES


class Recorded(RuleNumber):
    """A number with its nominal value and its place in a recording."""

    __slots__ = ("place", "recording", "value")

    def __init__(self, recording: Recording, place: int, value: Any) -> None:
        self.recording, self.place, self.value = recording, place, value

    def apply(self, name: str, *operands: Any) -> Any:
        """Record an operation and return its result."""
        return self.recording.apply(name, *operands)

    @property
    def real(self) -> Any:
        """The real part."""
        return self.apply("real", self) if isinstance(self.value, complex) else self

    @property
    def imag(self) -> Any:
        """The imaginary part."""
        return self.apply("imag", self) if isinstance(self.value, complex) else 0.0

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
        self._moved: dict[int, Dual] = {}  # nominal numbers with their derivatives, by places
        self._slopes: set[int] = set()  # places of derivatives and of what is computed from them
        self._variables: list[frozenset[int]] = []  # the numbers of the variables on which each step depends
        self.variables: list[Recorded] = []

    def variable(self, value: float) -> Recorded:
        """Return a new variable with a nominal value."""
        number = Recorded(self, len(self.steps), float(value))
        self.steps.append(("variable", (len(self.variables),)))
        self._variables.append(frozenset((len(self.variables),)))
        self.variables.append(number)
        return number

    def apply(self, name: str, *operands: Any) -> Any:
        """Record an operation and return its result; the same operation on the same operands is recorded once."""
        if any((isinstance(one, np.ndarray) and one.ndim) or _foreign(one) for one in operands):
            return NotImplemented  # numpy applies the operation to each element, or the other number does
        own = [one if isinstance(one, Recorded) else _number(one) for one in operands]
        key = (name, *((1, one.place) if isinstance(one, Recorded) else (0, one) for one in own))
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self._recorded(name, own, RULES[name].value(*map(nominal, own)))
        return found

    def slope(self, number: Any, variable: int) -> Any:
        """Return the derivative of a number by a variable as a recorded number, 0.0 if it does not depend on it."""
        if not isinstance(number, Recorded) or variable not in self.variables_of([number.place]):
            return 0.0
        key = ("slope", number.place, variable)
        if key not in self._known:
            if number.place not in self._moved:
                plain = [place for place in range(len(self.steps)) if place not in self._slopes]
                self._moved = self.tangents([np.array([one.value]) for one in self.variables], plain)
            value = self._moved[number.place].slopes[variable, 0]
            self._known[key] = self._recorded("slope", (number, variable), value)
        return self._known[key]

    def _recorded(self, name: str, operands: Sequence[Any], value: Any) -> Recorded:
        """Append an operation with a nominal result."""
        own = [one.place for one in operands if isinstance(one, Recorded)]
        if name == "slope" or not self._slopes.isdisjoint(own):
            self._slopes.add(len(self.steps))
        self._variables.append(frozenset[int]().union(*(self._variables[place] for place in own)))
        self.steps.append((name, tuple(operands)))
        return Recorded(self, len(self.steps) - 1, complex(value) if np.iscomplexobj(value) else float(value))

    def evaluate(self, values: Any, wanted: Sequence[int]) -> dict[int, Any]:
        """Return the numbers at places `wanted` of the recording for values (variables, designs) of the variables.

        The values of each variable may also be dual numbers; so are the results then.
        """
        done: dict[int, Any] = {}
        needed = self._needed(wanted)
        moving = [self.steps[place][1][0].place for place in needed if self.steps[place][0] == "slope"]
        moved = self.tangents(values, moving) if moving else {}
        with np.errstate(all="ignore"):
            for place in needed:
                name, operands = self.steps[place]
                if name == "variable":
                    done[place] = values[operands[0]]
                elif name == "slope":
                    done[place] = moved[operands[0].place].slopes[operands[1]]
                else:
                    own = (done[one.place] if isinstance(one, Recorded) else one for one in operands)
                    done[place] = RULES[name].value(*own)
        return {place: done[place] for place in wanted}

    def tangents(self, values: Any, wanted: Sequence[int]) -> dict[int, Dual]:
        """Return the numbers at places `wanted`, with their derivatives by the variables as tangents.

        values: (variables, designs).
        """
        count = len(self.variables)
        return self.evaluate([Dual(own, np.eye(count)[k][:, None]) for k, own in enumerate(values)], wanted)

    def variables_of(self, wanted: Sequence[int]) -> frozenset[int]:
        """Return the numbers of the variables on which the numbers at some places depend."""
        return frozenset[int]().union(*(self._variables[place] for place in wanted))

    def _needed(self, wanted: Sequence[int]) -> list[int]:
        """Return the places on which the wanted ones depend, in order."""
        needed, todo = set(wanted), list(wanted)
        while todo:
            name, operands = self.steps[todo.pop()]
            for one in operands if name not in ("variable", "slope") else ():
                if isinstance(one, Recorded) and one.place not in needed:
                    needed.add(one.place)
                    todo.append(one.place)
        return sorted(needed)


def _foreign(number: Any) -> bool:
    return isinstance(number, RuleNumber) and not isinstance(number, Recorded)


def _number(value: Any) -> Any:
    return complex(value) if isinstance(value, complex) else float(value)
