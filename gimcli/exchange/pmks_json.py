"""PMKS: its JSON files (`.pmks`, 2019), with the joints, the driver and the speed of the input.

Source: M. I. Campbell, PMKS file format version 1.0 (2019), and the reader of the PMKS library: angles of slots are in
radians, the speed of the input is in revolutions per minute or lengths per second.
"""

from __future__ import annotations

from gimcli.exchange.draft import Draft, DrawnJoint
from gimcli.exchange.pmks_joints import TYPES, draft_of_joints, drawn_joint
from gimcli.exchange.records import FileRecord, all_of, number_of, read as read_part, read_json

JOINT = {"X": float, "Y": float, "Angle": (object,), "TypeOfJoint": str, "Links": [str], "PositionVisible": False}
FILE = {"Joints": [JOINT], "Name": "", "DrivingIndex": (int,), "InputSpeed": (float,), "TargetShape": (object,)}


def recognises(text: str) -> bool:
    """Return whether a text is probably such a file, be it damaged or not."""
    return text.lstrip().startswith("{") and ('"TypeOfJoint"' in text or '"Joints"' in text)


def read(text: str, source: str) -> Draft:
    """Return the mechanism of a JSON file; raise ModelError with all errors."""
    own = read_part(FILE, read_json(text, source))
    joints = all_of(_joint, own.Joints)
    return draft_of_joints(joints, source, own.Name, number_of(str(own.InputSpeed)), own.DrivingIndex, own.TargetShape)


def _joint(own: FileRecord) -> DrawnJoint:
    kind, angle = own.TypeOfJoint.upper(), number_of(str(own.Angle))  # joints without a slot have NaN
    own.at("TypeOfJoint").refuse(kind not in TYPES, f"expected R, P or RP, got '{kind[:40]}'")
    return drawn_joint(kind, own.Links, own.X, own.Y, angle, own.own, traced=own.PositionVisible)
