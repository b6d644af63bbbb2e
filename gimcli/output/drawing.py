"""Pictures of positions, motions and convergence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.output import style
from gimcli.output.curves import drawn_runs
from gimcli.output.labels import Labels
from gimcli.output.picture import HIGHEST, LAYOUT, WIDEST, Frame, Picture, PictureLayout, composition
from gimcli.output.pose import draw_ghost, draw_markers, draw_strong
from gimcli.output.scene import Scene
from gimcli.output.style import Mark, Pen, curve_pen
from gimcli.output.vectors import Arrows, Field
from gimcli.table import labelled

MOST_NAMES = 40
"""With more nodes, no names are written."""

MOST_KEYS = 18
"""Largest number of curves in the legend."""

NARROW, WIDE = 1.2, 4.2
"""Widths of the last and of the first of curves that overlap [pt]."""

REACH = 0.4
"""A measure's curve is shown up to this distance, in sizes of the drawing, beyond it: centrodes extend to infinity."""


@composition
def motion_picture(
    mechanism: Mechanism, positions: ComplexArray, curves: Mapping[str, ComplexArray], title: str,
    measured: Mapping[str, ComplexArray] | None = None, areas: Sequence[ComplexArray] = (), *, nested: bool = False,
    targets: Sequence[complex] = (), layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return some poses, the first one strong and the others light, the traced curves, and curves of the measures.

    `nested` draws the first curves wider, so that those that are drawn over them leave them visible. `targets` are
    points that a fit has to pass.
    """
    scene = solved(mechanism, positions)
    traced = [np.asarray(curve, dtype=np.complex128) for curve in curves.values()]
    light = light_poses(len(scene.poses), layout.ghosts) if scene else []
    shown = [scene.extent([0, *light]), *traced] if scene else traced
    more = {name: _within(curve, shown) for name, curve in (measured or {}).items()}
    everything = [*shown, *more.values(), *(np.ravel(area) for area in areas), np.array(targets, dtype=np.complex128)]
    picture = plot(mechanism, title, everything, layout)
    if areas:
        with picture.named("area-swept"):
            picture.area(style.SWEPT, *areas)
        picture.legend.append(("area swept", Pen(7.0, style.SWEPT.face)))
    if scene:
        for number, pose in enumerate(light, start=1):
            with picture.named(f"light-position:{number}"):
                draw_ghost(picture, scene, pose, layout.members)
        draw_strong(picture, scene)
    _draw_curves(picture, dict(zip(curves, traced, strict=True)) | more, nested)
    if len(targets):
        with picture.named("targets"):
            picture.mark(style.TARGET, *targets)
        picture.legend.append(("targets", style.TARGET))
    if scene:
        _write_names(picture, scene, sorted(scene.used), {})
    return picture


def _within(curve: ComplexArray, shown: Sequence[ComplexArray]) -> ComplexArray:
    """Return a curve with NaN for the points that are far from everything else in the picture."""
    z = np.concatenate([*shown, np.zeros(0, dtype=np.complex128)])
    z = z[np.isfinite(z)]
    if not len(z):
        return curve
    reach = REACH * max(float(np.ptp(z.real)), float(np.ptp(z.imag)))
    outside = (curve.real < z.real.min() - reach) | (curve.real > z.real.max() + reach)
    outside |= (curve.imag < z.imag.min() - reach) | (curve.imag > z.imag.max() + reach)
    return np.where(outside, complex(np.nan, np.nan), curve)


def light_poses(poses: int, most: int) -> list[int]:
    """Return the numbers of poses that are drawn light: at most `most`, evenly spread behind the first."""
    return sorted({round(k * poses / (most + 1)) for k in range(1, most + 1)} - {0, poses})


@composition
def position_picture(
    mechanism: Mechanism, position: ComplexArray, title: str, points: Mapping[str, complex],
    arrows: Sequence[Arrows] = (), *, layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return one pose with the names of its nodes and points, and vectors at them."""
    scene = solved(mechanism, position)
    named = np.array(list(points.values()), dtype=np.complex128)
    shown = [np.ravel(position), named, *([scene.extent()] if scene else [])]
    field = Field(arrows, np.concatenate(shown))
    picture = plot(mechanism, title, [*shown, field.extent()], layout)
    own = {point.name for point in mechanism.points} if scene else set()
    for name, z in points.items():
        if name not in own and np.isfinite(z):
            with picture.named(f"point:{name}"):
                picture.mark(style.TRACER, z)
    if scene:
        draw_strong(picture, scene)
        draw_markers(picture, scene)
    with picture.named("vectors"):
        field.draw(picture)
    if scene:
        _write_names(picture, scene, range(len(mechanism.nodes)), points)
    return picture


def history_picture(
    errors: FloatArray, fit: tuple[float, float] | None, title: str, predicted: float, first: int
) -> Picture:
    """Return the error per sweep on a logarithmic axis, its fit and the predicted slope."""
    sweeps = first + np.arange(len(errors), dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        curve = sweeps + 1j * np.log10(np.asarray(errors, dtype=np.float64))
    curve = curve[np.isfinite(curve)]
    picture = Picture(title, _window(curve), ("sweep", "relative error"), logarithmic=True)
    picture.mark(style.DOT, *curve.tolist())
    picture.legend.append(("error", style.DOT))
    c1, c2 = fit if fit is not None else (float("nan"), float("nan"))
    _draw_decay(picture, c1, c2, Pen(1.3, style.INK), f"fit {c1:.3g} exp(−{c2:.4g} n)")
    if np.isfinite(predicted) and predicted > 0 and len(curve):
        start = c1 if np.isfinite(c1) and c1 > 0 else 10.0 ** curve[0].imag * predicted ** -curve[0].real
        pen = Pen(1.6, "#a50f15", (4.0, 2.5), layer=5)
        _draw_decay(picture, start, -np.log(predicted), pen, f"predicted slope, ρ = {predicted:.4g}")
    return picture


def solved(mechanism: Mechanism, positions: ComplexArray) -> Scene | None:
    """Return the poses without NaN, or None if there are none."""
    poses = np.atleast_2d(np.asarray(positions, dtype=np.complex128))
    poses = poses[np.all(np.isfinite(poses), axis=1)]
    return Scene(mechanism, poses) if len(poses) else None


def plot(mechanism: Mechanism, title: str, shown: Sequence[ComplexArray], layout: PictureLayout = LAYOUT) -> Picture:
    """Return an empty picture with equal axes around the given points."""
    frame = Frame.around(np.concatenate([*shown, np.zeros(0, dtype=np.complex128)]), layout)
    return Picture(title, frame, length_labels(mechanism))


def length_labels(mechanism: Mechanism) -> tuple[str, str]:
    """Return the names of the axes, with the file's unit."""
    return labelled("x", mechanism.length_unit), labelled("y", mechanism.length_unit)


def _draw_curves(picture: Picture, curves: Mapping[str, ComplexArray], nested: bool) -> None:
    for index, (name, curve) in enumerate(curves.items()):
        pen, above = curve_pen(index), (len(curves) - 1 - index) / max(1, len(curves) - 1)
        if nested:
            pen = replace(pen, width=NARROW + above * (WIDE - NARROW))
        runs = drawn_runs(curve, picture.frame.point)
        with picture.named(f"curve:{name}"):
            picture.stroke(pen, *(run for run in runs if len(run) > 1))
            picture.mark(Mark("o", 2.0, pen.color, pen.color), *(run[0] for run in runs if len(run) == 1))
        if index < MOST_KEYS:
            picture.legend.append((name, pen))
    if len(curves) > MOST_KEYS:
        picture.legend.append((f"and {len(curves) - MOST_KEYS} more", Pen(0.0)))


def _write_names(picture: Picture, scene: Scene, nodes: Sequence[int], points: Mapping[str, complex]) -> None:
    labels = Labels(picture)
    name_nodes(labels, scene, nodes, points)
    labels.write()


def name_nodes(labels: Labels, scene: Scene, nodes: Sequence[int], points: Mapping[str, complex]) -> None:
    """Request the names of nodes and points beside them, unless there are too many."""
    mechanism = scene.mechanism
    if len(nodes) > MOST_NAMES:
        return
    own = {name: complex(scene.place(anchor, scene.poses[0])) for name, anchor in scene.tracers.items()}
    for node in nodes:
        labels.beside(complex(scene.poses[0][node]), mechanism.nodes[node])
    for name, z in {**own, **points}.items():
        if np.isfinite(z):
            labels.beside(complex(z), name)


def _window(curve: ComplexArray) -> Frame:
    """Return the window of a history, from one power of ten to another."""
    z = curve if len(curve) else np.array([0.0j, 10.0 - 6.0j])
    low, high = np.floor(z.imag.min() - 0.05), np.ceil(z.imag.max() + 0.05)
    span = max(1.0, float(z.real.max() - z.real.min()))
    left, right = float(z.real.min()) - 0.03 * span, float(z.real.min()) + 1.03 * span
    return Frame(complex(left, low), complex(right, high), WIDEST, 0.7 * HIGHEST)


def _draw_decay(picture: Picture, start: float, rate: float, pen: Pen, name: str) -> None:
    """Draw an exponential over the width of the window."""
    if not (np.isfinite(start) and start > 0 and np.isfinite(rate)):
        return
    low, high = picture.frame.low, picture.frame.high
    sweeps = np.linspace(low.real, high.real, 60)
    picture.stroke(pen, sweeps + 1j * (np.log10(start) - rate * sweeps / np.log(10.0)))
    picture.legend.append((name, pen))
