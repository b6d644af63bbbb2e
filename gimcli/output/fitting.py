"""Fit pictures into a size on paper: the axes take the space that titles, legends and borders leave."""

from __future__ import annotations

from dataclasses import replace

from gimcli.errors import UsageError
from gimcli.output.gallery import panel_size
from gimcli.output.picture import Content, Gallery, Picture, PictureLayout, Sheet
from gimcli.output.sizes import borders, title_height, whole_height

LEAST = 0.4
"""Smallest side of the axes [in]."""


def recomposed(content: Content, layout: PictureLayout) -> Content:
    """Return a content that is composed again in a layout; its titles are kept."""
    if isinstance(content, Sheet):
        return replace(content, pictures=tuple(_again(one, layout) for one in content.pictures))
    if isinstance(content, Gallery):
        return content if content.again is None else replace(content.again(layout), title=content.title)
    return _again(content, layout)


def fitted(content: Content, size: tuple[float, float], layout: PictureLayout) -> Content:
    """Return a content that fills a size (width, height) [in]; raise UsageError if that is too small."""
    if isinstance(content, Gallery):
        width, height = _enough(*panel_size(content, size, layout.font), size)
        return recomposed(content, replace(layout, width=width, height=height, fills=True))
    pictures = content.pictures if isinstance(content, Sheet) else (content,)
    left, right = borders(layout.font)
    width = size[0] - left - right
    around = sum(whole_height(one, size[0]) - one.frame.height for one in pictures)
    heading = title_height(content.title, size[0], layout.font) if isinstance(content, Sheet) else 0.0
    spare = size[1] - around - heading
    _enough(width, spare / len(pictures), size)
    over = [max(one.frame.height - LEAST, 1e-9) for one in pictures]
    part = (spare - len(pictures) * LEAST) / sum(over)
    filled = tuple(
        _again(one, replace(layout, width=width, height=LEAST + part * own, fills=True))
        for one, own in zip(pictures, over, strict=True)
    )
    return replace(content, pictures=filled) if isinstance(content, Sheet) else filled[0]


def _enough(width: float, height: float, size: tuple[float, float]) -> tuple[float, float]:
    """Return the size of axes; raise UsageError if it is too small."""
    if min(width, height) < LEAST:
        wide, high = (25.4 * side for side in size)
        raise UsageError(
            f"size: {wide:.0f}x{high:.0f}mm leaves no space for the axes beside titles, legends and numbers;"
            " use a larger size"
        )
    return width, height


def _again(picture: Picture, layout: PictureLayout) -> Picture:
    """Return a picture in a layout; a graph only gets another frame."""
    if picture.again is not None:
        return replace(picture.again(layout), title=picture.title)
    width, height = (layout.width, layout.height) if layout.fills else (picture.frame.width, picture.frame.height)
    return replace(picture, frame=replace(picture.frame, width=width, height=height, font=layout.font))
