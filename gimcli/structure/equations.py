"""The constraints of a mechanism in the plane, written as equations of terms of at most second degree.

    SPAN      |p - q|^2 - value^2 = 0
    HEIGHT    Re(conj(w) (p - q)) - value = 0        w = z (V - U) e^(+-i theta), |w| = 1
    ANGLE     Im(conj(w) (p - q)) = 0
    CLOSURE   p - q - w = 0

The value of a SPAN is a constant or an input; the constant part of a height is multiplied by |w|^2. Values and
derivatives, ranks, freedoms and the gradients of sequences follow from the terms.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from gimcli.canonical import beside
from gimcli.mechanism import ANGLE, CLOSURE, FRAME, HEIGHT, SPAN, ComplexArray, Coupling, FloatArray, Mechanism
from gimcli.structure.carried import measured
from gimcli.structure.derived import derived
from gimcli.structure.kinematic_nodes import base_first, moving_nodes
from gimcli.structure.pair_rows import constraint_of, pair_rows
from gimcli.structure.steps import NONE, Constraint, Value, Vector
from gimcli.structure.terms import COSINE, ONE, SINE, SQUARE, VALUE, Term, Terms, coordinates

ZERO = 1e-15
"""A coefficient below this fraction of the greatest in its equation is a rounding error of 0."""

Linear = Mapping[int, complex]
"""A complex number that is linear in the variables: the factor of each."""

PARTS = {SPAN: ("real",), HEIGHT: ("real",), ANGLE: ("imag",), CLOSURE: ("real", "imag")}
"""The parts of a complex equation that are 0."""


@derived
def make_terms(mechanism: Mechanism) -> Terms:
    """Return the equations of members, pairs and actuators."""
    frame, free = mechanism.members[FRAME], moving_nodes(mechanism)
    one = 2 * len(mechanism.nodes) + len(mechanism.actuators)
    places: list[Linear] = [{one: complex(z)} for z in mechanism.drawn]
    for k, z in zip(frame.nodes, frame.shape, strict=True):
        places[k] = {one: complex(z)}
    for k in free:
        places[k] = moving_place(k)
    equations = tuple(written(constraints(mechanism, base_first(mechanism)), places, one))
    return Terms(mechanism, equations, tuple(2 * k + c for k in free for c in (0, 1)))


def constraints(mechanism: Mechanism, nodes: Sequence[Sequence[int]]) -> Iterator[Constraint]:
    """Yield the constraints of members, pairs and actuators as written in the file.

    nodes: of each member, those that have coordinates; the first two of them determine its direction.
    """
    for member, (u, v, *others) in zip(mechanism.members[FRAME + 1 :], nodes[FRAME + 1 :], strict=True):
        reach = member.reach(u, v)
        yield Constraint(member.name, SPAN, v, u, Value(abs(reach)))
        for node in others:
            yield Constraint(member.name, CLOSURE, node, u, Value(0.0), Vector(member.reach(u, node) / reach, u, v))
    for row in pair_rows(mechanism):
        yield constraint_of(mechanism, row, row.value, nodes)


def moving_place(node: int) -> Linear:
    """Return the place of a node with two coordinates."""
    return {2 * node: 1.0 + 0.0j, 2 * node + 1: 1j}


def with_gauges(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose gauges are appended to its actuators."""
    return replace(mechanism, actuators=(*mechanism.actuators, *mechanism.gauges), gauges=())


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


def variables_at(
    terms: Terms, z: ComplexArray, inputs: FloatArray, gauges: FloatArray | None = None
) -> FloatArray:  # fmt: skip
    """Return the variables at positions z (nodes,) and inputs (actuators,).

    What the gauges read is measured; angles are near those of the gauges given, or the initial ones. Those of the
    linkage that inputs follow agree with these inputs: full turns are added.
    """
    mechanism, first = terms.mechanism, terms.first_reading
    v, end = np.ones(terms.variables), first + len(inputs)
    v[:first], v[first:end] = coordinates(z), inputs
    read = mechanism.actuators[len(inputs) :]
    near = [gauge.drawn for gauge in read]
    if gauges is not None:
        near[: len(gauges)] = gauges.tolist()
    for k, (gauge, angle) in enumerate(zip(read, near, strict=True), start=end):
        value = float(measured(mechanism, gauge, z))
        v[k] = beside(value, angle) if gauge.rotary else value
    for coupling in mechanism.couplings:
        for row, ratio in coupling.reads:
            if row.rotary:
                rest = v[first + coupling.follower] - coupling.phase
                rest -= sum(factor * v[first + k] for k, factor in followed(mechanism, coupling))
                v[first + mechanism.actuators.index(row)] += 2.0 * math.pi * round(rest / ratio / (2.0 * math.pi))
    return v


def written(constraints: Iterable[Constraint], places: Sequence[Linear], one: int) -> Iterator[tuple[Term, ...]]:
    """Yield the equations of constraints; places: of the nodes; one: number of the variable that is the constant 1."""
    for constraint in constraints:
        total: dict[tuple[int, int, int], complex] = {}
        for factor, function, a, b in _products(constraint, places, {one: 1.0 + 0.0j}):
            for (k, p), (n, q) in product(a.items(), b.items()):
                key = function, min(k, n), max(k, n)
                total[key] = total.get(key, 0.0j) + factor * p.conjugate() * q
        for part in PARTS[constraint.kind]:
            factors = {key: getattr(factor, part) for key, factor in total.items()}
            bound = ZERO * max(map(abs, factors.values()), default=0.0)
            yield tuple(Term(factor, *key) for key, factor in factors.items() if abs(factor) > bound)


def _products(c: Constraint, places: Sequence[Linear], unit: Linear) -> Iterator[tuple[complex, int, Linear, Linear]]:
    """Yield factor, function f, a and b of the products factor f conj(a) b whose sum is 0."""
    arm, vector, value, base = _difference(places, c.q, c.p), c.vector or Vector(1.0), c.value, unit
    if vector.u != NONE:
        base = _difference(places, vector.u, vector.v)
    if c.kind == CLOSURE:
        yield 1.0, ONE, unit, arm
        yield from ((-turn * vector.z, function, unit, base) for function, turn in _turn(vector))
    elif c.kind == SPAN:
        yield 1.0, ONE, arm, arm
        yield -(value.constant**2), ONE, unit, unit
    else:
        yield from (((turn * vector.z).conjugate(), function, base, arm) for function, turn in _turn(vector))
        yield -value.constant * abs(vector.z) ** 2, ONE, base, base
    if value.actuator != NONE:
        yield -1.0, 4 * value.actuator + (SQUARE if c.kind == SPAN else VALUE), unit, unit


def _difference(places: Sequence[Linear], u: int, v: int) -> Linear:
    """Return the vector from node u to node v."""
    found = dict(places[v])
    for variable, factor in places[u].items():
        found[variable] = found.get(variable, 0.0j) - factor
    return found


def _turn(vector: Vector) -> list[tuple[int, complex]]:
    """Return functions and factors of e^(+-i theta)."""
    at = 4 * vector.actuator
    return [(ONE, 1.0)] if vector.actuator == NONE else [(at + COSINE, 1.0), (at + SINE, 1j * vector.turn)]
