"""The picture of singular positions, with the curves of the traced points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.picture import LAYOUT, Picture, PictureLayout, composition
from gimcli.output.pose import Drawing, Shown, solved
from gimcli.output.style import INK, PALETTE, Mark

MARKS = {
    "change point": Mark("s", 7.0, width=1.4, layer=9),
    "tangency": Mark("D", 6.0, layer=9),
    "limit": Mark("^", 7.0, face=INK, layer=9),
    "dead point": Mark("X", 7.0, face=INK, width=0.4, layer=9),
    "stationary": Mark("o", 5.0, layer=9),
}
"""The mark of each kind of singular position."""


@composition
def singular_picture(
    mechanism: Mechanism, shown: Sequence[Shown], curves: Mapping[str, ComplexArray], title: str, *,
    layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return the first position strong, some others light, in the order of the kinds in `MARKS`, and numbered marks."""
    order = list(MARKS)
    chosen = sorted(shown, key=lambda one: order.index(one.kind))[: layout.ghosts + 1]
    scene = solved(mechanism, np.array([one.pose for one in chosen])) if chosen else None
    drawing = Drawing.around(mechanism, scene, title, curves.values(), layout)
    drawing.poses(range(1, len(chosen)), layout.members)
    drawing.curves(curves)
    drawing.numbered(shown, MARKS, PALETTE[0])
    return drawing.write(sorted(scene.used) if scene else (), {})
