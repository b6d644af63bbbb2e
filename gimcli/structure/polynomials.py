"""The terms of the equations of a mechanism, found by evaluating `Constraints` with polynomials instead of numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from gimcli.mechanism import FRAME, Coupling, FloatArray, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.exact_equations import Constraints
from gimcli.structure.terms import COSINE, ONE, SINE, SQUARE, VALUE, Term, Terms

ZERO = 1e-15
"""A coefficient below this fraction of the greatest in its equation is a rounding error of 0."""

Key = tuple[int, int, int]
"""Number of the function, and two variables in ascending order."""


def with_gauges(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose gauges are appended to its actuators."""
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


def with_linked_gauges(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with a gauge for each quantity of the linkage that inputs follow."""
    rows = dict.fromkeys(row for coupling in mechanism.couplings for row, _ in coupling.reads)
    return replace(mechanism, gauges=(*mechanism.gauges, *rows)) if rows else mechanism


def coupled_terms(mechanism: Mechanism) -> Terms:
    """Return the equations of a mechanism and of its couplings: u - phase - sum of ratio times input or quantity = 0.

    The quantities of the linkage that inputs follow are actuators, by `with_linked_gauges` and `with_gauges`.
    """
    terms = make_terms(mechanism)
    if not mechanism.couplings:
        return terms
    first, one = terms.first_reading, terms.variables - 1
    equations = [
        (
            Term(1.0, ONE, first + coupling.follower, one),
            *(Term(-ratio, ONE, first + reading, one) for reading, ratio in followed(mechanism, coupling)),
            Term(-coupling.phase, ONE, one, one),
        )
        for coupling in mechanism.couplings
    ]  # fmt: skip
    return replace(terms, equations=(*terms.equations, *equations))


def linked_terms(mechanism: Mechanism) -> Terms:
    """Return the equations of a mechanism and of the inputs that follow its linkage, with what these read as inputs."""
    linked = tuple(coupling for coupling in mechanism.couplings if coupling.reads)
    if not linked:
        return make_terms(mechanism)
    return coupled_terms(with_gauges(with_linked_gauges(replace(mechanism, couplings=linked, gauges=()))))


def followed(mechanism: Mechanism, coupling: Coupling) -> list[tuple[int, float]]:
    """Return the readings that an input follows, with their ratios."""
    return [*coupling.terms, *((mechanism.actuators.index(row), ratio) for row, ratio in coupling.reads)]


def continue_linked(terms: Terms, v: FloatArray) -> None:
    """Add full turns to the angles of the linkage that inputs follow, so that they agree with these inputs."""
    mechanism, first = terms.mechanism, terms.first_reading
    for coupling in mechanism.couplings:
        for row, ratio in coupling.reads:
            if row.rotary:
                rest = v[first + coupling.follower] - coupling.phase
                rest -= sum(factor * v[first + k] for k, factor in followed(mechanism, coupling))
                v[first + mechanism.actuators.index(row)] += 2.0 * math.pi * round(rest / ratio / (2.0 * math.pi))


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
        """Return the complex conjugate; the variables are real."""
        return Polynomial({key: factor.conjugate() for key, factor in self.terms.items()}, self.one)

    def part(self, which: str) -> tuple[Term, ...]:
        """Return the terms of the "real" or the "imag" part."""
        factors = {key: getattr(factor, which) for key, factor in self.terms.items()}
        bound = ZERO * max(map(abs, factors.values()), default=0.0)
        return tuple(Term(factor, *key) for key, factor in factors.items() if abs(factor) > bound)

    def _lifted(self, other: Any) -> Mapping[Key, complex]:
        return other.terms if isinstance(other, Polynomial) else {(ONE, self.one, self.one): complex(other)}

    def _pair(self, *variables: int) -> tuple[int, int]:
        kept = sorted(v for v in variables if v != self.one)
        if len(kept) > 2:
            raise ValueError("an equation of a degree above 2")
        first, second = (*kept, self.one, self.one)[:2]
        return first, second


def _product(f: int, g: int) -> int:
    if ONE in (f, g):
        return f + g
    if f == g and (f - 1) % 4 + 1 == VALUE:
        return f + SQUARE - VALUE
    raise ValueError("an equation with a product of functions of two inputs")
