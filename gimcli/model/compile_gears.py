"""Compiler of gears, belts, and racks with pinions: the inputs that follow from them.

Angles of members and travels of racks are unknowns x. Rotary actuators, pairs without relative rotation and gears give
linear equations between them and the inputs u of the actuators. The quantities that the gears determine become inputs
that follow the others: each gear adds one, if other gears do not imply it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from gimcli.calculus.numbers import nominal, phase, scalar
from gimcli.coupling_data import CROSSED, EXTERNAL, INTERNAL, NO_PIVOT, RACK, GearPair
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, Coupling, Input, Member, PairRow
from gimcli.model import schema
from gimcli.model.compile_geometry import GeometryCompiler
from gimcli.model.linear_relations import Relation, Relations, coupling_to
from gimcli.model.pairs import having
from gimcli.model.source import PlacedError


def structural_rank(members: Sequence[Member], rows: Sequence[PairRow]) -> int:
    """Return the greatest number of coordinates that members, pairs and inputs (`rows`) can determine together."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import structural_rank as rank_of

    equations = list(_equations(members, rows))
    free = sorted({n for nodes in equations for n in nodes}.difference(members[FRAME].nodes))
    table = np.array([[n in nodes for n in free for _ in range(2)] for nodes in equations], dtype=bool)
    return int(rank_of(csr_array(table))) if table.size else 0


def _equations(members: Sequence[Member], rows: Sequence[PairRow]) -> Iterator[list[int]]:
    """Yield the nodes in each equation."""
    for member in members[FRAME + 1 :]:
        first, far, _ = member.ends
        yield [first, far]
        for node in member.nodes:
            if node not in (first, far):
                yield from [[first, far, node]] * 2
    for row in rows:
        guides = [n for k in row.members if k != FRAME for n in members[k].ends[:2]]
        yield guides if row.kind == ANGLE else [*row.nodes, *guides]


OPPOSITE = (EXTERNAL, CROSSED)
"""Types whose wheels turn in opposite senses."""
PRESSURE_ANGLE = math.radians(20.0)
"""Of standard involute teeth (ISO 53)."""

MOST = 1000
"""Numbers that a name may be given."""

Unknown = tuple[str, int | str]
"""The angle of a member (number), or the travel of the rack of a gear (name)."""


class Candidate(NamedTuple):
    """A quantity that may follow the inputs: a combination of unknowns, and how it is measured."""

    row: Relation
    gear: GearPair
    members: tuple[int, int] | None  # of an angle; None: the travel of the gear's rack
    second: bool | None = None  # whether it is the second quantity of the gear, or the first; None: neither


