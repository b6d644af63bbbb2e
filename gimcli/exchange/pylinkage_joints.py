"""Linkages of older releases of pylinkage: joints that are solved in turn.

The joints are placed one after another from earlier ones. A `Crank` turns by `angle` in each step,
a `Revolute` joint (once `Pivot`) has two distances, a `Fixed` one a distance and an angle, a `Linear` one (later
`Prismatic`) a distance and a line. The distances count, the coordinates only choose between two places; here the joints
are placed as the program does.
"""

from __future__ import annotations

import cmath
import math

from gimcli.exchange.draft import GROUND, Draft
from gimcli.exchange.json_parts import JsonPart
from gimcli.exchange.repeated import RepeatedInput, RepeatedMotion

SAME = {"Pivot": "Revolute", "Linear": "Prismatic"}
"""Words of older releases."""
_KEYS = ("joint0", "joint1", "joint2")
_NUMBER_OF_DIGITS = 9
"""Digits of a name that is an address in memory."""
_TOUCH = 1e-9
"""Relative gap between two circles that touch, of rounding."""


def _chosen(name: str, other: str) -> str:
    """Return a name that a person has chosen; the program names other joints by long numbers."""
    return other if not name or (name.isdigit() and len(name) >= _NUMBER_OF_DIGITS) else name


