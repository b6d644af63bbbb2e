"""Pictures of positions, motions and convergence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.output import style
from gimcli.output.picture import HIGHEST, LAYOUT, WIDEST, Frame, Picture, PictureLayout, composition
from gimcli.output.pose import Drawing, solved
from gimcli.output.style import Pen
from gimcli.output.vectors import Arrows, Field

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
    light = light_poses(len(scene.poses), layout.ghosts) if scene else []
    traced = {name: np.asarray(curve, dtype=np.complex128) for name, curve in curves.items()}
    shown = [*([scene.extent([0, *light])] if scene else []), *traced.values()]
    traced |= {name: _within(curve, shown) for name, curve in (measured or {}).items()}
    goals = np.array(targets, dtype=np.complex128)
    drawing = Drawing.around(mechanism, scene, title, [*traced.values(), *areas, goals], layout, [0, *light])
    if areas:
        with drawing.picture.named("area-swept"):
            drawing.picture.draw(style.SWEPT, *areas)
        drawing.picture.legend.append(("area swept", Pen(7.0, style.SWEPT.face)))
    drawing.poses(light, layout.members, crosses=False)
    drawing.curves(traced, nested)
    with drawing.picture.named("targets"):
        drawing.picture.draw(style.TARGET, *targets, key="targets")
    return drawing.write(sorted(scene.used) if scene else (), {})


def _within(curve: ComplexArray, content: Sequence[ComplexArray]) -> ComplexArray:
    """Return a curve with NaN for the points that are far from everything else in the picture."""
    z = np.concatenate([*content, np.zeros(0, dtype=np.complex128)])
    z = z[np.isfinite(z)]
    if not len(z):
        return curve
    reach = REACH * max(float(np.ptp(z.real)), float(np.ptp(z.imag)))
    every = ((z.real, curve.real), (z.imag, curve.imag))
    outside = [(own < shown.min() - reach) | (own > shown.max() + reach) for shown, own in every]
    return np.where(outside[0] | outside[1], complex(np.nan, np.nan), curve)


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
    drawing = Drawing.around(mechanism, scene, title, [*shown, field.extent()], layout)
    own = {point.name for point in mechanism.points} if scene else set()
    for name, z in points.items():
        if name not in own and np.isfinite(z):
            with drawing.picture.named(f"point:{name}"):
                drawing.picture.draw(style.TRACER, z)
    drawing.poses()
    with drawing.picture.named("vectors"):
        field.draw(drawing.picture)
    return drawing.write(range(len(mechanism.nodes)), points) if scene else drawing.picture


def history_picture(
    errors: FloatArray, fit: tuple[float, float] | None, title: str, predicted: float, first: int
) -> Picture:
    """Return the error per sweep on a logarithmic axis, its fit and the predicted slope."""
    sweeps = first + np.arange(len(errors), dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        curve = sweeps + 1j * np.log10(np.asarray(errors, dtype=np.float64))
    curve = curve[np.isfinite(curve)]
    picture = Picture(title, _window(curve), ("sweep", "relative error"), logarithmic=True)
    picture.draw(style.DOT, *curve.tolist(), key="error")
    c1, c2 = fit if fit is not None else (float("nan"), float("nan"))
    _draw_decay(picture, c1, c2, Pen(1.3, style.INK), f"fit {c1:.3g} exp(−{c2:.4g} n)")
    if np.isfinite(predicted) and predicted > 0 and len(curve):
        start = c1 if np.isfinite(c1) and c1 > 0 else 10.0 ** curve[0].imag * predicted ** -curve[0].real
        pen = Pen(1.6, "#a50f15", (4.0, 2.5), layer=5)
        _draw_decay(picture, start, -np.log(predicted), pen, f"predicted slope, ρ = {predicted:.4g}")
    return picture


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
    picture.draw(pen, sweeps + 1j * (np.log10(start) - rate * sweeps / np.log(10.0)), key=name)
