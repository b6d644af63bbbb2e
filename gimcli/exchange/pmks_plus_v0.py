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
from gimcli.exchange.draft import Draft
from gimcli.exchange.pmks_plus import CLOCKWISE, NO_GRAVITY, PlusDraft
from gimcli.exchange.pmks_plus_codec import FORCE, JOINT, LINK, PlusDocument
from gimcli.exchange.records import FilePart, FileRecord, all_of, number_of

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
    lines = {"j": _joint, "l": _link, "f": _force}
    joints, links, forces = all_of(lambda key: _records(key, sections[key], lines[key], source), lines)
    _mark_blocks(joints, links)
    speed, gravity, clockwise, unit = (*(field.strip() for field in sections["s"].split(",")), "", "", "", "")[:4]
    rate = number_of(speed or "0")
    FilePart(source).refuse(math.isnan(rate), f"s=: '{speed[:20]}' is not a speed")
    enums = [UNITS.get(unit.casefold(), 1), 0, 0, 0]
    document = PlusDocument(integers=[rate], enums=enums, joints=joints, links=links, forces=forces)
    document.flags[NO_GRAVITY] = not FLAGS.get(gravity.casefold())
    document.flags[CLOCKWISE] = FLAGS.get(clockwise.casefold(), False)
    draft = PlusDraft(document, source).draft
    known, paths = unit.casefold() in UNITS, sections.get("pp", "") + sections.get("tp", "")
    draft.length = draft.length if known else "unit"
    draft.note(not known, "the unit of length is unknown; lengths are without a unit")
    draft.note(paths.strip(), "the points of paths are left out")
    return draft


def _records(key: str, text: str, record: Callable[[str, str, list[str]], FileRecord], source: str) -> list[FileRecord]:
    """Return the records of the lines of a section; raise ModelError with all lines that are none."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]

    def read_line(number: int) -> FileRecord:
        own, *fields = (field.strip() for field in lines[number].split(","))
        try:
            return record(source, own, fields if own else [])
        except (ValueError, LookupError):
            where = f"{source}: {key}= line {number + 1}"
            raise ModelError([f"{where}: '{lines[number][:60]}' is damaged or incomplete"]) from None

    return all_of(read_line, range(len(lines)))


def _joint(source: str, own: str, fields: list[str]) -> FileRecord:
    x, y, _, kind, fixed, angle, *further = fields
    slides, driven = {"R": False, "P": True}[kind], any(map(_flag, [field for field in further if field][-1:]))
    place = {"x": _number(x), "y": _number(y), "angle": _number(angle) if slides else 0.0}
    return JOINT.record(source, id=own, name=own, **place, slides=slides, driven=driven, fixed=_flag(fixed))


def _link(source: str, own: str, fields: list[str]) -> FileRecord:
    kind, *rest = fields if fields[0] in ("R", "P") else ("R", *fields)
    mass, inertia, x, y = (_number(text) if text not in EMPTY else 0.0 for text in rest[:4])
    joints = [name for name in rest[4].split("|") if name]
    place = {"mass": mass, "inertia": inertia, "x": x, "y": y}
    return LINK.record(source, id=own, name=own, **place, block=kind == "P", joints=joints, parts=[])


def _force(source: str, own: str, fields: list[str]) -> FileRecord:
    link, x, y, x1, y1, fixed, outward, size = fields[:8]
    places = dict(zip(("x", "y", "x1", "y1", "size"), map(_number, (x, y, x1, y1, size)), strict=True))
    flags = {"local": not _flag(fixed), "outward": _flag(outward)}
    return FORCE.record(source, id=own, link=link, name=own, **places, **flags)


def _mark_blocks(joints: list[FileRecord], links: list[FileRecord]) -> None:
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
