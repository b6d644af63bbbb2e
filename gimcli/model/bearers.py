"""What carries a mass or a load: a member, otherwise a node, or the node of a pin in a slot.

A member wins over a node of the same name, and a node over a sliding pair.
"""

from __future__ import annotations

from gimcli.model.pairs import used_nodes
from gimcli.model.references import References
from gimcli.model.schema import Model
from gimcli.model.source import Where
from gimcli.nearest import near


def node_of(model: Model, name: str) -> str | None:
    """Return the node with a mass or a load; None if it is a member, or if there is no node of this name."""
    if name == "ground" or name in model.links or name in model.elements:
        return None
    pair = model.prismatic.get(name)
    return name if name in model.nodes else pair.node if pair is not None else None


def fixed(model: Model, name: str) -> bool:
    """Return whether the member or the node of a mass or a load is fixed to the frame."""
    held = model.ground.member
    nodes = model.ground.nodes if held is None else model.members[held].nodes
    return name in ("ground", held) or node_of(model, name) in nodes


def check_bearer(refs: References, where: Where, name: str, key: bool = False) -> str | None:
    """Return the node with a mass or a load, None if it is a member; record an error if it is neither."""
    model, node = refs.model, node_of(refs.model, name)
    pair = model.prismatic.get(name)
    if node is not None:
        if node in model.nodes and node not in used_nodes(model) and refs.sure:
            refs.fault(where, f"node '{node}' belongs to no member or pair; add it to one", key)
        return node
    if name in refs.every or name == "ground" or ("nodes", name) in refs.doubtful:
        return None
    if pair is not None:
        ends = " or ".join(pair.nodes or [])
        refs.fault(where, f"'{name}' slides a member without rotation; name this member, or the node {ends}", key)
    elif near(name, refs.every) or not (hint := near(name, [*model.nodes, *model.prismatic])):
        refs.member(where, name, key, nodes=True)
    else:
        refs.fault(where, f"'{name}' is neither a member nor a node{hint}", key)
    return None
