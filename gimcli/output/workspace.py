"""The picture of a workspace: the region and its curves, or the density of a grid of positions, and the mechanism."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.output.drawing import name_nodes, plot, solved
from gimcli.output.labels import Labels
from gimcli.output.picture import LAYOUT, Picture, PictureLayout, composition
from gimcli.output.pose import draw_strong
from gimcli.output.scene import Scene
from gimcli.output.style import INK, PAPER, TRACER, Fill, Pen

REGION = Fill("#ececec", "none", 0.0, layer=0)
VOID = Fill(PAPER, "none", 0.0, layer=0)
PENS = {
    "outer": Pen(1.9, INK, layer=7),
    "hole": Pen(1.9, "#a50f15", (5.0, 1.6), layer=7),
    "inner": Pen(0.9, "#4a6fa5", (1.4, 1.8), layer=6),
}
OTHERS = Pen(1.1, "#20508c", (4.0, 2.0), layer=7)
"""Paths of other configurations."""
PARTS = {"outer": "boundary", "hole": "hole", "inner": "inner-curves"}
NAMES = {"outer": "boundary", "hole": "hole", "inner": "inner curve: limit of some configurations"}

GREYS = ("#efefef", "#e2e2e2", "#d4d4d4", "#c4c4c4", "#b0b0b0")
"""Greys of the cells, from few positions to many."""

CELLS = 110
"""Number of cells along the longer side."""


@composition
def workspace_picture(
    mechanism: Mechanism, pose: ComplexArray | None, curves: Mapping[str, Sequence[ComplexArray]],
    point: tuple[str, complex | None], density: ComplexArray | None, title: str, *,
    layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return the region between the curves of each kind, and a pose (nodes,), in the file's units.

    `density` (rows,) are reached positions, drawn as cells; without it the region is filled.
    """
    scene = None if pose is None else solved(mechanism, pose)
    shown = [
        *(z for group in curves.values() for z in group),
        *([scene.extent()] if scene else []),
        *([density] if density is not None else []),
        *([np.array([point[1]])] if point[1] is not None else []),
    ]
    picture = plot(mechanism, title, shown, layout)
    if density is not None:
        with picture.named("positions"):
            _draw_density(picture, density)
    else:
        with picture.named("region"):
            _fill(picture, curves)
    for kind, pen in PENS.items():
        group = curves.get(kind, ())
        if group:
            ends = () if kind == "inner" else (1,)
            with picture.named(PARTS[kind]):
                picture.stroke(pen, *(np.append(z, z[:1]) if ends else z for z in group))
            picture.legend.append((NAMES[kind], pen))
    _draw_pose(picture, scene, point)
    return picture


@composition
def path_picture(
    mechanism: Mechanism, pose: ComplexArray | None, paths: Sequence[ComplexArray], point: tuple[str, complex | None],
    title: str, *, layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return the paths of a point that one input moves, that of the drawn configuration first, and a pose (nodes,)."""
    scene = None if pose is None else solved(mechanism, pose)
    picture = plot(mechanism, title, [*paths, *([scene.extent()] if scene else [])], layout)
    for pen, name, group in (
        (PENS["outer"], "path of the initial configuration", paths[:1]),
        (OTHERS, "paths of other configurations", paths[1:]),
    ):
        if group:
            with picture.named(f"curve:{name}"):
                picture.stroke(pen, *group)
            picture.legend.append((name, pen))
    _draw_pose(picture, scene, point)
    return picture


def _draw_pose(picture: Picture, scene: Scene | None, point: tuple[str, complex | None]) -> None:
    """Draw the mechanism with the names of its nodes, and its point with the name."""
    if scene is not None:
        draw_strong(picture, scene)
    name, at = point
    if at is not None and np.isfinite(at):
        picture.mark(TRACER, at)
    labels = Labels(picture)
    if scene is not None:
        named = {name: at} if at is not None and name not in scene.mechanism.nodes else {}
        name_nodes(labels, scene, sorted(scene.used), named)
    elif at is not None and np.isfinite(at):
        labels.beside(at, name)
    labels.write()


def _fill(picture: Picture, curves: Mapping[str, Sequence[ComplexArray]]) -> None:
    """Fill the region, large loops first, so that an island in a hole remains visible."""
    loops = [(z, REGION) for z in curves.get("outer", ())] + [(z, VOID) for z in curves.get("hole", ())]
    for layer, (z, fill) in enumerate(sorted(loops, key=lambda loop: -abs(_area(loop[0])))):
        level = -2.0 + layer / (len(loops) + 1.0)
        picture.area(Fill(fill.face, fill.edge, fill.width, layer=level), z)


def _area(z: ComplexArray) -> float:
    return 0.5 * float(np.sum((z.conjugate() * np.roll(z, -1)).imag))


def _draw_density(picture: Picture, places: ComplexArray) -> None:
    """Draw the cells that contain positions, darker for more positions."""
    z = places[np.isfinite(places)]
    if not len(z):
        return
    cell = max(float(np.ptp(z.real)), float(np.ptp(z.imag))) / CELLS
    if cell <= 0.0:
        return
    low = complex(z.real.min(), z.imag.min())
    column, row = ((z - low).real / cell).astype(int), ((z - low).imag / cell).astype(int)
    width = int(column.max()) + 1
    counts = np.bincount(row * width + column)
    filled = np.flatnonzero(counts)
    level = _levels(counts[filled].astype(float))
    for k, grey in enumerate(GREYS):
        chosen = filled[level == k]
        corners = low + cell * (chosen % width + 1j * (chosen // width))
        boxes = corners[:, None] + cell * np.array([0.0, 1.0, 1.0 + 1.0j, 1.0j])
        picture.area(Fill(grey, grey, 0.2, layer=1), *boxes)
    picture.legend.append(("few positions of the grid", Pen(6.0, GREYS[0], layer=1)))
    picture.legend.append(("many", Pen(6.0, GREYS[-1], layer=1)))


def _levels(counts: FloatArray) -> np.ndarray:
    """Return the level of each count, 0 to the number of greys - 1, with about equal numbers of cells."""
    return np.searchsorted(np.quantile(counts, np.arange(1, len(GREYS)) / len(GREYS)), counts, side="left")
