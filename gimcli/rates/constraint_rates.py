"""Constraints on the unknowns of a step (distances, lines and closures): derivatives and gradients.

distance   (|p - q|^2 - v^2) / 2 = 0
line       n.(p - q) - v = 0
closure    p - q - w (V - U) = 0
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from gimcli.mechanism import CLOSURE, HEIGHT, SPAN
from gimcli.rates.slots import SlotValues
from gimcli.rates.tape import Number, Term
from gimcli.structure.steps import Circle, Constraint, Locus, Value


@dataclass(frozen=True)
class Imposed:
    """A distance, a line or a closure; `away` gives the slots of p - q, `vector` those of the vector."""

    of: SlotValues
    kind: int  # of kernels.constraints
    away: Callable[[int], Number]
    vector: Callable[[int], Number] | None
    value: Value

    @staticmethod
    def locus(of: SlotValues, node: int, locus: Locus) -> Imposed:
        """Return the constraint of a locus of a node."""
        hung = locus.centre if isinstance(locus, Circle) else locus.anchor

        def away(k: int) -> Number:
            arm = of.tape.plus(of.nodes[node][k], of.nodes[hung][k], -1.0)
            return arm if locus.offset is None else of.tape.plus(arm, of.vector(locus.offset, k), -1.0)

        if isinstance(locus, Circle):
            return Imposed(of, SPAN, away, None, locus.radius)
        return Imposed(of, HEIGHT, away, partial(of.vector, locus.normal), locus.distance)

    @staticmethod
    def equation(of: SlotValues, equation: Constraint) -> Imposed:
        """Return the constraint of an equation of a coupled group."""

        def away(k: int) -> Number:
            return of.tape.plus(of.nodes[equation.p][k], of.nodes[equation.q][k], -1.0)

        vector = None if equation.vector is None else partial(of.vector, equation.vector)
        return Imposed(of, equation.kind, away, vector, equation.value)

    def normal(self, k: int) -> Number:
        """Return slot k of the vector."""
        assert self.vector is not None
        return self.vector(k)

    def gradient(self) -> Number:
        """Return the gradient by p - q."""
        return self.away(0) if self.kind == SPAN else self.normal(0)

    def gradients(self, arm: Number, turning: Number) -> list[Number]:
        """Return the gradients by a complex unknown that changes p - q by `arm` and the vector by `turning`.

        The gradient of Re(conj(a) c s) by the two parts of s is the complex number conj(c) a.
        """
        tape = self.of.tape
        if self.kind == CLOSURE:
            both = tape.plus(arm, turning, -1.0)
            return [tape.products([(1.0, both, unit)], conjugate=True) for unit in (1.0 + 0j, 1j)]
        if self.kind == SPAN:
            return [tape.products([(1.0, arm, self.away(0))], conjugate=True)]
        terms: list[Term] = [(1.0, arm, self.normal(0))]
        if turning != 0.0:
            terms.append((1.0, turning, self.away(0)))
        return [tape.products(terms, conjugate=True)]

    def fill(self, to: int, k: int) -> bool:
        """Fill a lane, two for a closure, with slot k > 0 of the residual; return whether it can differ from 0."""
        of, tape = self.of, self.of.tape
        if self.kind == CLOSURE:
            apart = tape.plus(self.away(k), self.normal(k), -1.0)
            tape.put(to, apart)
            return apart != 0.0
        away = {n: self.away(n) for n in of.needed(k)}
        value = {n: of.value(self.value, n) for n in of.needed(k)}
        i, j, c = of.slots[k].cross or (0, 0, 0)
        if self.kind == SPAN:
            terms: list[Term] = [(1.0, away[0], away[k]), (1.0 * c, away[i], away[j])]
            return tape.dots(to, terms, [(-1.0, value[0], value[k]), (-1.0 * c, value[i], value[j])])
        normal = {n: self.normal(n) for n in of.needed(k)}
        return tape.dots(to, of.leibniz(normal, away, k), [(-1.0, 1.0, value[k])])
