"""A picture independent of file formats: lines, areas, marks and texts in data coordinates."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np

from gimcli.mechanism import ComplexArray
from gimcli.output.style import FONT, INK, Fill, Mark, Pen

MARGIN = 0.5
"""Free border inside the axes, for symbols and names [in]."""

WIDEST, HIGHEST, LEAST = 5.9, 5.4, 2.7
"""Largest width, largest height and smallest side of the axes [in]."""


GHOSTS = 3
"""Number of light poses beside the first one."""

Style = Pen | Fill | Mark
Key = Pen | Mark | tuple[Pen, Mark]
"""The line or mark beside a name in the legend."""


@dataclass(frozen=True)
class PictureLayout:
    """What the composition of a picture depends on, besides its content: symbols and texts keep their size [pt]."""

    width: float = WIDEST  # largest width of the axes [in]
    height: float = HIGHEST  # largest height of the axes [in]
    fills: bool = False  # the axes have exactly this size; otherwise they are as small as the content allows
    font: float = 1.0  # size of the texts, relative to the usual one
    ghosts: int = GHOSTS  # largest number of light poses
    members: tuple[str, ...] = ()  # names of the members that light poses show; () for all


LAYOUT = PictureLayout()


@dataclass(frozen=True)
class Frame:
    """The window of the axes: data limits and the size on paper."""

    low: complex  # lower left corner, data
    high: complex  # upper right corner, data
    width: float  # in
    height: float  # in
    font: float = 1.0  # size of the texts, relative to the usual one

    @classmethod
    def around(
        cls, points: ComplexArray, layout: PictureLayout = LAYOUT, border: float = MARGIN,
        least: tuple[float, float] = (LEAST, LEAST),
    ) -> Frame:  # fmt: skip
        """Return the window with equal axes around some points, those that are not finite are ignored.

        `border` is free inside it, `least` its smallest width and height [in].
        """
        finite = points[np.isfinite(points)]
        z = finite if len(finite) else np.array([0.0, 1.0 + 1.0j])
        low, high = complex(z.real.min(), z.imag.min()), complex(z.real.max(), z.imag.max())
        span = high - low
        margin = min(border, 0.2 * min(layout.width, layout.height))
        per_inch = max(span.real / (layout.width - 2 * margin), span.imag / (layout.height - 2 * margin))
        if per_inch <= 1e-12 * max(abs(low), abs(high)) or per_inch == 0.0:
            per_inch = max(abs(low), 1.0) / layout.width
        width, height = layout.width, layout.height
        if not layout.fills:
            width = max(span.real / per_inch + 2 * margin, least[0])
            height = max(span.imag / per_inch + 2 * margin, least[1])
        half = complex(width, height) * per_inch / 2
        centre = (low + high) / 2
        return cls(centre - half, centre + half, width, height, layout.font)

    @property
    def point(self) -> float:
        """Length of one typographic point in data units."""
        return (self.high.real - self.low.real) / (72.0 * self.width)


@dataclass(frozen=True)
class Text:
    """A text, centred at a place or beginning there."""

    at: complex
    text: str
    size: float = FONT
    color: str = INK
    ring: bool = False  # draw a circle around it, for numbers
    halo: bool = False  # draw a light edge around the letters, over lines
    begins: bool = False  # the place is the left end of the text


@dataclass
class Picture:
    """All parts of a drawing; the drawing functions add to the lists."""

    title: str
    frame: Frame
    labels: tuple[str, str] = ("x", "y")
    logarithmic: bool = False  # y are decimal logarithms
    logarithmic_x: bool = False  # x are decimal logarithms
    bare: bool = False  # no axes: a diagram
    things: dict[Style, list[tuple[str, Any]]] = field(default_factory=dict)  # in a style: part, and path or place
    texts: list[Text] = field(default_factory=list)
    legend: list[tuple[str, Key]] = field(default_factory=list)
    above: list[tuple[float, str]] = field(default_factory=list)  # words above the axes, at their abscissae
    again: Callable[[PictureLayout], Picture] | None = field(default=None, repr=False, compare=False)
    """Compose the picture in another layout; None for graphs, whose frame may have any size."""
    part: str = ""  # to which the next things belong, such as "member:crank"; "" for none

    @contextmanager
    def named(self, part: str) -> Iterator[None]:
        """Let all things that are drawn in the `with` block belong to a part."""
        before, self.part = self.part, part
        try:
            yield
        finally:
            self.part = before

    def draw(self, style: Style, *things: Any, key: str = "") -> None:
        """Add open polylines in the style of a pen, closed polygons in that of a fill, or marks at places.

        `key` is the name in the legend, if anything is added.
        """
        if things:
            own = ((self.part, complex(one) if isinstance(style, Mark) else _array(one)) for one in things)
            self.things.setdefault(style, []).extend(own)
            self.legend += [(key, cast(Key, style))] if key else []

    def draw_runs(self, pen: Pen, runs: Iterable[ComplexArray]) -> None:
        """Add the pieces of a curve; a piece of one point is a small mark."""
        every = list(runs)
        self.draw(pen, *(run for run in every if len(run) > 1))
        self.draw(Mark("o", 2.0, pen.color, pen.color), *(run[0] for run in every if len(run) == 1))

    @property
    def drawn(self) -> dict[Style, list[Any]]:
        """The paths or places in each style: of lines, then of areas, then of marks."""
        ordered = sorted(self.things.items(), key=lambda item: (Pen, Fill, Mark).index(type(item[0])))
        return {style: [thing for _, thing in own] for style, own in ordered}

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """The picture, as a sheet has several."""
        return (self,)

    def split(self) -> dict[str, Picture]:
        """Return the things of each part, those without a part as the part ""."""
        found: dict[str, Picture] = {}
        for style in self.drawn:
            for part, thing in self.things[style]:
                found.setdefault(part, Picture("", self.frame)).draw(style, thing)
        return found


@dataclass(frozen=True)
class Sheet:
    """Pictures one above the other under one title, or a gallery: panels with the same window in rows of `columns`."""

    title: str
    pictures: tuple[Picture, ...]
    columns: int = 0
    again: Callable[[PictureLayout], Sheet] | None = field(default=None, repr=False, compare=False)


Content = Picture | Sheet
"""The content of a picture file."""


def changed(content: Content, change: Callable[[Picture], Picture]) -> Content:
    """Return a content with each of its pictures changed."""
    if isinstance(content, Picture):
        return change(content)
    return replace(content, pictures=tuple(map(change, content.pictures)))


Arguments = ParamSpec("Arguments")
Composed = TypeVar("Composed", Picture, Sheet)


def composition(compose: Callable[Arguments, Composed]) -> Callable[Arguments, Composed]:
    """Keep with a picture how it is composed in another layout (decorator).

    `compose` has a keyword argument `layout`.
    """

    def composed(*given: Any, layout: PictureLayout = LAYOUT, **named: Any) -> Any:
        found = cast(Any, compose)(*given, layout=layout, **named)
        return replace(found, again=lambda other: composed(*given, layout=other, **named))

    return cast(Callable[Arguments, Composed], wraps(compose)(composed))


def rectangle(centre: complex, half: complex) -> list[complex]:
    """Return the corners of a rectangle of half a width and a height."""
    return [centre + complex(x * half.real, y * half.imag) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _array(path: ComplexArray | Iterable[complex]) -> ComplexArray:
    return np.asarray(path if isinstance(path, np.ndarray) else list(path), dtype=np.complex128)
