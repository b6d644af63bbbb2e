"""Elements by what they share: connected sets, groups with the same key, elements that differ."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Set as AbstractSet
from typing import TypeVar

Element = TypeVar("Element", bound=Hashable)
Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


def connected(ties: Iterable[Iterable[Element]], fixed: AbstractSet[Element]) -> list[set[Element]]:
    """Return the sets of elements that ties join, directly or through others; `fixed` elements join nothing."""
    groups: list[set[Element]] = []
    for names in ties:
        tied = set(names) - fixed
        if tied:
            joined = [group for group in groups if not group.isdisjoint(tied)]
            groups = [*(group for group in groups if group.isdisjoint(tied)), tied.union(*joined)]
    return groups


def grouped(pairs: Iterable[tuple[Key, Value]]) -> dict[Key, list[Value]]:
    """Return the values of each key, both in the order in which they come."""
    groups: dict[Key, list[Value]] = {}
    for key, value in pairs:
        groups.setdefault(key, []).append(value)
    return groups


def alike(items: Iterable[Value], same: Callable[[Value, Value], bool]) -> list[list[Value]]:
    """Return the elements, each with those that are the same; `same` compares one with the first of such a group."""
    groups: list[list[Value]] = []
    for one in items:
        own = next((group for group in groups if same(one, group[0])), None)
        if own is None:
            groups.append([one])
        else:
            own.append(one)
    return groups


def unlike(items: Iterable[Value], same: Callable[[Value, Value], bool]) -> list[Value]:
    """Return the elements without those that are the same as one before; `same` compares one with an earlier one."""
    return [group[0] for group in alike(items, same)]
