"""Search for the sequence in which restrictions are imposed: candidates, ranked by their spectral radius.

Both fundamental conditions of Petuya et al. 2004 are satisfied by construction: every free node is moved twice and
every restriction is imposed once. The rules leave choices, and a member has several models. One sweep is a smooth map;
its linearisation at a position is a product of small matrices. The spectral radius of this product is the factor by
which one sweep reduces the error: exp(-C2) of eq. (3).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from gimcli.errors import StructureError
from gimcli.gim.rules import Walk
from gimcli.mechanism import ANGLE, FRAME, SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.structure.closed_form_order import Layout
from gimcli.structure.derived import derived
from gimcli.structure.dulmage_mendelsohn import components, match
from gimcli.structure.gradients import gradient
from gimcli.structure.kinematic_nodes import free_nodes, kinematic_nodes
from gimcli.structure.plan import make_plan
from gimcli.structure.restrictions import Move, Restriction, member_models, pair_restrictions
from gimcli.structure.steps import Coupled, Dyad, Place, Plan, Tilt

CANDIDATES = 400
"""Greatest number of sequences tried for one choice of models; the double butterfly has 12, the ten-bar 32."""

CONVERGES = 0.99
"""Spectral radius below which the classic search accepts a sequence."""

RESTARTS = 60
"""Number of random choices of models for a restart of the spectral search, if no sequence converges."""

FEW = CANDIDATES // 20
"""Greatest number of sequences tried for each of many choices of models."""


@dataclass(frozen=True)
class SequenceGroup:
    """One group of the sequence, and results of the search."""

    moves: tuple[Move, ...]
    nodes: tuple[int, ...]
    radius: float  # spectral radius
    classic_radius: float  # of the best sequence of the classic search
    candidates: int  # number of sequences tried


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

    def radius_at(self, z: ComplexArray, inputs: FloatArray) -> float:
        """Return the spectral radius at another position z (nodes,)."""
        radii = [
            spectral_radius([(m.node, gradient(m.restriction, z, inputs)) for m in g.moves], g.nodes)
            for g in self.groups
        ]
        return max(radii, default=0.0)


@derived
def known_nodes(mechanism: Mechanism) -> tuple[frozenset[int], frozenset[int]]:
    """Return the known nodes (P), and those of them that inputs carry."""
    layout = Layout(mechanism)
    layout.carry()
    fixed = set(mechanism.members[FRAME].nodes)
    return frozenset(layout.placed), frozenset(layout.placed) - fixed


def find_sequence(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, strategy: str = "spectral", plan: Plan | None = None
) -> Sequence:
    """Search for the best sequence at an assembled position z (nodes,); strategy: "spectral" or "classic".

    Raises StructureError if no sequence moves each node twice.
    """
    known, carried = known_nodes(mechanism)
    search = SequenceSearch(mechanism, z, inputs, strategy, known, carried, plan or make_plan(mechanism))
    return Sequence(tuple(search.groups()), carried)


def group_sequence(
    mechanism: Mechanism, nodes: list[int], z: ComplexArray, inputs: FloatArray, plan: Plan
) -> tuple[Move, ...]:
    """Return the best sequence, at a position z (nodes,), that moves only the nodes of one group."""
    known = frozenset(range(len(mechanism.nodes))) - set(nodes)
    search = SequenceSearch(mechanism, z, inputs, "classic", known, frozenset(), plan)
    return tuple(m for g in search.groups() for m in g.moves)


class SequenceSearch:
    """The search for the sequence of one mechanism."""

    def __init__(
        self, mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, strategy: str, known: frozenset[int],
        carried: frozenset[int], plan: Plan,
    ) -> None:  # fmt: skip
        self.mechanism, self.z, self.inputs, self.strategy = mechanism, z, inputs, strategy
        self.known, self.carried = known, carried
        kinematic = kinematic_nodes(mechanism)
        order = {n: k for k, n in enumerate(placement_order(plan))}
        free = set(free_nodes(mechanism)) - known
        self.free = [n for n in sorted(order, key=order.__getitem__) if n in free]
        self.models: list[list[list[Restriction]]] = []
        for index, nodes in enumerate(kinematic):
            if index != FRAME and not set(nodes) <= known:
                ranked = sorted(nodes, key=lambda n: (n not in known, order.get(n, -1)))
                self.models.append(member_models(mechanism, index, ranked, known))
        self.pairs = pair_restrictions(mechanism, known, kinematic)
        self.gradients: dict[int, dict[int, complex]] = {}
        self.kept: list[Restriction] = []  # keeps the ids of `gradients` in use

    def groups(self) -> Iterator[SequenceGroup]:
        """Yield the groups in order of solution."""
        chosen = [0] * len(self.models)
        settled = set(self.known)
        components = self._components(chosen)
        if self.strategy == "spectral":
            components = self._turned(components, chosen)
        for nodes in components:
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
        tried = 0
        classic: tuple[float, tuple[Move, ...]] | None = None
        for variant in self._classic_models(chosen, mine):
            for moves in self._candidates(variant, inside, settled):
                tried += 1
                radius = self.radius(moves, nodes)
                if classic is None or radius < classic[0]:
                    classic = radius, moves
                if radius < CONVERGES:
                    break
        best = classic
        if self.strategy == "spectral":
            best, more = self._descend(nodes, settled, chosen, mine)
            tried += more
            if best is not None and best[0] >= CONVERGES and mine:
                best, more = self._restart(best, nodes, settled, chosen, mine)
                tried += more
        if best is None or classic is None:
            names = ", ".join(self.mechanism.nodes[n] for n in nodes)
            raise StructureError(f"no sequence moves nodes {names} twice each; use --method auto or newton")
        radius, moves = best
        return SequenceGroup(moves, nodes, radius, classic[0], tried)

    def _descend(
        self, nodes: tuple[int, ...], settled: set[int], chosen: list[int], mine: list[int]
    ) -> tuple[tuple[float, tuple[Move, ...]] | None, int]:
        """Improve the sequence by changing the model of one member at a time; return the best and the number tried."""
        best: tuple[float, tuple[Move, ...]] | None = None
        tried, variants, most = 0, [list(chosen)], CANDIDATES
        while variants:
            winner = None
            for variant in variants:
                for moves in islice(self._candidates(variant, set(nodes), settled), most):
                    tried += 1
                    radius = self.radius(moves, nodes)
                    if best is None or radius < best[0] - 1e-9:
                        best, winner = (radius, moves), variant
            if winner is None and (best is not None or most == FEW):
                break
            if winner is not None:
                chosen[:] = winner
            variants = [
                [*chosen[:k], other, *chosen[k + 1 :]]
                for k in mine
                for other in range(len(self.models[k]))
                if other != chosen[k]
            ]
            most = FEW
        return best, tried

    def _restart(
        self, best: tuple[float, tuple[Move, ...]], nodes: tuple[int, ...], settled: set[int], chosen: list[int],
        mine: list[int],
    ) -> tuple[tuple[float, tuple[Move, ...]], int]:  # fmt: skip
        """Try random models of the members (fixed seed), because `_descend` cannot leave a plateau of radius 1."""
        generator, tried = np.random.default_rng(0), 0
        for _ in range(RESTARTS):
            variant = list(chosen)
            for k in mine:
                variant[k] = int(generator.integers(len(self.models[k])))
            for moves in islice(self._candidates(variant, set(nodes), settled), FEW):
                tried += 1
                radius = self.radius(moves, nodes)
                if radius < best[0] - 1e-9:
                    best, chosen[:] = (radius, moves), variant
            if best[0] < CONVERGES:
                break
        return best, tried

    def _classic_models(self, chosen: list[int], mine: list[int]) -> list[list[int]]:
        """Return the two choices of models of the paper: chains, and distances only."""
        chains = list(chosen)
        for k in mine:
            chains[k] = min(len(self.models[k]) - 1, 1)
        return [chains, list(chosen)] if chains != chosen else [chains]

    def _candidates(self, chosen: list[int], inside: set[int], settled: set[int]) -> Iterator[tuple[Move, ...]]:
        mine = [r for r in self._restrictions(chosen) if set(r.nodes) & inside and set(r.nodes) <= inside | settled]
        if len(mine) < 2 * len(inside):
            return
        yield from islice(Walk(mine, inside, self.carried).sequences(), CANDIDATES)

    def radius(self, moves: tuple[Move, ...], nodes: tuple[int, ...]) -> float:
        """Return the spectral radius of one sweep with some moves."""
        for move in moves:
            if id(move.restriction) not in self.gradients:
                self.kept.append(move.restriction)
                self.gradients[id(move.restriction)] = gradient(move.restriction, self.z, self.inputs)
        return spectral_radius([(m.node, self.gradients[id(m.restriction)]) for m in moves], nodes)


def _about_one(model: list[Restriction]) -> bool:
    """Return whether all angles and distances of a member's model are about one vertex."""
    angles = [r for r in model if r.kind == ANGLE]
    return bool(angles) and all(angles[0].q in (r.p, r.q) and (r.kind == SPAN or r.q == angles[0].q) for r in model)


