"""The picture of an inverse dynamics: efforts over the input, and the path of the shaking force."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.output.curves import drawn_runs
from gimcli.output.picture import HIGHEST, WIDEST, Frame, Picture, Sheet
from gimcli.output.style import DOT, SOFT, Pen, curve_pen

PANEL = 0.42 * HIGHEST
"""Height of a panel of efforts [in]."""

ROOM = 0.06
"""Free border above and below a curve, as part of its span."""

AXIS = Pen(0.8, SOFT, layer=2)


@dataclass(frozen=True)
class Effort:
    """One driving torque or force over what drives it."""

    name: str
    unit: str  # N m or N
    over: FloatArray  # (rows,)
    values: FloatArray  # (rows,) NaN where not told
    label: str  # of the horizontal axis


def forces_sheet(efforts: Sequence[Effort], shaking: ComplexArray, title: str) -> Sheet:
    """Return a panel for torques, one for forces, and the path of the shaking force."""
    units = dict.fromkeys(effort.unit for effort in efforts)
    panels = [_panel([e for e in efforts if e.unit == unit], unit) for unit in units]
    return Sheet(title, (*panels, _hodograph(shaking)))


def _panel(efforts: Sequence[Effort], unit: str) -> Picture:
    what = "driving torque [N m]" if unit == "N m" else "driving force [N]"
    curves = [effort.over + 1j * effort.values for effort in efforts]
    frame = _window(np.concatenate(curves))
    picture = Picture("", frame, (efforts[0].label, what))
    picture.stroke(AXIS, [complex(frame.low.real, 0.0), complex(frame.high.real, 0.0)])
    for k, (effort, curve) in enumerate(zip(efforts, curves, strict=True)):
        picture.stroke(curve_pen(k), *_pieces(curve))
        picture.legend.append((effort.name, curve_pen(k)))
    return picture


def _pieces(curve: ComplexArray) -> list[ComplexArray]:
    """Return the pieces of a curve between its gaps."""
    gaps = np.flatnonzero(~np.isfinite(curve))
    pieces = np.split(curve, np.unique(np.concatenate((gaps, gaps + 1))))
    return [piece for piece in pieces if len(piece) > 1 and np.all(np.isfinite(piece))]


def _window(curve: ComplexArray) -> Frame:
    """Return the window about a curve, the line of 0 in it."""
    finite = curve[np.isfinite(curve)]
    z = np.concatenate((finite, [finite[0].real + 0.0j])) if len(finite) else np.array([0.0j, 1.0 + 1.0j])
    low, high = complex(z.real.min(), z.imag.min()), complex(z.real.max(), z.imag.max())
    span = complex(high.real - low.real or 1.0, high.imag - low.imag or 1.0)
    return Frame(
        low - 1j * ROOM * span.imag, complex(low.real + span.real, low.imag + (1 + ROOM) * span.imag), WIDEST, PANEL
    )


def _hodograph(shaking: ComplexArray) -> Picture:
    """Return the path of the force on the frame, its first value marked."""
    frame = Frame.around(np.concatenate((shaking, [0.0j])))
    picture = Picture("", frame, ("shaking force x [N]", "shaking force y [N]"))
    picture.stroke(AXIS, [complex(frame.low.real, 0.0), complex(frame.high.real, 0.0)])
    picture.stroke(AXIS, [complex(0.0, frame.low.imag), complex(0.0, frame.high.imag)])
    picture.stroke(curve_pen(1), *drawn_runs(shaking, frame.point))
    good = shaking[np.isfinite(shaking)]
    picture.mark(DOT, *good[:1].tolist())
    picture.legend += [("force on the frame", curve_pen(1)), ("start", DOT)]
    return picture
