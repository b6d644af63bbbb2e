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
    """The joints by name; `names` are those in the draft."""

    def __init__(self, file: FileRecord, draft: Draft) -> None:
        self.draft, self.motion = draft, RepeatedMotion(draft)
        self.joints = by_key("name", file.joints, "joint")
        self.cranks = sum(joint.type == "Crank" for joint in file.joints)
        self.names: dict[str, str] = {}

    def convert(self) -> None:
        """Place the joints in an order in which each depends on earlier ones only."""
        waiting = {name: self._names_of(joint) for name, joint in self.joints.items()}
        while waiting:
            ready = [name for name, earlier in waiting.items() if not any(n in waiting for n in earlier)]
            circle = f"the joints {', '.join(waiting)[:80]} depend on each other in a circle"
            self.joints[next(iter(waiting))].refuse(not ready, circle)
            for name in ready:
                del waiting[name]
                self._add(name, self.joints[name])
        self.motion.complete()

    def _names_of(self, joint: FileRecord) -> list[str]:
        """Return the names of the joints that a joint refers to."""
        given = [own for key in _KEYS if (own := getattr(joint, key)) and own.inline is None]
        for own in given:
            own.at("ref").refuse(own.ref not in self.joints, f"there is no joint '{own.ref[:40]}'")
        return [own.ref for own in given]

    def _parents(self, joint: FileRecord, count: int) -> list[str]:
        """Return the draft's names of joints that are referred to; one that is given inline is fixed."""
        found = []
        for key in _KEYS[:count]:
            own = getattr(joint, key)
            joint.refuse(own is None, f"`{key}` is missing; name a joint")
            inline = own.inline is not None
            fixed = (_chosen(own.name, "fixed"), complex(own.x, own.y), GROUND)
            found.append(self.draft.joint(*fixed) if inline else self.names[own.ref])
        return found

    def _add(self, name: str, joint: FileRecord) -> None:
        add = {
            "Static": lambda own, joint: self.draft.joint(own, complex(joint.x, joint.y), GROUND),
            "Crank": self._crank, "Fixed": self._rigid, "Revolute": self._revolute, "Prismatic": self._prismatic,
        }.get(SAME.get(joint.type, joint.type))  # fmt: skip
        if add is None:
            raise joint.at("type").refused(f"the joint type '{joint.type[:40]}' is not known")
        self.names[name] = add(_chosen(name, f"joint{len(self.names) + 1}"), joint)

    # -- one of each type -----------------------------------------------------------------------

    def _crank(self, name: str, joint: FileRecord) -> str:
        [pivot] = self._parents(joint, 1)
        centre = self.draft.joints[pivot]
        ray = complex(joint.x, joint.y) - centre
        radius = abs(ray) if joint.distance is None else joint.distance
        joint.refuse(
            not radius > 0.0 or not abs(ray) > 0.0, "the crank has no length; correct `distance`, or its coordinates"
        )
        joint.refuse(
            pivot not in self.draft.bodies[GROUND],
            "the crank turns about a moving joint; only cranks on fixed joints are converted",
        )
        own = self.draft.joint(name, centre + ray / abs(ray) * radius)
        body = self.draft.body(f"{name}_crank", [pivot, own])
        motor = "motor" if self.cranks == 1 else f"motor_{name}"
        law = self.motion.add(motor, RepeatedInput(math.degrees(joint.angle)))
        self.draft.rotary(motor, pivot, body, arm=own, law=law)
        return own

    def _rigid(self, name: str, joint: FileRecord) -> str:
        first, second = self._parents(joint, 2)
        carriers = self.draft.common(first, second)
        joint.refuse(joint.distance is None, "`distance` is missing; give a number")
        joint.refuse(
            not carriers, f"joint '{name[:40]}' is fixed to {first} and {second}, whose distance is not constant"
        )
        origin, along = self.draft.joints[first], self.draft.joints[second]
        place = origin + cmath.rect(joint.distance, cmath.phase(along - origin) + joint.angle)
        return self.draft.joint(name, place, carriers[0])

    def _revolute(self, name: str, joint: FileRecord) -> str:
        first, second = self._parents(joint, 2)
        a, b, drawn = self.draft.joints[first], self.draft.joints[second], complex(joint.x, joint.y)
        ra = abs(drawn - a) if joint.distance0 is None else joint.distance0
        rb = abs(drawn - b) if joint.distance1 is None else joint.distance1
        gap = abs(b - a)
        along = (ra * ra - rb * rb + gap * gap) / (2.0 * gap) if gap else math.inf
        joint.refuse(
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

    def _prismatic(self, name: str, joint: FileRecord) -> str:
        centre, first, second = self._parents(joint, 3)
        c, a, b, drawn = *(self.draft.joints[n] for n in (centre, first, second)), complex(joint.x, joint.y)
        joint.refuse(not abs(b - a) > 0.0, "the two joints of its line coincide and define no direction; move one")
        carriers = self.draft.common(first, second)
        joint.refuse(not carriers, f"its line passes through {first} and {second}, whose distance is not constant")
        unit = (b - a) / abs(b - a)
        radius = abs(drawn - c) if joint.revolute_radius is None else joint.revolute_radius
        local = (c - a) / unit
        joint.refuse(
            abs(local.imag) > radius * (1.0 + _TOUCH),
            f"the line is {abs(local.imag):g} from {centre}, more than the distance {radius:g}",
        )
        reach = math.sqrt(max(0.0, radius * radius - local.imag**2))
        place = min((a + unit * (local.real + s * reach) for s in (1.0, -1.0)), key=lambda z: abs(z - drawn))
        own = self.draft.joint(name, place)
        self.draft.body(f"{name}_{centre}", [centre, own])
        self.draft.slot(f"slot_{own}", own, carriers[0], b - a, guide=(first, second))
        return own
