"""Queries for the checks of a model: declared names, members of a node, coincident nodes."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import islice, pairwise
from typing import NamedTuple

from gimcli.calculus.numbers import nominal
from gimcli.model.pairs import having, node_of, used_nodes
from gimcli.model.schema import Load, Model, Tracer
from gimcli.model.source import Source, Where
from gimcli.model.tables import read_table
from gimcli.model.wording import written
from gimcli.nearest import near

CLOSEST = 1e-12
"""Nodes closer than this fraction of the mechanism's size coincide in double precision."""


class PartFault(NamedTuple):
    """An error of a part: the path of keys below the part, and whether it is at the key, not at the value.

    It is not recorded if an unknown key of the part was probably meant as one of those that are `lacking`, nor without
    a text: then another check reports it.
    """

    at: Where
    text: str
    key: bool = False
    lacking: Sequence[str] = ()


def those(*cases: object) -> Iterator[PartFault]:
    """Return the errors among some cases; the others, `condition and PartFault(...)`, do not hold."""
    return (one for one in cases if isinstance(one, PartFault))


class References:
    """The names of a model and the paths of its parts.

    `sized` are the nodes that give the size. `doubtful` holds the paths of invalid parts, whose error has been
    recorded: references to them are not reported.
    `sure` is false if a member or the ground is invalid, `placed` if a node is.
    """

    def __init__(self, source: Source, model: Model, sized: Collection[str], doubtful: Collection[Where] = ()) -> None:
        self.source, self.model, self.doubtful = source, model, doubtful
        self.every = {k: v.nodes for k, v in model.links.items()} | {k: v.nodes for k, v in model.elements.items()}
        self.held = model.ground.member
        self.ground = set(model.ground.nodes if self.held is None else self.every.get(self.held, []))
        self.members = {k: v for k, v in self.every.items() if k != self.held}
        self.sure = not any(where[0] in ("ground", "links", "elements") for where in doubtful)
        self.placed = not any(where[0] == "nodes" for where in doubtful)
        self.size = size_of(model, sized)

    def fault(self, where: Where, text: str, key: bool = False) -> None:
        """Record an error."""
        self.source.fault(written(self.source, where), text, key)

    def lack(self, where: Where, keys: Collection[str], text: str, key: bool = False) -> None:
        """Record that one of some keys is missing, unless an unknown key of the part was probably meant."""
        if not any((*where, one) in self.doubtful for one in keys):
            self.fault(where, text, key)

    def sound(self, where: Where, errors: Iterator[PartFault]) -> bool:
        """Return whether a part has no errors; record the first one."""
        return self.record(where, islice(errors, 1))

    def record(self, where: Where, errors: Iterable[PartFault]) -> bool:
        """Record all errors of a part; return whether there are none."""
        found = list(errors)
        for one in (one for one in found if one.text):
            self.lack((*where, *one.at), one.lacking, one.text, one.key)
        return not found

    def node(self, where: Where, name: str) -> bool:
        """Return whether a node is declared; record an error if it is not."""
        if name in self.model.nodes:
            return True
        declared = list(self.source.data["nodes"])
        if name not in declared:
            some = ", ".join(declared[:6]) + (" ..." if len(declared) > 6 else "")
            hint = near(name, declared) or f"; declare it under `nodes:` or use one of {some}"
            self.fault(where, f"node '{name}' is not declared{hint}")
        return False

    def nodes(self, where: Where, names: Sequence[str]) -> bool:
        """Return whether all nodes of a list are declared and different; record the errors."""
        declared = all([self.node((*where, k), n) for k, n in enumerate(names)])
        if len(set(names)) < len(names):
            self.fault(where, f"a node is named twice in [{', '.join(names)}]; name different nodes")
            return False
        return declared

    def member(self, where: Where, name: str, key: bool = False, nodes: bool = False) -> bool:
        """Return whether a member or the ground has a name; record an error if none has.

        `nodes`: whether a node is possible, too.
        """
        if name in self.every or name == "ground":
            return True
        if not {("links",), ("elements",), ("links", name), ("elements", name)} & set(self.doubtful):
            hint = near(name, self.every)
            if not hint:
                hint = f"; members: {', '.join(list(self.every)[:8])}"
                hint += f"; or a node: {', '.join(list(self.model.nodes)[:8])}" if nodes else ""
            self.fault(where, f"member '{name}' does not exist{hint}", key)
        return False

    def table(self, where: Where, name: str, first: str = "time") -> tuple[list[float], list[float]] | None:
        """Return the columns of a table over the variable `first`; None, and record an error, if it has none."""
        try:
            return read_table(self.source.folder / name, first)
        except ValueError as error:
            self.fault(where, f"table {name}: {error}")
            return None

    def having(self, name: str) -> Collection[str]:
        """Return the nodes of a member or of the ground; those of the member that is held are the ground's."""
        return self.ground if name in ("ground", self.held) else self.members[name]

    def bearer(self, where: Where, name: str, key: bool = False) -> str | None:
        """Return the node with a mass or a load, None if it is a member; record an error if it is neither."""
        model, node = self.model, node_of(self.model, name)
        if node is not None:
            if node in model.nodes and node not in used_nodes(model) and self.sure:
                self.fault(where, f"node '{node}' belongs to no member or pair; add it to one", key)
            return node
        if name in self.every or name == "ground" or ("nodes", name) in self.doubtful:
            return None
        if (pair := model.prismatic.get(name)) is not None:
            ends = " or ".join(pair.nodes or [])
            self.fault(where, f"'{name}' slides a member without rotation; name this member, or the node {ends}", key)
        elif near(name, self.every) or not (hint := near(name, [*model.nodes, *model.prismatic])):
            self.member(where, name, key, nodes=True)
        else:
            self.fault(where, f"'{name}' is neither a member nor a node{hint}", key)
        return None

    def drawn(self, where: Where, nodes: list[str]) -> None:
        """Record an error if the first two nodes of a member coincide: its initial direction is then undefined."""
        a, b = nodes[:2]
        if {a, b} <= set(self.model.nodes) and a != b and not self.apart(a, b):
            self.fault(where, f"nodes {a} and {b} coincide and define no direction; move one")

    def place(self, where: Where, part: Tracer | Load, what: str, known: bool) -> None:
        """Check the coordinates of a point or force (`what`) on a member, which is `known` if it exists."""
        if (part.at is None) == (part.local is None):
            self.lack(where, ("at", "local"), f"{what} '{where[1]}' needs either `at` (initial coordinates) or `local`")
        elif known and part.at is not None and part.on != "ground":
            self.drawn((*where, "at"), self.every[part.on])

    def carriers(self, *nodes: str) -> list[str]:
        """Return the members that have all of the nodes, 'ground' first."""
        return list(having(self.model, nodes))

    def apart(self, a: str, b: str) -> bool:
        """Return whether the initial coordinates of two declared nodes differ."""
        return math.dist(self.model.nodes[a], self.model.nodes[b]) > CLOSEST * self.size

    def coincident(self, places: dict[str, list[float]]) -> list[tuple[str, str]]:
        """Return pairs of names whose coordinates coincide."""
        grain = CLOSEST * self.size or 1.0
        order = sorted(places, key=lambda name: (round(places[name][0] / grain), places[name][1]))
        return [(a, b) for a, b in pairwise(order) if math.dist(places[a], places[b]) <= CLOSEST * self.size]


