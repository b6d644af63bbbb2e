"""Types of loops of four links, by their pairs and their dimensions at a position.

Which links make full turns, in closed form:

Slider-crank: a crank of length a on the frame, a rod of length b, and a slider whose pin is at the height e over the
line of sliding through the crank's pivot. The height of the crank pin is between -a and a, and the rod reaches the line
e from it if the difference is at most b: the crank makes full turns if a + |e| <= b. The rod does if b + |e| <= a.

Inverted slider-crank: the frame is a link with two pins, of length d; the crank of length a carries a block that slides
along a link hinged to the frame, at the distance e from its pivot. The crank pin must stay outside the circle of radius
|e| about that pivot: the crank makes full turns if |d - a| >= |e|. The sliding link does if a >= d + |e|.

Source: elementary geometry; Norton, Design of Machinery, sections 2.13 (inversions) and 3.12 (quick return).
"""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.mechanism import FRAME, ComplexArray, Mechanism
from gimcli.structure.four_bars import FourBar
from gimcli.structure.joints import Joint
from gimcli.structure.kinematic_chain import KinematicChain, LinkLoop
from gimcli.structure.residual import pose

EQUAL = 1e-9
"""Lengths that differ by less than this part of their sum are equal."""


@dataclass(frozen=True)
class SliderCrank:
    """A slider-crank whose frame carries the slider."""

    crank: float
    rod: float
    offset: float

    @property
    def inline(self) -> bool:
        """Whether the slider's pin moves on a line through the crank's pivot."""
        return abs(self.offset) <= EQUAL * (self.crank + self.rod)

    @property
    def name(self) -> str:
        """The name with or without an offset."""
        return "slider-crank, inline" if self.inline else "slider-crank, offset"

    @property
    def excess(self) -> float:
        """Return b - a - |e|: positive if the crank makes full turns, 0 at a change point."""
        return _excess(self.rod, self.crank + abs(self.offset))

    @property
    def kind(self) -> str:
        """Which links make full turns."""
        if self.excess == 0.0:
            return "the crank makes full turns, with a change point"
        if self.excess > 0.0:
            return "the crank makes full turns"
        if _excess(self.crank, self.rod + abs(self.offset)) >= 0.0:
            return "the rod makes full turns, the crank swings"
        return "the crank and the rod swing"


@dataclass(frozen=True)
class InvertedSliderCrank:
    """A slider-crank whose frame is a link with two pins."""

    frame: float
    crank: float
    offset: float

    @property
    def crank_excess(self) -> float:
        """Return |d - a| - |e|: not negative if the crank makes full turns."""
        return _excess(abs(self.frame - self.crank), abs(self.offset))

    @property
    def guide_excess(self) -> float:
        """Return a - d - |e|: not negative if the sliding link makes full turns."""
        return _excess(self.crank, self.frame + abs(self.offset))

    @property
    def kind(self) -> str:
        """Which links make full turns."""
        if self.guide_excess >= 0.0:
            return "the crank and the sliding link make full turns (Whitworth)"
        if self.crank_excess >= 0.0:
            return "the crank makes full turns, the sliding link swings"
        return "the crank and the sliding link swing"


def _excess(large: float, small: float) -> float:
    return large - small if abs(large - small) > EQUAL * (large + small) else 0.0


SLIDERS = {
    "PRRP": ("double slider (elliptic trammel)", "the frame has both prismatic pairs"),
    "RRPP": ("Scotch yoke", "the crank makes full turns"),
    "RPPR": ("Oldham coupling", "the frame has both revolute pairs"),
    "RPRP": ("Rapson's slide", "revolute and prismatic pairs alternate"),
}
"""Loops with two prismatic pairs that no dimension distinguishes: name and property."""


@dataclass(frozen=True)
class LoopType:
    """The type of a loop of four links, the frame first, then the input link."""

    loop: LinkLoop
    name: str
    kind: str
    dimensions: dict[str, float]  # normal frame
    four_bar: FourBar | None = None


def loop_type(mechanism: Mechanism, chain: KinematicChain, loop: LinkLoop, z: ComplexArray, first: int) -> LoopType:
    """Return the type of a loop at a position z (nodes,); `first` is the input link, if it is next to the frame."""
    if loop.kinds == "RRRR":
        return _four_bar(mechanism, chain, loop if loop.links[1] == first else loop.backwards, z)
    if loop.kinds in ("RRRP", "PRRR"):
        return _slider_crank(mechanism, chain, loop if loop.kinds == "RRRP" else loop.backwards, z)
    if loop.kinds in ("RRPR", "RPRR"):
        return _inverted(mechanism, chain, loop if loop.kinds == "RRPR" else loop.backwards, z)
    for own in (loop, loop.backwards):
        if own.kinds in SLIDERS:
            name, kind = SLIDERS[own.kinds]
            return LoopType(own, name, kind, {})
    return LoopType(loop, f"loop {loop.kinds}", "", {})


