"""PMKS+: the addresses of its first versions (2020-2023), with comma-separated lines for joints, links and forces.

`j=` has a line for each joint: id, x, y, links, type R or P, fixed, angle in radians, coefficient of friction (not in
the oldest version), input. `l=`: id, type (not in the oldest version), mass, moment of inertia, centre of mass, joints.
`f=`: id, link, start, end, global, outward, size. `s=`: speed in revolutions per minute, gravity, clockwise, unit.

Source: PMKS+ (2020-2023), its class UrlProcessorService.
"""

from __future__ import annotations

import re
from typing import Any

from gimcli.exchange.draft import Draft
from gimcli.exchange.pmks_plus import CLOCKWISE, NO_GRAVITY, PlusDraft
from gimcli.exchange.pmks_plus_codec import FORCE, JOINT, LINK, PlusDocument, RecordKind
from gimcli.exchange.records import FilePart, FileRecord, all_of, query_of, read as read_part

ADDRESS = re.compile(r"https?://", re.IGNORECASE)
JOINTS, LINKS = re.compile(r"[?&]j="), re.compile(r"&l=")
UNITS = {"in": 0, "inch": 0, "cm": 1, "m": 2, "meter": 2, "metre": 2}
"""Units of length, by their number in newer versions."""
EMPTY = "Null"
"""Fields of blocks, which have no mass in the versions of 2021."""
LINES: dict[str, tuple[RecordKind, dict[str, Any]]] = {
    "j": (JOINT, {"id": str, "x": float, "y": float, "links": "", "type": str, "fixed": bool, "angle": 0.0,
                  "friction": (object,), "driven": False}),
    "l": (LINK, {"id": str, "type": str, "mass": 0.0, "inertia": 0.0, "x": 0.0, "y": 0.0, "joints": str}),
    "f": (FORCE, {"id": str, "link": str, "x": float, "y": float, "x1": float, "y1": float, "fixed": bool,
                  "outward": bool, "size": float}),
}  # fmt: skip
"""The fields of lines by the key of their section."""
SETTINGS = {"rate": 0.0, "gravity": False, "clockwise": False, "unit": ""}


def recognises(text: str) -> bool:
    """Return whether a text is such an address, be it damaged or not."""
    own = text.strip()
    return bool(ADDRESS.match(own) and (found := JOINTS.search(own)) and LINKS.search(own, found.end()))


def read(text: str, source: str) -> Draft:
    """Return the mechanism of an address; raise ModelError for a damaged one."""
    sections = dict.fromkeys("jlfs", "") | dict(query_of(text.strip()))
    joints, links, forces = all_of(lambda key: _records(key, sections[key], source), LINES)
    _mark_blocks(joints, links)
    own = _line(SETTINGS, sections["s"].split(","), f"{source}: s=")
    known = own.unit.casefold() in UNITS
    enums = [UNITS.get(own.unit.casefold(), 1), 0, 0, 0]
    document = PlusDocument(integers=[own.rate], enums=enums, joints=joints, links=links, forces=forces)
    document.flags[NO_GRAVITY], document.flags[CLOCKWISE] = not own.gravity, own.clockwise
    draft = PlusDraft(document, source).draft
    draft.length = draft.length if known else "unit"
    draft.note(not known, "the unit of length is unknown; lengths are without a unit")
    paths = sections.get("pp", "") + sections.get("tp", "")
    draft.note(paths.strip(), "the points of paths are left out")
    return draft


def _line(form: dict[str, Any], fields: list[str], where: str) -> FileRecord:
    """Return the fields of a line as a record."""
    texts = [field.strip().replace(EMPTY, "") for field in fields]
    record: FileRecord = read_part(form, FilePart(where, dict(zip(form, texts, strict=False)), texts=True))
    return record


def _records(key: str, text: str, source: str) -> list[FileRecord]:
    """Return the records of the lines of a section; raise ModelError with the faults of all lines."""
    kind, form = LINES[key]

    def record(number: int) -> FileRecord:
        fields = lines[number].split(",")
        if kind is LINK and fields[1:] and fields[1].strip() not in ("R", "P"):
            fields.insert(1, "R")
        if kind is JOINT:  # the input is the last field
            fields[7:] = ["", *[field for field in fields[7:] if field.strip()][-1:]]
        own = _line(form, fields, f"{source}: {key}= line {number + 1}")
        if kind is FORCE:
            return kind.record(source, **vars(own), name=own.id, local=not own.fixed)
        own.at("type").refuse(own.type not in ("R", "P"), f"expected R or P, got '{own.type[:40]}'")
        own.joints = [name for name in own.joints.split("|") if name] if kind is LINK else []
        return kind.record(source, **vars(own), name=own.id, slides=own.type == "P", block=own.type == "P")

    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return all_of(record, range(len(lines)))


def _mark_blocks(joints: list[FileRecord], links: list[FileRecord]) -> None:
    """Mark the blocks of sliders where the version has no type of links: a slider and a pin at one place."""
    places = {joint.id: joint for joint in joints}
    for link in links:
        ends = [places[name] for name in link.joints if name in places]
        if len(ends) == 2 and ends[0].slides != ends[1].slides:
            link.block = (ends[0].x, ends[0].y) == (ends[1].x, ends[1].y)
