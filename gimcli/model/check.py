"""Validation of a model file: types by the schema, then what its parts say of each other.

Every fault of a file is one line: file:line:column, what was met, what to do.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from gimcli.errors import ModelError
from gimcli.model.schema import PROFILES, Actuator, Law, Model, long_form
from gimcli.model.source import Source, Where, read_source


def load_model(path: Path | str) -> Model:
    """Read and validate a model file; raise ModelError with all its faults."""
    source = read_source(Path(path))
    try:
        model = Model.model_validate(long_form(source.data))
    except ValidationError as error:
        faults = [_schema_fault(source, dict(e)) for e in error.errors()]
        raise ModelError(_sorted(source.faults + faults)) from None
    faults = source.faults + Checker(source, model).run()
    if faults:
        raise ModelError(_sorted(faults))
    return model


def _sorted(faults: Iterable[str]) -> list[str]:
    def place(fault: str) -> tuple[int, int]:
        numbers = [part for part in fault.split(":")[1:3] if part.isdigit()]
        return (int(numbers[0]), int(numbers[1])) if len(numbers) == 2 else (0, 0)

    return sorted(dict.fromkeys(faults), key=place)


def near(word: str, words: Iterable[str]) -> str:
    """Return '; did you mean X?' for a near miss, else ''."""
    found = difflib.get_close_matches(word, list(words), 1, 0.6)
    folded = [w for w in words if w.lower() == word.lower()]
    best = folded or found
    return f"; did you mean '{best[0]}'?" if best else ""


# -- types ----------------------------------------------------------------------------------


def _schema_fault(source: Source, error: dict[str, Any]) -> str:
    kind, where = str(error["type"]), tuple(p for p in error["loc"])
    met, limits = error.get("input"), error.get("ctx", {})
    path: Where = tuple(p for p in where if not (p == "nodes" and _short(source, where)))
    name = ".".join(str(p) for p in where) or "the file"
    at = source.at(path)
    if kind == "extra_forbidden":
        known = _known_keys(where[:-1])
        listed = near(str(where[-1]), known) or f"; known here: {', '.join(known)}"
        return f"{source.at(path, key=True)}: unknown key '{where[-1]}'{listed}"
    if kind == "missing":
        cure = "; write `ground: [NODES]`, or `ground: {member: NAME}` for a floating mechanism"
        return f"{at}: '{where[-1]}' is missing" + (cure if where == ("ground",) else f"; add `{where[-1]}:`")
    if kind in ("float_type", "float_parsing"):
        return f"{at}: {name}: a number is needed, met {_shown(met)}"
    if kind == "finite_number":
        return f"{at}: {name}: a finite number is needed, met {met}"
    if kind in ("greater_than", "greater_than_equal"):
        least = limits.get("gt", limits.get("ge"))
        bound = "above" if "gt" in limits else "at least"
        return f"{at}: {name}: must be {bound} {least:g}, met {met}"
    if kind == "literal_error":
        allowed = [w.strip(" '") for w in str(limits.get("expected", "")).replace(" or ", ", ").split(",")]
        return f"{at}: {name}: met {_shown(met)}; choose {', '.join(allowed)}{near(str(met), allowed)}"
    if kind in ("too_short", "too_long"):
        length = limits.get("min_length", limits.get("max_length"))
        count = limits.get("actual_length")
        side = "at least" if kind == "too_short" else "no more than"
        return f"{at}: {name}: {side} {length} entries are needed, met {count}"
    if kind in ("list_type", "dict_type", "model_type"):
        form = "a list such as [A, B]" if kind == "list_type" else "a mapping of keys"
        return f"{at}: {name}: {form} is needed, met {_shown(met)}"
    if kind.startswith("string"):
        return f"{at}: {name}: a name is needed, met {_shown(met)}"
    return f"{at}: {name}: {error.get('msg', kind)}, met {_shown(met)}"


def _short(source: Source, where: Where) -> bool:
    return len(where) > 1 and where not in source.values and where[:-1] in source.values


def _shown(met: Any) -> str:
    text = repr(met) if not isinstance(met, dict) else "a mapping"
    return text if len(text) <= 60 else text[:57] + "..."


def _known_keys(where: Sequence[Any]) -> list[str]:
    schema = Model.model_json_schema(by_alias=True)
    node: dict[str, Any] = schema
    for part in where:
        if part in node.get("properties", {}):
            node = node["properties"][part]
        elif isinstance(node.get("additionalProperties"), dict):
            node = node["additionalProperties"]
        for option in [*node.get("anyOf", []), *node.get("allOf", []), node]:
            if "$ref" in option:
                node = schema["$defs"][option["$ref"].rsplit("/", 1)[-1]]
                break
    return list(node.get("properties", {}))


# -- references -----------------------------------------------------------------------------


class Checker:
    """What the parts of a model say of each other."""

    def __init__(self, source: Source, model: Model) -> None:
        self.source, self.model = source, model
        self.faults: list[str] = []
        self.members: dict[str, list[str]] = {k: v.nodes for k, v in model.links.items()}
        self.members |= {k: v.nodes for k, v in model.elements.items()}
        self.ground = set(model.ground.nodes)
        if model.ground.member in self.members:
            self.ground = set(self.members[model.ground.member])

    def run(self) -> list[str]:
        """Return all faults."""
        model = self.model
        if not model.links and not model.elements:
            self.fault((), "no members; add `links:` or `elements:`")
        self._ground()
        for name in set(model.links) & set(model.elements):
            self.fault(("elements", name), f"'{name}' names a link too; rename one", key=True)
        for name, nodes in self.members.items():
            self._member(name, nodes)
        for name, element in model.elements.items():
            if element.shape is not None:
                self._shape(name, element.nodes, element.shape)
        self._prismatic()
        for name, actuator in model.actuators.items():
            self._actuator(name, actuator)
        self._points()
        return self.faults

    def fault(self, where: Where, text: str, key: bool = False) -> None:
        """Note a fault."""
        while where and where not in self.source.values and "nodes" in where:
            where = tuple(p for p in where if p != "nodes")
        self.faults.append(f"{self.source.at(where, key)}: {text}")

    def node(self, where: Where, name: str) -> bool:
        """Tell whether a node is declared; note a fault where it is not."""
        if name in self.model.nodes:
            return True
        hint = near(name, self.model.nodes) or f"; declare it under `nodes:` or use {self._some_nodes()}"
        self.fault(where, f"node '{name}' is not declared{hint}")
        return False

    def _some_nodes(self) -> str:
        names = list(self.model.nodes)
        return ", ".join(names[:6]) + (" ..." if len(names) > 6 else "")

    def nodes(self, where: Where, names: Sequence[str]) -> bool:
        """Tell whether all nodes of a list are declared and different."""
        good = all([self.node((*where, k), n) for k, n in enumerate(names)])
        if len(set(names)) < len(names):
            self.fault(where, f"a node is named twice in [{', '.join(names)}]; name different nodes")
            return False
        return good

    def _ground(self) -> None:
        ground = self.model.ground
        if ground.member is not None and ground.nodes:
            self.fault(("ground",), "met both nodes and a member; ground one or the other")
        elif ground.member is not None:
            if ground.member not in self.members:
                hint = near(ground.member, self.members)
                self.fault(("ground", "member"), f"member '{ground.member}' does not exist{hint}")
        elif not ground.nodes:
            self.fault(("ground",), "no node is fixed; write `ground: [NODES]` or `ground: {member: NAME}`")
        self.nodes(("ground", "nodes"), ground.nodes)

    def _member(self, name: str, nodes: list[str]) -> None:
        section = "links" if name in self.model.links else "elements"
        if not self.nodes((section, name, "nodes"), nodes):
            return
        if self.model.ground.member is None and set(nodes) <= self.ground:
            self.fault((section, name), f"'{name}' joins ground nodes only; remove it, the frame is a member already")
        free = (section == "links" and self.model.links[name].length is None) or (
            section == "elements" and self.model.elements[name].shape is None
        )
        for i, a in enumerate(nodes) if free else ():
            for b in nodes[:i]:
                if self.model.nodes[a] == self.model.nodes[b]:
                    cure = "move one, or give the `length`" if section == "links" else "move one, or give the `shape`"
                    self.fault((section, name), f"nodes {b} and {a} of '{name}' coincide; {cure}")

    def _shape(self, name: str, nodes: list[str], shape: dict[str, list[float]]) -> None:
        for node in nodes:
            if node not in shape:
                self.fault(("elements", name, "shape"), f"shape of '{name}' lacks node {node}; add its place")
        for node in shape:
            if node not in nodes:
                hint = near(node, nodes)
                self.fault(("elements", name, "shape", node), f"'{node}' is no node of '{name}'{hint}", key=True)
        places = [tuple(shape[n]) for n in nodes if n in shape]
        if len(set(places)) < len(places):
            self.fault(("elements", name, "shape"), f"two nodes of '{name}' coincide in its shape; move one")

    def carriers(self, *nodes: str) -> list[str]:
        """Return the members that hold all nodes; 'ground' first."""
        found = ["ground"] if set(nodes) <= self.ground else []
        return found + [k for k, v in self.members.items() if set(nodes) <= set(v)]

    def _guide(self, where: Where, guide: list[str], sliding: list[str]) -> None:
        if not self.nodes((*where, "guide"), guide):
            return
        carriers = self.carriers(*guide)
        if not carriers:
            text = f"guide nodes {guide[0]} and {guide[1]} belong to no common member; name two nodes of one, or of the ground"
            self.fault((*where, "guide"), text)
            return
        if self.model.nodes[guide[0]] == self.model.nodes[guide[1]]:
            self.fault((*where, "guide"), f"guide nodes {guide[0]} and {guide[1]} coincide; they must show a direction")
        held = self.ground if carriers[0] == "ground" else set(self.members[carriers[0]])
        for node in sliding:
            if node in held:
                self.fault(
                    where, f"node {node} belongs to '{carriers[0]}', which carries the guide; it cannot slide on it"
                )

    def _prismatic(self) -> None:
        for name, pair in self.model.prismatic.items():
            where: Where = ("prismatic", name)
            if (pair.node is None) == (pair.nodes is None):
                self.fault(where, f"'{name}' needs either `node` (pin in a slot) or `nodes` (no relative rotation)")
                continue
            sliding = [pair.node] if pair.node is not None else list(pair.nodes or [])
            known = (
                self.node((*where, "node"), sliding[0])
                if pair.node is not None
                else self.nodes((*where, "nodes"), sliding)
            )
            if known:
                self._guide(where, pair.guide, sliding)
            if known and len(sliding) == 2 and not self.carriers(*sliding):
                self.fault(
                    (*where, "nodes"),
                    f"nodes {sliding[0]} and {sliding[1]} belong to no common member; one member slides",
                )

    # -- actuators --------------------------------------------------------------------------

    def _actuator(self, name: str, actuator: Actuator) -> None:
        where: Where = ("actuators", name)
        given = {k for k in ("pivot", "arm", "reference", "nodes", "node", "guide") if getattr(actuator, k) is not None}
        if actuator.type == "rotary":
            self._fields(where, name, given, {"pivot", "arm"}, {"reference"})
            if {"pivot", "arm"} <= given:
                self._rotary(where, actuator)
        elif "nodes" in given:
            self._fields(where, name, given, {"nodes"}, set())
            self._telescope(where, list(actuator.nodes or []))
        else:
            self._fields(where, name, given, {"node", "guide"}, set())
            if {"node", "guide"} <= given and self.node((*where, "node"), str(actuator.node)):
                self._guide(where, list(actuator.guide or []), [str(actuator.node)])
        if actuator.law is not None:
            self._law((*where, "law"), actuator.law)

    def _fields(self, where: Where, name: str, given: set[str], needed: set[str], optional: set[str]) -> None:
        for key in sorted(needed - given):
            self.fault(where, f"actuator '{name}' needs `{key}`")
        for key in sorted(given - needed - optional):
            kind = self.model.actuators[name].type
            self.fault((*where, key), f"`{key}` does not belong to this {kind} actuator; remove it", key=True)

    def _rotary(self, where: Where, actuator: Actuator) -> None:
        pivot, arm, reference = str(actuator.pivot), str(actuator.arm), actuator.reference
        known = [self.node((*where, k), n) for k, n in (("pivot", pivot), ("arm", arm))]
        if reference is not None:
            known.append(self.node((*where, "reference"), reference))
        if not all(known):
            return
        arms = [m for m in self.carriers(pivot, arm) if m != "ground"]
        if pivot == arm or not arms:
            self.fault(
                (*where, "arm"), f"pivot {pivot} and arm {arm} belong to no common moving member; name two nodes of one"
            )
            return
        if reference is None:
            others = [m for m in self.carriers(pivot) if m not in ("ground", arms[0])]
            if pivot not in self.ground and others:
                text = (
                    f"pivot {pivot} joins '{arms[0]}' and '{others[0]}', which both move; add a `reference` node on one"
                )
                self.fault((*where, "pivot"), text)
        elif not [m for m in self.carriers(pivot, reference) if m != arms[0]]:
            text = f"pivot {pivot} and reference {reference} belong to no other common member; name a node of one that {arms[0]} turns on"
            self.fault((*where, "reference"), text)

    def _telescope(self, where: Where, nodes: list[str]) -> None:
        if self.nodes((*where, "nodes"), nodes) and self.carriers(*nodes):
            text = f"nodes {nodes[0]} and {nodes[1]} belong to one member ('{self.carriers(*nodes)[0]}'): their distance cannot change"
            self.fault((*where, "nodes"), text)

    def _law(self, where: Where, law: Law) -> None:
        profile = law.profile
        if profile.name not in PROFILES:
            self.fault(
                where,
                f"profile '{profile.name}' is unknown; choose {', '.join(PROFILES)}{near(profile.name, PROFILES)}",
            )
        if law.by is not None and (law.from_ is not None or law.to is not None):
            self.fault(where, "met `by` with `from` or `to`; give an increment or absolute values")
        if profile.table is not None:
            if law.from_ is not None or law.to is not None or law.by is not None:
                self.fault(where, "a table holds absolute values; remove `from`, `to` and `by`")
            self._table(where, profile.table)
            return
        if law.by is None and (law.from_ is None) != (law.to is None):
            missing = "to" if law.to is None else "from"
            self.fault(where, f"`{missing}` is missing; give both ends, or `by`")
        if profile.polynomial is not None and (law.by is not None or law.from_ is not None):
            ends = profile.polynomial[0], math.fsum(profile.polynomial)
            if ends[0] != 0.0 or abs(ends[1] - 1.0) > 1e-9:
                text = f"with `from` and `to` the polynomial must run from 0 to 1, met {ends[0]:g} to {ends[1]:g}"
                self.fault(where, text)

    def _table(self, where: Where, name: str) -> None:
        from gimcli.model.tables import read_table

        try:
            time, _ = read_table(self.source.path.parent / name)
        except ValueError as error:
            self.fault(where, f"table {name}: {error}")
            return
        span, duration = time[-1] - time[0], self.model.duration
        if duration is not None and abs(span - duration) > 1e-9 * duration:
            self.fault(where, f"table {name} runs {span:g} s, duration is {duration:g} s; make them equal")

    # -- points, masses, loads ------------------------------------------------------------------

    def _points(self) -> None:
        model = self.model
        for name, point in model.points.items():
            self._carried("points", name, point.on)
            if (point.at is None) == (point.local is None):
                self.fault(("points", name), f"point '{name}' needs either `at` (drawn) or `local`")
            if name in model.nodes:
                self.fault(("points", name), f"point '{name}' has the name of a node; rename it", key=True)
        for k, name in enumerate(model.trace):
            known = [*model.points, *model.nodes]
            if name not in known:
                self.fault(("trace", k), f"'{name}' is neither a point nor a node{near(name, known)}")
        for name in model.masses:
            self._carried("masses", name, name)
        for name, load in model.loads.items():
            self._carried("loads", name, load.on)
            if (load.force is None) == (load.torque is None):
                self.fault(("loads", name), f"load '{name}' needs either `force` or `torque`")
            if load.force is not None and (load.at is None) == (load.local is None):
                self.fault(("loads", name), f"force '{name}' needs either `at` (drawn) or `local`")

    def _carried(self, section: str, name: str, member: str) -> None:
        if member not in self.members and member != "ground":
            where: Where = (section, name) if section == "masses" else (section, name, "on")
            hint = near(member, self.members) or f"; members: {', '.join(list(self.members)[:8])}"
            self.fault(where, f"member '{member}' does not exist{hint}", key=section == "masses")
