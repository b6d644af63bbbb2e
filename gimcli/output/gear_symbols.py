"""The symbols of gears, belts and racks: pitch circles (dash-dotted) with marks that turn, belts, pitch lines."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray
from gimcli.output.gear_outlines import TICKS, GearOutlines, PitchLine, Wheel
from gimcli.output.picture import Picture
from gimcli.output.scene import Scene
from gimcli.output.style import PALE, Pen

PITCH = Pen(0.9, dash=(9.0, 2.5, 1.5, 2.5), layer=3)
RIM = Pen(1.4, layer=3)
BELT = Pen(1.5, layer=3)
MARK = Pen(1.1, layer=3)
GHOST_PITCH = Pen(0.6, PALE, (9.0, 2.5, 1.5, 2.5), layer=2)
GHOST_BELT = Pen(0.7, PALE, layer=2)

TICK, WALL = 6.0, 7.0
"""Length of a mark, and thickness of a ring [pt]."""

POINTS = 121
"""Points of a circle."""


def circle(centre: complex, radius: float) -> ComplexArray:
    """Return the closed polyline of a circle."""
    return np.asarray(centre + radius * np.exp(2j * np.pi * np.arange(POINTS) / (POINTS - 1)))


def draw_gears(picture: Picture, scene: Scene, z: ComplexArray) -> None:
    """Draw the gears at positions of the nodes (nodes,)."""
    outlines = scene.gears
    if outlines is None:
        return
    for wheel in outlines.wheels:
        with picture.named(f"gear:{wheel.gear}"):
            _draw_wheel(picture, scene, wheel, z)
    for belt in outlines.belts:
        with picture.named(f"gear:{belt.gear}"):
            picture.stroke(BELT, belt.path(complex(z[belt.pivots[0]]), complex(z[belt.pivots[1]])))
    for rack in outlines.racks:
        with picture.named(f"gear:{rack.gear}"):
            _draw_rack(picture, scene, rack, z)


def draw_light_gears(picture: Picture, scene: Scene, z: ComplexArray, outlines: GearOutlines) -> None:
    """Draw the gears of a light pose whose pivots move."""
    for wheel in outlines.wheels:
        if wheel.pivot not in scene.fixed:
            picture.stroke(GHOST_PITCH, circle(complex(z[wheel.pivot]), wheel.radius))
    for belt in outlines.belts:
        if not set(belt.pivots) <= scene.fixed:
            picture.stroke(GHOST_BELT, belt.path(complex(z[belt.pivots[0]]), complex(z[belt.pivots[1]])))
    for rack in outlines.racks:
        picture.stroke(GHOST_PITCH, [scene.place(end, z) for end in rack.ends])


def _draw_wheel(picture: Picture, scene: Scene, wheel: Wheel, z: ComplexArray) -> None:
    """Draw a pitch circle and its marks; a ring has a rim outside."""
    at, turn, pt = complex(z[wheel.pivot]), complex(scene.turn(wheel.member, z)), picture.frame.point
    picture.stroke(PITCH, circle(at, wheel.radius))
    length = min(TICK * pt, 0.4 * wheel.radius)
    if wheel.ring:
        picture.stroke(RIM, circle(at, wheel.radius + WALL * pt))
        length = -WALL * pt
    if wheel.member != FRAME or scene.mechanism.floating:
        rays = [turn * tick for tick in TICKS]
        picture.stroke(MARK, *([at + ray * wheel.radius, at + ray * (wheel.radius - length)] for ray in rays))


def _draw_rack(picture: Picture, scene: Scene, rack: PitchLine, z: ComplexArray) -> None:
    """Draw a pitch line and the strokes that end it."""
    first, second = (complex(scene.place(end, z)) for end in rack.ends)
    across = 1j * (second - first) / abs(second - first) * 0.5 * TICK * picture.frame.point
    picture.stroke(PITCH, [first, second])
    picture.stroke(MARK, *([end - across, end + across] for end in (first, second)))
