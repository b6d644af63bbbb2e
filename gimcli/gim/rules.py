"""The rules of the paper: the sequence of Petuya et al. 2004, section 4, and nothing that goes further.

States of a node in one sweep: P fixed, P0 free (not moved yet), P1 available (moved once), P2 stable (moved twice).

Rule I has priority: a restriction on an available node whose other nodes are all fixed is imposed on that node.
Rule II: the restrictions on stable nodes are imposed from these, first those that necessarily move a certain node, then
combinations that make a node stable at once, then the others. The criteria apply when only available nodes remain: the
origin is the available node with the most unused restrictions; if it was moved by a distance, another distance is
imposed from it.

Readings where the paper is silent: the arm of a rotary input about a fixed pivot is stable from the start, and the end
of a driven length from a fixed node has been moved once. The order of rule II is that of all stable nodes together.
A member counts as one restriction until its model is chosen; then it is the chain of distances and angles that begins
with the origin and the node that is moved first, or, with a fixed node, the distances from this node and the angles of
the chain. Of equals the first is taken, in the order of the file; members with more nodes come first. A sliding pair is
an angle of 180 or 0 degrees, its travel a distance along the guide.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from gimcli.errors import StructureError
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, Mechanism
from gimcli.structure.kinematic_nodes import free_nodes, kinematic_nodes
from gimcli.structure.pair_rows import ImposedRow, pair_rows
from gimcli.structure.restrictions import (
    Move,
    Restriction,
    angle,
    member_angle,
    member_distance,
    pair_restrictions,
)
from gimcli.structure.steps import Value

NEAR = 1e-9  # distance from a line, relative to the size, and relative difference of a direction
STAGES = ("it can only move {}", "in a combination that makes {} stable at once", "the first of the other restrictions")


Option = tuple[Restriction, int, int, int]  # restriction, its body (see `unused`), origin, node that it moves


class PaperRules:
    """The rules applied to a mechanism.

    `placed`: moves that place the arms of rotary inputs once; `moves` of a sweep, in order; `missing`: nodes that are
    not moved twice. Raises StructureError if a pair cannot be written as a distance or an angle.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.kinematic = mechanism, kinematic_nodes(mechanism)
        self.fixed = set(mechanism.members[FRAME].nodes)
        self.fixed |= {n for nodes in self.kinematic if len(self.fixed & set(nodes)) > 1 for n in nodes}
        free = (n for n in free_nodes(mechanism) if n not in self.fixed)
        self.counts = dict.fromkeys(free, 0)  # moves of each node; last the node that was moved last
        bodies = [(k, nodes) for k, nodes in enumerate(self.kinematic) if not self.fixed.issuperset(nodes)]
        self.open = {body: nodes for body, nodes in bodies if len(nodes) > 2}  # members whose model is not chosen yet
        self.unused = {  # {restriction: its member, or number of members + its pair}
            self._distance(body, held, n): body
            for body, nodes in bodies
            for held in [n for n in nodes if n in self.fixed or len(nodes) == 2][:1]
            for n in nodes
            if n != held
        }
        self.placed, self.moves = list[Move](), list[Move]()
        self._write()
        while self._next():
            pass
        self.missing = tuple(n for n, count in sorted(self.counts.items()) if count < 2)
        for r in [] if self.missing else list(self.unused):
            for node in [n for n in r.movable if n in self.counts][:1]:
                self._impose(r, node, "surplus", "redundant: all nodes are stable, but the restriction is imposed too")

    # -- restrictions and inputs ----------------------------------------------------------------

    def _write(self) -> None:
        """Write the pairs as restrictions too, and impose the inputs that begin the sequence."""
        written = pair_restrictions(self.mechanism, frozenset(), self.kinematic)
        for k, (row, r) in enumerate(zip(pair_rows(self.mechanism), written, strict=True), start=len(self.kinematic)):
            if r.kind == ANGLE and r.driven and row.guide == FRAME and row.nodes and row.node in self.fixed:
                self._place_arm(row)
            else:
                self.unused[self._written(row, r)] = k
        self.unused = {r: body for r, body in self.unused.items() if not all(map(self._settled, r.nodes))}
        ends = {r: set(r.nodes) - self.fixed for r in self.unused if r.kind != ANGLE and r.driven}
        for r in [r for r, moved in ends.items() if len(moved) == 1]:
            self._impose(r, min(ends[r]), "input", f"input: {r.name} moves it once (P1)")

    def _place_arm(self, row: ImposedRow) -> None:
        """Place the arm of a rotary input: the node in its direction from the pivot."""
        member, others = self.mechanism.members[row.members[0]], set(self.kinematic[row.members[0]]) - {row.node}
        arm = min(sorted(others), key=lambda n: abs(np.angle(member.reach(row.node, n) / row.arm)))
        self.counts[arm] = 2
        r = Restriction(row.name, ANGLE, arm, row.node, Value(0.0))
        self.placed.append(Move(r, arm, "input", f"input: {r.name} places it, so it is stable (P2), an origin"))

    def _written(self, row: ImposedRow, r: Restriction) -> Restriction:
        """Return the restriction of a pair as a distance or an angle between nodes."""
        written = {  # a length; a travel along its own guide; an angle at a common node
            SPAN: True,
            HEIGHT: r.driven and any((s.node, s.guide) == (row.node, row.guide) for s in self.mechanism.slides),
            ANGLE: r.vector is not None and r.vector.u == r.q,
        }
        if written[r.kind]:
            return r
        guide, drawn = self.mechanism.members[row.guide], self.mechanism.drawn
        on = [n for n in self.kinematic[row.guide] if abs(row.height(guide.local(n))) < NEAR * self.mechanism.size]
        if r.kind == ANGLE or r.driven or len(on) < 2:
            raise StructureError(
                f"{row.pair or row.name} cannot be written as a distance or an angle between nodes, as the rules of the"
                " paper need it (a sliding pair can, as 180 or 0 degrees, on the line of two nodes of its guide): use"
                " the strategy spectral"
            )
        arm, *_, vertex = sorted(on, key=lambda n: (n in self.fixed, float(abs(drawn[n] - drawn[row.node]))))
        ratio = (drawn[row.node] - drawn[vertex]) / (drawn[arm] - drawn[vertex])  # > 0: 0 degrees, < 0: 180 degrees
        return angle(row.name, vertex, arm, row.node, complex(np.sign(ratio.real)))

    def _distance(self, body: int, a: int, b: int) -> Restriction:
        return member_distance(self.mechanism, body, a, b, len(self.kinematic[body]) == 2)

    def _model(self, body: int, head: Sequence[int]) -> None:
        """Choose the model of a member: the chain that begins with the nodes `head`."""
        chain = [*head, *sorted(set(self.open.pop(body)) - set(head))]
        if chain[0] not in self.fixed:
            self.unused |= {self._distance(body, a, b): body for a, b in pairwise(chain)}
        corners = zip(chain, chain[1:], chain[2:], strict=False)
        self.unused |= {member_angle(self.mechanism, body, b, a, c): body for a, b, c in corners}

    # -- rules and criteria ---------------------------------------------------------------------

    def _settled(self, node: int) -> bool:
        return node in self.fixed or self.counts[node] == 2

    def _impose(self, r: Restriction, node: int, rule: str, reason: str) -> None:
        del self.unused[r]
        self.counts[node] = self.counts.pop(node) + 1
        self.moves.append(Move(r, node, rule, reason))

    def _next(self) -> bool:
        """Make the next move; return whether there is one."""
        for body, nodes in list(self.open.items()):
            settled = sorted(filter(self._settled, nodes), key=lambda n: n not in self.fixed)
            if len(settled) > 1:
                self._model(body, settled)
        found = self._rule_one() or self._rule_two() or self._criteria()
        if found is not None:
            (r, body, origin, node), rule, reason = found
            if r not in self.unused:
                self._model(body, (origin, node))
            self._impose(r, node, rule, reason)
        return found is not None

    def _options(self, *origins: int) -> list[Option]:
        """Return what can be imposed from some origins, those of members with more nodes first."""
        chosen = [
            (r, body, o, n)
            for o in origins for r, body in self.unused.items() if o in r.nodes for n in sorted(r.movable)
        ]  # fmt: skip
        free = [
            (self._distance(body, o, n), body, o, n)
            for o in origins for body, nodes in self.open.items() if o in nodes for n in sorted(nodes)
        ]  # fmt: skip
        size = [*map(len, self.kinematic), *[2] * len(pair_rows(self.mechanism))]
        order = sorted(chosen + free, key=lambda option: (origins.index(option[2]), -size[option[1]], option[1]))
        return [option for option in order if option[2] != option[3] and not self._settled(option[3])]

    def _rule_one(self) -> tuple[Option, str, str] | None:
        reason = "rule I: it has been moved once (P1); fixed (P): {}"
        return next(
            (
                (option, "I", reason.format(self._named(sorted(others))))
                for option in self._options(*sorted(self.fixed))
                for others in [set(option[0].nodes) - {option[3]}]
                if self.counts[option[3]] == 1 and others <= self.fixed
            ),
            None,
        )

    def _rule_two(self) -> tuple[Option, str, str] | None:
        options = self._options(*(n for n, count in self.counts.items() if count == 2))
        why = "rule II: {} is stable (P2); {}"
        return next(
            (
                (option, "II", why.format(self._named([option[2]]), STAGES[stage].format(self._named([option[3]]))))
                for stage in range(len(STAGES))
                for option in options
                if self._stage(option) == stage
            ),
            None,
        )

    def _stage(self, option: Option) -> int:
        """Return the place in the order of rule II."""
        certain = [r for r in self.unused if sum(not self._settled(n) for n in r.nodes) == 1]
        r, node = option[0], option[3]
        if r in self.unused:
            return 0 if r in certain else 2
        models = [nodes for nodes in self.open.values() if node in nodes and any(map(self._settled, nodes))]
        return 1 if sum(node in r.movable for r in certain) + len(models) + self.counts[node] >= 2 else 2

    def _criteria(self) -> tuple[Option, str, str] | None:
        bodies = [*((r.nodes, body) for r, body in self.unused.items()), *((n, body) for body, n in self.open.items())]
        available = [n for n, count in sorted(self.counts.items()) if count == 1 and self._options(n)]
        unused = {n: len({body for nodes, body in bodies if n in nodes}) for n in available}
        equal = [n for n in available if unused[n] == max(unused.values())]
        if not equal:
            return None
        distance = next(m.restriction.kind for m in reversed(self.moves) if m.node == equal[0]) == SPAN
        best = min(self._options(equal[0]), key=lambda option: distance and option[0].kind != SPAN)
        most = f"most unused restrictions ({unused[equal[0]]}) of the available nodes (P1): {self._named(equal)}"
        by = "; it was moved by a distance, so by a distance" * (distance and best[0].kind == SPAN)
        return best, "criteria", f"criteria: {most}{'; the first of them is the origin' * (len(equal) > 1)}{by}"

    def _named(self, nodes: Iterable[int]) -> str:
        return ", ".join(self.mechanism.nodes[n] for n in nodes)
