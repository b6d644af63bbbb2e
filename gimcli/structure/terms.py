"""The equations of a mechanism as sums of terms c f(u) a b, with their derivatives, at one position or at many.

a and b are variables: the coordinates of all nodes, those of a node side by side, then the reading u of every actuator
and gauge, then 1. A reading is the value of the quantity that an actuator drives or a gauge measures. f is 1, or a
function of one reading: u, u^2, cos u or sin u. Values of the variables (..., variables) may have leading axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism

ONE, VALUE, SQUARE, COSINE, SINE = range(5)

DERIVATIVES = {ONE: (0.0, ONE), VALUE: (1.0, ONE), SQUARE: (2.0, VALUE), COSINE: (-1.0, SINE), SINE: (1.0, COSINE)}
"""The derivative of each function: a factor and a function."""


@dataclass(frozen=True)
class Term:
    """The term factor * f(u) * a * b."""

    factor: float
    function: int  # 0 for f = 1, else 4 * reading + VALUE, SQUARE, COSINE or SINE
    first: int  # variable a
    second: int  # variable b


@dataclass(frozen=True)
class Terms:
    """The equations of a mechanism."""

    mechanism: Mechanism
    equations: tuple[tuple[Term, ...], ...]
    moving: tuple[int, ...]  # unknown variables: coordinates of the moving nodes
    dimension: int = 2  # number of coordinates of a node

    @property
    def first_reading(self) -> int:
        """Number of the variable that is the first actuator's reading."""
        return self.dimension * len(self.mechanism.nodes)

    @property
    def readings(self) -> int:
        """Number of readings: of actuators, and of gauges if they were added by `with_gauges`."""
        return len(self.mechanism.actuators)

    @property
    def variables(self) -> int:
        """Number of variables, including the constant 1."""
        return self.first_reading + self.readings + 1

    @property
    def functions(self) -> int:
        """Number of functions."""
        return 1 + 4 * self.readings

    def owner(self, function: int) -> int:
        """Return the number of the variable u of a function; for the function 1, that of the constant 1."""
        return self.variables - 1 if function == ONE else self.first_reading + (function - 1) // 4

    def is_rotary(self, reading: int) -> bool:
        """Return whether a reading is an angle."""
        return self.mechanism.actuators[reading].rotary

    @cached_property
    def arrays(self) -> TermArrays:
        """The terms as arrays, for values and derivatives in all variables (..., variables)."""
        return TermArrays(self.equations, self.first_reading, range(self.variables))


def coordinates(z: ComplexArray) -> FloatArray:
    """Return the coordinates (..., 2 nodes) of places (..., nodes) in the plane."""
    return np.ascontiguousarray(z).view(float)


def places(x: FloatArray) -> ComplexArray:
    """Return the places (..., nodes) in the plane of coordinates (..., 2 nodes)."""
    return np.asarray(x[..., 0::2] + 1j * x[..., 1::2])


