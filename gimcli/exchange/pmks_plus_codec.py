"""The text of PMKS+ addresses and files: records of joints, links and forces, with their checks.

A text is `bools.decimals.integers.enums.` and then the joints, the links and the forces, each record ended by a point,
each list by one more; then the selected object, a list of tagged entries if there are any, one character for the length
and, in newer texts, an asterisk with a digest of six characters. Numbers are integers in base 64, with a leading 0 if
they are negative; decimals are in thousandths.

Source: PMKS+ (2023-2026), its classes StringTranscoder, BaseNConverter, FlagPacker and Checksum.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

from gimcli.errors import ModelError

DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-"
CHECK_DIGITS = DIGITS[:62]
HEAD = re.compile(r"[0-9A-Za-z_-]{1,4}\.[0-9A-Za-z_,-]{1,99}\.[0-9A-Za-z_,-]{1,99}\.[0-9A-Za-z_-]{0,9}\.")
"""The settings at the start of a text."""
DIGEST_LENGTH, DIGEST_MARK = 6, "*"
THOUSANDTHS = 1000
LONGEST_NUMBER = 14
"""Most digits of a number: 64^14 is far beyond any length in thousandths."""
MOST_RECORDS = 500
MOST_CHARACTERS = 200_000

Record = TypeVar("Record")

ROOTS, PARTS = "YAMG0123", "Namg4567"
"""First character of links that are bodies, and of bars that are welded into a body."""


@dataclass
class PlusJoint:
    """A pin or a slider; a slider has an angle if the ground carries it, else a carrier and two joints of its slot."""

    id: str
    name: str
    x: float
    y: float
    angle: float = 0.0
    slides: bool = False
    driven: bool = False
    fixed: bool = False
    welded: bool = False  # of a slider: its links cannot turn against the slot
    traced: bool = False
    sealed: bool = False  # the piston of a cylinder
    carrier: str = ""
    slot: tuple[str, str] = ("", "")
    speed: float = 0.0  # its own speed, with sign; 0: that of the drawing
    mass: float = 0.0
    further: tuple[str, ...] = ()  # fields of newer versions


@dataclass
class PlusLink:
    """A link: a body (`root`), a bar that is welded into a body, or the block of a slider (`block`)."""

    id: str
    name: str
    root: bool = True
    block: bool = False
    mass: float = 0.0
    inertia: float = 0.0
    centre: complex = 0j
    colour: str = "303e9f"
    joints: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()


@dataclass
class PlusForce:
    """A force from `start` towards `end`, or the other way if it is not `outward`."""

    id: str
    link: str
    name: str
    start: complex
    end: complex
    size: float
    local: bool = False  # turns with its link
    outward: bool = True


@dataclass
class PlusDocument:
    """The content of a text; flags, decimals, integers and enums in the order of the format."""

    flags: list[bool] = field(default_factory=lambda: [False] * 9)
    decimals: list[float] = field(default_factory=list)
    integers: list[float] = field(default_factory=list)
    enums: list[int] = field(default_factory=list)
    joints: list[PlusJoint] = field(default_factory=list)
    links: list[PlusLink] = field(default_factory=list)
    forces: list[PlusForce] = field(default_factory=list)
    entries: list[str] = field(default_factory=list)  # the tagged list


class Damaged(NamedTuple):
    """Where a text is read, to report errors."""

    source: str

    def error(self, text: str) -> ModelError:
        """Return the error for a damaged text."""
        return ModelError([f"{self.source}: {text}; copy the whole address or file again"])


# -- numbers --------------------------------------------------------------------------------------


def integer_text(value: int) -> str:
    """Return an integer in base 64, with a leading 0 if it is negative."""
    rest, text = abs(value), ""
    while rest or not text:
        rest, digit = divmod(rest, len(DIGITS))
        text = DIGITS[digit] + text
    return "0" + text if value < 0 else text


def decimal_text(value: float) -> str:
    """Return a number, rounded to thousandths; raise ModelError if it is too large."""
    if not math.isfinite(value * THOUSANDTHS):
        raise ModelError(["a number is too large for PMKS+; change it, or use another unit"])
    return integer_text(round(value * THOUSANDTHS))


def integer_of(text: str) -> int | None:
    """Return the integer of a text; None if it is none."""
    negative = len(text) > 1 and text[0] == "0"
    digits = text[1:] if negative else text
    if not digits or len(digits) > LONGEST_NUMBER or any(c not in DIGITS for c in digits):
        return None
    value = 0
    for digit in digits:
        value = value * len(DIGITS) + DIGITS.index(digit)
    return -value if negative else value


def flags_of(text: str, count: int) -> list[bool]:
    """Return flags that are packed into an integer in base 64, the first one in the last bit."""
    value = 0
    for digit in text[:4]:
        value = value * len(DIGITS) + max(DIGITS.find(digit), 0)
    return [bool(value >> k & 1) for k in range(count)]


def flags_text(flags: list[bool]) -> str:
    """Return flags as an integer in base 64."""
    return integer_text(sum(1 << k for k, flag in enumerate(flags) if flag))


# -- checks ---------------------------------------------------------------------------------------


def digest(text: str) -> str:
    """Return the check of a text: 32 bits by Fowler, Noll and Vo (FNV-1a), in base 62."""
    value = 2166136261
    for unit in _units(text):
        value = (value ^ unit) * 16777619 & 0xFFFFFFFF
    found = ""
    for _ in range(DIGEST_LENGTH):
        value, digit = divmod(value, len(CHECK_DIGITS))
        found = CHECK_DIGITS[digit] + found
    return found


def _units(text: str) -> memoryview:
    """Return the units of 16 bits that PMKS+ counts as characters."""
    return memoryview(text.encode("utf-16-le", "surrogatepass")).cast("H")


def _length_digit(body: str) -> str:
    return CHECK_DIGITS[len(_units(body)) % len(CHECK_DIGITS)]


def stamped(body: str) -> str:
    """Return a body with the character for its length and the digest."""
    checked = body + _length_digit(body)
    return checked + DIGEST_MARK + digest(checked)


def checked_body(text: str, source: str) -> str:
    """Return the body of a text; raise ModelError if its length or its digest is wrong."""
    damaged = Damaged(source)
    if len(text) > MOST_CHARACTERS:
        raise damaged.error("too long for a drawing of PMKS+")
    text, mark, found = text.partition(DIGEST_MARK)
    if mark and found != digest(text):
        raise damaged.error("the address is damaged: its digest does not match")
    if len(text) < 2 or text[-1] != _length_digit(text[:-1]):
        raise damaged.error("the address is damaged or truncated: its length does not match")
    return text[:-1]


# -- reading --------------------------------------------------------------------------------------


def document_of(text: str, source: str) -> PlusDocument:
    """Return the content of a text; raise ModelError if it is damaged."""
    return _PlusText(checked_body(text, source), source).document()


class _PlusText:
    """A body that is read from its start to its end."""

    def __init__(self, body: str, source: str) -> None:
        self.rest, self.damaged = body, Damaged(source)

    def document(self) -> PlusDocument:
        """Return the content."""
        flags = flags_of(self._part("settings"), 9)
        decimals = [self._number(t, "settings") / THOUSANDTHS for t in self._part("settings").split(",")]
        integers = [float(self._number(t, "settings")) for t in self._part("settings").split(",")]
        enums = [self._number(t, "settings") for t in self._part("settings")]
        joints = [self._joint(record) for record in self._records("joints")]
        links = [self._link(record) for record in self._records("links")]
        forces = [self._force(record) for record in self._records("forces")] if self.rest else []
        _, _, entries = self.rest.partition(".")  # before it the selected object
        listed = [entry for entry in entries.split(",") if entry]
        return PlusDocument(flags, decimals, integers, enums, joints, links, forces, listed)

    def _part(self, name: str) -> str:
        part, point, self.rest = self.rest.partition(".")
        if not point:
            raise self.damaged.error(f"the {name} are incomplete")
        return part

    def _records(self, name: str) -> list[str]:
        """Return the records up to an empty one."""
        found: list[str] = []
        while record := self._part(name):
            found.append(record)
            if len(found) > MOST_RECORDS:
                raise self.damaged.error(f"more than {MOST_RECORDS} {name}")
        return found

    def _number(self, text: str, where: str) -> int:
        value = integer_of(text)
        if value is None:
            raise self.damaged.error(f"{where}: '{text[:20]}' is not a number")
        return value

    def _decimal(self, text: str, where: str) -> float:
        return self._number(text, where) / THOUSANDTHS

    def _fields(self, record: str, least: int, where: str) -> list[str]:
        fields = record.split(",")
        if len(fields) < least:
            raise self.damaged.error(f"{where} {fields[0][:20]}: expected {least} fields, got {len(fields)}")
        return fields

    def _joint(self, record: str) -> PlusJoint:
        fields = self._fields(record, 5, "joint")
        slides, driven, fixed, welded, traced, sealed = flags_of(record[:1], 6)
        own = fields[0][1:]
        where = f"joint {own[:20]}"
        x, y, angle = (self._decimal(text, where) for text in fields[2:5])
        carrier, a, b, *rates = (*fields[5:10], *[""] * 5)[:5]
        speed, mass = (self._decimal(text, where) if text else 0.0 for text in rates)
        further = tuple(text for text in fields[10:] if text)
        return PlusJoint(
            own, fields[1], x, y, angle, slides, driven, fixed, welded, traced, sealed,
            carrier, (a, b), speed, mass, further,
        )  # fmt: skip

    def _link(self, record: str) -> PlusLink:
        fields = self._fields(record, 7, "link")
        flag, kind, own = record[:1], record[1:2], fields[0][2:]
        if flag not in ROOTS + PARTS or kind not in ("R", "P"):
            raise self.damaged.error(f"link {own[:20]}: '{record[:2]}' is unknown: a newer version of PMKS+ wrote it")
        where = f"link {own[:20]}"
        mass, inertia, x, y = (self._decimal(text, where) for text in fields[2:6])
        joints = tuple(_until_empty(fields[7:]))
        parts = tuple(text for text in fields[8 + len(joints) :] if text)
        return PlusLink(
            own, fields[1], flag in ROOTS, kind == "P", mass, inertia, complex(x, y), fields[6], joints, parts
        )

    def _force(self, record: str) -> PlusForce:
        fields = self._fields(record, 8, "force")
        local, outward = flags_of(record[:1], 2)
        own = fields[0][1:]
        x0, y0, x1, y1, size = (self._decimal(text, f"force {own[:20]}") for text in fields[3:8])
        return PlusForce(own, fields[1], fields[2], complex(x0, y0), complex(x1, y1), size, local, outward)


def _until_empty(texts: list[str]) -> list[str]:
    return texts[: texts.index("")] if "" in texts else texts


# -- writing --------------------------------------------------------------------------------------


def text_of(document: PlusDocument) -> str:
    """Return the text of a document, with its checks."""
    return stamped(
        ".".join(
            (
                flags_text(document.flags),
                ",".join(map(decimal_text, document.decimals)),
                ",".join(integer_text(round(value)) for value in document.integers),
                "".join(map(integer_text, document.enums)),
                _listed(document.joints, _joint_text),
                _listed(document.links, _link_text),
                _listed(document.forces, _force_text),
                "N_",
            )
        )
    )


def _listed(records: list[Record], written: Callable[[Record], str]) -> str:
    return "".join(f"{written(record)}." for record in records)


def _joint_text(joint: PlusJoint) -> str:
    flags = [joint.slides, joint.driven, joint.fixed, joint.welded, joint.traced, joint.sealed]
    numbers = [decimal_text(value) for value in (joint.x, joint.y, joint.angle)]
    further = [
        joint.carrier, *joint.slot, decimal_text(joint.speed) if joint.speed else "",
        decimal_text(joint.mass) if joint.mass else "",
    ]  # fmt: skip
    while further and not further[-1]:
        further.pop()
    return ",".join([f"{flags_text(flags)}{joint.id}", joint.name, *numbers, *further])


def _link_text(link: PlusLink) -> str:
    flag = "Y" if link.root else "N"
    numbers = [decimal_text(value) for value in (link.mass, link.inertia, link.centre.real, link.centre.imag)]
    return ",".join([f"{flag}R{link.id}", link.name, *numbers, link.colour, *link.joints, "", *(link.parts or ("",))])


def _force_text(force: PlusForce) -> str:
    points = (force.start.real, force.start.imag, force.end.real, force.end.imag)
    numbers = [decimal_text(value) for value in (*points, force.size)]
    return ",".join([f"{flags_text([force.local, force.outward])}{force.id}", force.link, force.name, *numbers])
