"""The order of configurations: it depends on the mechanism and its inputs alone.

Configurations are sorted by the signs of their groups in the order of solution, + before -. The solutions of a coupled
group, for the same signs before it, are numbered by the coordinates of its nodes: by x, then y, of the first node in
the order of the file, then of the next nodes. Differences below SAME do not count, so that rounding errors, which
depend on the machine and on the way to a root, change no number.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimcli.assemblies.assemblies import Configurations
from gimcli.canonical import ranks
from gimcli.mechanism import IntArray

SAME = 1e-6
"""Difference of coordinates, relative to the size, below which they count as equal."""


def in_order(found: Configurations) -> Configurations:
    """Return the configurations in their order, with the solutions of coupled groups numbered by coordinates."""
    if not len(found):
        return found
    branches = np.array(found.branches, dtype=int).reshape(len(found), len(found.groups))
    keys = [ranks(part, SAME * found.mechanism.size) for z in found.z.T for part in (z.real, z.imag)]
    table = np.array(keys).T  # (configurations, 2 nodes)
    for k, group in enumerate(found.groups):
        if group.loops > 1:
            own = [found.mechanism.nodes.index(name) for name in group.nodes]
            branches[:, k] = _numbered(branches[:, : k + 1], table, sorted(own))
    order = np.lexsort((*table.T[::-1], *branches.T[::-1]))
    return replace(
        found, z=found.z[order], residual=found.residual[order], radius=found.radius[order],
        branches=tuple(tuple(row) for row in branches[order].tolist()),
    )  # fmt: skip


def _numbered(branches: IntArray, table: IntArray, nodes: list[int]) -> IntArray:
    """Return the last of `branches` (configurations, groups), numbered from 0 by the ranks of coordinates."""
    result = branches[:, -1].copy()
    columns = [2 * n + part for n in nodes for part in (0, 1)]
    columns += [c for c in range(table.shape[1]) if c not in columns]  # a group may turn members about known nodes only
    for before in np.unique(branches[:, :-1], axis=0):
        here = np.flatnonzero((branches[:, :-1] == before).all(axis=1))
        roots, first = np.unique(branches[here, -1], return_index=True)
        order = np.lexsort(table[here[first]][:, columns].T[::-1])
        for number, root in enumerate(roots[order].tolist()):
            result[here[branches[here, -1] == root]] = number
    return result
