"""The picture of equilibria: stable positions with full lines, the others with dashes, each with its number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.drawing import name_nodes, plot
from gimcli.output.labels import Labels
from gimcli.output.picture import LAYOUT, Picture, PictureLayout, composition
from gimcli.output.pose import draw_markers, draw_strong
from gimcli.output.scene import Scene
from gimcli.output.style import GHOST_PIN, INK, Mark, Pen

STABLE = Pen(1.6, "#3577bd", layer=4)
OTHER = Pen(1.3, "#a50f15", (3.0, 2.0), layer=3)
"""Lines of the members in further stable positions, and in the others."""

MARKS = {
    "stable": Mark("s", 5.5, face=INK, width=0.5, layer=11),
    "unstable": Mark("o", 5.5, width=1.1, layer=11),
    "undecided": Mark("D", 5.0, layer=11),
}
"""The mark of each stability at a point that moves."""

MOST = 12
"""Largest number of positions that are drawn."""


@dataclass(frozen=True)
class ShownEquilibrium:
    """An equilibrium in the file's units."""

    number: int
    stability: str
    pose: ComplexArray = field(repr=False)  # (nodes,)


@composition
def equilibria_picture(
    mechanism: Mechanism, shown: Sequence[ShownEquilibrium], title: str, *, layout: PictureLayout = LAYOUT
) -> Picture:
    """Return the mechanism in each equilibrium, the first stable one with all symbols; at least one is needed."""
    strong = next((one for one in shown if one.stability == "stable"), shown[0])
    drawn = [strong, *(one for one in shown if one is not strong)][:MOST]
    scene = Scene(mechanism, np.array([one.pose for one in drawn]))
    picture = plot(mechanism, title, [scene.extent(list(range(len(drawn))))], layout)
    for pose, one in enumerate(drawn[1:], start=1):
        with picture.named(f"equilibrium:{one.number}"):
            _draw_lines(picture, scene, pose, STABLE if one.stability == "stable" else OTHER)
    draw_strong(picture, scene)
    draw_markers(picture, scene)
    labels, node = Labels(picture), _free_node(scene)
    for kind, mark in MARKS.items():
        own = [one for one in drawn if one.stability == kind]
        if own:
            picture.mark(mark, *(complex(one.pose[node]) for one in own))
            picture.legend.append((kind, mark))
    _write_numbers(labels, drawn, node, picture)
    name_nodes(labels, scene, sorted(scene.used & scene.fixed), {})
    labels.write()
    return picture


def _draw_lines(picture: Picture, scene: Scene, pose: int, pen: Pen) -> None:
    """Draw the members of a position as lines."""
    z = scene.poses[pose]
    for body in scene.bodies:
        outline = [scene.place(anchor, z) for anchor in body.outline]
        picture.stroke(pen, [*outline, outline[0]] if body.kind == "plate" else outline)
    for drive in scene.drives:
        if drive.kind == "cylinder":
            picture.stroke(pen, z[list(drive.nodes)])
    picture.mark(GHOST_PIN, *z[[node for node in scene.pins if node not in scene.fixed]].tolist())


def _free_node(scene: Scene) -> int:
    """Return the node with the greatest distances between its places; of a single position, one that moves."""
    moving = [node for node in sorted(scene.used) if node not in scene.fixed] or [0]
    spread = [float(np.abs(scene.poses[:, node] - scene.poses[:, node].mean()).max()) for node in moving]
    return moving[int(np.argmax(spread))]


def _write_numbers(labels: Labels, drawn: Sequence[ShownEquilibrium], node: int, picture: Picture) -> None:
    """Write the numbers of the equilibria, those at the same place together."""
    together: list[tuple[complex, list[int]]] = []
    for one in sorted(drawn, key=lambda one: one.number):
        at = complex(one.pose[node])
        near = next((own for place, own in together if abs(place - at) < 4.0 * picture.frame.point), None)
        if near is None:
            together.append((at, [one.number]))
        else:
            near.append(one.number)
    for place, numbers in together:
        labels.beside(place, ", ".join(map(str, numbers)), size=10.0)
