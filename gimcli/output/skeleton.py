"""Draw a mechanism at one pose with the symbols of textbooks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.mechanism import FRAME, HEIGHT, SPAN, ComplexArray, Input, Mechanism, PairRow
from gimcli.output import style, symbols
from gimcli.output.picture import Picture
from gimcli.structure.convex_hull import convex_hull

FLAT = 1e-3
"""An element with a smaller ratio of width to length is drawn as a beam."""


@dataclass(frozen=True)
class Skeleton:
    """A mechanism and some of its poses (file units), with the geometry that the drawing needs."""

    mechanism: Mechanism
    poses: ComplexArray = field(repr=False)  # (poses, nodes); the first is drawn strong

    def place(self, member: int, local: complex, pose: int = 0) -> complex:
        """Return the position of a point that is given in a member's own frame."""
        origin, turn = self._carrier(member, pose)
        return origin + turn * self.mechanism.scale * local

    def turn(self, member: int, pose: int = 0) -> complex:
        """Return a member's rotation as a unit complex number."""
        return self._carrier(member, pose)[1]

    def _carrier(self, member: int, pose: int) -> tuple[complex, complex]:
        """Return the position of the origin of a member's frame, and the rotation of the member."""
        m, scale = self.mechanism.members[member], self.mechanism.scale
        if member == FRAME and not self.mechanism.floating:
            return self.mechanism.origin, 1.0 + 0.0j
        z = self.poses[pose]
        first, shape = complex(z[m.nodes[0]]), m.shape
        if len(m.nodes) < 2 or shape[1] == shape[0]:
            return first - complex(shape[0]) * scale, 1.0 + 0.0j
        turn = (complex(z[m.nodes[1]]) - first) / complex(shape[1] - shape[0])
        turn = turn / abs(turn) if turn else 1.0 + 0.0j
        return first - turn * scale * complex(shape[0]), turn

    @property
    def fixed(self) -> frozenset[int]:
        """Nodes of the ground."""
        return frozenset() if self.mechanism.floating else frozenset(self.mechanism.members[FRAME].nodes)

    @property
    def used(self) -> frozenset[int]:
        """Nodes at which a moving member, a slide or a linear actuator is attached."""
        bodies = self.mechanism.members[0 if self.mechanism.floating else 1 :]
        nodes = {node for member in bodies for node in member.nodes}
        nodes |= {slide.node for slide in self.mechanism.slides}
        nodes |= {n for a in self.mechanism.actuators if a.kind == SPAN for n in (a.node, a.nodes[1])}
        return frozenset(nodes)

    @property
    def pins(self) -> tuple[int, ...]:
        """Nodes that are revolute pairs: two members meet, or one meets a block or an actuator."""
        count = np.zeros(len(self.mechanism.nodes), dtype=int)
        for member in self.mechanism.members:
            count[list(member.nodes)] += 1
        for pair in self.pairs():
            if len(pair) == 1:
                count[pair[0].node] += 1
        for actuator in self.mechanism.actuators:
            if actuator.kind == SPAN:
                count[[actuator.node, actuator.nodes[1]]] += 1
        return tuple(int(node) for node in np.flatnonzero(count > 1) if int(node) in self.used)

    def pairs(self) -> list[list[PairRow]]:
        """Return the sliding pairs; a true prismatic pair is a list of two rows."""
        pairs: dict[str, list[PairRow]] = {}
        for slide in self.mechanism.slides:
            pairs.setdefault(slide.pair, []).append(slide)
        return list(pairs.values())

    def outline(self, member: int, pose: int = 0) -> ComplexArray:
        """Return the convex hull of the nodes and points of a member; a line if they are collinear."""
        carried = [p.local for p in self.mechanism.points if p.member == member]
        nodes = self.poses[pose][list(self.mechanism.members[member].nodes)]
        return hull(np.append(nodes, [self.place(member, local, pose) for local in carried]))

    def reach(self, pair: Sequence[PairRow]) -> tuple[complex, complex, complex]:
        """Return the ends of a block's travel over all poses, drawn in the first pose, and the direction (unit)."""
        slide = pair[0]
        line, along = self.place(slide.guide, slide.point), slide.along * self.turn(slide.guide)
        travel: list[float] = []
        for pose in range(len(self.poses)):
            start = self.place(slide.guide, slide.point, pose)
            back = (slide.along * self.turn(slide.guide, pose)).conjugate()
            travel += [((complex(self.poses[pose][s.node]) - start) * back).real for s in pair]
        if slide.guide != FRAME or self.mechanism.floating:
            travel += self.bracket(slide, line, along)
        return line + along * min(travel), line + along * max(travel), along

    def bracket(self, slide: PairRow, line: complex, along: complex) -> list[float]:
        """Return the position along a guide where its member holds it, if the guide passes none of its nodes."""
        nodes = self.poses[0][list(self.mechanism.members[slide.guide].nodes)]
        feet = (nodes - line) * along.conjugate()
        if np.min(np.abs(feet.imag)) < 1e-6 * self.mechanism.size * self.mechanism.scale:
            return []
        return [float(feet.real[np.argmin(np.abs(feet.imag))])]

    def extent(self) -> ComplexArray:
        """Return points that the picture must contain."""
        nodes, poses = self.poses[:, sorted(self.used)].ravel(), range(len(self.poses))
        points = [self.place(p.member, p.local, pose) for p in self.mechanism.points for pose in poses]
        ends = [end for pair in self.pairs() for end in self.reach(pair)[:2]]
        return np.concatenate((nodes, np.array([*points, *ends], dtype=np.complex128)))


