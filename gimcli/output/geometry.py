"""Geometry in true size for drawing programs: layers of polylines, circles, points and names.

Coordinates are those of the file. Only pins, blocks and names have a size of their own, in proportion to the drawing.
A motion is a position, and the curves of the traced points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.curves import pieces
from gimcli.output.scene import Scene, Slider
from gimcli.table import Table

if TYPE_CHECKING:
    from gimcli.output.gear_outlines import GearOutlines


PIN = 0.01
"""Radius of a pin, relative to the extent of the mechanism."""

CLOSED = 1e-9
"""A curve whose ends are nearer to each other, relative to its extent, is closed."""

FRAME, PINS, GUIDES, BLOCKS, POINTS, NAMES = "frame", "pins", "guides", "blocks", "points", "names"


@dataclass(frozen=True)
class Polyline:
    """Straight lines between points."""

    points: ComplexArray
    closed: bool = False


@dataclass(frozen=True)
class PinCircle:
    """A circle."""

    centre: complex
    radius: float


@dataclass(frozen=True)
class Spot:
    """A single point."""

    at: complex


@dataclass(frozen=True)
class Lettering:
    """A text that begins at a place."""

    at: complex
    text: str
    height: float


Shape = Polyline | PinCircle | Spot | Lettering


@dataclass
class Geometry:
    """Shapes by layer, in a length unit of the model file."""

    unit: str
    layers: dict[str, list[Shape]] = field(default_factory=dict)

    def add(self, layer: str, *shapes: Shape) -> None:
        """Add shapes to a layer."""
        if shapes:
            self.layers.setdefault(layer, []).extend(shapes)

    def add_curve(self, name: str, curve: ComplexArray) -> None:
        """Add the pieces of a curve between its gaps (NaN); a curve that stays at a place is a point."""
        self.add(name, *map(_shape, pieces(curve)))

    def add_loops(self, name: str, loops: Sequence[ComplexArray]) -> None:
        """Add closed curves."""
        self.add(name, *(Polyline(loop, closed=True) for loop in loops))

    def add_mechanism(self, mechanism: Mechanism, z: ComplexArray, points: Mapping[str, complex] | None = None) -> None:
        """Add a mechanism at a position (nodes,) in the file's coordinates, with the names of its nodes and points."""
        _MechanismLayers(self, Scene(mechanism, z[None, :])).add(points or {})


def _shape(curve: ComplexArray) -> Shape:
    extent = float(max(np.ptp(curve.real), np.ptp(curve.imag)))
    if extent <= CLOSED * float(np.max(np.abs(curve))):
        return Spot(complex(curve[0]))
    closed = len(curve) > 3 and abs(curve[-1] - curve[0]) <= CLOSED * extent
    return Polyline(curve[:-1] if closed else curve, bool(closed))


class _MechanismLayers:
    """The layers of a mechanism: each member, cylinder, spring and damper has its own."""

    def __init__(self, geometry: Geometry, scene: Scene) -> None:
        self.geometry, self.scene, self.z = geometry, scene, scene.poses[0]
        extent = scene.extent()
        self.radius = PIN * float(max(np.ptp(extent.real), np.ptp(extent.imag)))

    def add(self, points: Mapping[str, complex]) -> None:
        """Add everything."""
        scene, geometry = self.scene, self.geometry
        for body in scene.bodies:
            layer = f"member {scene.mechanism.members[body.member].name}"
            geometry.add(layer, Polyline(scene.line(body.outline, self.z), body.kind == "plate"))
        for slider in scene.sliders:
            self._add_slider(slider)
        for drive in scene.cylinders:
            geometry.add(f"actuator {drive.name}", Polyline(self.z[list(drive.nodes)]))
        if scene.gears:
            self._add_gears(scene.gears)
        for element in scene.elements:
            if element.pivot < 0:
                geometry.add(f"{element.kind} {element.name}", Polyline(scene.line(element.ends, self.z)))
        self._add_nodes({name: complex(scene.place(a, self.z)) for name, a in scene.tracers.items()} | dict(points))

    def _add_gears(self, outlines: GearOutlines) -> None:
        """Add pitch circles, belts and the pitch lines of racks, each gear on its own layer."""
        for wheel in outlines.wheels:
            self.geometry.add(f"gear {wheel.gear}", PinCircle(complex(self.z[wheel.pivot]), wheel.radius))
        for belt in outlines.belts:
            first, second = (complex(self.z[pivot]) for pivot in belt.pivots)
            self.geometry.add(f"gear {belt.gear}", Polyline(belt.path(first, second)[:-1], closed=True))
        for rack in outlines.racks:
            self.geometry.add(f"gear {rack.gear}", Polyline(self.scene.line(rack.ends, self.z)))

    def _add_slider(self, slider: Slider) -> None:
        """Add the line of a guide, the block on it, and the line from the guide to its member."""
        scene, (first, last) = self.scene, self.scene.ends(slider, self.z)
        along = complex(slider.along * scene.turn(slider.line.member, self.z))
        layer = FRAME if slider.side else GUIDES
        self.geometry.add(layer, Polyline(np.array([first, last])))
        if slider.bracket:
            self.geometry.add(layer, Polyline(scene.line(slider.bracket, self.z)))
        nodes = self.z[list(slider.nodes)]
        length, half = (nodes * along.conjugate()).real, 1.5 * self.radius
        low, high = (complex(nodes[at(length)]) for at in (np.argmin, np.argmax))
        right, left = along * (2 - 1j) * half, along * (2 + 1j) * half
        self.geometry.add(BLOCKS, Polyline(np.array([low - left, high + right, high + left, low - right]), closed=True))

    def _add_nodes(self, points: Mapping[str, complex]) -> None:
        """Add pins, fixed nodes with a second circle, points, and all names."""
        scene, geometry, mechanism = self.scene, self.geometry, self.scene.mechanism
        named = {mechanism.nodes[node]: complex(self.z[node]) for node in sorted(scene.used | scene.fixed)}
        geometry.add(PINS, *(PinCircle(complex(self.z[node]), self.radius) for node in scene.pins))
        geometry.add(FRAME, *(PinCircle(complex(self.z[support.node]), 2 * self.radius) for support in scene.supports))
        geometry.add(FRAME, *(Spot(complex(self.z[node])) for node in scene.crosses))
        named |= {name: at for name, at in points.items() if np.isfinite(at)}
        geometry.add(POINTS, *(Spot(at) for name, at in named.items() if name not in mechanism.nodes))
        beside = (1 + 1j) * 1.5 * self.radius
        geometry.add(NAMES, *(Lettering(at + beside, name, 2 * self.radius) for name, at in named.items()))


BRANCH = "branch"


def motion_geometry(mechanism: Mechanism, pose: ComplexArray, table: Table) -> Geometry:
    """Return a position (nodes,) in the file's coordinates and the paths that a table has, with all its rows."""
    found = Geometry(mechanism.length_unit)
    found.add_mechanism(mechanism, pose)
    for name in (*mechanism.nodes, *(point.name for point in mechanism.points)):
        if {f"{name}.x", f"{name}.y"} <= set(table.names):
            z = table.floats(f"{name}.x") + 1j * table.floats(f"{name}.y")
            for tail, rows in _parts(table):
                found.add_curve(f"curve {name}{tail}", z[rows])
    return found


def _parts(table: Table) -> list[tuple[str, np.ndarray]]:
    """Return the rows of each branch, and the end of its name."""
    if BRANCH not in table.names:
        return [("", np.arange(len(table)))]
    own = table[BRANCH]
    return [(f" {BRANCH} {number}", np.flatnonzero(own == number)) for number in np.unique(own)]
