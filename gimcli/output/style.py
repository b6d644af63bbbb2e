"""Styles of the drawings: line widths [pt], colours, dashes and the order of layers.

Lines and marks with different meanings differ in width, dash or shape, not only in colour, so that they can be
distinguished in a grey print.
"""

from __future__ import annotations

from dataclasses import dataclass

INK = "#1a1a1a"
SOFT = "#b4b4b4"
PALE = "#c4c4c4"
PAPER = "white"

FONT = 8.0
"""Size of ordinary text [pt]."""

DPI = 150
"""Lowest resolution of a picture."""

PIXELS = 1000
"""Least width of a picture [pixels]: narrow pictures have a higher resolution."""

LEFT, RIGHT, BOTTOM, TOP = 0.85, 0.3, 0.5, 0.2
"""Borders around the axes [in]."""

LINE = 0.19
"""Height of a line of the title or of the legend [in]."""

LETTER = 0.0087
"""Width of a letter [in] per point of its size."""


@dataclass(frozen=True)
class Pen:
    """The style of a line."""

    width: float  # pt
    color: str = INK
    dash: tuple[float, ...] = ()  # on, off, ... in line widths; () is a full line
    layer: float = 4


@dataclass(frozen=True)
class Fill:
    """The style of an area."""

    face: str = PAPER
    edge: str = INK
    width: float = 1.0  # pt
    layer: float = 5.0


@dataclass(frozen=True)
class Mark:
    """The style of a single point."""

    shape: str = "o"
    size: float = 6.0  # pt
    face: str = PAPER
    edge: str = INK
    width: float = 1.1  # pt
    layer: int = 8


LINK = Pen(2.2)
BEAM = Pen(3.4)  # an element whose nodes lie on one line
UPPER = Pen(2.2, layer=7)  # a link that is pinned on top of a block
LEADER = Pen(0.5, "#595959", layer=7)
ROD = Pen(1.8, layer=5)
THIN = Pen(0.8, layer=5)
GROUND = Pen(1.2, layer=5)
HATCH = Pen(0.7, layer=5)
ARROW = Pen(1.1, layer=7)
GHOST = Pen(0.7, PALE, layer=2)

PLATE = Fill("#e4e4e4", INK, 1.4, layer=3)
SWEPT = Fill("#ededed", "#ededed", 0.3, layer=1)
SUPPORT = Fill(PAPER, INK, 1.0, layer=5)
BLOCK = Fill(PAPER, INK, 1.3, layer=6)
CYLINDER = Fill("#cccccc", INK, 1.2, layer=6)
HEAD = Fill(INK, INK, 0.3, layer=7)

PITCH = Pen(0.9, dash=(9.0, 2.5, 1.5, 2.5), layer=3.5)
RIM = Pen(1.4, layer=3.5)
BELT = Pen(1.5, layer=3.5)
TICK = Pen(1.1, layer=3.5)  # of a gear

LIGHT: dict[Pen | Fill, Pen | Fill] = {
    LINK: GHOST, BEAM: GHOST, UPPER: GHOST, ROD: GHOST,
    PLATE: Fill("#f5f5f5", PALE, 0.7, layer=1.5), BLOCK: Fill(PAPER, PALE, 0.7, layer=2.5),
    PITCH: Pen(0.6, PALE, PITCH.dash, layer=2), BELT: Pen(0.7, PALE, layer=2),
}  # fmt: skip
"""The styles of light poses; other strokes are not drawn in them."""

SPRING = Pen(1.0, layer=5)
LOAD = Pen(1.6, "#7a3b00", layer=9)
LOAD_HEAD = Fill("#7a3b00", "#7a3b00", 0.3, layer=9)
CENTRE = Fill(PAPER, INK, 0.7, layer=9)
CENTRE_FILL = Fill(INK, INK, 0.3, layer=9.1)

PIN = Mark()
GHOST_PIN = Mark(size=3.0, face=PAPER, edge=PALE, width=0.7, layer=3)
DOT = Mark(size=3.2, face=INK, width=0.5)
CROSS = Mark("x", 5.0, width=1.0)
TRACER = Mark("D", 4.6, face=INK, width=0.5, layer=9)

VERTICAL = Pen(0.9, INK, (4.0, 2.5), layer=2)
CUT = Mark("^", 3.6, face=INK, width=0.5, layer=9)
_EVENTS = (Mark("o", 4.0, width=0.9), Mark("s", 4.0, face=INK, width=0.5), Mark("D", 4.0, width=0.9), CROSS)

PALETTE = ("#a50f15", "#3577bd", "#0b4f2c", "#d9822b", "#54278f", "#2f9c95")
"""Colours of curves; neighbours have different lightness, for prints in grey."""

LONGEST_VECTOR = 0.3
"""Length of the longest arrow of a velocity, relative to the longer side of the drawing."""

TARGET = Mark("+", 8.0, PALETTE[1], PALETTE[1], 1.6, layer=10)
"""A point that a fit has to pass."""

_DASHES: tuple[tuple[float, ...], ...] = (
    (), (5.0, 2.0), (1.2, 1.5), (7.0, 1.8, 1.2, 1.8), (12.0, 3.0), (3.0, 1.2, 1.2, 1.2, 1.2, 1.2),
)  # fmt: skip
_WEIGHTS = (1.4, 2.6, 0.8)


TINT = 0.16
"""Part of a colour in its tint."""


def tint(colour: str) -> str:
    """Return a light tint of a colour ("#rrggbb")."""
    parts = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(255 - TINT * (255 - part)):02x}" for part in parts)


def group_colour(number: int) -> str:
    """Return the colour of a group of links by its number, from 1."""
    return PALETTE[(number - 1) % len(PALETTE)]


def curve_pen(index: int) -> Pen:
    """Return the pen of the index-th curve; colour, dash and width change together."""
    around, number = divmod(index, len(_DASHES))
    colour = PALETTE[(number + 3 * around) % len(PALETTE)]
    return Pen(_WEIGHTS[around % len(_WEIGHTS)], colour, _DASHES[number], layer=7)


def event_mark(index: int) -> Mark:
    """Return the mark of the index-th kind of event."""
    return _EVENTS[index % len(_EVENTS)]
