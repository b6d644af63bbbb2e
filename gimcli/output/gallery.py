"""Many positions of one mechanism side by side, with the same window in every panel."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.axes import title_height
from gimcli.output.curves import drawn_runs
from gimcli.output.picture import LAYOUT, Frame, Picture, PictureLayout, Sheet, composition
from gimcli.output.pose import Drawing, length_labels
from gimcli.output.scene import Scene
from gimcli.output.style import LEFT, RIGHT, TOP, curve_pen

NAMED = 9
"""Largest number of panels in which all nodes are named; with more, only the fixed pivots."""

WIDTH, HIGHEST = 9.6, 3.4
"""Width of all panels together, if there are few, and largest height of one panel [in]."""

NARROWEST, WIDEST = 2.3, 3.4
"""Limits of the width of a panel [in]; the size of symbols does not depend on it."""

BORDER = 0.4
"""Space for symbols inside a panel [in]."""

GAP = 0.12
"""Distance between panels [in]."""

HEAD = 0.2
"""Space above a panel for its number [in]."""

FOOT = 0.5
"""Space below the last row for the numbers and the name of the axis [in]."""


@composition
def gallery_picture(
    mechanism: Mechanism, positions: ComplexArray, titles: Sequence[str], title: str,
    paths: Sequence[ComplexArray] = (), *, layout: PictureLayout = LAYOUT,
) -> Sheet:  # fmt: skip
    """Return the panels of positions (panels, nodes), each with its title, and its path if there are paths."""

    def draw(drawing: Drawing, number: int) -> None:
        for path in paths[number : number + 1]:
            with drawing.picture.named("curve"):
                drawing.picture.draw_runs(curve_pen(0), drawn_runs(path, drawing.picture.frame.point))

    scenes = [Scene(mechanism, z[None, :]) for z in positions]
    return panels_of(scenes, titles, title, draw, layout, [positions.ravel(), *paths])


def panels_of(
    scenes: Sequence[Scene], titles: Sequence[str], title: str, draw: Callable[[Drawing, int], None],
    layout: PictureLayout, shown: Sequence[ComplexArray] = (), colours: Mapping[str, str] | None = None,
) -> Sheet:  # fmt: skip
    """Return a gallery: the first pose of each scene over what `draw` draws in the panel of a number.

    Args:
        scenes: one for each panel.
        titles: what stands above each panel.
        title: what stands above all.
        draw: draws what is below the pose.
        layout: size of the window.
        shown: further points in the window.
        colours: replace black for members, blocks and cylinders, by name.
    """
    columns = next((c for c in range(1, 6) if len(scenes) <= c * c), 6)
    frame = window_of(np.concatenate([*(scene.extent() for scene in scenes), *shown]), columns, layout)
    panels = []
    for number, (scene, name) in enumerate(zip(scenes, titles, strict=True)):
        drawing = Drawing(Picture(name, frame, length_labels(scene.mechanism)), scene)
        draw(drawing, number)
        drawing.poses(colours=colours)
        panels.append(drawing.write(sorted(scene.used if len(scenes) <= NAMED else scene.used & scene.fixed)))
    return Sheet(title, tuple(panels), columns)


def window_of(points: ComplexArray, columns: int, layout: PictureLayout) -> Frame:
    """Return the window around some points with equal axes, for panels in a number of columns."""
    if layout.fills:
        return Frame.around(points, layout)
    width = float(np.clip(WIDTH / columns - GAP, NARROWEST, WIDEST))
    return Frame.around(points, replace(layout, width=width, height=HIGHEST), BORDER, (width, 0.45 * width))


def panel_size(gallery: Sheet, size: tuple[float, float], font: float) -> tuple[float, float]:
    """Return the width and height [in] of the panels' axes in a figure of a size [in]."""
    width = (size[0] - LEFT * font - RIGHT) / gallery.columns - GAP
    top = TOP + title_height(gallery.title, size[0], font)
    return width, (size[1] - top - FOOT * font) / _rows(gallery) - HEAD * font


def gallery_size(gallery: Sheet) -> tuple[float, float]:
    """Return the width and height [in] of the figure of a gallery with the sizes of its panels."""
    frame = gallery.pictures[0].frame
    width = LEFT * frame.font + gallery.columns * (frame.width + GAP) + RIGHT
    top = TOP + title_height(gallery.title, width, frame.font)
    return width, top + _rows(gallery) * (frame.height + HEAD * frame.font) + FOOT * frame.font


def corners(gallery: Sheet, width: float, height: float) -> Iterator[tuple[float, float]]:
    """Yield the lower left corner [in] of each panel in a figure of a size [in]."""
    frame = gallery.pictures[0].frame
    top = TOP + title_height(gallery.title, width, frame.font)
    for row, column in (divmod(k, gallery.columns) for k in range(len(gallery.pictures))):
        left = LEFT * frame.font + column * (frame.width + GAP)
        yield left, height - top - (row + 1) * (frame.height + HEAD * frame.font)


def _rows(gallery: Sheet) -> int:
    return -(-len(gallery.pictures) // gallery.columns)