class TermArrays:
    """The terms of all equations as arrays, in some of the variables, v (..., columns), the last of which is 1."""

    def __init__(self, equations: Sequence[Sequence[Term]], first: int, columns: Sequence[int]) -> None:
        """Number the variables that occur in the equations by their places in `columns`; first: the first reading."""
        place, one = {variable: k for k, variable in enumerate(columns)}, columns[-1]
        none = (Term(0.0, ONE, one, one),)  # so that no equation is empty
        every = [(row, t) for row, equation in enumerate(equations) for t in equation or none]
        kinds = [(t.function - 1) % 4 + 1 if t.function else ONE for _, t in every]
        owners = [place[first + (t.function - 1) // 4 if t.function else one] for _, t in every]
        ints = [(row, place[t.first], place[t.second], own) for (row, t), own in zip(every, owners, strict=True)]
        self.row, self.first, self.second, self.owner = np.array(ints, dtype=np.int64).reshape(-1, 4).T
        self.factor, self.count, self.width = np.array([t.factor for _, t in every]), len(equations), len(columns)
        used = set(zip(kinds, owners, strict=True))
        angles, lengths = (sorted({u for k, u in used if k in own}) for own in ((COSINE, SINE), (VALUE, SQUARE)))
        listed = [(ONE, self.width - 1), *((k, u) for k in (COSINE, SINE) for u in angles)]
        listed += [(k, u) for k in (VALUE, SQUARE) for u in lengths]
        number = {one: k for k, one in enumerate(listed)}
        sign = np.array([DERIVATIVES[kind][0] for kind, _ in listed])
        after = np.array([number.get((DERIVATIVES[kind][1], u), 0) for kind, u in listed], dtype=np.int64)
        own = np.array([number[one] for one in zip(kinds, owners, strict=True)], dtype=np.int64)
        self._owns = (own, after[own], after[after[own]], after[after[after[own]]])  # f and its three derivatives
        self._signs = np.cumprod([np.ones(len(own)), *(sign[one] for one in self._owns[:3])], axis=0)
        self._angles, self._lengths = np.array(angles, dtype=np.int64), np.array(lengths, dtype=np.int64)
        self._begin = np.flatnonzero(np.diff(self.row, prepend=-1))  # the first term of each equation
        self._nest()
        column = np.concatenate([self.first, self.second, self.owner])
        where = np.tile(self.row, 3) * self.width + column
        part = np.argsort(where, kind="stable")
        self._part = part[column[part] < self.width - 1]  # derivatives by a, by b and by u, in the order of the table
        self._first_part = np.flatnonzero(np.diff(where[self._part], prepend=-1))  # of each place in the table
        self._place = where[self._part][self._first_part]
        self.scale(np.ones(self.count), 0.0, 0)

    def _nest(self) -> None:
        """Write each equation as a sum of a (sum of c f b): half of a term a b stands under a and half under b.

        Differences of coordinates are then formed before they are multiplied: rounding errors are not those of the
        squares of coordinates. 1 is the first a of an equation: reduceat adds the first to the sum of the others.
        """
        low, high = np.minimum(self.first, self.second), np.maximum(self.first, self.second)
        halved = (low < high) & (high < self.width - 1)
        term, column = np.append(np.arange(len(low)), np.flatnonzero(halved)), np.append(low, high[halved])
        where = self.row[term] * self.width + (column + 1) % self.width
        order = np.argsort(where, kind="stable")
        self._nested, self._inner = term[order], np.append(high, low[halved])[order]
        self._share, self._inner_owns = np.where(halved, 0.5, 1.0)[self._nested], self._owns[0][self._nested]
        self._first_inner = np.flatnonzero(np.diff(where[order], prepend=-1))  # of each a
        ahead = order[self._first_inner]
        self._outer, self._first_outer = column[ahead], np.flatnonzero(np.diff(self.row[term[ahead]], prepend=-1))

    def scale(self, factors: FloatArray, least: float, unknowns: int) -> None:
        """Multiply the equations by factors (equations,); terms in the first `unknowns` below `least` become 0."""
        self.factor = self.factor * factors[self.row]
        self.factor[(np.abs(self.factor) < least) & (np.minimum(self.first, self.second) < unknowns)] = 0.0
        self._weights = self._signs * self.factor
        self._inner_weights = self.factor[self._nested] * self._share

    def parts(self, v: FloatArray) -> FloatArray:
        """Return the values of all terms (..., terms)."""
        return np.asarray(
            self._functions(self._every(v), 0)[0] * v.take(self.first, axis=-1) * v.take(self.second, axis=-1)
        )

    def values(self, v: FloatArray) -> FloatArray:
        """Return the values of the equations (..., equations)."""
        return self._values(v, self._every(v))

    def slopes(self, v: FloatArray) -> FloatArray:
        """Return the derivatives of the equations by all variables (..., equations, columns); by 1 they are 0."""
        return self._slopes(v, self._every(v))

    def linearised(self, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the values and the slopes."""
        every = self._every(v)
        return self._values(v, every), self._slopes(v, every)

    def _values(self, v: FloatArray, every: FloatArray) -> FloatArray:
        inner = self._inner_weights * every.take(self._inner_owns, axis=-1) * v.take(self._inner, axis=-1)
        outer = np.add.reduceat(inner, self._first_inner, axis=-1) * v.take(self._outer, axis=-1)
        return np.asarray(np.add.reduceat(outer, self._first_outer, axis=-1))

    def _slopes(self, v: FloatArray, every: FloatArray) -> FloatArray:
        a, b, (f, g) = v.take(self.first, axis=-1), v.take(self.second, axis=-1), self._functions(every, 1)
        return self._table(f * b, f * a, g * a * b)

    def slopes_along(self, v: FloatArray, along: FloatArray) -> FloatArray:
        """Return the derivatives of the slopes (..., equations, columns) along a direction (..., columns).

        The direction has a 0 for the constant 1.
        """
        (a, b, _), (da, db, du), (f, g, h) = self._factors(v), self._factors(along), self._functions(self._every(v), 2)
        turned, both = g * du, da * b + a * db
        return self._table(turned * b + f * db, turned * a + f * da, h * du * a * b + g * both)

    def third(self, v: FloatArray, along: FloatArray) -> FloatArray:
        """Return the third derivative of the equations (..., equations) along a direction, taken three times."""
        (a, b, _), (da, db, du) = self._factors(v), self._factors(along)
        _, g, h, k = self._functions(self._every(v), 3)
        parts = du * (du * du * k * a * b + 3.0 * du * h * (da * b + a * db) + 6.0 * g * da * db)
        return np.asarray(np.add.reduceat(parts, self._begin, axis=-1))

    def _factors(self, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the variables a, b and u of all terms (..., terms)."""
        return v.take(self.first, axis=-1), v.take(self.second, axis=-1), v.take(self.owner, axis=-1)

    def _functions(self, every: FloatArray, order: int) -> list[FloatArray]:
        """Return c f (..., terms) of the terms, and the derivatives by their readings up to an order."""
        return [self._weights[k] * every.take(self._owns[k], axis=-1) for k in range(order + 1)]

    def _every(self, v: FloatArray) -> FloatArray:
        """Return 1, the cosines and sines of the angles, and the lengths and their squares (..., functions)."""
        parts = [v[..., -1:]]
        if len(self._angles):
            turn = np.exp(1j * v.take(self._angles, axis=-1))
            parts += turn.real, turn.imag
        if len(self._lengths):
            u = v.take(self._lengths, axis=-1)
            parts += u, u * u
        return np.concatenate(parts, axis=-1)

    def _table(self, *parts: FloatArray) -> FloatArray:
        """Return a table (..., equations, columns) of the derivatives by a, by b and by u (..., terms)."""
        table = np.zeros((*parts[0].shape[:-1], self.count * self.width))
        every = np.concatenate(parts, axis=-1).take(self._part, axis=-1)
        table[..., self._place] = np.add.reduceat(every, self._first_part, axis=-1)
        return table.reshape(*table.shape[:-1], self.count, self.width)
