"""Assur groups of a linkage with their loops, and the choice of its redundant constraints.

Unknowns are x, y of every moving body and node, one angle per rotation class and one travel per slide; a joint gives
two equations. The rank is computed for random dimensions at which all joints close. A matching of equations to unknowns
directs the structure; its strongly connected components in topological order are the Assur groups. Source: Servatius,
Shai & Whiteley 2010; Fraczek & Wojtyra on redundant constraints.

The coefficients of the loops of a group follow from its lengths, the positions of its nodes from the roots. The nodes
to which the group is connected are known. A spanning tree of its joints gives the position of every new body and node
in terms of the unknowns; every joint outside the tree closes a loop.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.assemblies.constants import PRIME
from gimcli.assemblies.link_joints import NONE, Linkage, pruned
from gimcli.assemblies.loops import GROUND, LoopFamily
from gimcli.errors import StructureError
from gimcli.mechanism import FRAME, ComplexArray, IntArray
from gimcli.structure.dulmage_mendelsohn import components, match

RANGE = 1 << 20
"""Greatest random coordinate (integers)."""

SEED = 20040401


@dataclass(frozen=True)
class GroupPart:
    """The unknowns and equations of one Assur group."""

    vertices: tuple[int, ...]  # bodies and nodes that it positions
    classes: tuple[int, ...]  # rotation classes whose angles it determines
    slides: tuple[int, ...]  # joints with an unknown travel
    joints: tuple[int, ...]  # joints that give its equations


@dataclass
class Unknowns:
    """Columns of the unknowns: ("p", vertex) has two, ("t", class) and ("s", joint) have one."""

    linkage: Linkage
    column: dict[tuple[str, int], int] = field(default_factory=dict)
    count: int = 0

    def __post_init__(self) -> None:
        linkage = self.linkage
        bodies = [b for b in range(linkage.bodies) if b != FRAME and b not in linkage.dropped]
        nodes = sorted({j.node for j in linkage.joints})
        for vertex in (*bodies, *(linkage.bodies + n for n in nodes)):
            self._add(("p", vertex), 2)
        for turning in sorted({linkage.classes[b] for b in bodies} - {NONE}):
            self._add(("t", turning), 1)
        for k, joint in enumerate(linkage.joints):
            if joint.direction is not None:
                self._add(("s", k), 1)

    def _add(self, unknown: tuple[str, int], width: int) -> None:
        self.column[unknown] = self.count
        self.count += width

    def of(self, index: int) -> list[tuple[str, int]]:
        """Return the unknowns of a joint."""
        joint = self.linkage.joints[index]
        places = ("p", joint.body), ("p", self.linkage.bodies + joint.node)
        return [u for u in (*places, ("t", self.linkage.classes[joint.body]), ("s", index)) if u in self.column]


def independent(linkage: Linkage) -> Linkage:
    """Return the linkage without redundant constraints, which are removed one after the other.

    A bar is removed with both its pins, a slide as one joint; another pin is replaced by a slide. The residual of
    the removed constraints is checked afterwards. Raises StructureError if the linkage can still move.
    """
    loose = len(linkage.loose)
    while True:
        free, surplus = _freedoms(linkage)
        if free:
            _refuse(linkage)
        if not surplus:
            return linkage
        linkage = next(found for found in _reduced(linkage) if len(found.loose) == loose and not _freedoms(found)[0])


def _reduced(linkage: Linkage) -> Iterator[Linkage]:
    """Yield linkages with one constraint less, beginning with the last bars."""
    joints, pins = linkage.joints, Counter(j.body for j in linkage.joints)
    for body in range(len(linkage.mechanism.members) - 1, FRAME, -1):
        own = [j for j in joints if j.body == body]
        shared = sum(c == linkage.classes[body] for c in linkage.classes) > 1
        if pins[body] == 2 and not shared and all(j.direction is None and j.actuator == NONE for j in own):
            yield pruned(replace(linkage, dropped=linkage.dropped | {body}), [j for j in joints if j.body != body])
    for k in reversed(range(len(joints))):
        if joints[k].direction is not None and joints[k].actuator == NONE:
            yield pruned(linkage, [*joints[:k], *joints[k + 1 :]])
    for k in reversed(range(len(joints))):
        if joints[k].direction is None and joints[k].body != FRAME:
            slide = replace(joints[k], direction=1.0 + 0.0j, slack=True)
            yield pruned(linkage, [*joints[:k], slide, *joints[k + 1 :]])
    raise StructureError(f"{linkage.mechanism.name} is over-driven: its actuators contradict each other; remove one")


def _freedoms(linkage: Linkage) -> tuple[int, int]:
    """Return the freedoms at random dimensions, and by how many the equations exceed the unknowns."""
    table = generic_jacobian(linkage)
    equations, unknowns = table.shape
    return unknowns - len(_eliminated(table)[1]), equations - unknowns


def generic_jacobian(linkage: Linkage) -> IntArray:
    """Return the derivatives of all joints (2 joints, unknowns) at a random position in which they close.

    Coordinates are integers, so that the rank modulo a prime is exact for chains of any length.
    """
    unknowns, generator = Unknowns(linkage), np.random.default_rng(SEED)
    place = generator.integers(-RANGE, RANGE, (linkage.vertices, 2))
    place[FRAME] = 0
    table = np.zeros((2 * len(linkage.joints), unknowns.count), dtype=np.int64)
    rails: dict[int, IntArray] = {}
    for k, joint in enumerate(linkage.joints):
        node, rail = linkage.bodies + joint.node, _rail(linkage, k, place, generator)
        rails[k] = rail = rails.get(joint.parallel, rail)
        for unknown in unknowns.of(k):
            kind, which = unknown
            at, rows = unknowns.column[unknown], slice(2 * k, 2 * k + 2)
            x, y = place[node] - place[joint.body]
            if kind == "p":
                table[rows, at : at + 2] = np.eye(2) if which == node else -np.eye(2)
            else:
                table[rows, at] = (y, -x) if kind == "t" else -rail
    return table % PRIME


def _rail(linkage: Linkage, index: int, place: IntArray, generator: np.random.Generator) -> IntArray:
    """Return a random direction of a rail; if the rail passes a pin of its body, the direction through that pin."""
    joint = linkage.joints[index]
    if joint.through == NONE:
        return np.asarray(generator.integers(-RANGE, RANGE, 2))
    return np.asarray(place[linkage.bodies + joint.node] - place[linkage.bodies + linkage.joints[joint.through].node])


def _eliminated(table: IntArray) -> tuple[IntArray, list[int]]:
    """Return the reduced rows of a matrix modulo PRIME (Gauss-Jordan elimination), and the columns of their pivots."""
    rows, pivots = table.copy(), list[int]()
    for column in range(table.shape[1]):
        rank = len(pivots)
        below = np.flatnonzero(rows[rank:, column])
        if not len(below):
            continue
        pivot = rank + int(below[0])
        rows[[rank, pivot]] = rows[[pivot, rank]]
        rows[rank] = rows[rank] * pow(int(rows[rank, column]), -1, PRIME) % PRIME
        others = np.flatnonzero(rows[:, column])
        others = others[others != rank]
        rows[others] = (rows[others] - rows[others, column, None] * rows[rank]) % PRIME
        pivots.append(column)
    return rows[: len(pivots)], pivots


def _refuse(linkage: Linkage) -> None:
    """Raise StructureError with the names of the undriven nodes."""
    unknowns = Unknowns(linkage)
    reduced, pivots = _eliminated(generic_jacobian(linkage))
    moving = np.ones(unknowns.count, dtype=bool)
    free = np.setdiff1d(np.arange(unknowns.count), pivots)
    moving[pivots] = (reduced[:, free] != 0).any(axis=1)
    names = [
        linkage.mechanism.nodes[which - linkage.bodies]
        for (kind, which), at in unknowns.column.items()
        if kind == "p" and which >= linkage.bodies and moving[at : at + 2].any()
    ]
    raise StructureError(
        f"nothing drives {'nodes ' + ', '.join(names) if names else linkage.mechanism.name}: the mechanism can move"
        " at these inputs; add an actuator for each freedom"
    )


def parts(linkage: Linkage) -> list[GroupPart]:
    """Return the Assur groups of a linkage without redundant constraints, in the order of solution."""
    unknowns = Unknowns(linkage)
    whole, rows = list(range(unknowns.count)), list[list[int]]()  # x and y of a vertex belong to the same group
    for (kind, _), at in unknowns.column.items():
        if kind == "p":
            whole[at + 1] = at
    for k in range(len(linkage.joints)):
        columns = [(unknowns.column[u], u[0] == "p") for u in unknowns.of(k)]
        rows += [[at + part * of_place for at, of_place in columns] for part in (0, 1)]  # columns of every equation
    entered = [[row for row, columns_of in enumerate(rows) if at in columns_of] for at in range(unknowns.count)]
    equation = match(len(rows), entered)
    needs: list[list[int]] = [[] for _ in whole]
    joints: dict[int, list[int]] = {at: [] for at in whole}
    for own, row in enumerate(equation):
        needs[whole[own]] += [whole[c] for c in rows[row]]
        joints[whole[own]].append(row // 2)
    unknown = {at: u for u, at in unknowns.column.items()}
    found = ([at for at in part if at in unknown] for part in components(needs))
    return [_part([unknown[at] for at in part], {j for at in part for j in joints[at]}) for part in found if part]


def _part(content: list[tuple[str, int]], joints: set[int]) -> GroupPart:
    def only(kind: str) -> tuple[int, ...]:
        return tuple(sorted(which for k, which in content if k == kind))

    return GroupPart(only("p"), only("t"), only("s"), tuple(sorted(joints)))


Term = tuple[str, int, int]
"""A parameter, ("place", node), ("at", joint), ("arm", joint) or ("rail", joint), and the column that it multiplies."""


@dataclass
class LoopState:
    """Positions of bodies and nodes computed so far, for several configurations (`positions`)."""

    place: ComplexArray  # (vertices, positions)
    turn: ComplexArray  # (bodies, positions) e^(i phi)
    travel: ComplexArray  # (joints, positions)
    points: ComplexArray  # (joints, 1) points times the phases of their bodies
    rails: ComplexArray  # (joints, 1) directions times the phases of their bodies
    phases: ComplexArray  # (bodies, 1)

    def take(self, chosen: IntArray) -> LoopState:
        """Return the state of some of the configurations."""
        return replace(self, place=self.place[:, chosen], turn=self.turn[:, chosen], travel=self.travel[:, chosen])


@dataclass(frozen=True)
class LoopGroup:
    """One Assur group: its family of loops, and the tree from which positions are computed."""

    linkage: Linkage = field(repr=False)
    part: GroupPart
    family: LoopFamily = field(repr=False)
    parameters: tuple[tuple[str, int], ...]
    tree: tuple[tuple[int, bool], ...]  # joint, and whether it leads from the body to the node

    def values(self, state: LoopState) -> ComplexArray:
        """Return the parameters (positions, parameters)."""
        joints = self.linkage.joints
        result = np.empty((len(self.parameters), state.place.shape[1]), dtype=complex)
        for row, (kind, which) in enumerate(self.parameters):
            if kind == "place":
                result[row] = state.place[self.linkage.bodies + which]
                continue
            joint = joints[which]
            table = state.points if kind != "rail" else state.rails
            value = table[which]
            if self.linkage.classes[joint.body] not in self.part.classes:
                value = value * self._class_turn(state, joint.body)
            if kind == "at":
                value = value + state.place[joint.body]
            result[row] = value
        return result.T

    def _class_turn(self, state: LoopState, body: int) -> ComplexArray:
        """Return e^(i phi) of a known class: that of the body without the phase included in points and rails."""
        if self.linkage.classes[body] == NONE:
            return np.ones(state.turn.shape[1], dtype=complex)
        return np.asarray(state.turn[body] / state.phases[body])

    def put(self, state: LoopState, w: ComplexArray) -> None:
        """Write the positions for roots w (positions, n + q) into a state."""
        n, linkage = self.family.angles, self.linkage
        for column, turning in enumerate(self.part.classes):
            for body in range(linkage.bodies):
                if linkage.classes[body] == turning:
                    state.turn[body] = np.exp(w[:, column]) * state.phases[body]
        for column, index in enumerate(self.part.slides):
            state.travel[index] = w[:, n + column]
        for index, forward in self.tree:
            joint = linkage.joints[index]
            step = (state.points[index] + state.travel[index] * state.rails[index]) * self._class_turn(
                state, joint.body
            )
            node = linkage.bodies + joint.node
            if forward:
                state.place[node] = state.place[joint.body] + step
            else:
                state.place[joint.body] = state.place[node] - step


def group_of(linkage: Linkage, part: GroupPart) -> LoopGroup:
    """Return the loop group of a part."""
    tree, ways = _spanning(linkage, part)
    loops = [
        ways[joint.body] + unit - ways[linkage.bodies + joint.node]
        for index, (joint, unit) in enumerate(zip(linkage.joints, np.eye(ways.shape[1], dtype=int), strict=True))
        if index in part.joints and index not in tree
    ]
    return LoopGroup(linkage, part, *_tensors(linkage, part, loops), tuple(tree.items()))


def _spanning(linkage: Linkage, part: GroupPart) -> tuple[dict[int, bool], IntArray]:
    """Return the joints of the tree in the order of solution with their senses, and the ways to the vertices.

    A way (vertices, joints) has the signs of the joints from a known vertex on.
    """
    ways = np.zeros((linkage.vertices, len(linkage.joints)), dtype=int)
    known, tree, left, idle = set(range(len(ways))) - {*part.vertices}, dict[int, bool](), list(part.joints), 0
    while idle < len(left):
        index = left.pop(0)
        body, node = linkage.joints[index].body, linkage.bodies + linkage.joints[index].node
        if (body in known) == (node in known):
            left, idle = [*left, index], idle + 1
            continue
        tree[index] = forward = body in known
        start, end, sign = (body, node, 1) if forward else (node, body, -1)
        ways[end] = ways[start]
        ways[end, index] = sign
        known, idle = known | {end}, 0
    return tree, ways


def _terms(linkage: Linkage, part: GroupPart, index: int) -> Iterator[tuple[Term, int]]:
    """Yield the terms of the vector from a joint's body to its node, and their factors; known ends are fixed points."""
    joint = linkage.joints[index]
    label = joint.through if joint.through in part.joints else index
    yield ("arm" if joint.body in part.vertices else "at", label, 1 + _class(linkage, part, index)), 1
    if linkage.bodies + joint.node not in part.vertices:
        yield ("place", joint.node, 0), -1
    if index in part.slides:
        other = next(k for k in part.slides if linkage.same_rail(k, index))
        sense = linkage.sense(joint, linkage.joints[other]) if other != index else 1
        yield ("rail", other, 1 + len(part.classes) + part.slides.index(index)), sense


def _class(linkage: Linkage, part: GroupPart, index: int) -> int:
    """Return the column of the rotation class of a joint's body; GROUND if its angle is known."""
    own = linkage.classes[linkage.joints[index].body]
    return part.classes.index(own) if own in part.classes else GROUND


def _tensors(
    linkage: Linkage, part: GroupPart, loops: list[IntArray]
) -> tuple[LoopFamily, tuple[tuple[str, int], ...]]:
    """Return the tensors of loops, given by the signs (joints,) of their joints, and their parameters."""
    total = Counter[tuple[int, Term]]()
    for k, signs in enumerate(loops):
        for index in np.flatnonzero(signs).tolist():
            for term, factor in _terms(linkage, part, index):
                total[k, term] += int(signs[index]) * factor
    kept = {key: count for key, count in total.items() if count}
    parameters = tuple(sorted({term[:2] for _, term in kept}))
    table = np.zeros((len(loops), 1 + len(part.classes) + len(part.slides), len(parameters)))
    for (k, (kind, which, column)), count in kept.items():
        table[k, column, parameters.index((kind, which))] = count
    rail = np.array([_class(linkage, part, s) for s in part.slides], dtype=np.int64)
    return LoopFamily(table, rail), parameters
