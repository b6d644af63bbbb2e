"""The region between paths: its outer boundaries and holes, and its area by Green's theorem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.canonical import ranks
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray
from gimcli.reach.arcs import Cut, PathArc, PathIndex
from gimcli.reach.sampling import Bank

OUTER, HOLE, INNER, ALONE, OPEN = "outer", "hole", "inner", "alone", "open"
"""Kinds of curves. `inner` has reachable points on both sides; `alone` on none, since two inputs are at an end of their
ranges along it; `open` on none although it should have."""


@dataclass(frozen=True)
class RegionConstants:
    """Constants of the sorting; lengths relative to the mechanism's size (about 1)."""

    aside: float = 1e-3  # greatest distance from a path of the points tested for reachability
    clear: float = 0.2  # their distance relative to that of the next path
    short: float = 0.05  # their distance relative to the length of the path
    parts: tuple[float, ...] = (0.5, 0.31, 0.73, 0.11, 0.89)  # fractions of the path at which points are tested
    rounds: int = 4  # of tests, with other random starts
    hints: int = 12  # starts near the position on the path
    farthest: float = 0.3  # greatest distance of these starts
    joined: float = 1e-5  # distance below which ends are one corner: touching curves are accurate to about 4e-6
    checked: int = 400  # number of reached points for the check of the boundary
    margin: float = 1e-4  # distance from the boundary within which points are not checked
    dense: int = 6  # points per cubic of the outlines for that check


REGION = RegionConstants()


@dataclass(frozen=True, eq=False)
class Edge:
    """A piece of a curve; of a boundary, with the region to its left."""

    arc: PathArc = field(repr=False)
    kind: str
    forward: bool = True  # in the direction of the arc

    @property
    def moment(self) -> float:
        """Contribution to the area."""
        return self.arc.moment if self.forward else -self.arc.moment

    def points(self, parts: int = 4) -> FloatArray:
        """Return points (rows, 2) along the edge."""
        dense = self.arc.dense(parts)
        return dense if self.forward else dense[::-1]

    @property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """First and last point (2,)."""
        y = self.arc.y if self.forward else self.arc.y[::-1]
        return y[0], y[-1]


@dataclass(frozen=True, eq=False)
class Loop:
    """A sequence of edges; it is closed unless a curve was not found."""

    edges: tuple[Edge, ...]
    closed: bool

    @property
    def area(self) -> float:
        """Enclosed area, negative around a hole; gaps at corners are closed by straight lines."""
        ends = [edge.ends for edge in self.edges]
        gaps = [(last, first) for (_, last), (first, _) in zip(ends, [*ends[1:], ends[0]], strict=True)]
        closing = sum(0.5 * float(last[0] * first[1] - last[1] * first[0]) for last, first in gaps)
        return float(sum(edge.moment for edge in self.edges) + closing)

    def points(self, parts: int = 4) -> FloatArray:
        """Return the outline (rows, 2)."""
        return np.concatenate([edge.points(parts)[:-1] for edge in self.edges])


def sorted_edges(arcs: Sequence[PathArc], bank: Bank) -> list[Edge]:
    """Return every path with its kind, from tests of the points beside it; repeated for loops that do not close."""
    if not arcs:
        return []
    index = PathIndex(arcs)
    reached = np.array([[arc.inside > 0.0, arc.inside < 0.0] for arc in arcs])  # from the curvatures
    chosen = np.arange(len(arcs))
    for _ in range(REGION.rounds):
        _test_sides(arcs, chosen, reached, index, bank)
        edges = [_edge(arc, bool(left), bool(right)) for arc, (left, right) in zip(arcs, reached, strict=True)]
        doubtful = {id(e.arc) for loop in loops(edges) if not loop.closed for e in loop.edges}
        chosen = np.array([k for k, e in enumerate(edges) if e.kind == OPEN or id(e.arc) in doubtful], dtype=int)
        if not len(chosen):
            break
    return edges


def _test_sides(arcs: Sequence[PathArc], chosen: IntArray, reached: BoolArray, index: PathIndex, bank: Bank) -> None:
    """Test the points beside chosen paths, and set `reached` (paths, 2) for the left and right side."""
    tests = [(k, side) for k in chosen.tolist() for side in (0, 1) if not reached[k, side]]
    if not tests:
        return
    marks = _marks(list(dict(tests)), arcs, index)
    places = np.array([marks[k][0] + (1.0, -1.0)[side] * marks[k][2] * marks[k][1] for k, side in tests])
    hints = np.array([_hints(marks[k][3], marks[k][2], bank) for k, _ in tests])
    for (k, side), found in zip(tests, bank.reaches(places, hints).tolist(), strict=True):
        reached[k, side] |= found


def _edge(arc: PathArc, left: bool, right: bool) -> Edge:
    kind = INNER if left and right else OUTER if left or right else ALONE if arc.alone else OPEN
    return Edge(arc, kind, left or kind != OUTER)


Mark = tuple[FloatArray, FloatArray, float, FloatArray]
"""A point (2,) of a path, its left normal, the distance of the tests, and the position."""


