"""Unknown reactions and efforts of a mechanism, the bodies that they act on, and the order of solution.

Unknowns: two force components for every member at a node except the first member, one normal force for every node on a
line, one reaction of every gear, and the effort of every actuator that does not follow by gears. Equations: three for
every moving member, two for a node without a member. The pin of a node belongs to its first member (the frame first,
then the order of the file): forces on the pin act on that member. A true prismatic pair acts on the member whose two
nodes slide. The order of the blocks is the reverse order of formation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate, chain
from typing import Any

import numpy as np

from gimcli.calculus.numbers import RuleNumber, nominal, scalar
from gimcli.coupling_data import RACK, GearPair
from gimcli.dynamic_data import NO_NODE, AppliedLoad, Inertia
from gimcli.kernels.equilibrium import ALONG, COUPLE, MOMENT, PUSH, TURN, X, Y
from gimcli.mechanism import FRAME, HEIGHT, FloatArray, Mechanism, PairRow
from gimcli.structure.carried import carried_direction
from gimcli.structure.derived import derived
from gimcli.structure.dulmage_mendelsohn import EquationBlock, split
from gimcli.structure.joints import PRISMATIC, sliding_pairs
from gimcli.structure.rotation import members_of
from gimcli.structure.steps import NONE, Vector


@dataclass(frozen=True)
class Body:
    """A moving member, or a node without a member."""

    member: int  # NONE for a node
    node: int  # reference point of moments


@dataclass(frozen=True)
class Reaction:
    """One unknown: `vector` at `node` on body `plus`, the opposite at `other` on body `minus`; NONE is the frame.

    A unit of it also exerts the `couples` (body, factor), in lengths of the normal frame for a force.
    """

    kind: int  # of kernels.equilibrium
    plus: int
    minus: int
    node: int = NONE
    other: int = NONE
    vector: Vector = field(default=Vector(1.0 + 0.0j))
    couples: tuple[tuple[int, float], ...] = ()
    on_pin: bool = False  # it acts on the pins of its nodes

    @property
    def ends(self) -> tuple[tuple[int, int], ...]:
        """Its nodes, with the sense of the force at each."""
        return ((self.node, 1),) if self.node == self.other else ((self.node, 1), (self.other, -1))


@dataclass(frozen=True)
class Pin:
    """The revolute pairs at a node; the force on the k-th member but the first is unknowns `first` + 2 (k - 1), + 1."""

    node: int
    members: tuple[int, ...]
    first: int
    loaded: bool  # sliding pairs, actuators, springs, dampers, masses or loads are attached to the pin itself

    @property
    def unknowns(self) -> dict[int, tuple[int, int]]:
        """The unknowns x and y of the force on each member but the first."""
        return {member: (self.first + 2 * k, self.first + 2 * k + 1) for k, member in enumerate(self.members[1:])}


class Statics:
    """The bodies and unknowns of a mechanism."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.reactions, dynamics = mechanism, list[Reaction](), mechanism.dynamics
        holders, moving = members_of(mechanism), len(mechanism.members) - 1
        loose = [node for node, held in enumerate(holders) if not held]
        self.body_of_member = {k: k - 1 for k in range(1, moving + 1)} | {FRAME: NONE}
        # body to which the pin of each node belongs; NONE for the frame
        self.body_of_pin = {n: self.body_of_member[held[0]] for n, held in enumerate(holders) if held}
        self.body_of_pin |= {n: k for k, n in enumerate(loose, start=moving)}
        held, driven, self.gauges = (  # the last: the effort of a spring or damper on each gauge, as an unknown
            [self._row(row) for row in rows] for rows in (mechanism.pairs, mechanism.actuators, mechanism.gauges)
        )
        loaded = {node for one in (*held, *driven, *self.gauges) if one.on_pin for node, _ in one.ends}
        loaded |= {one.node for one in dynamics.inertias} | {load.node for load in dynamics.loads}
        joined = [(n, members) for n, members in enumerate(holders) if len(members) > 1]
        self.pins = [Pin(n, members, self._pin(n, members), n in loaded) for n, members in joined]
        unknowns = [self._add(one) for one in held]
        slides = (k for k, row in zip(unknowns, mechanism.pairs, strict=True) if row.kind == HEIGHT)
        self.normals = dict(enumerate(slides))  # unknown of each slide
        # unknown of each actuator; NONE if it follows by gears; and of each gear
        self.efforts = [NONE if k in mechanism.geared else self._add(one) for k, one in enumerate(driven)]
        self.teeth = [self._add(gear_reaction(mechanism, gear, self.body_of_member)) for gear in mechanism.gears]
        self.bodies = [*(Body(k, self._moment_node(k)) for k in range(1, moving + 1)), *(Body(NONE, n) for n in loose)]

    @property
    def equations(self) -> int:
        """Number of equations."""
        return sum(self._sizes)

    @cached_property
    def _sizes(self) -> list[int]:
        """Number of equations of each body."""
        return [3 if body.member != NONE else 2 for body in self.bodies]

    @property
    def surplus(self) -> int:
        """Number of unknowns beyond the equations: redundant constraints."""
        return len(self.reactions) - self.equations

    @cached_property
    def first_row(self) -> tuple[int, ...]:
        """First equation of each body."""
        return tuple(accumulate(self._sizes[:-1], initial=0)) if self.bodies else ()

    def body_of(self, part: Inertia | AppliedLoad) -> int:
        """Return the body on which a mass or a load acts; the pin of a node belongs to its first member."""
        return self.body_of_member[part.member] if part.node == NO_NODE else self.body_of_pin[part.node]

    @cached_property
    def pole(self) -> complex:
        """The fixed node at the origin: moments on the frame are about it, and heights are measured from it."""
        return next((z for z in self.mechanism.members[FRAME].shape if nominal(z) == 0.0), 0.0j)

    def axes(self, reaction: Reaction, body: int, node: int) -> list[int]:
        """Return the axes of a body's equations that a reaction enters."""
        turns = [MOMENT] if self.bodies[body].member != NONE else []
        if reaction.kind == COUPLE:
            return turns
        z = reaction.vector.z
        fixed = reaction.vector.u == NONE and not isinstance(z, RuleNumber) and not np.ndim(z)
        axes = [X] * (not fixed or z.real != 0.0) + [Y] * (not fixed or z.imag != 0.0)
        return axes + (turns if node != self.bodies[body].node else [])

    def entries(self, reaction: Reaction) -> list[tuple[int, int, int, float, int]]:
        """Return where a reaction enters the equations: body, axis, kind (axis or TURN), factor, node of action."""
        sides = (reaction.plus, 1.0, reaction.node), (reaction.minus, -1.0, reaction.other)
        found = [
            (body, axis, TURN if reaction.kind == COUPLE else axis, sense, node)
            for body, sense, node in sides if body != NONE
            for axis in self.axes(reaction, body, node)
        ]  # fmt: skip
        turned = [(body, factor) for body, factor in reaction.couples if body != NONE]
        found += [(body, MOMENT, TURN, factor, self.bodies[body].node) for body, factor in turned]
        return found

    @cached_property
    def entered(self) -> tuple[tuple[tuple[int, int, int, float, int], ...], ...]:
        """Where each unknown enters the equations."""
        return tuple(tuple(self.entries(reaction)) for reaction in self.reactions)

    @cached_property
    def columns(self) -> tuple[tuple[int, ...], ...]:
        """The equations that each unknown enters."""
        return tuple(
            tuple(dict.fromkeys(self.first_row[body] + axis for body, axis, *_ in own)) for own in self.entered
        )

    @cached_property
    def blocks(self) -> tuple[EquationBlock, ...]:
        """Equations and unknowns in the order of solution."""
        return split(self.equations, self.columns)

    @cached_property
    def scales(self) -> tuple[FloatArray, FloatArray]:
        """Factors (equations,) and (unknowns,) that relate moments and couples to the extent of their own body.

        They are powers of two: scaling is exact.
        """
        members = self.mechanism.members
        extents = [members[body.member].extent if body.member >= 0 else 0.0 for body in self.bodies]
        lengths = [2.0 ** round(math.log2(extent)) if extent > 0.0 else 1.0 for extent in extents]
        rows, columns = np.ones(self.equations), np.ones(len(self.reactions))
        for body, first, length in zip(self.bodies, self.first_row, lengths, strict=True):
            rows[first + 2 :][: int(body.member >= 0)] = 1.0 / length
        for c, reaction in enumerate(self.reactions):
            if reaction.kind == COUPLE:
                columns[c] = max(lengths[body] for body, *_ in self.entered[c])
        return rows, columns

    @cached_property
    def open_pins(self) -> frozenset[int]:
        """Nodes whose reactions can be indeterminate: self-stresses of redundant constraints may act there."""
        loose: set[int] = set()
        for block in self.blocks:
            rows = set(block.rows)
            if len(block.columns) > len(block.rows) or any(rows & set(self.columns[c]) for c in loose):
                loose.update(block.columns)
        attached = {n for k in loose if self.reactions[k].on_pin for n, _ in self.reactions[k].ends}
        held = {pin.node for pin in self.pins if not loose.isdisjoint(chain(*pin.unknowns.values()))}
        return frozenset(pin.node for pin in self.pins if pin.node in attached | held)

    def _add(self, reaction: Reaction) -> int:
        self.reactions.append(reaction)
        return len(self.reactions) - 1

    def _pin(self, node: int, members: tuple[int, ...]) -> int:
        """Add the unknowns of a node; return the first."""
        start, vectors = len(self.reactions), (Vector(1.0 + 0.0j), Vector(1.0j))
        first, *others = (self.body_of_member[member] for member in members)
        self.reactions += [Reaction(PUSH, body, first, node, node, one) for body in others for one in vectors]
        return start

    def _row(self, row: PairRow) -> Reaction:
        """Return the reaction of a constraint or an input: a couple, a force between nodes, or one on a guide."""
        body = self.body_of_member
        if row.rotary:
            return Reaction(COUPLE, body[row.members[0]], body[row.guide])
        if row.kind == HEIGHT:
            vector = carried_direction(self.mechanism, row.guide, row.normal)
            near = (p for p in sliding_pairs(self.mechanism) if row.node in p.nodes and row.guide == p.bodies[0])
            pair = next(near, None)
            on_pin = pair is None or pair.kind != PRISMATIC  # else on the sliding member
            plus = self.body_of_pin[row.node] if pair is None or on_pin else body[pair.bodies[1]]
            return Reaction(PUSH, plus, body[row.guide], row.node, row.node, vector, on_pin=on_pin)
        first, second = row.nodes
        vector = Vector(1.0 + 0.0j, first, second)
        plus, minus = self.body_of_pin[second], self.body_of_pin[first]
        return Reaction(ALONG, plus, minus, second, first, vector, on_pin=True)

    def _moment_node(self, member: int) -> int:
        """Return the node of a member at which most unknowns act; they have no moment about it."""
        body = self.body_of_member[member]
        count = dict.fromkeys(self.mechanism.members[member].nodes, 0)
        for reaction in self.reactions:
            for side, node in ((reaction.plus, reaction.node), (reaction.minus, reaction.other)):
                if side == body and node in count:
                    count[node] += 1
        return max(count, key=lambda node: count[node])


