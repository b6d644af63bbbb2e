"""The loops of one Assur group: the coefficients from its lengths, and the positions of its nodes from the roots.

The nodes to which the group is connected are known. A spanning tree of its joints gives the position of every new body
and node in terms of the unknowns; every joint outside the tree closes a loop.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.assemblies.assur_loops import GroupPart
from gimcli.assemblies.link_joints import NONE, Linkage
from gimcli.assemblies.loops import GROUND, LoopFamily
from gimcli.mechanism import ComplexArray, IntArray

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


class _LoopWriter:
    """Collects the terms of positions and loops."""

    def __init__(self, linkage: Linkage, part: GroupPart) -> None:
        self.linkage, self.part = linkage, part
        self.new = set(part.vertices)
        self.angle = {c: 1 + k for k, c in enumerate(part.classes)}
        self.slide = {s: 1 + len(part.classes) + k for k, s in enumerate(part.slides)}

    def start(self, node: int) -> Counter[Term]:
        """Return the terms of a known node."""
        return Counter({("place", node, 0): 1})

    def step(self, index: int) -> Counter[Term]:
        """Return the terms of the vector from a joint's body to its node; of the node itself if the body is known."""
        joint = self.linkage.joints[index]
        column = self.angle.get(self.linkage.classes[joint.body], 0)
        label = joint.through if joint.through in self.part.joints else index
        total: Counter[Term] = Counter({("arm" if joint.body in self.new else "at", label, column): 1})
        if index in self.slide:
            other = next(k for k in self.part.slides if self.linkage.same_rail(k, index))
            sense = self.linkage.sense(joint, self.linkage.joints[other]) if other != index else 1
            total[("rail", other, self.slide[index])] += sense
        return total


def _sum(a: Counter[Term], b: Counter[Term], factor: int = 1) -> Counter[Term]:
    total = Counter(a)
    for term, count in b.items():
        total[term] += factor * count
    return total


def group_of(linkage: Linkage, part: GroupPart) -> LoopGroup:
    """Return the loop group of a part."""
    writer = _LoopWriter(linkage, part)
    tree, place = _spanning(writer)
    chords = [k for k in part.joints if k not in {index for index, _ in tree}]
    loops = []
    for index in chords:
        joint = linkage.joints[index]
        node = linkage.bodies + joint.node
        end = place[node] if node in writer.new else writer.start(joint.node)
        loops.append(_sum(_sum(place.get(joint.body, Counter()), writer.step(index)), end, -1))
    family, parameters = _tensors(writer, loops)
    return LoopGroup(linkage, part, family, parameters, tuple(tree))


def _spanning(writer: _LoopWriter) -> tuple[list[tuple[int, bool]], dict[int, Counter[Term]]]:
    """Return the joints of the tree in the order of solution with their senses, and the terms of the vertices."""
    linkage, left = writer.linkage, list(writer.part.joints)
    tree: list[tuple[int, bool]] = []
    place: dict[int, Counter[Term]] = {}
    news = True
    while news:
        news = False
        for index in left.copy():
            joint = linkage.joints[index]
            body, node = joint.body, linkage.bodies + joint.node
            known = [v in place or v not in writer.new for v in (body, node)]
            if known[0] == known[1]:
                continue
            step = writer.step(index)
            if known[0]:
                place[node] = _sum(place.get(body, Counter()), step)
            else:
                place[body] = _sum(place[node] if node in place else writer.start(joint.node), step, -1)
            tree.append((index, known[0]))
            left.remove(index)
            news = True
    return tree, place


def _tensors(writer: _LoopWriter, loops: list[Counter[Term]]) -> tuple[LoopFamily, tuple[tuple[str, int], ...]]:
    """Return the tensors of some loops and their parameters."""
    part, linkage = writer.part, writer.linkage
    terms = {(kind, which) for loop in loops for (kind, which, _), count in loop.items() if count}
    parameters = tuple(sorted(terms))
    number = {p: k for k, p in enumerate(parameters)}
    n, q = len(part.classes), len(part.slides)
    table = np.zeros((len(loops), 1 + n + q, len(parameters)))
    for k, loop in enumerate(loops):
        for (kind, which, column), count in loop.items():
            if count:
                table[k, column, number[(kind, which)]] += count
    rail = [writer.angle.get(linkage.classes[linkage.joints[s].body], 0) - 1 for s in part.slides]
    assert GROUND == -1
    family = LoopFamily(table[:, 0], table[:, 1 : 1 + n], table[:, 1 + n :], np.array(rail, dtype=np.int64))
    return family, parameters
