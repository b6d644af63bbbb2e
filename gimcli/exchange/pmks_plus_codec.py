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
from dataclasses import dataclass, field
from itertools import takewhile
from typing import Any, NamedTuple

from gimcli.errors import ModelError
from gimcli.exchange.records import FilePart, FileRecord, number_of

DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-"
CHECK_DIGITS = DIGITS[:62]
HEAD = re.compile(r"[0-9A-Za-z_-]{1,4}\.[0-9A-Za-z_,-]{1,99}\.[0-9A-Za-z_,-]{1,99}\.[0-9A-Za-z_-]{0,9}\.")
"""The settings at the start of a text."""
DIGEST_LENGTH, DIGEST_MARK = 6, "*"
THOUSANDTHS = 1000
LONGEST_NUMBER = 14
"""Most digits of a number: 64^14 is far beyond any length in thousandths."""
MOST_CHARACTERS = 200_000


class RecordKind(NamedTuple):
    """A kind of records: its texts and numbers in the order of the format, and the flags in its first character.

    The first `least` fields must be there; a number after them is left empty if it is 0.
    """

    word: str
    least: int
    fields: dict[str, str | float]
    flags: dict[str, bool]

    def record(self, source: str, **values: Any) -> FileRecord:
        """Return a record; what is not given has its default. Errors name the file and the record."""
        own = FilePart(source, None, (f"{self.word} {values['id'][:20]}",))
        further = {"own": own, "joints": (), "parts": (), "rest": ()}
        return FileRecord(**{**self.fields, **self.flags, **further, **values})


JOINT = RecordKind(
    "joint", 5,
    {"id": "", "name": "", "x": 0.0, "y": 0.0, "angle": 0.0, "carrier": "", "start": "", "end": "", "speed": 0.0,
     "mass": 0.0},
    dict.fromkeys(("slides", "driven", "fixed", "welded", "traced", "sealed"), False),
)  # fmt: skip
"""A pin or a slider; a slider has an angle if the ground carries it, else a carrier and two joints of its slot.

`speed`: its own one, with sign; 0: that of the drawing. `welded`, of a slider: its links cannot turn against the slot.
`sealed`: it is the piston of a cylinder. `rest`: fields of newer versions.
"""
LINK = RecordKind(
    "link", 7, {"id": "", "name": "", "mass": 0.0, "inertia": 0.0, "x": 0.0, "y": 0.0, "colour": "303e9f"},
    {"root": True, "block": False},
)  # fmt: skip
"""A link: a body (`root`), a bar that is welded into a body, or the block of a slider (`block`).

x and y are the centre of mass. `joints` are its joints, and `parts` the bars that are welded into it. It has two
characters for its flags.
"""
FORCE = RecordKind(
    "force", 8, {"id": "", "link": "", "name": "", "x": 0.0, "y": 0.0, "x1": 0.0, "y1": 0.0, "size": 0.0},
    {"local": False, "outward": False},
)  # fmt: skip
"""A force from (x, y) towards (x1, y1), or the other way if it is not `outward`; `local`: it turns with its link."""
ROOTS, PARTS = "YAMG0123", "Namg4567"
"""First character of links that are bodies, and of bars that are welded into a body."""


@dataclass
class PlusDocument:
    """The content of a text; flags, decimals, integers and enums in the order of the format."""

    flags: list[bool] = field(default_factory=lambda: [False] * 9)
    decimals: list[float] = field(default_factory=list)
    integers: list[float] = field(default_factory=list)
    enums: list[int] = field(default_factory=list)
    joints: list[FileRecord] = field(default_factory=list)
    links: list[FileRecord] = field(default_factory=list)
    forces: list[FileRecord] = field(default_factory=list)
    entries: list[str] = field(default_factory=list)  # the tagged list