def size_of(model: Model, sized: Collection[str]) -> float:
    """Return the largest dimension (file's unit), from the initial coordinates or given.

    sized: the nodes that count; if they coincide, all nodes do. A node that is drawn farther away than its links can
    reach does not count.
    """
    return min(_extent(model, sized) or _extent(model, model.nodes), _reach(model))


def _reach(model: Model) -> float:
    """Return a distance that two nodes cannot exceed; inf if a length is that of the drawing, or a node can slide."""
    given = [link.length for link in model.links.values()] + [part.shape for part in model.elements.values()]
    if model.prismatic or not given or None in given:
        return math.inf
    parts = sum(_span(list(one.values())) if isinstance(one, dict) else nominal(one) for one in given)
    return float(parts) + _span([model.nodes[name] for name in model.ground.nodes if name in model.nodes])


def _extent(model: Model, names: Collection[str]) -> float:
    shapes = [e.shape for e in model.elements.values() if e.shape]
    spans = [_span([place for n, place in places.items() if n in names]) for places in [model.nodes, *shapes]]
    links = (link for link in model.links.values() if set(names).issuperset(link.nodes))
    return max([*spans, *(float(nominal(link.length or 0.0)) for link in links)])


def _span(places: list[list[float]]) -> float:
    if not places:
        return 0.0
    x, y = ([nominal(value) for value in part] for part in zip(*places, strict=True))
    return math.hypot(max(x) - min(x), max(y) - min(y))
