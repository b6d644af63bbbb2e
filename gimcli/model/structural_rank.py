"""The structural rank of the constraints of a mechanism: what they can determine by their nodes alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gimcli.mechanism import ANGLE, FRAME, Member, PairRow


def structural_rank(members: Sequence[Member], rows: Sequence[PairRow]) -> int:
    """Return the greatest number of coordinates that members, pairs and inputs (`rows`) can determine together."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import structural_rank as rank_of

    fixed = set(members[FRAME].nodes)
    equations = [[n for n in nodes if n not in fixed] for nodes in _equations(members, rows)]
    column = {node: k for k, node in enumerate(sorted({n for nodes in equations for n in nodes}))}
    table = np.zeros((len(equations), 2 * len(column)), dtype=bool)
    for k, nodes in enumerate(equations):
        for node in nodes:
            table[k, 2 * column[node] : 2 * column[node] + 2] = True
    return int(rank_of(csr_array(table))) if table.size else 0


def _equations(members: Sequence[Member], rows: Sequence[PairRow]) -> Iterator[list[int]]:
    """Yield the nodes in each equation."""
    for member in members[FRAME + 1 :]:
        first, far, _ = member.ends
        yield [first, far]
        for node in member.nodes:
            if node not in (first, far):
                yield from [[first, far, node]] * 2
    for row in rows:
        guides = [n for k in row.members if k != FRAME for n in members[k].ends[:2]]
        yield guides if row.kind == ANGLE else [*row.nodes, *guides]
