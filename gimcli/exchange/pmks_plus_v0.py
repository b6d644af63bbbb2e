"""PMKS+: the addresses of its first versions (2020-2023), with comma-separated lines for joints, links and forces.

`j=` has a line for each joint: id, x, y, links, type R or P, fixed, angle in radians, coefficient of friction (not in
the oldest version), input. `l=`: id, type (not in the oldest version), mass, moment of inertia, centre of mass, joints.
`f=`: id, link, start, end, global, outward, size. `s=`: speed in revolutions per minute, gravity, clockwise, unit.

Source: PMKS+ (2020-2023), its class UrlProcessorService.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from urllib.parse import unquote

from gimcli.errors import ModelError
from gimcli.exchange.draft import Draft, number_of
from gimcli.exchange.pmks_plus import CLOCKWISE, NO_GRAVITY, PlusDraft
from gimcli.exchange.pmks_plus_codec import MOST_RECORDS, PlusDocument, PlusForce, PlusJoint, PlusLink, Record
from gimcli.exchange.refusing import FilePlace

ADDRESS = re.compile(r"https?://", re.IGNORECASE)
JOINTS, LINKS = re.compile(r"[?&]j="), re.compile(r"&l=")
UNITS = {"in": 0, "inch": 0, "cm": 1, "m": 2, "meter": 2, "metre": 2}
"""Units of length, by their number in newer versions."""
EMPTY = ("", "Null")
"""Fields of blocks, which have no mass in the versions of 2021."""
FLAGS = {"t": True, "true": True, "f": False, "false": False}


def recognises(text: str) -> bool:
    """Return whether a text is such an address, be it damaged or not."""
    own = text.strip()
    return bool(ADDRESS.match(own) and (found := JOINTS.search(own)) and LINKS.search(own, found.end()))


def read(text: str, source: str) -> Draft:
    """Return the mechanism of an address; raise ModelError for a damaged one."""
    sections = dict.fromkeys("jlfs", "")
    for part in re.split("[?&]", text.strip())[1:]:
        key, _, value = part.partition("=")
        sections[key] = unquote(value)
    faults: list[str] = []
    joints = _records("j", sections["j"], _joint, source, faults)
    links = _records("l", sections["l"], _link, source, faults)
    forces = _records("f", sections["f"], _force, source, faults)
    if faults:
        raise ModelError(faults)
    _mark_blocks(joints, links)
    speed, gravity, clockwise, unit = (*(field.strip() for field in sections["s"].split(",")), "", "", "", "")[:4]
    rate = number_of(speed or "0")
    FilePlace(source).refuse(math.isnan(rate), f"s=: '{speed[:20]}' is not a speed")
    enums = [UNITS.get(unit.casefold(), 1), 0, 0, 0]
    document = PlusDocument(integers=[rate], enums=enums, joints=joints, links=links, forces=forces)
    document.flags[NO_GRAVITY] = not FLAGS.get(gravity.casefold())
    document.flags[CLOCKWISE] = FLAGS.get(clockwise.casefold(), False)
    draft = PlusDraft(document, source).draft
    if unit.casefold() not in UNITS:
        draft.length = "unit"
        draft.left_out.append("the unit of length is unknown; lengths are without a unit")
    if sections.get("pp", "").strip() or sections.get("tp", "").strip():
        draft.left_out.append("the points of paths are left out")
    return draft


def _records(
    key: str, text: str, record: Callable[[list[str]], Record], source: str, faults: list[str]
) -> list[Record]:  # fmt: skip
    """Return the records of the lines of a section; add the faults of the lines that are none."""
    found: list[Record] = []
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    FilePlace(source).refuse(len(lines) > MOST_RECORDS, f"more than {MOST_RECORDS} lines in {key}=")
    for number, line in enumerate(lines, 1):
        try:
            found.append(record([field.strip() for field in line.split(",")]))
        except (ValueError, LookupError):
            faults.append(f"{source}: {key}= line {number}: '{line[:60]}' is damaged or incomplete")
    return found


def _joint(fields: list[str]) -> PlusJoint:
    own, x, y, _, kind, fixed, angle = fields[:7]
    if kind not in ("R", "P") or not own:
        raise ValueError(kind)
    further = [field for field in fields[7:] if field]
    driven = bool(further) and _flag(further[-1])
    slope = _number(angle) if kind == "P" else 0.0
    return PlusJoint(own, own, _number(x), _number(y), slope, slides=kind == "P", driven=driven, fixed=_flag(fixed))


def _link(fields: list[str]) -> PlusLink:
    own, *rest = fields
    kind = rest.pop(0) if rest[0] in ("R", "P") else "R"
    joints = tuple(name for name in rest[4].split("|") if name)
    if not own or not joints:
        raise ValueError(own)
    mass, inertia, x, y = (_number(text) if text not in EMPTY else 0.0 for text in rest[:4])
    return PlusLink(own, own, mass, inertia, x, y, block=kind == "P", joints=joints)


def _force(fields: list[str]) -> PlusForce:
    x, y, x1, y1 = (_number(text) for text in fields[2:6])
    fixed, outward, size = _flag(fields[6]), _flag(fields[7]), _number(fields[8])
    return PlusForce(fields[0], fields[1], fields[0], x, y, x1, y1, size, not fixed, outward)


def _mark_blocks(joints: list[PlusJoint], links: list[PlusLink]) -> None:
    """Mark the blocks of sliders where the version has no type of links: a slider and a pin at one place."""
    places = {joint.id: joint for joint in joints}
    for link in links:
        ends = [places[name] for name in link.joints if name in places]
        if len(ends) == 2 and ends[0].slides != ends[1].slides:
            link.block = (ends[0].x, ends[0].y) == (ends[1].x, ends[1].y)


def _flag(text: str) -> bool:
    """Return the truth value of a field; raise LookupError if it is none."""
    return FLAGS[text.casefold()]


def _number(text: str) -> float:
    """Return a finite number; raise ValueError if it is none."""
    if math.isnan(value := number_of(text)):
        raise ValueError(text)
    return value
