"""The positions of nodes without coordinates, computed from the lengths, angles and shapes of the file.

The nodes are placed one after the other (see `placing_steps`). A step with two positions follows the `side` of its
node; without a side, a position is chosen if only one of the two lets all other nodes be placed.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from gimcli.model.placing_data import GivenSlot, PlacingData, height, line_of, placing_data, unit
from gimcli.model.placing_order import steps_of
from gimcli.model.placing_steps import CircleAndLine, Gap, PlacingStep
from gimcli.model.schema import Model, OpenNode

SIDES = ("left", "right")

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


class Blocked(NamedTuple):
    """A step that cannot be done, and the positions of the nodes before it."""

    number: int
    step: PlacingStep
    gap: Gap


class Placement(NamedTuple):
    """One set of positions: of all nodes that could be placed, and the sides that were chosen."""

    at: dict[str, Any]
    sides: dict[str, str]


@dataclass(frozen=True)
class Placing:
    """The result of placing the open nodes of a model."""

    data: PlacingData
    steps: tuple[PlacingStep, ...]
    left: frozenset[str]
    """Nodes for which there is no step."""
    asked: Mapping[str, str]
    """The sides that are given."""
    found: tuple[Placement, ...]
    """Possible sets of positions; those of the nodes in `left` are not in it."""
    blocked: Blocked | None
    """If nothing was found: the step that failed."""

    @property
    def undecided(self) -> tuple[str, ...]:
        """The nodes whose side is open; if there are very many positions, all for which no side is given."""
        sides = [one.sides for one in self.found]
        if len(sides) >= FOUND:
            return tuple(name for name in sides[0] if name not in self.asked)
        names = [step.owner for step in self.steps if step.owner]
        return tuple(name for name in names if len({one.get(name) for one in sides}) > 1)


def place(model: Model, folder: Path, preferred: Mapping[str, str]) -> Placing:
    """Return the positions of the open nodes of a model; the paths of tables start at `folder`.

    `preferred` are sides that are chosen where both are possible.
    """
    data = placing_data(model, folder)
    given = {name: complex(*xy) for name, xy in model.nodes.items() if name not in model.open.parts}
    steps, left = steps_of(data, set(given))
    asked = _usual_sides(steps) | {name: part.side for name, part in model.open.parts.items() if part.side is not None}
    size = _size(data, given)
    search = _Search(steps, asked, preferred, size)
    found = tuple(search.run(given))
    exact = tuple(one for one in found if _fits(data, one.at, model.open.parts, size)) if len(found) > 1 else found
    return Placing(data, tuple(steps), frozenset(left), asked, exact or found, None if found else search.blocked)


def _usual_sides(steps: Sequence[PlacingStep]) -> dict[str, str]:
    """Return the sides of nodes of sliding pairs without rotation: the second node is ahead of the first."""
    found = {}
    for step in steps:
        pair = step.locus.given.nodes if isinstance(step, CircleAndLine) else ()
        if len(pair) == 2 and {step.node, step.circle.centre} == set(pair):  # type: ignore[attr-defined]  # known by `pair`
            found[step.node] = SIDES[pair.index(step.node)]
    return found


def placed_again(model: Model, folder: Path) -> Model:
    """Return a model with positions of its open nodes from other dimensions, which may be recorded numbers.

    The sides are kept; nodes for which there is no step keep their coordinates. Raises Gap if a step is impossible.
    """
    data = placing_data(model, folder)
    at = {name: _point(xy) for name, xy in model.nodes.items()}
    steps, _ = steps_of(data, set(model.nodes) - set(model.open.parts))
    for step in steps:
        at |= _chosen(step, step.positions(at), model.open.sides)
    return _moved(model, {name: at[name] for name in model.open.parts})


def sides_at(model: Model, folder: Path, at: Mapping[str, complex]) -> dict[str, str]:
    """Return the sides that the nodes of a model have at some positions; of nodes for which there is a choice."""
    data = placing_data(model, folder)
    known = {**{name: _point(xy) for name, xy in model.nodes.items()}, **at}
    found = {}
    for step in steps_of(data, set(model.nodes) - set(model.open.parts))[0]:
        if step.owner:
            try:
                positions = step.positions(known)
            except Gap:
                continue
            away = [max(abs(one[n] - known[n]) for n in one) for one in positions]
            found[step.owner] = SIDES[int(away[-1] < away[0])]
    return found


def with_sides(model: Model, sides: Mapping[str, str]) -> Model:
    """Return a model with chosen sides of its open nodes."""
    parts = {name: OpenNode(side=sides.get(name, part.side)) for name, part in model.open.parts.items()}
    return _moved(model, {}, parts=parts, sides={**model.open.sides, **sides})


def rough_again(model: Model, folder: Path, number: int) -> Model:
    """Return a model with other rough positions of its coupled nodes."""
    opened = model.open
    at = {name: _point(xy) for name, xy in model.nodes.items() if name not in opened.coupled}
    data = placing_data(model, folder)
    rough = with_rough(model, data, Placement(at, dict(opened.sides)), opened.coupled, number)
    return with_positions(model, rough, opened.undecided)


def with_rough(
    model: Model, data: PlacingData, placement: Placement, left: Sequence[str], number: int = 0
) -> Placement:
    """Return a placement with rough positions of other nodes: on a circle about the nodes that are placed.

    The sense of sliding pairs without rotation is that of the side of the second node; without a side it is `right`.
    `number`: of the circle, where others are needed.
    """
    known = list(placement.at.values()) or [0j]
    middle = sum(known) / len(known)
    radius = max(abs(z - middle) for z in known) or 1.0
    turn = cmath.exp(1j * number) / (1.0 + 0.3 * number)
    rough = {name: middle + radius * turn * cmath.exp(1j * GOLDEN * (k + 1)) for k, name in enumerate(left)}
    at = {**placement.at, **rough}
    for slot in (one for one in data.slots if len(one.nodes) == 2):
        first, second = slot.nodes
        if second in rough:
            along = _direction(data, slot, at)
            at[second] = at[first] + radius * (-along if model.open.parts[second].side == SIDES[0] else along)
    return placement._replace(at=at)


def _direction(data: PlacingData, slot: GivenSlot, at: Mapping[str, complex]) -> complex:
    """Return the direction of a guide at rough positions of its member: that of the best fit of the member's shape."""
    for shape in data.shapes:
        if set(slot.guide) <= shape.local.keys():
            names = list(shape.local)
            own, there = ([places[n] for n in names] for places in (shape.local, at))
            middle, centre = sum(own) / len(own), sum(there) / len(there)
            turn = sum((z - middle).conjugate() * (w - centre) for z, w in zip(own, there, strict=True))
            return complex(unit(turn) * unit(shape.local[slot.guide[1]] - shape.local[slot.guide[0]]))
    return complex(unit(at[slot.guide[1]] - at[slot.guide[0]]))


