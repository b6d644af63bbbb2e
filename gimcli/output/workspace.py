"""The picture of a workspace: the region and its curves, or the density of a grid of positions, and the mechanism."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.picture import LAYOUT, Picture, PictureLayout, composition
from gimcli.output.pose import Drawing, solved
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
    shown = [
        *(z for group in curves.values() for z in group),
        *([density] if density is not None else []),
        *([np.array([point[1]])] if point[1] is not None else []),
    ]
    drawing = Drawing.around(mechanism, solved(mechanism, pose), title, shown, layout)
    picture = drawing.picture
    if density is not None:
        with picture.named("positions"):
            _draw_density(picture, density)
    else:
        with picture.named("region"):
            _fill(picture, curves)
    for kind, pen in PENS.items():
        ends = 0 if kind == "inner" else 1
        with picture.named(PARTS[kind]):
            picture.draw(pen, *(np.append(z, z[:ends]) for z in curves.get(kind, ())), key=NAMES[kind])
    return _with_pose(drawing, mechanism, point)


@composition
def path_picture(
    mechanism: Mechanism, pose: ComplexArray | None, paths: Sequence[ComplexArray], point: tuple[str, complex | None],
    title: str, *, layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return the paths of a point that one input moves, that of the drawn configuration first, and a pose (nodes,)."""
    drawing = Drawing.around(mechanism, solved(mechanism, pose), title, paths, layout)
    for pen, name, group in (
        (PENS["outer"], "path of the initial configuration", paths[:1]),
        (OTHERS, "paths of other configurations", paths[1:]),
    ):
        with drawing.picture.named(f"curve:{name}"):
            drawing.picture.draw(pen, *group, key=name)
    return _with_pose(drawing, mechanism, point)


def _with_pose(drawing: Drawing, mechanism: Mechanism, point: tuple[str, complex | None]) -> Picture:
    """Draw the mechanism with the names of its nodes, and its point with the name; return the picture."""
    scene, (name, at) = drawing.scene, point
    drawing.poses(crosses=False)
    if at is not None and np.isfinite(at):
        drawing.picture.draw(TRACER, at)
    named = {} if at is None or (scene and name in mechanism.nodes) else {name: at}
    return drawing.write(sorted(scene.used) if scene else (), named)


def _fill(picture: Picture, curves: Mapping[str, Sequence[ComplexArray]]) -> None:
    """Fill the region, large loops first, so that an island in a hole remains visible."""
    loops = [(z, REGION) for z in curves.get("outer", ())] + [(z, VOID) for z in curves.get("hole", ())]
    for layer, (z, fill) in enumerate(sorted(loops, key=lambda loop: -abs(_area(loop[0])))):
        level = -2.0 + layer / (len(loops) + 1.0)
        picture.draw(Fill(fill.face, fill.edge, fill.width, layer=level), z)


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
    level = np.searchsorted(np.quantile(counts[filled], np.arange(1, len(GREYS)) / len(GREYS)), counts[filled])
    for k, grey in enumerate(GREYS):
        chosen = filled[level == k]
        corners = low + cell * (chosen % width + 1j * (chosen // width))
        boxes = corners[:, None] + cell * np.array([0.0, 1.0, 1.0 + 1.0j, 1.0j])
        picture.draw(Fill(grey, grey, 0.2, layer=1), *boxes)
    picture.legend.append(("few positions of the grid", Pen(6.0, GREYS[0], layer=1)))
    picture.legend.append(("many", Pen(6.0, GREYS[-1], layer=1)))
