"""The constraints of all pairs and actuators, with their values; the sliding pairs.

A sliding pair has the heights that form it, the body that slides, and the actuator that drives it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from gimcli.connected import grouped
from gimcli.mechanism import ANGLE, HEIGHT, Input, Mechanism, PairRow
from gimcli.structure.derived import derived
from gimcli.structure.rotation import PARALLEL, members_of, rotation_classes
from gimcli.structure.steps import NONE, Value


@dataclass(frozen=True, eq=False)
class ImposedRow(PairRow):
    """A constraint and its value; `implied`: the rotation classes and the other rows already ensure it."""

    value: Value = field(default=Value(0.0))
    implied: bool = False


@derived
def pair_rows(mechanism: Mechanism) -> tuple[ImposedRow, ...]:
    """Return the constraints of all pairs, then those of all actuators."""
    implied = rotation_classes(mechanism).implied
    pairs = [_imposed(row, NONE, row.kind == ANGLE or row in implied) for row in mechanism.pairs]
    return (*pairs, *(_imposed(actuator, k, False) for k, actuator in enumerate(mechanism.actuators)))


def _imposed(row: PairRow, actuator: int, implied: bool) -> ImposedRow:
    own = {part.name: getattr(row, part.name) for part in fields(PairRow)}
    return ImposedRow(**own, value=Value(0.0, actuator), implied=implied)


@dataclass(frozen=True)
class SlidingPair:
    """A true prismatic pair, or a pin in a slot."""

    name: str
    slides: tuple[int, ...]  # numbers in Mechanism.slides
    guide: int  # member that carries the line
    body: int  # member that translates along the guide; NONE for a pin in a slot
    actuator: int  # actuator that drives it along the guide; NONE if there is none


@derived
def sliding_pairs(mechanism: Mechanism) -> tuple[SlidingPair, ...]:
    """Return the sliding pairs in the order of the file."""
    pairs = grouped((slide.pair, number) for number, slide in enumerate(mechanism.slides))
    found: list[SlidingPair] = []
    for name, slides in pairs.items():
        taken = {pair.actuator for pair in found}
        drivers = (k for k, a in enumerate(mechanism.actuators) if k not in taken and _along(mechanism, a, slides))
        guide = mechanism.slides[slides[0]].guide
        found.append(SlidingPair(name, tuple(slides), guide, _body(mechanism, slides), next(drivers, NONE)))
    return tuple(found)


def pair_of(mechanism: Mechanism, slide: int) -> SlidingPair:
    """Return the pair that a slide belongs to."""
    return next(pair for pair in sliding_pairs(mechanism) if slide in pair.slides)


def _body(mechanism: Mechanism, slides: list[int]) -> int:
    """Return the member that contains all nodes of a pair of two or more nodes, else NONE."""
    first, *others = (mechanism.slides[k] for k in slides)
    members = members_of(mechanism)
    common = [m for m in members[first.node] if m != first.guide and all(m in members[s.node] for s in others)]
    return common[0] if others and common else NONE


def _along(mechanism: Mechanism, actuator: Input, slides: list[int]) -> bool:
    """Return whether an actuator drives a node of a pair along its guide."""
    return actuator.kind == HEIGHT and any(
        s.node == actuator.node and s.guide == actuator.guide
        and abs((s.along.conjugate() * actuator.normal).imag) < PARALLEL
        for s in (mechanism.slides[k] for k in slides)
    )  # fmt: skip
