"""Panels with a mechanism at rest, light, and in two extreme positions of a motion, in two colours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output import style
from gimcli.output.drawing import length_labels
from gimcli.output.gallery import NAMED, columns_of, window_of
from gimcli.output.labels import Labels
from gimcli.output.picture import LAYOUT, Frame, Gallery, Picture, PictureLayout, composition
from gimcli.output.pose import draw_ghost, draw_markers, draw_strong, part_names
from gimcli.output.scene import Scene
from gimcli.output.style import Mark, Pen

OTHER = Pen(1.5, style.PALETTE[1], (3.0, 1.5), layer=5)
"""Members in the second extreme position."""

OTHER_PIN = Mark(size=3.6, face=style.PAPER, edge=style.PALETTE[1], width=0.9, layer=6)


@composition
def extremes_gallery(
    mechanism: Mechanism, rest: ComplexArray, extremes: ComplexArray, titles: Sequence[str], title: str, *,
    layout: PictureLayout = LAYOUT,
) -> Gallery:  # fmt: skip
    """Return one panel for each motion.

    Args:
        mechanism: the mechanism.
        rest: position in the middle (nodes,), in the file's coordinates, as the extremes.
        extremes: the two extreme positions (motions, 2, nodes).
        titles: what stands above each panel.
        title: what stands above all.
        layout: size of the window.
    """
    scenes = [Scene(mechanism, np.array([one, rest, other])) for one, other in extremes]
    columns = columns_of(len(scenes))
    frame = window_of(np.concatenate([scene.extent() for scene in scenes]), columns, layout)
    panels = [_panel(scene, frame, name, len(scenes) <= NAMED) for scene, name in zip(scenes, titles, strict=True)]
    return Gallery(title, tuple(panels), columns)


def _panel(scene: Scene, frame: Frame, title: str, all_names: bool) -> Picture:
    mechanism = scene.mechanism
    panel = Picture(title, frame, length_labels(mechanism))
    with panel.named("at-rest"):
        draw_ghost(panel, scene, 1)
    with panel.named("other-extreme"):
        _draw_other(panel, scene, scene.poses[2])
    draw_strong(panel, scene, colours=dict.fromkeys(part_names(scene), style.PALETTE[0]))
    draw_markers(panel, scene)
    labels = Labels(panel)
    for node in sorted(scene.used if all_names else scene.used & scene.fixed):
        labels.beside(complex(scene.poses[0][node]), mechanism.nodes[node])
    labels.write()
    return panel


def _draw_other(panel: Picture, scene: Scene, z: ComplexArray) -> None:
    """Draw the members, cylinders and blocks at a position with dashed lines."""
    for body in scene.bodies:
        outline = [scene.place(anchor, z) for anchor in body.outline]
        panel.stroke(OTHER, [*outline, *outline[: body.kind == "plate"]])
    for drive in scene.drives:
        if drive.kind == "cylinder":
            panel.stroke(OTHER, z[list(drive.nodes)])
    blocks = {node for slider in scene.sliders for node in slider.nodes}
    panel.mark(OTHER_PIN, *z[[n for n in {*scene.pins, *blocks} if n not in scene.fixed]].tolist())
