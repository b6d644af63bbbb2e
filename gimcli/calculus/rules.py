"""One table of rules: the value of each operation, and how it carries the derivatives of its operands.

Source: Griewank & Walther, Evaluating Derivatives, 2008, chapter 3 (forward mode).
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np


class Rule(NamedTuple):
    """An operation: its value, and for each operand the part of its derivative that comes from this operand."""

    value: Callable[..., Any]  # of the operands
    parts: tuple[Callable[..., Any], ...] = ()  # of value, operands, derivative of the operand; (): linear, one operand

    def slope(self, value: Any, operands: Sequence[Any], slopes: Sequence[Any]) -> Any:
        """Return the derivative of the operation from those of its operands; None: the operand is a constant."""
        if not self.parts:
            return self.value(slopes[0])
        own = [part(value, *operands, d) for part, d in zip(self.parts, slopes, strict=True) if d is not None]
        return own[0] if len(own) == 1 else reduce(operator.add, own)


def _amount_slope(f: Any, a: Any, d: Any) -> Any:
    return np.sign(a) * d if np.isrealobj(a) else np.real(np.conjugate(a) * d) / f


RULES: dict[str, Rule] = {
    "add": Rule(np.add, (lambda _, a, b, d: d, lambda _, a, b, d: d)),
    "subtract": Rule(np.subtract, (lambda _, a, b, d: d, lambda _, a, b, d: -d)),
    "multiply": Rule(np.multiply, (lambda _, a, b, d: d * b, lambda _, a, b, d: a * d)),
    "divide": Rule(np.divide, (lambda _, a, b, d: d / b, lambda f, a, b, d: -f * d / b)),
    "power": Rule(np.power, (
        lambda _, a, b, d: b * np.power(a, b - (b != 0.0)) * d, lambda f, a, b, d: f * np.log(a) * d,
    )),
    "negative": Rule(np.negative),
    "conjugate": Rule(np.conjugate),
    "real": Rule(np.real),
    "imag": Rule(np.imag),
    "abs": Rule(np.absolute, (_amount_slope,)),
    "phase": Rule(np.angle, (lambda _, a, d: np.imag(d / a),)),
    "sqrt": Rule(np.sqrt, (lambda f, a, d: d / (2.0 * f),)),
    "exp": Rule(np.exp, (lambda f, a, d: d * f,)),
    "log": Rule(np.log, (lambda _, a, d: d / a,)),
    "sin": Rule(np.sin, (lambda _, a, d: d * np.cos(a),)),
    "cos": Rule(np.cos, (lambda _, a, d: -d * np.sin(a),)),
    "tan": Rule(np.tan, (lambda _, a, d: d / np.cos(a) ** 2,)),
    "asin": Rule(np.arcsin, (lambda _, a, d: d / np.sqrt(1.0 - a * a),)),
    "acos": Rule(np.arccos, (lambda _, a, d: -d / np.sqrt(1.0 - a * a),)),
    "atan": Rule(np.arctan, (lambda _, a, d: d / (1.0 + a * a),)),
    "atan2": Rule(np.arctan2, (
        lambda _, a, b, d: b * d / (a * a + b * b), lambda _, a, b, d: -a * d / (a * a + b * b),
    )),
    "hypot": Rule(np.hypot, (lambda f, a, b, d: a * d / f, lambda f, a, b, d: b * d / f)),
    "radians": Rule(np.radians),
    "degrees": Rule(np.degrees),
    "minimum": Rule(np.minimum, (
        lambda _, a, b, d: np.where(a <= b, d, 0.0), lambda _, a, b, d: np.where(a <= b, 0.0, d),
    )),
    "maximum": Rule(np.maximum, (
        lambda _, a, b, d: np.where(a >= b, d, 0.0), lambda _, a, b, d: np.where(a >= b, 0.0, d),
    )),
    "where": Rule(np.where, (
        lambda _, c, a, b, d: 0.0 * d,
        lambda _, c, a, b, d: np.where(c, d, 0.0), lambda _, c, a, b, d: np.where(c, 0.0, d),
    )),
}  # fmt: skip
"""The operations by name."""

NAMES: dict[Callable[..., Any], str] = {rule.value: name for name, rule in RULES.items()}
"""The name of the operation of each of numpy's functions."""
