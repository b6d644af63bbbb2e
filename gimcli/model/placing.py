"""The positions of nodes without coordinates, computed from the lengths, angles and shapes of the file.

The nodes are placed one after the other (see `placing_steps`). A step with two positions follows the `side` of its
node; without a side, a position is chosen if only one of the two lets all other nodes be placed.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import compress, islice
from pathlib import Path
from typing import Any, NamedTuple

from gimcli.calculus.numbers import places
from gimcli.model.laws import ended
from gimcli.model.pairs import used_nodes
from gimcli.model.placing_data import GivenLine, PlacingData, height, placing_data, starts_by_value, unit
from gimcli.model.placing_steps import SIDES, Gap, Order, PlacingStep, number
from gimcli.model.references import PartFault, those
from gimcli.model.schema import Link, Model, OpenNode, OpenNodes
from gimcli.model.source import Source
from gimcli.model.units import RADIANS

SAME = 1e-6
"""Distance of two positions of a node, relative to the size, up to which they are one: the loci are tangent."""

FITS = 1e-6
"""Error of a dimension, relative to the size, up to which a position satisfies it."""

GOLDEN = math.pi * (3.0 - math.sqrt(5.0))
"""Angle [rad] between two rough positions, of which no two coincide."""

TRIES = 4096
"""Most steps that are tried while sides are chosen, besides those of one try."""

FOUND = 64
"""Most sets of positions that are compared."""


class Placement(NamedTuple):
    """One set of positions: of all nodes that could be placed, and the sides that were chosen."""

    at: Mapping[str, Any]
    sides: Mapping[str, str]
    number: int | None = None
    """That of the configuration, if it has one."""


class Placing(NamedTuple):
    """The result of placing the open nodes of a model."""

    data: PlacingData
    left: frozenset[str]
    """Nodes for which there is no step."""
    found: tuple[Placement, ...]
    """Possible sets of positions; those of the nodes in `left` are not in it."""
    undecided: tuple[str, ...]
    """The nodes whose side is open; if there are very many positions, all for which no side is given."""
    blocked: Gap | None
    """If nothing was found: the step that failed."""


def place(model: Model, folder: Path, preferred: Mapping[str, str]) -> Placing:
    """Return the positions of the open nodes of a model; the paths of tables start at `folder`.

    `preferred` are sides that are chosen where both are possible.
    """
    data, steps, left = _steps(model, folder)
    given = {name: complex(*xy) for name, xy in model.nodes.items() if name not in model.open.parts}
    asked = {step.owner: step.side for step in steps if step.side is not None}
    asked |= {name: part.side for name, part in model.open.parts.items() if part.side is not None}
    size = _size(data, given)
    search = _Search(steps, asked, preferred, size)
    found = tuple(islice(search.run(given), FOUND))
    if len(found) > 1:
        errors = (_errors(data, one.at, set(model.open.parts)) for one in found)
        fits = [all(error <= FITS * size for error in own) for own in errors]
        found = tuple(compress(found, fits)) or found
    undecided = tuple(
        step.owner for step in steps
        if step.owner and (len({one.sides.get(step.owner) for one in found}) > 1
                           or (len(found) >= FOUND and step.owner not in asked))
    )  # fmt: skip
    return Placing(data, left, found, undecided, None if found else search.blocked)


def _steps(model: Model, folder: Path) -> tuple[PlacingData, list[PlacingStep], frozenset[str]]:
    """Return what a model gives, the steps that place its open nodes, and the nodes for which there is none."""
    data = placing_data(model, folder)
    order = Order(data, model.nodes.keys() - model.open.parts.keys())
    return data, [*order.steps()], frozenset(order.data.order) - order.known


def placed_again(model: Model, folder: Path) -> Model:
    """Return a model with positions of its open nodes from other dimensions, which may be recorded numbers.

    The sides are kept; nodes for which there is no step keep their coordinates. Raises Gap if a step is impossible.
    """
    at = _points(model)
    for step in _steps(model, folder)[1]:
        positions = step.positions(at)
        at |= positions[SIDES.index(model.open.sides.get(step.owner, SIDES[0])) if len(positions) > 1 else 0]
    return moved(model, {name: at[name] for name in model.open.parts})


def sides_at(model: Model, folder: Path, at: Mapping[str, complex]) -> dict[str, str]:
    """Return the sides that the nodes of a model have at some positions; of nodes for which there is a choice."""
    known, found = {**_points(model), **at}, dict[str, str]()
    for step in (one for one in _steps(model, folder)[1] if one.owner):
        with suppress(Gap):
            away = [max(abs(one[n] - known[n]) for n in one) for one in step.positions(known)]
            found[step.owner] = SIDES[int(away[-1] < away[0])]
    return found


def chosen_at(model: Model, folder: Path, at: Mapping[str, complex], chosen: bool) -> Model:
    """Return a model with the sides that its open nodes have at some positions; all sides are decided.

    The nodes that no step places have these positions, which may be `chosen` among several.
    """
    sides = sides_at(model, folder, at)
    left = {name: at[name] for name in _steps(model, folder)[2] if name in at}
    parts = {name: OpenNode(side=sides.get(name, part.side)) for name, part in model.open.parts.items()}
    names = tuple(name for name in model.nodes if name in left and chosen)
    sides = {**model.open.sides, **sides}
    return placed_again(moved(model, left, parts=parts, sides=sides, coupled=(), undecided=(), chosen=names), folder)


def with_rough(model: Model, folder: Path, number: int = 0) -> Model:
    """Return a model with rough positions of its coupled nodes: on a circle about the others.

    The sense of sliding pairs without rotation is that of the side of the second node; without a side it is `right`.
    `number`: of the circle, where others are needed.
    """
    left = model.open.coupled
    at = {name: complex(*xy) for name, xy in model.nodes.items() if name not in left}
    known = [*at.values()] or [0j]
    middle = sum(known) / len(known)
    radius = max(abs(z - middle) for z in known) or 1.0
    turn = cmath.exp(1j * number) / (1.0 + 0.3 * number)
    at |= {name: middle + radius * turn * cmath.exp(1j * GOLDEN * (k + 1)) for k, name in enumerate(left)}
    data = placing_data(model, folder)
    for slot in (one for one in data.lines if len(one.nodes) == 2 and one.nodes[1] in left):
        first, second = slot.nodes
        along = _direction(data, slot, at)
        at[second] = at[first] + radius * (-along if model.open.parts[second].side == SIDES[0] else along)
    return moved(model, {name: at[name] for name in left})


def _direction(data: PlacingData, slot: GivenLine, at: Mapping[str, complex]) -> complex:
    """Return the direction of a guide at rough positions of its member: that of the best fit of the member's shape."""
    for shape in data.shapes.values():
        if set(slot.guide) <= shape.keys():
            own, there = ([places[n] for n in shape] for places in (shape, at))
            middle, centre = sum(own) / len(own), sum(there) / len(there)
            turn = sum((z - middle).conjugate() * (w - centre) for z, w in zip(own, there, strict=True))
            return complex(unit(turn) * unit(shape[slot.guide[1]] - shape[slot.guide[0]]))
    return complex(unit(at[slot.guide[1]] - at[slot.guide[0]]))


