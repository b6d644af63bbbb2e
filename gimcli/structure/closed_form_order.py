"""The nodes that are placed so far, and the nodes that can be placed next in closed form.

A member with two placed nodes, or with a known direction and one placed node, carries its other nodes. A guide with
one placed node and a placed node that slides on it has a known direction. A node with two loci is placed by a dyad.
"""

from __future__ import annotations

import cmath
from collections.abc import Iterator, Sequence

from gimcli.calculus.numbers import nominal, scalar
from gimcli.connected import grouped
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, Mechanism, PairRow
from gimcli.structure.kinematic_nodes import kinematic_nodes, loose_nodes
from gimcli.structure.pair_rows import ImposedRow, pair_rows
from gimcli.structure.rotation import Rotation, members_of, rotation_classes
from gimcli.structure.steps import NONE, Constraint, Dyad, Orient, Place, Step, Tilt, Value, Vector

GOOD_CROSSING = 0.2
"""Sine of the angle between two loci above which a dyad is accepted without comparing it with others."""


class Directions:
    """The nodes that are placed, and the members whose directions are known: by rotation classes, as vectors."""

    mechanism: Mechanism
    kinematic: tuple[tuple[int, ...], ...]
    placed: set[int]
    rotation: Rotation
    direction: dict[int, Vector]  # e^(i phi) of a rotation class

    def is_turned(self, member: int) -> bool:
        """Return whether the direction of a member is known."""
        return self.rotation.of[member] in self.direction

    def source(self, member: int) -> Vector | None:
        """Return e^(i phi) of a member as a vector; None while its direction is unknown."""
        known = self.direction.get(self.rotation.of[member])
        return known.times(self.rotation.phase[member]) if known is not None else None

    def anchor(self, member: int) -> int | None:
        """Return a placed node of a member; None if it has none."""
        return next((n for n in self.kinematic[member] if n in self.placed), None)

    def span(self, member: int) -> tuple[int, int, complex] | None:
        """Return the first two placed nodes of a member and the vector between them in its own frame; None without."""
        u, v, *_ = (*(n for n in self.kinematic[member] if n in self.placed), NONE, NONE)
        return None if v == NONE else (u, v, self.mechanism.members[member].reach(u, v))

    def carried(self, member: int, nodes: Sequence[int]) -> Iterator[Place]:
        """Yield the places of nodes of a member from its placed one; none while its direction is unknown."""
        source, anchor = self.source(member), self.anchor(member)
        for node in nodes:
            if source is not None and anchor is not None and node != anchor:
                yield Place(node, anchor, source.times(self.mechanism.members[member].reach(anchor, node)))

    def line(self, row: ImposedRow, moved: int, offset: Vector | None = None) -> Constraint | None:
        """Return the height of a node over a line of a member of known direction, which has a placed node."""
        source, anchor = self.source(row.guide), self.anchor(row.guide)
        if source is None or anchor is None:
            return None
        value = row.value.plus(row.height(self.mechanism.members[row.guide].local(anchor)))
        return Constraint(row.name, HEIGHT, moved, anchor, value, source.times(row.normal), offset)

    def turned_by(self, row: ImposedRow) -> Iterator[tuple[int, int, Vector, tuple[complex, int, int]]]:
        """Yield the member that an angle turns, the other, its direction, and factor, actuator, sense of the turn."""
        (arm, reference), number = row.members, row.value.actuator
        ratio = row.reference / row.arm
        for free, known, factor, sense in ((arm, reference, ratio, 1), (reference, arm, 1.0 / ratio, -1)):
            source = None if self.is_turned(free) else self.source(known)
            if source is not None:
                yield free, known, source, (factor, number, sense)


