"""The picture of inverse dynamics: graphs of the efforts over the input, and the hodograph of the shaking force."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gimcli.mechanism import ComplexArray
from gimcli.output.curves import drawn_runs
from gimcli.output.panels import panel
from gimcli.output.picture import LAYOUT, WIDEST, Frame, Picture, PictureLayout, Sheet, composition
from gimcli.output.style import DOT, SOFT, Pen, curve_pen
from gimcli.table import Table

AXIS = Pen(0.8, SOFT, layer=2)


def forces_sheet(efforts: Mapping[str, Table], shaking: ComplexArray, title: str) -> Sheet:
    """Return a panel for each table of efforts, and the hodograph of the shaking force."""
    panels = [panel(name, table, WIDEST, peaks=True) for name, table in efforts.items()]
    return Sheet(title, (*panels, _hodograph(shaking)))


@composition
def _hodograph(shaking: ComplexArray, *, layout: PictureLayout = LAYOUT) -> Picture:
    """Return the curve of the tip of the force on the frame, with a mark at its start."""
    frame = Frame.around(np.concatenate((shaking, [0.0j])), layout)
    picture = Picture("", frame, ("shaking force x [N]", "shaking force y [N]"))
    picture.stroke(AXIS, [complex(frame.low.real, 0.0), complex(frame.high.real, 0.0)])
    picture.stroke(AXIS, [complex(0.0, frame.low.imag), complex(0.0, frame.high.imag)])
    picture.stroke(curve_pen(1), *drawn_runs(shaking, frame.point))
    good = shaking[np.isfinite(shaking)]
    picture.mark(DOT, *good[:1].tolist())
    picture.legend += [("shaking force", curve_pen(1)), ("start", DOT)]
    return picture
