"""A mechanism's equations as sparse polynomials: terms c f(u) a b of two coordinates and a function of one reading.

The variables are x and y of all nodes, side by side, then what every actuator and gauge reads, then 1. The functions
are 1 and, of each reading u: u, u^2, cos u, sin u. What is written once in `Constraints` for numbers is here run with
polynomials, so that no coefficient is found by evaluating.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from gimcli.mechanism import FRAME, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.exact_equations import Constraints

DUST = 1e-15
"""A coefficient below this part of its equation's greatest is what rounding left of none."""

ONE, VALUE, SQUARE, COSINE, SINE = range(5)

Key = tuple[int, int, int]
"""Function, and two variables in order."""


@dataclass(frozen=True)
class Term:
    """factor f(u) a b."""

    factor: float
    function: int  # 0: 1, else 4 reading + VALUE ... SINE
    first: int
    second: int


@dataclass(frozen=True)
class Terms:
    """The equations of a mechanism."""

    mechanism: Mechanism
    equations: tuple[tuple[Term, ...], ...]
    moving: tuple[int, ...]  # variables that the equations tell, but for the readings

    @property
    def first_reading(self) -> int:
        """Variable of the first actuator's reading."""
        return 2 * len(self.mechanism.nodes)

    @property
    def readings(self) -> int:
        """Number of actuators; where gauges are read, they are among them."""
        return len(self.mechanism.actuators)

    @property
    def variables(self) -> int:
        """Number of variables, that of 1 among them."""
        return self.first_reading + self.readings + 1

    @property
    def functions(self) -> int:
        """Number of functions."""
        return 1 + 4 * self.readings

    def owner(self, function: int) -> int:
        """Return the variable that a function is of; 1 for the constant."""
        return self.variables - 1 if function == ONE else self.first_reading + (function - 1) // 4


def with_gauges(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose gauges are read as if they were actuators."""
    return replace(mechanism, actuators=(*mechanism.actuators, *mechanism.gauges), gauges=())


@derived
def make_terms(mechanism: Mechanism) -> Terms:
    """Return the equations of a mechanism."""
    constraints = Constraints(mechanism)
    one = 2 * len(mechanism.nodes) + len(mechanism.actuators)
    free = constraints.free
    nodes: list[Any] = [Polynomial({(ONE, one, one): complex(z)}, one) for z in mechanism.drawn]
    for k, z in zip(mechanism.members[FRAME].nodes, mechanism.members[FRAME].shape, strict=True):
        nodes[k] = Polynomial({(ONE, one, one): complex(z)}, one)
    for k in free:
        nodes[k] = Polynomial({(ONE, 2 * k, one): 1.0 + 0j, (ONE, 2 * k + 1, one): 1j}, one)
    values, turns = [], []
    for k in range(len(mechanism.actuators)):
        at = 4 * k
        values.append(Polynomial({(at + VALUE, one, one): 1.0 + 0j}, one))
        turns.append(Polynomial({(at + COSINE, one, one): 1.0 + 0j, (at + SINE, one, one): 1j}, one))
    equations = []
    for part, value in constraints.equations(nodes, values, turns):
        equations += [value.part("real")] * (part != "imag") + [value.part("imag")] * (part != "real")
    return Terms(mechanism, tuple(equations), tuple(2 * k + c for k in free for c in (0, 1)))


class Polynomial:
    """A sum of terms with complex factors."""

    def __init__(self, terms: Mapping[Key, complex], one: int) -> None:
        self.terms, self.one = terms, one

    def __add__(self, other: Any) -> Polynomial:
        total = dict(self.terms)
        for key, factor in self._lifted(other).items():
            total[key] = total.get(key, 0j) + factor
        return Polynomial(total, self.one)

    __radd__ = __add__

    def __neg__(self) -> Polynomial:
        return Polynomial({key: -factor for key, factor in self.terms.items()}, self.one)

    def __sub__(self, other: Any) -> Polynomial:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Polynomial:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Polynomial:
        total: dict[Key, complex] = {}
        for (f, a, b), factor in self.terms.items():
            for (g, c, d), other_factor in self._lifted(other).items():
                key = (_product(f, g), *self._pair(a, b, c, d))
                total[key] = total.get(key, 0j) + factor * other_factor
        return Polynomial(total, self.one)

    __rmul__ = __mul__

    def __truediv__(self, other: complex) -> Polynomial:
        return Polynomial({key: factor / other for key, factor in self.terms.items()}, self.one)

    def conjugate(self) -> Polynomial:
        """Return the polynomial that is conjugate where the variables are real."""
        return Polynomial({key: factor.conjugate() for key, factor in self.terms.items()}, self.one)

    def part(self, which: str) -> tuple[Term, ...]:
        """Return the real or the imaginary part."""
        factors = {key: getattr(factor, which) for key, factor in self.terms.items()}
        dust = DUST * max(map(abs, factors.values()), default=0.0)
        return tuple(Term(factor, *key) for key, factor in factors.items() if abs(factor) > dust)

    def _lifted(self, other: Any) -> Mapping[Key, complex]:
        return other.terms if isinstance(other, Polynomial) else {(ONE, self.one, self.one): complex(other)}

    def _pair(self, *variables: int) -> tuple[int, int]:
        kept = sorted(v for v in variables if v != self.one)
        if len(kept) > 2:
            raise ValueError("an equation of a degree above the second")
        first, second = (*kept, self.one, self.one)[:2]
        return first, second


def _product(f: int, g: int) -> int:
    if ONE in (f, g):
        return f + g
    if f == g and (f - 1) % 4 + 1 == VALUE:
        return f + SQUARE - VALUE
    raise ValueError("an equation with a product of functions of two inputs")


def is_rotary(terms: Terms, reading: int) -> bool:
    """Tell whether a reading is an angle."""
    return terms.mechanism.actuators[reading].rotary
