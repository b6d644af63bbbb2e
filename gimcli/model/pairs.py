"""The nodes of a model that its parts use, that give its size, that are fixed, and that carry masses and loads.

For masses and loads, a member wins over a node of the same name, and a node over a sliding pair.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from gimcli.model.schema import Element, Link, Model


def used_nodes(model: Model) -> set[str]:
    """Return the nodes that a member, the ground, a pair or an actuator uses; the compiler leaves out the others."""
    parts: list[Link | Element] = [*model.links.values(), *model.elements.values()]
    members = (name for part in parts for name in part.nodes)
    sliding = (name for pair in model.prismatic.values() for name in pair.sliding)
    driven = (name for actuator in model.actuators.values() for key, name in actuator.keyed if key in ("node", "nodes"))
    return {*model.ground.nodes, *members, *sliding, *driven}


def sized_nodes(model: Model) -> set[str]:
    """Return the nodes that give the size: those of moving members, pairs and inputs.

    A guide is a line without ends: a node that only marks its direction does not count, nor does a node of the ground
    that nothing else uses. A travel begins at the first node of its guide.
    """
    held, fixed = model.ground.member, fixed_nodes(model)
    members = Counter(n for name, part in model.members.items() if name != held for n in part.nodes)
    gauges = [*model.actuators.values(), *model.springs.values(), *model.dampers.values()]
    guides = [*(pair.guide for pair in model.prismatic.values()), *(gauge.guide or [] for gauge in gauges)]
    lines = {n for guide in guides for n in guide}
    named = {n for pair in model.prismatic.values() for n in pair.sliding}
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


def having(model: Model, nodes: Iterable[str]) -> Iterator[str]:
    """Yield the members that have all of some nodes, 'ground' first; the member that is held is the ground."""
    wanted = set(nodes)
    if wanted <= fixed_nodes(model):
        yield "ground"
    moving = (name for name, part in model.members.items() if name != model.ground.member and wanted <= {*part.nodes})
    yield from moving


# -- what carries a mass or a load: a member, otherwise a node, or the node of a pin in a slot ------------


def node_of(model: Model, name: str) -> str | None:
    """Return the node with a mass or a load; None if it is a member, or if there is no node of this name."""
    if name == "ground" or name in model.links or name in model.elements:
        return None
    pair = model.prismatic.get(name)
    return name if name in model.nodes else pair.node if pair is not None else None


def fixed(model: Model, name: str) -> bool:
    """Return whether the member or the node of a mass or a load is fixed to the frame."""
    return name in ("ground", model.ground.member) or node_of(model, name) in fixed_nodes(model)
