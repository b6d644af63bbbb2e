"""Gears, belts and racks as they are drawn: pitch circles that turn with their members, belts, pitch lines of racks.

Of gears without known radii, such as a belt that is given by its ratio, nothing is drawn. The argument `scene` is the
`Scene` that the outlines belong to; its module imports this one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.connected import unlike
from gimcli.coupling_data import BELT, CROSSED, INTERNAL, RACK, GearPair
from gimcli.mechanism import ComplexArray
from gimcli.output.anchors import Anchor

SAME = 1e-9
"""Relative difference of radii below which two circles of one wheel are the same."""

BEYOND = 1.0
"""Length of a rack's pitch line beyond the contacts with the pinion, in radii of the pinion."""

TICKS = tuple(np.exp(1j * np.radians([60.0, 180.0, 300.0])).tolist())
"""Directions of the marks of a wheel in the coordinate system of its member: rarely those of links."""


@dataclass(frozen=True)
class Wheel:
    """A pitch circle that turns with its member."""

    gear: str
    member: int
    pivot: int  # node
    radius: float
    ring: bool = False  # the teeth are inside


@dataclass(frozen=True)
class BeltLoop:
    """A belt or chain around two wheels."""

    gear: str
    pivots: tuple[int, int]
    radii: tuple[float, float]
    crossed: bool

    def path(self, first: complex, second: complex, count: int = 33) -> ComplexArray:
        """Return the closed path of the belt for the places of its pivots; each arc has `count` points."""
        (r, s), away = self.radii, second - first
        cosine = (r + s if self.crossed else r - s) / (abs(away) or 1.0)
        leaves = np.arccos(np.clip(cosine, -1.0, 1.0))  # angle of the tangent point, from the line of the pivots
        near = r * np.exp(1j * np.linspace(leaves, 2.0 * np.pi - leaves, count))
        last = np.pi - leaves if self.crossed else -leaves
        far = s * np.exp(1j * np.linspace(last, -last, count))
        loop = np.concatenate((near, abs(away) + far))
        return first + np.append(loop, loop[0]) * (away / abs(away) if away else 1.0)


@dataclass(frozen=True)
class PitchLine:
    """The pitch line of a rack, fixed to it."""

    gear: str
    ends: tuple[Anchor, Anchor]


@dataclass(frozen=True)
class GearOutlines:
    """What is drawn of all gears; lengths are in the file's unit."""

    wheels: tuple[Wheel, ...]
    belts: tuple[BeltLoop, ...]
    racks: tuple[PitchLine, ...]

    def extent(self, scene: Any, poses: ComplexArray) -> Iterator[ComplexArray]:
        """Yield points that a picture of some poses (poses, nodes) must contain."""
        for wheel in self.wheels:
            for corner in (-1.0 - 1.0j, 1.0 + 1.0j):
                yield poses[:, wheel.pivot] + wheel.radius * corner
        for rack in self.racks:
            for end in rack.ends:
                yield np.broadcast_to(scene.place(end, poses), (len(poses),))


def gear_outlines(scene: Any) -> GearOutlines:
    """Return what is drawn of the gears of a mechanism."""
    known = [(gear, _radii(scene, gear)) for gear in scene.mechanism.gears if gear.radii is not None]
    wheels = unlike((own for gear, radii in known for own in _wheels(gear, radii)), _same)
    belts = [
        BeltLoop(gear.name, gear.pivots, radii, gear.kind == CROSSED)
        for gear, radii in known
        if gear.kind in (BELT, CROSSED)
    ]
    return GearOutlines(tuple(wheels), tuple(belts), tuple(_rack(scene, g, r[0]) for g, r in known if g.kind == RACK))


def _radii(scene: Any, gear: GearPair) -> tuple[float, float]:
    first, second = gear.radii or (0.0, 0.0)
    return float(first) * scene.mechanism.scale, float(second) * scene.mechanism.scale


def _wheels(gear: GearPair, radii: tuple[float, float]) -> Iterator[Wheel]:
    for k in range(1 if gear.kind == RACK else 2):
        ring = gear.kind == INTERNAL and radii[k] > radii[1 - k]
        yield Wheel(gear.name, gear.members[k], gear.pivots[k], radii[k], ring)


def _same(one: Wheel, other: Wheel) -> bool:
    """Return whether two circles coincide: wheels of a train that share a member."""
    alike = (one.member, one.pivot, one.ring) == (other.member, other.pivot, other.ring)
    return alike and abs(one.radius - other.radius) <= SAME * one.radius


def _rack(scene: Any, gear: GearPair, radius: float) -> PitchLine:
    """Return the pitch line of a rack: all contacts with the pinion in the poses of the scene, and a length beyond."""
    row, rack, poses = scene.mechanism.pairs[gear.slide], gear.members[1], scene.poses
    foot = scene.place(scene.on(row.guide, row.point), poses)
    along = scene.direction(row.guide, row.along) * scene.turn(row.guide, poses)
    pivot = poses[:, gear.pivots[0]]
    on_rack = foot if row.guide == rack else poses[:, row.node]
    side = np.sign(np.ravel((np.conjugate(along) * (on_rack - pivot)).imag)[0])
    contact = np.atleast_1d(pivot + 1j * side * radius * along)
    origin, turn = scene.carriers[rack].origin, np.broadcast_to(scene.turn(rack, poses), contact.shape)
    local = (contact - (poses[:, origin] if origin >= 0 else 0.0)) / turn
    line = complex(np.ravel(along)[0] / turn[0])
    places = ((local - local[0]) / line).real
    low, high = float(places.min()) - BEYOND * radius, float(places.max()) + BEYOND * radius
    ends = (complex(local[0] + low * line), complex(local[0] + high * line))
    return PitchLine(gear.name, (Anchor(member=rack, local=ends[0]), Anchor(member=rack, local=ends[1])))
