"""The symbols of gears, belts and racks: pitch circles (dash-dotted) with marks that turn, belts, pitch lines."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gimcli.mechanism import FRAME
from gimcli.output.anchors import Anchor
from gimcli.output.gear_outlines import TICKS, BeltLoop, GearOutlines, PitchLine, Wheel
from gimcli.output.scene import Scene
from gimcli.output.style import PALE, Pen
from gimcli.output.symbols import Seat, Stroke, Symbol

PITCH = Pen(0.9, dash=(9.0, 2.5, 1.5, 2.5), layer=3.5)
RIM = Pen(1.4, layer=3.5)
BELT = Pen(1.5, layer=3.5)
MARK = Pen(1.1, layer=3.5)
GHOST_PITCH = Pen(0.6, PALE, (9.0, 2.5, 1.5, 2.5), layer=2)
GHOST_BELT = Pen(0.7, PALE, layer=2)

TICK, WALL = 6.0, 7.0
"""Length of a mark, and thickness of a ring [pt]."""

CIRCLE = np.exp(2j * np.pi * np.arange(121) / 120)
"""The closed polyline of a circle."""


def gears(scene: Scene, outlines: GearOutlines) -> Iterator[Symbol]:
    """Yield the symbols of gears."""
    for wheel in outlines.wheels:
        yield Symbol(
            f"gear:{wheel.gear}", tuple(_wheel(scene, wheel)), Seat(Anchor(wheel.pivot), None, 1.0, wheel.member)
        )
    for belt in outlines.belts:
        yield _belt(scene, belt, BELT)
    for rack in outlines.racks:
        walls = (Stroke(MARK, (-0.5j * TICK, 0.5j * TICK), end) for end in (0.0, 1.0))
        yield _rack(rack, Stroke(PITCH, share=(0.0, 1.0)), *walls)


def light_gears(scene: Scene, outlines: GearOutlines) -> Iterator[Symbol]:
    """Yield the symbols of gears in light poses, without those whose pivots do not move."""
    for wheel in outlines.wheels:
        if wheel.pivot not in scene.fixed:
            pitch = Stroke(GHOST_PITCH, lengths=wheel.radius * CIRCLE)
            yield Symbol(f"gear:{wheel.gear}", (pitch,), Seat(Anchor(wheel.pivot), None, 1.0))
    for belt in outlines.belts:
        if not set(belt.pivots) <= scene.fixed:
            yield _belt(scene, belt, GHOST_BELT)
    for rack in outlines.racks:
        yield _rack(rack, Stroke(GHOST_PITCH, share=(0.0, 1.0)))


def _wheel(scene: Scene, wheel: Wheel) -> Iterator[Stroke]:
    """Yield a pitch circle and its marks; a ring has a rim outside."""
    yield Stroke(PITCH, lengths=wheel.radius * CIRCLE)
    if wheel.ring:
        yield Stroke(RIM, WALL * CIRCLE, lengths=wheel.radius * CIRCLE)
    if wheel.member != FRAME or scene.mechanism.floating:
        end = WALL if wheel.ring else -TICK
        for tick in TICKS:
            yield Stroke(MARK, (0j, end * tick), lengths=wheel.radius * tick)


def _belt(scene: Scene, belt: BeltLoop, pen: Pen) -> Symbol:
    """Return a belt; the distance of its pivots is constant."""
    first, second = (complex(scene.poses[0][pivot]) for pivot in belt.pivots)
    seat = Seat(Anchor(belt.pivots[0]), Anchor(belt.pivots[1]))
    return Symbol(f"gear:{belt.gear}", (Stroke(pen, lengths=belt.path(0j, abs(second - first) + 0j)),), seat)


def _rack(rack: PitchLine, *strokes: Stroke) -> Symbol:
    return Symbol(f"gear:{rack.gear}", strokes, Seat(*rack.ends))