def with_coordinates(model: Model, at: Mapping[str, complex], chosen: bool) -> Model:
    """Return a model with positions, which may be `chosen`, of the nodes that no step places; all sides are decided."""
    data = placing_data(model, Path())
    _, left = steps_of(data, set(model.nodes) - set(model.open.parts))
    found = {name: at[name] for name in left if name in at}
    return _moved(model, found, coupled=(), undecided=(), chosen=tuple(found) if chosen else ())


def with_positions(model: Model, placement: Placement, undecided: Sequence[str] = ()) -> Model:
    """Return a model with the positions and sides of a placement, in the order of the file."""
    at = {name: z for name, z in placement.at.items() if name in model.open.parts}
    return _moved(model, at, sides=dict(placement.sides), undecided=tuple(undecided))


def _moved(model: Model, at: Mapping[str, Any], **opened: Any) -> Model:
    """Return a model with other positions of some nodes, and other values of its `open`."""
    nodes = {name: [at[name].real, at[name].imag] if name in at else xy for name, xy in model.nodes.items()}
    moved = model.with_value("nodes", lambda _: nodes)
    moved.open = model.open._replace(**opened)
    return moved


def _point(xy: Sequence[Any]) -> Any:
    x, y = xy
    return complex(x, y) if isinstance(x, float) and isinstance(y, float) else x + 1j * y


