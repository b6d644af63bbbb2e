"""Values over the time, or over an input: one panel above the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.output.picture import HIGHEST, WIDEST, Frame, Picture, Sheet
from gimcli.output.style import DOT, SOFT, Pen, curve_pen

PANEL = 0.34 * HIGHEST
"""Height of a panel [in]."""

ROOM = 0.06
"""Free border above and below a curve, as part of its span."""

AXIS = Pen(0.8, SOFT, layer=2)


@dataclass(frozen=True)
class Panel:
    """Curves with one vertical axis; marks are places of events."""

    label: str
    curves: Sequence[tuple[str, FloatArray, FloatArray]]  # name, over, values
    marks: Sequence[complex] = ()


def history_sheet(panels: Sequence[Panel], over: str, title: str) -> Sheet:
    """Return panels that share what they run over."""
    return Sheet(title, tuple(_panel(panel, over) for panel in panels))


def _panel(panel: Panel, over: str) -> Picture:
    curves = [x + 1j * y for _, x, y in panel.curves]
    frame = _window(np.concatenate([*curves, np.array(panel.marks, dtype=complex)]))
    picture = Picture("", frame, (over, panel.label))
    if frame.low.imag < 0.0 < frame.high.imag:
        picture.stroke(AXIS, [complex(frame.low.real, 0.0), complex(frame.high.real, 0.0)])
    for k, ((name, _, _), curve) in enumerate(zip(panel.curves, curves, strict=True)):
        picture.stroke(curve_pen(k), *_pieces(curve))
        if name:
            picture.legend.append((name, curve_pen(k)))
    picture.mark(DOT, *panel.marks)
    return picture


def _pieces(curve: ComplexArray) -> list[ComplexArray]:
    """Return the pieces of a curve between its gaps."""
    gaps = np.flatnonzero(~np.isfinite(curve))
    pieces = np.split(curve, np.unique(np.concatenate((gaps, gaps + 1))))
    return [piece for piece in pieces if len(piece) > 1 and np.all(np.isfinite(piece))]


def _window(curve: ComplexArray) -> Frame:
    """Return the window about the finite places of some curves."""
    finite = curve[np.isfinite(curve)]
    z = finite if len(finite) else np.array([0.0j, 1.0 + 1.0j])
    low, high = complex(z.real.min(), z.imag.min()), complex(z.real.max(), z.imag.max())
    wide, tall = high.real - low.real or 1.0, high.imag - low.imag
    if tall <= 1e-12 * max(abs(low.imag), abs(high.imag), 1e-300):
        tall = abs(low.imag) or 1.0
        low, high = low - 0.5j * tall, high + 0.5j * tall
    return Frame(low - 1j * ROOM * tall, complex(low.real + wide, high.imag + ROOM * tall), WIDEST, PANEL)
