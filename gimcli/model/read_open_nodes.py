"""Open nodes of a file that is read: their positions, or the errors that name what is missing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from gimcli.model.pairs import used_nodes
from gimcli.model.placing import SIDES, Blocked, Placing, place, with_positions
from gimcli.model.schema import Link, Model, OpenNode, OpenNodes
from gimcli.model.source import Source, Where


class OpenNodeFault(NamedTuple):
    """An error, and the part of the file where it is."""

    where: Where
    text: str


class ReadNodes(NamedTuple):
    """A model whose nodes all have positions; without those of `unplaced`, for which `faults` has the reasons."""

    model: Model
    unplaced: tuple[str, ...] = ()
    faults: tuple[OpenNodeFault, ...] = ()


def with_open_nodes(source: Source, model: Model) -> ReadNodes:
    """Return a validated model with the positions of its nodes without coordinates."""
    model.open = OpenNodes({name: part for name, part in model.nodes.items() if isinstance(part, OpenNode)})
    faults = list(_fixed(model))
    placing = place(model, source.folder, {})
    faults += [] if faults else _left(model, placing)
    if not faults and placing.blocked is not None:
        faults.append(_impossible(source, model, placing.blocked))
    if not faults:
        return ReadNodes(with_positions(model, placing.found[0], placing.undecided))
    given = {name: xy for name, xy in model.nodes.items() if name not in model.open.parts}
    return ReadNodes(model.with_value("nodes", lambda _: given), tuple(model.open.parts), tuple(faults))


def placed_anew(source: Source, model: Model) -> ReadNodes:
    """Return a model whose dimensions have changed with new positions of its open nodes; chosen sides are kept."""
    old = model.open
    placing = place(model, source.folder, old.sides)
    if placing.blocked is not None:
        return ReadNodes(model, (), (_impossible(source, model, placing.blocked),))
    undecided = [name for name in placing.undecided if name in old.undecided or name not in old.sides]
    return ReadNodes(with_positions(model, placing.found[0], undecided))


def _fixed(model: Model) -> Iterator[OpenNodeFault]:
    """Yield the nodes that need coordinates: those of the ground, and the first two of a held member."""
    held = model.members.get(model.ground.member or "")
    why = f"it gives the position of '{model.ground.member}', which is held fixed" if held else "it is a ground node"
    for name in model.ground.nodes if held is None else held.nodes[:2]:
        if name in model.open.parts:
            yield OpenNodeFault(("nodes", name), f"node {name} needs coordinates [x, y]: {why}")


def _left(model: Model, placing: Placing) -> list[OpenNodeFault]:
    """Return the reasons for nodes that no step places; first those with a dimension that is missing."""
    used, left = used_nodes(model), [name for name in model.nodes if name in placing.left]
    faults = []
    for name in left:
        lacking = [f"the `{_key(part)}` of {key}" for key, part in placing.data.missing.items() if name in part.nodes]
        if name not in used:
            text = f"node {name} has no coordinates and belongs to no member; add it to one, or remove it"
        elif lacking:
            text = f"node {name} has no coordinates, and nothing else determines its position"
            text += f": give {', '.join(lacking)}, or coordinates [x, y]"
        else:
            continue
        faults.append(OpenNodeFault(("nodes", name), text))
    return faults if faults or not left else [_together(left)]


def _key(part: object) -> str:
    return "length" if isinstance(part, Link) else "shape"


def _together(left: list[str]) -> OpenNodeFault:
    if len(left) == 1:
        text = f"node {left[0]} has no coordinates, and the lengths and inputs do not determine its position"
    else:
        names = f"{', '.join(left[:-1])} and {left[-1]}"
        text = f"the nodes {names} have no coordinates, and cannot be placed one after the other"
    return OpenNodeFault(("nodes", left[0]), f"{text}; give rough coordinates [x, y]")


def _impossible(source: Source, model: Model, blocked: Blocked) -> OpenNodeFault:
    """Return the error for a step that is impossible."""
    name = blocked.step.owner or blocked.step.node
    where: Where = ("nodes", name)
    return OpenNodeFault(where, f"{name} cannot be placed{_at(model)}: {blocked.gap.text}{_other(source, model)}")


def _at(model: Model) -> str:
    """Return the inputs of a message."""
    names = ", ".join(model.actuators)
    return f" at the start of {names}" if names else ""


def _other(source: Source, model: Model) -> str:
    """Return the sides with which all nodes can be placed, if there are some."""
    free = model.with_value("nodes", lambda old: old)
    free.open = OpenNodes({name: OpenNode() for name in model.open.parts})
    found = place(free, source.folder, {}).found
    if not found:
        return "; change a length"
    asked = {name: part.side for name, part in model.open.parts.items() if part.side is not None}
    other = {name: found[0].sides[name] for name in asked if found[0].sides.get(name, asked[name]) != asked[name]}
    assert set(other.values()) <= set(SIDES)
    return "; use " + " and ".join(f"`side: {side}` of {name}" for name, side in other.items())
