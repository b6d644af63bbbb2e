"""Many positions of one mechanism side by side, with the same window in every panel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.axes import fill, set_up, title_lines, write_title
from gimcli.output.curves import drawn_runs
from gimcli.output.drawing import length_labels
from gimcli.output.labels import Labels
from gimcli.output.part_groups import PartNames
from gimcli.output.picture import LAYOUT, Frame, Gallery, Picture, PictureLayout, composition
from gimcli.output.pose import draw_markers, draw_strong
from gimcli.output.scene import Scene
from gimcli.output.sizes import title_height
from gimcli.output.style import LEFT, LINE, RIGHT, TOP, curve_pen

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
) -> Gallery:  # fmt: skip
    """Return the panels of positions (panels, nodes), each with its title, and its path if there are paths."""
    scenes = [Scene(mechanism, z[None, :]) for z in positions]
    columns = columns_of(len(scenes))
    extents = [s.extent() for s in scenes] + [positions.ravel(), *paths]
    frame = window_of(np.concatenate(extents), columns, layout)
    labels = length_labels(mechanism)
    panels = []
    for k, (scene, name) in enumerate(zip(scenes, titles, strict=True)):
        panel = Picture(name, frame, labels)
        for path in paths[k : k + 1]:
            with panel.named("curve"):
                panel.stroke(curve_pen(0), *(run for run in drawn_runs(path, frame.point) if len(run) > 1))
        draw_strong(panel, scene)
        draw_markers(panel, scene)
        names = Labels(panel)
        for node in sorted(scene.used if len(scenes) <= NAMED else scene.used & scene.fixed):
            names.beside(complex(scene.poses[0][node]), mechanism.nodes[node])
        names.write()
        panels.append(panel)
    return Gallery(title, tuple(panels), columns)


def columns_of(count: int) -> int:
    """Return the number of panels side by side."""
    return next((c for c in range(1, 6) if count <= c * c), 6)


def window_of(points: ComplexArray, columns: int, layout: PictureLayout) -> Frame:
    """Return the window around some points with equal axes, for panels in a number of columns."""
    if layout.fills:
        return Frame.around(points, layout)
    width = float(np.clip(WIDTH / columns - GAP, NARROWEST, WIDEST))
    low, high = complex(points.real.min(), points.imag.min()), complex(points.real.max(), points.imag.max())
    span = high - low
    per_inch = max(span.real / (width - 2 * BORDER), span.imag / (HIGHEST - 2 * BORDER))
    if not per_inch > 0.0:
        return Frame.around(points, layout)
    height = min(max(span.imag / per_inch + 2 * BORDER, 0.45 * width), HIGHEST)
    half, centre = complex(width, height) * per_inch / 2, (low + high) / 2
    return Frame(centre - half, centre + half, width, height, layout.font)


def panel_size(gallery: Gallery, size: tuple[float, float], font: float) -> tuple[float, float]:
    """Return the width and height [in] of the panels' axes in a figure of a size [in]."""
    rows = -(-len(gallery.panels) // gallery.columns)
    width = (size[0] - LEFT * font - RIGHT) / gallery.columns - GAP
    top = TOP + title_height(gallery.title, size[0], font)
    return width, (size[1] - top - FOOT * font) / rows - HEAD * font


def gallery_figure(gallery: Gallery, size: tuple[float, float] | None = None, names: PartNames | None = None) -> Any:
    """Return the matplotlib figure of a gallery; only the left and the lowest panels have numbers at their axes."""
    from matplotlib.figure import Figure

    columns, frame = gallery.columns, gallery.panels[0].frame
    rows, font = -(-len(gallery.panels) // columns), frame.font
    width = size[0] if size else LEFT * font + columns * (frame.width + GAP) + RIGHT
    lines = title_lines(gallery.title, width, font)
    top = TOP + len(lines) * LINE * font
    height = size[1] if size else top + rows * (frame.height + HEAD * font) + FOOT * font
    figure = Figure((width, height))
    for k, panel in enumerate(gallery.panels):
        row, column = divmod(k, columns)
        left = LEFT * font + column * (frame.width + GAP)
        bottom = height - top - (row + 1) * (frame.height + HEAD * font)
        axes = figure.add_axes((left / width, bottom / height, frame.width / width, frame.height / height))
        set_up(axes, panel)
        fill(axes, panel, names)
        axes.set_title(panel.title, pad=3.0, parse_math=False)
        if column:
            axes.set(ylabel="", yticklabels=[])
        if k + columns < len(gallery.panels):
            axes.set(xlabel="", xticklabels=[])
    write_title(figure, lines, 0.5, 1 - 0.12 / height)
    return figure