class Layout(Directions):
    """A plan under construction: the placed nodes, the known directions and the steps so far."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.members = members_of(mechanism)
        self.kinematic = kinematic_nodes(mechanism)
        self.rotation = rotation_classes(mechanism)
        self.free_points = loose_nodes(mechanism)
        self.placed: set[int] = set()
        self.direction = {self.rotation.of[FRAME]: Vector(1.0 / self.rotation.phase[FRAME])}
        self.steps: list[Step] = []
        self.registers = 0
        self.branches = 0
        rows = [row for row in pair_rows(mechanism) if row.kind != ANGLE and not row.implied]
        self.rows_at = grouped((node, row) for row in rows for node in row.nodes)
        self.rows_on = grouped((member, row) for row in rows for member in row.members)
        # candidates for the next step: only neighbours of newly placed nodes
        free = dict.fromkeys(n for nodes in (*self.kinematic, self.free_points) for n in nodes)
        self.rank = {node: k for k, node in enumerate(free)}
        self.missing = set(free)
        self.near: set[int] = set()  # free nodes that may have loci
        self.turnable: set[int] = set()  # members whose direction may be known now
        self.carriable: set[int] = set()  # members that may carry nodes now
        self.tiltable: set[int] = set()  # slides whose guide may have a known direction now
        self.drives = [row for row in pair_rows(self.mechanism) if row.kind == ANGLE and not row.implied]
        self.tied = grouped((group, index) for index, group in enumerate(self.rotation.of))
        self.slides_at = grouped((slide.node, number) for number, slide in enumerate(self.mechanism.slides))
        self.slides_on = grouped((slide.guide, number) for number, slide in enumerate(self.mechanism.slides))
        for node in self.mechanism.members[FRAME].nodes:
            self.mark_placed(node)
        for member in self.tied[self.rotation.of[FRAME]]:
            self._review_member(member)

    # -- candidates for the next step ---------------------------------------------------------

    def mark_placed(self, node: int) -> None:
        """Record that a node is placed, and which members, slides and nodes this may affect."""
        self.placed.add(node)
        self.missing.discard(node)
        self.near.discard(node)
        for member in self.members[node]:
            if member != FRAME:
                self._review_member(member)
        self.tiltable.update(self.slides_at.get(node, ()))
        for row in self.rows_at.get(node, ()):
            for other in (*row.nodes, *(n for member in row.members for n in self.kinematic[member])):
                self._review_node(other)

    def _review_member(self, member: int) -> None:
        """Record that a member has a newly placed node or a newly known direction."""
        self.turnable.add(member)
        self.carriable.add(member)
        self.tiltable.update(self.slides_on.get(member, ()))
        for row in self.rows_on.get(member, ()):
            self._review_node(row.node)
        for node in self.kinematic[member]:
            if node not in self.placed:
                self._review_node(node)
                self.tiltable.update(self.slides_at.get(node, ()))

    def _review_node(self, node: int) -> None:
        """Record that a node may have a new locus, as may the other nodes of a translating member with this node."""
        if node in self.missing:
            self.near.add(node)
            for member in self.members[node]:
                if self.is_turned(member):
                    self.near.update(n for n in self.kinematic[member] if n in self.missing)

    # -- steps ----------------------------------------------------------------------

    def place(self, step: Place) -> None:
        """Add a step that places a carried node."""
        self.steps.append(step)
        self.mark_placed(step.node)

    def orient(self, member: int, vector: Vector) -> None:
        """Record e^(i phi) of a member, and with it that of its rotation class."""
        group = self.rotation.of[member]
        self.direction[group] = vector.times(1.0 / self.rotation.phase[member])
        for tied in self.tied[group]:
            self._review_member(tied)

    def register(self) -> int:
        """Return a new register for a direction."""
        self.registers += 1
        return self.registers - 1

    def branch(self) -> int:
        """Return the branch number for a new step with two solutions."""
        self.branches += 1
        return self.branches - 1

    # -- closed forms -----------------------------------------------------------------

    def carry(self) -> bool:
        """Carry directions and nodes along members; return whether any direction or node was added."""
        changed = False
        while self._turn_members() | self._carry_nodes():
            changed = True
        return changed

    def _turn_members(self) -> bool:
        changed = False
        members, self.turnable = sorted(self.turnable), set()
        for index in members:
            span = None if index == FRAME or self.is_turned(index) else self.span(index)
            if span is not None:
                self.orient(index, Vector(1.0 / span[2], *span[:2]))
                changed = True
        for row in self.drives.copy():
            for free, _, known, turn in self.turned_by(row):
                self.drives.remove(row)
                vector = known.driven(*turn)
                if vector is None:  # a vector has one actuator only: store the direction in a register
                    register = self.register()
                    self.steps.append(Orient(register, known))
                    vector = Vector(turn[0], register=register, actuator=turn[1], turn=turn[2])
                self.orient(free, vector)
                changed = True
        return changed

    def _carry_nodes(self) -> bool:
        """Carry nodes along the members in order; those that become able to carry nodes join in if they come later."""
        changed, index = False, FRAME
        while (index := min((k for k in self.carriable if k > index), default=NONE)) != NONE:
            self.carriable.remove(index)
            for step in self.carried(index, [n for n in self.kinematic[index] if n not in self.placed]):
                self.place(step)
                changed = True
        return changed

    def tilt(self) -> bool:
        """Determine the direction of one guide from a placed node that slides on it; return whether there was one."""
        for number in sorted(self.tiltable):
            slide = self.mechanism.slides[number]
            found = self._tiltable(slide)
            if found is None:
                self.tiltable.discard(number)
                continue
            a, b, e = found
            register = self.register()
            guide = self.mechanism.members[slide.guide]
            along = Vector(slide.along / scalar(guide.shape[1] - guide.shape[0]), *guide.nodes[:2])
            self.steps.append(Tilt(register, a, b, e, along, self.branch()))
            self.orient(slide.guide, Vector(1.0 / slide.along, register=register))
            return True
        return False

    def _tiltable(self, slide: PairRow) -> tuple[int, int, float] | None:
        if self.is_turned(slide.guide):
            return None
        a = self.anchor(slide.guide)
        if a is None:
            return None
        e = slide.height(self.mechanism.members[slide.guide].local(a))
        if slide.node in self.placed:
            return a, slide.node, e
        group = self.rotation.of[slide.guide]
        for body in self.members[slide.node]:
            b = self.anchor(body)
            if self.rotation.of[body] == group and b is not None:
                turn = self.rotation.phase[body] / self.rotation.phase[slide.guide]
                reach = self.mechanism.members[body].reach(b, slide.node) * turn
                return a, b, e - (slide.normal.conjugate() * reach).real
        return None

    def dyad(self, good: float = GOOD_CROSSING) -> bool:
        """Place one node at the intersection of two loci; return whether there was one.

        The first pair of loci whose crossing angle has a sine above `good` is used, else the pair with the greatest.
        """
        best: tuple[float, Constraint, Constraint] | None = None
        for node in sorted(self.near, key=self.rank.__getitem__):
            loci = list(self.loci(node))
            for i in range(len(loci)):
                for j in range(i):
                    score = self._crossing(loci[j], loci[i])
                    if score >= 0.0 and (best is None or score > best[0]):
                        best = (score, loci[j], loci[i])
            if best is not None and best[0] > good:
                break
        if best is None:
            return False
        _, first, second = best
        both_lines = first.kind == second.kind == HEIGHT
        self.steps.append(Dyad(first.p, first, second, NONE if both_lines else self.branch()))
        self.mark_placed(first.p)
        return True

    def loci(self, node: int) -> Iterator[Constraint]:
        """Yield the loci of a free node relative to the placed nodes, one for each constraint."""
        yield from self.own_loci(node, node, None)
        for body in self.members[node]:
            source = self.source(body)
            if source is None:
                continue
            for other in self.kinematic[body]:  # a translating member shifts the loci of its other nodes
                if other != node:
                    offset = source.times(self.mechanism.members[body].reach(other, node))
                    yield from self.own_loci(other, node, offset)
            yield from self._carried_lines(node, body, source)

    def own_loci(self, node: int, moved: int, offset: Vector | None) -> Iterator[Constraint]:
        """Yield the loci of a node from its members of unknown direction and from the rows of its pairs.

        They are those of the node `moved`, which is offset from it.
        """
        mechanism = self.mechanism
        for body in self.members[node]:
            centre = self.anchor(body)
            if centre is not None and not self.is_turned(body):
                radius = abs(self.mechanism.members[body].reach(centre, node))
                yield Constraint(mechanism.members[body].name, SPAN, moved, centre, Value(radius), offset=offset)
        for row in self.rows_at.get(node, []):
            locus = self.line(row, moved, offset) if row.kind == HEIGHT else self._span(row, node, moved, offset)
            if locus is not None:
                yield locus

    def _span(self, row: ImposedRow, node: int, moved: int, offset: Vector | None) -> Constraint | None:
        other = next(n for n in row.nodes if n != node)
        return Constraint(row.name, SPAN, moved, other, row.value, offset=offset) if other in self.placed else None

    def _carried_lines(self, node: int, body: int, source: Vector) -> Iterator[Constraint]:
        """Yield the loci of a node of a translating member from placed nodes that slide on its lines."""
        for row in self.rows_on.get(body, []):
            if row.node in self.placed:
                height = row.height(self.mechanism.members[body].local(node))
                value = Value(-height, row.value.actuator, -row.value.gain)
                yield Constraint(row.name, HEIGHT, node, row.node, value, source.times(row.normal))

    def _crossing(self, first: Constraint, second: Constraint) -> float:
        """Return the sine of the angle between two loci as drawn; -1 for one constraint or one centre twice."""
        circles = first.kind == second.kind == SPAN
        if first.name == second.name or (circles and (first.q, first.offset) == (second.q, second.offset)):
            return -1.0
        n, m = (self._normal(locus) for locus in (first, second))
        return abs((n.conjugate() * m).imag) / max(abs(n) * abs(m), 1e-300)

    def _normal(self, locus: Constraint) -> complex:
        drawn = self.mechanism.drawn
        if locus.vector is not None:
            return self.drawn_vector(locus.vector)
        radius = complex(nominal(drawn[locus.p] - drawn[locus.q]))
        return radius - self.drawn_vector(locus.offset) if locus.offset else radius

    def drawn_vector(self, vector: Vector) -> complex:
        """Return a vector at the drawn position; a register counts as direction 1."""
        drawn = self.mechanism.drawn
        base = complex(nominal(drawn[vector.v] - drawn[vector.u])) if vector.u != NONE else 1.0 + 0.0j
        if vector.actuator != NONE:
            base *= cmath.exp(1j * vector.turn * nominal(self.mechanism.actuators[vector.actuator].drawn))
        return complex(nominal(vector.z)) * base
