"""Decomposition of equations into blocks that can be solved one after the other.

Each unknown is matched to an equation that contains it. This directs the dependencies between the equations; the
strongly connected components are the blocks (Dulmage & Mendelsohn 1958). An unknown without an equation is added to
the block of the equations that it reaches by alternating paths; such a block has more unknowns than equations.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from graphlib import TopologicalSorter
from heapq import heappop, heappush
from itertools import pairwise

from gimcli.connected import grouped

NONE = -1


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
    """Return a maximum matching: for each unknown an equation of its own that contains it, or NONE.

    Source: Hopcroft & Karp 1973; scipy's function is the same, but takes longer to import than to match.
    """
    row_of, column_of = [NONE] * len(columns), [NONE] * count
    while NONE in (level := _levels(columns, row_of, column_of)):
        for start in [column for column, row in enumerate(row_of) if row == NONE]:
            _lengthen(columns, row_of, column_of, level, start)
    return row_of


def _levels(columns: Sequence[Sequence[int]], row_of: list[int], column_of: list[int]) -> dict[int, int]:
    """Return the least number of steps from unmatched unknowns to others, and to an equation without one (NONE)."""
    level = {column: 0 for column, row in enumerate(row_of) if row == NONE}
    todo = list(level)
    for column in todo:
        for row in columns[column] if level[column] < level.get(NONE, len(columns)) else ():
            if column_of[row] not in level:
                level[column_of[row]] = level[column] + 1
                todo.append(column_of[row])
    return level


def _lengthen(
    columns: Sequence[Sequence[int]], row_of: list[int], column_of: list[int], level: dict[int, int], start: int
) -> None:
    """Exchange the equations on a shortest path from an unmatched unknown to an equation without one, if there is one.

    No other path leads through the unknowns of this one.
    """
    todo, before = [start], dict[int, int]()
    while todo:
        column = todo.pop()
        for row in columns[column]:
            owner = column_of[row]
            if level.get(owner) != level[column] + 1:
                continue
            if owner == NONE:
                while row != NONE:
                    del level[column]
                    column_of[row], row_of[column], row = column, row, row_of[column]
                    column = before.get(column, NONE)
                return
            before[owner] = column
            todo.append(owner)


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
    label = _strong(needs)
    parts = grouped((label[node], node) for node in range(len(needs)))
    before = {
        own: dict.fromkeys(label[other] for node in part for other in sorted(needs[node]) if label[other] != own)
        for own, part in parts.items()
    }
    order = TopologicalSorter(before)
    return [parts[own] for own in (_ranked(order, parts) if ranked else order.static_order())]


def _strong(needs: Sequence[Sequence[int]]) -> dict[int, int]:
    """Return a label for each node, the same for nodes that depend on one another.

    Source: Sharir, A strong-connectivity algorithm and its applications in data flow analysis, 1981.
    """
    back = grouped((other, node) for node, others in enumerate(needs) for other in others)
    left: dict[int, None] = {}  # nodes in the order in which a search along `needs` leaves them
    label: dict[int, int] = {}
    todo, seen = list(range(len(needs))), set[int]()
    while todo:
        node = todo.pop()
        if node < 0:
            left[~node] = None
        elif node not in seen:
            seen.add(node)
            todo += [~node, *needs[node]]
    for first in reversed(left):
        todo = [first]
        while todo:
            node = todo.pop()
            if node not in label:
                label[node] = first
                todo += back.get(node, [])
    return label


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
