"""Draw a mechanism with the symbols of textbooks: poses, curves, marks with numbers, names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.connected import alike
from gimcli.errors import UsageError
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output import style
from gimcli.output.curves import drawn_runs
from gimcli.output.labels import Labels
from gimcli.output.picture import LAYOUT, Frame, Picture, PictureLayout
from gimcli.output.scene import GROUND, Scene
from gimcli.output.style import FONT, INK, Fill, Mark, Pen, curve_pen, tint
from gimcli.table import labelled

MOST_NAMES = 40
"""With more nodes, no names are written."""

MOST_KEYS = 18
"""Largest number of curves in the legend."""

NARROW, WIDE = 1.2, 4.2
"""Widths of the last and of the first of curves that overlap [pt]."""

COLOURED = {style.LINK, style.BEAM, style.UPPER, style.ROD, style.PLATE, style.BLOCK, style.CYLINDER}
"""Styles of members, blocks and cylinders, which have another colour in some pictures."""

TOGETHER = 4.0
"""Marks that are nearer to each other have one text with their numbers [pt]."""


@dataclass(frozen=True)
class Shown:
    """A position with a number, in the file's units, and the places of its marks."""

    number: int
    kind: str  # which its mark depends on
    pose: ComplexArray = field(repr=False)  # (nodes,)
    at: tuple[complex, ...] = ()


def solved(mechanism: Mechanism, positions: ComplexArray | None) -> Scene | None:
    """Return the poses (poses, nodes) or (nodes,) without NaN; None if there are none."""
    poses = np.atleast_2d(np.asarray(np.nan if positions is None else positions, dtype=np.complex128))
    poses = poses[np.all(np.isfinite(poses), axis=1)]
    return Scene(mechanism, poses) if len(poses) else None


def length_labels(mechanism: Mechanism) -> tuple[str, str]:
    """Return the names of the axes, with the file's unit."""
    return labelled("x", mechanism.length_unit), labelled("y", mechanism.length_unit)


