"""The nodes of a model that its parts use, that give its size, and that are fixed."""

from __future__ import annotations

from collections import Counter

from gimcli.model.schema import Element, Link, Model


def used_nodes(model: Model) -> set[str]:
    """Return the nodes that a member, the ground, a pair or an actuator uses; the compiler leaves out the others."""
    members: list[Link | Element] = [*model.links.values(), *model.elements.values()]
    named = [name for part in members for name in part.nodes]
    for part in (*model.prismatic.values(), *model.actuators.values()):
        named += [*(part.nodes or []), *([part.node] if part.node is not None else [])]
    return {*model.ground.nodes, *named}


def sized_nodes(model: Model) -> set[str]:
    """Return the nodes that give the size: those of moving members, pairs and inputs.

    A guide is a line without ends: a node that only marks its direction does not count, nor does a node of the ground
    that nothing else uses. A travel begins at the first node of its guide.
    """
    held, fixed = model.ground.member, fixed_nodes(model)
    members = Counter(n for name, part in model.members.items() if name != held for n in part.nodes)
    gauges = [*model.actuators.values(), *model.springs.values(), *model.dampers.values()]
    lines = {n for part in (*model.prismatic.values(), *gauges) for n in part.guide or []}
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
