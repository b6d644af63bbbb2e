"""Complex and real numbers over rows, recorded as a tape of operations; constants are computed while recording.

`ComplexLanes` is a complex number that varies from row to row, a plain complex number is constant; likewise `Lane` and
float. A constant may be a recorded number, which depends on the dimensions. Lanes taken inside a `step` block are used
again after it.

`tape_values` runs the operations on any numbers: arrays over rows, or dual numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
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
        return w, heads, np.array([(nominal(f), nominal(g)) for f, g in self.factors], dtype=float).reshape(-1, 2)

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


Lanes = dict[int, Any]


def tape_values(heads: IntArray, factors: Sequence[Sequence[Any]], w: Lanes, z: Any, given: Any) -> tuple[Any, Any]:
    """Return points[slot, point] and angles[slot, member] (rows,) as dicts.

    factors (operations, 2) and the constants in the lanes w: numbers. z[node] and given[slot, actuator] (rows,).
    """
    points: dict[tuple[int, int], Any] = {}
    angles: dict[tuple[int, int], Any] = {}

    def pair(k: int) -> Any:
        return w[k] + 1j * w[k + 1]

    for head, (f, g) in zip(heads.tolist(), factors, strict=True):
        op, to, a, b, *more = head
        if op == kernels.WRITE_POINT:
            points[a, b] = pair(to)
        elif op == kernels.WRITE_ANGLE:
            angles[a, b] = w[to]
        elif op == kernels.FACTOR:
            pass
        elif op == kernels.SOLVE:
            m, n = int(nominal(f)), int(nominal(g))
            _solve(w, to, a, m, n)
        elif op in REAL:
            w[to] = REAL[op](w, pair, f, g, a, b, *more) + (w[to] if op in ADDED else 0.0)
        else:
            if op == kernels.NODE:
                found = z[a]
            elif op == kernels.VALUE:
                w[to] = given[a, b]
                continue
            else:
                found = COMPLEX[op](w, pair, f + 1j * g, a, b, *more) + (pair(to) if op in ADDED else 0.0)
            w[to], w[to + 1] = found.real, found.imag
    return points, angles


Operation = Callable[..., Any]

REAL: dict[int, Operation] = {
    kernels.DOT: lambda w, pair, f, g, a, b, *_: f * (w[a] * w[b] + w[a + 1] * w[b + 1]),
    kernels.PRODUCT: lambda w, pair, f, g, a, b, *_: f * w[a] * w[b],
    kernels.AFFINE: lambda w, pair, f, g, a, *_: f + g * w[a],
    kernels.INVERSE: lambda w, pair, f, g, a, *_: 1.0 / (w[a] * w[a] + w[a + 1] * w[a + 1]),
    kernels.ACROSS: lambda w, pair, f, g, a, b, c, _: _cross(w, a, b) * w[c],
    kernels.DETERMINANT: lambda w, pair, f, g, a, b, *_: 1.0 / _cross(w, a, b),
}
"""Operations with a real result."""
REAL |= {kernels.ADD_DOT: REAL[kernels.DOT], kernels.ADD_PRODUCT: REAL[kernels.PRODUCT]}

COMPLEX: dict[int, Operation] = {
    kernels.SCALE: lambda w, pair, z, a, *_: z * pair(a),
    kernels.LINEAR: lambda w, pair, z, a, b, *_: pair(a) + z * pair(b),
    kernels.CARRY: lambda w, pair, z, a, b, c, _: pair(a) + z * (pair(b) - pair(c)),
    kernels.TIMES: lambda w, pair, z, a, b, *_: z.real * pair(a) * pair(b),
    kernels.CONJUGATE: lambda w, pair, z, a, b, *_: z.real * pair(a).conjugate() * pair(b),
    kernels.TURN: lambda w, pair, z, a, b, *_: z.real * 1j * w[a] * pair(b),
    kernels.COS_SIN: lambda w, pair, z, a, *_: np.cos(w[a]) + 1j * np.sin(w[a]),
    kernels.UNIT: lambda w, pair, z, a, *_: pair(a) / abs(pair(a)),
    kernels.MEET: lambda w, pair, z, a, b, c, d: 1j * (w[c] * pair(b) - w[c + 1] * pair(a)) * w[d],
    kernels.NEGATIVE: lambda w, pair, z, a, *_: -pair(a),
}
"""Operations with a complex result."""
COMPLEX |= {
    kernels.ADD_TIMES: COMPLEX[kernels.TIMES],
    kernels.ADD_CONJUGATE: COMPLEX[kernels.CONJUGATE],
    kernels.ADD_TURN: COMPLEX[kernels.TURN],
}

ADDED = {
    kernels.ADD_DOT, kernels.ADD_PRODUCT, kernels.ADD_TIMES, kernels.ADD_CONJUGATE, kernels.ADD_TURN,
}  # fmt: skip
"""Operations that add to their lanes."""


def _cross(w: Lanes, a: int, b: int) -> Any:
    return w[a] * w[b + 1] - w[a + 1] * w[b]


def _solve(w: Lanes, right: int, a: int, m: int, n: int) -> None:
    """Solve the equations A x = b of a group in place of b; the derivatives are those of A x' = b' - A' x."""
    some = sum((0.0 * w[right + k] for k in range(m)), 0.0)
    table, own = (
        np.stack([w[k] + some for k in range(first, first + count)]) for first, count in ((a, m * n), (right, m))
    )
    known = np.nan_to_num(np.moveaxis(nominal(table).reshape(m, n, -1), 2, 0))
    inverse = np.linalg.pinv(known)
    found = np.einsum("rnm,mr->nr", inverse, nominal(own))
    if isinstance(own, Dual):
        moved = own.slopes - np.einsum("tmnr,nr->tmr", table.slopes.reshape(-1, m, n, found.shape[1]), found)
        found = Dual(found, np.einsum("rnm,tmr->tnr", inverse, moved))
    for k in range(n):
        w[right + k] = found[k]