def hull(z: ComplexArray) -> ComplexArray:
    """Return the convex hull counter-clockwise, or the two ends if the points are on a line."""
    return np.asarray(z[convex_hull(z, FLAT)])


def draw_ghost(picture: Picture, skeleton: Skeleton, pose: int) -> None:
    """Draw one of the other poses with light lines."""
    z = skeleton.poses[pose]
    for member in _bodies(skeleton):
        outline = skeleton.outline(member, pose)
        if len(outline) > 2:
            picture.area(style.GHOST_PLATE, outline)
        else:
            picture.stroke(style.GHOST, outline)
    for actuator in skeleton.mechanism.actuators:
        if actuator.kind == SPAN:
            picture.stroke(style.GHOST, z[[actuator.node, actuator.nodes[1]]])
    for pair in skeleton.pairs():
        along = pair[0].along * skeleton.turn(pair[0].guide, pose)
        symbols.block(picture, *_span(z, pair, along), along, style.GHOST_BLOCK)
    moving = [n for n in skeleton.pins if n not in skeleton.fixed]
    picture.mark(style.GHOST_PIN, *z[moving].tolist())


def draw_strong(picture: Picture, skeleton: Skeleton) -> None:
    """Draw the first pose with all its symbols."""
    for member in _bodies(skeleton):
        _draw_body(picture, skeleton, member)
    for pair in skeleton.pairs():
        _draw_pair(picture, skeleton, pair)
    for node in sorted(skeleton.fixed & skeleton.used):
        _draw_support(picture, skeleton, node)
    for actuator in skeleton.mechanism.actuators:
        _draw_actuator(picture, skeleton, actuator)
    _draw_nodes(picture, skeleton)


def _bodies(skeleton: Skeleton) -> range:
    return range(0 if skeleton.mechanism.floating else 1, len(skeleton.mechanism.members))


def _draw_body(picture: Picture, skeleton: Skeleton, member: int) -> None:
    """Draw a plate, a beam or a link; a link is drawn over the block of another member to which it is pinned."""
    outline, nodes = skeleton.outline(member), set(skeleton.mechanism.members[member].nodes)
    if len(outline) > 2:
        picture.area(style.PLATE, outline)
    elif len(nodes) > 2:
        picture.stroke(style.BEAM, outline)
    else:
        carried = [p for p in skeleton.pairs() if p[0].guide != member and not {s.node for s in p} >= nodes]
        upper = any(slide.node in nodes for pair in carried for slide in pair)
        picture.stroke(style.UPPER if upper else style.LINK, outline)


def _draw_pair(picture: Picture, skeleton: Skeleton, pair: Sequence[PairRow]) -> None:
    """Draw a block and its guide."""
    first, second, along = skeleton.reach(pair)
    z, carrier = skeleton.poses[0], pair[0].guide
    if carrier == FRAME and not skeleton.mechanism.floating:
        symbols.frame_guide(picture, first, second, along, _away(skeleton, first, along))
    else:
        symbols.moving_guide(picture, first, second, along)
        _draw_bracket(picture, skeleton, pair[0], along)
    symbols.block(picture, *_span(z, pair, along), along)


