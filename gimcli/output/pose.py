"""Draw a mechanism at one pose with the symbols of textbooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gimcli.errors import UsageError
from gimcli.mechanism import ComplexArray
from gimcli.output import style
from gimcli.output.mechanism_symbols import GROUND, coloured, light_symbols, point_marks, strong_symbols
from gimcli.output.picture import Picture
from gimcli.output.scene import Scene
from gimcli.output.style import Pen


def draw_ghost(picture: Picture, scene: Scene, pose: int, only: Sequence[str] = ()) -> None:
    """Draw one of the other poses with light lines, all of it or only the members, blocks and cylinders of some names.

    Raises:
        UsageError: there is no part of a name.
    """
    z, shown = scene.poses[pose], _parts(scene, only)
    for symbol in light_symbols(scene):
        if not only or symbol.name in shown:
            for stroke in symbol.strokes:
                picture.draw(stroke.style, *symbol.paths(stroke, scene, z, picture.frame.point))
    pinned = {n for member in scene.mechanism.members if member.name in shown for n in member.nodes}
    picture.mark(style.GHOST_PIN, *z[[n for n in scene.pins if n in pinned - scene.fixed]].tolist())


def part_names(scene: Scene) -> list[str]:
    """Return the names of the members, sliding pairs and drives."""
    bodies = [scene.mechanism.members[body.member].name for body in scene.bodies]
    return bodies + [slider.name for slider in scene.sliders] + [drive.name for drive in scene.drives]


def _parts(scene: Scene, only: Sequence[str]) -> set[str]:
    """Return the names of the parts that are drawn; all if none is given."""
    names = part_names(scene)
    for name in only:
        if name not in names:
            raise UsageError(f"ghosts: no member '{name}'; members: {', '.join(dict.fromkeys(names))}")
    return set(only or names)


def draw_strong(
    picture: Picture, scene: Scene, positions: ComplexArray | None = None, colours: Mapping[str, str] | None = None
) -> None:
    """Draw the first pose, or other positions of the nodes (nodes,), with all symbols.

    `colours` replace black for members, blocks and cylinders, by name.
    """
    z, colours = scene.poses[0] if positions is None else positions, colours or {}
    for symbol in strong_symbols(scene):
        with picture.named(symbol.part):
            for stroke in symbol.strokes:
                own = coloured(stroke.style, colours.get(symbol.name))
                picture.draw(own, *symbol.paths(stroke, scene, z, picture.frame.point))
    for part, mark, anchor in point_marks(scene):
        with picture.named(part):
            picture.mark(mark, complex(scene.place(anchor, z)))


def draw_lines(picture: Picture, scene: Scene, z: ComplexArray, pen: Pen) -> None:
    """Draw the outlines of the members and the cylinders at positions of the nodes (nodes,) as lines."""
    for body in scene.bodies:
        outline = [scene.place(anchor, z) for anchor in body.outline]
        picture.stroke(pen, [*outline, *outline[: body.kind == "plate"]])
    for drive in scene.drives:
        if drive.kind == "cylinder":
            picture.stroke(pen, z[list(drive.nodes)])


def draw_markers(picture: Picture, scene: Scene) -> None:
    """Draw the nodes of the frame to which nothing is attached, such as those that only define a guide."""
    with picture.named(GROUND):
        picture.mark(style.CROSS, *scene.poses[0][list(scene.crosses)].tolist())