@derived
def statics(mechanism: Mechanism) -> Statics:
    """Return the unknown reactions of a mechanism and the bodies that they act on."""
    return Statics(mechanism)


def direction(reaction: Reaction, z: Any) -> Any:
    """Return the direction of a reaction (rows,) at positions z (nodes, rows)."""
    vector = reaction.vector
    if vector.u == NONE:
        return np.broadcast_to(scalar(vector.z), np.shape(z[0])) if np.ndim(z[0]) else scalar(vector.z)
    found = (z[vector.v] - z[vector.u]) * scalar(vector.z)
    if reaction.kind != ALONG:
        return found
    with np.errstate(divide="ignore", invalid="ignore"):  # rows without a position become NaN
        return found / abs(found)


LEAST = 1e-12
"""Part k of a belt force below which it is 0: the wheels are of equal size."""


def gear_reaction(mechanism: Mechanism, gear: GearPair, body: Mapping[int, int]) -> Reaction:
    """Return what a unit of F of a gear exerts (see `gear_reactions`); `body` has the numbers of members' bodies."""
    (one, two), ratio = (body[k] for k in gear.members), gear.ratio
    if gear.kind == RACK:
        along = carried_direction(mechanism, mechanism.pairs[gear.slide].guide, rack_direction(mechanism, gear))
        return Reaction(PUSH, two, one, gear.pivots[0], gear.pivots[0], along, _couples((two, ratio), (one, -ratio)))
    if gear.radii is None:
        couples = _couples((two, 1.0), (one, -ratio), (body[gear.carrier], -(1.0 - ratio)))
        return Reaction(COUPLE, NONE, NONE, couples=couples)
    part, apart = across_part(mechanism, gear)
    couples = _couples((two, gear.radii[1]), (one, -ratio * gear.radii[1]))
    if abs(part) <= LEAST:
        return Reaction(COUPLE, NONE, NONE, couples=couples)
    return Reaction(PUSH, two, one, gear.pivots[1], gear.pivots[0], Vector(1j * part / apart, *gear.pivots), couples)


def _couples(*each: tuple[int, float]) -> tuple[tuple[int, float], ...]:
    return tuple((own, factor) for own, factor in each if factor != 0.0)


def across_part(mechanism: Mechanism, gear: GearPair) -> tuple[float, float]:
    """Return k, the part of a tooth or belt force across the line of the pivots, and the distance of the pivots."""
    one, other = (mechanism.members[gear.carrier].local(node) for node in gear.pivots)
    apart = float(abs(other - one))
    return -(1.0 - gear.ratio) * (gear.radii[1] if gear.radii else 0.0) / apart, apart


def rack_direction(mechanism: Mechanism, gear: GearPair) -> complex:
    """Return the direction in which a rack moves when its travel increases, in the own frame of the guide."""
    slide = mechanism.pairs[gear.slide]
    return slide.along if slide.guide == gear.carrier else -slide.along