def _four_bar(mechanism: Mechanism, chain: KinematicChain, loop: LinkLoop, z: ComplexArray) -> LoopType:
    a, b, c, d = (joint.node for joint in loop.joints)
    ends = (d, a), (a, b), (b, c), (c, d)
    frame, first, coupler, second = (_length(mechanism, link, *e, z) for link, e in zip(loop.links, ends, strict=True))
    lengths = frame, first, coupler, second
    found = FourBar(lengths, crossed=cross(*(complex(z[node]) for node in (d, a, b, c))))
    names = _names(mechanism, chain, loop)
    return LoopType(loop, "four-bar linkage", found.kind, dict(zip(names, lengths, strict=True)), found)


def _length(mechanism: Mechanism, link: int, a: int, b: int, z: ComplexArray) -> float:
    """Return the distance of two nodes of a link: of a member its own, which the position may not satisfy."""
    if link < len(mechanism.members) and {a, b} <= set(mechanism.members[link].nodes):
        return abs(mechanism.members[link].reach(a, b))
    return float(abs(z[b] - z[a]))


def cross(d: complex, a: complex, b: complex, c: complex) -> bool:
    """Return whether the two links on the frame d-a cross: a-b and c-d have their ends on different sides."""

    def side(p: complex, q: complex, r: complex) -> float:
        return ((q - p).conjugate() * (r - p)).imag

    links = side(a, b, c) * side(a, b, d) < 0.0 and side(d, c, a) * side(d, c, b) < 0.0
    bars = side(d, a, b) * side(d, a, c) < 0.0 and side(b, c, d) * side(b, c, a) < 0.0
    return links or bars


def _slider_crank(mechanism: Mechanism, chain: KinematicChain, loop: LinkLoop, z: ComplexArray) -> LoopType:
    pivot, pin, end = (joint.node for joint in loop.joints[:3])
    crank_length, rod_length = (
        _length(mechanism, link, *ends, z)
        for link, ends in zip(loop.links[1:3], ((pivot, pin), (pin, end)), strict=True)
    )
    offset = abs(_height(mechanism, loop.joints[3], complex(z[pivot]), complex(z[end]), z))
    found = SliderCrank(crank_length, rod_length, offset)
    crank, rod = _names(mechanism, chain, loop)[1:3]
    return LoopType(loop, found.name, found.kind, {crank: found.crank, rod: found.rod, "offset": found.offset})


def _inverted(mechanism: Mechanism, chain: KinematicChain, loop: LinkLoop, z: ComplexArray) -> LoopType:
    pivot, pin, hinge = (loop.joints[k].node for k in (0, 1, 3))
    offset = abs(_height(mechanism, loop.joints[2], complex(z[hinge]), complex(z[pin]), z))
    base, arm = (_length(mechanism, loop.links[k], pivot, end, z) for k, end in ((0, hinge), (1, pin)))
    found = InvertedSliderCrank(base, arm, offset)
    frame, crank = _names(mechanism, chain, loop)[:2]
    sizes = {frame: found.frame, crank: found.crank, "offset": found.offset}
    if not loop.joints[2].slides:  # its stroke, not its dimensions, limits the motion
        return LoopType(loop, "inverted slider-crank", "a linear actuator swings the crank", sizes)
    return LoopType(loop, "inverted slider-crank", found.kind, sizes)


def _height(mechanism: Mechanism, pair: Joint, a: complex, b: complex, z: ComplexArray) -> float:
    """Return the distance of b from the line through a along a prismatic pair."""
    if pair.slides:
        row = mechanism.slides[pair.slides[0]]
        along = complex(row.along * pose(mechanism, row.guide, z[:, None])[1][0])
    else:
        run = complex(z[pair.nodes[1]] - z[pair.node])
        along = run / abs(run)
    return (along.conjugate() * (b - a)).imag


def _names(mechanism: Mechanism, chain: KinematicChain, loop: LinkLoop) -> list[str]:
    """Return the names of the links of a loop; the frame's is "frame" unless it is a member of the file."""
    frame = chain.links[FRAME] if mechanism.floating else "frame"
    return [frame if link == FRAME else chain.links[link] for link in loop.links]
