"""Files of pylinkage (JSON): mechanisms of joints and links, and the older linkages of joints that are solved in turn.

One step of the program counts as one second: it knows no other time. Source: mechanism/serialization.py and
mechanism/link.py of release 1.3, linkage/serialization.py of the older releases.

Older releases have joints that are placed one after another from earlier ones. A `Crank` turns by `angle` in each step,
a `Revolute` joint (once `Pivot`) has two distances, a `Fixed` one a distance and an angle, a `Linear` one (later
`Prismatic`) a distance and a line. The distances count, the coordinates only choose between two places; here the joints
are placed as the program does.
"""

from __future__ import annotations

import cmath
import math
import re

from gimcli.exchange.draft import GROUND, MOST_PLACES, Draft
from gimcli.exchange.json_parts import JsonPart, read_json
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
        found = []
        for key in _KEYS:
            if part.has(key) and not part.at(key).has("inline"):
                ref = part.at(key).at("ref")
                ref.refuse(ref.text() not in self.joints, f"there is no joint '{ref.text()[:40]}'")
                found.append(ref.text())
        return found

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


PROGRAM = "pylinkage"
MOST_PARTS = 500
"""Most joints and most links."""
NEAR = 1e-6
"""Distance of a sliding joint from its line, relative to the size, and error of an angle [rad], that are rounding."""

_MECHANISM = re.compile(r'"type"\s*:\s*"(?:ground|revolute|prismatic|tracker|driver|arc_driver)"')
_JOINTS = re.compile(r'"type"\s*:\s*"(?:Static|Crank|Fixed|Revolute|Pivot|Linear|Prismatic)"')
_GRAPH = re.compile(r'"(?:joint_type)"\s*:\s*"(?:REVOLUTE|PRISMATIC|GROUND|TRACKER)"')


def recognises(text: str) -> bool:
    """Return whether a text is probably a file of pylinkage."""
    if not text.lstrip("\ufeff \t\r\n").startswith("{"):
        return False
    listed = '"joints"' in text and (_MECHANISM.search(text) or _JOINTS.search(text))
    return bool(listed or ('"nodes"' in text and _GRAPH.search(text)))


def read(text: str, source: str) -> Draft:
    """Return the mechanism of a file of pylinkage; `source` names it in messages."""
    data = read_json(text, source)
    name = data.at("name").text()
    draft = Draft(PROGRAM, source, name="" if name.isdigit() else name)
    data.refuse(
        data.has("nodes") and not data.has("joints"),
        "this graph of pylinkage has no dimensions; save the mechanism with mechanism_to_json",
    )
    if _JOINTS.search(text):
        PylinkageJoints(data, draft, MOST_PARTS).convert()
    else:
        _Mechanism(data, draft).convert()
    return draft


