"""Files of pylinkage (JSON): mechanisms of joints and links, and the older linkages of joints that are solved in turn.

One step of the program counts as one second: it knows no other time. Source: mechanism/serialization.py and
mechanism/link.py of release 1.3, linkage/serialization.py of the older releases.
"""

from __future__ import annotations

import cmath
import math
import re
from collections import defaultdict

from gimcli.exchange.draft import GROUND, Draft
from gimcli.exchange.pylinkage_joints import LINKAGE, PylinkageJoints
from gimcli.exchange.records import FileRecord, by_key, read as read_part, read_json
from gimcli.exchange.repeated import RepeatedInput, RepeatedMotion

PROGRAM = "pylinkage"
NEAR = 1e-6
"""Distance of a sliding joint from its line, relative to the size, and error of an angle [rad], that are rounding."""

JOINT = {
    "id": str, "type": "revolute", "name": "", "position": ([(float,)],), "axis": 1.0 + 0j, "line_point": 0j,
    "ref_joint1_id": "", "ref_joint2_id": "", "distance": 0.0, "angle": 0.0,
}  # fmt: skip
LINK = {
    "id": str, "type": "", "name": "", "joints": [str], "motor_joint": "", "angular_velocity": math.tau / 360.0,
    "arc_start": 0.0, "arc_end": math.pi, "initial_angle": (float,),
}  # fmt: skip
HEAD = {"name": "", "nodes": (object,), "joints": (object,)}
MECHANISM = {"joints": [JOINT], "links": [LINK]}

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
    part = read_json(text, source)
    head = read_part(HEAD, part)
    draft = Draft(PROGRAM, source, name="" if head.name.isdigit() else head.name)
    head.refuse(
        head.nodes is not None and head.joints is None,
        "this graph of pylinkage has no dimensions; save the mechanism with mechanism_to_json",
    )
    if _JOINTS.search(text):
        PylinkageJoints(read_part(LINKAGE, part), draft).convert()
    else:
        _Mechanism(read_part(MECHANISM, part), draft).convert()
    return draft


class _Mechanism:
    """The conversion of a mechanism of joints and links; `on` has the links of each joint."""

    def __init__(self, file: FileRecord, draft: Draft) -> None:
        self.draft = draft
        self.joints, self.links = by_key("id", file.joints, "joint"), by_key("id", file.links, "link")
        self.bodies: dict[str, str] = {}
        self.on: dict[str, list[FileRecord]] = defaultdict(list)
        for link in file.links:
            for joint in link.joints:
                self.on[self._known(joint, link)].append(link)
        self.fixed = {ident for ident, joint in self.joints.items() if self._fixed(joint)}

    def convert(self) -> None:
        """Fill the draft."""
        placed = {ident: joint for ident, joint in self.joints.items() if joint.type != "tracker" or self.on[ident]}
        self.names = {
            ident: self.draft.joint(joint.name or ident, self._place(joint), *[GROUND] * (ident in self.fixed))
            for ident, joint in placed.items()
        }
        for ident, link in self.links.items():
            own = [self.names[joint] for joint in link.joints]
            if link.type == GROUND:
                self.bodies[ident] = GROUND
            elif len(set(own)) > 1:
                self.bodies[ident] = self.draft.body(link.name or ident, own)
        for ident, joint in self.joints.items():
            if joint.type == "prismatic" and ident not in self.fixed:
                self._add_slide(joint)
            elif joint.type == "tracker":
                self._add_tracker(joint)
        self._add_inputs()

    # -- joints ---------------------------------------------------------------------------------

    def _known(self, ident: str, by: FileRecord) -> str:
        by.refuse(ident not in self.joints, f"there is no joint '{ident[:40]}'")
        return ident

    def _place(self, joint: FileRecord) -> complex:
        cure = "the joint has no position; build the mechanism before it is saved"
        joint.at("position").refuse(len(joint.position or ()) != 2 or None in joint.position, cure)
        return complex(*joint.position)

    def _fixed(self, joint: FileRecord) -> bool:
        """Return whether a joint is fixed: a ground joint, a motor, or a tracker of nothing."""
        if joint.type == "tracker":
            return not (joint.ref_joint1_id and joint.ref_joint2_id)
        motors = [link.motor_joint for link in self.links.values()]
        return joint.type == GROUND or any(link.type == GROUND for link in self.on[joint.id]) or joint.id in motors

    def _add_slide(self, joint: FileRecord) -> None:
        name, axis = self.names[joint.id], joint.axis
        joint.at("axis").refuse(not abs(axis) > 0.0, "the axis has no direction; give two numbers that are not both 0")
        across = abs(((self.draft.joints[name] - joint.line_point) / axis * abs(axis)).imag)
        joint.refuse(
            across > NEAR * self.draft.size(),
            f"the joint is {across:g} off its line (axis, line_point); move it there",
        )
        self.draft.slot(f"slot_{name}", name, GROUND, axis)

    def _add_tracker(self, joint: FileRecord) -> None:
        """Add a point; one that joins links is a joint of the link that carries it, too."""
        ident, named = joint.id, joint.name or joint.id
        if ident in self.fixed:
            if not self.on[ident]:
                self.draft.point(named, GROUND, self._place(joint))
            return
        first, second = (self._known(own, joint) for own in (joint.ref_joint1_id, joint.ref_joint2_id))
        links = [link.id for link in self.on[first] if link in self.on[second]]
        carriers = [self.bodies[link] for link in links if link in self.bodies]
        carriers += [GROUND] * (not carriers and {first, second} <= self.fixed)
        if not carriers:
            text = f"its joints {first} and {second} are on no common link"
            joint.refuse(self.on[ident], f"a tracker cannot carry a link: {text}")
            self.draft.left_out.append(f"tracker {ident} is left out: {text}")
        elif ident in self.names:
            self.draft.bodies[carriers[0]].append(self.names[ident])
        else:
            origin, along = self._place(self.joints[first]), self._place(self.joints[second])
            place = origin + cmath.rect(joint.distance, cmath.phase(along - origin) + joint.angle)
            self.draft.point(named, carriers[0], place)

    # -- inputs ---------------------------------------------------------------------------------

    def _add_inputs(self) -> None:
        drivers = [link for link in self.links.values() if link.type in ("driver", "arc_driver")]
        motion = RepeatedMotion(self.draft)
        for link in drivers:
            what = f"the driver '{link.id[:40]}'"
            link.refuse(not link.motor_joint, f"{what} has no `motor_joint`; name a ground joint")
            motor = self._known(link.motor_joint, link)
            others = [joint for joint in link.joints if joint != motor]
            link.refuse(
                len(others) != 1 or motor not in link.joints,
                f"{what} needs two joints, its `motor_joint` and one more",
            )
            name = "motor" if len(drivers) == 1 else f"motor_{link.id}"
            pivot, arm = self.names[motor], self.names[others[0]]
            law = motion.add(name, _driver(link, self.draft.joints[arm] - self.draft.joints[pivot]))
            self.draft.rotary(name, pivot, self.bodies.get(link.id, link.id), arm=arm, law=law)
        motion.complete()


def _driver(link: FileRecord, ray: complex) -> RepeatedInput:
    """Return the input of a driver; its first angle is given, whatever the positions are."""
    speed, bounded = math.degrees(link.angular_velocity), link.type == "arc_driver"
    low, high = link.arc_start, link.arc_end
    first = link.initial_angle if link.initial_angle is not None else low if bounded else 0.0
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
