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
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from itertools import takewhile
from typing import Any, TypeVar

from gimcli.errors import ModelError
from gimcli.exchange.refusing import FilePlace

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
    """A pin or a slider; a slider has an angle if the ground carries it, else a carrier and two joints of its slot.

    Texts and numbers are in the order of the format, and so are the flags, which are its first character.
    """

    id: str
    name: str
    x: float
    y: float
    angle: float = 0.0
    carrier: str = ""
    start: str = ""
    end: str = ""
    speed: float = 0.0  # its own speed, with sign; 0: that of the drawing
    mass: float = 0.0
    slides: bool = False
    driven: bool = False
    fixed: bool = False
    welded: bool = False  # of a slider: its links cannot turn against the slot
    traced: bool = False
    sealed: bool = False  # the piston of a cylinder
    further: tuple[str, ...] = ()  # fields of newer versions


@dataclass
class PlusLink:
    """A link: a body (`root`), a bar that is welded into a body, or the block of a slider (`block`).

    Texts and numbers are in the order of the format; x and y are the centre of mass.
    """

    id: str
    name: str
    mass: float = 0.0
    inertia: float = 0.0
    x: float = 0.0
    y: float = 0.0
    colour: str = "303e9f"
    root: bool = True
    block: bool = False
    joints: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()


@dataclass
class PlusForce:
    """A force from (x, y) towards (x1, y1), or the other way if it is not `outward`; `local`: it turns with its link.

    Texts and numbers are in the order of the format, and so are the flags, which are its first character.
    """

    id: str
    link: str
    name: str
    x: float
    y: float
    x1: float
    y1: float
    size: float
    local: bool = False
    outward: bool = True


WORDS: dict[type, str] = {PlusJoint: "joint", PlusLink: "link", PlusForce: "force"}
LEAST: dict[type, int] = {PlusJoint: 5, PlusLink: 7, PlusForce: 8}
"""Fields that records must have; a number after them is left empty if it is 0."""


def named(kind: type, *types: str) -> list[str]:
    """Return the names of the fields of a record that have one of some types, in the order of the format."""
    return [one.name for one in fields(kind) if one.type in types]


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


class Damaged(FilePlace):
    """A text that may be damaged."""

    def refused(self, text: str) -> ModelError:
        """Return the error for a damaged text."""
        return super().refused(f"{text}; copy the whole address or file again")


# -- numbers --------------------------------------------------------------------------------------


def _digits(value: int, digits: str, least: int = 1) -> str:
    """Return the digits of a number that is not negative, at least `least` of them."""
    text = ""
    while value or len(text) < least:
        value, digit = divmod(value, len(digits))
        text = digits[digit] + text
    return text


def _value(text: str) -> int:
    """Return the number of digits in base 64; other signs count as 0."""
    return sum(max(DIGITS.find(digit), 0) << 6 * k for k, digit in enumerate(reversed(text)))


def integer_text(value: int) -> str:
    """Return an integer in base 64, with a leading 0 if it is negative."""
    return ("0" if value < 0 else "") + _digits(abs(value), DIGITS)


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
    return -_value(digits) if negative else _value(digits)


def flags_of(text: str, count: int) -> list[bool]:
    """Return flags that are packed into an integer in base 64, the first one in the last bit."""
    return [bool(_value(text[:4]) >> k & 1) for k in range(count)]


def flags_text(flags: list[bool]) -> str:
    """Return flags as an integer in base 64."""
    return integer_text(sum(1 << k for k, flag in enumerate(flags) if flag))


# -- checks ---------------------------------------------------------------------------------------


