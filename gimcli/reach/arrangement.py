"""Paths cut at all their meetings, each of those that lie upon each other once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.mechanism import FloatArray
from gimcli.reach.arcs import Crowd, Cut, Meeting, PathArc, footpoints


def arranged(arcs: Sequence[PathArc], meeting: Meeting | None = None) -> list[PathArc]:
    """Return paths that meet at their ends only, none twice and none a point."""
    meeting = meeting or Meeting()
    pieces = [piece for arc in arcs if arc.length > meeting.least for piece in _once(arc, meeting)]
    pieces = distinct(pieces, meeting)
    pieces = _cut(pieces, _at_ends(pieces, meeting))
    pieces = distinct([p for p in pieces if p.length > meeting.least], meeting)
    pieces = _cut(pieces, _at_crossings(pieces, meeting))
    return distinct([p for p in pieces if p.length > meeting.same], meeting)


def _once(arc: PathArc, meeting: Meeting) -> list[PathArc]:
    """Return a path that runs over itself in thirds, so that each place is in one of them once."""
    thirds = arc.cut([arc.halfway(part) for part in ((1 / 6, 1 / 2, 5 / 6) if arc.closed else (1 / 3, 2 / 3))])
    for part in thirds:
        z = part.at(*part.halfway(0.5))[None, :]
        if any(other is not part and footpoints(other, z, meeting)[0] is not None for other in thirds):
            return thirds
    return [arc]


def distinct(arcs: Sequence[PathArc], meeting: Meeting) -> list[PathArc]:
    """Return the paths without those that lie upon another."""
    kept: list[PathArc] = []
    for arc in sorted(arcs, key=lambda a: len(a.held)):
        if not any(_same(arc, other, meeting) for other in kept):
            kept.append(arc)
    return kept


def _same(a: PathArc, b: PathArc, meeting: Meeting) -> bool:
    """Return whether two paths of one length are one."""
    if abs(a.length - b.length) > 10.0 * meeting.same:
        return False
    marks = np.array([a.at(*a.halfway(part)) for part in (0.25, 0.5, 0.8)])
    return None not in footpoints(b, marks, meeting)


def _at_ends(arcs: Sequence[PathArc], meeting: Meeting) -> list[list[Cut]]:
    """Return where an end of a path lies on another path."""
    ends = _ends(arcs, meeting)
    return [[cut for cut in footpoints(arc, ends, meeting) if cut and _inner(arc, cut, meeting)] for arc in arcs]


def _at_crossings(arcs: Sequence[PathArc], meeting: Meeting) -> list[list[Cut]]:
    cuts: list[list[Cut]] = [[] for _ in arcs]
    for k, cut in Crowd(arcs).crossings(meeting) if arcs else ():
        if _inner(arcs[k], cut, meeting):
            cuts[k].append(cut)
    return cuts


def _ends(arcs: Sequence[PathArc], meeting: Meeting) -> FloatArray:
    """Return the ends (rows, 2) of the open paths, each once."""
    ends: list[FloatArray] = []
    for arc in arcs:
        for z in () if arc.closed else (arc.y[0], arc.y[-1]):
            if not any(np.linalg.norm(z - other) < 0.1 * meeting.same for other in ends):
                ends.append(z)
    return np.reshape(ends, (-1, 2))


def _inner(arc: PathArc, cut: Cut, meeting: Meeting) -> bool:
    """Return whether a cut is away from the path's ends."""
    if arc.closed:
        return True
    z = arc.at(*cut)
    return float(min(np.linalg.norm(z - arc.y[0]), np.linalg.norm(z - arc.y[-1]))) > 5.0 * meeting.same


def _cut(arcs: Sequence[PathArc], cuts: Sequence[list[Cut]]) -> list[PathArc]:
    return [piece for arc, at in zip(arcs, cuts, strict=True) for piece in (arc.cut(at) if at else [arc])]
