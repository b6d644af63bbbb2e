"""Symbols of gears, belts and racks: pitch circles that turn with their members, belts, pitch lines of racks.

Pitch lines are dash-dotted. Of gears without known radii, such as a belt that is given by its ratio, nothing is drawn.
The argument `scene` is the `Scene` that the symbols belong to; its module imports this one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.connected import unlike
from gimcli.coupling_data import BELT, CROSSED, INTERNAL, RACK, GearPair
from gimcli.mechanism import FRAME, ComplexArray
from gimcli.output import style
from gimcli.output.anchors import Anchor
from gimcli.output.symbols import Seat, Stroke, Symbol

SAME = 1e-9
"""Relative difference of radii below which two circles of one wheel are the same."""

BEYOND = 1.0
"""Length of a rack's pitch line beyond the contacts with the pinion, in radii of the pinion."""

TICKS = tuple(np.exp(1j * np.radians([60.0, 180.0, 300.0])).tolist())
"""Directions of the marks of a wheel in the coordinate system of its member: rarely those of links."""

TICK, WALL = 6.0, 7.0
"""Length of a mark, and thickness of a ring [pt]."""

CIRCLE = np.exp(2j * np.pi * np.arange(121) / 120)
"""The closed polyline of a circle."""


def gear_symbols(scene: Any) -> tuple[Symbol, ...]:
    """Return the wheels of a mechanism, each once, then its belts and racks."""
    size = scene.mechanism.scale
    known = [(gear, [float(r) * size for r in gear.radii]) for gear in scene.mechanism.gears if gear.radii is not None]
    pinions = ((gear, radii, k) for gear, radii in known for k in range(1 if gear.kind == RACK else 2))
    belts = (_belt(scene, gear, radii) for gear, radii in known if gear.kind in (BELT, CROSSED))
    racks = (_rack(scene, gear, radii[0]) for gear, radii in known if gear.kind == RACK)
    return (*unlike((_wheel(scene, *one) for one in pinions), _same), *belts, *racks)


def _wheel(scene: Any, gear: GearPair, radii: Sequence[float], k: int) -> Symbol:
    """Return a pitch circle that turns with its member, with its marks; a ring, whose teeth are inside, has a rim."""
    member, radius, ring = gear.members[k], radii[k], gear.kind == INTERNAL and radii[k] > radii[1 - k]
    strokes = [Stroke(style.PITCH, lengths=radius * CIRCLE)]
    if ring:
        strokes.append(Stroke(style.RIM, WALL * CIRCLE, lengths=radius * CIRCLE))
    if member != FRAME or scene.mechanism.floating:
        end = WALL if ring else -TICK
        strokes += [Stroke(style.TICK, (0j, end * tick), lengths=radius * tick) for tick in TICKS]
    return Symbol(f"gear:{gear.name}", tuple(strokes), Seat(Anchor(gear.pivots[k]), None, 1.0, member), radius=radius)


def _same(one: Symbol, other: Symbol) -> bool:
    """Return whether two circles coincide: wheels of a train that share a member."""
    alike = (one.seat, len(one.strokes)) == (other.seat, len(other.strokes))
    return alike and abs(one.radius - other.radius) <= SAME * one.radius


def _belt(scene: Any, gear: GearPair, radii: Sequence[float]) -> Symbol:
    """Return a belt or chain around two wheels; the distance of its pivots is constant."""
    first, second = (complex(scene.poses[0][pivot]) for pivot in gear.pivots)
    path = belt_path(radii, gear.kind == CROSSED, abs(second - first))
    return Symbol(
        f"gear:{gear.name}", (Stroke(style.BELT, lengths=path),), Seat(Anchor(gear.pivots[0]), Anchor(gear.pivots[1]))
    )


def belt_path(radii: Sequence[float], crossed: bool, away: float, count: int = 33) -> ComplexArray:
    """Return the closed path of a belt from a wheel at 0 to one at a distance; each arc has `count` points."""
    r, s = radii
    cosine = (r + s if crossed else r - s) / (away or 1.0)
    leaves = np.arccos(np.clip(cosine, -1.0, 1.0))  # angle of the tangent point, from the line of the pivots
    near = r * np.exp(1j * np.linspace(leaves, 2.0 * np.pi - leaves, count))
    last = np.pi - leaves if crossed else -leaves
    far = s * np.exp(1j * np.linspace(last, -last, count))
    return np.concatenate((near, away + far, near[:1]))


def _rack(scene: Any, gear: GearPair, radius: float) -> Symbol:
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
    reach = float(places.min()) - BEYOND * radius, float(places.max()) + BEYOND * radius
    first, last = (Anchor(member=rack, local=complex(local[0] + at * line)) for at in reach)
    walls = (Stroke(style.TICK, (-0.5j * TICK, 0.5j * TICK), end) for end in (0.0, 1.0))
    return Symbol(f"gear:{gear.name}", (Stroke(style.PITCH, share=(0.0, 1.0)), *walls), Seat(first, last))