def placement_order(plan: Plan) -> list[int]:
    """Return the free nodes in the order in which a plan places them."""
    order: list[int] = []
    for step in plan.steps:
        if isinstance(step, Place | Dyad):
            order.append(step.node)
        elif isinstance(step, Coupled):
            order += step.nodes
        elif isinstance(step, Tilt):
            continue
    return order


def spectral_radius(moves: list[tuple[int, dict[int, complex]]], nodes: tuple[int, ...]) -> float:
    """Return the spectral radius of a linearised sweep, for moves (moved node, {node: gradient of its restriction}).

    A move of B changes dB to (1 - n n') dB - n (sum of the other gradients . dz) / |gradient at B|, with n the unit
    gradient at B.
    """
    if not nodes:
        return 0.0
    column = {n: 2 * k for k, n in enumerate(nodes)}
    sweep = np.eye(2 * len(nodes))
    for moved, g in moves:
        own = g[moved]
        norm = abs(own)
        if not norm > 1e-12:
            return float("inf")
        pull = np.zeros(2 * len(nodes))
        for node, value in g.items():
            if node in column:
                at = column[node]
                pull[at : at + 2] = value.real / norm, value.imag / norm
        change = pull @ sweep
        at = column[moved]
        sweep[at] -= own.real / norm * change
        sweep[at + 1] -= own.imag / norm * change
    return float(np.max(np.abs(np.linalg.eigvals(sweep)))) if np.all(np.isfinite(sweep)) else float("inf")
