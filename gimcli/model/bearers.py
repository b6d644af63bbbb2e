"""What carries a mass, a load or a point: a member, otherwise a node, or the node of a pin in a slot.

A member wins over a node of the same name, and a node over a sliding pair.
"""

from __future__ import annotations

from gimcli.model.pairs import fixed_nodes, used_nodes
from gimcli.model.references import References
from gimcli.model.schema import Load, Model, Tracer
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
    return name in ("ground", model.ground.member) or node_of(model, name) in fixed_nodes(model)


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


# -- points of members --------------------------------------------------------------------------


def check_drawn(refs: References, where: Where, nodes: list[str]) -> None:
    """Record an error if the first two nodes of a member coincide: its initial direction is then undefined."""
    a, b = nodes[:2]
    if {a, b} <= set(refs.model.nodes) and a != b and not refs.apart(a, b):
        refs.fault(where, f"nodes {a} and {b} coincide and define no direction; move one")


def check_place(refs: References, where: Where, part: Tracer | Load, what: str, known: bool) -> None:
    """Check the coordinates of a point or force (`what`) on a member, which is `known` if it exists."""
    if (part.at is None) == (part.local is None):
        refs.lack(where, ("at", "local"), f"{what} '{where[1]}' needs either `at` (initial coordinates) or `local`")
    elif known and part.at is not None and part.on != "ground":
        check_drawn(refs, (*where, "at"), refs.every[part.on])
