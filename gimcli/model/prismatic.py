"""The section `prismatic`: pins in slots (`node`), and blocks that slide without relative rotation (`nodes`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gimcli.mechanism import HEIGHT, PairRow
from gimcli.model.check_inputs import check_span
from gimcli.model.references import References
from gimcli.model.schema import Prismatic
from gimcli.model.source import Where

if TYPE_CHECKING:
    from gimcli.model.compile_geometry import GeometryCompiler


def nodes(pair: Prismatic) -> list[str]:
    """Return the nodes that slide."""
    return [pair.node] if pair.node is not None else pair.nodes or []


def check(refs: References, name: str) -> None:
    """Record the errors in a pair."""
    where: Where = ("prismatic", name)
    pair = refs.model.prismatic[name]
    if (pair.node is None) == (pair.nodes is None):
        text = f"'{name}' needs either `node` (pin in a slot) or `nodes` (no relative rotation)"
        refs.lack(where, ("node", "nodes"), text)
        return
    if pair.node is not None:
        if refs.node((*where, "node"), pair.node):
            check_span(refs, where, pair.guide, [pair.node])
        return
    sliding = pair.nodes or []
    if refs.nodes((*where, "nodes"), sliding):
        check_span(refs, where, pair.guide, sliding)
        if refs.sure and not refs.carriers(*sliding):
            text = (
                f"nodes {sliding[0]} and {sliding[1]} belong to no common member; name two nodes of the sliding member"
            )
            refs.fault((*where, "nodes"), text)


def rows(own: GeometryCompiler, name: str, pair: Prismatic) -> list[PairRow]:
    """Return one constraint per sliding node: its height over the line of sliding is 0."""
    member, _, along = own.line(pair.guide)
    body = own.members[member]
    near = min((own.index[n] for n in pair.guide), key=body.remote.__contains__)  # a far one has fewer decimals
    point = body.local(near) + 1j * along * pair.offset / own.scale
    names = {name if pair.node is not None else f"{name} {node}": node for node in nodes(pair)}
    return [PairRow(n, HEIGHT, (own.index[v],), (member,), point, 1j * along, pair=name) for n, v in names.items()]
