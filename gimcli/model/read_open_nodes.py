"""Open nodes of a file that is read: their positions, or the errors that name what is missing."""

from __future__ import annotations

from collections.abc import Iterator

from gimcli.model.laws import ended
from gimcli.model.pairs import used_nodes
from gimcli.model.placing import Placement, Placing, moved, place, with_rough
from gimcli.model.placing_data import PlacingData, starts_by_value
from gimcli.model.placing_steps import number
from gimcli.model.references import PartFault
from gimcli.model.schema import Link, Model, OpenNode, OpenNodes
from gimcli.model.source import Source
from gimcli.model.units import RADIANS

Read = tuple[Model, list[PartFault]]
"""A model whose nodes all have positions; rough ones if there are reasons why they cannot be placed."""


def with_open_nodes(source: Source, model: Model) -> Read:
    """Return a validated model with the positions of its nodes without coordinates."""
    model.open = OpenNodes({name: part for name, part in model.nodes.items() if isinstance(part, OpenNode)})
    faults = list(_fixed(model))
    placing = place(model, source.folder, {})
    faults += [] if faults else _left(model, placing)
    if not faults and placing.blocked is not None:
        faults.append(_impossible(source, model, placing))
    left, found = (model.open.parts, Placement({}, {})) if faults else (placing.left, placing.found[0])
    coupled = tuple(name for name in model.nodes if name in left)
    model = moved(model, found.at, sides=found.sides, undecided=placing.undecided, coupled=coupled)
    return with_rough(model, source.folder) if coupled else model, faults


def placed_anew(source: Source, model: Model) -> Read:
    """Return a model whose dimensions have changed with new positions of its open nodes; chosen sides are kept."""
    old = model.open
    placing = place(model, source.folder, old.sides)
    if placing.blocked is not None:
        return model, [_impossible(source, model, placing)]
    undecided = [name for name in placing.undecided if name in old.undecided or name not in old.sides]
    at, sides, _ = placing.found[0]
    return moved(model, at, sides=sides, undecided=tuple(undecided)), []


def _fixed(model: Model) -> Iterator[PartFault]:
    """Yield the nodes that need coordinates: those of the ground, and the first two of a held member."""
    held = model.members.get(model.ground.member or "")
    why = f"it gives the position of '{model.ground.member}', which is held fixed" if held else "it is a ground node"
    for name in model.ground.nodes if held is None else held.nodes[:2]:
        if name in model.open.parts:
            yield PartFault(("nodes", name), f"node {name} needs coordinates [x, y]: {why}")


def _left(model: Model, placing: Placing) -> list[PartFault]:
    """Return the reasons for nodes that no step places; first those with a dimension that is missing."""
    used, faults = used_nodes(model), []
    for name in (name for name in model.nodes if name in placing.left):
        given = {key: part for key, part in placing.data.missing.items() if name in part.nodes}
        lacking = [f"the `{'length' if isinstance(part, Link) else 'shape'}` of {key}" for key, part in given.items()]
        text = f"node {name} has no coordinates, and nothing else determines its position"
        text += f": give {', '.join(lacking)}, or coordinates [x, y]"
        if name not in used:
            text = f"node {name} has no coordinates and belongs to no member; add it to one, or remove it"
        if lacking or name not in used:
            faults.append(PartFault(("nodes", name), text))
    return faults or list(_open_laws(model, placing))


def _open_laws(model: Model, placing: Placing) -> Iterator[PartFault]:
    """Yield the actuators whose law starts at a value that only coordinates would give."""
    known = {one.name for one in placing.data.distances} | {one.name for one in placing.data.lines}
    for name, actuator in model.actuators.items():
        law = actuator.law
        given = name in known or (actuator.pivot is not None and law is not None and starts_by_value(law))
        if not given and (open_ends := placing.left.intersection(actuator.named)):
            lacking = "`from`" if law is not None and ended(law) else "`from` and `to`"
            text = f"the law of {name} needs {lacking}: the node {min(open_ends)} has no coordinates"
            yield PartFault(("actuators", name), text)


def _impossible(source: Source, model: Model, placing: Placing) -> PartFault:
    """Return the error for a step that is impossible."""
    gap = placing.blocked
    assert gap is not None
    at = _inputs(model, placing.data)
    return PartFault(("nodes", gap.node), f"{gap.node} cannot be placed{at}: {gap.text}{_other(source, model)}")


def _inputs(model: Model, data: PlacingData) -> str:
    """Return the inputs of a message."""
    units = model.units
    unit = "" if units.length == "unit" else f" {units.length}"
    values = [
        *(f"{name} = {number(rad / RADIANS[units.angle])} {units.angle}" for name, (_, rad) in data.angles.items()),
        *(f"{one.name} = {number([*one.local.values()][1])}{unit}" for one in data.distances),
        *(f"{one.name} = {number(one.offset)}{unit}" for one in data.lines if one.square),
    ]
    return f" at {', '.join(values)}" if values else ""


def _other(source: Source, model: Model) -> str:
    """Return the sides with which all nodes can be placed, if there are some."""
    free = model.with_value("nodes", dict)
    free.open = OpenNodes({name: OpenNode() for name in model.open.parts})
    found = place(free, source.folder, {}).found
    if not found:
        return f"; change a length{' or the start of a law' * bool(model.actuators)}"
    sides = {name: found[0].sides.get(name, part.side) for name, part in model.open.parts.items()}
    other = {name: side for name, side in sides.items() if model.open.parts[name].side not in (None, side)}
    return "; use " + " and ".join(f"`side: {side}` of {name}" for name, side in other.items())
