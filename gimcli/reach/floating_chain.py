"""The chain on which a point depends: moving members that are connected without the frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from gimcli.connected import connected
from gimcli.mechanism import FRAME, Dynamics, Mechanism, PairRow

Row = TypeVar("Row", bound=PairRow)


def chains(mechanism: Mechanism, point: str, members: Iterable[str] = ()) -> tuple[Mechanism, list[Mechanism]]:
    """Return the chain of a node or point and some members, and the other chains, each with the frame."""
    groups = connected(_ties(mechanism), set(mechanism.members[FRAME].nodes))
    named = [m.nodes for m in mechanism.members[FRAME + 1 :] if m.name in set(members)]
    wanted = {n for nodes in (_carriers(mechanism, point), *named) for n in nodes}
    own = set().union(*(group for group in groups if group & wanted))
    if not own or len(groups) < 2:
        return mechanism, []
    return _cut_out(mechanism, own), [_cut_out(mechanism, group) for group in groups if not group & own]


def _carriers(mechanism: Mechanism, point: str) -> tuple[int, ...]:
    """Return the nodes of the member to which a point is fixed; for a node itself."""
    if point in mechanism.nodes:
        return (mechanism.nodes.index(point),)
    return next(mechanism.members[p.member].nodes for p in mechanism.points if p.name == point)


def _ties(mechanism: Mechanism) -> Iterator[tuple[int, ...]]:
    """Yield the nodes that are connected by each member, sliding pair and input."""
    yield from (m.nodes for m in mechanism.members[FRAME + 1 :])
    yield from (_held(mechanism, row) for row in (*mechanism.pairs, *mechanism.actuators))


def _held(mechanism: Mechanism, row: PairRow) -> tuple[int, ...]:
    return (*row.nodes, *(n for k in row.members for n in _moving(mechanism, k)))


def _moving(mechanism: Mechanism, member: int) -> tuple[int, ...]:
    return () if member == FRAME else mechanism.members[member].nodes


def _cut_out(mechanism: Mechanism, own: set[int]) -> Mechanism:
    """Return the mechanism of the frame and the chain of some moving nodes, in the same normal frame."""
    kept = [n for n in range(len(mechanism.nodes)) if n in own or n in mechanism.members[FRAME].nodes]
    node = {old: new for new, old in enumerate(kept)}
    chosen = [k for k, m in enumerate(mechanism.members) if k == FRAME or set(m.nodes) & own]
    member = {old: new for new, old in enumerate(chosen)}

    def moved(rows: Sequence[Row]) -> tuple[Row, ...]:
        return tuple(
            replace(row, nodes=tuple(node[n] for n in row.nodes), members=tuple(member[k] for k in row.members))
            for row in rows
            if own & set(_held(mechanism, row))
        )

    members = [mechanism.members[k] for k in chosen]
    return replace(
        mechanism,
        nodes=tuple(mechanism.nodes[n] for n in kept),
        drawn=np.ascontiguousarray(mechanism.drawn[kept]),
        members=tuple(replace(m, nodes=tuple(node[n] for n in m.nodes)) for m in members),
        pairs=moved(mechanism.pairs),
        actuators=moved(mechanism.actuators),
        points=tuple(replace(p, member=member[p.member]) for p in mechanism.points if p.member in chosen),
        dynamics=Dynamics(),
        gauges=(),
    )