def _draw_bracket(picture: Picture, skeleton: Skeleton, slide: PairRow, along: complex) -> None:
    """Draw a line from a guide that passes through no node of its member to the nearest node."""
    line = skeleton.place(slide.guide, slide.point)
    for travel in skeleton.bracket(slide, line, along):
        nodes = skeleton.poses[0][list(skeleton.mechanism.members[slide.guide].nodes)]
        foot = line + along * travel
        picture.stroke(style.LINK, [foot, complex(nodes[np.argmin(np.abs(nodes - foot))])])


def _span(z: ComplexArray, pair: Sequence[PairRow], along: complex) -> tuple[complex, complex]:
    """Return the first and last node of a block along its guide."""
    nodes = sorted((complex(z[s.node]) for s in pair), key=lambda p: (p * along.conjugate()).real)
    return nodes[0], nodes[-1]


def _away(skeleton: Skeleton, foot: complex, along: complex) -> complex:
    """Return the side (unit) of a frame guide for the hatching: below, or for a vertical guide away from the links."""
    z = skeleton.poses[0][sorted(skeleton.used)]
    aside = float(np.mean(((z - foot) * along.conjugate()).imag))
    if abs(along.imag) < 0.95:
        return -1j * along if along.real > 0 else 1j * along
    return -1j * along if aside >= 0 else 1j * along


def _draw_support(picture: Picture, skeleton: Skeleton, node: int) -> None:
    """Draw a fixed pivot below its node, or above it if all links point down."""
    slopes = [direction.imag for direction in _directions(skeleton, node)]
    symbols.fixed_pivot(picture, complex(skeleton.poses[0][node]), bool(slopes) and max(slopes) < -0.2)


def _directions(skeleton: Skeleton, node: int) -> list[complex]:
    """Return the directions (unit) in which members leave a node."""
    at = complex(skeleton.poses[0][node])
    found = []
    for member in _bodies(skeleton):
        if node in skeleton.mechanism.members[member].nodes:
            found += [complex(p) - at for p in skeleton.outline(member)]
    ends = {a.node: a.nodes[1] for a in skeleton.mechanism.actuators if a.kind == SPAN}
    ends |= {b: a for a, b in ends.items()}
    found += [complex(skeleton.poses[0][ends[node]]) - at] if node in ends else []
    return [d / abs(d) for d in found if d]


def _draw_actuator(picture: Picture, skeleton: Skeleton, actuator: Input) -> None:
    """Draw a turning arrow, a cylinder or a straight arrow."""
    z = skeleton.poses[0]
    ends = actuator.law(np.array([0.0, 1.0]))
    sense = float(ends[1] - ends[0])
    if actuator.kind == SPAN:
        symbols.cylinder(picture, complex(z[actuator.node]), complex(z[actuator.nodes[1]]))
    elif actuator.kind == HEIGHT:
        along = actuator.normal * skeleton.turn(actuator.guide)
        aside = -_away(skeleton, complex(z[actuator.node]), along)
        symbols.travel_arrow(picture, complex(z[actuator.node]), along, aside, sense)
    else:
        taken = _directions(skeleton, actuator.node)
        if actuator.node in skeleton.fixed:
            taken.append(1j if taken and max(d.imag for d in taken) < -0.2 else -1j)
        symbols.turning_arrow(picture, complex(z[actuator.node]), taken, sense)


def _draw_nodes(picture: Picture, skeleton: Skeleton) -> None:
    """Draw pins, other nodes, and the points that members carry."""
    z, pins = skeleton.poses[0], set(skeleton.pins)
    covered = {slide.node for pair in skeleton.pairs() if len(pair) > 1 for slide in pair} - pins
    plain = skeleton.used - pins - covered
    picture.mark(style.PIN, *z[sorted(pins)].tolist())
    picture.mark(style.DOT, *z[sorted(plain)].tolist())
    picture.mark(style.TRACER, *(skeleton.place(p.member, p.local) for p in skeleton.mechanism.points))


def draw_markers(picture: Picture, skeleton: Skeleton) -> None:
    """Draw the nodes of the frame to which nothing is attached, such as those that only define a guide."""
    picture.mark(style.CROSS, *skeleton.poses[0][sorted(skeleton.fixed - skeleton.used)].tolist())
