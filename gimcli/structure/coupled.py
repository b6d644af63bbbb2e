"""Strongly coupled Assur groups: the members that are solved together, and their unknowns.

To find a group, the unknowns are x and y of every member that is not placed yet and one angle for each rotation class;
the equations are pairs, slides and actuators. A matching directs the dependencies; the strongly connected components
that depend on no others are the next groups (Servatius, Shai & Whiteley 2010). To solve a group, the unknowns are the
coordinates of a few base nodes; all its other nodes are carried and linear in them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from gimcli.errors import StructureError
from gimcli.mechanism import ANGLE, CLOSURE, HEIGHT, SPAN, Mechanism
from gimcli.structure.closed_form_order import Directions, Layout
from gimcli.structure.dulmage_mendelsohn import components, join, match, reached
from gimcli.structure.pair_rows import ImposedRow, pair_rows
from gimcli.structure.steps import NONE, Constraint, Coupled, Place, Value, Vector

Unknown = tuple[str, int]
"""("x", body), ("y", body) or ("t", rotation class). A body is a member, or -1 - n for a loose node n."""


class CoupledSystem:
    """The unknowns of the bodies that are not placed yet, and those in each equation of a pair, slide or actuator."""

    def __init__(self, layout: Layout) -> None:
        self.layout, self.rows, self.bodies = layout, list[list[Unknown]](), dict[int, list[Unknown]]()
        for index in range(1, len(layout.mechanism.members)):
            turn: list[Unknown] = [("t", layout.rotation.of[index])] if layout.source(index) is None else []
            if turn or layout.anchor(index) is None:
                self.bodies[index] = [("x", index), ("y", index), *turn]
        for node in layout.free_points:
            if node not in layout.placed:
                self.bodies[-1 - node] = [("x", -1 - node), ("y", -1 - node)]
        for node in range(len(layout.mechanism.nodes)):
            self._join(node)
        for row in (row for row in pair_rows(layout.mechanism) if not row.implied):
            nodes = [n for n in row.nodes if row.kind != ANGLE and n not in layout.placed]
            parts = [own for n in nodes for own in self._at(n)[:1]] + [self.bodies.get(m, []) for m in row.members]
            self._add([u for own in parts for u in own if row.kind != ANGLE or u[0] == "t"])

    def _add(self, unknowns: list[Unknown]) -> None:
        """Add an equation, unless it has no unknowns (such an equation is only checked, with the residual)."""
        if unknowns:
            self.rows.append(list(dict.fromkeys(unknowns)))

    def _at(self, node: int) -> list[list[Unknown]]:
        """Return the unknowns of each body at a node."""
        members = [m for m in self.layout.members[node] if node in self.layout.kinematic[m]]
        return [self.bodies[body] for body in (*members, -1 - node) if body in self.bodies]

    def _join(self, node: int) -> None:
        """Add the equations of the revolute pairs at a node."""
        parts = self._at(node)
        for pair in ((part,) for part in parts) if node in self.layout.placed else pairwise(parts):
            for axis in ("x", "y"):
                self._add([u for part in pair for u in part if u[0] in (axis, "t")])


def next_group(layout: Layout) -> None:
    """Find the next coupled group, add its step to the plan, and mark its nodes as placed."""
    builder = Builder(layout, _first_group(layout, CoupledSystem(layout)))
    layout.steps.append(builder.build())
    for node in sorted(builder.placed - layout.placed):
        layout.mark_placed(node)
    layout.carry()


def _first_group(layout: Layout, system: CoupledSystem) -> list[int]:
    """Return the bodies of the smallest group that depends on no other."""
    unknowns = list(dict.fromkeys(u for body in system.bodies.values() for u in body))
    column = {u: k for k, u in enumerate(unknowns)}
    rows = [sorted(column[u] for u in row) for row in system.rows]
    matched = match(len(unknowns), rows)
    if len(set(matched) - {NONE}) < len(unknowns):
        raise undriven(layout, _reachable_bodies(system, unknowns, rows, matched))
    needs: list[list[int]] = [[] for _ in unknowns]
    for row, own in zip(rows, matched, strict=True):
        if own != NONE:
            needs[own] += row
    whole = [[column[u] for u in body] for body in system.bodies.values()]  # keeps the unknowns of a body together
    row_of = {own: row for row, own in enumerate(matched) if own != NONE}
    # redundant equations stay in the group of the equations that they depend on
    surplus = [reached(rows, row_of, k) for k, own in enumerate(matched) if own == NONE]
    join(needs, [*whole, *surplus])
    leaves = [part for part in map(set, components(needs)) if all(part.issuperset(needs[k]) for k in part)]
    return min(([b for b, body in system.bodies.items() if column[body[0]] in part] for part in leaves), key=len)


def _reachable_bodies(
    system: CoupledSystem, unknowns: list[Unknown], rows: list[list[int]], matched: Sequence[int]
) -> list[int]:
    """Return the bodies with unknowns that the equations cannot determine."""
    entered, own = (
        [[i for i, row in enumerate(rows) if c in row] for c in range(len(unknowns))],
        dict(enumerate(matched)),
    )
    open_ones = set(range(len(unknowns))) - set(matched)
    loose = {unknowns[k] for k in open_ones.union(*([own[i] for i in reached(entered, own, c)] for c in open_ones))}
    return [b for b, body in system.bodies.items() if loose & set(body)]


def undriven(layout: Layout, bodies: list[int]) -> StructureError:
    """Return the error that names the undriven members and nodes."""
    mechanism = layout.mechanism
    names = [mechanism.members[b].name if b >= 0 else mechanism.nodes[-1 - b] for b in bodies]
    nodes = [
        mechanism.nodes[n]
        for b in bodies
        for n in (mechanism.members[b].nodes if b >= 0 else (-1 - b,))
        if n not in layout.placed
    ]
    have = len(mechanism.actuators)
    return StructureError(
        f"nothing drives {_and(names)} (nodes {_and(list(dict.fromkeys(nodes)))}): {have}"
        f" actuator{' does' if have == 1 else 's do'} not determine the position; add an actuator or a member that"
        f" fixes {'it' if len(names) == 1 else 'them'} (`gim mobility` shows how many are needed)"
    )


def _and(names: list[str]) -> str:
    shown = names if len(names) <= 8 else [*names[:7], f"{len(names) - 7} more"]
    return ", ".join(shown[:-1]) + " and " + shown[-1] if len(shown) > 1 else "".join(shown)


class Builder(Directions):
    """Selects the base nodes of a group, and collects its carried nodes and equations."""

    def __init__(self, layout: Layout, bodies: list[int]) -> None:
        self.layout = layout
        self.mechanism: Mechanism = layout.mechanism
        self.bodies = [b for b in bodies if b >= 0]
        self.points = [-1 - b for b in bodies if b < 0]
        self.placed = set(layout.placed)
        self.kinematic, self.rotation, self.direction = layout.kinematic, layout.rotation, dict(layout.direction)
        self.base: list[int] = []
        self.places: list[Place] = []
        self.equations: list[Constraint] = []
        self.done: set[int] = set()
        self.used: set[int] = set()
        self.angles = [row for row in pair_rows(self.mechanism) if row.kind == ANGLE and not row.implied]

    def build(self) -> Coupled:
        """Return the group as a step."""
        self._carry()
        nodes = dict.fromkeys([n for b in self.bodies for n in self.kinematic[b]] + self.points)
        while wanted := [n for n in nodes if n not in self.placed]:
            self.base.append(max(wanted, key=self._gain))
            self.placed.add(self.base[-1])
            self._carry()
        self._pairs()
        return Coupled(tuple(self.base), tuple(self.places), tuple(self.equations), tuple(self.bodies))

    def _gain(self, node: int) -> tuple[int, int]:
        """Return the number of nodes that a node would carry as base node, then of its members with a placed node."""
        trial = Builder(self.layout, [])
        trial.bodies, trial.points = self.bodies, self.points
        trial.placed, trial.direction, trial.done = self.placed | {node}, dict(self.direction), set(self.done)
        before = len(trial.placed)
        trial._carry()
        begun = sum(any(n in self.placed for n in self.kinematic[b]) for b in self.layout.members[node])
        return len(trial.placed) - before, begun

    def _carry(self) -> None:
        """Carry directions and nodes along the members, and add the closure equations of loops."""
        changed = True
        while changed:
            changed = self._drives()
            for body in self.bodies:
                if self._turn(body):
                    self._drives()  # before a driven neighbour gets its direction from its own nodes
                    changed = True
                changed |= self._finish(body)

    def _turn(self, body: int) -> bool:
        if self.is_turned(body):
            return False
        span = self.span(body)
        if span is None:
            return False
        u, v, reach = span
        self.direction[self.rotation.of[body]] = Vector(1.0 / (reach * self.rotation.phase[body]), u, v)
        self.equations.append(Constraint(self.mechanism.members[body].name, SPAN, u, v, Value(abs(reach))))
        return True

    def _finish(self, body: int) -> bool:
        """Carry the nodes of a member of known direction; each node that is already placed closes a loop."""
        found, name = [*self.carried(body, self.kinematic[body])], self.mechanism.members[body].name
        if body in self.done or not found:
            return False
        self.done.add(body)
        for step in found:
            node, anchor, vector = step.node, step.anchor, step.vector
            if node not in self.placed:
                self.places.append(step)
                self.placed.add(node)
            elif set(vector.nodes) != {node, anchor} or vector.actuator >= 0:
                self.equations.append(Constraint(name, CLOSURE, node, anchor, Value(0.0), vector))
        return True

    def _drives(self) -> bool:
        changed = False
        for row in self.angles:
            for free, known, source, turn in self.turned_by(row):
                vector = (source.driven(*turn) or self._by_nodes(known, *turn)) if free in self.bodies else None
                if vector is not None:
                    self.direction[self.rotation.of[free]] = vector.times(1.0 / self.rotation.phase[free])
                    self.used.add(turn[1])
                    changed = True
        return changed

    def _by_nodes(self, body: int, factor: complex, number: int, turn: int) -> Vector | None:
        """Return a driven direction from two placed nodes of the body, whose vector has another actuator already."""
        span = self.span(body)
        return None if span is None else Vector(factor / span[2], span[0], span[1], actuator=number, turn=turn)

    def _pairs(self) -> None:
        """Add the equations of slides and linear actuators, and of driven angles that carry no direction."""
        new, group = self.placed - self.layout.placed, set(self.bodies)
        for row in pair_rows(self.mechanism):
            if row.implied:
                continue
            if row.kind == ANGLE:
                self._angle(row)
            elif not set(row.nodes) <= self.placed:
                continue
            elif row.kind == SPAN and set(row.nodes) & new:
                a, b = row.nodes
                self.equations.append(Constraint(row.name, SPAN, a, b, row.value))
            elif row.kind == HEIGHT and (row.node in new or row.guide in group):
                line = self.line(row, row.node)
                self.equations += [line] if line is not None else []  # without, a later group places the guide

    def _angle(self, row: ImposedRow) -> None:
        """Add the equation of a driven angle between two members whose directions come from their nodes."""
        (arm, reference), number = row.members, row.value.actuator
        if number in self.used or not {arm, reference} & set(self.bodies):
            return
        source = self.source(reference)
        normal = source.driven(1j * row.reference, number, 1) if source else None
        span = self.span(arm)
        if normal is None or span is None:
            return
        u, v, reach = span[0], span[1], -span[2] / row.arm
        self.equations.append(Constraint(row.name, HEIGHT, u, v, Value(0.0), normal.times(reach / abs(reach))))