def moved(model: Model, at: Mapping[str, Any], **opened: Any) -> Model:
    """Return a model with other positions of some nodes, and other values of its `open`."""
    nodes = {name: [at[name].real, at[name].imag] if name in at else xy for name, xy in model.nodes.items()}
    moved = model.with_value("nodes", lambda _: nodes)
    moved.open = model.open._replace(**opened)
    return moved


def _points(model: Model) -> dict[str, Any]:
    """Return the positions of the nodes of a model, which may be recorded numbers."""
    return dict(zip(model.nodes, places([*model.nodes.values()]).tolist(), strict=True))


# -- a file that is read --------------------------------------------------------------------

Read = tuple[Model, list[PartFault]]
"""A model whose nodes all have positions; rough ones if there are reasons why they cannot be placed."""


def with_open_nodes(source: Source, model: Model) -> Read:
    """Return a validated model with the positions of its nodes without coordinates."""
    model.open = OpenNodes({name: part for name, part in model.nodes.items() if isinstance(part, OpenNode)})
    faults = list(_fixed(model))
    placing = place(model, source.folder, {})
    faults += [] if faults else _left(model, placing)
    if not faults and placing.blocked is not None:
        faults.append(_impossible(source, model, placing.data, placing.blocked))
    left, found = (model.open.parts, Placement({}, {})) if faults else (placing.left, placing.found[0])
    coupled = tuple(name for name in model.nodes if name in left)
    model = moved(model, found.at, sides=found.sides, undecided=placing.undecided, coupled=coupled)
    return with_rough(model, source.folder) if coupled else model, faults


def placed_anew(source: Source, model: Model) -> Read:
    """Return a model whose dimensions have changed with new positions of its open nodes; chosen sides are kept."""
    old = model.open
    placing = place(model, source.folder, old.sides)
    if placing.blocked is not None:
        return model, [_impossible(source, model, placing.data, placing.blocked)]
    undecided = [name for name in placing.undecided if name in old.undecided or name not in old.sides]
    at, sides, _ = placing.found[0]
    return moved(model, at, sides=sides, undecided=tuple(undecided)), []


def _fixed(model: Model) -> Iterator[PartFault]:
    """Return the nodes that need coordinates: those of the ground, and the first two of a held member."""
    held = model.members.get(model.ground.member or "")
    why = f"it gives the position of '{model.ground.member}', which is held fixed" if held else "it is a ground node"
    return those(*(name in model.open.parts and PartFault(
        ("nodes", name), f"node {name} needs coordinates [x, y]: {why}"
    ) for name in (model.ground.nodes if held is None else held.nodes[:2])))  # fmt: skip


