"""Places that move with a mechanism: nodes, and points in the coordinate systems of its members.

Lengths and positions are in the file's length unit, directions are unit complex numbers.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, Mechanism


@dataclass(frozen=True)
class Anchor:
    """A place that moves with the mechanism: a node, or a point in the coordinate system of a member."""

    node: int = -1  # -1: a point of the member
    member: int = FRAME
    local: complex = 0.0j


@dataclass(frozen=True)
class Carrier:
    """The coordinate system in which points of a member are given: origin at one node, x axis towards another."""

    origin: int = -1  # node; -1: the coordinates of the file
    towards: int = -1  # node; -1: the x axis does not turn


class Anchors:
    """The coordinate systems of the members of a mechanism, and the places of anchors."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism

    @cached_property
    def carriers(self) -> tuple[Carrier, ...]:
        """The coordinate system of each member."""
        every, still = self.mechanism.members, not self.mechanism.floating
        ends = (None if k == FRAME and still else member.ends for k, member in enumerate(every))
        return tuple(Carrier(own[0], own[1] if own[2] else -1) if own else Carrier() for own in ends)

    def local(self, member: int, place: complex) -> complex:
        """Convert a position in a member's own frame (normal frame) to its coordinate system here."""
        if self.carriers[member].origin < 0:
            return self.mechanism.origin + self.mechanism.scale * place
        away = place - complex(self.mechanism.members[member].shape[0])
        return self.direction(member, away * self.mechanism.scale)

    def direction(self, member: int, direction: complex) -> complex:
        """Convert a direction in a member's own frame to its coordinate system here."""
        reach = 0j if self.carriers[member].origin < 0 else self.mechanism.members[member].ends[2]
        return direction * (reach.conjugate() / abs(reach) if reach else 1.0 + 0.0j)

    def on(self, member: int, place: complex) -> Anchor:
        """Return the anchor of a position in a member's own frame (normal frame)."""
        return Anchor(member=member, local=self.local(member, place))

    def place(self, anchor: Anchor, z: ComplexArray) -> Any:
        """Return the position of an anchor for positions of the nodes (nodes,) or (rows, nodes)."""
        if anchor.node >= 0:
            return z[..., anchor.node]
        origin = self.carriers[anchor.member].origin
        start = z[..., origin] if origin >= 0 else 0.0j
        return start + self.turn(anchor.member, z) * anchor.local

    def line(self, anchors: Iterable[Anchor], z: ComplexArray) -> ComplexArray:
        """Return the places of anchors (anchors,) for positions of the nodes (nodes,)."""
        return np.array([self.place(anchor, z) for anchor in anchors])

    def turn(self, member: int, z: ComplexArray) -> Any:
        """Return the direction (unit) of the x axis of a member's coordinate system."""
        carrier = self.carriers[member]
        if carrier.towards < 0:
            return 1.0 + 0.0j
        reach = z[..., carrier.towards] - z[..., carrier.origin]
        size = np.abs(reach)
        return np.where(size > 0.0, reach / np.where(size > 0.0, size, 1.0), 1.0 + 0.0j)
