"""The steps that place nodes one after the other, and their order.

The order depends on the structure alone; each step has one position for its nodes, or two: `left` and `right`.
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from functools import partial
from typing import Any, NamedTuple

from gimcli.calculus.numbers import FUNCTIONS, nominal
from gimcli.connected import grouped
from gimcli.model.placing_data import GivenLine, Line, PlacingData, Shape, height, meeting, unit

Places = Mapping[str, Any]
"""Positions of nodes as complex numbers, file's unit of length."""

SIDES = ("left", "right")

TOUCHING = 1e-12
"""Gap between two loci, relative to their size, that is rounding: they touch."""


class Gap(Exception):  # noqa: N818  # an outcome, not an error
    """The loci of a step do not meet; `amount` is by how much (file's unit)."""

    node: str
    number: int  # of the step

    def __init__(self, text: str, amount: float = 0.0) -> None:
        super().__init__(text)
        self.text, self.amount = text, amount


CERTAIN, NODES, MEMBERS = range(3)
"""Ranks: steps without a choice are first, then nodes by two loci, then members that turn about a node."""


class PlacingStep(NamedTuple):
    """A step that places one node, or the nodes of a member of which a node is placed."""

    nodes: tuple[str, ...]
    rank: int
    positions: Callable[[Places], list[dict[str, Any]]]
    """The positions of its nodes from those before: one, or left and right; raises Gap if there is none."""
    side: str | None = None  # the usual one, if there is a choice

    @property
    def node(self) -> str:
        """The first of its nodes."""
        return self.nodes[0]

    @property
    def owner(self) -> str:
        """The node whose side chooses; "" if there is no choice."""
        return self.node if self.rank > CERTAIN else ""


def _single(node: str, formula: Callable[[Places], list[Any]], at: Places) -> list[dict[str, Any]]:
    """Return the positions of one node."""
    return [{node: z} for z in formula(at)]


def _turned(
    nodes: Sequence[str], shape: Shape, placed: str, turns: Callable[[Places], list[Any]], at: Places
) -> list[dict[str, Any]]:
    """Return the positions of nodes of a member about a placed one, for factors that turn its own frame."""
    moved = [n for n in shape if n in nodes]
    return [{n: at[placed] + turn * (shape[n] - shape[placed]) for n in moved} for turn in turns(at)]


# -- loci -----------------------------------------------------------------------------------


class CircleLocus(NamedTuple):
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


def _on_line(line: Line, centre: Any, radius: Any) -> tuple[list[Any], float]:
    """Return the points of a line at a distance from a centre, behind and ahead, and the distance of the line.

    There are none if the line is too far.
    """
    away, along = height(line, centre), line[1]
    across = _root((radius - away) * (radius + away), float(nominal(radius)))
    foot = centre - 1j * along * away
    points = [] if across is None else [foot - along * across, foot + along * across]
    return points, abs(float(nominal(away)))


# -- formulas -------------------------------------------------------------------------------


def _crossed_lines(one: GivenLine, other: GivenLine, at: Places) -> list[Any]:
    """Return the only position of a node on two lines."""
    met = meeting(one.line(at), other.line(at))
    if met is None:
        raise Gap(f"the lines of {one.name} and {other.name} are parallel")
    return [met]


def _crossed_circles(node: str, one: CircleLocus, other: CircleLocus, at: Places) -> list[Any]:
    """Return the positions of a node at known distances from two nodes, left and right of their line."""
    p, q, r, s = at[one.centre], at[other.centre], one.radius, other.radius
    far = abs(q - p)
    apart, near, reach = float(nominal(far)), float(abs(nominal(r - s))), float(nominal(r + s))
    if apart <= TOUCHING * reach:
        raise Gap(f"{one.centre} and {other.centre} coincide, and leave the position of {node} open")
    along = (far * far + r * r - s * s) / (2.0 * far)
    across = _root((r - along) * (r + along), reach)
    if across is not None:
        foot, square = p + (q - p) / far * along, 1j * (q - p) / far * across
        return [foot + square, foot - square]
    span = f"{one.centre} and {other.centre} are {number(apart)} apart, but"
    if apart > reach:
        raise Gap(f"{span} {one} and {other} together reach only {number(reach)}: {number(apart - reach)} too short",
                  apart - reach)  # fmt: skip
    long, short = (one, other) if nominal(r) > nominal(s) else (other, one)
    raise Gap(f"{span} {long} and {short} need at least {number(near)}: {number(near - apart)} more", near - apart)


