"""Numbers over rows whose operations are recorded on a tape, so that a formula of any numbers can be compiled."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from operator import index, mul
from typing import Any

import numpy as np

from gimcli.calculus.numbers import RuleNumber, nominal
from gimcli.calculus.recorded import Recorded
from gimcli.kernels import tape as kernels
from gimcli.rates.tape import ComplexLanes, Lane, Tape, vanishes

GIVEN = 3
"""First row of the given derivatives that has a function of the time or of an input."""


class TapeNumber(RuleNumber):
    """A constant factor times a real or complex number in lanes of a tape, or times its conjugate.

    Operations on it are recorded; other numbers, plain or recorded, are constants. There are no comparisons.
    """

    __slots__ = ("conjugated", "factor", "own", "tape")

    def __init__(self, tape: Tape, own: Any, factor: Any = 1.0, conjugated: bool = False) -> None:
        self.tape, self.own, self.factor, self.conjugated = tape, own, factor, conjugated

    def apply(self, name: str, *operands: Any) -> Any:
        """Record an operation and return its result."""
        if any(isinstance(one, np.ndarray) and one.ndim for one in operands):
            return NotImplemented  # numpy applies the operation to each element
        own = [one if isinstance(one, (TapeNumber, Recorded)) else np.asarray(nominal(one)).item() for one in operands]
        return OPERATIONS[name](self.tape, *own)

    def sqrt(self) -> Any:
        """Return the square root."""
        return self.apply("sqrt", self)

    @property
    def lanes(self) -> Any:
        """Lanes with the number itself."""
        tape, own = self.tape, self.own
        if self.conjugated:
            own = tape.products([(1.0, own, 1.0 + 0j)], conjugate=True)
        if isinstance(own, ComplexLanes):
            return tape.scaled(own, self.factor)
        return own if vanishes(self.factor - 1.0) else tape.real(kernels.AFFINE, own.lane, f=0.0, g=self.factor)


class GivenNumber(TapeNumber):
    """The time or an input; functions of it are computed before the tape is executed."""

    def __init__(self, tape: Tape, own: Any, over: int, functions: list[tuple[int, Callable[[Any], Any]]]) -> None:
        """Take the number of an input, or TIME; `functions` are those of all such numbers, with their arguments."""
        super().__init__(tape, own)
        self.over, self.functions = over, functions

    def through(self, function: Callable[[Any], Any]) -> TapeNumber:
        """Return a function of the number: row GIVEN + k of the given derivatives, k its place in `functions`."""
        self.functions.append((self.over, function))
        return given(self.tape, GIVEN + len(self.functions) - 1, 0)


def given(tape: Tape, row: int, column: int) -> TapeNumber:
    """Return a number of the given derivatives."""
    to = tape.keep(1)
    tape.emit(kernels.VALUE, to, row, column)
    return TapeNumber(tape, Lane(to))


def number(tape: Tape, found: Any) -> Any:
    """Return a number in lanes, or a constant as it is."""
    return TapeNumber(tape, found) if isinstance(found, (ComplexLanes, Lane)) else found


def product(number: Any) -> tuple[Any, Any]:
    """Return a real number as a constant times a number in a lane, or times 1."""
    if isinstance(number, TapeNumber):
        return number.factor, number.own
    return number if isinstance(number, Recorded) else np.asarray(nominal(number)).item(), 1.0


def lanes(number: Any) -> Any:
    """Return the lanes of a number, or the constant."""
    own = number.item() if isinstance(number, np.ndarray) else number  # numpy makes arrays of such numbers
    return own.lanes if isinstance(own, TapeNumber) else own


def _is_complex(number: Any) -> bool:
    return isinstance(number.own if isinstance(number, TapeNumber) else nominal(number), (complex, ComplexLanes))


def _real(tape: Tape, op: int, *operands: Any, f: Any = 1.0, g: Any = 0.0, factor: Any = 1.0) -> TapeNumber:
    return TapeNumber(tape, tape.real(op, *map(tape.lane, operands), f=f, g=g), factor)


def _turned(tape: Tape, real: TapeNumber, number: Any) -> TapeNumber:
    """Return a real number times a complex one or a constant."""
    own, factor, conjugated = number, real.factor, False
    if isinstance(number, TapeNumber):
        own, factor, conjugated = number.own, real.factor * number.factor, number.conjugated
    found = tape.pair(kernels.TURN, tape.lane(real.own), tape.lane(own))
    return TapeNumber(tape, found, factor * (1j if conjugated else -1j), conjugated)


def _multiply(tape: Tape, a: Any, b: Any) -> Any:
    if not isinstance(a, TapeNumber):
        a, b = b, a
    if not isinstance(b, TapeNumber):
        if vanishes(b):
            return 0.0
        if _is_complex(b) and not _is_complex(a):
            return _turned(tape, a, b)
        return TapeNumber(tape, a.own, a.factor * b, a.conjugated)
    if not _is_complex(a) and not _is_complex(b):
        return _real(tape, kernels.PRODUCT, a.own, b.own, factor=a.factor * b.factor)
    if not (_is_complex(a) and _is_complex(b)):
        return _turned(tape, b, a) if _is_complex(a) else _turned(tape, a, b)
    if b.conjugated and not a.conjugated:
        a, b = b, a
    mixed = a.conjugated and not b.conjugated
    found: Any = tape.products([(1.0, a.own, b.own)], conjugate=mixed)
    return TapeNumber(tape, found, a.factor * b.factor, a.conjugated and b.conjugated)


def _sum(tape: Tape, a: Any, b: Any, sign: float) -> Any:
    """Return a + sign b."""
    if not isinstance(b, TapeNumber):
        if vanishes(b):
            return a
        a, b, sign = sign * b, a, 1.0
    if not isinstance(a, TapeNumber) and vanishes(a):
        return sign * b
    if _is_complex(a) or _is_complex(b):
        a, b = (_turned(tape, n, 1.0 + 0j) if not _is_complex(n) and isinstance(n, TapeNumber) else n for n in (a, b))
        b = TapeNumber(tape, b.lanes) if b.conjugated else b
        return TapeNumber(tape, tape.plus(lanes(a), b.own, sign * b.factor))
    if not isinstance(a, TapeNumber):
        return _real(tape, kernels.AFFINE, b.own, f=a, g=sign * b.factor)
    return _real(tape, kernels.COMBINE, a.own, b.own, f=a.factor, g=sign * b.factor)


def _divide(tape: Tape, a: Any, b: Any) -> Any:
    if not isinstance(b, TapeNumber):
        return a * (1.0 / b)
    if _is_complex(b):
        return a * b.conjugate() * _real(tape, kernels.INVERSE, lanes(b))
    if _is_complex(a):
        return a * _real(tape, kernels.QUOTIENT, 1.0, b.own, factor=1.0 / b.factor)
    factor, own = product(a)
    return _real(tape, kernels.QUOTIENT, own, b.own, factor=factor / b.factor)


def _conjugate(tape: Tape, a: TapeNumber) -> TapeNumber:
    return TapeNumber(tape, a.own, a.factor.conjugate(), not a.conjugated) if _is_complex(a) else a


def _part(tape: Tape, a: TapeNumber, imaginary: bool) -> Any:
    """Return the real or the imaginary part."""
    if not _is_complex(a):
        return 0.0 if imaginary else a
    lane, sense = a.own.lane, -1.0 if a.conjugated else 1.0
    f, g = (a.factor.imag, sense * a.factor.real) if imaginary else (a.factor.real, -sense * a.factor.imag)
    if vanishes(f) or vanishes(g):
        return TapeNumber(tape, Lane(lane + vanishes(f)), g if vanishes(f) else f)
    return _real(tape, kernels.COMBINE, Lane(lane), Lane(lane + 1), f=f, g=g)


def _amount(tape: Tape, a: TapeNumber) -> TapeNumber:
    square = _real(tape, kernels.DOT if _is_complex(a) else kernels.PRODUCT, a.own, a.own)
    return _real(tape, kernels.ROOT, square.own, factor=abs(a.factor))


OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": lambda tape, a, b: _sum(tape, a, b, 1.0),
    "subtract": lambda tape, a, b: _sum(tape, a, b, -1.0),
    "multiply": _multiply,
    "divide": _divide,
    "power": lambda tape, a, b: reduce(mul, [a] * index(b)),
    "negative": lambda tape, a: _multiply(tape, a, -1.0),
    "conjugate": _conjugate,
    "real": lambda tape, a: _part(tape, a, False),
    "imag": lambda tape, a: _part(tape, a, True),
    "abs": _amount,
    "sqrt": lambda tape, a: _real(tape, kernels.ROOT, a.lanes),
    "phase": lambda tape, a: _real(tape, kernels.PHASE, a.lanes),
}
"""The operations of the table of rules that a tape has."""
