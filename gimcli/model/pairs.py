"""Registry of the kinds of pairs: one row per section of the model file.

To add a kind, write a module such as `prismatic`, add its row to `PAIRS`, and add a field of the section's name to
`schema.Model`.
"""

from __future__ import annotations

from collections import Counter
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


def sized_nodes(model: Model) -> set[str]:
    """Return the nodes that give the size: those of moving members, pairs and inputs.

    A guide is a line without ends: a node that only marks its direction does not count, nor does a node of the ground
    that nothing else uses. A travel begins at the first node of its guide.
    """
    held, fixed = model.ground.member, fixed_nodes(model)
    members = Counter(n for name, part in model.members.items() if name != held for n in part.nodes)
    pairs = [(kind, pair) for section, kind in PAIRS.items() for pair in getattr(model, section).values()]
    gauges = [*model.actuators.values(), *model.springs.values(), *model.dampers.values()]
    lines = {n for part in (*(pair for _, pair in pairs), *gauges) for n in part.guide or []}
    named = {n for kind, pair in pairs for n in kind.nodes(pair)}
    for actuator in model.actuators.values():
        named |= set(actuator.named) - set((actuator.guide or [])[1:])
    loaded = {*model.masses, *(load.on for load in model.loads.values()), *model.friction}
    for gauge in (*model.springs.values(), *model.dampers.values()):
        loaded |= set(gauge.named) - set(gauge.guide or [])
    alone = {n for n in lines - loaded if members[n] == 1 and n not in fixed}
    return ({*members} - alone) | named


def fixed_nodes(model: Model) -> set[str]:
    """Return the nodes of the ground, or of the member that is held fixed."""
    held = model.ground.member
    return set(model.ground.nodes if held not in model.members else model.members[held].nodes)