class _Mechanism:
    """The conversion of a mechanism of joints and links."""

    def __init__(self, data: JsonPart, draft: Draft) -> None:
        self.data, self.draft = data, draft
        self.joints = _by_id(data.at("joints"), "joint")
        self.links = _by_id(data.at("links"), "link")
        self.names: dict[str, str] = {}
        self.bodies: dict[str, str] = {}
        self.of: dict[str, list[str]] = {}  # joints by link
        self.on: dict[str, list[str]] = {ident: [] for ident in self.joints}  # links by joint
        self.motors = {link.at("motor_joint").text() for link in self.links.values() if link.has("motor_joint")}

    def convert(self) -> None:
        """Fill the draft."""
        for ident, link in self.links.items():
            self.of[ident] = [self._known(joint) for joint in link.at("joints").entries(MOST_PARTS)]
            for joint in self.of[ident]:
                self.on[joint].append(ident)
            link.refuse(
                sum(map(len, self.on.values())) > MOST_PLACES,
                f"more than {MOST_PLACES} joints of links are too many for one mechanism",
            )
        for ident, part in self.joints.items():
            if part.at("type").text("revolute") != "tracker" or self.on[ident]:
                fixed = [GROUND] if self._fixed(ident) else []
                self.names[ident] = self.draft.joint(part.at("name").text(ident), self._place(part), *fixed)
        for ident, link in self.links.items():
            own = [self.names[joint] for joint in self.of[ident]]
            if link.at("type").text("link") == GROUND:
                self.bodies[ident] = GROUND
            elif len(set(own)) > 1:
                self.bodies[ident] = self.draft.body(link.at("name").text(ident), own)
        for ident, part in self.joints.items():
            kind = part.at("type").text("revolute")
            if kind == "prismatic" and not self._fixed(ident):
                self._add_slide(ident, part)
            elif kind == "tracker":
                self._add_tracker(ident, part)
        self._add_inputs()

    # -- joints ---------------------------------------------------------------------------------

    def _known(self, ident: JsonPart) -> str:
        ident.refuse(ident.text() not in self.joints, f"there is no joint '{ident.text()[:40]}'")
        return ident.text()

    def _place(self, joint: JsonPart) -> complex:
        position = joint.at("position")
        position.refuse(
            position.value is None or (isinstance(position.value, list) and None in position.value),
            "the joint has no position; build the mechanism before it is saved",
        )
        return position.place()

    def _fixed(self, ident: str) -> bool:
        """Return whether a joint is fixed: a ground joint, a motor, or a tracker of nothing."""
        joint = self.joints[ident]
        kind = joint.at("type").text("revolute")
        if kind == "tracker":
            return not (joint.at("ref_joint1_id").text() and joint.at("ref_joint2_id").text())
        on_ground = any(self.links[link].at("type").text() == GROUND for link in self.on[ident])
        return kind == GROUND or on_ground or ident in self.motors

    def _add_slide(self, ident: str, joint: JsonPart) -> None:
        axis = joint.at("axis").place() if joint.has("axis") else 1.0 + 0j
        foot = joint.at("line_point").place() if joint.has("line_point") else 0j
        joint.at("axis").refuse(not abs(axis) > 0.0, "the axis has no direction; give two numbers that are not both 0")
        name = self.names[ident]
        across = ((self.draft.joints[name] - foot) / axis * abs(axis)).imag
        joint.refuse(
            abs(across) > NEAR * self.draft.size(),
            f"the joint is {abs(across):g} off its line (axis, line_point); move it there",
        )
        self.draft.slot(f"slot_{name}", name, GROUND, axis)

    def _add_tracker(self, ident: str, joint: JsonPart) -> None:
        """Add a point; one that joins links is a joint of the link that carries it, too."""
        if self._fixed(ident):
            if not self.on[ident]:
                self.draft.point(joint.at("name").text(ident), GROUND, self._place(joint))
            return
        first, second = (self._known(joint.at(key)) for key in ("ref_joint1_id", "ref_joint2_id"))
        carriers = [self.bodies[link] for link in self.on[first] if link in self.on[second] and link in self.bodies]
        if not carriers and self._fixed(first) and self._fixed(second):
            carriers = [GROUND]
        if not carriers:
            text = f"its joints {first} and {second} are on no common link"
            joint.refuse(self.on[ident], f"a tracker cannot carry a link: {text}")
            self.draft.left_out.append(f"tracker {ident} is left out: {text}")
            return
        if ident in self.names:
            self.draft.bodies[carriers[0]].append(self.names[ident])
            return
        origin, along = self._place(self.joints[first]), self._place(self.joints[second])
        turn = cmath.phase(along - origin) + joint.at("angle").number(0.0)
        place = origin + cmath.rect(joint.at("distance").number(0.0), turn)
        self.draft.point(joint.at("name").text(ident), carriers[0], place)

    # -- inputs ---------------------------------------------------------------------------------

    def _add_inputs(self) -> None:
        drivers = [i for i, link in self.links.items() if link.at("type").text() in ("driver", "arc_driver")]
        motion = RepeatedMotion(self.draft)
        for ident in drivers:
            link = self.links[ident]
            link.refuse(
                not link.has("motor_joint"), f"the driver '{ident[:40]}' has no `motor_joint`; name a ground joint"
            )
            motor = self._known(link.at("motor_joint"))
            others = [joint for joint in self.of[ident] if joint != motor]
            link.refuse(
                len(others) != 1 or motor not in self.of[ident],
                f"the driver '{ident[:40]}' needs two joints, its `motor_joint` and one more",
            )
            name = "motor" if len(drivers) == 1 else f"motor_{ident}"
            pivot, arm = self.names[motor], self.names[others[0]]
            law = motion.add(name, self._driver(link, self.draft.joints[arm] - self.draft.joints[pivot]))
            self.draft.rotary(name, pivot, self.bodies.get(ident, ident), arm=arm, law=law)
        motion.complete()

    def _driver(self, link: JsonPart, ray: complex) -> RepeatedInput:
        """Return the input of a driver; its first angle is given, whatever the positions are."""
        speed = math.degrees(link.at("angular_velocity").number(math.tau / 360.0))
        bounded = link.at("type").text() == "arc_driver"
        low, high = link.at("arc_start").number(0.0), link.at("arc_end").number(math.pi)
        first = link.at("initial_angle").number(low if bounded else 0.0)
        ahead = math.remainder(first - cmath.phase(ray), math.tau)
        ahead = math.degrees(ahead) if abs(ahead) > NEAR else 0.0
        if not bounded:
            return RepeatedInput(speed, ahead=ahead)
        link.refuse(
            not low <= first <= high or not low < high,
            "expected arc_start <= initial_angle <= arc_end; correct the angles",
        )
        stroke, passed = math.degrees(high - low), math.degrees(first - low)
        return RepeatedInput(abs(speed), stroke=stroke, passed=passed, back=speed < 0.0, ahead=ahead)


def _by_id(listed: JsonPart, what: str) -> dict[str, JsonPart]:
    """Return the entries of a list by their `id`."""
    found: dict[str, JsonPart] = {}
    for part in listed.entries(MOST_PARTS):
        ident = part.at("id").text()
        part.refuse(
            not isinstance(part.value, dict) or not ident, f"expected a {what} with an `id`, got {part.found()}"
        )
        part.refuse(ident in found, f"the {what} '{ident[:40]}' is given twice")
        found[ident] = part
    return found