class GearCompiler:
    """Compiles the gears of a validated model after its actuators."""

    def __init__(
        self, own: GeometryCompiler, pairs: Sequence[PairRow], actuators: Sequence[Input], couplings: Sequence[Coupling]
    ) -> None:
        self.own, self.model, self.pairs = own, own.model, pairs
        self.actuators, self.couplings = list(actuators), list(couplings)
        self.number = own.number
        self.travels: dict[str, Input] = {}
        self.gears = [self._gear(name, part) for name, part in self.model.gears.items()]

    def compile(self) -> tuple[tuple[Input, ...], tuple[Coupling, ...], tuple[GearPair, ...]]:
        """Return all actuators, all couplings, and the gears.

        Raises ModelError if gears and actuators contradict each other.
        """
        known = Relations(self._driven())
        every = Relations(known.rows)
        for gear in self.gears:
            first, second = self._quantities(gear)
            if not every.add(second.minus(first, gear.ratio)) and every.contradicted:
                raise PlacedError(
                    ("gears", gear.name),
                    f"gears: '{gear.name}' contradicts the other gears and actuators: the mechanism is locked; remove"
                    " an actuator or a gear, or correct a ratio",
                )
        while open_ones := [g for g in self.gears if not all(map(known.determines, self._quantities(g)))]:
            candidates = [c for gear in open_ones for c in self._candidates(gear) if not known.determines(c.row)]
            candidates.sort(key=lambda c: any(c.gear.name == one.name for one in self.actuators))  # each gear in turn
            candidate = next((c for c in candidates if every.determines(c.row)), None)
            if candidate is not None:
                self._follow(candidate, every.value(candidate.row), [])
            else:
                candidate, other = self._linked(open_ones, candidates)
                ratio = candidate.gear.ratio if candidate.second else 1.0 / candidate.gear.ratio
                every.add(Relation(candidate.row.unknowns, {len(self.actuators): 1.0}))
                self._follow(candidate, {}, [(self._input(other), ratio)])
                known.add(other.row)
            known.add(candidate.row)
        return tuple(self.actuators), tuple(self.couplings), tuple(self.gears)

    # -- one gear -------------------------------------------------------------------------------

    def _gear(self, name: str, part: schema.Gear) -> GearPair:
        first, second = (self.number[member] for member in part.members)
        carrier, pivots = self.number[carrier_of(self.model, part)], [self.own.index[n] for n in part.pivots]
        angle = PRESSURE_ANGLE if part.pressure_angle is None else part.pressure_angle * self.own.units[True]
        if part.type == RACK:
            return self._rack(name, part, angle)
        given = part.teeth or part.radii
        ratio: Any = part.ratio if given is None else given[0] / given[1]  # without its sense
        return GearPair(
            name, part.type, (first, second), carrier, (pivots[0], pivots[1]),
            -ratio if part.type in OPPOSITE else ratio, self._radii(part, carrier, pivots, ratio), angle,
        )  # fmt: skip

    def _radii(self, part: schema.Gear, carrier: int, pivots: Sequence[int], ratio: Any) -> tuple[Any, Any] | None:
        """Return the pitch radii: those of teeth follow from the distance of the pivots, which the carrier fixes."""
        member = self.own.members[carrier]
        apart = abs(scalar(member.local(pivots[1]) - member.local(pivots[0])))
        if part.type == EXTERNAL:
            return apart * ratio / (1.0 + ratio), apart / (1.0 + ratio)
        if part.type == INTERNAL:
            second = apart / abs(1.0 - ratio)
            return ratio * second, second
        if part.radii is not None:
            return part.radii[0] / self.own.scale, part.radii[1] / self.own.scale
        if part.teeth is not None and part.pitch is not None:
            factor = part.pitch / (2.0 * math.pi * self.own.scale)
            return part.teeth[0] * factor, part.teeth[1] * factor
        return None

    def _rack(self, name: str, part: schema.Gear, angle: Any) -> GearPair:
        pair = rack_pair(self.model, part)
        assert pair is not None  # checked
        slide = self.model.prismatic[pair]
        nodes = slide.nodes or []
        travel = self.own.quantity(name, schema.Gauge(node=nodes[0], guide=slide.guide))
        guide, carrier = travel.guide, self.number[carrier_of(self.model, part)]
        line = "ground" if guide == FRAME else self.own.members[guide].name
        start = self.own.carried(line, self.model.nodes[nodes[0]])
        self.travels[name] = replace(travel, point=start, drawn=0.0)  # not from a guide's node, which may be far
        pivot = self.own.index[part.pivots[0]]
        radius = (part.radii or [0.0])[0] / self.own.scale
        side = 1.0 if nominal(rack_height(self.model, part, slide)) > 0.0 else -1.0
        ratio = -side * radius if guide == carrier else side * radius
        first = next(n for n, row in enumerate(self.pairs) if row.pair == pair)
        members = (self.number[part.members[0]], self.number[part.members[1]])
        return GearPair(name, RACK, members, carrier, (pivot, NO_PIVOT), ratio, (radius, 0.0), angle, first)

    # -- relations ---------------------------------------------------------------------------------

    def _driven(self) -> Iterator[Relation]:
        """Yield the relations without gears: of rotary actuators, of pairs, and of travels that actuators drive."""
        for k, one in enumerate(self.actuators):
            if one.kind == ANGLE:
                yield _relative(one.members[0], one.guide, {k: 1.0})
            elif one.kind == HEIGHT:
                yield from self._driven_travels(k, one)
        for pair in self.model.prismatic.values():
            body, guide = sliding_members(self.model, pair)
            if body is not None and guide is not None:
                yield _relative(self.number[body], self.number[guide], {})

    def _driven_travels(self, k: int, one: Input) -> Iterator[Relation]:
        for name, travel in self.travels.items():
            along = scalar(one.normal.conjugate() * travel.normal)
            joined = any({one.node, travel.node} <= set(member.nodes) for member in self.own.members)
            if one.members == travel.members and abs(along.imag) < PARALLEL and joined:
                yield Relation({("rack", name): 1.0}, {k: math.copysign(1.0, nominal(along.real))})

    def _linked(self, gears: Sequence[GearPair], candidates: Sequence[Candidate]) -> tuple[Candidate, Candidate]:
        """Return a quantity that can follow one that the linkage moves, and that one; raise ModelError if none can."""
        members, rows = self.own.members, [*self.pairs, *self.actuators]
        rank = structural_rank(members, rows)
        for candidate in candidates:
            own = [c for c in self._candidates(candidate.gear) if c.second is not None]
            others = [c for c in own if c.second is not candidate.second]
            if candidate in own and others and structural_rank(members, [*rows, self._input(candidate)]) > rank:
                return candidate, others[0]
        one, other = (members[m].name for m in gears[0].members)
        text = f"gears: '{gears[0].name}' couples '{one}' and '{other}', which the rest of the mechanism moves already,"
        raise PlacedError(("gears", gears[0].name), f"{text} or which nothing moves; remove or add an actuator")

    def _quantities(self, gear: GearPair) -> tuple[Relation, Relation]:
        """Return the first and the second quantity of a gear."""
        first = _relative(gear.members[0], gear.carrier, {})
        if gear.kind == RACK:
            return first, Relation({("rack", gear.name): 1.0}, {})
        return first, _relative(gear.members[1], gear.carrier, {})

    def _candidates(self, gear: GearPair) -> Iterator[Candidate]:
        """Yield the second and the first quantity of a gear, then the absolute angles of its members."""
        quantities = self._quantities(gear)
        for k in (1, 0):
            if gear.kind == RACK and k == 1:
                yield Candidate(quantities[1], gear, None, True)
            elif gear.members[k] != FRAME:
                yield Candidate(quantities[k], gear, (gear.members[k], gear.carrier), k == 1)
        for member in (gear.carrier, *gear.members):
            if member != FRAME:
                yield Candidate(_relative(member, FRAME, {}), gear, (member, FRAME))

    def _follow(self, candidate: Candidate, ratios: dict[int, Any], reads: list[tuple[Input, Any]]) -> None:
        """Add a quantity as an actuator that follows inputs and quantities that are read, each with its ratio."""
        one, gear = self._input(candidate), candidate.gear
        taken = {other.name for other in self.actuators}
        name = next(n for n in (gear.name, *(f"{gear.name} {k}" for k in range(2, MOST))) if n not in taken)
        value, followed = one.drawn, {coupling.follower: coupling for coupling in self.couplings}
        for row, ratio in reads:  # it is as drawn where its leaders are
            value = value - ratio * row.drawn
        leaders = {k: (ratio, self.actuators[k].drawn) for k, ratio in ratios.items()}
        self.couplings.append(coupling_to(len(self.actuators), value, leaders, followed, reads, geared=True))
        self.actuators.append(replace(one, name=name))

    def _input(self, candidate: Candidate) -> Input:
        """Return the quantity as an input."""
        gear = candidate.gear
        if candidate.members is None:
            return self.travels[gear.name]
        arm, reference = candidate.members
        pivot = gear.pivots[gear.members.index(arm)] if arm in gear.members else gear.pivots[0]
        pivot = gear.pivots[0] if pivot == NO_PIVOT else pivot
        (own, ray), (other, base) = (self._direction(member, pivot) for member in (arm, reference))
        drawn = phase(ray / base + 0.0j)
        return Input(gear.name, ANGLE, (pivot,), (arm, reference), arm=own, reference=other, drawn=drawn)

    def _direction(self, number: int, pivot: int) -> tuple[complex, complex]:
        """Return the direction from the pivot to the farthest node of a member, in its own frame and as drawn."""
        member, drawn = self.own.members[number], self.own.drawn
        if number == FRAME:
            return 1.0 + 0.0j, 1.0 + 0.0j
        start = pivot if pivot in member.nodes else member.nodes[0]
        far = max(member.nodes, key=lambda n: nominal(abs(scalar(member.local(n) - member.local(start)))))
        own, ray = scalar(member.local(far) - member.local(start)), scalar(drawn[far] - drawn[start])
        return own / abs(own), ray / abs(ray)


