"""The symbols of a mechanism, for pictures and pages: members, pairs, drives, gears, springs, loads, marks of points.

Gears, belts and racks are pitch circles (dash-dotted) with marks that turn, belts, and pitch lines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from gimcli.mechanism import FRAME, FloatArray
from gimcli.output import style, symbols
from gimcli.output.anchors import Anchor
from gimcli.output.gear_outlines import TICKS, BeltLoop, GearOutlines, PitchLine, Wheel
from gimcli.output.scene import Drive, ForceElement, LoadArrow, MemberOutline, Scene, Slider
from gimcli.output.style import PALE, Fill, Mark, Pen, tint
from gimcli.output.symbols import Seat, Stroke, Symbol

GROUND = "frame"
"""Name of the part with the symbols of the frame."""

COLOURED = {style.LINK, style.BEAM, style.UPPER, style.ROD, style.PLATE, style.BLOCK, style.CYLINDER}
"""Styles of members, blocks and cylinders, which have another colour in some pictures."""


def strong_symbols(scene: Scene) -> Iterator[Symbol]:
    """Yield all symbols of a mechanism but the marks of its points."""
    if scene.gears:
        yield from gears(scene, scene.gears)
    yield from (_body(scene, body, _style(body)) for body in scene.bodies)
    yield from chain.from_iterable(_slider(scene, slider) for slider in scene.sliders)
    for support in scene.supports:
        yield Symbol(GROUND, symbols.fixed_pivot(support.upward), Seat(Anchor(support.node), None, 1.0), fixed=True)
    yield from (_element(scene, element) for element in scene.elements)
    yield from map(_drive, scene.drives)
    yield from (_load(load) for load in scene.loads if load.torque or load.force)
    for at in scene.centres:
        yield Symbol("centres-of-mass", symbols.centre_of_mass(), Seat(at, None, 1.0))


def light_symbols(scene: Scene) -> Iterator[Symbol]:
    """Yield the symbols of a light pose: members, gears, cylinders and blocks."""
    for body in scene.bodies:
        yield _body(scene, body, style.GHOST_PLATE if body.kind == "plate" else style.GHOST)
    if scene.gears:
        yield from light_gears(scene, scene.gears)
    rod = Stroke(style.GHOST, share=(0.0, 1.0))
    yield from (_between(drive, (rod,)) for drive in scene.cylinders)
    yield from (_block(scene, slider, style.GHOST_BLOCK) for slider in scene.sliders)


def point_marks(scene: Scene) -> Iterator[tuple[str, Mark, Anchor]]:
    """Yield part, mark and place of the pins, the other nodes and the points of members."""
    for mark, nodes in ((style.PIN, scene.pins), (style.DOT, scene.plain)):
        for node in nodes:
            yield f"node:{scene.mechanism.nodes[node]}", mark, Anchor(node)
    for name, anchor in scene.tracers.items():
        yield f"point:{name}", style.TRACER, anchor


def _style(body: MemberOutline) -> Pen | Fill:
    if body.kind == "plate":
        return style.PLATE
    return style.BEAM if body.kind == "beam" else style.UPPER if body.above else style.LINK


def _body(scene: Scene, body: MemberOutline, own: Pen | Fill) -> Symbol:
    """Return a plate, a beam or a link."""
    return Symbol(f"member:{scene.mechanism.members[body.member].name}", (Stroke(own),), corners=body.outline)


def _slider(scene: Scene, slider: Slider) -> Iterator[Symbol]:
    """Yield the guide of a block, the line from the guide to its member, and the block."""
    guide = slider.line.member
    first, last = (Anchor(member=guide, local=slider.line.local + t * slider.along) for t in slider.travel)
    seat = Seat(first, last, slider.along, guide)
    if slider.side:
        yield Symbol(GROUND, symbols.frame_guide(slider.side / slider.along), seat, fixed=True)
    else:
        yield Symbol(f"pair:{slider.name}", symbols.moving_guide(), seat)
    if slider.bracket:
        held = f"member:{scene.mechanism.members[guide].name}"
        yield Symbol(held, (Stroke(style.LINK),), corners=slider.bracket)
    yield _block(scene, slider, style.BLOCK)


def _block(scene: Scene, slider: Slider, fill: Fill) -> Symbol:
    """Return the block of a sliding pair, between its nodes if there are two."""
    at, *other = map(Anchor, slider.nodes)
    seat = Seat(at, other[0]) if other else Seat(at, None, slider.along, slider.line.member)
    return Symbol(f"pair:{slider.name}", (symbols.block(fill),), seat)


def _drive(drive: Drive) -> Symbol:
    """Return a turning arrow, a cylinder or a straight arrow."""
    if drive.kind == "cylinder":
        return _between(drive, symbols.cylinder())
    travels = drive.kind == "travel"
    strokes = symbols.travel_arrow(drive.aside, drive.sense) if travels else symbols.turning_arrow(drive.sense)
    return Symbol(f"actuator:{drive.name}", strokes, Seat(Anchor(drive.nodes[0]), None, drive.direction, drive.guide))


def _between(drive: Drive, strokes: tuple[Stroke, ...]) -> Symbol:
    return Symbol(f"actuator:{drive.name}", strokes, Seat(Anchor(drive.nodes[0]), Anchor(drive.nodes[1])))


def _element(scene: Scene, element: ForceElement) -> Symbol:
    """Return a spring or a damper, also about a pivot."""
    part, kind = f"{element.kind}:{element.name}", element.kind
    if element.pivot < 0:
        return Symbol(part, symbols.STRAIGHT[kind](element.lane), Seat(*element.ends))
    (arm, reference), pivot = element.ends, Anchor(element.pivot)
    seat = Seat(pivot, reference, arm=arm)
    angles = [seat.axes(scene, z).turn for z in scene.poses]
    least = symbols.LEAST_TURN[kind]
    turn = least + (_middle(np.array(angles)) - least) % (2.0 * np.pi)
    return Symbol(part, symbols.TORSIONAL[kind](element.lane), replace(seat, turn=turn))


def _middle(angles: FloatArray) -> float:
    """Return the middle of the smallest arc that contains some angles [rad]."""
    turned = np.sort(angles % (2.0 * np.pi))
    gaps = np.diff(turned, append=turned[0] + 2.0 * np.pi)
    widest = int(np.argmax(gaps))
    return float(turned[widest] + 0.5 * gaps[widest] + np.pi)


def _load(load: LoadArrow) -> Symbol:
    """Return a force as an arrow from its point, a torque as an arc."""
    if load.torque:
        return Symbol(f"load:{load.name}", symbols.torque(load.torque), Seat(load.at, None, 1.0))
    size = abs(load.force)
    seat = Seat(load.at, None, load.force / size, load.at.member if load.follower else FRAME)
    return Symbol(f"load:{load.name}", symbols.force(size), seat)


def coloured(own: Pen | Fill, colour: str | None) -> Pen | Fill:
    """Return the style of a member, block or cylinder in a colour; areas are filled with a light tint of it."""
    if colour is None or own not in COLOURED:
        return own
    return replace(own, color=colour) if isinstance(own, Pen) else replace(own, face=tint(colour), edge=colour)


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