class PylinkageJoints:
    """The joints by name; `fixed` are those of the frame."""

    def __init__(self, data: JsonPart, draft: Draft, most: int) -> None:
        self.draft, self.motion = draft, RepeatedMotion(draft)
        self.joints: dict[str, JsonPart] = {}
        for part in data.at("joints").entries(most):
            name = part.at("name").text()
            part.refuse(
                not name or name in self.joints,
                f"the joint has {'the name of another one' if name else 'no `name`'}; correct it",
            )
            self.joints[name] = part
        self.cranks = sum(self._kind(part) == "Crank" for part in self.joints.values())
        self.names: dict[str, str] = {}

    def convert(self) -> None:
        """Place the joints in an order in which each depends on earlier ones only."""
        waiting = {name: self._names_of(part) for name, part in self.joints.items()}
        while waiting:
            ready = [name for name, earlier in waiting.items() if not any(n in waiting for n in earlier)]
            circle = f"the joints {', '.join(waiting)[:80]} depend on each other in a circle"
            self.joints[next(iter(waiting))].refuse(not ready, circle)
            for name in ready:
                del waiting[name]
                self._add(name, self.joints[name])
        self.motion.complete()

    def _kind(self, part: JsonPart) -> str:
        kind = part.at("type").text()
        return SAME.get(kind, kind)

    def _names_of(self, part: JsonPart) -> list[str]:
        """Return the names of the joints that a joint refers to."""
        refs = [part.at(key).at("ref") for key in _KEYS if part.has(key) and not part.at(key).has("inline")]
        for ref in refs:
            ref.refuse(ref.text() not in self.joints, f"there is no joint '{ref.text()[:40]}'")
        return [ref.text() for ref in refs]

    def _parent(self, part: JsonPart, key: str) -> str:
        """Return the draft's name of a joint that is referred to; one that is given inline is fixed."""
        own = part.at(key)
        part.refuse(own.value is None, f"`{key}` is missing; name a joint")
        if not own.has("inline"):
            return self.names[own.at("ref").text()]
        place = complex(own.at("x").number(0.0), own.at("y").number(0.0))
        return self.draft.joint(_chosen(own.at("name").text(), "fixed"), place, GROUND)

    def _add(self, name: str, part: JsonPart) -> None:
        add = {
            "Static": lambda own, part: self.draft.joint(own, self._drawn(part), GROUND),
            "Crank": self._crank, "Fixed": self._rigid, "Revolute": self._revolute, "Prismatic": self._prismatic,
        }.get(self._kind(part))  # fmt: skip
        if add is None:
            raise part.at("type").refused(f"the joint type {part.at('type').found()} is not known")
        self.names[name] = add(_chosen(name, f"joint{len(self.names) + 1}"), part)

    def _drawn(self, part: JsonPart) -> complex:
        return complex(part.at("x").number(0.0), part.at("y").number(0.0))

    # -- one of each type -----------------------------------------------------------------------

    def _crank(self, name: str, part: JsonPart) -> str:
        pivot = self._parent(part, "joint0")
        centre = self.draft.joints[pivot]
        ray = self._drawn(part) - centre
        radius = part.at("distance").number(abs(ray))
        part.refuse(
            not radius > 0.0 or not abs(ray) > 0.0, "the crank has no length; correct `distance`, or its coordinates"
        )
        own = self.draft.joint(name, centre + ray / abs(ray) * radius)
        body = self.draft.body(f"{name}_crank", [pivot, own])
        part.refuse(
            pivot not in self.draft.bodies[GROUND],
            "the crank turns about a moving joint; only cranks on fixed joints are converted",
        )
        motor = "motor" if self.cranks == 1 else f"motor_{name}"
        speed = math.degrees(part.at("angle").number(0.0))
        self.draft.rotary(motor, pivot, body, arm=own, law=self.motion.add(motor, RepeatedInput(speed)))
        return own

    def _rigid(self, name: str, part: JsonPart) -> str:
        first, second = self._parent(part, "joint0"), self._parent(part, "joint1")
        origin, along = self.draft.joints[first], self.draft.joints[second]
        turn = cmath.phase(along - origin) + part.at("angle").number(0.0)
        carriers = self.draft.common(first, second)
        own = self.draft.joint(name, origin + cmath.rect(part.at("distance").number(), turn), *carriers[:1])
        part.refuse(
            not carriers, f"joint '{name[:40]}' is fixed to {first} and {second}, whose distance is not constant"
        )
        return own

    def _revolute(self, name: str, part: JsonPart) -> str:
        first, second = self._parent(part, "joint0"), self._parent(part, "joint1")
        a, b, drawn = self.draft.joints[first], self.draft.joints[second], self._drawn(part)
        ra = part.at("distance0").number(abs(drawn - a))
        rb = part.at("distance1").number(abs(drawn - b))
        gap = abs(b - a)
        along = (ra * ra - rb * rb + gap * gap) / (2.0 * gap) if gap else math.inf
        part.refuse(
            not abs(along) <= ra * (1.0 + _TOUCH),
            f"distances {ra:g} and {rb:g} to {first} and {second}, which are {gap:g} apart, do not meet",
        )
        height = math.sqrt(max(0.0, ra * ra - along * along))
        foot, unit = a + (b - a) / gap * along, 1j * (b - a) / gap
        place = min((foot + height * unit, foot - height * unit), key=lambda z: abs(z - drawn))
        own = self.draft.joint(name, place)
        self.draft.body(f"{name}_{first}", [first, own])
        self.draft.body(f"{name}_{second}", [second, own])
        return own

    def _prismatic(self, name: str, part: JsonPart) -> str:
        centre, first, second = (self._parent(part, key) for key in _KEYS)
        c, a, b, drawn = *(self.draft.joints[n] for n in (centre, first, second)), self._drawn(part)
        part.refuse(not abs(b - a) > 0.0, "the two joints of its line coincide and define no direction; move one")
        unit = (b - a) / abs(b - a)
        radius = part.at("revolute_radius").number(abs(drawn - c))
        local = (c - a) / unit
        part.refuse(
            abs(local.imag) > radius * (1.0 + _TOUCH),
            f"the line is {abs(local.imag):g} from {centre}, more than the distance {radius:g}",
        )
        reach = math.sqrt(max(0.0, radius * radius - local.imag**2))
        place = min((a + unit * (local.real + s * reach) for s in (1.0, -1.0)), key=lambda z: abs(z - drawn))
        own = self.draft.joint(name, place)
        self.draft.body(f"{name}_{centre}", [centre, own])
        carriers = self.draft.common(first, second)
        part.refuse(not carriers, f"its line passes through {first} and {second}, whose distance is not constant")
        self.draft.slot(f"slot_{own}", own, carriers[0], b - a, guide=(first, second))
        return own
