"""PMKS: its JSON files (`.pmks`, 2019), with the joints, the driver and the speed of the input.

Source: M. I. Campbell, PMKS file format version 1.0 (2019), and the reader of the PMKS library: angles of slots are in
radians, the speed of the input is in revolutions per minute or lengths per second.
"""

from __future__ import annotations

import math
from typing import Any

from gimcli.errors import ModelError
from gimcli.exchange.draft import Draft, DrawnJoint
from gimcli.exchange.json_parts import read_json
from gimcli.exchange.pmks_joints import TYPES, draft_of_joints


def recognises(text: str) -> bool:
    """Return whether a text is probably such a file, be it damaged or not."""
    return text.lstrip().startswith("{") and ('"TypeOfJoint"' in text or '"Joints"' in text)


def read(text: str, source: str) -> Draft:
    """Return the mechanism of a JSON file; raise ModelError with all errors."""
    data = read_json(text, source).value
    entries = data.get("Joints") if isinstance(data, dict) else None
    if not isinstance(entries, list):
        raise ModelError([f"{source}: Joints: expected a list of joints"])
    driver, name = data.get("DrivingIndex"), data.get("Name")
    joints = [_joint(entry, f"{source}: Joints.{number}") for number, entry in enumerate(entries)]
    left_out = ["the target shape is left out"] if data.get("TargetShape") else []
    return draft_of_joints(
        joints, source, name if isinstance(name, str) else "", _number(data.get("InputSpeed")),
        driver if isinstance(driver, int) else None, left_out,
    )  # fmt: skip


def _number(value: Any) -> float | None:
    """Return a finite number; None for any other value."""
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > 1e300:
        return None
    return float(value) if math.isfinite(value) else None


def _joint(entry: Any, where: str) -> DrawnJoint | str:
    """Return a joint, or the fault of an entry that is none."""
    if not isinstance(entry, dict):
        return f"{where}: expected a joint with the keys X, Y, TypeOfJoint and Links"
    x, y, angle = (_number(entry.get(key)) for key in ("X", "Y", "Angle"))
    if x is None or y is None:
        return f"{where}: expected finite numbers X and Y"
    kind = entry.get("TypeOfJoint")
    if not isinstance(kind, str) or kind.upper() not in TYPES:
        return f"{where}.TypeOfJoint: expected R, P or RP, got '{kind}'"
    links = entry.get("Links")
    if not isinstance(links, list) or not all(isinstance(link, str) and link.strip() for link in links):
        return f"{where}.Links: expected a list of names"
    traced = entry.get("PositionVisible") is True
    names = tuple(link.strip() for link in links)
    return DrawnJoint(names, kind.upper(), complex(x, y), angle or 0.0, where, traced)