class Damaged(FilePart):
    """A text that may be damaged."""

    def refused(self, text: str) -> ModelError:
        """Return the error for a damaged text."""
        return super().refused(f"{text}; copy the whole address or file again")

    def integer_of(self, text: str, where: str) -> int:
        """Return an integer in base 64; a 0 before other digits is the sign of a negative one."""
        negative = len(text) > 1 and text[0] == "0"
        good = 0 < len(text) - negative <= LONGEST_NUMBER and not text.strip(DIGITS)
        self.refuse(not good, f"{where}: '{text[:20]}' is not a number")
        return -_value(text) if negative else _value(text)


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
    parts, whole = checked_body(text, source).split("."), Damaged(source)
    whole.refuse(len(parts) < 4, "the settings are incomplete")
    flags, decimals, integers, enums = parts[0], parts[1].split(","), parts[2].split(","), parts[3]
    settings = [[whole.integer_of(one, "settings") for one in own] for own in (decimals, integers, enums)]
    rest, lists = parts[4:], []
    for kind in (JOINT, LINK, FORCE):  # each list up to an empty record
        whole.refuse("" not in rest, f"the {kind.word}s are incomplete")
        end = rest.index("")
        lists.append([_record(kind, one, whole) for one in rest[:end]])
        rest = rest[end + 1 :]
    joints, links, forces = lists
    _, _, entries = ".".join(rest).partition(".")  # before it the selected object
    return PlusDocument(
        flags_of(flags, 9), [value / THOUSANDTHS for value in settings[0]], list(map(float, settings[1])), settings[2],
        joints, links, forces, [entry for entry in entries.split(",") if entry],
    )  # fmt: skip


def _record(kind: RecordKind, text: str, whole: Damaged) -> FileRecord:
    """Return a record, whose identifier stands after one character with its flags, or two of a link."""
    head = 2 if kind is LINK else 1
    texts = text[head:].split(",")
    where, least = f"{kind.word} {texts[0][:20]}", kind.least
    whole.refuse(len(texts) < least, f"{where}: expected {least} fields, got {len(texts)}")
    values: dict[str, Any] = dict(zip(kind.fields, texts, strict=False))
    for number, (name, own) in enumerate(values.items()):
        if isinstance(kind.fields[name], float):
            written = own or number < least
            values[name] = whole.integer_of(own, where) / THOUSANDTHS if written else 0.0
    flags = dict(zip(kind.flags, flags_of(text[:1], len(kind.flags)), strict=True))
    record = kind.record(whole.place, **values, **flags, rest=texts[len(kind.fields) :])
    if kind is LINK:
        unknown = f"{where}: '{text[:2]}' is unknown: a newer version of PMKS+ wrote it"
        whole.refuse(text[0] not in ROOTS + PARTS or text[1:2] not in ("R", "P"), unknown)
        record.root, record.block = text[0] in ROOTS, text[1] == "P"
        record.joints = list(takewhile(bool, record.rest))
        record.parts = [part for part in record.rest[len(record.joints) + 1 :] if part]
    return record


def restored(document: PlusDocument, entry: str) -> bool:
    """Replace a number by one with all digits, such as `PJA~0~1.23456`; return whether the entry is complete."""
    tag, *rest = entry.split("~")
    kind, own = tag[1:2], tag[2:]
    index, value = (*map(number_of, rest[:2]), math.nan, math.nan)[:2]
    if not (index >= 0.0 and index.is_integer() and math.isfinite(value)):
        return False
    if kind in ("D", "I"):
        numbers = document.decimals if kind == "D" else document.integers
        numbers[int(index) : int(index) + 1] = [value] * (index < len(numbers))
        return index < len(numbers)
    form, records = {"L": (LINK, document.links), "F": (FORCE, document.forces)}.get(kind, (JOINT, document.joints))
    names = [name for name, default in form.fields.items() if isinstance(default, float)][int(index) :][:1]
    found = [record for record in records if record.id == own and kind in ("J", "L", "F")][:1]
    for name in names if found else ():
        setattr(found[0], name, value)
    return bool(names and found)


# -- writing --------------------------------------------------------------------------------------


def text_of(document: PlusDocument) -> str:
    """Return the text of a document, with its checks."""
    settings = (
        flags_text(document.flags), ",".join(map(decimal_text, document.decimals)),
        ",".join(integer_text(round(value)) for value in document.integers), "".join(map(integer_text, document.enums)),
    )  # fmt: skip
    lists = ((JOINT, document.joints), (LINK, document.links), (FORCE, document.forces))
    texts = ("".join(f"{_record_text(kind, one)}." for one in own) for kind, own in lists)
    return stamped(".".join([*settings, *texts, "N_"]))


def _record_text(kind: RecordKind, record: FileRecord) -> str:
    """Return the text of a record, without empty fields at its end that need not be there."""
    own = [getattr(record, name) for name in kind.fields]
    while len(own) > kind.least and own[-1] in ("", 0.0):
        own.pop()
    texts = ["" if k >= kind.least and not value else value if isinstance(value, str) else decimal_text(value)
             for k, value in enumerate(own)]  # fmt: skip
    if kind is LINK:
        return ("YR" if record.root else "NR") + ",".join([*texts, *record.joints, "", ""])
    return flags_text([getattr(record, name) for name in kind.flags]) + ",".join(texts)
