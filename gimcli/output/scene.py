"""What is drawn of a mechanism, for pictures and for animated pages: bodies, guides, drives, springs and loads.

All places are anchors: a node, or a point fixed to a member. A renderer needs only the positions of the
nodes to place every item. Lengths and positions are in the file's length unit, directions are unit complex numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gimcli.connected import grouped
from gimcli.dynamic_data import AppliedLoad
from gimcli.mechanism import FRAME, HEIGHT, SPAN, ComplexArray, Input, Mechanism
from gimcli.output.anchors import Anchor, Anchors
from gimcli.structure.convex_hull import convex_hull
from gimcli.structure.joints import PRISMATIC, REVOLUTE, Joint, sliding_pairs
from gimcli.structure.kinematic_chain import kinematic_chain

if TYPE_CHECKING:
    from gimcli.output.gear_outlines import GearOutlines

FLAT = 1e-3
"""An element with a smaller ratio of width to length is drawn as a beam."""

HANGING, STEEP = -0.2, -0.7
"""A support is drawn above its pivot if all links leave it with a sine of their direction below the first, and one of
them below the second: it would cover the support."""


@dataclass(frozen=True)
class MemberOutline:
    """A moving member."""

    member: int
    kind: str  # "plate", "beam" (nodes on one line) or "link"
    outline: tuple[Anchor, ...]  # its convex hull, or two ends
    above: bool = False  # drawn over the block of another member to which it is pinned


@dataclass(frozen=True)
class Slider:
    """A block on a guide: a pin in a slot (one node), or a true prismatic pair (two nodes)."""

    name: str
    nodes: tuple[int, ...]  # covered by the block
    line: Anchor  # a point of the guide's line
    along: complex  # direction of the line in the coordinate system of the guide's member
    travel: tuple[float, float]  # positions of the guide's ends along the line, from `line`
    side: complex = 0.0j  # of the hatching, for a guide on the frame; 0: the guide moves
    bracket: tuple[Anchor, ...] = ()  # line from the guide to its member, if the guide passes through no node of it


@dataclass(frozen=True)
class Support:
    """A fixed pivot."""

    node: int
    upward: bool  # drawn above the pivot


@dataclass(frozen=True)
class Drive:
    """An actuator: a turning arrow, a straight arrow beside a block, or a cylinder between two nodes."""

    name: str
    kind: str  # "turn", "travel" or "cylinder"
    nodes: tuple[int, ...]
    sense: float  # 1, or -1 if the input decreases
    direction: complex = 1.0 + 0.0j  # middle of the arc; or direction of travel in the guide's coordinate system
    aside: float = 1.0  # the straight arrow is to the left (1) or to the right (-1) of its direction
    guide: int = FRAME  # member of the guide


@dataclass(frozen=True)
class ForceElement:
    """A spring or a damper between two anchors, or between two directions at a pivot."""

    name: str
    kind: str  # "spring" or "damper"
    ends: tuple[Anchor, Anchor]  # for a torsional one: on the arm and on the reference, or beside the pivot
    pivot: int = -1  # node of a torsional spring or damper
    lane: float = 0.0  # place beside other elements with the same ends: 0 on their line, 1 one width to the left


@dataclass(frozen=True)
class LoadArrow:
    """An applied force or torque."""

    name: str
    at: Anchor
    force: complex = 0.0j  # direction times its size relative to the largest force
    follower: bool = False  # the direction turns with the member
    torque: float = 0.0  # sign


class Scene(Anchors):
    """The items of a mechanism, with sizes and sides that suit all of some poses.

    Args:
        mechanism: a compiled mechanism.
        poses: (poses, nodes) positions x + iy without NaN. Guides are long enough for all of them; the first determines
            on which sides symbols are.
    """

    def __init__(self, mechanism: Mechanism, poses: ComplexArray) -> None:
        super().__init__(mechanism)
        self.poses = np.atleast_2d(poses)

    # -- nodes ----------------------------------------------------------------------------------

    @cached_property
    def fixed(self) -> frozenset[int]:
        """Nodes of the ground."""
        return frozenset() if self.mechanism.floating else frozenset(self.mechanism.members[FRAME].nodes)

    @cached_property
    def used(self) -> frozenset[int]:
        """Nodes at which a moving member, a slide, a linear actuator, a spring or a damper is attached."""
        spans = (a for a in (*self.mechanism.actuators, *self.mechanism.gauges) if a.kind == SPAN)
        return frozenset(
            (
                *(node for k in self.moving for node in self.mechanism.members[k].nodes),
                *(slide.node for slide in self.mechanism.slides),
                *(node for a in spans for node in a.nodes[:2]),
            )
        )

    @cached_property
    def pins(self) -> tuple[int, ...]:
        """Nodes that are revolute pairs: two members meet, or one meets a block or an actuator."""
        joints = kinematic_chain(self.mechanism).joints
        return tuple(joint.node for joint in joints if joint.kind == REVOLUTE and joint.node in self.used)

    @cached_property
    def plain(self) -> tuple[int, ...]:
        """Other nodes that are drawn: not pins, and not covered by a block of two nodes."""
        covered = {node for pair in sliding_pairs(self.mechanism) if pair.kind == PRISMATIC for node in pair.nodes}
        return tuple(sorted(self.used - set(self.pins) - covered))

    @cached_property
    def crosses(self) -> tuple[int, ...]:
        """Nodes of the ground to which nothing is attached, such as those that only define a guide."""
        return tuple(sorted(self.fixed - self.used))

    @cached_property
    def tracers(self) -> dict[str, Anchor]:
        """The points that members carry, by name."""
        return {p.name: self.on(p.member, p.local) for p in self.mechanism.points}

    @cached_property
    def traced(self) -> dict[str, Anchor]:
        """The nodes and points whose curves are drawn, by name."""
        nodes = self.mechanism.nodes
        return {n: Anchor(nodes.index(n)) if n in nodes else self.tracers[n] for n in self.mechanism.traced}

    # -- items ----------------------------------------------------------------------------------

    @property
    def moving(self) -> range:
        """Numbers of the members that are drawn."""
        return range(0 if self.mechanism.floating else 1, len(self.mechanism.members))

    @cached_property
    def bodies(self) -> tuple[MemberOutline, ...]:
        """The moving members."""
        return tuple(self._body(member) for member in self.moving)

    @cached_property
    def sliders(self) -> tuple[Slider, ...]:
        """The sliding pairs."""
        return tuple(self._slider(pair) for pair in sliding_pairs(self.mechanism))

    @cached_property
    def supports(self) -> tuple[Support, ...]:
        """The fixed pivots."""
        return tuple(Support(node, self._hangs(node)) for node in sorted(self.fixed & self.used))

    @cached_property
    def drives(self) -> tuple[Drive, ...]:
        """The actuators of the file; what gears turn has no actuator."""
        geared = {coupling.follower for coupling in self.mechanism.couplings if coupling.geared}
        return tuple(self._drive(own) for k, own in enumerate(self.mechanism.actuators) if k not in geared)

    @cached_property
    def cylinders(self) -> tuple[Drive, ...]:
        """The actuators between two nodes."""
        return tuple(drive for drive in self.drives if drive.kind == "cylinder")

    @cached_property
    def gears(self) -> GearOutlines | None:
        """The gears, belts and racks, if there are any."""
        if not self.mechanism.gears:
            return None
        from gimcli.output.gear_outlines import gear_outlines  # imported late: few models have gears

        return gear_outlines(self)

    @cached_property
    def elements(self) -> tuple[ForceElement, ...]:
        """The springs and dampers; those with the same ends are side by side."""
        data = self.mechanism.dynamics
        springs = [(spring.name, "spring", spring.gauge) for spring in data.springs]
        named = [*springs, *((damper.name, "damper", damper.gauge) for damper in data.dampers)]
        placed = [(name, kind, *self._measured(self.mechanism.gauges[gauge])) for name, kind, gauge in named]
        ends_of = [(drive.name, -1, frozenset(map(Anchor, drive.nodes))) for drive in self.cylinders]
        ends_of += [(name, pivot, frozenset(ends)) for name, _, ends, pivot in placed]
        beside = grouped(((pivot, ends), name) for name, pivot, ends in ends_of)
        found = []
        for name, kind, ends, pivot in placed:
            together = beside[pivot, frozenset(ends)]
            found.append(ForceElement(name, kind, ends, pivot, together.index(name) - 0.5 * (len(together) - 1)))
        return tuple(found)

    @cached_property
    def loads(self) -> tuple[LoadArrow, ...]:
        """The applied forces and torques."""
        loads = self.mechanism.dynamics.loads
        largest = max((abs(load.force) for load in loads), default=0.0) or 1.0
        return tuple(self._load(load, largest) for load in loads)

    @cached_property
    def centres(self) -> tuple[Anchor, ...]:
        """The centres of mass of members, and the point masses."""
        inertias = [i for i in self.mechanism.dynamics.inertias if i.mass]
        return tuple(Anchor(i.node) if i.node >= 0 else self.on(i.member, i.centre) for i in inertias)

    def extent(self, shown: Sequence[int] | None = None) -> ComplexArray:
        """Return points that a picture of all poses, or of those with the numbers `shown`, must contain."""
        poses = self.poses if shown is None else self.poses[list(shown)]
        anchors = [*self.tracers.values(), *(load.at for load in self.loads), *self.centres]
        ends = [end for slider in self.sliders for end in self.ends(slider, self.poses[0])]
        places = [np.atleast_1d(self.place(anchor, poses)) for anchor in anchors]
        gears = self.gears.extent(self, poses) if self.gears else ()
        whole = (poses[:, sorted(self.used)].ravel(), *places, *gears, np.array(ends, dtype=np.complex128))
        return np.concatenate(whole)

    def ends(self, slider: Slider, z: ComplexArray) -> tuple[complex, complex]:
        """Return the ends of a block's travel on its guide, for positions of the nodes (nodes,)."""
        line, along = self.place(slider.line, z), slider.along * self.turn(slider.line.member, z)
        return complex(line + along * slider.travel[0]), complex(line + along * slider.travel[1])

    def directions(self, node: int) -> list[complex]:
        """Return the directions (unit) in which members, cylinders and springs leave a node in the first pose."""
        z = self.poses[0]
        found = [
            self.place(a, z) for b in self.bodies if node in self.mechanism.members[b.member].nodes for a in b.outline
        ]
        for span in (*self.mechanism.actuators, *self.mechanism.gauges):
            if span.kind == SPAN and node in span.nodes[:2]:
                found += [z[n] for n in span.nodes[:2] if n != node]
        away = [complex(place) - complex(z[node]) for place in found]
        near = 1e-9 * self.mechanism.size * self.mechanism.scale
        return [d / abs(d) for d in away if abs(d) > near]

    # -- parts ----------------------------------------------------------------------------------

    def _body(self, member: int) -> MemberOutline:
        own = self.mechanism.members[member]
        places = np.append(own.shape, [p.local for p in self.mechanism.points if p.member == member])
        corners = convex_hull(places, FLAT)
        outline = tuple(
            Anchor(own.nodes[k]) if k < len(own.nodes) else self.on(member, complex(places[k]))
            for k in map(int, corners)
        )
        kind = "plate" if len(outline) > 2 else "beam" if len(own.nodes) > 2 else "link"
        carried = (p.nodes for p in sliding_pairs(self.mechanism) if p.bodies[0] != member)
        above = kind == "link" and any(0 < len({*own.nodes} - {*nodes}) < len(own.nodes) for nodes in carried)
        return MemberOutline(member, kind, outline, above)

    def _slider(self, pair: Joint) -> Slider:
        slide = self.mechanism.slides[pair.slides[0]]
        line, along = self.on(slide.guide, slide.point), self.direction(slide.guide, slide.along)
        start = self.place(line, self.poses)
        back = np.conjugate(along * self.turn(slide.guide, self.poses))
        travel = [float(t) for node in pair.nodes for t in np.ravel((self.poses[:, node] - start) * back).real]
        if self.carriers[slide.guide].origin < 0:
            side = self._side(line.local + along * min(travel), along)
            return Slider(pair.name, pair.nodes, line, along, (min(travel), max(travel)), side)
        held, bracket = self._bracket(slide.guide, line, along)
        travel += held
        return Slider(pair.name, pair.nodes, line, along, (min(travel), max(travel)), bracket=bracket)

    def _bracket(self, guide: int, line: Anchor, along: complex) -> tuple[list[float], tuple[Anchor, ...]]:
        """Return where a guide that passes through no node of its member is held: position on it, and the two ends."""
        own = self.mechanism.members[guide]
        feet = (np.array([self.local(guide, complex(z)) for z in own.shape]) - line.local) * along.conjugate()
        nearest = int(np.argmin(np.abs(feet.imag)))
        if abs(feet[nearest].imag) < 1e-6 * self.mechanism.size * self.mechanism.scale:
            return [], ()
        at = float(feet[nearest].real)
        return [at], (Anchor(member=guide, local=line.local + along * at), Anchor(own.nodes[nearest]))

    def _side(self, foot: complex, along: complex) -> complex:
        """Return the side of a frame guide for the hatching: below; of a vertical guide away from the links."""
        z = self.poses[0][sorted(self.used)]
        aside = float(np.mean(((z - foot) * along.conjugate()).imag))
        if abs(along.imag) < 0.95:
            return -1j * along if along.real > 0 else 1j * along
        return -1j * along if aside >= 0 else 1j * along

    def _hangs(self, node: int) -> bool:
        """Return whether all members leave a node downwards, and one of them steeply."""
        slopes = [direction.imag for direction in self.directions(node)]
        return bool(slopes) and max(slopes) < HANGING and min(slopes) < STEEP

    def _drive(self, actuator: Input) -> Drive:
        ends = actuator.law(np.array([0.0, 1.0]))
        sense = 1.0 if ends[1] >= ends[0] else -1.0
        if actuator.kind == SPAN:
            return Drive(actuator.name, "cylinder", actuator.nodes[:2], sense)
        if actuator.kind == HEIGHT:
            direction = self.direction(actuator.guide, actuator.normal)
            along = direction * complex(np.ravel(self.turn(actuator.guide, self.poses[0]))[0])
            aside = -(self._side(complex(self.poses[0][actuator.node]), along) / along).imag
            return Drive(actuator.name, "travel", (actuator.node,), sense, direction, aside, actuator.guide)
        taken = self.directions(actuator.node)
        if actuator.node in self.fixed:
            taken.append(1j if self._hangs(actuator.node) else -1j)
        return Drive(actuator.name, "turn", (actuator.node,), sense, _widest_gap(taken))

    def _measured(self, gauge: Input) -> tuple[tuple[Anchor, Anchor], int]:
        """Return the ends of a spring or damper on a gauge, and the pivot's node of an angle (else -1)."""
        if gauge.kind == SPAN:
            return (Anchor(gauge.nodes[0]), Anchor(gauge.nodes[1])), -1
        if gauge.kind == HEIGHT:
            return (self.on(gauge.guide, gauge.point), Anchor(gauge.node)), -1
        return (self._ray(gauge, 0), self._ray(gauge, 1)), gauge.node

    def _ray(self, gauge: Input, side: int) -> Anchor:
        """Return a point one size of the mechanism away from a gauge's pivot, on its arm (0) or its reference (1)."""
        member, direction = gauge.members[side], (gauge.arm, gauge.reference)[side]
        reach = direction * self.mechanism.size
        own = self.mechanism.members[member]
        if gauge.node in own.nodes:
            return self.on(member, own.local(gauge.node) + reach)
        first = complex(self.poses[0][gauge.node]) - self.mechanism.origin  # a reference on the frame
        return self.on(member, first / self.mechanism.scale + reach)

    def _load(self, load: AppliedLoad, largest: float) -> LoadArrow:
        if load.torque:
            centre = self.on(load.member, complex(self.mechanism.members[load.member].shape.mean()))
            return LoadArrow(load.name, centre, torque=float(np.sign(load.torque)))
        force = load.force / largest
        force = self.direction(load.member, force) if load.follows else force
        at = Anchor(load.node) if load.node >= 0 else self.on(load.member, load.point)
        return LoadArrow(load.name, at, force, load.follows)


def _widest_gap(taken: Sequence[complex]) -> complex:
    """Return the direction that is farthest from the given directions (unit)."""
    angles = np.radians(np.arange(90.0, 450.0, 15.0))
    others: NDArray[Any] = np.array(taken or [-1j])
    apart = np.angle(np.exp(1j * angles)[:, None] / others[None, :])
    middle = angles[np.argmax(np.min(np.abs(apart), axis=1).round(6))]
    return complex(np.exp(1j * middle))