PARALLEL = 1e-9
"""Sine of the angle below which two guides are parallel."""


def _relative(member: int, reference: int, inputs: dict[int, Any]) -> Relation:
    """Return the relation: angle of a member minus that of another = inputs."""
    signs = ((member, 1.0), (reference, -1.0))
    return Relation({("angle", number): sign for number, sign in signs if number != FRAME}, inputs)


def carrier_of(model: schema.Model, part: schema.Gear) -> str:
    """Return the member on which both wheels of a gear turn: the given one, the ground, or that with both pivots."""
    if part.carrier is not None:
        return "ground" if part.carrier == model.ground.member else part.carrier
    return next((name for name in having(model, part.pivots) if name == "ground" or name not in part.members), "")


def sliding_members(model: schema.Model, pair: schema.Prismatic) -> tuple[str | None, str | None]:
    """Return the sliding member and the guide of a prismatic pair without relative rotation."""
    if pair.nodes is None:
        return None, None
    guide = next(having(model, pair.guide), None)
    return next((name for name in having(model, pair.nodes) if name != guide), None), guide


def rack_pair(model: schema.Model, part: schema.Gear) -> str | None:
    """Return the sliding pair between the rack and the carrier of a gear."""
    wanted = {part.members[1], carrier_of(model, part)}
    pairs = ((name, sliding_members(model, pair)) for name, pair in model.prismatic.items())
    return next((name for name, both in pairs if set(both) == wanted), None)


def rack_height(model: schema.Model, part: schema.Gear, slide: schema.Prismatic) -> Any:
    """Return the height of the line of the rack over the pinion's pivot, to the left of the guide's direction."""
    on_rack = slide.sliding if sliding_members(model, slide)[0] == part.members[1] else slide.guide
    names = (*slide.guide, part.pivots[0], on_rack[0])
    first, second, pivot, place = (complex(*map(float, map(nominal, model.nodes[n]))) for n in names)
    return ((second - first).conjugate() / abs(second - first) * (place - pivot)).imag
