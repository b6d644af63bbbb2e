"""Files of pylinkage (JSON): mechanisms of joints and links, and the older linkages of joints that are solved in turn.

One step of the program counts as one second: it knows no other time. Source: mechanism/serialization.py and
mechanism/link.py of release 1.3, linkage/serialization.py of the older releases.
"""

from __future__ import annotations

import cmath
import math
import re

from gimcli.exchange.draft import GROUND, MOST_PLACES, Draft
from gimcli.exchange.json_parts import JsonPart, read_json
from gimcli.exchange.pylinkage_joints import PylinkageJoints
from gimcli.exchange.repeated import RepeatedInput, RepeatedMotion

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
        placed = {i: p for i, p in self.joints.items() if p.at("type").text("revolute") != "tracker" or self.on[i]}
        fixed = {ident: [GROUND] if self._fixed(ident) else [] for ident in placed}
        self.names = {
            ident: self.draft.joint(part.at("name").text(ident), self._place(part), *fixed[ident])
            for ident, part in placed.items()
        }
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
        held = [GROUND] if self._fixed(first) and self._fixed(second) else []
        links = [link for link in self.on[first] if link in self.on[second]]
        carriers = [self.bodies[link] for link in links if link in self.bodies] or held
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
