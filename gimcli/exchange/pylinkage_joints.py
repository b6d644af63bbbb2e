"""Linkages of older releases of pylinkage: joints that are solved in turn.

The joints are placed one after another from earlier ones. A `Crank` turns by `angle` in each step,
a `Revolute` joint (once `Pivot`) has two distances, a `Fixed` one a distance and an angle, a `Linear` one (later
`Prismatic`) a distance and a line. The distances count, the coordinates only choose between two places; here the joints
are placed as the program does.
"""

from __future__ import annotations

import cmath
import math

from gimcli.exchange.draft import GROUND, Draft, free_name
from gimcli.exchange.records import FileRecord, by_key
from gimcli.exchange.repeated import RepeatedInput, RepeatedMotion

_REFERENCE = {"ref": "", "inline": (object,), "name": "", "x": 0.0, "y": 0.0}
"""Another joint, or the place of a fixed one (`inline`)."""
_KEYS = ("joint0", "joint1", "joint2")
JOINT = {
    "name": str, "type": "", "x": 0.0, "y": 0.0, **dict.fromkeys(_KEYS, (_REFERENCE,)), "distance": (float,),
    "distance0": (float,), "distance1": (float,), "angle": 0.0, "revolute_radius": (float,),
}  # fmt: skip
LINKAGE = {"joints": [JOINT]}

SAME = {"Pivot": "Revolute", "Linear": "Prismatic"}
"""Words of older releases."""
_NUMBER_OF_DIGITS = 9
"""Digits of a name that is an address in memory."""
_TOUCH = 1e-9
"""Relative gap between two circles that touch, of rounding."""


def _chosen(name: str, other: str) -> str:
    """Return a name that a person has chosen; the program names other joints by long numbers."""
    return other if not name or (name.isdigit() and len(name) >= _NUMBER_OF_DIGITS) else name


