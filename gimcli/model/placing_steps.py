"""The steps that place nodes one after the other, and their order.

The order depends on the structure alone; each step has one position for its nodes, or two: `left` and `right`.
"""

from __future__ import annotations

import heapq
from abc import ABC, abstractmethod
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass
from typing import Any, ClassVar

from gimcli.calculus.numbers import FUNCTIONS, nominal
from gimcli.model.placing_data import GivenLine, GivenShape, PlacingData, height, meeting, unit

Places = Mapping[str, Any]
"""Positions of nodes as complex numbers, file's unit of length."""

TOUCHING = 1e-12
"""Gap between two loci, relative to their size, that is rounding: they touch."""


class Gap(Exception):  # noqa: N818  # an outcome, not an error
    """The loci of a step do not meet; `amount` is by how much (file's unit)."""

    def __init__(self, text: str, amount: float) -> None:
        super().__init__(text)
        self.text, self.amount = text, amount


CERTAIN, NODES, MEMBERS = range(3)
"""Ranks: steps without a choice are first, then nodes by two loci, then members that turn about a node."""


@dataclass(frozen=True)
class PlacingStep(ABC):
    """A step that places nodes; the first one is the node whose side chooses, if there is a choice."""

    nodes: tuple[str, ...]
    rank: ClassVar[int] = CERTAIN

    @property
    def node(self) -> str:
        """The first of its nodes."""
        return self.nodes[0]

    @property
    def owner(self) -> str:
        """The node whose side chooses; "" if there is no choice."""
        return self.node if self.rank > CERTAIN else ""

    @abstractmethod
    def positions(self, at: Places) -> list[dict[str, Any]]:
        """Return the positions of its nodes from those of the nodes before: one, or those for `left` and `right`.

        Raises Gap if there is none.
        """


# -- loci -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class CircleLocus:
    """The circle about a node that is placed."""

    name: str  # of the member, or of the actuator
    centre: str
    radius: Any

    def __str__(self) -> str:
        return f"{self.name} ({number(self.radius)})"


def number(value: Any) -> str:
    """Return a number of a message."""
    return format(float(nominal(value)), ".6g")


def _root(square: Any, scale: float) -> Any:
    """Return the square root of a number that is not negative beyond rounding; None if it is."""
    if nominal(square) <= 0.0:
        return 0.0 if nominal(square) >= -TOUCHING * scale * scale else None
    return FUNCTIONS["sqrt"](square)


# -- steps ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class MemberStep(PlacingStep):
    """A member of which a node is placed."""

    shape: GivenShape
    placed: str

    def turned(self, at: Places, turn: Any) -> dict[str, Any]:
        """Return the positions of its nodes if the member is turned from its own frame by a complex factor."""
        local, nodes = self.shape.local, set(self.nodes)
        return {n: at[self.placed] + turn * (local[n] - local[self.placed]) for n in local if n in nodes}


@dataclass(frozen=True)
class TurnStep(MemberStep):
    """A member with a known direction: it is at an angle to that of two nodes that are placed, or to +x."""

    pivot: str
    tip: str  # node of the member whose direction from the pivot is known
    base: str | None  # node whose direction from the pivot is 0; None: +x
    angle: Any = 0.0

    def positions(self, at: Places) -> list[dict[str, Any]]:
        """Return the only positions."""
        local, pivot = self.shape.local, self.pivot
        zero = 1.0 + 0.0j if self.base is None else unit(at[self.base] - at[pivot])
        cos, sin = FUNCTIONS["cos"](self.angle), FUNCTIONS["sin"](self.angle)
        return [self.turned(at, zero * (cos + 1j * sin) / unit(local[self.tip] - local[pivot]))]


@dataclass(frozen=True)
class CrossedLines(PlacingStep):
    """A node on two lines."""

    loci: tuple[GivenLine, GivenLine]

    def positions(self, at: Places) -> list[dict[str, Any]]:
        """Return the only position."""
        one, other = self.loci
        met = meeting(one.line(at), other.line(at))
        if met is None:
            raise Gap(f"the lines of {one.name} and {other.name} are parallel", 0.0)
        return [{self.node: met}]


