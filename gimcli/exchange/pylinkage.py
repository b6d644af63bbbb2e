"""Files of pylinkage (JSON): mechanisms of joints and links, and the older linkages of joints that are solved in turn.

One step of the program counts as one second: it knows no other time. Source: mechanism/serialization.py and
mechanism/link.py of release 1.3, linkage/serialization.py of the older releases.
"""

from __future__ import annotations

import cmath
import math
import re

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
    """The conversion of a mechanism of joints and links.

    It sets for joints their links (`links`), whether they are fixed, whether they are trackers of other joints
    (`carried`), and their names in the draft (`named`, "" for none), for links the names of their bodies (`body`, ""
    for none).
    """

    def __init__(self, file: FileRecord, draft: Draft) -> None:
        self.draft, self.joints = draft, by_key("id", file.joints, "joint")
        self.links = list(by_key("id", file.links, "link").values())
        for link in self.links:
            link.joints = [self._known(joint, link) for joint in link.joints]
        motors = [link.motor_joint for link in self.links]
        for joint in file.joints:
            joint.links, joint.named = [link for link in self.links if joint in link.joints], ""
            grounded = joint.type == GROUND or any(link.type == GROUND for link in joint.links) or joint.id in motors
            joint.carried = joint.type == "tracker" and bool(joint.ref_joint1_id and joint.ref_joint2_id)
            joint.fixed = not joint.carried if joint.type == "tracker" else grounded

    def convert(self) -> None:
        """Fill the draft."""
        for joint in self.joints.values():
            if joint.type != "tracker" or joint.links:
                fixed = [GROUND] * joint.fixed
                joint.named = self.draft.joint(joint.name or joint.id, self._place(joint), *fixed)
        for link in self.links:
            own = [joint.named for joint in link.joints]
            rigid = GROUND if link.type == GROUND else ""
            link.body = rigid or (self.draft.body(link.name or link.id, own) if len(set(own)) > 1 else "")
        for joint in self.joints.values():
            if joint.type == "prismatic" and not joint.fixed:
                self._add_slide(joint)
            elif joint.carried:
                self._add_tracker(joint)
            elif not joint.named:
                self.draft.point(joint.name or joint.id, GROUND, self._place(joint))
        self._add_inputs()

    # -- joints ---------------------------------------------------------------------------------

    def _known(self, ident: str, by: FileRecord) -> FileRecord:
        by.refuse(ident not in self.joints, f"there is no joint '{ident[:40]}'")
        return self.joints[ident]

    def _place(self, joint: FileRecord) -> complex:
        cure = "the joint has no position; build the mechanism before it is saved"
        joint.at("position").refuse(len(joint.position or ()) != 2 or None in joint.position, cure)
        return complex(*joint.position)

    def _add_slide(self, joint: FileRecord) -> None:
        name, axis = joint.named, joint.axis
        joint.at("axis").refuse(not abs(axis) > 0.0, "the axis has no direction; give two numbers that are not both 0")
        across = abs(((self.draft.z(name) - joint.line_point) / axis * abs(axis)).imag)
        off = f"the joint is {across:g} off its line (axis, line_point); move it there"
        joint.refuse(across > NEAR * self.draft.size(), off)
        self.draft.slot(f"slot_{name}", name, GROUND, axis)

    def _add_tracker(self, joint: FileRecord) -> None:
        """Add a point; one that joins links is a joint of the link that carries it, too."""
        first, second = (self._known(own, joint) for own in (joint.ref_joint1_id, joint.ref_joint2_id))
        carriers = self.draft.common(first.named, second.named)
        text = f"its joints {first.id} and {second.id} are on no common link"
        joint.refuse(joint.links and not carriers, f"a tracker cannot carry a link: {text}")
        self.draft.note(not carriers, f"tracker {joint.id} is left out: {text}")
        origin, along = self._place(first), self._place(second)
        place = origin + cmath.rect(joint.distance, cmath.phase(along - origin) + joint.angle)
        for carrier in carriers[:1]:
            if joint.named:
                self.draft.bodies[carrier].append(joint.named)
            else:
                self.draft.point(joint.name or joint.id, carrier, place)

    # -- inputs ---------------------------------------------------------------------------------

    def _add_inputs(self) -> None:
        drivers = [link for link in self.links if link.type in ("driver", "arc_driver")]
        motion = RepeatedMotion(self.draft)
        for link in drivers:
            what = f"the driver '{link.id[:40]}'"
            ends = sorted((joint.id != link.motor_joint, joint.named) for joint in link.joints)
            link.check({
                f"{what} has no `motor_joint`; name a ground joint": not link.motor_joint,
                f"{what} needs two joints, its `motor_joint` and one more": [end for end, _ in ends] != [False, True],
            })  # fmt: skip
            (_, pivot), (_, arm) = ends
            own = _driver(link, self.draft.z(arm) - self.draft.z(pivot))
            motion.rotary(link.id, len(drivers) == 1, pivot, link.body, own, arm)
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
