"""The tagged entries at the end of a PMKS+ text: numbers with all digits, locks, colours, gears and others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from gimcli.exchange.draft import Draft
from gimcli.exchange.pmks_plus_codec import PlusDocument

APPEARANCE = ("J", "L", "F", "C", "S", "H", "K")
"""First letters of entries that no motion depends on: locks, anchors, synthesis designs, held values and colours."""
PRECISE = {
    "J": ("x", "y", "angle", "speed", "mass"),
    "L": ("mass", "inertia", "centre.real", "centre.imag"),
    "F": ("start.real", "start.imag", "end.real", "end.imag", "size"),
}
"""Fields of entries with all digits of a number, in the order of the format."""


def apply_entries(document: PlusDocument, draft: Draft) -> None:
    """Apply the entries to the records that they name; refuse those that the motion may depend on."""
    for entry in document.entries:
        if entry.startswith("G"):
            raise draft.refusal("the gears of the drawing cannot be converted; add them to the model file as `gears`")
        if entry.startswith("P"):
            if not _restored(document, entry):
                raise draft.refusal(f"the entry '{entry[:20]}' is damaged; copy the whole address or file again")
        elif entry.startswith("T"):
            draft.left_out.append("the properties for stresses are left out")
        elif entry[:1] not in APPEARANCE:
            raise draft.refusal(f"the entry '{entry[:20]}' is unknown: a newer version of PMKS+ wrote it")
    further = [joint.id for joint in document.joints if joint.further]
    if further:
        fields = "friction, names and the like, which newer versions of PMKS+ write for joints"
        draft.left_out.append(f"{fields}, are left out: {', '.join(further[:10])}")


def _restored(document: PlusDocument, entry: str) -> bool:
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
        return _put(document.decimals if kind == "D" else document.integers, index, value)
    records: dict[str, Sequence[Any]] = {"J": document.joints, "L": document.links, "F": document.forces}
    found = [record for record in records.get(kind, ()) if record.id == own]
    if not found or index >= len(PRECISE[kind]):
        return False
    _set(found[0], PRECISE[kind][index], value)
    return True


def _put(numbers: list[float], index: int, value: float) -> bool:
    if index >= len(numbers):
        return False
    numbers[index] = value
    return True


def _set(record: Any, path: str, value: float) -> None:
    """Set a number of a record, or one of the two coordinates of a point."""
    name, _, part = path.partition(".")
    old = getattr(record, name)
    new = {"": value, "real": complex(value, old.imag), "imag": complex(old.real, value)}[part]
    setattr(record, name, new)