def _circle_and_line(circle: CircleLocus, line: GivenLine, at: Places) -> list[Any]:
    """Return the positions of a node on a line at a known distance from a node: behind and ahead, along the line."""
    found, away = _on_line(line.line(at), at[circle.centre], circle.radius)
    if not found:
        short = away - float(nominal(circle.radius))
        text = f"{circle.centre} is {number(away)} from the line of {line.name}, but {circle}"
        raise Gap(f"{text} is {number(short)} too short for it", short)
    return found


def _direction(shape: Shape, pivot: str, tip: str, base: str | None, angle: Any, at: Places) -> list[Any]:
    """Return the only turn of a member whose ray pivot -> tip is at an angle to pivot -> base, or to +x."""
    zero = 1.0 + 0.0j if base is None else unit(at[base] - at[pivot])
    cos, sin = FUNCTIONS["cos"](angle), FUNCTIONS["sin"](angle)
    return [zero * (cos + 1j * sin) / unit(shape[tip] - shape[pivot])]


def _through(name: str, local: Shape, placed: str, slot: GivenLine, slider: str, at: Places) -> list[Any]:
    """Return the turns of a member whose line passes through a node, which is behind or ahead of the placed one."""
    ray = at[slider] - at[placed]
    far = float(nominal(abs(ray)))
    if far <= TOUCHING * max(abs(nominal(z)) for z in local.values()):
        raise Gap(f"{slider} and {placed} coincide, and leave the direction of {name} open")
    found, away = _on_line(slot.line(local), local[placed], abs(ray))
    if not found:
        text = f"{slider} is {number(far)} from {placed}, but the line of {slot.name} passes it at {number(away)}"
        raise Gap(f"{text}: {number(away - far)} more", away - far)
    return [ray / (z - local[placed]) for z in found]


# -- order ----------------------------------------------------------------------------------

Key = tuple[str, str]


