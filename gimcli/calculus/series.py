"""Truncated power series in one variable, for derivatives of any order along a motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.calculus.numbers import ArrayNumber, applied
from gimcli.calculus.rules import RULES


class Series(ArrayNumber):
    """The series c[0] + c[1] t + c[2] t^2 + ...; the coefficients (orders, ...) are real or complex, t is real."""

    def __init__(self, c: Any) -> None:
        self.c = c

    @property
    def value(self) -> Any:
        """The value at t = 0."""
        return self.c[0]

    def apply(self, name: str, *operands: Any) -> Series:
        """Return the result of an operation of the table.

        Except for products and quotients, coefficient k is that of order k - 1 of the derivative by the rule, over k.
        """
        rule, moving = RULES[name], [isinstance(one, Series) for one in operands]
        if (name == "multiply" and not all(moving)) or (name == "divide" and not moving[1]):
            return Series(rule.value(*(one.c if isinstance(one, Series) else one for one in operands)))
        own = [one.c if isinstance(one, Series) else self._constant(one) for one in operands]
        if name in ("add", "subtract") or not rule.parts:
            return Series(np.stack([applied(name, *orders) for orders in zip(*own, strict=True)]))
        found = [applied(name, *(c[0] for c in own))]
        for k in range(1, len(self.c)):
            if name == "multiply":
                found.append(sum(own[0][j] * own[1][k - j] for j in range(k + 1)))
            elif name == "divide":
                found.append((own[0][k] - sum(found[j] * own[1][k - j] for j in range(k))) / own[1][0])
            else:
                rates = [Series(_rates(c[: k + 1])) if moves else None for c, moves in zip(own, moving, strict=True)]
                slope = rule.slope(Series(np.stack(found)), [Series(c[:k]) for c in own], rates)
                found.append(slope.c[k - 1] / k)
        return Series(np.stack(found))

    def __array_function__(self, function: Any, types: Any, arguments: Any, options: Any) -> Any:
        if function is np.isrealobj:
            return np.isrealobj(self.c)
        return super().__array_function__(function, types, arguments, options)

    def _constant(self, number: Any) -> Any:
        """Return the coefficients of a constant."""
        rest = 0.0 * (self.c + number)
        return np.concatenate([rest[:1] + number, rest[1:]])


def _rates(c: Any) -> Any:
    """Return the coefficients (orders - 1, ...) of the derivative of a series."""
    return np.stack([k * c[k] for k in range(1, len(c))])
