"""The joints of PMKS, as its text format and its JSON format list them, and the mechanism that they describe.

A joint is a list of links, a type, a position and, for P and RP, the direction of the slot. The slot belongs to the
link that is named first; the second link slides in it, for P without rotation. A point of one link only is a tracer.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable
from typing import NamedTuple

from gimcli.errors import ModelError
from gimcli.exchange.draft import GROUND, MOST_PLACES, STROKE, Draft, DrawnJoint

PROGRAM = "PMKS"
MOST_JOINTS = 500
GROUND_NAMES = ("0", "gnd", "grnd", "grond", "gound", "groud")
NO_SPEED = "the speed of the input is zero in the file; the law is one revolution in 1 s"
TYPES = ("R", "P", "RP", "G")


class PmksSpeed(NamedTuple):
    """Speed of the input: in revolutions per minute for R, in lengths per second for P.

    Source: PMKS writes a speed only if it is not its default (DefaultSpeed of its class DisplayConstants).
    """

    rpm: float = 10.0
    linear: float = 10.0


def sound(read: Iterable[DrawnJoint | str]) -> list[DrawnJoint]:
    """Return the joints that were read; raise ModelError with all faults if there are any."""
    joints = list(read)
    faults = [one for one in joints if isinstance(one, str)]
    if faults:
        raise ModelError(faults)
    return [one for one in joints if isinstance(one, DrawnJoint)]


def draft_of_joints(joints: list[DrawnJoint], source: str, name: str, speed: PmksSpeed, left_out: list[str]) -> Draft:
    """Return the mechanism of a list of joints.

    Raises ModelError for joints that contradict each other, for gears, and for a driver that is a pin in a slot.
    """
    draft = Draft(PROGRAM, source, name=name, left_out=list(left_out))
    joints = _checked(joints, source)
    spelled: dict[str, str] = {}
    for joint in joints:
        for link in joint.links:
            spelled.setdefault(_key(link), link)
    for key, link in spelled.items():
        if key != GROUND:
            spelled[key] = draft.body(link, ())
    spelled[GROUND] = GROUND
    names = [_add(draft, letter(k), joint, [spelled[_key(link)] for link in joint.links])
             for k, joint in enumerate(joints)]  # fmt: skip
    driver = _driver(joints)
    if driver is not None:
        _drive(draft, names[driver], joints[driver], [spelled[_key(link)] for link in joints[driver].links], speed)
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


def _checked(joints: list[DrawnJoint], source: str) -> list[DrawnJoint]:
    """Return the joints; raise ModelError with all of their faults."""
    faults = [fault for joint in joints if (fault := _fault(joint))]
    if len(joints) > MOST_JOINTS:
        faults = [f"{source}: {len(joints)} joints are too many for one mechanism; at most {MOST_JOINTS} are read"]
    elif sum(len(joint.links) for joint in joints) > MOST_PLACES:
        faults = [f"{source}: more than {MOST_PLACES} names of links are too many for one mechanism"]
    elif joints and not any(is_ground(link) for joint in joints for link in joint.links):
        faults.append(f"{source}: no link is the ground; name one link ground")
    if faults:
        raise ModelError(faults)
    return joints


def _fault(joint: DrawnJoint) -> str | None:
    keys = [_key(link) for link in joint.links]
    if not keys:
        return f"{joint.where}: expected the names of links before the type {joint.kind}"
    if len(set(keys)) < len(keys):
        return f"{joint.where}: a link is named twice in one joint"
    if not cmath.isfinite(joint.place) or not math.isfinite(joint.angle):
        return f"{joint.where}: the coordinates are not finite numbers"
    if joint.kind == "G":
        return f"{joint.where}: gear teeth (type G) cannot be converted; write the gears as `gears` of a model file"
    if joint.kind == "P" and len(keys) > 2:
        return f"{joint.where}: a sliding block (type P) joins two links, not {len(keys)}"
    if joint.driver and joint.kind == "RP":
        return f"{joint.where}: the driver is a pin in a slot (type RP), which has two freedoms; drive an R or P joint"
    return None


def _add(draft: Draft, name: str, joint: DrawnJoint, links: list[str]) -> str:
    """Add a joint, its slot and its tracer to the draft; return its name."""
    if len(links) == 1:
        if links[0] != GROUND:
            draft.tracers[name] = (links[0], joint.place)
            draft.traced.append(name)
        return name
    own = draft.joint(name, joint.place)
    if joint.traced:
        draft.traced.append(own)
    fixed = links if joint.kind == "R" else links[1:]
    if joint.kind == "P" and links[1] == GROUND:  # the slot slides over a block of the ground
        links = fixed = [GROUND, links[0]]
        fixed = links[1:]
    for link in fixed:
        if link == GROUND:
            draft.fix(own)
        else:
            draft.bodies[link].append(own)
    if joint.kind != "R":
        draft.slot(f"slide_{own}", own, links[0], direction(joint.angle), body=links[1] if joint.kind == "P" else "")
    return own


def direction(angle: float) -> complex:
    """Return the direction of a slot: PMKS turns it by half a revolution to between -90 and 90 degrees."""
    return cmath.rect(1.0, math.remainder(angle, math.pi))


def _driver(joints: list[DrawnJoint]) -> int | None:
    """Return the number of the driver: the last one marked, else the first R or P joint of two links."""
    marked = [k for k, joint in enumerate(joints) if joint.driver and len(joint.links) > 1]
    free = [k for k, joint in enumerate(joints) if joint.kind in ("R", "P") and len(joint.links) > 1]
    return marked[-1] if marked else free[0] if free else None


def _drive(draft: Draft, name: str, joint: DrawnJoint, links: list[str], speed: PmksSpeed) -> None:
    if joint.kind == "R":
        reference, body = (links[1], links[0]) if links[1] == GROUND else (links[0], links[1])
        backwards = speed.rpm < 0.0
        draft.rotary("motor", name, body, reference, law={"by": -360.0 if backwards else 360.0})
        draft.duration = 60.0 / abs(speed.rpm) if speed.rpm else None
        if speed.rpm == 0.0:
            draft.left_out.append(NO_SPEED)
        return
    travel = STROKE * draft.size()
    backwards = speed.linear < 0.0
    draft.slider("motor", f"slide_{name}", law={"by": -travel if backwards else travel})
    draft.duration = travel / abs(speed.linear) if speed.linear else None
    draft.left_out.append(f"the stroke of the input at joint {name} is not in the file; the law moves it by {travel:g}")
