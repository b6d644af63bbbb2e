"""What is drawn of a mechanism, as symbols, for pictures, animated pages and drawing programs.

All places are anchors: a node, or a point fixed to a member. A renderer needs only the positions of the
nodes to place every symbol. Lengths and positions are in the file's length unit, directions are unit complex numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from gimcli.connected import grouped
from gimcli.dynamic_data import AppliedLoad
from gimcli.mechanism import FRAME, HEIGHT, SPAN, ComplexArray, FloatArray, Input, Mechanism
from gimcli.output import style, symbols
from gimcli.output.anchors import Anchor, Anchors
from gimcli.output.style import Mark
from gimcli.output.symbols import Seat, Stroke, Symbol
from gimcli.structure.convex_hull import convex_hull
from gimcli.structure.joints import PRISMATIC, REVOLUTE, Joint, sliding_pairs
from gimcli.structure.kinematic_chain import kinematic_chain

FLAT = 1e-3
"""An element with a smaller ratio of width to length is drawn as a beam."""

HANGING, STEEP = -0.2, -0.7
"""A support is drawn above its pivot if all links leave it with a sine of their direction below the first, and one of
them below the second: it would cover the support."""

GROUND = "frame"
"""Name of the part with the symbols of the frame."""

SQUARE = np.array([-1.0 - 1.0j, 1.0 + 1.0j])
"""Corners around a circle of radius 1."""


class Scene(Anchors):
    """The symbols of a mechanism, with sizes and sides that suit all of some poses.

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

    @cached_property
    def marks(self) -> tuple[tuple[str, Mark, Anchor], ...]:
        """Part, mark and place of the pins, the other nodes and the points of members."""
        drawn = [(node, style.PIN) for node in self.pins] + [(node, style.DOT) for node in self.plain]
        nodes = [(f"node:{self.mechanism.nodes[node]}", mark, Anchor(node)) for node, mark in drawn]
        return (*nodes, *((f"point:{name}", style.TRACER, anchor) for name, anchor in self.tracers.items()))

    # -- symbols --------------------------------------------------------------------------------

    @cached_property
    def strong(self) -> tuple[Symbol, ...]:
        """All symbols."""
        every = chain(self.gears, self.bodies, *self.sliders, self.supports, self.elements, self.drives, self.loads)
        return (*(symbol for symbol in every if symbol.strokes), *self.centres)

    @cached_property
    def light(self) -> tuple[Symbol, ...]:
        """The symbols of a light pose: members, cylinders, blocks, and gears of which a pivot moves."""
        moving = (gear for gear in self.gears if not {end.node for end in gear.ends} <= self.fixed)
        gears = (replace(gear, seat=replace(cast(Seat, gear.seat), member=FRAME)) for gear in moving)  # without marks
        return tuple(symbol.light for symbol in (*self.bodies, *gears, *self.cylinders, *self.blocks))

    @property
    def moving(self) -> range:
        """Numbers of the members that are drawn."""
        return range(0 if self.mechanism.floating else 1, len(self.mechanism.members))

    @cached_property
    def bodies(self) -> tuple[Symbol, ...]:
        """The moving members."""
        return tuple(map(self._body, self.moving))

    @cached_property
    def sliders(self) -> tuple[tuple[Symbol, ...], ...]:
        """The sliding pairs: a guide, the line from it to its member if it passes through no node of it, and a block.

        The block covers the pin in a slot (one node), or the two nodes of a true prismatic pair.
        """
        return tuple(tuple(self._slider(pair)) for pair in sliding_pairs(self.mechanism))

    @property
    def blocks(self) -> tuple[Symbol, ...]:
        """The blocks of the sliding pairs."""
        return tuple(own[-1] for own in self.sliders)

    @cached_property
    def supports(self) -> tuple[Symbol, ...]:
        """The fixed pivots."""
        return tuple(map(self._support, sorted(self.fixed & self.used)))

    @cached_property
    def drives(self) -> tuple[Symbol, ...]:
        """The actuators of the file; what gears turn has no actuator."""
        geared = {coupling.follower for coupling in self.mechanism.couplings if coupling.geared}
        return tuple(self._drive(own) for k, own in enumerate(self.mechanism.actuators) if k not in geared)

    @property
    def cylinders(self) -> tuple[Symbol, ...]:
        """The actuators between two nodes."""
        return tuple(drive for drive in self.drives if len(drive.ends) > 1)

    @cached_property
    def gears(self) -> tuple[Symbol, ...]:
        """The gears, belts and racks."""
        if not self.mechanism.gears:
            return ()
        from gimcli.output.gear_symbols import gear_symbols  # imported late: few models have gears

        return gear_symbols(self)

    @cached_property
    def elements(self) -> tuple[Symbol, ...]:
        """The springs and dampers between two places or about a pivot; those with the same ends are side by side."""
        data, gauges = self.mechanism.dynamics, self.mechanism.gauges
        named: list[tuple[str, Any]] = [
            *(("spring", one) for one in data.springs),
            *(("damper", one) for one in data.dampers),
        ]
        placed = [(kind, f"{kind}:{one.name}", self._measured(gauges[one.gauge], kind)) for kind, one in named]
        taken = [(drive.part, drive.ends) for drive in self.cylinders] + [
            (part, seat.places) for _, part, seat in placed
        ]
        beside = grouped((frozenset(places), part) for part, places in taken)
        found = []
        for kind, part, seat in placed:
            together = beside[frozenset(seat.places)]
            lane = together.index(part) - 0.5 * (len(together) - 1)
            found.append(Symbol(part, (symbols.TORSIONAL if seat.arm else symbols.STRAIGHT)[kind](lane), seat))
        return tuple(found)

    @cached_property
    def loads(self) -> tuple[Symbol, ...]:
        """The applied forces and torques, without strokes if they are zero."""
        loads = self.mechanism.dynamics.loads
        largest = max((abs(load.force) for load in loads), default=0.0) or 1.0
        return tuple(self._load(load, largest) for load in loads)

    @cached_property
    def centres(self) -> tuple[Symbol, ...]:
        """The centres of mass of members, and the point masses."""
        inertias = [i for i in self.mechanism.dynamics.inertias if i.mass]
        places = (Anchor(i.node) if i.node >= 0 else self.on(i.member, i.centre) for i in inertias)
        return tuple(Symbol("centres-of-mass", symbols.centre_of_mass(), Seat(at, None, 1.0)) for at in places)

    def extent(self, shown: Sequence[int] | None = None) -> ComplexArray:
        """Return points that a picture of all poses, or of those with the numbers `shown`, must contain."""
        poses = self.poses if shown is None else self.poses[list(shown)]
        anchors = [*self.tracers.values(), *(end for one in (*self.loads, *self.centres) for end in one.ends)]
        guides = [self.line(guide.ends, self.poses[0]) for guide, *_ in self.sliders]
        places = [np.atleast_1d(self.place(anchor, poses)) for anchor in anchors]
        gears = [self.place(end, poses) + gear.radius * SQUARE[:, None] for gear in self.gears for end in gear.ends]
        return np.concatenate((poses[:, sorted(self.used)].ravel(), *places, *map(np.ravel, gears), *guides))

    def directions(self, node: int) -> list[complex]:
        """Return the directions (unit) in which members, cylinders and springs leave a node in the first pose."""
        z = self.poses[0]
        own = (k for k in self.moving if node in self.mechanism.members[k].nodes)
        found = [self.place(end, z) for k in own for end in self.bodies[k - self.moving.start].ends]
        for span in (*self.mechanism.actuators, *self.mechanism.gauges):
            if span.kind == SPAN and node in span.nodes[:2]:
                found += [z[n] for n in span.nodes[:2] if n != node]
        away = [complex(place) - complex(z[node]) for place in found]
        near = 1e-9 * self.mechanism.size * self.mechanism.scale
        return [d / abs(d) for d in away if abs(d) > near]

    # -- parts ----------------------------------------------------------------------------------

    def _body(self, member: int) -> Symbol:
        """Return a plate, a beam (nodes on one line) or a link, above the block of another member it is pinned to."""
        own = self.mechanism.members[member]
        places = np.append(own.shape, [p.local for p in self.mechanism.points if p.member == member])
        corners = convex_hull(places, FLAT)
        outline = tuple(
            Anchor(own.nodes[k]) if k < len(own.nodes) else self.on(member, complex(places[k]))
            for k in map(int, corners)
        )
        carried = (p.nodes for p in sliding_pairs(self.mechanism) if p.bodies[0] != member)
        above = any(0 < len({*own.nodes} - {*nodes}) < len(own.nodes) for nodes in carried)
        line = style.BEAM if len(own.nodes) > 2 else style.UPPER if above else style.LINK
        look = style.PLATE if len(outline) > 2 else line
        return Symbol(f"member:{own.name}", (Stroke(look),), corners=outline)

    def _slider(self, pair: Joint) -> Iterator[Symbol]:
        """Yield the guide of a block, the line from the guide to its member if there is one, and the block."""
        slide = self.mechanism.slides[pair.slides[0]]
        line, along = self.on(slide.guide, slide.point), self.direction(slide.guide, slide.along)
        start, part = self.place(line, self.poses), f"pair:{pair.name}"
        back = np.conjugate(along * self.turn(slide.guide, self.poses))
        travel = [float(t) for node in pair.nodes for t in np.ravel((self.poses[:, node] - start) * back).real]
        fixed = self.carriers[slide.guide].origin < 0
        held, bracket = ([], ()) if fixed else self._bracket(slide.guide, line, along)
        low, high = min(travel + held), max(travel + held)
        first, last = (Anchor(member=slide.guide, local=line.local + t * along) for t in (low, high))
        side = self._side(line.local + along * low, along) / along if fixed else 0j
        strokes = symbols.frame_guide(side) if fixed else symbols.moving_guide()
        yield Symbol(GROUND if fixed else part, strokes, Seat(first, last, along, slide.guide), fixed=fixed)
        if bracket:
            yield Symbol(f"member:{self.mechanism.members[slide.guide].name}", (Stroke(style.LINK),), corners=bracket)
        at, *other = map(Anchor, pair.nodes)
        seat = Seat(at, other[0]) if other else Seat(at, None, along, slide.guide)
        yield Symbol(part, (symbols.block(),), seat)

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

    def _support(self, node: int) -> Symbol:
        upward = self._hangs(node)
        aside = complex(0.0, 1.0 if upward else -1.0)
        return Symbol(GROUND, symbols.fixed_pivot(upward), Seat(Anchor(node), None, 1.0), fixed=True, aside=aside)

    def _hangs(self, node: int) -> bool:
        """Return whether all members leave a node downwards, and one of them steeply."""
        slopes = [direction.imag for direction in self.directions(node)]
        return bool(slopes) and max(slopes) < HANGING and min(slopes) < STEEP

    def _drive(self, actuator: Input) -> Symbol:
        """Return a turning arrow, a straight arrow beside a block, or a cylinder between two nodes."""
        part, ends = f"actuator:{actuator.name}", actuator.law(np.array([0.0, 1.0]))
        sense = 1.0 if ends[1] >= ends[0] else -1.0
        if actuator.kind == SPAN:
            return Symbol(part, symbols.cylinder(), Seat(Anchor(actuator.nodes[0]), Anchor(actuator.nodes[1])))
        if actuator.kind == HEIGHT:
            direction = self.direction(actuator.guide, actuator.normal)
            along = direction * complex(np.ravel(self.turn(actuator.guide, self.poses[0]))[0])
            left = -(self._side(complex(self.poses[0][actuator.node]), along) / along).imag
            seat = Seat(Anchor(actuator.node), None, direction, actuator.guide)
            return Symbol(part, symbols.travel_arrow(left, sense), seat)
        taken = self.directions(actuator.node)
        if actuator.node in self.fixed:
            taken.append(1j if self._hangs(actuator.node) else -1j)
        free = _widest_gap(taken)
        return Symbol(part, symbols.turning_arrow(sense), Seat(Anchor(actuator.node), None, free), aside=free)

    def _measured(self, gauge: Input, kind: str) -> Seat:
        """Return the seat of a spring or damper on a gauge."""
        if gauge.kind == SPAN:
            return Seat(Anchor(gauge.nodes[0]), Anchor(gauge.nodes[1]))
        if gauge.kind == HEIGHT:
            return Seat(self.on(gauge.guide, gauge.point), Anchor(gauge.node))
        seat = Seat(Anchor(gauge.node), self._ray(gauge, 1), arm=self._ray(gauge, 0))
        middle = _middle(np.array([seat.axes(self, z).turn for z in self.poses]))
        least = symbols.LEAST_TURN[kind]
        return replace(seat, turn=least + (middle - least) % (2.0 * np.pi))

    def _ray(self, gauge: Input, side: int) -> Anchor:
        """Return a point one size of the mechanism away from a gauge's pivot, on its arm (0) or its reference (1)."""
        member, direction = gauge.members[side], (gauge.arm, gauge.reference)[side]
        reach = direction * self.mechanism.size
        own = self.mechanism.members[member]
        if gauge.node in own.nodes:
            return self.on(member, own.local(gauge.node) + reach)
        first = complex(self.poses[0][gauge.node]) - self.mechanism.origin  # a reference on the frame
        return self.on(member, first / self.mechanism.scale + reach)

    def _load(self, load: AppliedLoad, largest: float) -> Symbol:
        """Return a force as an arrow from its point, of a size relative to the largest one; a torque as an arc."""
        part = f"load:{load.name}"
        if load.torque:
            centre = self.on(load.member, complex(self.mechanism.members[load.member].shape.mean()))
            return Symbol(part, symbols.torque(float(np.sign(load.torque))), Seat(centre, None, 1.0))
        force = load.force / largest
        force = self.direction(load.member, force) if load.follows else force
        at, size = Anchor(load.node) if load.node >= 0 else self.on(load.member, load.point), abs(force)
        seat = Seat(at, None, force / (size or 1.0), at.member if load.follows else FRAME)
        return Symbol(part, symbols.force(size) if size else (), seat)


def _middle(angles: FloatArray) -> float:
    """Return the middle of the smallest arc that contains some angles [rad]."""
    turned = np.sort(angles % (2.0 * np.pi))
    gaps = np.diff(turned, append=turned[0] + 2.0 * np.pi)
    widest = int(np.argmax(gaps))
    return float(turned[widest] + 0.5 * gaps[widest] + np.pi)


def _widest_gap(taken: Sequence[complex]) -> complex:
    """Return the direction that is farthest from the given directions (unit)."""
    angles = np.radians(np.arange(90.0, 450.0, 15.0))
    others: NDArray[Any] = np.array(taken or [-1j])
    apart = np.angle(np.exp(1j * angles)[:, None] / others[None, :])
    middle = angles[np.argmax(np.min(np.abs(apart), axis=1).round(6))]
    return complex(np.exp(1j * middle))
