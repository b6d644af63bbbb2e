"""Fit pictures into a size on paper: the axes take the space that titles, legends and borders leave."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

from gimcli.errors import UsageError
from gimcli.output.gallery import panel_size
from gimcli.output.picture import Content, PictureLayout, Sheet
from gimcli.output.sizes import borders, title_height, whole_height

LEAST = 0.4
"""Smallest side of the axes [in]."""


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
    over = [max(one.frame.height - LEAST, 1e-9) for one in content.pictures]
    part = (spare - len(content.pictures) * LEAST) / sum(over)
    filled = tuple(
        recomposed(one, replace(layout, width=width, height=LEAST + part * own, fills=True))
        for one, own in zip(content.pictures, over, strict=True)
    )
    return replace(content, pictures=filled) if isinstance(content, Sheet) else cast(Content, filled[0])


def _enough(width: float, height: float, size: tuple[float, float]) -> tuple[float, float]:
    """Return the size of axes; raise UsageError if it is too small."""
    if min(width, height) < LEAST:
        wide, high = (25.4 * side for side in size)
        raise UsageError(
            f"size: {wide:.0f}x{high:.0f}mm leaves no space for the axes beside titles, legends and numbers;"
            " use a larger size"
        )
    return width, height
