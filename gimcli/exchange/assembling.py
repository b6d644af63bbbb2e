"""From a draft to the data of a model file: joints are merged, slots get guides, bodies become members."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

from gimcli.exchange.draft import GROUND, PARALLEL, Draft, DrawnJoint, Place, coordinates, free_name

REACH = 0.25
"""Distance of an added guide node from its joint, relative to the size of the mechanism."""
SHORTEST = 0.05
"""Least distance of two joints that define the direction of a slot, relative to the size: the file rounds places."""
SAME = 1e-9
"""Distance of two joints at one place, relative to the size of the mechanism."""
ROUNDING = 1e-14
"""Coordinate, relative to the size of the mechanism, that is a rounding error of 0."""


def model_of(draft: Draft) -> dict[str, Any]:
    """Return the data of the model of a draft."""
    return Assembling(draft).model()


class Assembling:
    """The nodes, members and pairs that a draft becomes."""

    def __init__(self, draft: Draft) -> None:
        self.draft = draft
        self.places = {name: complex(*place) for name, place in draft.joints.items()}
        draft.refuse(not self.places, f"no joints found: this is not a mechanism of {draft.program}")
        self.size = draft.size()
        self.reach = float(f"{REACH * self.size:.0e}")  # one digit: readable coordinates
        self.tiny = SAME * self.size
        self.near = max(draft.resolution, self.tiny)
        self.same = {name: name for name in self.places}
        self._merge()
        self.bodies = {name: list(dict.fromkeys(self.same[j] for j in own)) for name, own in draft.bodies.items()}
        self.ground = self.bodies[GROUND]
        self.fixed = {GROUND}
        while any([self._absorbed(name, own) for name, own in self.bodies.items() if name not in self.fixed]):
            pass
        self.prismatic: dict[str, dict[str, Any]] = {}
        self.guides: dict[str, list[str]] = {}
        self.lines: dict[tuple[str, str, complex], list[str]] = {}
        for slot in draft.slots:
            self._slot(slot)

    # -- joints and bodies ----------------------------------------------------------------------

    def _merge(self) -> None:
        """Let joints of one body that coincide be one node."""
        bodies = (own for name, own in self.draft.bodies.items() if name != GROUND)
        for a, b in (pair for own in bodies for pair in combinations(own, 2)):
            first, second = self.same[a], self.same[b]
            if first != second and self._gap(first, second) <= self.near:
                self.same.update({k: first for k, v in self.same.items() if v == second})

    def _absorbed(self, name: str, own: list[str]) -> bool:
        """Add a body to the ground if it shares two nodes with it; return whether it does."""
        shared = combinations(set(own) & set(self.ground), 2)
        found = any(self._gap(a, b) > self.tiny for a, b in shared)
        if found:
            self.ground += [node for node in own if node not in self.ground]
            self.fixed.add(name)
        return found

    def _gap(self, a: str, b: str) -> float:
        return abs(self.places[a] - self.places[b])

    def _carrier(self, name: str) -> str:
        return GROUND if name in self.fixed else name

    def _add(self, carrier: str, name: str, place: complex) -> str:
        """Add a node to a carrier, unless it has one there; return its name."""
        there = [node for node in self.bodies[carrier] if abs(self.places[node] - place) <= self.tiny]
        if there:
            return there[0]
        own = free_name(name, self.places)
        digits = 12 - math.ceil(math.log10(self.size))
        self.places[own] = complex(round(place.real, digits), round(place.imag, digits))
        self.bodies[carrier].append(own)
        return own

    # -- slots ----------------------------------------------------------------------------------

    def _slot(self, slot: DrawnJoint) -> None:
        """Add the pair of a slot.

        A carrier that slides over a block of the ground is guided by the ground. Further blocks at the same joint turn
        about it: one more point on the line holds the direction of each, and no constraint is redundant.
        """
        node, carrier, body, named = self.same[slot.at], self._carrier(slot.carrier), slot.block, slot.guide
        held = bool(body) and self._carrier(body) == GROUND
        if carrier == GROUND and (held or (not body and node in self.ground)):
            self.draft.note(True, f"{slot.name} is left out: it joins parts that are fixed to the ground")
            return
        if held:
            node, body = self._add(carrier, f"{node}_slide", self.places[node]), carrier
            carrier, named = GROUND, None
        line = (node, carrier, slot.along)
        known = self.lines.get(line)
        guide = known or self._guide(named, node, carrier, slot.along)
        nodes = [] if known else [node]
        if body and (len(self.bodies[body]) > 1 or self._needed(body)):
            nodes.append(self._second(node, body, slot.along))
        if nodes:
            a, b = (self.places[n] for n in guide)
            offset = float(((self.places[node] - a) * ((b - a) / abs(b - a)).conjugate()).imag)
            shifted = {"offset": offset} if abs(offset) > self.near else {}
            place = {"nodes": nodes} if len(nodes) > 1 else {"node": nodes[0]}
            self.prismatic[free_name(slot.name, self.prismatic)] = {**place, "guide": guide, **shifted}
        self.lines[line] = guide
        self.guides[slot.name] = [*nodes, node][:1] + (guide[::-1] if held else guide)

    def _needed(self, body: str) -> bool:
        """Return whether the direction of a body of one joint matters: it carries a slot, a tracer or an input."""
        carriers = [slot.carrier for slot in self.draft.slots] + [owner for owner, _ in self.draft.tracers.values()]
        return body in carriers or any(body in turn.bodies for turn in self.draft.turns)

    def _guide(self, given: tuple[str, str] | None, node: str, carrier: str, direction: complex) -> list[str]:
        """Return two nodes of the carrier along the line of sliding; add them where there are none."""
        named = [self.same[name] for name in given or ()]
        if named and self._gap(*named) > self.tiny:
            return named
        on_line = [n for n in self._along(node, carrier, direction) if n != node]
        on_line.sort(key=lambda n: (self.places[n] / direction).real)
        if on_line and self._gap(on_line[-1], on_line[0]) > SHORTEST * self.size:
            return [on_line[0], on_line[-1]]
        here, reach = self.places[node], self.reach * direction
        return [self._add(carrier, f"{node}_{end}", here + sign * reach) for end, sign in (("from", -1), ("to", 1))]

    def _along(self, node: str, body: str, direction: complex) -> list[str]:
        """Return the nodes of a body on a line through a node, within the resolution of the file."""
        most = max(self.draft.resolution, PARALLEL * self.size)
        here = self.places[node]
        return [n for n in self.bodies[body] if abs(((self.places[n] - here) / direction).imag) <= most]

    def _second(self, node: str, body: str, direction: complex) -> str:
        """Return another node of a sliding body on the line of sliding; add one where there is none."""
        others = [n for n in self._along(node, body, direction) if self._gap(n, node) > SHORTEST * self.size]
        place = self.places[node] + self.reach * direction
        return others[0] if others else self._add(body, f"{node}_block", place)

    # -- inputs ---------------------------------------------------------------------------------

    def _turn(self, turn: DrawnJoint) -> dict[str, Any]:
        reference, body = (self._carrier(own) for own in turn.bodies)
        if body == GROUND:
            body, reference = reference, GROUND
        self.draft.refuse(body == GROUND, f"input {turn.name}: the link that it turns is fixed to the ground")
        pivot = self.same[turn.at]
        arm = self.same[turn.arm] if turn.arm else self._other(body, pivot, turn.name)
        own: dict[str, Any] = {"type": "rotary", "pivot": pivot, "arm": arm}
        ray = self.places[arm] - self.places[pivot]
        if reference != GROUND:
            own["reference"] = self._other(reference, pivot, turn.name)
            ray /= self.places[own["reference"]] - self.places[pivot]
        return {**own, **_with_range(turn.keys, math.degrees(math.atan2(ray.imag, ray.real)))}

    def _other(self, body: str, pivot: str, name: str) -> str:
        """Return the node of a body farthest from a pivot; a tracer becomes a node where there is none."""
        far = max(self.bodies.get(body) or [pivot], key=lambda n: self._gap(n, pivot))
        if self._gap(far, pivot) > self.tiny:
            return far
        places = ((own, complex(*place)) for own, (owner, place) in self.draft.tracers.items() if owner == body)
        points = [(own, z) for own, z in places if abs(z - self.places[pivot]) > self.tiny]
        self.draft.refuse(not points, f"input {name}: the link that it turns has no second joint")
        return self._add(body, *points[0])

    def _travel(self, name: str, keys: dict[str, Any]) -> dict[str, Any]:
        own = dict(keys)
        if "slot" not in own:
            a, b = (self.same[n] for n in own["nodes"])
            return {**_with_range(own, self._gap(a, b)), "nodes": [a, b]}
        lost = own["slot"] not in self.guides
        self.draft.refuse(lost, f"input {name}: the link that it moves is fixed to the ground")
        node, *guide = self.guides[own.pop("slot")]
        return {"type": "linear", "node": node, "guide": guide, **own}

    # -- the data -------------------------------------------------------------------------------

    def model(self) -> dict[str, Any]:
        """Return the data of the model, its sections in the usual order."""
        draft = self.draft
        inputs = {free_name(t.name, draft.travels): self._turn(t) for t in draft.turns}
        inputs |= {name: self._travel(name, keys) for name, keys in draft.travels.items()}
        self.members = members = {n: own for n, own in self.bodies.items() if n not in self.fixed and len(own) > 1}
        nothing = not members and not self.prismatic
        draft.refuse(nothing, f"no moving links found: this is not a mechanism of {draft.program}")
        slid = (n for p in self.prismatic.values() for n in [*p["guide"], *p.get("nodes", [p.get("node")])])
        driven = (n for own in inputs.values() for n in own.get("nodes", []))
        used = {*self.ground, *(n for own in members.values() for n in own), *slid, *driven}
        mass = {"mass": draft.mass} if draft.masses and draft.mass != "kg" else {}
        points = {name: own for name, point in draft.tracers.items() if (own := self._point(name, *point))}
        traced = dict.fromkeys(self.same.get(name, name) for name in draft.traced)  # those whose paths it draws
        moving = used - {*self.ground} | {*points}
        data: dict[str, Any] = {
            "name": draft.name, "source": f"converted from {draft.program}", "units": {"length": draft.length, **mass},
            "nodes": {n: self._pair(z) for n, z in self.places.items() if n in used},
            "ground": self.ground,
            "links": {n: own for n, own in members.items() if len(own) == 2},
            "elements": {n: own for n, own in members.items() if len(own) > 2},
            "prismatic": self.prismatic, "actuators": inputs, "gears": self._gears([*members, *inputs]),
            "points": points,
            "trace": [name for name in traced if name in moving] or None,
            "duration": draft.duration, "masses": self._masses(),
            "gravity": None if draft.gravity is None else self._pair(draft.gravity),
            "loads": {name: own for name, load in draft.loads.items() if (own := self._load(name, load))},
        }  # fmt: skip
        return {key: value for key, value in data.items() if value not in (None, "", {})}

    def _pair(self, place: Place | complex) -> list[float]:
        """Return a place or a vector as in a model file, with 0 in place of coordinates that are rounding errors."""
        return [0.0 if abs(value) <= ROUNDING * self.size else value for value in coordinates(place)]

    def _gears(self, taken: list[str]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for name, own in self.draft.gears:
            found[free_name(name, [*taken, *self.prismatic, *found])] = {
                **own, "members": [self._carrier(body) for body in own["members"]],
                "pivots": [self.same[pivot] for pivot in own["pivots"]], "carrier": self._carrier(own["carrier"]),
            }  # fmt: skip
        return found

    def _point(self, name: str, body: str, place: Place) -> dict[str, Any] | None:
        owner, free = self._carrier(body), name not in self.places
        if free and owner in (GROUND, *self.members):
            return {"on": owner, "at": self._pair(place)}
        self.draft.note(free, f"point {name} is left out: its link {body} has one joint and may turn")
        return None

    def _masses(self) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for body, own in self.draft.masses:
            owner = self._carrier(body)
            if owner in self.members:
                first = self.places[self.members[owner][0]]
                centre = {"centre": self._pair((own["centre"] - first) / self._ray(owner))} if "centre" in own else {}
                found[owner] = {**own, **centre}
            elif owner != GROUND and own["mass"]:  # a point mass
                for node in self.bodies[owner][:1]:
                    found[node] = {"mass": found.get(node, {"mass": 0.0})["mass"] + own["mass"]}
        return found

    def _load(self, name: str, load: dict[str, Any]) -> dict[str, Any] | None:
        owner = self._carrier(load["on"])
        [key] = load.keys() & {"force", "follower"}
        if owner in self.members:
            turned = self._ray(owner) if key == "follower" else 1.0
            return {"on": owner, "at": self._pair(load["at"]), key: self._pair(load[key] / turned)}
        self.draft.note(owner == GROUND, f"load {name} is left out: it acts on the ground")
        nodes = [] if owner == GROUND else self.bodies[owner]
        return {"on": nodes[0], "force": self._pair(load[key])} if nodes else None

    def _ray(self, member: str) -> complex:
        """Return the direction of the own x axis of a member: from its first node to its second."""
        along = self.places[self.members[member][1]] - self.places[self.members[member][0]]
        return along / (abs(along) or 1.0)


def _with_range(keys: dict[str, Any], drawn: float) -> dict[str, Any]:
    """Return the keys of an input with the range `over` of its law, relative to the drawn value, as absolute values."""
    law = dict(keys.get("law", {}))
    if "over" not in law:
        return keys
    first, last = law.pop("over")
    return {**keys, "law": {"from": drawn + first, "to": drawn + last, **law}}
