"""Sliding pairs: the heights that form one pair, the body that slides, and the actuator that drives the pair."""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.connected import grouped
from gimcli.mechanism import HEIGHT, Input, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.rotation import PARALLEL, members_of
from gimcli.structure.steps import NONE


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
