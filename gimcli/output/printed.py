"""How a picture is printed: its size on paper, resolution, title, number of light poses, and look."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any, cast

from gimcli.errors import UsageError
from gimcli.output.axes import borders, title_height, whole_height
from gimcli.output.gallery import panel_size
from gimcli.output.look import PLAIN, Look, dressed, read_look
from gimcli.output.picture import GHOSTS, LAYOUT, Content, PictureLayout, Sheet, changed

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
        content = recomposed(content, replace(layout, width=width, height=height, fills=True))
        return content
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
