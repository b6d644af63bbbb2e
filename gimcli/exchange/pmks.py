"""PMKS: the joints that its files list, the mechanism that they describe, and its JSON files (`.pmks`, 2019).

A joint is a list of links, a type, a position and, for P and RP, the direction of the slot. The slot belongs to the
link that is named first; the second link slides in it, for P without rotation. A point of one link only is a tracer.

Source: M. I. Campbell, PMKS file format version 1.0 (2019), and the reader of the PMKS library: angles of slots are in
radians, the speed of the input is in revolutions per minute or lengths per second.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from typing import Any

from gimcli.exchange.draft import GROUND, STROKE, Draft, DrawnJoint, coordinates
from gimcli.exchange.records import FilePart, FileRecord, all_of, number_of, read as read_part, read_json

PROGRAM = "PMKS"
GROUND_NAMES = ("0", "gnd", "grnd", "grond", "gound", "groud")
NO_SPEED = "the speed of the input is zero in the file; the law is one revolution in 1 s"
TYPES = ("R", "P", "RP", "G")
JOINT = {"X": float, "Y": float, "Angle": (object,), "TypeOfJoint": str, "Links": [str], "PositionVisible": False}
FILE = {"Joints": [JOINT], "Name": "", "DrivingIndex": (int,), "InputSpeed": (float,), "TargetShape": (object,)}


DEFAULT_SPEED = 10.0
"""Speed of the input, revolutions per minute for R and lengths per second for P, where the file has none.

Source: PMKS writes a speed only if it is not its default (DefaultSpeed of its class DisplayConstants).
"""


def drawn_joint(
    kind: str, links: list[str], x: float, y: float, angle: float, own: FilePart, **more: Any
) -> DrawnJoint:
    """Return a joint; `angle` [rad] is that of its slot, nan if it has none.

    PMKS turns slots by half a revolution to between -90 and 90 degrees.
    """
    along = cmath.rect(1.0, 0.0 if math.isnan(angle) else math.remainder(angle, math.pi))
    return DrawnJoint(kind, tuple(links), (x, y), coordinates(along), own=own, **more)


def draft_of_joints(
    joints: list[DrawnJoint], source: str, name: str, speed: float, driver: int | None, shape: object
) -> Draft:  # fmt: skip
    """Return the mechanism of a list of joints.

    `speed` is nan if the file has none, `driver` the number of the joint that is the input, if the file names it apart
    from the joints, `shape` the target of its path, if it has one. Raises ModelError with all faults of joints: those
    that contradict each other, gears, and a driver that is a pin in a slot.
    """
    draft = Draft(PROGRAM, source, name=name)
    draft.note(shape, "the target shape is left out")
    if driver in range(len(joints)):
        joints = [replace(joint, driver=0 if k == driver else None) for k, joint in enumerate(joints)]
    all_of(_check, joints)
    grounded = not joints or any(is_ground(link) for joint in joints for link in joint.bodies)
    draft.refuse(not grounded, "no link is the ground; name one link ground")
    joints = draft.linked(joints, _key)
    names = [_add(draft, letter(k), joint) for k, joint in enumerate(joints)]
    marked = [k for k, joint in enumerate(joints) if joint.driver is not None and len(joint.bodies) > 1]
    free = [k for k, joint in enumerate(joints) if joint.kind in ("R", "P") and len(joint.bodies) > 1]
    for number in [*free[:1], *marked][-1:]:
        _drive(draft, names[number], joints[number], DEFAULT_SPEED if math.isnan(speed) else speed)
    return draft


def letter(number: int) -> str:
    """Return the name of a joint from its number: A to Z, then AA, AB and so on."""
    text = ""
    number += 1
    while number:
        number, digit = divmod(number - 1, 26)
        text = chr(ord("A") + digit) + text
    return text


def is_ground(link: str) -> bool:
    """Return whether the name of a link means the ground."""
    plain = link.casefold()
    return plain in GROUND_NAMES or plain.startswith(GROUND)


def _key(link: str) -> str:
    return GROUND if is_ground(link) else link.casefold()


def _check(joint: DrawnJoint) -> None:
    """Raise ModelError if something is wrong with a joint."""
    keys = [_key(link) for link in joint.bodies]
    joint.own.check({
        f"expected the names of links before the type {joint.kind}": not keys,
        "a link is named twice in one joint": len(set(keys)) < len(keys),
        "the coordinates are not finite numbers": not all(map(math.isfinite, joint.place)),
        "gear teeth (type G) cannot be converted; write the gears as `gears` of a model file": joint.kind == "G",
        f"a sliding block (type P) joins two links, not {len(keys)}": joint.kind == "P" and len(keys) > 2,
        "the driver is a pin in a slot (type RP), which has two freedoms; drive an R or P joint":
            joint.driver is not None and joint.kind == "RP",
    })  # fmt: skip


def _add(draft: Draft, name: str, joint: DrawnJoint) -> str:
    """Add a joint, its slot and its tracer to the draft; return its name."""
    if len(joint.bodies) > 1:
        name = draft.listed(name, joint, "slide")
    elif joint.bodies[0] != GROUND:
        draft.point(name, joint.bodies[0], joint.place)
    if joint.traced or name in draft.tracers:
        draft.traced.append(name)
    return name


def _drive(draft: Draft, name: str, joint: DrawnJoint, speed: float) -> None:
    sense = -1.0 if speed < 0.0 else 1.0
    if joint.kind == "R":
        reference, body = joint.bodies[1::-1] if joint.bodies[1] == GROUND else joint.bodies[:2]
        draft.rotary("motor", name, body, reference, law={"by": 360.0 * sense})
        draft.duration = 60.0 / abs(speed) if speed else None
        draft.note(not speed, NO_SPEED)
        return
    travel = STROKE * draft.size()
    draft.travel("motor", slot=f"slide_{name}", law={"by": travel * sense})
    draft.duration = travel / abs(speed) if speed else None
    draft.note(True, f"the stroke of the input at joint {name} is not in the file; the law moves it by {travel:g}")


# -- JSON files -----------------------------------------------------------------------------------


def recognises(text: str) -> bool:
    """Return whether a text is probably such a file, be it damaged or not."""
    return text.lstrip().startswith("{") and ('"TypeOfJoint"' in text or '"Joints"' in text)


def read(text: str, source: str) -> Draft:
    """Return the mechanism of a JSON file; raise ModelError with all errors."""
    own = read_part(FILE, read_json(text, source))
    joints = all_of(_joint, own.Joints)
    return draft_of_joints(joints, source, own.Name, number_of(str(own.InputSpeed)), own.DrivingIndex, own.TargetShape)


def _joint(own: FileRecord) -> DrawnJoint:
    kind, angle = own.TypeOfJoint.upper(), number_of(str(own.Angle))  # joints without a slot have NaN
    own.at("TypeOfJoint").refuse(kind not in TYPES, f"expected R, P or RP, got '{kind[:40]}'")
    return drawn_joint(kind, own.Links, own.X, own.Y, angle, own.own, traced=own.PositionVisible)
