"""How a picture is printed: its size on paper, resolution, title, number of light poses, and look.

The look is matplotlib settings: our own ones and those of a style file or a named style.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from gimcli.errors import UsageError
from gimcli.nearest import guess
from gimcli.output.axes import borders, title_height, whole_height
from gimcli.output.gallery import panel_size
from gimcli.output.picture import GHOSTS, LAYOUT, Content, Picture, PictureLayout, Sheet, Style, changed
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

    def collect(record: logging.LogRecord) -> bool:
        own = record.args.values() if isinstance(record.args, Mapping) else record.args or ()
        lines.append(next((one for one in own if isinstance(one, int)), 1))
        return False

    logger = logging.getLogger("matplotlib")
    logger.addFilter(collect)
    try:
        yield
    finally:
        logger.removeFilter(collect)


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


UNITS = {"mm": 1 / 25.4, "cm": 1 / 2.54, "in": 1.0}
"""Units of the size [in]."""

LEAST, GREATEST = 1.0, 60.0
"""Smallest and largest side of a picture [in]."""

COARSEST, FINEST = 20, 2400
"""Lowest and highest resolution [dpi]."""

PIXELS = 30_000
"""Largest number of pixels along a side."""


NARROWEST = 0.4
"""Smallest side of the axes [in]."""


@dataclass(frozen=True)
class Printed:
    """A picture with its size on paper, resolution and look; None is the usual size or resolution."""

    content: Content
    size: tuple[float, float] | None = None  # width and height [in]
    dpi: float | None = None
    look: Look = PLAIN
    grouped: bool = False  # members, pairs, curves ... are groups with names


@dataclass(frozen=True)
class PictureOptions:
    """The options of pictures; the defaults leave a picture as it is."""

    size: tuple[float, float] | None = None  # width and height [in]
    dpi: int | None = None
    title: str | None = None  # "" for none
    ghosts: int = GHOSTS
    members: tuple[str, ...] = ()  # that light poses show; () for all
    look: Look = PLAIN

    @classmethod
    def checked(
        cls, size: str | None = None, dpi: int | None = None, title: str | None = None,
        ghosts: int | str | None = None, style: str | None = None,
    ) -> PictureOptions:  # fmt: skip
        """Return the options; None is the default of each.

        Args:
            size: width and height of the whole picture, such as "160x90mm"; units are mm, cm and in.
            dpi: dots per inch, 20 to 2400.
            title: text above the picture; "" for no title.
            ghosts: largest number of light poses, or "none"; "4:coupler,rocker" shows only these members in them.
            style: a matplotlib style file, or the name of one of matplotlib's styles.

        Raises:
            UsageError: an invalid option.
        """
        look = PLAIN if style is None else read_look(style)
        found = cls(_size(size) or look.size, _dpi(dpi), title, *_ghosts(ghosts), look)
        if found.size and found.dpi and max(found.size) * found.dpi > PIXELS:
            raise UsageError(f"dpi: {size} with {dpi} dpi is more than {PIXELS} pixels wide or high")
        return found

    def printed(self, content: Content) -> Printed:
        """Return a picture as it is printed with these options."""
        if self.title is not None:
            content = _titled(content, self.title)
        layout = replace(LAYOUT, font=self.look.font, ghosts=self.ghosts, members=self.members)
        content = recomposed(content, layout) if layout != LAYOUT else content
        content = fitted(content, self.size, layout) if self.size else content
        return Printed(dressed(content, self.look), self.size, self.dpi or self.look.dpi, self.look)

    def animated(self, animation: Any) -> Any:
        """Return an Animation with these options."""
        return replace(animation, title=animation.title if self.title is None else self.title, options=self)


def recomposed(content: Any, layout: PictureLayout) -> Any:
    """Return a content that is composed again in a layout; its titles are kept, and a graph only gets another frame."""
    if content.again is not None:
        return replace(content.again(layout), title=content.title)
    if isinstance(content, Sheet):
        return replace(content, pictures=tuple(recomposed(one, layout) for one in content.pictures))
    frame = content.frame
    width, height = (layout.width, layout.height) if layout.fills else (frame.width, frame.height)
    return replace(content, frame=replace(frame, width=width, height=height, font=layout.font))


def fitted(content: Content, size: tuple[float, float], layout: PictureLayout) -> Content:
    """Return a content that fills a size (width, height) [in]; raise UsageError if that is too small."""
    if isinstance(content, Sheet) and content.columns:
        width, height = _enough(*panel_size(content, size, layout.font), size)
        return cast(Content, recomposed(content, replace(layout, width=width, height=height, fills=True)))
    left, right = borders(layout.font)
    width = size[0] - left - right
    around = sum(whole_height(one, size[0]) - one.frame.height for one in content.pictures)
    heading = title_height(content.title, size[0], layout.font) if isinstance(content, Sheet) else 0.0
    spare = size[1] - around - heading
    _enough(width, spare / len(content.pictures), size)
    over = [max(one.frame.height - NARROWEST, 1e-9) for one in content.pictures]
    part = (spare - len(content.pictures) * NARROWEST) / sum(over)
    filled = tuple(
        recomposed(one, replace(layout, width=width, height=NARROWEST + part * own, fills=True))
        for one, own in zip(content.pictures, over, strict=True)
    )
    return replace(content, pictures=filled) if isinstance(content, Sheet) else cast(Content, filled[0])


def _enough(width: float, height: float, size: tuple[float, float]) -> tuple[float, float]:
    """Return the size of axes; raise UsageError if it is too small."""
    if min(width, height) < NARROWEST:
        wide, high = (25.4 * side for side in size)
        raise UsageError(
            f"size: {wide:.0f}x{high:.0f}mm leaves no space for the axes beside titles, legends and numbers;"
            " use a larger size"
        )
    return width, height


def _titled(content: Content, title: str) -> Content:
    """Return a content with another title; below the title of pictures one above the other, these have none."""
    above = isinstance(content, Sheet) and not content.columns
    return replace(changed(content, lambda one: replace(one, title="")) if above else content, title=title)


def _size(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    found = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*[x×]\s*(\d+\.?\d*|\.\d+)\s*(mm|cm|in)\s*", str(text))
    if not found:
        raise UsageError(f"size: expected width x height with a unit (mm, cm, in), such as 160x90mm, got '{text}'")
    width, height = (float(found[k]) * UNITS[found[3]] for k in (1, 2))
    if min(width, height) < LEAST or max(width, height) > GREATEST:
        raise UsageError(f"size: expected sides from {LEAST:g} to {GREATEST:g} in, got '{text}'")
    return width, height


def _dpi(dpi: int | None) -> int | None:
    if dpi is not None and not COARSEST <= dpi <= FINEST:
        raise UsageError(f"dpi: expected a number from {COARSEST} to {FINEST}, got {dpi}")
    return dpi


def _ghosts(given: int | str | None) -> tuple[int, tuple[str, ...]]:
    """Return the number of light poses, and the names of their members, () for all."""
    count, _, names = str(GHOSTS if given is None else given).partition(":")
    if count == "none":
        return 0, ()
    if not re.fullmatch(r"\d{1,4}", count):
        raise UsageError(f"ghosts: expected a number of poses, such as 3 or 3:coupler,rocker, or none, got '{given}'")
    return int(count), tuple(name.strip() for name in names.split(",") if name.strip())