class PylinkageJoints:
    """The joints by name; `named` are their names in the draft."""

    def __init__(self, file: FileRecord, draft: Draft) -> None:
        self.draft, self.motion = draft, RepeatedMotion(draft)
        self.joints = by_key("name", file.joints, "joint")
        self.cranks = sum(joint.type == "Crank" for joint in file.joints)

    def convert(self) -> None:
        """Place the joints in an order in which each depends on earlier ones only."""
        waiting = {name: self._names_of(joint) for name, joint in self.joints.items()}
        while waiting:
            ready = [name for name, earlier in waiting.items() if not any(n in waiting for n in earlier)]
            circle = f"the joints {', '.join(waiting)[:80]} depend on each other in a circle"
            self.joints[next(iter(waiting))].refuse(not ready, circle)
            for name in ready:
                del waiting[name]
                self._add(self.joints[name], len(self.joints) - len(waiting))
        self.motion.complete()

    def _names_of(self, joint: FileRecord) -> list[str]:
        """Return the names of the joints that a joint refers to."""
        given = [own for key in _KEYS if (own := getattr(joint, key)) and own.inline is None]
        for own in given:
            own.at("ref").refuse(own.ref not in self.joints, f"there is no joint '{own.ref[:40]}'")
        return [own.ref for own in given]

    def _parent(self, joint: FileRecord, key: str) -> str:
        """Return the draft's name of a joint that is referred to; one that is given inline is fixed."""
        own = getattr(joint, key)
        joint.refuse(own is None, f"`{key}` is missing; name a joint")
        if own.inline is None:
            return str(self.joints[own.ref].named)
        return self.draft.joint(_chosen(own.name, "fixed"), complex(own.x, own.y), GROUND)

    def _add(self, joint: FileRecord, number: int) -> None:
        """Add a joint, the links that join it to its parents, and its slot or input."""
        kinds = {"Static": (0, self._static), "Crank": (1, self._crank), "Fixed": (2, self._rigid),
                 "Revolute": (2, self._revolute), "Prismatic": (3, self._prismatic)}  # fmt: skip
        kind = SAME.get(joint.type, joint.type)
        joint.at("type").refuse(kind not in kinds, f"the joint type '{joint.type[:40]}' is not known")
        count, place = kinds[kind]
        parents = [self._parent(joint, key) for key in _KEYS[:count]]
        joint.named = free_name(_chosen(joint.name, f"joint{number}"), self.draft.joints)
        joint.drawn = complex(joint.x, joint.y)
        place(joint, parents, [self.draft.z(parent) for parent in parents])

    # -- one of each type -----------------------------------------------------------------------

    def _static(self, joint: FileRecord, names: list[str], places: list[complex]) -> None:
        self.draft.joint(joint.named, joint.drawn, GROUND)

    def _crank(self, joint: FileRecord, names: list[str], places: list[complex]) -> None:
        [pivot], [centre], name = names, places, joint.named
        ray = joint.drawn - centre
        radius = abs(ray) if joint.distance is None else joint.distance
        joint.refuse(not (radius > 0.0 and ray), "the crank has no length; correct `distance`, or its coordinates")
        turns = "the crank turns about a moving joint; only cranks on fixed joints are converted"
        joint.refuse(pivot not in self.draft.bodies[GROUND], turns)
        self.draft.joint(name, centre + ray / abs(ray) * radius)
        body, turning = self.draft.body(f"{name}_crank", [pivot, name]), RepeatedInput(math.degrees(joint.angle))
        self.motion.rotary(name, self.cranks == 1, pivot, body, turning, arm=name)

    def _rigid(self, joint: FileRecord, names: list[str], places: list[complex]) -> None:
        (first, second), (origin, along) = names, places
        carriers = self.draft.common(first, second)
        fault = f"joint '{joint.name[:40]}' is fixed to {first} and {second}, whose distance is not constant"
        joint.check({"`distance` is missing; give a number": joint.distance is None, fault: not carriers})
        place = origin + cmath.rect(joint.distance, cmath.phase(along - origin) + joint.angle)
        self.draft.joint(joint.named, place, carriers[0])

    def _revolute(self, joint: FileRecord, names: list[str], places: list[complex]) -> None:
        (first, second), (a, b), drawn = names, places, joint.drawn
        ra = abs(drawn - a) if joint.distance0 is None else joint.distance0
        rb = abs(drawn - b) if joint.distance1 is None else joint.distance1
        gap = abs(b - a)
        along = (ra * ra - rb * rb + gap * gap) / (2.0 * gap) if gap else math.inf
        apart = f"distances {ra:g} and {rb:g} to {first} and {second}, which are {gap:g} apart, do not meet"
        joint.refuse(not abs(along) <= ra * (1.0 + _TOUCH), apart)
        height = math.sqrt(max(0.0, ra * ra - along * along))
        foot, unit = a + (b - a) / gap * along, 1j * (b - a) / gap
        self.draft.joint(joint.named, min((foot + height * unit, foot - height * unit), key=lambda z: abs(z - drawn)))
        for parent in names:
            self.draft.body(f"{joint.named}_{parent}", [parent, joint.named])

    def _prismatic(self, joint: FileRecord, names: list[str], places: list[complex]) -> None:
        (centre, first, second), (c, a, b), name = names, places, joint.named
        carriers = self.draft.common(first, second)
        joint.check({
            "the two joints of its line coincide and define no direction; move one": not abs(b - a) > 0.0,
            f"its line passes through {first} and {second}, whose distance is not constant": not carriers,
        })  # fmt: skip
        unit = (b - a) / abs(b - a)
        radius = abs(joint.drawn - c) if joint.revolute_radius is None else joint.revolute_radius
        local = (c - a) / unit
        far = f"the line is {abs(local.imag):g} from {centre}, more than the distance {radius:g}"
        joint.refuse(abs(local.imag) > radius * (1.0 + _TOUCH), far)
        reach = math.sqrt(max(0.0, radius * radius - local.imag**2))
        ends = (a + unit * (local.real + sign * reach) for sign in (1.0, -1.0))
        self.draft.joint(name, min(ends, key=lambda z: abs(z - joint.drawn)))
        self.draft.body(f"{name}_{centre}", [centre, name])
        self.draft.slot(f"slot_{name}", name, carriers[0], unit, guide=(first, second))
