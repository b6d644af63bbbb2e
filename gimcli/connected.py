"""Connected sets: what shares no element with the others."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Set as AbstractSet
from typing import TypeVar

Element = TypeVar("Element", bound=Hashable)


def connected(ties: Iterable[Iterable[Element]], fixed: AbstractSet[Element]) -> list[set[Element]]:
    """Return the sets of elements that ties join, directly or through others; `fixed` elements join nothing."""
    groups: list[set[Element]] = []
    for names in ties:
        tied = set(names) - fixed
        if tied:
            joined = [group for group in groups if not group.isdisjoint(tied)]
            groups = [*(group for group in groups if group.isdisjoint(tied)), tied.union(*joined)]
    return groups
