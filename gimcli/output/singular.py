"""The picture of singular positions, with the curves of the traced points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.curves import drawn_runs
from gimcli.output.drawing import name_nodes, plot
from gimcli.output.labels import Labels
from gimcli.output.picture import LAYOUT, Picture, PictureLayout, composition
from gimcli.output.pose import draw_ghost, draw_markers, draw_strong
from gimcli.output.scene import Scene
from gimcli.output.style import INK, Mark, Pen, curve_pen

MARKS = {
    "change point": Mark("s", 7.0, width=1.4, layer=9),
    "tangency": Mark("D", 6.0, layer=9),
    "limit": Mark("^", 7.0, face=INK, layer=9),
    "dead point": Mark("X", 7.0, face=INK, width=0.4, layer=9),
    "stationary": Mark("o", 5.0, layer=9),
}
"""The mark of each kind of singular position."""


@dataclass(frozen=True)
class Shown:
    """A singular position in the file's units."""

    number: int
    kind: str
    pose: ComplexArray = field(repr=False)  # (nodes,)
    at: tuple[complex, ...]  # places of its marks


@composition
def singular_picture(
    mechanism: Mechanism, shown: Sequence[Shown], curves: Mapping[str, ComplexArray], title: str, *,
    layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return the first position strong, some others light, and a numbered mark for each."""
    poses = _chosen(shown, layout.ghosts + 1)
    scene = Scene(mechanism, np.array([s.pose for s in poses])) if poses else None
    picture = plot(mechanism, title, [*curves.values(), *([scene.extent()] if scene else [])], layout)
    if scene:
        for pose in range(1, len(scene.poses)):
            draw_ghost(picture, scene, pose, layout.members)
        draw_strong(picture, scene)
        draw_markers(picture, scene)
    for index, (name, curve) in enumerate(curves.items()):
        pen = curve_pen(index)
        picture.stroke(pen, *(run for run in drawn_runs(curve, picture.frame.point) if len(run) > 1))
        picture.legend.append((name, pen))
    _mark(picture, shown)
    _write(picture, scene, shown)
    return picture


def _chosen(shown: Sequence[Shown], most: int) -> list[Shown]:
    """Return the positions that are drawn with their members, in the order of the kinds in `MARKS`."""
    order = list(MARKS)
    return sorted(shown, key=lambda s: order.index(s.kind))[:most]


def _mark(picture: Picture, shown: Sequence[Shown]) -> None:
    for kind, mark in MARKS.items():
        places = [z for s in shown if s.kind == kind for z in s.at]
        if places:
            picture.mark(mark, *places)
            picture.legend.append((kind, mark))


def _write(picture: Picture, scene: Scene | None, shown: Sequence[Shown]) -> None:
    """Write the numbers of the marks, one text for marks at the same place, and the names of the nodes."""
    labels = Labels(picture)
    together: list[tuple[complex, list[int]]] = []
    for s in shown:
        for z in s.at:
            near = next((numbers for at, numbers in together if abs(at - z) < 4.0 * picture.frame.point), None)
            if near is None:
                together.append((z, [s.number]))
            elif s.number not in near:
                near.append(s.number)
    for z, numbers in together:
        labels.beside(z, ", ".join(map(str, numbers)), STRONG.color)
    if scene:
        name_nodes(labels, scene, sorted(scene.used), {})
    labels.write()


STRONG = Pen(1.0, "#a50f15")