@dataclass(frozen=True)
class CrossedCircles(PlacingStep):
    """A node at known distances from two nodes; left and right as seen from the first to the second centre."""

    loci: tuple[CircleLocus, CircleLocus]
    rank = NODES

    def positions(self, at: Places) -> list[dict[str, Any]]:
        """Return the positions to the left and to the right."""
        one, other = self.loci
        p, q, r, s = at[one.centre], at[other.centre], one.radius, other.radius
        far = abs(q - p)
        apart, near, reach = float(nominal(far)), float(abs(nominal(r - s))), float(nominal(r + s))
        if apart <= TOUCHING * reach:
            raise Gap(f"{one.centre} and {other.centre} coincide, and leave the position of {self.node} open", 0.0)
        along = (far * far + r * r - s * s) / (2.0 * far)
        across = _root((r - along) * (r + along), reach)
        if across is None:
            raise Gap(*self._gap(apart, near, reach))
        foot, square = p + (q - p) / far * along, 1j * (q - p) / far * across
        return [{self.node: foot + square}, {self.node: foot - square}]

    def _gap(self, apart: float, near: float, reach: float) -> tuple[str, float]:
        one, other = self.loci
        span = f"{one.centre} and {other.centre} are {number(apart)} apart"
        if apart > reach:
            both = f"{one} and {other} together reach only {number(reach)}"
            return f"{span}, but {both}: {number(apart - reach)} too short", apart - reach
        long, short = (one, other) if nominal(one.radius) > nominal(other.radius) else (other, one)
        return f"{span}, but {long} and {short} need at least {number(near)}: {number(near - apart)} more", near - apart


@dataclass(frozen=True)
class CircleAndLine(PlacingStep):
    """A node on a line at a known distance from a node; right is the position farther along the line."""

    circle: CircleLocus
    locus: GivenLine
    rank = NODES

    def positions(self, at: Places) -> list[dict[str, Any]]:
        """Return the positions to the left (behind) and to the right (ahead), along the line."""
        centre, r = at[self.circle.centre], self.circle.radius
        point, along = self.locus.line(at)
        away = height((point, along), centre)
        across = _root((r - away) * (r + away), float(nominal(r)))
        if across is None:
            most, short = abs(float(nominal(away))), abs(float(nominal(away))) - float(nominal(r))
            text = f"{self.circle.centre} is {number(most)} from the line of {self.locus.name}"
            raise Gap(f"{text}, but {self.circle} is {number(short)} too short for it", short)
        foot = centre - 1j * along * away
        return [{self.node: foot - along * across}, {self.node: foot + along * across}]


@dataclass(frozen=True)
class SlotThroughNode(MemberStep):
    """A member of which one node is placed, turned so that its line passes through a node.

    Right: this node is farther along the guide than the node that is placed; left: it is behind it.
    """

    slot: GivenLine
    slider: str
    rank = MEMBERS

    def positions(self, at: Places) -> list[dict[str, Any]]:
        """Return the positions for `left` and for `right`."""
        local, ray = self.shape.local, at[self.slider] - at[self.placed]
        line = self.slot.line(local)
        away = -height(line, local[self.placed])
        far = abs(ray)
        if float(nominal(far)) <= TOUCHING * max(abs(nominal(z)) for z in local.values()):
            text = f"{self.slider} and {self.placed} coincide, and leave the direction of {self.shape.name} open"
            raise Gap(text, 0.0)
        ahead = _root((far - away) * (far + away), float(nominal(far)))
        if ahead is None:
            short = abs(float(nominal(away))) - float(nominal(far))
            text = f"{self.slider} is {number(far)} from {self.placed}, but the line of {self.slot.name} passes it at"
            raise Gap(f"{text} {number(abs(nominal(away)))}: {number(short)} more", short)
        turns = (ray * (sign * ahead - 1j * away) / (far * far) / line[1] for sign in (-1.0, 1.0))
        return [self.turned(at, turn) for turn in turns]


# -- order ----------------------------------------------------------------------------------

Key = tuple[str, str]


def steps_of(data: PlacingData, placed: Set[str]) -> tuple[list[PlacingStep], set[str]]:
    """Return the steps that place nodes, beginning with those that are placed, and the nodes that are left."""
    order = _Order(data, placed)
    return list(order.steps()), set(data.order) - order.known


class _Order:
    """The steps that are possible with the nodes that are placed so far."""

    def __init__(self, data: PlacingData, placed: Set[str]) -> None:
        self.data, self.known = data, set(placed)
        self.shapes = {shape.name: shape for shape in (*data.shapes, *data.distances)}
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
        return [found[name] for name in sorted(found, key=self.rank.__getitem__)]


def _neighbours(data: PlacingData) -> dict[str, list[Key]]:
    """Return the members and nodes whose steps may change when a node is placed, by node."""
    found: dict[str, dict[Key, None]] = defaultdict(dict)
    of_member: dict[str, dict[str, None]] = defaultdict(dict)
    for shape in (*data.shapes, *data.distances):
        keys = dict.fromkeys([("member", shape.name), *(("node", name) for name in shape.local)])
        for node in shape.local:
            of_member[node][shape.name] = None
            found[node].update(keys)
    groups = [(*one.guide, *one.nodes) for one in data.lines]
    groups += [tuple(n for n in (g.pivot, g.arm, g.reference) if n is not None) for g in data.angles]
    for names in groups:
        count = Counter(member for node in names for member in of_member[node])
        keys = dict.fromkeys([*(("member", m) for m, n in count.items() if n > 1), *(("node", n) for n in names)])
        for node in names:
            found[node].update(keys)
    return defaultdict(list, {node: list(keys) for node, keys in found.items()})
