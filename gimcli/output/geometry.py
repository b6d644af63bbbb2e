"""Geometry in true size for drawing programs: layers of polylines, circles, points and names.

Coordinates are those of the file. Only pins, blocks and names have a size of their own, in proportion to the drawing.
A motion is a position, and the curves of the traced points.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, cast

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.curves import pieces
from gimcli.output.scene import Scene
from gimcli.output.symbols import Seat, Symbol
from gimcli.table import Table

PIN = 0.01
"""Radius of a pin, relative to the extent of the mechanism."""

CLOSED = 1e-9
"""A curve whose ends are nearer to each other, relative to its extent, is closed."""

FRAME, PINS, GUIDES, BLOCKS, POINTS, NAMES = "frame", "pins", "guides", "blocks", "points", "names"


class Shape(NamedTuple):
    """A line through points, a circle or a text at a point, or only a point."""

    points: ComplexArray
    closed: bool = False
    size: float = 0.0  # radius of a circle, or height of a text
    text: str = ""  # begins at the point


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
        self.add(name, *(Shape(loop, closed=True) for loop in loops))

    def add_mechanism(self, mechanism: Mechanism, z: ComplexArray, points: Mapping[str, complex] | None = None) -> None:
        """Add a mechanism at a position (nodes,) in the file's coordinates, with the names of its nodes and points."""
        _MechanismLayers(self, Scene(mechanism, z[None, :])).add(points or {})


def _shape(curve: ComplexArray) -> Shape:
    extent = float(max(np.ptp(curve.real), np.ptp(curve.imag)))
    if extent <= CLOSED * float(np.max(np.abs(curve))):
        return Shape(curve[:1])
    closed = len(curve) > 3 and abs(curve[-1] - curve[0]) <= CLOSED * extent
    return Shape(curve[:-1] if closed else curve, bool(closed))


class _MechanismLayers:
    """The layers of a mechanism: each member, cylinder, spring and damper has its own."""

    def __init__(self, geometry: Geometry, scene: Scene) -> None:
        self.geometry, self.scene, self.z = geometry, scene, scene.poses[0]
        extent = scene.extent()
        self.radius = PIN * float(max(np.ptp(extent.real), np.ptp(extent.imag)))

    def add(self, points: Mapping[str, complex]) -> None:
        """Add everything."""
        scene = self.scene
        self._add_symbols(scene.bodies)
        for guide, *bracket, block in scene.sliders:
            layer = FRAME if guide.fixed else GUIDES
            self.geometry.add(layer, *(Shape(scene.line(one.ends, self.z)) for one in (guide, *bracket)))
            self._add_block(cast(Seat, guide.seat).axes(scene, self.z).along, scene.line(block.ends, self.z))
        self._add_symbols((*scene.cylinders, *scene.gears, *(one for one in scene.elements if len(one.ends) == 2)))
        self._add_nodes({name: complex(scene.place(a, self.z)) for name, a in scene.tracers.items()} | dict(points))

    def _add_symbols(self, symbols: Iterable[Symbol]) -> None:
        """Add pitch circles, belts, outlines of members and lines between two places, each on its own layer."""
        for symbol in symbols:
            stroke, shape = symbol.strokes[0], Shape(self.scene.line(symbol.ends, self.z), symbol.filled, symbol.radius)
            if symbol.seat and not symbol.radius and np.any(stroke.lengths):
                shape = Shape(stroke.paths(symbol.seat.axes(self.scene, self.z), 0.0)[0][:-1], closed=True)
            self.geometry.add(symbol.part.replace(":", " ", 1), shape)

    def _add_block(self, along: complex, nodes: ComplexArray) -> None:
        """Add the block over some nodes on a line in a direction."""
        length, half = (nodes * along.conjugate()).real, 1.5 * self.radius
        low, high = (complex(nodes[at(length)]) for at in (np.argmin, np.argmax))
        right, left = along * (2 - 1j) * half, along * (2 + 1j) * half
        self.geometry.add(BLOCKS, Shape(np.array([low - left, high + right, high + left, low - right]), closed=True))

    def _add_nodes(self, points: Mapping[str, complex]) -> None:
        """Add pins, fixed nodes with a second circle, points, and all names."""
        scene, geometry, nodes = self.scene, self.geometry, self.scene.mechanism.nodes
        named = {nodes[node]: complex(self.z[node]) for node in sorted(scene.used | scene.fixed)}
        geometry.add(PINS, *(Shape(self.z[[node]], size=self.radius) for node in scene.pins))
        geometry.add(FRAME, *(Shape(scene.line(one.ends, self.z), size=2 * self.radius) for one in scene.supports))
        geometry.add(FRAME, *(Shape(self.z[[node]]) for node in scene.crosses))
        named |= {name: at for name, at in points.items() if np.isfinite(at)}
        geometry.add(POINTS, *(Shape(np.array([at])) for name, at in named.items() if name not in nodes))
        beside, height = (1 + 1j) * 1.5 * self.radius, 2 * self.radius
        geometry.add(NAMES, *(Shape(np.array([at + beside]), size=height, text=n) for n, at in named.items()))


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
