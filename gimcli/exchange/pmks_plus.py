"""PMKS+: its addresses (2023 and later) and its `.pmks` files, which hold an address or the part behind the `?`.

Source: PMKS+ (2023-2026), its classes StringTranscoder and MechanismBuilder.
"""

from __future__ import annotations

import cmath
import math
import re
from urllib.parse import unquote

from gimcli.errors import ModelError
from gimcli.exchange.draft import BARREL, GROUND, STROKE, Draft, free_name
from gimcli.exchange.pmks_joints import NO_SPEED
from gimcli.exchange.pmks_plus_codec import HEAD, PlusDocument, document_of, restored
from gimcli.exchange.pmks_plus_links import PlusStructure
from gimcli.exchange.records import Part, Record

PROGRAM = "PMKS+"
ADDRESS = re.compile(r"https?://[^\s?]*pmks[^\s?]*\?", re.IGNORECASE)
NEWER = "pmks2:"

CLOCKWISE, NO_GRAVITY = 0, 8
"""Flags of the settings."""
LENGTHS, MASSES = ("in", "cm", "m"), ("lb", "g", "kg")
POUND, INCH, GRAVITY, POUND_FORCE = 0.45359237, 0.0254, 9.80665, 4.4482216152605
INERTIAS = (POUND * INCH**2, 1e-4, 1.0)
"""Units by the setting of lengths, the moment of inertia in kg m^2; those of forces follow from it, too."""
LINEAR_SPEED = 5.0
"""Speed of sliding inputs in drawings that have none [length/s]."""
RESOLUTION = 1e-3
HALF = 0.5 * RESOLUTION

APPEARANCE = ("J", "L", "F", "C", "S", "H", "K")
"""First letters of entries that no motion depends on: locks, anchors, synthesis designs, held values and colours."""


def recognises(text: str) -> bool:
    """Return whether a text is an address or a file of PMKS+, be it damaged or not."""
    own = text.strip()
    return bool(ADDRESS.match(own) or HEAD.match(own) or own.startswith(NEWER))


def read(text: str, source: str) -> Draft:
    """Return the mechanism of an address or a file.

    Raises ModelError for a damaged text, and for gears and entries of newer versions.
    """
    payload = payload_of(text)
    newer = f"documents `{NEWER}` of newer PMKS+ versions are not read; share it as an address"
    Part(source).refuse(payload.startswith(NEWER), newer)
    try:
        document = document_of(unquote(payload), source)
    except ModelError:
        if unquote(payload) == payload:
            raise
        document = document_of(payload, source)  # a name with a percent sign
    return PlusDraft(document, source).draft


def payload_of(text: str) -> str:
    """Return the part of an address behind the question mark, or the whole of another text."""
    own = text.strip()
    found = ADDRESS.match(own)
    return own[found.end() :].split("#")[0] if found else own


