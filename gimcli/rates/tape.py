"""Complex and real numbers over rows, recorded as a tape of operations; constants are computed while recording.

`ComplexLanes` is a complex number that varies from row to row, a plain complex number is constant; likewise `Lane` and
float. A constant may be a recorded number, which depends on the dimensions. Lanes taken inside a `step` block are used
again after it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.calculus.numbers import RuleNumber, nominal, scalar
from gimcli.calculus.recorded import Recorded
from gimcli.kernels import tape as kernels
from gimcli.kernels.lanes import WIDTH, aligned
from gimcli.mechanism import FloatArray, IntArray


@dataclass(frozen=True)
class ComplexLanes:
    """A complex number in two lanes."""

    lane: int


@dataclass(frozen=True)
class Lane:
    """A real number in a lane."""

    lane: int


Number = ComplexLanes | complex
Real = Lane | float
Term = tuple[float, Number, Number]
RealTerm = tuple[float, Real, Real]

STEP = 1 << 40
CONSTANT = 1 << 41
"""First provisional numbers of the lanes of a step and of constants; `arrays` replaces them by final numbers."""

MAKING = (kernels.SCALE, kernels.LINEAR, kernels.CARRY, kernels.TIMES, kernels.CONJUGATE, kernels.UNIT)
"""Operations that fill two lanes."""


def vanishes(number: Number | Real) -> bool:
    """Return whether a number is 0 whatever the row and the dimensions are."""
    return not isinstance(number, (ComplexLanes, Lane, RuleNumber)) and number == 0.0


class Tape:
    """Operations and the lanes that they need."""

    def __init__(self) -> None:
        self.heads: list[list[int]] = []
        self.factors: list[tuple[Any, Any]] = []
        self.constants: dict[Any, tuple[int, Any]] = {}  # lanes and value, by value or place in the recording
        self.kept, self.used, self.most = kernels.LANES, 0, 0
        self.known: dict[Any, Any] = {}  # results in this step, by operation and operands
        self.begin = 0  # first operation of this step

    # -- lanes ---------------------------------------------------------------------------------

    @contextmanager
    def step(self) -> Iterator[None]:
        """Release the lanes that are taken inside the block at its end."""
        before = self.used, self.known, self.begin
        self.known, self.begin = self.known.copy(), len(self.heads)
        yield
        self.used, self.known, self.begin = before

    def take(self, lanes: int) -> int:
        """Return the number of the first of some lanes for this step."""
        self.used += lanes
        self.most = max(self.most, self.used)
        return STEP + self.used - lanes

    def keep(self, lanes: int) -> int:
        """Return the number of the first of some permanent lanes."""
        self.kept += lanes
        return self.kept - lanes

    def constant(self, value: Any) -> int:
        """Return the lanes of a constant."""
        key = (value.place,) if isinstance(value, Recorded) else complex(value)
        return self.constants.setdefault(key, (CONSTANT + 2 * len(self.constants), value))[0]

    def lane(self, value: Number | Real) -> int:
        """Return the lane of a number."""
        return value.lane if isinstance(value, (ComplexLanes, Lane)) else self.constant(value)

    def arrays(self) -> tuple[FloatArray, IntArray, FloatArray]:
        """Return the arrays of the kernel: lanes with constants, operations, factors."""
        factors = [(nominal(f), nominal(g)) for f, g in self.factors]
        return *self.operations(), np.array(factors, dtype=float).reshape(-1, 2)

    def operations(self) -> tuple[FloatArray, IntArray]:
        """Return lanes with constants, and operations."""
        heads = np.array(self.heads, dtype=np.int64).reshape(-1, 6)
        constants = self.kept + self.most
        operands = heads[:, 1:]
        for base, place in ((CONSTANT, constants), (STEP, self.kept)):
            np.add(operands, place - base, out=operands, where=operands >= base)
        w = aligned((constants + 2 * len(self.constants)) * WIDTH)
        self.fixed = w[constants * WIDTH :].reshape(-1, 2, WIDTH)
        self.fixed[:] = np.array([(nominal(c).real, nominal(c).imag) for _, c in self.constants.values()]).reshape(
            -1, 2, 1
        )
        return w, heads

    # -- operations ----------------------------------------------------------------------------

    def emit(self, op: int, to: int, *operands: int, f: Any = 1.0, g: Any = 0.0) -> None:
        """Record an operation."""
        self.heads.append([op, to, *operands, *[0] * (4 - len(operands))])
        self.factors.append((f, g))

    def pair(self, op: int, *operands: int, z: Any = 1.0) -> ComplexLanes:
        """Record an operation with a complex result, unless it is known."""
        key = op, operands, _key(z)
        found: ComplexLanes | None = self.known.get(key)
        if found is None:
            found = self.known[key] = ComplexLanes(self.take(2))
            self.emit(op, found.lane, *operands, f=z.real, g=z.imag)
        return found

    def real(self, op: int, *operands: int, f: Any = 1.0, g: Any = 0.0) -> Lane:
        """Record an operation with a real result."""
        to = self.take(1)
        self.emit(op, to, *operands, f=f, g=g)
        return Lane(to)

    def scaled(self, a: Number, z: complex) -> Number:
        """Return z a."""
        if vanishes(a) or vanishes(z):
            return 0j
        if not isinstance(a, ComplexLanes):
            return a * z
        return a if vanishes(z - 1.0) else self.pair(kernels.SCALE, a.lane, z=scalar(z))

    def plus(self, a: Number, b: Number, z: complex = 1.0) -> Number:
        """Return a + z b."""
        if not isinstance(b, ComplexLanes):
            if not isinstance(a, ComplexLanes):
                return a + z * b
            return a if vanishes(b) or vanishes(z * b) else self.pair(kernels.LINEAR, a.lane, self.constant(z * b))
        if vanishes(z):
            return a
        if vanishes(a):
            return self.scaled(b, z)
        return self.pair(kernels.LINEAR, self.lane(a), b.lane, z=scalar(z))

    def carried(self, a: Number, b: Number, c: Number, z: complex) -> Number:
        """Return a + z (b - c)."""
        if isinstance(b, ComplexLanes) and isinstance(c, ComplexLanes) and not vanishes(z):
            return self.pair(kernels.CARRY, self.lane(a), b.lane, c.lane, z=scalar(z))
        return self.plus(a, self.plus(b, c, -1.0), z)

    def products(self, terms: Sequence[Term], conjugate: bool = False) -> Number:
        """Return the sum of f a b, or of f conj(a) b."""
        key = conjugate, tuple(tuple(map(_key, term)) for term in terms)
        found: Number | None = self.known.get(key)
        if found is None:
            found = self.known[key] = self._products(terms, conjugate)
        return found

    def _products(self, terms: Sequence[Term], conjugate: bool) -> Number:
        first, more = (kernels.CONJUGATE, kernels.ADD_CONJUGATE) if conjugate else (kernels.TIMES, kernels.ADD_TIMES)
        result: Number = 0j
        found: ComplexLanes | None = None
        for f, a, b in terms:
            if isinstance(a, ComplexLanes) and (isinstance(b, ComplexLanes) or (conjugate and not vanishes(b))):
                if found is None:
                    found = ComplexLanes(self.take(2))
                    self.emit(first, found.lane, a.lane, self.lane(b), f=f)
                else:
                    self.emit(more, found.lane, a.lane, self.lane(b), f=f)
            elif isinstance(a, ComplexLanes):
                assert not isinstance(b, ComplexLanes)
                result = self.plus(result, a, f * b)
            else:
                result = self.plus(result, b, f * (a.conjugate() if conjugate else a))
        return result if found is None else self.plus(found, result)

    def dots(self, to: int, terms: Sequence[Term], reals: Sequence[RealTerm] = ()) -> bool:
        """Fill a lane with the sum of f a.b and of f p q; return whether it can differ from 0."""
        fixed, varied = 0.0, list[RealTerm]()
        for f, p, q in reals:
            if isinstance(p, Lane) or isinstance(q, Lane):
                varied.append((f, p, q))
            else:
                fixed = fixed + f * p * q
        first = vanishes(fixed)
        if not first:
            self.emit(kernels.AFFINE, to, self.constant(0.0), f=fixed, g=0.0)
        for (one, more), some in (
            ((kernels.DOT, kernels.ADD_DOT), terms), ((kernels.PRODUCT, kernels.ADD_PRODUCT), varied)
        ):  # fmt: skip
            for f, a, b in some:
                if not any(map(vanishes, (f, a, b))):
                    self.emit(one if first else more, to, self.lane(a), self.lane(b), f=f)
                    first = False
        if first:
            self.emit(kernels.AFFINE, to, self.constant(0.0), f=0.0, g=0.0)
        return not first

    def put(self, to: int, value: Number) -> None:
        """Store a complex number in two lanes."""
        self.emit(kernels.SCALE, to, self.lane(value), g=0.0)

    def kept_number(self, value: Number) -> Number:
        """Return a number in permanent lanes; if the last operation gave it, that operation writes there."""
        if not isinstance(value, ComplexLanes) or value.lane < STEP:
            return value
        to, last = self.keep(2), self.heads[-1]
        if last[1] == value.lane and last[0] in MAKING and len(self.heads) > self.begin:
            last[1] = to
            self.known = {key: ComplexLanes(to) if one == value else one for key, one in self.known.items()}
        else:
            self.put(to, value)
        return ComplexLanes(to)


def _key(number: Any) -> Any:
    """Return what distinguishes a number from others: recorded ones with the same value differ."""
    return (number.place,) if isinstance(number, Recorded) else number
