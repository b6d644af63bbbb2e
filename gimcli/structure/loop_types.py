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
    """Return the type of a slider-crank whose frame carries the slider."""
    _, crank, rod, _ = _lengths(mechanism, loop, z)
    offset = _offset(mechanism, loop, loop.joints[3], z)
    name = "slider-crank, inline" if offset <= EQUAL * (crank + rod) else "slider-crank, offset"
    sizes = {names[1]: crank, names[2]: rod, "offset": offset}
    return LoopType(loop, name, turns_of_slider_crank(crank, rod, offset), sizes)


def turns_of_slider_crank(a: float, b: float, e: float) -> str:
    """Return which links of a slider-crank make full turns, for crank, rod and offset."""
    if (excess := _excess(b, a + e)) >= 0.0:
        return f"the crank makes full turns{'' if excess > 0.0 else ', with a change point'}"
    return "the rod makes full turns, the crank swings" if _excess(a, b + e) >= 0.0 else "the crank and the rod swing"


def _inverted(mechanism: Mechanism, loop: LinkLoop, names: list[str], z: ComplexArray) -> LoopType:
    """Return the type of a slider-crank whose frame is a link with two pins."""
    frame, crank, _, _ = _lengths(mechanism, loop, z)
    offset = _offset(mechanism, loop, loop.joints[2], z)
    # the stroke of a linear actuator, not its dimensions, limits the motion
    own = bool(loop.joints[2].slides)
    kind = turns_of_inverted(frame, crank, offset) if own else "a linear actuator swings the crank"
    return LoopType(loop, "inverted slider-crank", kind, {names[0]: frame, names[1]: crank, "offset": offset})


def turns_of_inverted(d: float, a: float, e: float) -> str:
    """Return which links of an inverted slider-crank make full turns, for frame, crank and offset."""
    if _excess(a, d + e) >= 0.0:
        return "the crank and the sliding link make full turns (Whitworth)"
    if _excess(abs(d - a), e) >= 0.0:
        return "the crank makes full turns, the sliding link swings"
    return "the crank and the sliding link swing"


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
