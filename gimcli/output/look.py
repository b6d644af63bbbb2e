"""The look of pictures: matplotlib settings, our own ones and those of a style file or a named style."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from gimcli.errors import UsageError
from gimcli.nearest import guess
from gimcli.output.picture import Content, Picture, Style, changed
from gimcli.output.style import FONT, INK, PALETTE, PAPER, TINT, Pen, tint

IGNORED = (
    "backend", "backend_fallback", "figure.autolayout", "figure.constrained_layout.use", "interactive", "savefig.bbox",
    "text.usetex", "toolbar",
)  # fmt: skip
"""Settings of a style that have no effect: names are written as they are, not as TeX; axes are placed by `sizes`."""

WIDTH = 1.5
"""The `lines.linewidth` of matplotlib for which curves have our usual widths [pt]."""


@dataclass(frozen=True)
class Look:
    """Settings of matplotlib (rcParams) that replace ours."""

    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def font(self) -> float:
        """Size of the texts, relative to the usual one."""
        return float(self.settings.get("font.size", FONT)) / FONT

    @property
    def size(self) -> tuple[float, float] | None:
        """Size of the whole picture [in], if the style has one."""
        found = self.settings.get("figure.figsize")
        return None if found is None else (float(found[0]), float(found[1]))

    @property
    def dpi(self) -> float | None:
        """Resolution, if the style has one."""
        found = self.settings.get("savefig.dpi")
        return float(found) if isinstance(found, int | float) else None


PLAIN = Look()


def read_look(style: str) -> Look:
    """Return the look of a matplotlib style file, or of a style that matplotlib knows by name.

    Raises:
        UsageError: there is no such file or style, or the file has errors.
    """
    import matplotlib
    import matplotlib.style

    library = matplotlib.style.library
    if style in library:
        return Look(_used(library[style]))
    path = Path(style)
    if not path.is_file():
        styles = sorted(name for name in library if not name.startswith("_"))
        raise UsageError(f"style: no file or matplotlib style '{style}'; {guess(style, styles, 'styles')}")
    errors: list[int] = []
    try:
        with _collected(errors):
            found = matplotlib.rc_params_from_file(str(path), use_default_template=False)
    except (OSError, UnicodeDecodeError):
        raise UsageError(f"style: {style} cannot be read; name a text file") from None
    if errors:
        raise UsageError(f"style: {style} has a name or a value in line {errors[0]} that matplotlib does not know")
    return Look(_used(found))


def _used(found: Any) -> dict[str, Any]:
    return {name: value for name, value in found.items() if name not in IGNORED}


@contextmanager
def _collected(lines: list[int]) -> Iterator[None]:
    """Append the lines of matplotlib's warnings about a style file to a list, in place of printing them."""

    class Collect(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            own = record.args.values() if isinstance(record.args, Mapping) else record.args or ()
            lines.append(next((one for one in own if isinstance(one, int)), 1))

    logger, handler = logging.getLogger("matplotlib"), Collect()
    logger.addHandler(handler)
    before, logger.propagate = logger.propagate, False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = before


def settings_of(look: Look) -> Any:
    """Return our settings of matplotlib, replaced by those of a look."""
    size = look.font * FONT
    return {
        "svg.hashsalt": "gim", "font.size": size, "axes.labelsize": size * (FONT + 1) / FONT, "axes.titlesize": size,
        "figure.titlesize": size * (FONT + 2) / FONT, "legend.fontsize": size,
        "text.color": INK, "figure.facecolor": PAPER, "axes.facecolor": PAPER, "axes.linewidth": 0.6,
        **{
            f"{axis}tick.{name}": value
            for axis, far in (("x", "top"), ("y", "right"))
            for name, value in {
                "labelsize": size, "direction": "in", far: True, "major.width": 0.6, "major.size": 3.0,
                "minor.width": 0.4, "minor.size": 1.8,
            }.items()
        },
        **look.settings,
    }  # fmt: skip


def dressed(content: Content, look: Look) -> Content:
    """Return a content in the colours of a look.

    Curves take the colours of `axes.prop_cycle` and widths in proportion to `lines.linewidth`. Greys are mixed from
    `text.color`, in place of black, and `axes.facecolor`, in place of white.
    """
    return changed(content, _Paint(look).picture) if look.settings else content


class _Paint:
    """Replaces colours and widths."""

    def __init__(self, look: Look) -> None:
        from matplotlib.colors import to_hex, to_rgb

        settings = look.settings
        cycle = settings["axes.prop_cycle"].by_key().get("color", []) if "axes.prop_cycle" in settings else []
        self.curves = {own: to_hex(cycle[k % len(cycle)]) for k, own in enumerate(PALETTE)} if cycle else {}
        self.tints = {tint(own): own for own in PALETTE}
        self.ink = to_rgb(settings.get("text.color", INK))
        self.paper = to_rgb(settings.get("axes.facecolor", PAPER))
        self.width = float(settings.get("lines.linewidth", WIDTH)) / WIDTH
        self._hex, self._rgb = to_hex, to_rgb

    def color(self, color: str) -> str:
        """Return the colour that replaces one of ours."""
        if color in self.curves or color == "none":
            return self.curves.get(color, color)
        if color in self.tints:
            own, paper = self._rgb(self.color(self.tints[color])), self.paper
            light: Any = [b + TINT * (a - b) for a, b in zip(own, paper, strict=True)]
            return str(self._hex(tuple(light)))
        red, green, blue = self._rgb(color)
        if not red == green == blue:
            return color
        dark, light = self._rgb(INK)[0], self._rgb(PAPER)[0]
        part = (red - dark) / (light - dark)
        mixed: Any = [min(1.0, max(0.0, a + part * (b - a))) for a, b in zip(self.ink, self.paper, strict=True)]
        return str(self._hex(tuple(mixed)))

    def style(self, style: Any) -> Any:
        """Return the style of a line, an area or a mark, or a key of the legend, with other colours and widths."""
        if isinstance(style, tuple):
            return tuple(map(self.style, style))
        if isinstance(style, Pen):
            width = style.width * self.width if style.color in PALETTE else style.width
            return replace(style, color=self.color(style.color), width=width)
        return replace(style, face=self.color(style.face), edge=self.color(style.edge))

    def picture(self, picture: Picture) -> Picture:
        """Return a picture with other colours and widths."""
        things: dict[Style, list[tuple[str, Any]]] = {}
        for style, own in picture.things.items():
            things.setdefault(self.style(style), []).extend(own)
        return replace(
            picture,
            things=things,
            texts=[replace(text, color=self.color(text.color)) for text in picture.texts],
            legend=[(name, self.style(key)) for name, key in picture.legend],
        )