def digest(text: str) -> str:
    """Return the check of a text: 32 bits by Fowler, Noll and Vo (FNV-1a), in base 62."""
    value = 2166136261
    for unit in _units(text):
        value = (value ^ unit) * 16777619 & 0xFFFFFFFF
    return _digits(value, CHECK_DIGITS, DIGEST_LENGTH)


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
    whole = Damaged(source)
    whole.refuse(len(text) > MOST_CHARACTERS, "too long for a drawing of PMKS+")
    text, mark, found = text.partition(DIGEST_MARK)
    whole.refuse(mark and found != digest(text), "the address is damaged: its digest does not match")
    good = len(text) > 1 and text[-1] == _length_digit(text[:-1])
    whole.refuse(not good, "the address is damaged or truncated: its length does not match")
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
        records = self._records("forces") if self.rest else []
        forces = [PlusForce(**self._flagged(PlusForce, record)) for record in records]
        _, _, entries = self.rest.partition(".")  # before it the selected object
        listed = [entry for entry in entries.split(",") if entry]
        return PlusDocument(flags, decimals, integers, enums, joints, links, forces, listed)

    def _part(self, name: str) -> str:
        part, point, self.rest = self.rest.partition(".")
        self.damaged.refuse(not point, f"the {name} are incomplete")
        return part

    def _records(self, name: str) -> list[str]:
        """Return the records up to an empty one."""
        found: list[str] = []
        while record := self._part(name):
            found.append(record)
            self.damaged.refuse(len(found) > MOST_RECORDS, f"more than {MOST_RECORDS} {name}")
        return found

    def _number(self, text: str, where: str) -> int:
        value = integer_of(text)
        if value is None:
            raise self.damaged.refused(f"{where}: '{text[:20]}' is not a number")
        return value

    def _fields(self, kind: type, record: str, head: int = 1) -> list[str]:
        """Return the texts of a record; its identifier stands after `head` characters of the first one."""
        first, *rest = record.split(",")
        text = f"{WORDS[kind]} {first[:20]}: expected {LEAST[kind]} fields, got {len(rest) + 1}"
        self.damaged.refuse(len(rest) + 1 < LEAST[kind], text)
        return [first[head:], *rest]

    def _values(self, kind: type, texts: list[str]) -> dict[str, Any]:
        """Return the texts and numbers of a record by the names of its fields."""
        numbers = named(kind, "float")
        found: dict[str, Any] = dict(zip(named(kind, "str", "float"), texts, strict=False))
        for number, (name, text) in enumerate(found.items()):
            if name in numbers:
                written = text or number < LEAST[kind]
                where = f"{WORDS[kind]} {texts[0][:20]}"
                found[name] = self._number(text, where) / THOUSANDTHS if written else 0.0
        return found

    def _flagged(self, kind: type, record: str) -> dict[str, Any]:
        """Return the texts, numbers and flags of a record by the names of its fields."""
        flags = named(kind, "bool")
        own = self._values(kind, self._fields(kind, record))
        return own | dict(zip(flags, flags_of(record[:1], len(flags)), strict=True))

    def _joint(self, record: str) -> PlusJoint:
        further = tuple(text for text in record.split(",")[10:] if text)
        return PlusJoint(**self._flagged(PlusJoint, record), further=further)

    def _link(self, record: str) -> PlusLink:
        flag, kind, texts = record[:1], record[1:2], self._fields(PlusLink, record, 2)
        text = f"link {texts[0][:20]}: '{record[:2]}' is unknown: a newer version of PMKS+ wrote it"
        self.damaged.refuse(flag not in ROOTS + PARTS or kind not in ("R", "P"), text)
        joints = tuple(takewhile(bool, texts[7:]))
        parts = tuple(text for text in texts[8 + len(joints) :] if text)
        own = self._values(PlusLink, texts)
        return PlusLink(**own, root=flag in ROOTS, block=kind == "P", joints=joints, parts=parts)


def restored(document: PlusDocument, entry: str) -> bool:
    """Replace a number by one with all digits, such as `PJA~0~1.23456`; return whether the entry is complete."""
    tag, *rest = entry.split("~")
    kind, own = tag[1:2], tag[2:]
    try:
        index, value = int(rest[0]), float(rest[1])
    except (ValueError, IndexError):
        return False
    if not math.isfinite(value) or index < 0:
        return False
    if kind in ("D", "I"):
        numbers = document.decimals if kind == "D" else document.integers
        if index < len(numbers):
            numbers[index] = value
        return index < len(numbers)
    records: dict[str, Sequence[Any]] = {"J": document.joints, "L": document.links, "F": document.forces}
    found = next((record for record in records.get(kind, ()) if record.id == own), None)
    names = named(type(found), "float") if found else []
    for name in names[index : index + 1]:
        setattr(found, name, value)
    return index < len(names)


# -- writing --------------------------------------------------------------------------------------


def text_of(document: PlusDocument) -> str:
    """Return the text of a document, with its checks."""
    settings = (
        flags_text(document.flags), ",".join(map(decimal_text, document.decimals)),
        ",".join(integer_text(round(value)) for value in document.integers), "".join(map(integer_text, document.enums)),
    )  # fmt: skip
    lists = (document.joints, document.links, document.forces)
    return stamped(".".join([*settings, *("".join(f"{_record_text(one)}." for one in own) for own in lists), "N_"]))


def _record_text(record: PlusJoint | PlusLink | PlusForce) -> str:
    """Return the text of a record, without empty fields at its end that need not be there."""
    kind, empty = type(record), ("", 0.0)
    least = LEAST[kind]
    own = [getattr(record, name) for name in named(kind, "str", "float")]
    while len(own) > least and own[-1] in empty:
        own.pop()
    texts = ["" if k >= least and value in empty else value if isinstance(value, str) else decimal_text(value)
             for k, value in enumerate(own)]  # fmt: skip
    if isinstance(record, PlusLink):
        return ("YR" if record.root else "NR") + ",".join([*texts, *record.joints, "", *(record.parts or ("",))])
    return flags_text([getattr(record, name) for name in named(kind, "bool")]) + ",".join(texts)
