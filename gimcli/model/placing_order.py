"""The order in which nodes without coordinates are placed: determined by the structure alone."""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Set

from gimcli.model.placing_data import GivenLine, GivenShape, PlacingData
from gimcli.model.placing_steps import (
    CircleAndLine,
    CircleLocus,
    CrossedCircles,
    CrossedLines,
    PlacingStep,
    SlotThroughNode,
    TurnStep,
)

Key = tuple[str, str]


def steps_of(data: PlacingData, placed: Set[str]) -> tuple[list[PlacingStep], set[str]]:
    """Return the steps that place nodes, beginning with those that are placed, and the nodes that are left."""
    order = _Order(data, placed)
    return list(order.steps()), set(data.order) - order.known


class _Order:
    """The steps that are possible with the nodes that are placed so far."""

    def __init__(self, data: PlacingData, placed: Set[str]) -> None:
        self.data, self.known = data, set(placed)
        self.shapes = {shape.name: shape for shape in data.shapes}
        self.rank = {name: k for k, name in enumerate((*self.shapes, *data.order))}
        self.beside = _neighbours(data)
        self.ready: dict[Key, PlacingStep] = {}
        self.queue: list[tuple[int, int, Key]] = []

    def steps(self) -> Iterator[PlacingStep]:
        """Yield the steps; the first possible one is always taken."""
        self._update([*(("member", name) for name in self.shapes), *(("node", name) for name in self.data.order)])
        while self.queue:
            rank, _, key = heapq.heappop(self.queue)
            step = self.ready.get(key)
            if step is None or step.rank != rank or self.known.issuperset(step.nodes):
                continue
            yield step
            self.known.update(step.nodes)
            self._update(dict.fromkeys(key for node in step.nodes for key in self.beside[node]))

    def _update(self, keys: Iterable[Key]) -> None:
        for key in keys:
            step = next(self._of_member(self.shapes[key[1]]) if key[0] == "member" else self._of_node(key[1]), None)
            if step is None:
                self.ready.pop(key, None)
            else:
                self.ready[key] = step
                heapq.heappush(self.queue, (step.rank, self.rank[key[1]], key))

    # -- members ------------------------------------------------------------------------------

    def _of_member(self, shape: GivenShape) -> Iterator[PlacingStep]:
        """Yield the steps that place a whole member."""
        have = tuple(n for n in shape.local if n in self.known)
        lack = tuple(n for n in shape.local if n not in self.known)
        if lack and len(have) > 1:
            yield TurnStep(lack, shape, have[0], have[0], have[1], have[1])
        elif lack and have:
            yield from self._turned(shape, have[0], lack)
            yield from self._through(shape, have[0], lack)

    def _turned(self, shape: GivenShape, placed: str, lack: tuple[str, ...]) -> Iterator[PlacingStep]:
        own = shape.local.keys()
        for given in self.data.angles:
            pivot, arm, base = given.pivot, given.arm, given.reference
            if {pivot, arm} <= own and (base is None or (base not in own and {pivot, base} <= self.known)):
                yield TurnStep(lack, shape, placed, pivot, arm, base, given.angle)
            elif base is not None and {pivot, base} <= own and arm not in own and {pivot, arm} <= self.known:
                yield TurnStep(lack, shape, placed, pivot, base, arm, -given.angle)

    def _through(self, shape: GivenShape, placed: str, lack: tuple[str, ...]) -> Iterator[PlacingStep]:
        for slot in (one for one in self.data.lines if not one.square and set(one.guide) <= shape.local.keys()):
            for slider in (node for node in slot.nodes if node in self.known and node not in shape.local):
                chosen = next((n for n in slot.guide if n in lack), lack[0])
                yield SlotThroughNode(tuple(dict.fromkeys((chosen, *lack))), shape, placed, slot, slider)

    # -- nodes --------------------------------------------------------------------------------

    def _of_node(self, node: str) -> Iterator[PlacingStep]:
        """Yield the steps that place one node by two of its loci, those without a choice first."""
        if node in self.known:
            return
        lines, circles = self._lines(node), self._circles(node)
        if len(lines) > 1:
            yield CrossedLines((node,), (lines[0], lines[1]))
        elif lines and circles:
            yield CircleAndLine((node,), circles[0], lines[0])
        elif len(circles) > 1:
            yield CrossedCircles((node,), (circles[0], circles[1]))

    def _lines(self, node: str) -> list[GivenLine]:
        """Return the lines on which a node is, one for each guide and kind."""
        own = (one for one in self.data.lines if node in one.nodes and self.known.issuperset(one.guide))
        return [*{(one.square, one.guide): one for one in own}.values()]

    def _circles(self, node: str) -> list[CircleLocus]:
        """Return the circles on which a node is, one for each centre, in the order of the file's nodes."""
        found: dict[str, CircleLocus] = {}
        for kind, name in self.beside[node]:
            if kind == "member" and node in (local := self.shapes[name].local):
                for other in (n for n in local if n in self.known):
                    found.setdefault(other, CircleLocus(name, other, abs(local[node] - local[other])))
        for given in self.data.distances:
            if node in given.nodes:
                other = given.nodes[given.nodes[0] == node]
                if other in self.known:
                    found.setdefault(other, CircleLocus(given.name, other, given.value))
        return [found[name] for name in sorted(found, key=self.rank.__getitem__)]


def _neighbours(data: PlacingData) -> dict[str, list[Key]]:
    """Return the members and nodes whose steps may change when a node is placed, by node."""
    found: dict[str, dict[Key, None]] = defaultdict(dict)
    of_member: dict[str, dict[str, None]] = defaultdict(dict)
    for shape in data.shapes:
        keys = dict.fromkeys([("member", shape.name), *(("node", name) for name in shape.local)])
        for node in shape.local:
            of_member[node][shape.name] = None
            found[node].update(keys)
    groups = [(*one.guide, *one.nodes) for one in data.lines] + [given.nodes for given in data.distances]
    groups += [tuple(n for n in (g.pivot, g.arm, g.reference) if n is not None) for g in data.angles]
    for names in groups:
        count = Counter(member for node in names for member in of_member[node])
        keys = dict.fromkeys([*(("member", m) for m, n in count.items() if n > 1), *(("node", n) for n in names)])
        for node in names:
            found[node].update(keys)
    return defaultdict(list, {node: list(keys) for node, keys in found.items()})
