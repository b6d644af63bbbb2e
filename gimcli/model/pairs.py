"""The kinds of pairs: what each section of a file says of nodes and members."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from gimcli.mechanism import PairRow
from gimcli.model import prismatic
from gimcli.model.references import References
from gimcli.model.schema import Element, Link, Model

if TYPE_CHECKING:
    from gimcli.model.compile_geometry import GeometryCompiler


class PairKind(NamedTuple):
    """What is done with the pairs of a section."""

    nodes: Callable[[Any], Sequence[str]]
    """Nodes that a pair names beside those of members."""
    check: Callable[[References, str], None]
    """Note what is wrong with the pair of a name."""
    rows: Callable[[GeometryCompiler, str, Any], list[PairRow]]
    """The constraints of a pair of a name."""


PAIRS = {"prismatic": PairKind(prismatic.nodes, prismatic.check, prismatic.rows)}
"""By section of the file."""


def used_nodes(model: Model) -> set[str]:
    """Return the nodes that a member, the ground, a pair or an actuator uses: the others are left out."""
    members: list[Link | Element] = [*model.links.values(), *model.elements.values()]
    named = [name for part in members for name in part.nodes]
    for section, kind in PAIRS.items():
        named += [name for pair in getattr(model, section).values() for name in kind.nodes(pair)]
    for actuator in model.actuators.values():
        named += [*(actuator.nodes or []), *([actuator.node] if actuator.node is not None else [])]
    return {*model.ground.nodes, *named}
