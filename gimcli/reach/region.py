"""The region between paths: which of them bound it, from outside or around a hole, and its area by Green's theorem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gimcli.mechanism import ComplexArray, FloatArray, IntArray
from gimcli.reach.arcs import Crowd, Cut, PathArc
from gimcli.reach.sampling import Bank

OUTER, HOLE, INNER, ALONE, OPEN = "outer", "hole", "inner", "alone", "open"
"""Kinds of curves: `inner` has reachable places on both sides, `alone` on none, as two inputs stand at an end all along
it; `open` has none where there should be."""


@dataclass(frozen=True)
class RegionConstants:
    """Constants of the sorting; lengths relative to the mechanism's size (about 1)."""

    aside: float = 1e-3  # from a path, at most: where reachability is asked
    clear: float = 0.2  # part of the distance to the next path
    short: float = 0.05  # and of the path's own length
    parts: tuple[float, ...] = (0.5, 0.31, 0.73, 0.11, 0.89)  # places of a path that are tried
    rounds: int = 4  # of trying: starts are random
    hints: int = 12  # starts about the path's own position
    farthest: float = 0.3  # from it
    joined: float = 1e-5  # ends nearer than this are one corner: where curves touch it is known to about 4e-6
    checked: int = 400  # positions that must lie within the boundary
    margin: float = 1e-4  # but those nearer to it than this
    dense: int = 6  # points a cubic of the outlines for that check


REGION = RegionConstants()


@dataclass(frozen=True, eq=False)
class Edge:
    """A piece of a curve; of a boundary, with the region to its left."""

    arc: PathArc = field(repr=False)
    kind: str
    forward: bool = True  # the way of the arc

    @property
    def moment(self) -> float:
        """Its part of the area."""
        return self.arc.moment if self.forward else -self.arc.moment

    def points(self, parts: int = 4) -> FloatArray:
        """Return points (rows, 2) along it."""
        dense = self.arc.dense(parts)
        return dense if self.forward else dense[::-1]

    @property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """Where it begins and ends."""
        y = self.arc.y if self.forward else self.arc.y[::-1]
        return y[0], y[-1]


@dataclass(frozen=True, eq=False)
class Loop:
    """Edges that follow each other; closed but for what was not found."""

    edges: tuple[Edge, ...]
    closed: bool

    @property
    def area(self) -> float:
        """Enclosed area, negative around a hole; what corners leave open is closed straight."""
        ends = [edge.ends for edge in self.edges]
        gaps = [(last, first) for (_, last), (first, _) in zip(ends, [*ends[1:], ends[0]], strict=True)]
        closing = sum(0.5 * float(last[0] * first[1] - last[1] * first[0]) for last, first in gaps)
        return float(sum(edge.moment for edge in self.edges) + closing)

    def points(self, parts: int = 4) -> FloatArray:
        """Return its outline (rows, 2)."""
        return np.concatenate([edge.points(parts)[:-1] for edge in self.edges])


def sorted_edges(arcs: Sequence[PathArc], bank: Bank) -> list[Edge]:
    """Return every path with what it is: the places beside it are tried, those of a loop that does not close again."""
    if not arcs:
        return []
    crowd = Crowd(arcs)
    reached = np.array([[arc.inside > 0.0, arc.inside < 0.0] for arc in arcs])  # by the curve's own curvatures
    chosen = np.arange(len(arcs))
    for _ in range(REGION.rounds):
        _ask(arcs, chosen, reached, crowd, bank)
        edges = [_edge(arc, bool(left), bool(right)) for arc, (left, right) in zip(arcs, reached, strict=True)]
        doubtful = {id(e.arc) for loop in loops(edges) if not loop.closed for e in loop.edges}
        chosen = np.array([k for k, e in enumerate(edges) if e.kind == OPEN or id(e.arc) in doubtful], dtype=int)
        if not len(chosen):
            break
    return edges