class PlusDraft:
    """The mechanism of a document."""

    def __init__(self, document: PlusDocument, source: str) -> None:
        self.document = document
        self.draft = Draft(PROGRAM, source, resolution=RESOLUTION)
        apply_entries(document, self.draft)
        self.draft.refuse_many(sum(len(link.joints) + len(link.parts) for link in document.links))
        self.structure = PlusStructure(document)
        self.sense = -1.0 if document.flags[CLOCKWISE] else 1.0
        self._units()
        self._joints()
        self._sliders()
        self._masses()
        self._forces()
        self._inputs()

    # -- units ----------------------------------------------------------------------------------

    def _units(self) -> None:
        enums = [*self.document.enums, 0, 0, 0]
        self.draft.refuse(
            not 0 <= enums[0] < len(LENGTHS), "the unit of length is unknown: a newer version of PMKS+ wrote it"
        )
        self.unit = enums[0]
        self.draft.length, self.draft.mass = LENGTHS[self.unit], MASSES[self.unit]
        self.newton = POUND_FORCE if self.unit == 0 else 1.0
        if self.document.forces and self.unit > 0 and enums[2] > 1:
            self.draft.left_out.append("the unit of forces is not newtons or pounds; their numbers are read as newtons")

    # -- joints, bodies and slots ---------------------------------------------------------------

    def _joints(self) -> None:
        joints, links = self.structure.joints.items(), self.structure.links
        pinned = {own: [GROUND] if joint.fixed and not joint.slides else [] for own, joint in joints}
        self.names = {own: self.draft.joint(joint.name or own, self._place(own), *pinned[own]) for own, joint in joints}
        self.draft.traced = [self.names[own] for own, joint in joints if joint.traced]
        self.bodies = {
            own: self.draft.body(links[own].name or own, [self.names[joint] for joint in joints])
            for own, joints in self.structure.bodies.items()
        }

    def _sliders(self) -> None:
        """Add the slots: on the ground at an angle, or on a body along two of its joints."""
        self.slots: dict[str, str] = {}
        for own, joint in self.structure.joints.items():
            riders = self.structure.riders(joint) if joint.slides else []
            if not riders:
                continue
            carrier, guide, direction = self._line(joint)
            joint.refuse(carrier in (self.bodies[rider] for rider in riders), "it slides along its own link")
            self.slots[own] = slot = free_name(f"slide_{self.names[own]}", self.slots.values())
            blocks = [self.bodies[rider] for rider in riders] if joint.welded or joint.sealed else [""]
            for number, body in enumerate(blocks):
                name = f"{slot}_{number + 1}" if number else slot
                self.draft.slot(name, self.names[own], carrier, direction, body=body, guide=guide)

    def _line(self, joint: Record) -> tuple[str, tuple[str, str] | None, complex]:
        """Return the carrier of a slot, the two joints that it passes through, and its direction."""
        if not joint.carrier:
            return GROUND, None, cmath.rect(1.0, _whole_degrees(joint.angle))
        a, b = self.structure.slot(joint)
        carrier = self.structure.body_of.get(joint.carrier, "")
        outside = not {a, b} <= set(self.structure.bodies.get(carrier, ()))
        joint.refuse(outside, f"the joints of its slot are not on link {joint.carrier}")
        along = self._place(b) - self._place(a)
        joint.refuse(abs(along) <= RESOLUTION, "its slot has no length")
        return self.bodies[carrier], (self.names[a], self.names[b]), along

    def _place(self, own: str) -> complex:
        joint = self.structure.joints[own]
        return complex(joint.x, joint.y)

    # -- masses and forces ----------------------------------------------------------------------

    def _masses(self) -> None:
        for own, body in self.bodies.items():
            link = self.structure.links[own]
            if link.mass > 0.0:
                inertia = max(link.inertia, 0.0) * INERTIAS[self.unit]
                self.draft.masses.append(
                    (body, {"mass": link.mass, "inertia": inertia, "centre": complex(link.x, link.y)})
                )
        for own, joint in self.structure.joints.items():
            if joint.mass > 0.0 and own in self.slots:
                block = self.draft.body(f"block_{self.names[own]}", [self.names[own]])
                self.draft.masses.append((block, {"mass": joint.mass}))
        if self.draft.masses and not self.document.flags[NO_GRAVITY]:
            self.draft.gravity = complex(0.0, -GRAVITY)

    def _forces(self) -> None:
        for force in self.document.forces:
            force.refuse(force.link not in self.structure.body_of, f"its link {force.link} is missing")
            along = complex(force.x1, force.y1) - complex(force.x, force.y)
            if force.size:
                force.refuse(not along, "it has no direction")
                size = force.size * self.newton * (1.0 if force.outward else -1.0)
                name, key = free_name(force.name or force.id, self.draft.loads), "follower" if force.local else "force"
                body, at = self.bodies[self.structure.body_of[force.link]], complex(force.x, force.y)
                self.draft.loads[name] = {"on": body, "at": at, key: size * along / abs(along)}

    # -- inputs ---------------------------------------------------------------------------------

    def _inputs(self) -> None:
        """Add the inputs: all move for one time, a revolution of the fastest or the shortest stroke."""
        driven = {own: joint for own, joint in self.structure.joints.items() if joint.driven}
        if not driven:
            self.draft.suggest_input()
        rate = self.sense * (self.document.integers[0] if self.document.integers else 0)
        turns = {own: joint.speed or rate for own, joint in driven.items() if not joint.slides}
        travels = {own: self._travel(joint) for own, joint in driven.items() if own in self.slots}
        times = [abs(stroke / speed) for stroke, speed in travels.values()]
        fastest = max(map(abs, turns.values()), default=0.0)
        duration = min(times) if times else 60.0 / fastest if fastest else None
        if turns and duration is None:
            self.draft.left_out.append(NO_SPEED)
        single = len(turns) + len(travels) == 1
        for own, rpm in turns.items():
            by = 360.0 if duration is None else 6.0 * rpm * duration
            self._turn("motor" if single else f"motor_{self.names[own]}", own, by)
        for own, (stroke, speed) in travels.items():
            by = math.copysign(abs(speed) * min(times), stroke)
            self.draft.travel("drive" if single else f"drive_{self.names[own]}", slot=self.slots[own], law={"by": by})
        self.draft.duration = duration

    def _travel(self, joint: Record) -> tuple[float, float]:
        """Return the stroke of a sliding input, to the end of its slot, and its speed."""
        drawing = self.document.decimals[1] if len(self.document.decimals) > 1 else 0.0
        speed = joint.speed or self.sense * (drawing if drawing > 0.0 else LINEAR_SPEED)
        if joint.carrier:
            a, b = (self._place(own) for own in self.structure.slot(joint))
            at = ((complex(joint.x, joint.y) - a) / (b - a)).real * abs(b - a)
            ends = (abs(b - a) - at, -at * (BARREL if joint.sealed else 1.0))  # ahead and behind
            stroke, other = ends if speed > 0.0 else ends[::-1]
            if abs(stroke) <= RESOLUTION:  # it stands at the end: back
                stroke = other
        else:
            stroke = math.copysign(STROKE * self.draft.size(), speed)
        if joint.sealed or not joint.carrier:
            part, shown = ("cylinder", stroke) if joint.carrier else ("input", abs(stroke))
            text = f"the stroke of the {part} at joint {joint.name or joint.id} is not in the file"
            self.draft.left_out.append(f"{text}; the law moves it by {shown:.3g}")
        return stroke or RESOLUTION, speed

    def _turn(self, name: str, own: str, by: float) -> None:
        joint = self.structure.joints[own]
        moving = [self.bodies[body] for body in self.structure.riders(joint) if self.structure.moving(body)]
        sides = [GROUND, *moving] if joint.fixed else moving
        expected = "one link on the ground, or two moving links"
        joint.refuse(len(sides) != 2, f"the input joins {len(moving)} links; expected {expected}")
        self.draft.rotary(name, self.names[own], sides[1], sides[0], law={"by": by})


def _whole_degrees(angle: float) -> float:
    """Return an angle [rad]; that of whole degrees if the file's digits cannot distinguish it from them."""
    whole = math.radians(round(math.degrees(angle)))
    return whole if abs(whole - angle) <= HALF else angle


def apply_entries(document: PlusDocument, draft: Draft) -> None:
    """Apply the entries to the records that they name; refuse those that the motion may depend on."""
    for entry in document.entries:
        kind, named = entry[:1], f"the entry '{entry[:20]}'"
        faults = {
            "the gears of the drawing cannot be converted; add them to the model file as `gears`": kind == "G",
            f"{named} is damaged; copy the whole address or file again": kind == "P" and not restored(document, entry),
            f"{named} is unknown: a newer version of PMKS+ wrote it": kind not in (*APPEARANCE, "G", "P", "T"),
        }
        for fault, holds in faults.items():
            draft.refuse(holds, fault)
        if kind == "T":
            draft.left_out.append("the properties for stresses are left out")
    further = [joint.id for joint in document.joints if any(joint.rest)]
    if further:
        fields = "friction, names and the like, which newer versions of PMKS+ write for joints"
        draft.left_out.append(f"{fields}, are left out: {', '.join(further[:10])}")
