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
    def name(self) -> str:
        """The name: inline if the slider's pin moves on a line through the crank's pivot."""
        inline = abs(self.offset) <= EQUAL * (self.crank + self.rod)
        return "slider-crank, inline" if inline else "slider-crank, offset"

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
    def kind(self) -> str:
        """Which links make full turns."""
        if _excess(self.crank, self.frame + abs(self.offset)) >= 0.0:
            return "the crank and the sliding link make full turns (Whitworth)"
        if _excess(abs(self.frame - self.crank), abs(self.offset)) >= 0.0:
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
    frame = chain.links[FRAME] if mechanism.floating else "frame"
    ahead = loop.links[1] == first or loop.kinds != "RRRR"
    for own in (loop, loop.backwards) if ahead else (loop.backwards, loop):
        names = [frame if link == FRAME else chain.links[link] for link in own.links]
        if own.kinds in TYPES:
            return TYPES[own.kinds](mechanism, own, names, z)
        if own.kinds in SLIDERS:
            return LoopType(own, *SLIDERS[own.kinds], {})
    return LoopType(loop, f"loop {loop.kinds}", "", {})


def _four_bar(mechanism: Mechanism, loop: LinkLoop, names: list[str], z: ComplexArray) -> LoopType:
    frame, first, coupler, second = lengths = _lengths(mechanism, loop, z)
    a, b, c, d = (complex(z[joint.node]) for joint in loop.joints)
    found = FourBar((frame, first, coupler, second), crossed=cross(d, a, b, c))
    return LoopType(loop, "four-bar linkage", found.kind, dict(zip(names, lengths, strict=True)), found)


def _slider_crank(mechanism: Mechanism, loop: LinkLoop, names: list[str], z: ComplexArray) -> LoopType:
    _, crank, rod, _ = _lengths(mechanism, loop, z)
    found = SliderCrank(crank, rod, _offset(mechanism, loop, loop.joints[3], z))
    return LoopType(loop, found.name, found.kind, {names[1]: crank, names[2]: rod, "offset": found.offset})


def _inverted(mechanism: Mechanism, loop: LinkLoop, names: list[str], z: ComplexArray) -> LoopType:
    frame, crank, _, _ = _lengths(mechanism, loop, z)
    found = InvertedSliderCrank(frame, crank, _offset(mechanism, loop, loop.joints[2], z))
    sizes = {names[0]: frame, names[1]: crank, "offset": found.offset}
    # the stroke of a linear actuator, not its dimensions, limits the motion
    kind = found.kind if loop.joints[2].slides else "a linear actuator swings the crank"
    return LoopType(loop, "inverted slider-crank", kind, sizes)


TYPES = {"RRRR": _four_bar, "RRRP": _slider_crank, "RRPR": _inverted}
"""Types that depend on dimensions, by the kinds of the joints."""


def _lengths(mechanism: Mechanism, loop: LinkLoop, z: ComplexArray) -> list[float]:
    """Return the distance of the nodes of each link's two joints: of a member its own, else at the position."""
    lengths = []
    for link, first, second in zip(loop.links, (loop.joints[-1], *loop.joints), loop.joints, strict=False):
        a, b = first.node, second.node
        own = link < len(mechanism.members) and {a, b} <= set(mechanism.members[link].nodes)
        lengths.append(abs(mechanism.members[link].reach(a, b)) if own else float(abs(z[b] - z[a])))
    return lengths


def cross(d: complex, a: complex, b: complex, c: complex) -> bool:
    """Return whether the two links on the frame d-a cross: a-b and c-d have their ends on different sides."""

    def side(p: complex, q: complex, r: complex) -> float:
        return ((q - p).conjugate() * (r - p)).imag

    links = side(a, b, c) * side(a, b, d) < 0.0 and side(d, c, a) * side(d, c, b) < 0.0
    bars = side(d, a, b) * side(d, a, c) < 0.0 and side(b, c, d) * side(b, c, a) < 0.0
    return links or bars


def _offset(mechanism: Mechanism, loop: LinkLoop, pair: Joint, z: ComplexArray) -> float:
    """Return the distance of the revolute joints beside a prismatic pair across its direction."""
    if pair.slides:
        row = mechanism.slides[pair.slides[0]]
        along = complex(row.along * pose(mechanism, row.guide, z[:, None])[1][0])
    else:
        run = complex(z[pair.nodes[1]] - z[pair.node])
        along = run / abs(run)
    place = loop.joints.index(pair)
    before, after = loop.joints[place - 1].node, loop.joints[(place + 1) % len(loop.joints)].node
    return abs((along.conjugate() * complex(z[after] - z[before])).imag)