def _left(model: Model, placing: Placing) -> list[PartFault]:
    """Return the reasons for nodes that no step places; first those with a dimension that is missing."""
    used, faults = used_nodes(model), list[PartFault]()
    for name in (name for name in model.nodes if name in placing.left):
        given = {key: part for key, part in placing.data.missing.items() if name in part.nodes}
        lacking = [f"the `{'length' if isinstance(part, Link) else 'shape'}` of {key}" for key, part in given.items()]
        faults += those(
            name not in used and PartFault(
                ("nodes", name), f"node {name} has no coordinates and belongs to no member; add it to one, or remove it"
            ),
            name in used and lacking and PartFault(
                ("nodes", name),
                f"node {name} has no coordinates, and nothing else determines its position: give {', '.join(lacking)},"
                " or coordinates [x, y]",
            ),
        )  # fmt: skip
    return faults or list(_open_laws(model, placing))


def _open_laws(model: Model, placing: Placing) -> Iterator[PartFault]:
    """Yield the actuators whose law starts at a value that only coordinates would give."""
    known = {*placing.data.shapes, *(one.name for one in placing.data.lines)}
    for name, actuator in model.actuators.items():
        law = actuator.law
        given = name in known or (actuator.pivot is not None and law is not None and starts_by_value(law))
        lacking = "`from`" if law is not None and ended(law) else "`from` and `to`"
        open_ends = placing.left.intersection(actuator.named)
        yield from those(not given and open_ends and PartFault(
            ("actuators", name), f"the law of {name} needs {lacking}: the node {min(open_ends)} has no coordinates"
        ))  # fmt: skip


def _impossible(source: Source, model: Model, data: PlacingData, gap: Gap) -> PartFault:
    """Return the error for a step that is impossible."""
    at = _inputs(model, data)
    return PartFault(("nodes", gap.node), f"{gap.node} cannot be placed{at}: {gap.text}{_other(source, model)}")


def _inputs(model: Model, data: PlacingData) -> str:
    """Return the inputs of a message."""
    units = model.units
    unit = "" if units.length == "unit" else f" {units.length}"
    values = [
        *(f"{name} = {number(rad / RADIANS[units.angle])} {units.angle}" for name, (_, rad) in data.angles.items()),
        *(
            f"{name} = {number([*own.values()][1])}{unit}"
            for name, own in data.shapes.items()
            if name in model.actuators
        ),
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


# -- sides ----------------------------------------------------------------------------------


class _Search:
    """Search for the positions of all steps, with the sides that are asked for and all others."""

    def __init__(
        self, steps: list[PlacingStep], asked: Mapping[str, str], preferred: Mapping[str, str], size: float
    ) -> None:
        self.steps, self.asked, self.preferred, self.size = steps, asked, preferred, size
        self.blocked: Gap | None = None

    def run(self, at: dict[str, Any]) -> Iterator[Placement]:
        """Yield the placements, those of the preferred sides first."""
        sides = dict[str, str]()
        waiting: list[tuple[int, str, dict[str, Any]]] = [(-1, "", {})]  # number of a step, a side, and its positions
        for _ in range(TRIES + 4 * len(self.steps)):
            if not waiting:
                return
            number, side, positions = waiting.pop()
            at.update(positions)
            if side:
                sides[self.steps[number].owner] = side
            if number + 1 < len(self.steps):
                waiting += [(number + 1, *choice) for choice in reversed(self._choices(at, number + 1))]
            else:
                yield Placement(dict(at), dict(sides))

    def _choices(self, at: Mapping[str, Any], number: int) -> list[tuple[str, dict[str, Any]]]:
        """Return the positions of a step with their sides, the preferred one first; none if it is impossible.

        A step without a choice has no side.
        """
        step = self.steps[number]
        try:
            positions = step.positions(at)
        except Gap as gap:
            gap.node, gap.number = step.node, number
            known = (one for one in (self.blocked, gap) if one is not None)
            self.blocked = min(known, key=lambda one: (-one.number, one.amount))  # farthest, or nearest to possible
            return []
        named = list(zip(SIDES if step.owner else ("",), positions, strict=False))
        asked = self.asked.get(step.owner)
        if asked is not None:
            return named[SIDES.index(asked) :][:1] or named
        if len(named) > 1 and all(abs(positions[0][n] - positions[1][n]) <= SAME * self.size for n in positions[0]):
            return named[:1]
        return named[::-1] if self.preferred.get(step.owner) == SIDES[1] else named


def _size(data: PlacingData, given: Mapping[str, complex]) -> float:
    """Return the largest dimension between nodes, or of a member."""
    groups = [list(one.values()) for one in (given, *data.shapes.values())]
    return max((abs(z - group[0]) for group in groups for z in group[1:]), default=0.0)


def _errors(data: PlacingData, at: Mapping[str, Any], opened: set[str]) -> Iterator[float]:
    """Yield the errors of the dimensions between nodes that are placed."""
    for shape in data.shapes.values():
        names = [n for n in shape if n in at]
        if len(names) > 1 and opened & set(names):
            a, b = names[0], max(names, key=lambda n: abs(shape[n] - shape[names[0]]))
            turned = unit(at[b] - at[a]) / unit(shape[b] - shape[a])
            yield from (abs(at[a] + turned * (shape[n] - shape[a]) - at[n]) for n in names)
    for one in data.lines:
        for node in one.nodes:
            own = {node, *one.guide}
            if opened & own and own <= at.keys():
                yield abs(height(one.line(at), at[node]))