def _chosen(step: PlacingStep, positions: list[dict[str, Any]], sides: Mapping[str, str]) -> dict[str, Any]:
    """Return the position of a step for the side of its owner."""
    return positions[SIDES.index(sides.get(step.owner, SIDES[0])) if len(positions) > 1 else 0]


class _Search:
    """Search for the positions of all steps, with the sides that are asked for and all others."""

    def __init__(
        self, steps: list[PlacingStep], asked: Mapping[str, str], preferred: Mapping[str, str], size: float
    ) -> None:
        self.steps, self.asked, self.preferred, self.size = steps, asked, preferred, size
        self.blocked: Blocked | None = None

    def run(self, at: dict[str, Any]) -> Iterator[Placement]:
        """Yield the placements, those of the preferred sides first."""
        sides: dict[str, str] = {}
        tries, most, found = 0, TRIES + 4 * len(self.steps), 0
        open_choices = [self._choices(at, 0)] if self.steps else []
        if not self.steps:
            yield Placement(dict(at), {})
        while open_choices and tries < most and found < FOUND:
            number = len(open_choices) - 1
            step, tried = self.steps[number], next(open_choices[-1], None)
            tries += 1
            for name in step.nodes:
                at.pop(name, None)
            if tried is None:
                open_choices.pop()
                continue
            side, positions = tried
            at.update(positions)
            if step.owner:
                sides[step.owner] = side
            if number + 1 < len(self.steps):
                open_choices.append(self._choices(at, number + 1))
            else:
                found += 1
                yield Placement(dict(at), dict(sides))

    def _choices(self, at: Mapping[str, Any], number: int) -> Iterator[tuple[str, dict[str, Any]]]:
        """Return the positions of a step with their sides, the preferred one first; none if it is impossible."""
        step = self.steps[number]
        try:
            positions = step.positions(at)
        except Gap as gap:
            self._note(Blocked(number, step, gap))
            return iter(())
        named = list(zip(SIDES, positions, strict=False))
        asked = self.asked.get(step.owner)
        if asked is not None:
            return iter(named[SIDES.index(asked) :][:1] or named)
        if len(named) > 1 and all(abs(positions[0][n] - positions[1][n]) <= SAME * self.size for n in positions[0]):
            return iter(named[:1])
        return iter(named[::-1] if self.preferred.get(step.owner) == SIDES[1] else named)

    def _note(self, blocked: Blocked) -> None:
        """Keep the failed step that is farthest, or nearest to be possible."""
        old = self.blocked
        if old is None or (-blocked.number, blocked.gap.amount) < (-old.number, old.gap.amount):
            self.blocked = blocked


def _size(data: PlacingData, given: Mapping[str, complex]) -> float:
    """Return the largest dimension between nodes, or of a member."""
    groups = [list(given.values()), *(list(shape.local.values()) for shape in data.shapes)]
    spans = [abs(z - group[0]) for group in groups for z in group[1:]]
    return max([*spans, *(abs(one.value) for one in data.distances)], default=0.0)


def _fits(data: PlacingData, at: Mapping[str, Any], opened: Mapping[str, Any], size: float) -> bool:
    """Return whether positions satisfy all dimensions that concern an open node."""
    return all(error <= FITS * size for error in _errors(data, at, set(opened)))


def _errors(data: PlacingData, at: Mapping[str, Any], opened: set[str]) -> Iterator[float]:
    """Yield the errors of the dimensions between nodes that are placed."""
    for shape in data.shapes:
        names = [n for n in shape.local if n in at]
        if len(names) > 1 and opened & set(names):
            a, b = names[0], max(names, key=lambda n: abs(shape.local[n] - shape.local[names[0]]))
            turned = unit(at[b] - at[a]) / unit(shape.local[b] - shape.local[a])
            yield from (abs(at[a] + turned * (shape.local[n] - shape.local[a]) - at[n]) for n in names)
    for one in data.guided:
        for node in one.nodes:
            own = {node, *one.guide}
            if opened & own and own <= at.keys():
                yield abs(height(line_of(at, one), at[node]))
    for given in data.distances:
        if opened & set(given.nodes) and at.keys() >= set(given.nodes):
            yield abs(abs(at[given.nodes[1]] - at[given.nodes[0]]) - given.value)
