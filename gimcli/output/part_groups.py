"""Groups of the parts of a drawing in SVG files: one for each member, pair, curve ..., with its name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

LETTER = (
    "-.0-9:A-Z_a-z\u00b7\u00c0-\u00d6\u00d8-\u00f6\u00f8-\u037d\u037f-\u1fff\u200c\u200d\u203f\u2040\u2070-\u218f"
    "\u2c00-\u2fef\u3001-\ud7ff\uf900-\ufdcf\ufdf0-\ufffd\U00010000-\U000effff"
)
"""Characters of a name in XML. Source: W3C, Extensible Markup Language 1.0, fifth edition, production 4a."""


class PartNames:
    """The identifiers of one file: each is used once."""

    def __init__(self) -> None:
        self._used: set[str] = set()

    def of(self, part: str) -> str:
        """Return the identifier of a part such as "member:crank".

        Other characters than those of a name in XML become their number, such as "_x0020_" for a space. A part that
        comes again, such as that of another panel, gets a number.
        """
        stem = own = re.sub(f"[^{LETTER}]", lambda found: f"_x{ord(found[0]):04X}_", part)
        number = 1
        while own in self._used:
            number += 1
            own = f"{stem}-{number}"
        self._used.add(own)
        return own


def add_group(axes: Any, name: str, layer: float, artists: Sequence[Any]) -> None:
    """Add matplotlib artists to axes as one group of an SVG file."""
    from matplotlib.artist import Artist

    class PartGroup(Artist):
        def draw(self, renderer: Any) -> None:
            renderer.open_group("part", gid=self.get_gid())
            for artist in sorted(artists, key=lambda one: float(one.get_zorder())):
                artist.draw(renderer)
            renderer.close_group("part")

    for artist in artists:
        artist.set_figure(axes.figure)
        artist.axes = axes
        if not artist.is_transform_set():
            artist.set_transform(axes.transData)
        artist.set_clip_path(axes.patch)
    group = PartGroup()
    group.set_gid(name)
    group.set_zorder(layer)
    axes.add_artist(group)
