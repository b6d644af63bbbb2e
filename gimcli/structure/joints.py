"""A mechanism as links and lower pairs, as the theory of Assur groups has it.

A pin in a slot is a slider of its own: a revolute pair with the pin, a prismatic one with the guide. A linear actuator
between two nodes is a binary link whose length it sets. Where three or more parts meet, the pin is a part of its own
until it is known which link is there first.
"""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.mechanism import FRAME, Drive, Input, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.rotation import PARALLEL, members_of
from gimcli.structure.steps import NONE

REVOLUTE, PRISMATIC = "R", "P"


@dataclass(frozen=True)
class LowerPair:
    """A revolute or prismatic pair of two links, and the actuator that drives it."""

    kind: str
    name: str  # of the node, the sliding pair or the actuator
    a: int
    b: int
    actuator: int = NONE


@dataclass(frozen=True)
class PairLinkage:
    """Links by number, the frame first: members, then sliders, rams and pins."""

    links: tuple[str, ...]
    pairs: tuple[LowerPair, ...]
    turns: tuple[tuple[int, int, int], ...]  # actuator, arm and reference link of every driven angle
    rams: dict[int, int]  # actuator of each link whose length is an input
    pins: frozenset[int]  # links that are pins only


@derived
def linkage(mechanism: Mechanism) -> PairLinkage:
    """Return the links and pairs of a mechanism."""
    return _LinkageBuilder(mechanism).build()


class _LinkageBuilder:
    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.holders = members_of(mechanism)
        self.links = [m.name for m in mechanism.members]
        self.parts = [list(held) for held in self.holders]  # links at each node
        self.pairs: list[LowerPair] = []
        self.rams: dict[int, int] = {}

    def build(self) -> PairLinkage:
        drivers = {k: a for k, a in enumerate(self.mechanism.actuators)}
        self._slides(drivers)
        for k, actuator in drivers.items():
            if actuator.drive is Drive.DISTANCE:
                ram = self._link(actuator.name)
                self.rams[ram] = k
                self.parts[actuator.a].append(ram)
                self.parts[actuator.b].append(ram)
            elif actuator.drive is Drive.TRAVEL:
                block = self._link(actuator.name)
                self.parts[actuator.a].append(block)
                self.pairs.append(LowerPair(PRISMATIC, actuator.name, actuator.reference_member, block, k))
        pins = set(range(len(self.links), len(self.links) + self._revolutes()))
        turns = tuple(
            (k, a.arm_member, a.reference_member) for k, a in drivers.items() if a.drive is Drive.ROTARY
        )  # fmt: skip
        return PairLinkage(tuple(self.links), tuple(self.pairs), turns, self.rams, frozenset(pins))

    def _link(self, name: str) -> int:
        self.links.append(name)
        return len(self.links) - 1

    def _slides(self, drivers: dict[int, Input]) -> None:
        """Add sliders and prismatic pairs; take the actuators that drive them."""
        mechanism = self.mechanism
        for pair in dict.fromkeys(s.pair for s in mechanism.slides):
            first, *others = [s for s in mechanism.slides if s.pair == pair]
            common = [m for m in self.holders[first.node] if all(m in self.holders[s.node] for s in others)]
            common = [m for m in common if m != first.member]
            if others and common:
                slider = common[0]
            else:
                slider = self._link(pair)
                self.parts[first.node].append(slider)
            actuator = next((k for k, a in drivers.items() if self._along(a, pair)), NONE)
            drivers.pop(actuator, None)
            self.pairs.append(LowerPair(PRISMATIC, pair, first.member, slider, actuator))

    def _along(self, actuator: Input, pair: str) -> bool:
        """Tell whether an actuator drives what slides in a pair."""
        if actuator.drive is not Drive.TRAVEL:
            return False
        slides = [s for s in self.mechanism.slides if s.pair == pair]
        return any(
            s.node == actuator.a and s.member == actuator.reference_member
            and abs((s.direction.conjugate() * actuator.direction).imag) < PARALLEL
            for s in slides
        )  # fmt: skip

    def _revolutes(self) -> int:
        """Add a revolute pair where two links meet, and a pin with one to each link where more do; return the pins."""
        pins = 0
        for node, parts in enumerate(self.parts):
            name = self.mechanism.nodes[node]
            if len(parts) == 2:
                self.pairs.append(LowerPair(REVOLUTE, name, *parts))
            elif len(parts) > 2 and FRAME in parts:
                self.pairs += [LowerPair(REVOLUTE, name, FRAME, part) for part in parts if part != FRAME]
            elif len(parts) > 2:
                pin = self._link(name)
                pins += 1
                self.pairs += [LowerPair(REVOLUTE, name, pin, part) for part in parts]
        return pins
