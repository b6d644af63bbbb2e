"""PMKS: its text files, and the web addresses that have the same text behind `?mech=`.

A line is a joint: the names of its links, its type (R, P, RP or G), x, y, the angle of the slot in degrees, and marks;
commas or blanks separate them. Lines `set=`, `name=`, `s=` and `d=` may stand before. In addresses `|` ends a line.

Source: M. I. Campbell, PMKS (2012-2015), `ConvertTextToData` of its simulator and the reading of its addresses.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterator
from dataclasses import replace

from gimcli.exchange.draft import GROUND, MOST, Draft, DrawnJoint, free_name
from gimcli.exchange.drawn_linkage import DrawnLinkage
from gimcli.exchange.pmks import PROGRAM, TYPES, draft_of_joints, drawn_joint, is_ground
from gimcli.exchange.pmks_plus_codec import HEAD
from gimcli.exchange.records import FilePart, all_of, number_of, query_of

ADDRESS = re.compile(r"https?://", re.IGNORECASE)
MECHANISM = re.compile(r"[?&]mech=", re.IGNORECASE)
NO_ROW = re.compile(r"[:;{}<>=?\"]")
NUMBER = re.compile(r"[-+]?\.?\d")
HEADER = re.compile(r"\s*(mech|name|set|ts|s|d|e|f)\s*=(.*)", re.IGNORECASE)
LONGEST = 60
"""Most characters of a line that a message quotes."""

MOST_INPUTS = 1

MECH = "mech"


def recognises(text: str) -> bool:
    """Return whether a text is an address of PMKS, or a list of joints in most of its lines."""
    lines = [line for line in text.splitlines()[:MOST] if line.strip()]
    if any(_address(line) for line in lines):
        return True
    if HEAD.match(text.strip()):  # the text of a PMKS+ address
        return False
    rows = sum(1 for line in lines if _is_row(line[:1000]))
    return rows > 0 and 2 * rows >= sum(1 for line in lines if not HEADER.match(line))


def read(text: str, source: str) -> Draft:
    """Return the mechanism of a text or of an address; raise ModelError with all errors."""
    found = [address for line in text.splitlines() if (address := _address(line))]
    FilePart(source).refuse(len(found) > 1, f"holds {len(found)} addresses of {PROGRAM}; give one of them")
    rows, given = _entries(text, source, "".join(found))
    joints = all_of(_joint, rows)
    given |= {part[:1].casefold(): part[1:] for part in given.get("set", "").split("|")}  # s5|f1
    driver = re.fullmatch(r"\s*([0-9]{1,9})\s*", given.get("d", ""))
    name, speed = given.get("name", ""), number_of(given.get("s", ""))
    return draft_of_joints(joints, source, name, speed, int(driver[1]) if driver else None, given.get("ts", "").strip())


def _address(line: str) -> str:
    """Return the address in a line; "" if there is none with a mechanism."""
    start = ADDRESS.search(line)
    return line[start.start() :] if start and MECHANISM.search(line, start.start()) else ""


def _is_row(line: str) -> bool:
    """Return whether a line has words, the type of a joint and a number, and no signs of other formats."""
    words = re.split(r"[,\s]+", line.strip(" \t,"))
    at = max((k for k, word in enumerate(words[:-1]) if word.upper() in TYPES), default=0)
    return at > 0 and NUMBER.match(words[at + 1]) is not None and not NO_ROW.search(line)


# -- lines and header -----------------------------------------------------------------------------


def _entries(text: str, source: str, address: str) -> tuple[list[tuple[str, str]], dict[str, str]]:
    """Return the joints of a file, or behind `mech=` of an address, each with its place, and what else is set."""
    lines = ((f"{source}:{number}:1", *_keyed(line)) for number, line in enumerate(text.splitlines(), 1))
    queried = ((f"{source}: joint", key.strip().casefold(), value) for key, value in query_of(address))
    rows, given = list[tuple[str, str]](), dict[str, str]()
    for place, key, value in queried if address else lines:
        own = [row for row in re.split(r"[|\n]", value) if row.strip()]
        if key != MECH:
            given[key] = value.strip()
        rows += [(f"{place} {n}" if address else place, row) for n, row in enumerate(own, 1) if key == MECH]
    return rows, given


def _keyed(line: str) -> tuple[str, str]:
    """Return the key of a line and what follows it; MECH and the line if it is a joint."""
    match = HEADER.match(line)
    return (match[1].casefold(), match[2]) if match else (MECH, line)


# -- joints ---------------------------------------------------------------------------------------


def _joint(row: tuple[str, str]) -> DrawnJoint:
    """Return the joint of a line: its place in the file and its text.

    The four marks at the end are written `tfft`, `+--+` or `True,False,False,True`: path, velocity and acceleration are
    shown, and the joint is the driver.
    """
    where, line = row
    words, place = re.split(r"[,\s]+", line.strip(" \t\r,")), FilePart(where)
    got = f"got '{line.strip()[:LONGEST]}'"
    at = max((k for k, word in enumerate(words) if word.upper() in TYPES), default=-1)
    place.refuse(at < 0, f"expected LINKS,TYPE,X,Y with a type R, P or RP, {got}")
    x, y, angle = (*map(number_of, words[at + 1 : at + 4]), *[math.nan] * 3)[:3]
    place.refuse(math.isnan(x + y), f"expected two coordinates after the type {words[at].upper()}, {got}")
    marks = words[at + (3 if math.isnan(angle) else 4) :][:4]
    spelled = all(word.casefold() in ("true", "false") for word in marks)
    signs = ("".join(word[0] for word in marks) if spelled else marks[0]).ljust(4)
    own = {"traced": signs[0] in "tT+", "driver": 0 if signs[3] in "tT+" else None}
    return drawn_joint(words[at].upper(), words[:at], x, y, math.radians(angle), place, **own)


# -- writing --------------------------------------------------------------------------------------


def write(drawn: DrawnLinkage) -> str:
    """Return the text of a mechanism: the speed, and rows with the driver first, which PMKS counts by its number.

    `left_out` gets sentences about what PMKS has not. Raises ModelError for several inputs, of which PMKS has one.
    """
    own = drawn.mechanism
    names = [actuator.name for actuator in own.actuators]
    several = f"{PROGRAM} has one input, the model has {len(names)}: {', '.join(names)}"
    drawn.refuse(len(names) > MOST_INPUTS, several)
    rows = [row for joint in list(drawn.joints) for row in _rows(drawn, joint)]
    drawn.note_laws(cylinders=False)
    drawn.note(own.length_unit != "unit", f"{PROGRAM} has no units; lengths are in {own.length_unit}")
    drawn.note(not own.dynamics.empty, "masses, loads, springs, dampers and friction are left out")
    drawn.note(not names, f"the model has no input; {PROGRAM} drives the first joint that can be driven")
    links = _links(drawn)
    lines = [_line(row, links) for row in sorted(rows, key=lambda row: row.driver is None)]
    return "\n".join([*([f"set=s{_speed(drawn):.9g}"] if names else []), "mech=", *lines, ""])


def _line(row: DrawnJoint, links: dict[str, str]) -> str:
    """Return the line of a joint; all digits are written. `links`: the names of bodies."""
    marks = f"{'t' if row.traced else 'f'}ff{'f' if row.driver is None else 't'}"
    numbers = (*row.place, math.degrees(cmath.phase(row.along)))
    return ",".join([*(links[body] for body in row.bodies), row.kind, *(repr(value + 0.0) for value in numbers), marks])


def _speed(drawn: DrawnLinkage) -> float:
    """Return the speed of the input, against the direction of its slot if PMKS turns this by half a revolution."""
    against = any(abs(cmath.phase(slot.along)) > math.pi / 2.0 for slot in drawn.slots if slot.driver is not None)
    return -drawn.speed(0) if against else drawn.speed(0)


def _links(drawn: DrawnLinkage) -> dict[str, str]:
    """Return names of links as PMKS can read them: without blanks and commas, and not those of the ground."""
    found = {GROUND: GROUND}
    for body in (body for body in drawn.bodies if body != GROUND):
        plain = re.sub(r"[^\w.-]+", "_", body).strip("_") or "link"
        own = f"link_{plain}" if is_ground(plain) or plain.isdecimal() else plain
        found[body] = free_name(own, found.values(), same=str.casefold)
    return found


def _rows(drawn: DrawnLinkage, joint: str) -> Iterator[DrawnJoint]:
    """Yield the rows of a joint: its slots, and its pin or tracer.

    The links of the driver have a row of their own; each further link has one with one of them.
    """
    own = DrawnJoint("R", (), drawn.joints[joint], traced=joint in drawn.mechanism.traced)
    bodies, turns = drawn.common(joint), [turn for turn in drawn.turns if turn.at == joint]
    slots = [slot for slot in drawn.slots if slot.at == joint]
    for slot in slots:
        block = slot.block
        if slot.driver is not None and not block:  # PMKS drives blocks, not pins in slots
            block = drawn.body(f"{joint} block", [])
            yield replace(own, bodies=(block, bodies[0]))
        kind, pair = "P" if block else "RP", (slot.carrier, block or bodies[0])
        yield replace(own, kind=kind, bodies=pair, direction=slot.direction, driver=slot.driver)
    if turns or len(bodies) > 1 or (not slots and bodies not in ([], [GROUND])):
        first = turns[0].bodies if turns else tuple(bodies[:2])
        yield replace(own, bodies=first, driver=turns[0].driver if turns else None)
        yield from (replace(own, bodies=(first[0], body)) for body in bodies if body not in first)
