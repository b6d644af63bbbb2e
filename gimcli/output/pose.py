"""Draw a mechanism at one pose with the symbols of textbooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from gimcli.errors import UsageError
from gimcli.mechanism import ComplexArray
from gimcli.output import force_symbols, style, symbols
from gimcli.output.picture import Picture
from gimcli.output.scene import Drive, ForceElement, LoadArrow, MemberOutline, Scene, Slider
from gimcli.output.style import Fill

FRAME = "frame"
"""Name of the part with the symbols of the frame."""


def draw_ghost(picture: Picture, scene: Scene, pose: int, only: Sequence[str] = ()) -> None:
    """Draw one of the other poses with light lines, all of it or only the members, blocks and cylinders of some names.

    Raises:
        UsageError: there is no part of a name.
    """
    z, shown = scene.poses[pose], _parts(scene, only)
    for body in scene.bodies:
        if scene.mechanism.members[body.member].name not in shown:
            continue
        outline = [scene.place(anchor, z) for anchor in body.outline]
        if body.kind == "plate":
            picture.area(style.GHOST_PLATE, outline)
        else:
            picture.stroke(style.GHOST, outline)
    if scene.gears and not only:
        gear_symbols().draw_light_gears(picture, scene, z, scene.gears)
    for drive in scene.drives:
        if drive.kind == "cylinder" and drive.name in shown:
            picture.stroke(style.GHOST, z[list(drive.nodes)])
    for slider in scene.sliders:
        if slider.name in shown:
            along = _along(scene, slider, z)
            symbols.block(picture, *_span(slider, along, z), along, style.GHOST_BLOCK)
    pinned = {n for member in scene.mechanism.members if member.name in shown for n in member.nodes}
    picture.mark(style.GHOST_PIN, *z[[n for n in scene.pins if n in pinned - scene.fixed]].tolist())


def gear_symbols() -> Any:
    """Import the symbols of gears, which few mechanisms have."""
    from gimcli.output import gear_symbols

    return gear_symbols


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
    if scene.gears:
        gear_symbols().draw_gears(picture, scene, z)
    for body in scene.bodies:
        name = scene.mechanism.members[body.member].name
        with picture.named(f"member:{name}"):
            _draw_body(picture, scene, body, z, colours.get(name))
    for slider in scene.sliders:
        with picture.named(f"pair:{slider.name}"):
            _draw_slider(picture, scene, slider, z, colours.get(slider.name))
    with picture.named(FRAME):
        for support in scene.supports:
            symbols.fixed_pivot(picture, complex(z[support.node]), support.upward)
    for element in scene.elements:
        with picture.named(f"{element.kind}:{element.name}"):
            _draw_element(picture, scene, element, z)
    for drive in scene.drives:
        with picture.named(f"actuator:{drive.name}"):
            _draw_drive(picture, scene, drive, z, colours.get(drive.name))
    for load in scene.loads:
        with picture.named(f"load:{load.name}"):
            _draw_load(picture, scene, load, z)
    _draw_points(picture, scene, z)


def _draw_points(picture: Picture, scene: Scene, z: ComplexArray) -> None:
    """Draw the nodes, the points of members and the centres of mass."""
    for mark, nodes in ((style.PIN, scene.pins), (style.DOT, scene.plain)):
        for node in nodes:
            with picture.named(f"node:{scene.mechanism.nodes[node]}"):
                picture.mark(mark, complex(z[node]))
    for name, anchor in scene.tracers.items():
        with picture.named(f"point:{name}"):
            picture.mark(style.TRACER, complex(scene.place(anchor, z)))
    with picture.named("centres-of-mass"):
        for centre in scene.centres:
            force_symbols.centre_of_mass(picture, complex(scene.place(centre.at, z)))


def draw_markers(picture: Picture, scene: Scene) -> None:
    """Draw the nodes of the frame to which nothing is attached, such as those that only define a guide."""
    with picture.named(FRAME):
        picture.mark(style.CROSS, *scene.poses[0][list(scene.crosses)].tolist())


def _along(scene: Scene, slider: Slider, z: ComplexArray) -> complex:
    return complex(slider.along * scene.turn(slider.line.member, z))


def _draw_body(picture: Picture, scene: Scene, body: MemberOutline, z: ComplexArray, colour: str | None) -> None:
    """Draw a plate, a beam or a link."""
    outline = [scene.place(anchor, z) for anchor in body.outline]
    if body.kind == "plate":
        picture.area(_filled(style.PLATE, colour), outline)
        return
    pen = style.BEAM if body.kind == "beam" else style.UPPER if body.above else style.LINK
    picture.stroke(replace(pen, color=colour) if colour else pen, outline)


def _filled(fill: Fill, colour: str | None) -> Fill:
    """Return a fill with an edge of a colour and a light face of the same colour."""
    return replace(fill, face=style.tint(colour), edge=colour) if colour else fill


def _draw_slider(picture: Picture, scene: Scene, slider: Slider, z: ComplexArray, colour: str | None) -> None:
    """Draw a block and its guide."""
    (first, second), along = scene.ends(slider, z), _along(scene, slider, z)
    if slider.side:
        with picture.named(FRAME):
            symbols.frame_guide(picture, first, second, along, slider.side)
    else:
        symbols.moving_guide(picture, first, second, along)
        if slider.bracket:
            picture.stroke(style.LINK, [scene.place(anchor, z) for anchor in slider.bracket])
    symbols.block(picture, *_span(slider, along, z), along, _filled(style.BLOCK, colour))


def _span(slider: Slider, along: complex, z: ComplexArray) -> tuple[complex, complex]:
    """Return the first and last node of a block along its guide."""
    nodes = sorted((complex(z[node]) for node in slider.nodes), key=lambda p: (p * along.conjugate()).real)
    return nodes[0], nodes[-1]


def _draw_drive(picture: Picture, scene: Scene, drive: Drive, z: ComplexArray, colour: str | None) -> None:
    """Draw a turning arrow, a cylinder or a straight arrow."""
    at = complex(z[drive.nodes[0]])
    if drive.kind == "cylinder":
        symbols.cylinder(picture, at, complex(z[drive.nodes[1]]), _filled(style.CYLINDER, colour))
    elif drive.kind == "travel":
        along = complex(drive.direction * scene.turn(drive.guide, z))
        symbols.travel_arrow(picture, at, along, 1j * along * drive.aside, drive.sense)
    else:
        symbols.turning_arrow(picture, at, drive.direction, drive.sense)


def _draw_element(picture: Picture, scene: Scene, element: ForceElement, z: ComplexArray) -> None:
    """Draw a spring or a damper, also about a pivot."""
    first, second = (complex(scene.place(anchor, z)) for anchor in element.ends)
    kind, pivot = element.kind, complex(z[element.pivot])
    if element.pivot < 0:
        force_symbols.STRAIGHT[kind](picture, first, second, element.lane)
    else:
        force_symbols.TORSIONAL[kind](picture, pivot, second - pivot, first - pivot, element.lane)


def _draw_load(picture: Picture, scene: Scene, load: LoadArrow, z: ComplexArray) -> None:
    """Draw a force as an arrow from its point, a torque as an arc."""
    at = complex(scene.place(load.at, z))
    if load.torque:
        force_symbols.torque(picture, at, load.torque)
    else:
        turn = scene.turn(load.at.member, z) if load.follower else 1.0
        force_symbols.force(picture, at, complex(load.force * turn))
