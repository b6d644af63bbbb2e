"""Quantities with their first and second derivatives along k directions in which a mechanism can move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import ArrayNumber
from gimcli.calculus.rules import RULES

Values = NDArray[Any]
"""Real or complex values; the last axis has the positions (rows)."""


@dataclass(eq=False)
class Jet(ArrayNumber):
    """A quantity in some positions, with its derivatives along k directions."""

    value: Values  # (rows,)
    first: Values  # (k, rows)
    second: Values  # (k, k, rows)

    def apply(self, name: str, *operands: Any) -> Jet:
        """Return the result of an operation of the table; its second derivatives are those of the first ones."""
        rule, jets = RULES[name], [isinstance(one, Jet) for one in operands]
        if name == "multiply":
            return _product(*operands) if all(jets) else Jet(*map(rule.value, *(_orders(one, one) for one in operands)))
        if name in ("add", "subtract") or not rule.parts:
            return Jet(*map(rule.value, *(_orders(one, 0.0) for one in operands)))
        own = [one.dual if isinstance(one, Jet) else one for one in operands]
        found = own[jets.index(True)].apply(name, *own)
        rates = [one.rates if isinstance(one, Jet) else None for one in operands]
        return Jet(found.value, found.slopes, rule.slope(found, own, rates).slopes)

    def __getitem__(self, key: int) -> Jet:
        return Jet(self.value[key], self.first[:, key], self.second[:, :, key])

    @property
    def dual(self) -> Dual:
        """The quantity with its first derivatives."""
        return Dual(self.value, self.first)

    @property
    def rates(self) -> Dual:
        """Its first derivatives (k, rows) with their own ones."""
        return Dual(self.first, self.second)

    def through(self, value: Values, slope: Values, bend: Values) -> Jet:
        """Return a function of the quantity, from the function's value and its first and second derivative (rows,)."""
        second = slope * self.second + bend * (self.first[:, None] * self.first[None, :])
        return Jet(value, slope * self.first, second)


def _orders(one: Any, rate: Any) -> Sequence[Any]:
    """Return value, first and second derivatives; for a constant, with `rate` in place of the derivatives."""
    return (one.value, one.first, one.second) if isinstance(one, Jet) else (one, rate, rate)


def _product(a: Jet, b: Jet) -> Jet:
    mixed = a.first[:, None] * b.first[None, :]
    second = a.second * b.value + a.value * b.second + mixed + mixed.transpose(1, 0, 2)
    return Jet(a.value * b.value, a.first * b.value + a.value * b.first, second)