class Order:
    """The steps that are possible with the nodes that are placed so far."""

    def __init__(self, data: PlacingData, placed: Set[str]) -> None:
        self.data, self.known = data, set(placed)
        self.rank = {name: k for k, name in enumerate((*data.shapes, *data.order))}
        self.beside = _neighbours(data)
        self.ready, self.queue = dict[Key, PlacingStep | None](), list[tuple[int, int, Key]]()

    def steps(self) -> Iterator[PlacingStep]:
        """Yield the steps; the first possible one is always taken."""
        self._update([*(("member", name) for name in self.data.shapes), *(("node", name) for name in self.data.order)])
        while self.queue:
            rank, _, key = heapq.heappop(self.queue)
            step = self.ready[key]
            if step is not None and step.rank == rank and not self.known.issuperset(step.nodes):
                yield step
                self.known.update(step.nodes)
                self._update(dict.fromkeys(key for node in step.nodes for key in self.beside[node]))

    def _update(self, keys: Iterable[Key]) -> None:
        for kind, name in keys:
            steps = self._of_member(name, self.data.shapes[name]) if kind == "member" else self._of_node(name)
            step = self.ready[kind, name] = next(steps, None)
            if step is not None:
                heapq.heappush(self.queue, (step.rank, self.rank[name], (kind, name)))

    # -- members ------------------------------------------------------------------------------

    def _of_member(self, name: str, shape: Shape) -> Iterator[PlacingStep]:
        """Yield the steps that place a whole member, those without a choice first."""
        have = [n for n in shape if n in self.known]
        if not have or len(have) == len(shape):
            return
        first, lack = have[0], tuple(n for n in shape if n not in self.known)
        for turn in self._turns(shape, have):
            yield PlacingStep(lack, CERTAIN, partial(_turned, lack, shape, first, partial(_direction, shape, *turn)))
        for slot in self.data.lines if len(have) == 1 else ():
            if not slot.square and set(slot.guide) <= shape.keys():
                nodes = tuple(dict.fromkeys((*(n for n in slot.guide if n in lack), *lack)))
                for slider in (node for node in slot.nodes if node in self.known and node not in shape):
                    turns = partial(_through, name, shape, first, slot, slider)
                    yield PlacingStep(nodes, MEMBERS, partial(_turned, nodes, shape, first, turns))

    def _turns(self, shape: Shape, have: Sequence[str]) -> Iterator[tuple[str, str, str | None, Any]]:
        """Yield pivot and tip of a known direction of a member, the node from whose direction it is, and the angle."""
        if len(have) > 1:
            yield have[0], have[1], have[1], 0.0
        own = shape.keys()
        for one, angle in self.data.angles.values() if len(have) == 1 else ():
            pivot, arm, base = str(one.pivot), str(one.arm), one.reference
            if {pivot, arm} <= own and (base is None or (base not in own and {pivot, base} <= self.known)):
                yield pivot, arm, base, angle
            elif base is not None and {pivot, base} <= own and arm not in own and {pivot, arm} <= self.known:
                yield pivot, base, arm, -angle

    # -- nodes --------------------------------------------------------------------------------

    def _of_node(self, node: str) -> Iterator[PlacingStep]:
        """Yield the steps that place one node by two of its loci, those without a choice first."""
        if node in self.known:
            return
        lines, circles = self._lines(node), self._circles(node)
        if len(lines) > 1:
            yield PlacingStep((node,), CERTAIN, partial(_single, node, partial(_crossed_lines, lines[0], lines[1])))
        elif lines and circles:
            line, circle = lines[0], circles[0]
            block = {node, circle.centre} == set(line.nodes)  # a sliding pair without rotation: the second is ahead
            usual = SIDES[line.nodes.index(node)] if block else None
            yield PlacingStep((node,), NODES, partial(_single, node, partial(_circle_and_line, circle, line)), usual)
        elif len(circles) > 1:
            yield PlacingStep(
                (node,), NODES, partial(_single, node, partial(_crossed_circles, node, circles[0], circles[1]))
            )

    def _lines(self, node: str) -> list[GivenLine]:
        """Return the lines on which a node is, one for each guide and kind."""
        own = (one for one in self.data.lines if node in one.nodes and self.known.issuperset(one.guide))
        return [*{(one.square, one.guide): one for one in own}.values()]

    def _circles(self, node: str) -> list[CircleLocus]:
        """Return the circles on which a node is, one for each centre, in the order of the file's nodes."""
        found: dict[str, CircleLocus] = {}
        for kind, name in self.beside[node]:
            if kind == "member" and node in (local := self.data.shapes[name]):
                for other in (n for n in local if n in self.known):
                    found.setdefault(other, CircleLocus(name, other, abs(local[node] - local[other])))
        return [found[name] for name in sorted(found, key=self.rank.__getitem__)]


def _neighbours(data: PlacingData) -> dict[str, dict[Key, None]]:
    """Return the members and nodes whose steps may change when a node is placed, by node."""
    found: dict[str, dict[Key, None]] = defaultdict(dict)
    of_member = grouped((node, name) for name, shape in data.shapes.items() for node in shape)
    groups = [(*one.guide, *one.nodes) for one in data.lines] + [(*one.named,) for one, _ in data.angles.values()]
    counts = (Counter(member for node in names for member in of_member.get(node, ())) for names in groups)
    two = [(names, [m for m, n in count.items() if n > 1]) for names, count in zip(groups, counts, strict=True)]
    for names, members in (*((tuple(shape), [name]) for name, shape in data.shapes.items()), *two):
        keys = dict.fromkeys([*(("member", name) for name in members), *(("node", name) for name in names)])
        for node in names:
            found[node].update(keys)
    return found
