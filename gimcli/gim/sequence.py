"""The sequence in which restrictions are imposed: by the rules of the paper, or the best of the admissible ones.

Both fundamental conditions of Petuya et al. 2004 are satisfied by construction: every free node is moved twice and
every restriction is imposed once. Many sequences do so, and a member has several models. One sweep is a smooth map; its
linearisation at a position is a product of small matrices. The spectral radius of this product is the factor by which
one sweep reduces the error: exp(-C2) of eq. (3).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from gimcli.errors import StructureError
from gimcli.gim.admissible import Walk
from gimcli.gim.rules import PaperRules
from gimcli.mechanism import ANGLE, FRAME, SPAN, ComplexArray, Mechanism
from gimcli.structure.closed_form_order import Layout
from gimcli.structure.derived import derived
from gimcli.structure.dulmage_mendelsohn import components, match
from gimcli.structure.kinematic_nodes import free_nodes, kinematic_nodes
from gimcli.structure.plan import make_plan
from gimcli.structure.readings import Readings
from gimcli.structure.restrictions import Move, Restriction, member_models, pair_restrictions
from gimcli.structure.steps import Coupled, Dyad, Place, Plan
from gimcli.structure.terms import coordinates, places

CANDIDATES = 400
"""Greatest number of sequences tried for one choice of models; the double butterfly has 12, the ten-bar 32."""

CONVERGES = 0.99
"""Spectral radius below which a sequence is accepted."""

RESTARTS = 60
"""Number of random choices of models for a restart of the spectral search, if no sequence converges."""

INCOMPLETE = "the rules of the paper give no complete sequence; nodes that are not moved twice: "

FEW = CANDIDATES // 20
"""Greatest number of sequences tried for each of many choices of models."""


Ranked = tuple[float, tuple[Move, ...]]  # spectral radius and moves


@dataclass(frozen=True)
class SequenceGroup:
    """One group of the sequence, and results of the search."""

    moves: tuple[Move, ...]
    nodes: tuple[int, ...]
    radius: float  # spectral radius
    candidates: int  # number of sequences tried
    placed: tuple[Move, ...] = ()  # by which inputs place their arms, before the sweeps
    kind: str = ""  # by the rules of the paper: "weakly coupled" or "strongly coupled"
    missing: tuple[int, ...] = ()  # nodes that the rules of the paper do not move twice


@dataclass(frozen=True)
class Sequence:
    """Moves of one sweep in order, group after group."""

    groups: tuple[SequenceGroup, ...]
    carried_by_input: frozenset[int]

    @property
    def moves(self) -> tuple[Move, ...]:
        """All moves of one sweep."""
        return tuple(m for g in self.groups for m in g.moves)

    @property
    def radius(self) -> float:
        """Spectral radius of the whole sweep: the greatest of all groups, as its matrix is block triangular."""
        return max((g.radius for g in self.groups), default=0.0)

    def radius_at(self, z: ComplexArray) -> float:
        """Return the spectral radius at another position z (nodes,)."""
        return max((radius_of(g.moves, g.nodes, z) for g in self.groups), default=0.0)


@derived
def known_nodes(mechanism: Mechanism) -> tuple[frozenset[int], frozenset[int]]:
    """Return the known nodes (P), and those of them that inputs carry."""
    layout = Layout(mechanism)
    layout.carry()
    return frozenset(layout.placed), frozenset(layout.placed) - set(mechanism.members[FRAME].nodes)


def find_sequence(
    mechanism: Mechanism, z: ComplexArray, strategy: str = "spectral", plan: Plan | None = None
) -> Sequence:
    """Return the sequence by the rules of the paper ("classic"), or the best one at an assembled position z (nodes,).

    Raises StructureError if no sequence moves each node twice ("spectral"), or if the mechanism cannot be written in
    distances and angles ("classic").
    """
    if strategy == "classic":
        return _by_rules(mechanism, z)
    known, carried = known_nodes(mechanism)
    plan = plan or make_plan(mechanism)
    return Sequence(tuple(SequenceSearch(mechanism, z, known, carried, plan).groups()), carried)


def _by_rules(mechanism: Mechanism, z: ComplexArray) -> Sequence:
    rules = PaperRules(mechanism)
    moves, known = tuple(rules.moves), frozenset(rules.fixed | {m.node for m in rules.placed})
    nodes = tuple(n for n in free_nodes(mechanism) if n not in known)
    radius = radius_of(moves, nodes, z)
    kind = "strongly coupled" if rules.missing or any(m.rule == "criteria" for m in moves) else "weakly coupled"
    return Sequence(
        (SequenceGroup(moves, nodes, radius, 1, tuple(rules.placed), kind, rules.missing),), frozenset(known)
    )


def group_sequence(mechanism: Mechanism, nodes: list[int], z: ComplexArray, plan: Plan) -> tuple[Move, ...]:
    """Return the first sequence that converges at a position z (nodes,) and moves only the nodes of one group."""
    known = frozenset(range(len(mechanism.nodes))) - set(nodes)
    search = SequenceSearch(mechanism, z, known, frozenset(), plan, first=True)
    return tuple(m for g in search.groups() for m in g.moves)


class SequenceSearch:
    """The search for the best sequence of one mechanism, or for the `first` that converges."""

    def __init__(
        self, mechanism: Mechanism, z: ComplexArray, known: frozenset[int], carried: frozenset[int], plan: Plan,
        first: bool = False,
    ) -> None:  # fmt: skip
        self.mechanism, self.first = mechanism, first
        self.known, self.carried = known, carried
        kinematic = kinematic_nodes(mechanism)
        placing = (step for step in plan.steps if isinstance(step, Place | Dyad | Coupled))
        placed = (n for step in placing for n in (step.nodes if isinstance(step, Coupled) else (step.node,)))
        order = {n: k for k, n in enumerate(placed)}
        free = set(free_nodes(mechanism)) - known
        self.free = [n for n in sorted(order, key=order.__getitem__) if n in free]
        self.models = [
            member_models(mechanism, k, sorted(nodes, key=lambda n: (n not in known, order.get(n, -1))), known)
            for k, nodes in enumerate(kinematic)
            if k != FRAME and not set(nodes) <= known
        ]
        self.pairs = pair_restrictions(mechanism, known, kinematic)
        every = [*(r for models in self.models for model in models for r in model), *self.pairs]
        self.gradients = dict(zip(map(id, every), gradients(every, z), strict=True))

    def groups(self) -> Iterator[SequenceGroup]:
        """Yield the groups in order of solution."""
        chosen = [0] * len(self.models)
        settled = set(self.known)
        components = self._components(chosen)
        for nodes in components if self.first else self._turned(components, chosen):
            yield self._best(nodes, settled, chosen)
            settled |= set(nodes)

    def _turned(self, components: list[tuple[int, ...]], chosen: list[int]) -> list[tuple[int, ...]]:
        """Return the groups after choosing, for members that span several groups, distances and angles about a vertex.

        A node is then placed about two settled nodes of its member in one sweep (radius 0), whereas two distances
        converge by the squared cosine of the angle between them. A group alone cannot choose such a model.
        """
        label = {n: k for k, nodes in enumerate(components) for n in nodes}
        turned = list(chosen)
        for k, models in enumerate(self.models):
            free = {n for r in models[0] for n in r.nodes} - self.known
            if len({label[n] for n in free}) > 1:
                turned[k] = next((i for i, model in enumerate(models) if _about_one(model)), chosen[k])
        changed = self._components(turned)
        if len(changed) < len(components):
            return components
        chosen[:] = turned
        return changed

    def _restrictions(self, chosen: list[int]) -> list[Restriction]:
        return [r for models, k in zip(self.models, chosen, strict=True) for r in models[k]] + self.pairs

    def _components(self, chosen: list[int]) -> list[tuple[int, ...]]:
        """Match two restrictions to every node; return the strongly connected nodes in the order of solution."""
        if not self.free:
            return []
        restrictions = self._restrictions(chosen)
        column = {n: k for k, n in enumerate(self.free)}
        holds = [sorted(2 * column[n] + s for n in r.movable if n in column for s in (0, 1)) for r in restrictions]
        needs: list[list[int]] = [[] for _ in self.free]
        for r, c in zip(restrictions, match(2 * len(self.free), holds), strict=True):
            ties = [column[n] for n in r.nodes if n in column]
            for head in [c // 2] if c >= 0 else ties:  # redundant: keep its nodes in one group
                needs[head] += ties
        return [tuple(self.free[k] for k in part) for part in components(needs, ranked=True)]

    def _best(self, nodes: tuple[int, ...], settled: set[int], chosen: list[int]) -> SequenceGroup:
        """Return the best sequence of one group; raises StructureError if there is none."""
        inside = set(nodes)
        mine = [
            k
            for k, models in enumerate(self.models)
            if len(models) > 1
            and any(set(r.nodes) & inside for r in models[0])
            and all(set(r.nodes) <= inside | self.known for r in models[0])
        ]
        self.tried = 0
        best = self._first(nodes, settled, chosen, mine) if self.first else self._descend(nodes, settled, chosen, mine)
        if best is not None and best[0] >= CONVERGES and mine and not self.first:
            best = self._restart(best, nodes, settled, chosen, mine)
        if best is None:
            names = [self.mechanism.nodes[n] for n in nodes]
            raise StructureError(
                f"no sequence moves nodes {', '.join(names)} twice each; use the method auto or newton"
            )
        return SequenceGroup(best[1], nodes, best[0], self.tried)

    def _improved(
        self, best: Ranked | None, variant: list[int], nodes: tuple[int, ...], settled: set[int], most: int = CANDIDATES
    ) -> Ranked | None:
        """Return the best of a known sequence and `most` sequences with the models `variant`."""
        for moves in islice(self._candidates(variant, set(nodes), settled), most):
            self.tried += 1
            radius = self.radius(moves, nodes)
            if best is None or radius < best[0] - (0.0 if self.first else 1e-9):
                best = radius, moves
            if self.first and radius < CONVERGES:
                break
        return best

    def _first(self, nodes: tuple[int, ...], settled: set[int], chosen: list[int], mine: list[int]) -> Ranked | None:
        """Return the better of the first sequences that converge with chains, and with distances only."""
        chains = [min(len(self.models[k]) - 1, 1) if k in mine else model for k, model in enumerate(chosen)]
        best = self._improved(None, chains, nodes, settled)
        return best if chains == chosen else self._improved(best, chosen, nodes, settled)

    def _descend(self, nodes: tuple[int, ...], settled: set[int], chosen: list[int], mine: list[int]) -> Ranked | None:
        """Improve the sequence by changing the model of one member at a time."""
        best: Ranked | None = None
        variants, most = [list(chosen)], CANDIDATES
        while variants:
            winner = None
            for variant in variants:
                better = self._improved(best, variant, nodes, settled, most)
                best, winner = better, winner if better is best else variant
            if winner is None and (best is not None or most == FEW):
                break
            chosen[:] = winner or chosen
            variants = [
                [*chosen[:k], other, *chosen[k + 1 :]]
                for k in mine
                for other in range(len(self.models[k]))
                if other != chosen[k]
            ]
            most = FEW
        return best

    def _restart(
        self, best: Ranked | None, nodes: tuple[int, ...], settled: set[int], chosen: list[int], mine: list[int]
    ) -> Ranked | None:
        """Try random models of the members (fixed seed), because `_descend` cannot leave a plateau of radius 1."""
        generator = np.random.default_rng(0)
        for _ in range(RESTARTS):
            counts = {k: len(self.models[k]) for k in mine}
            variant = [int(generator.integers(counts[k])) if k in mine else model for k, model in enumerate(chosen)]
            better = self._improved(best, variant, nodes, settled, FEW)
            best, chosen[:] = better, chosen if better is best else variant
            if best is not None and best[0] < CONVERGES:
                break
        return best

    def _candidates(self, chosen: list[int], inside: set[int], settled: set[int]) -> Iterator[tuple[Move, ...]]:
        mine = [r for r in self._restrictions(chosen) if set(r.nodes) & inside and set(r.nodes) <= inside | settled]
        enough = len(mine) >= 2 * len(inside)
        return islice(Walk(mine, inside, self.carried).sequences(), CANDIDATES if enough else 0)

    def radius(self, moves: tuple[Move, ...], nodes: tuple[int, ...]) -> float:
        """Return the spectral radius of one sweep with some moves."""
        return spectral_radius([(m.node, self.gradients[id(m.restriction)]) for m in moves], nodes)


def _about_one(model: list[Restriction]) -> bool:
    """Return whether all angles and distances of a member's model are about one vertex."""
    angles = [r for r in model if r.kind == ANGLE]
    return bool(angles) and all(angles[0].q in (r.p, r.q) and (r.kind == SPAN or r.q == angles[0].q) for r in model)


