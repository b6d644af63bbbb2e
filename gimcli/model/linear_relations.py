"""Linear relations between inputs and unknowns, and what they determine; their numbers may be recorded ones."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gimcli.calculus.numbers import nominal
from gimcli.mechanism import Coupling, Input

ZERO = 1e-12
"""A coefficient below this is a rounding error of 0; coefficients are about 1."""


@dataclass(frozen=True)
class Relation:
    """The relation: sum of coefficient times unknown = sum of coefficient times input + a constant."""

    unknowns: Mapping[Any, Any]
    inputs: Mapping[int, Any]

    def minus(self, other: Relation, factor: Any) -> Relation:
        """Return this relation minus a multiple of another one; coefficients that vanish are left out."""
        return Relation(_minus(self.unknowns, other.unknowns, factor), _minus(self.inputs, other.inputs, factor))

    def over(self, unknown: Hashable) -> Relation:
        """Return the relation divided by the coefficient of an unknown."""
        factor = self.unknowns[unknown]
        return Relation(
            {k: v / factor for k, v in self.unknowns.items()}, {k: v / factor for k, v in self.inputs.items()}
        )


class Relations:
    """Independent relations, each solved for one unknown that no other one contains (Gauss and Jordan)."""

    def __init__(self, rows: Iterable[Relation] = ()) -> None:
        self._solved: dict[Any, Relation] = {}
        self.contradicted = False
        """Whether the relation that was added last contradicts the others: it would fix a combination of inputs."""
        for row in rows:
            self.add(row)

    @property
    def rows(self) -> list[Relation]:
        """The independent relations."""
        return list(self._solved.values())

    def add(self, row: Relation) -> bool:
        """Add a relation; return whether it is independent of the others."""
        rest = self._reduced(row)
        self.contradicted = not rest.unknowns and bool(rest.inputs)
        if not rest.unknowns:
            return False
        own = max(rest.unknowns, key=lambda k: abs(nominal(rest.unknowns[k])))
        rest = rest.over(own)
        for unknown, other in list(self._solved.items()):
            if own in other.unknowns:
                self._solved[unknown] = other.minus(rest, other.unknowns[own])
        self._solved[own] = rest
        return True

    def determines(self, row: Relation) -> bool:
        """Return whether the inputs determine a combination of unknowns."""
        return not self._reduced(row).unknowns

    def value(self, row: Relation) -> dict[int, Any]:
        """Return the derivatives of a determined combination of unknowns by the inputs."""
        return {k: -v for k, v in self._reduced(Relation(row.unknowns, {})).inputs.items()}

    def _reduced(self, row: Relation) -> Relation:
        for unknown, solved in self._solved.items():
            if unknown in row.unknowns:
                row = row.minus(solved, row.unknowns[unknown])
        return row


def _minus(one: Mapping[Any, Any], other: Mapping[Any, Any], factor: Any) -> dict[Any, Any]:
    result = dict(one)
    for key, value in other.items():
        result[key] = result.get(key, 0.0) - factor * value
    return {key: value for key, value in result.items() if abs(nominal(value)) > ZERO}


def coupling_to(
    follower: int, value: Any, leaders: Mapping[int, tuple[Any, Any]], couplings: Mapping[int, Coupling],
    reads: Sequence[tuple[Input, Any]] = (), geared: bool = False,
) -> Coupling:  # fmt: skip
    """Return the coupling of an input to others; if these follow others themselves, it is a coupling to those.

    value: of the input where its leaders have their own values. leaders: ratios and values by numbers of actuators.
    couplings: those that are known, by followers. reads: quantities that the input also follows, and their ratios.
    """
    own_reads, terms = list(reads), dict[int, Any]()
    for k, (ratio, own_value) in leaders.items():
        inner = couplings.get(k, Coupling(k, ((k, 1.0),)))
        value = value - ratio * own_value + ratio * inner.phase
        own_reads += [(row, ratio * own) for row, own in inner.reads]
        for leader, own in inner.terms:
            terms[leader] = terms.get(leader, 0.0) + ratio * own
    return Coupling(follower, tuple(terms.items()), value, geared, tuple(own_reads))
