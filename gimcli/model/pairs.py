"""Registry of the kinds of pairs: one row per section of the model file.

To add a kind, write a module such as `prismatic`, add its row to `PAIRS`, and add a field of the section's name to
`schema.Model`.
"""

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
    """The functions of one kind of pair."""

    nodes: Callable[[Any], Sequence[str]]
    """Return the nodes of a pair that count as used even if no member has them."""
    check: Callable[[References, str], None]
    """Record the errors of the pair with a given name."""
    rows: Callable[[GeometryCompiler, str, Any], list[PairRow]]
    """Return the constraints of the pair with a given name."""


PAIRS = {"prismatic": PairKind(prismatic.nodes, prismatic.check, prismatic.rows)}
"""The kinds of pairs, by section of the model file; `schema.Model` must have a field of the same name."""


def used_nodes(model: Model) -> set[str]:
    """Return the nodes that a member, the ground, a pair or an actuator uses; the compiler leaves out the others."""
    members: list[Link | Element] = [*model.links.values(), *model.elements.values()]
    named = [name for part in members for name in part.nodes]
    for section, kind in PAIRS.items():
        named += [name for pair in getattr(model, section).values() for name in kind.nodes(pair)]
    for actuator in model.actuators.values():
        named += [*(actuator.nodes or []), *([actuator.node] if actuator.node is not None else [])]
    return {*model.ground.nodes, *named}