def gradients(restrictions: Iterable[Restriction], z: ComplexArray) -> ComplexArray:
    """Return the gradients g (restrictions, nodes) at a position z (nodes,): d(value) = sum Re(conj(g) dz)."""
    return places(Readings(list(restrictions), len(z)).slopes(z))


def radius_of(moves: tuple[Move, ...], nodes: tuple[int, ...], z: ComplexArray) -> float:
    """Return the spectral radius of a sweep at a position z (nodes,)."""
    found = gradients((m.restriction for m in moves), z)
    return spectral_radius([(m.node, g) for m, g in zip(moves, found, strict=True)], nodes)


def spectral_radius(moves: list[tuple[int, ComplexArray]], nodes: tuple[int, ...]) -> float:
    """Return the spectral radius of a linearised sweep, for moves (moved node, gradient (nodes,) of its restriction).

    A move of B changes dB to (1 - n n') dB - n (sum of the other gradients . dz) / |gradient at B|, with n the unit
    gradient at B.
    """
    sweep = np.eye(2 * len(nodes))
    for moved, g in moves:
        norm = abs(g[moved])
        if not norm > 1e-12:
            return float("inf")
        at = 2 * nodes.index(moved)
        pull = coordinates(g[list(nodes)]) / norm
        sweep[at : at + 2] -= np.outer(pull[at : at + 2], pull @ sweep)
    return float(np.max(np.abs(np.linalg.eigvals(sweep)), initial=0.0)) if np.all(np.isfinite(sweep)) else float("inf")