class Drawing:
    """A picture of a mechanism, and what is drawn on it step by step.

    Without a scene, as no position is solved, nothing is drawn of the mechanism.
    """

    def __init__(self, picture: Picture, scene: Scene | None) -> None:
        self.picture, self.scene, self.labels = picture, scene, Labels(picture)

    @classmethod
    def around(
        cls, mechanism: Mechanism, scene: Scene | None, title: str, shown: Iterable[ComplexArray] = (),
        layout: PictureLayout = LAYOUT, poses: Sequence[int] | None = None,
    ) -> Drawing:  # fmt: skip
        """Return an empty drawing with equal axes around some points and all poses, or those with some numbers."""
        points = [np.zeros(0, dtype=np.complex128), *map(np.ravel, shown), *([scene.extent(poses)] if scene else [])]
        return cls(Picture(title, Frame.around(np.concatenate(points), layout), length_labels(mechanism)), scene)

    def poses(
        self, light: Iterable[int] = (), only: Sequence[str] = (), *, colours: Mapping[str, str] | None = None,
        crosses: bool = True,
    ) -> None:  # fmt: skip
        """Draw the first pose strong, as `strong` does, and others light.

        Args:
            light: the numbers of the light poses.
            only: the names of the parts that light poses show; () for all.
            colours: replace black for members, blocks and cylinders, by name.
            crosses: also mark the nodes of the frame to which nothing is attached.
        """
        if self.scene is None:
            return
        for number, pose in enumerate(light, start=1):
            with self.picture.named(f"light-position:{number}"):
                self.ghost(self.scene, pose, only)
        self.strong(self.scene, self.scene.poses[0], colours or {})
        if crosses:
            self.crosses(self.scene)

    def ghost(self, scene: Scene, pose: int, only: Sequence[str] = ()) -> None:
        """Draw a pose with light lines, all of it or only the members, blocks and cylinders of some names.

        Raises:
            UsageError: there is no part of a name.
        """
        z, shown = scene.poses[pose], _parts(scene, only)
        for symbol in scene.light:
            if not only or symbol.name in shown:
                for stroke in symbol.strokes:
                    self.picture.draw(stroke.style, *symbol.paths(stroke, scene, z, self.picture.frame.point))
        pinned = {n for member in scene.mechanism.members if member.name in shown for n in member.nodes}
        self.picture.draw(style.GHOST_PIN, *z[[n for n in scene.pins if n in pinned - scene.fixed]].tolist())

    def strong(self, scene: Scene, z: ComplexArray, colours: Mapping[str, str]) -> None:
        """Draw positions of the nodes (nodes,) with all symbols; `colours` replace black in parts by name."""
        for symbol in scene.strong:
            with self.picture.named(symbol.part):
                for stroke in symbol.strokes:
                    own = coloured(stroke.style, colours.get(symbol.name))
                    self.picture.draw(own, *symbol.paths(stroke, scene, z, self.picture.frame.point))
        for part, mark, anchor in scene.marks:
            with self.picture.named(part):
                self.picture.draw(mark, complex(scene.place(anchor, z)))

    def lines(self, scene: Scene, z: ComplexArray, pen: Pen, pin: Mark) -> None:
        """Draw members and cylinders at positions (nodes,) as lines, with pins and blocks as marks."""
        for symbol in (*scene.bodies, *scene.cylinders):
            outline = scene.line(symbol.ends, z)
            self.picture.draw(pen, np.append(outline, outline[: symbol.filled]))
        pinned = {*scene.pins, *(end.node for block in scene.blocks for end in block.ends)} - scene.fixed
        self.picture.draw(pin, *z[sorted(pinned)].tolist())

    def crosses(self, scene: Scene) -> None:
        """Mark the nodes of the frame to which nothing is attached, such as those that only define a guide."""
        with self.picture.named(GROUND):
            self.picture.draw(style.CROSS, *scene.poses[0][list(scene.crosses)].tolist())

    def curves(self, curves: Mapping[str, ComplexArray], nested: bool = False) -> None:
        """Draw curves by name; the first ones are wider if they are `nested`, so that they remain visible."""
        for index, (name, curve) in enumerate(curves.items()):
            pen, above = curve_pen(index), (len(curves) - 1 - index) / max(1, len(curves) - 1)
            if nested:
                pen = replace(pen, width=NARROW + above * (WIDE - NARROW))
            with self.picture.named(f"curve:{name}"):
                self.picture.draw_runs(pen, drawn_runs(curve, self.picture.frame.point))
            if index < MOST_KEYS:
                self.picture.legend.append((name, pen))
        if len(curves) > MOST_KEYS:
            self.picture.legend.append((f"and {len(curves) - MOST_KEYS} more", Pen(0.0)))

    def numbered(self, shown: Sequence[Shown], marks: Mapping[str, Mark], color: str = INK, size: float = FONT) -> None:
        """Draw the marks of numbered positions by their kind, and request their numbers beside them."""
        for kind, mark in marks.items():
            self.picture.draw(mark, *(z for one in shown if one.kind == kind for z in one.at), key=kind)
        near = TOGETHER * self.picture.frame.point
        every = ((z, str(one.number)) for one in shown for z in one.at)
        for together in alike(every, lambda one, first: abs(first[0] - one[0]) < near):
            self.labels.beside(together[0][0], ", ".join(dict.fromkeys(number for _, number in together)), color, size)

    def write(self, nodes: Sequence[int] = (), points: Mapping[str, complex] | None = None) -> Picture:
        """Write the names of nodes and the requested texts, and return the picture.

        With `points` the names of the points of members and of these are written, too.
        """
        scene, named = self.scene, dict(points or {})
        if scene and points is not None:
            named = {
                name: complex(scene.place(anchor, scene.poses[0])) for name, anchor in scene.tracers.items()
            } | named
        if len(nodes) <= MOST_NAMES:
            own = [(scene.mechanism.nodes[node], complex(scene.poses[0][node])) for node in nodes] if scene else []
            for name, z in (*own, *named.items()):
                if np.isfinite(z):
                    self.labels.beside(complex(z), name)
        self.labels.write()
        return self.picture


def coloured(own: Pen | Fill, colour: str | None) -> Pen | Fill:
    """Return the style of a member, block or cylinder in a colour; areas are filled with a light tint of it."""
    if colour is None or own not in COLOURED:
        return own
    return replace(own, color=colour) if isinstance(own, Pen) else replace(own, face=tint(colour), edge=colour)


def part_names(scene: Scene) -> list[str]:
    """Return the names of the members, sliding pairs and drives."""
    return [symbol.name for symbol in (*scene.bodies, *scene.blocks, *scene.drives)]


def _parts(scene: Scene, only: Sequence[str]) -> set[str]:
    """Return the names of the parts that are drawn; all if none is given."""
    names = part_names(scene)
    for name in only:
        if name not in names:
            raise UsageError(f"ghosts: no member '{name}'; members: {', '.join(dict.fromkeys(names))}")
    return set(only or names)