def _ask(arcs: Sequence[PathArc], chosen: IntArray, reached: NDArray[np.bool_], crowd: Crowd, bank: Bank) -> None:
    """Try the places beside some paths that are not known to be reached; note in `reached` (paths, 2) what is."""
    asked = [(k, side) for k in chosen.tolist() for side in (0, 1) if not reached[k, side]]
    if not asked:
        return
    marks = _marks(list(dict(asked)), arcs, crowd)
    places = np.array([marks[k][0] + (1.0, -1.0)[side] * marks[k][2] * marks[k][1] for k, side in asked])
    hints = np.array([_hints(marks[k][3], marks[k][2], bank) for k, _ in asked])
    for (k, side), found in zip(asked, bank.reaches(places, hints).tolist(), strict=True):
        reached[k, side] |= found


def _edge(arc: PathArc, left: bool, right: bool) -> Edge:
    if left and right:
        return Edge(arc, INNER)
    if not (left or right):
        return Edge(arc, ALONE if arc.alone else OPEN)
    return Edge(arc, OUTER, left)


Mark = tuple[FloatArray, FloatArray, float, FloatArray]
"""A place (2,) of a path, the normal to its left, how far to go, and the position."""


def _marks(chosen: Sequence[int], arcs: Sequence[PathArc], crowd: Crowd) -> dict[int, Mark]:
    """Return the place with most room about it of every chosen path."""
    cuts = [[arcs[k].halfway(part) for part in REGION.parts] for k in chosen]
    places = np.array([arcs[k].at(*cut) for k, own in zip(chosen, cuts, strict=True) for cut in own])
    but = np.repeat(chosen, len(REGION.parts))
    rooms = crowd.room(places, but, REGION.aside / REGION.clear).reshape(len(chosen), -1)
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
    """Return starts next to a position and farther off: the way on may be by another configuration close by."""
    spread = np.geomspace(np.sqrt(step), REGION.farthest, REGION.hints)
    return np.asarray(x + spread[:, None] * bank.rng.normal(size=(REGION.hints, len(x))))


def loops(edges: Sequence[Edge]) -> list[Loop]:
    """Return the boundary's edges in their order around the region, outer ones first."""
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
        if not closed or sum(e.arc.length for e in chain) > REGION.joined:  # what is shorter is a corner
            found.append(Loop(tuple(chain), closed))
    return [_named(loop) for loop in sorted(found, key=lambda loop: -loop.area)]


def _named(loop: Loop) -> Loop:
    """Return a loop whose edges say whether they go around a hole."""
    kind = OUTER if loop.area > 0.0 else HOLE
    return replace(loop, edges=tuple(replace(e, kind=kind) for e in loop.edges))


def _meets(first: Edge, second: Edge) -> bool:
    return float(np.linalg.norm(first.ends[1] - second.ends[0])) <= REGION.joined


def _following(edge: Edge, rest: Sequence[Edge]) -> Edge | None:
    """Return the edge that begins where one ends: of several, the leftmost, so that loops touch but do not cross."""
    offers = [other for other in rest if _meets(edge, other)]
    if len(offers) < 2:
        return offers[0] if offers else None
    come = edge.points(1)
    back = complex(*(come[-2] - come[-1]))

    def turn(other: Edge) -> float:
        go = other.points(1)
        angle = float(np.angle(complex(*(go[1] - go[0])) / back))
        return angle % (2.0 * np.pi)

    return max(offers, key=turn)


def outside(found: Sequence[Loop], others: Sequence[Edge], y: FloatArray) -> int:
    """Return how many of some reached places (rows, 2) the loops do not enclose, nor lie on other curves.

    0 if all of the boundary is known.
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
    """Return the distances of 0 from segments."""
    step = second - first
    square = np.maximum(np.abs(step) ** 2, np.finfo(float).tiny)
    part = np.clip(-(first * step.conjugate()).real / square, 0.0, 1.0)
    return np.asarray(np.abs(first + part * step))
