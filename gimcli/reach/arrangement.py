"""Cutting of paths at all their intersections, without duplicates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.connected import unlike
from gimcli.mechanism import FloatArray
from gimcli.reach.arcs import MEETING, Cut, PathArc, PathIndex, footpoints


def arranged(arcs: Sequence[PathArc]) -> list[PathArc]:
    """Return paths that meet only at their ends, without duplicates and without paths of zero length."""
    pieces = [piece for arc in arcs if arc.length > MEETING.least for piece in _once(arc)]
    pieces = distinct(pieces)
    pieces = _cut(pieces, _at_ends(pieces))
    pieces = distinct([p for p in pieces if p.length > MEETING.least])
    pieces = _cut(pieces, _at_crossings(pieces))
    return distinct([p for p in pieces if p.length > MEETING.same])


def _once(arc: PathArc) -> list[PathArc]:
    """Return the path, or its thirds if it covers itself, so that each part covers a point only once."""
    thirds = arc.cut([arc.halfway(part) for part in ((1 / 6, 1 / 2, 5 / 6) if arc.closed else (1 / 3, 2 / 3))])
    for part in thirds:
        z = part.at(*part.halfway(0.5))[None, :]
        if any(other is not part and footpoints(other, z)[0] is not None for other in thirds):
            return thirds
    return [arc]


def distinct(arcs: Sequence[PathArc]) -> list[PathArc]:
    """Return the paths without duplicates."""
    return unlike(sorted(arcs, key=lambda a: len(a.held)), _same)


def _same(a: PathArc, b: PathArc) -> bool:
    """Return whether two paths are the same curve."""
    if abs(a.length - b.length) > 10.0 * MEETING.same:
        return False
    marks = np.array([a.at(*a.halfway(part)) for part in (0.25, 0.5, 0.8)])
    return None not in footpoints(b, marks)


def _at_ends(arcs: Sequence[PathArc]) -> list[list[Cut]]:
    """Return for each path the cuts at which another path ends."""
    ends = _ends(arcs)
    return [[cut for cut in footpoints(arc, ends) if cut and _inner(arc, cut)] for arc in arcs]


def _at_crossings(arcs: Sequence[PathArc]) -> list[list[Cut]]:
    cuts: list[list[Cut]] = [[] for _ in arcs]
    for k, cut in PathIndex(arcs).crossings() if arcs else ():
        if _inner(arcs[k], cut):
            cuts[k].append(cut)
    return cuts


def _ends(arcs: Sequence[PathArc]) -> FloatArray:
    """Return the ends (rows, 2) of the open paths, without duplicates."""
    ends = (z for arc in arcs if not arc.closed for z in (arc.y[0], arc.y[-1]))
    kept = unlike(ends, lambda z, other: bool(np.linalg.norm(z - other) < 0.1 * MEETING.same))
    return np.reshape(kept, (-1, 2))


def _inner(arc: PathArc, cut: Cut) -> bool:
    """Return whether a cut is not at an end of the path."""
    if arc.closed:
        return True
    z = arc.at(*cut)
    return float(min(np.linalg.norm(z - arc.y[0]), np.linalg.norm(z - arc.y[-1]))) > 5.0 * MEETING.same


def _cut(arcs: Sequence[PathArc], cuts: Sequence[list[Cut]]) -> list[PathArc]:
    return [piece for arc, at in zip(arcs, cuts, strict=True) for piece in (arc.cut(at) if at else [arc])]