def _marks(chosen: Sequence[int], arcs: Sequence[PathArc], index: PathIndex) -> dict[int, Mark]:
    """Return for every chosen path the point with the greatest distance from other paths."""
    cuts = [[arcs[k].halfway(part) for part in REGION.parts] for k in chosen]
    places = np.array([arcs[k].at(*cut) for k, own in zip(chosen, cuts, strict=True) for cut in own])
    but = np.repeat(chosen, len(REGION.parts))
    rooms = index.room(places, but, REGION.aside / REGION.clear).reshape(len(chosen), -1)
    return {k: _mark(arcs[k], own, room.tolist()) for k, own, room in zip(chosen, cuts, rooms, strict=True)}


def _mark(arc: PathArc, cuts: Sequence[Cut], rooms: Sequence[float]) -> Mark:
    best = 0
    for k, room in enumerate(rooms):
        best = k if room > 1.2 * rooms[best] else best
    cut = cuts[best]
    z, slope = arc.at(*cut), arc.slope(*cut)
    normal = np.array([-slope[1], slope[0]]) / max(float(np.linalg.norm(slope)), 1e-300)
    step = min(REGION.aside, REGION.clear * rooms[best], REGION.short * arc.length)
    return z, normal, step, arc.knot(cut).p[: arc.table.shape[1]]


def _hints(x: FloatArray, step: float, bank: Bank) -> FloatArray:
    """Return starts at several distances from a position: the point beside may belong to a close configuration."""
    spread = np.geomspace(np.sqrt(step), REGION.farthest, REGION.hints)
    return np.asarray(x + spread[:, None] * bank.rng.normal(size=(REGION.hints, len(x))))


def loops(edges: Sequence[Edge]) -> list[Loop]:
    """Return the loops of the boundary, outer ones first."""
    rest = [e for e in edges if e.kind == OUTER]
    found: list[Loop] = []
    while rest:
        chain = [rest.pop()]
        closed = chain[0].arc.closed
        while not closed:
            following = _following(chain[-1], rest)
            closed = _meets(chain[-1], chain[0]) and (following is None or len(chain) > 1)
            if closed or following is None:
                break
            rest.remove(following)
            chain.append(following)
        if not closed or sum(e.arc.length for e in chain) > REGION.joined:  # shorter chains are corners
            found.append(Loop(tuple(chain), closed))
    corners = np.array([np.min([np.min(e.points(1), axis=0) for e in loop.edges], axis=0) for loop in found])
    keys = [ranks(side, REGION.joined) for side in corners.reshape(-1, 2).T[::-1]]
    order = np.lexsort((*keys, ranks(np.array([-loop.area for loop in found]), REGION.joined)))
    return [_named(found[k]) for k in order]


def _named(loop: Loop) -> Loop:
    """Return a loop whose edges have the kind of an outer boundary or of a hole."""
    kind = OUTER if loop.area > 0.0 else HOLE
    return replace(loop, edges=tuple(replace(e, kind=kind) for e in loop.edges))


def _meets(first: Edge, second: Edge) -> bool:
    return float(np.linalg.norm(first.ends[1] - second.ends[0])) <= REGION.joined


def _following(edge: Edge, rest: Sequence[Edge]) -> Edge | None:
    """Return the edge that begins at the end of another: of several the leftmost, so that loops do not cross."""
    offers = [other for other in rest if _meets(edge, other)]
    if len(offers) < 2:
        return offers[0] if offers else None
    come = edge.points(1)
    back = complex(*(come[-2] - come[-1]))

    def turn(other: Edge) -> float:
        go = other.points(1)
        return float(np.angle(complex(*(go[1] - go[0])) / back)) % (2.0 * np.pi)

    return max(offers, key=turn)


def outside(found: Sequence[Loop], others: Sequence[Edge], y: FloatArray) -> int:
    """Return the number of reached points (rows, 2) that are neither inside the loops nor on other curves.

    It is 0 if the boundary is complete.
    """
    y = y[: REGION.checked]
    winding, gap, z = np.zeros(len(y)), np.full(len(y), np.inf), y @ np.array([1.0, 1.0j])
    for loop in found:
        outline = loop.points(REGION.dense) @ np.array([1.0, 1.0j])
        seen = np.append(outline, outline[0]) - z[:, None]
        gap = np.minimum(gap, np.min(_distances(seen[:, :-1], seen[:, 1:]), axis=1))
        safe = np.where(seen == 0.0, 1.0, seen)
        winding += np.sum(np.angle(safe[:, 1:] / safe[:, :-1]), axis=1) / (2.0 * np.pi)
    for edge in others:
        seen = edge.points(REGION.dense) @ np.array([1.0, 1.0j]) - z[:, None]
        gap = np.minimum(gap, np.min(_distances(seen[:, :-1], seen[:, 1:]), axis=1))
    return int(np.sum((np.round(winding) < 1.0) & (gap > REGION.margin)))


def _distances(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Return the distances of the origin from segments."""
    step = second - first
    square = np.maximum(np.abs(step) ** 2, np.finfo(float).tiny)
    part = np.clip(-(first * step.conjugate()).real / square, 0.0, 1.0)
    return np.asarray(np.abs(first + part * step))
