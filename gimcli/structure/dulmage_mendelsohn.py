"""Decomposition of equations into blocks that can be solved one after the other.

Each unknown is matched to an equation that contains it. This directs the dependencies between the equations; the
strongly connected components are the blocks (Dulmage & Mendelsohn 1958). An unknown without an equation is added to
the block of the equations that it reaches by alternating paths; such a block has more unknowns than equations.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING

from gimcli.connected import grouped

if TYPE_CHECKING:
    from graphlib import TopologicalSorter


@dataclass(frozen=True)
class EquationBlock:
    """Equations and unknowns that are solved simultaneously."""

    rows: tuple[int, ...]
    columns: tuple[int, ...]


def split(
    count: int, columns: Sequence[Sequence[int]], together: Iterable[Sequence[int]] = ()
) -> tuple[EquationBlock, ...]:
    """Return the blocks of `count` equations, each after those that it depends on.

    columns: for each unknown, the equations that contain it. together: sets of equations to keep in one block.
    """
    row_of = match(count, columns)
    column_of = {row: column for column, row in enumerate(row_of) if row >= 0}
    needs: list[list[int]] = [[] for _ in range(count)]
    for column, entered in enumerate(columns):
        for row in entered:
            if row_of[column] not in (row, -1):
                needs[row].append(row_of[column])
    spare = [column for column, row in enumerate(row_of) if row < 0]
    alternating = [reached(columns, column_of, column) for column in spare]
    join(needs, [*together, *alternating])
    own = grouped((min(rows), column) for column, rows in zip(spare, alternating, strict=True))
    result = []
    for part in components(needs):
        extra = [column for row in part for column in own.get(row, [])]
        result.append(EquationBlock(tuple(part), tuple(sorted([column_of[r] for r in part if r in column_of] + extra))))
    return tuple(result)


def match(count: int, columns: Sequence[Sequence[int]]) -> list[int]:
    """Return a maximum matching: for each unknown an equation of its own that contains it, or -1."""
    import numpy as np
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    if not columns or not count:
        return [-1] * len(columns)
    ends = np.array([0, *accumulate(map(len, columns))], dtype=np.int32)  # scipy before 1.15 needs 32 bits
    entered = np.array([row for rows in columns for row in rows], dtype=np.int32)
    table = csr_array((np.ones(len(entered)), entered, ends), shape=(len(columns), count))
    return [int(row) for row in maximum_bipartite_matching(table, perm_type="column")]


def join(needs: list[list[int]], together: Iterable[Sequence[int]]) -> None:
    """Add cyclic dependencies so that the equations of each given set are in one component."""
    for rows in together:
        for a, b in pairwise([*rows, *rows[:1]]):
            needs[a].append(b)


def reached(columns: Sequence[Sequence[int]], column_of: Mapping[int, int], start: int) -> list[int]:
    """Return the equations that an unmatched unknown reaches by alternating paths."""
    seen: dict[int, None] = {}
    todo = [start]
    while todo:
        for row in columns[todo.pop()]:
            if row not in seen:
                seen[row] = None
                if row in column_of:
                    todo.append(column_of[row])
    return list(seen)


def components(needs: Sequence[Sequence[int]], ranked: bool = False) -> list[list[int]]:
    """Return the strongly connected components of a graph, each after those that it depends on.

    needs: for each node, the nodes that it depends on. With `ranked`, components that could exchange places are in the
    order of their lowest nodes.
    """
    from graphlib import TopologicalSorter

    import numpy as np
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    edges = [sorted(set(others)) for others in needs]  # scipy 1.x gives wrong components for duplicate edges
    ends = np.array([0, *accumulate(map(len, edges))], dtype=np.int32)
    heads = np.array([other for others in edges for other in others], dtype=np.int32)
    graph = csr_array((np.ones(len(heads)), heads, ends), shape=(len(needs), len(needs)))
    label = connected_components(graph, directed=True, connection="strong")[1].tolist()
    parts: dict[int, list[int]] = {}
    before: dict[int, dict[int, None]] = {}
    for node, own in enumerate(label):
        parts.setdefault(own, []).append(node)
        before.setdefault(own, {}).update((label[other], None) for other in edges[node] if label[other] != own)
    order = TopologicalSorter(before)
    return [parts[own] for own in (_ranked(order, parts) if ranked else order.static_order())]


def _ranked(order: TopologicalSorter[int], parts: Mapping[int, Sequence[int]]) -> Iterator[int]:
    """Yield components as they become ready, the one with the lowest node first."""
    order.prepare()
    ready: list[tuple[int, int]] = []
    while order.is_active():
        for own in order.get_ready():
            heappush(ready, (parts[own][0], own))
        _, first = heappop(ready)
        yield first
        order.done(first)
