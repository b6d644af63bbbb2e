"""Rigid triangles of members: three bodies that are joined in pairs by three pins cannot move relative to each other.

Such a triangle is one rigid body, but as separate members it has two configurations (mirror images).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

from gimcli.connected import grouped
from gimcli.mechanism import FRAME, Mechanism
from gimcli.structure.derived import derived


@dataclass(frozen=True)
class RigidTriangle:
    """Three bodies joined by three pins; a body is a member, or members that form rigid triangles already."""

    bodies: tuple[frozenset[int], frozenset[int], frozenset[int]]  # members of each
    pins: tuple[int, int, int]  # nodes

    @property
    def members(self) -> tuple[int, ...]:
        """All members of the triangle, in the order of the file."""
        return tuple(sorted(frozenset.union(*self.bodies)))


@derived
def rigid_triangles(mechanism: Mechanism) -> tuple[RigidTriangle, ...]:
    """Return the rigid triangles of a mechanism; each body found is joined to one before the next is searched."""
    bodies = {frozenset([k]): set(m.nodes) for k, m in enumerate(mechanism.members) if len(m.nodes) > 1}
    found: list[RigidTriangle] = []
    while (triangle := next(_triangles(bodies), None)) is not None:
        found.append(triangle)
        bodies[frozenset(triangle.members)] = set[int]().union(*(bodies.pop(body) for body in triangle.bodies))
    return tuple(found)


def _triangles(bodies: dict[frozenset[int], set[int]]) -> Iterator[RigidTriangle]:
    at = grouped((node, body) for body, nodes in bodies.items() for node in nodes)
    for pin in sorted(at):
        for one, two in combinations(at[pin], 2):
            for a in sorted(bodies[one] - bodies[two]):
                for three in at[a]:
                    shared = (bodies[three] & bodies[two]) - bodies[one]
                    if three != one and pin not in bodies[three] and shared:
                        yield RigidTriangle((one, two, three), (pin, a, min(shared)))


@derived
def rigid_bodies(mechanism: Mechanism) -> dict[str, int]:
    """Return the number of the rigid body of every member, by name; members of one rigid triangle have the same."""
    body = list(range(len(mechanism.members)))
    for triangle in rigid_triangles(mechanism):
        for k in triangle.members:
            body[k] = triangle.members[0]
    return {member.name: body[k] for k, member in enumerate(mechanism.members)}


def triangle_hints(mechanism: Mechanism) -> list[str]:
    """Return one sentence for each rigid body of triangles: which members to write as one member, and why."""
    return [hint for _, hint in rigid_parts(mechanism)]


def rigid_parts(mechanism: Mechanism) -> list[tuple[list[str], str]]:
    """Return the members of each rigid body of triangles, and the sentence of `triangle_hints` about it."""
    names, body = [m.name for m in mechanism.members], rigid_bodies(mechanism)
    hints: list[tuple[list[str], str]] = []
    for first in dict.fromkeys(body.values()):
        own = [t for t in rigid_triangles(mechanism) if body[names[t.members[0]]] == first]
        if own:
            parts = [name for name in names if body[name] == first]
            form = "a rigid triangle" if len(own) == 1 else f"{len(own)} rigid triangles"
            text = f"{', '.join(parts[:-1])} and {parts[-1]} form {form} with {2 ** len(own)} configurations"
            hints.append((parts, f"{text}: {_cure(mechanism, own)}"))
    return hints


def _cure(mechanism: Mechanism, triangles: list[RigidTriangle]) -> str:
    frame = mechanism.members[FRAME]
    if not any(FRAME in t.members for t in triangles):
        nodes = sorted({n for t in triangles for k in t.members for n in mechanism.members[k].nodes})
        return f"write one member [{', '.join(mechanism.nodes[n] for n in nodes)}] under `elements:` instead"
    fixed = dict.fromkeys(n for t in triangles for n in t.pins if n not in frame.nodes)
    return f"fix {', '.join(mechanism.nodes[n] for n in fixed)} under `ground:` instead"
