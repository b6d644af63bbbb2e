"""PMKS: its JSON files (`.pmks`, 2019), with the joints, the driver and the speed of the input.

Source: M. I. Campbell, PMKS file format version 1.0 (2019), and the reader of the PMKS library: angles of slots are in
radians, the speed of the input is in revolutions per minute or lengths per second.
"""

from __future__ import annotations

import math
from typing import Any

from gimcli.exchange.draft import Draft, DrawnJoint
from gimcli.exchange.json_parts import read_json
from gimcli.exchange.pmks_joints import TYPES, draft_of_joints
from gimcli.exchange.refusing import FilePlace


def recognises(text: str) -> bool:
    """Return whether a text is probably such a file, be it damaged or not."""
    return text.lstrip().startswith("{") and ('"TypeOfJoint"' in text or '"Joints"' in text)


def read(text: str, source: str) -> Draft:
    """Return the mechanism of a JSON file; raise ModelError with all errors."""
    data = read_json(text, source).value
    entries: Any = data.get("Joints") if isinstance(data, dict) else None
    FilePlace(source).refuse(not isinstance(entries, list), "Joints: expected a list of joints")
    driver, name = data.get("DrivingIndex"), data.get("Name")
    joints = [_joint(entry, f"{source}: Joints.{number}") for number, entry in enumerate(entries)]
    speed = _number(data.get("InputSpeed"))
    left_out = ["the target shape is left out"] if data.get("TargetShape") else []
    return draft_of_joints(
        joints, source, name if isinstance(name, str) else "", speed if math.isfinite(speed) else None,
        driver if isinstance(driver, int) else None, left_out,
    )  # fmt: skip


def _number(value: Any) -> float:
    """Return a finite number; nan for any other value."""
    good = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 1e300
    return float(value) if good else math.nan


def _joint(entry: Any, where: str) -> DrawnJoint | str:
    """Return a joint, or the fault of an entry that is none."""
    own = entry if isinstance(entry, dict) else {}
    x, y, angle = (_number(own.get(key)) for key in ("X", "Y", "Angle"))
    kind: Any = own.get("TypeOfJoint")
    links: Any = own.get("Links")
    named = isinstance(links, list) and all(isinstance(link, str) and link.strip() for link in links)
    faults = {
        ": expected a joint with the keys X, Y, TypeOfJoint and Links": not isinstance(entry, dict),
        ": expected finite numbers X and Y": math.isnan(x) or math.isnan(y),
        f".TypeOfJoint: expected R, P or RP, got '{kind}'": not isinstance(kind, str) or kind.upper() not in TYPES,
        ".Links: expected a list of names": not named,
    }
    fault = next((text for text, holds in faults.items() if holds), "")
    if fault:
        return where + fault
    names = tuple(link.strip() for link in links)
    slope = 0.0 if math.isnan(angle) else angle
    return DrawnJoint(names, kind.upper(), complex(x, y), slope, where, own.get("PositionVisible") is True)
