"""The links and lower pairs of a mechanism, as defined in the theory of Assur groups.

A pin in a slot is a separate link (a slider) with a revolute pair at the pin and a prismatic pair with the guide. A
linear actuator between two nodes is a binary link of variable length. At a node with three or more links the pin is a
separate link, until the order of formation decides which of these links the others are joined to.
"""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.mechanism import FRAME, HEIGHT, SPAN, Input, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.pair_rows import SlidingPair, sliding_pairs
from gimcli.structure.rotation import members_of
from gimcli.structure.steps import NONE

REVOLUTE, PRISMATIC = "R", "P"


@dataclass(frozen=True)
class LowerPair:
    """A revolute or prismatic pair of two links, and the actuator that drives it, if any."""

    kind: str
    name: str  # of the node, the sliding pair or the actuator
    a: int
    b: int
    actuator: int = NONE


@dataclass(frozen=True)
class LowerPairs:
    """Links by number, the frame first: members, then sliders, rams (linear actuators) and pins."""

    links: tuple[str, ...]
    pairs: tuple[LowerPair, ...]
    turns: tuple[tuple[int, int, int], ...]  # actuator or NONE, arm link and reference link of every angle
    rams: dict[int, int]  # {link: actuator} of the links whose length is an input
    pins: frozenset[int]  # links that are only pins


@derived
def lower_pairs(mechanism: Mechanism) -> LowerPairs:
    """Return the links and lower pairs of a mechanism."""
    return _LowerPairsBuilder(mechanism).build()


class _LowerPairsBuilder:
    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.holders = members_of(mechanism)
        self.links = [m.name for m in mechanism.members]
        self.parts = [list(members) for members in self.holders]  # links at each node
        self.pairs: list[LowerPair] = []
        self.rams: dict[int, int] = {}

    def build(self) -> LowerPairs:
        mechanism, pairs = self.mechanism, sliding_pairs(self.mechanism)
        for pair in pairs:
            self._slide(pair)
        driven = {pair.actuator for pair in pairs}
        drivers = {k: a for k, a in enumerate(mechanism.actuators) if k not in driven}
        for k, actuator in drivers.items():
            if actuator.kind == SPAN:
                ram = self._link(actuator.name)
                self.rams[ram] = k
                for node in actuator.nodes:
                    self.parts[node].append(ram)
            elif actuator.kind == HEIGHT:
                self._travel(k, actuator)
        pins = set(range(len(self.links), len(self.links) + self._revolutes()))
        angles = [*((NONE, row) for row in mechanism.pairs), *drivers.items()]
        turns = tuple((k, row.members[0], row.guide) for k, row in angles if row.rotary)
        return LowerPairs(tuple(self.links), tuple(self.pairs), turns, self.rams, frozenset(pins))

    def _link(self, name: str) -> int:
        self.links.append(name)
        return len(self.links) - 1

    def _travel(self, k: int, actuator: Input) -> None:
        """Add a driven block on the guide, and a slider on it across the guide: the node may leave the guide's line."""
        block, across = self._link(actuator.name), self._link(f"{actuator.name} across")
        self.parts[actuator.node].append(across)
        self.pairs.append(LowerPair(PRISMATIC, actuator.name, actuator.guide, block, k))
        self.pairs.append(LowerPair(PRISMATIC, f"{actuator.name} across", block, across))

    def _slide(self, pair: SlidingPair) -> None:
        """Add a prismatic pair, and a slider for a pin in a slot."""
        slider = pair.body
        if slider == NONE:
            slider = self._link(pair.name)
            self.parts[self.mechanism.slides[pair.slides[0]].node].append(slider)
        self.pairs.append(LowerPair(PRISMATIC, pair.name, pair.guide, slider, pair.actuator))

    def _revolutes(self) -> int:
        """Add the revolute pairs; return the number of pins added.

        A node of two links is one pair. At a node of more links, each is paired with the frame if it is one of them,
        else with a pin of its own.
        """
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
