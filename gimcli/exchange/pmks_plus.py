"""PMKS+: its addresses (2023 and later) and its `.pmks` files, which hold an address or the part behind the `?`.

Source: PMKS+ (2023-2026), its classes StringTranscoder and MechanismBuilder.
"""

from __future__ import annotations

import cmath
import math
import re
from urllib.parse import unquote

from gimcli.errors import ModelError
from gimcli.exchange.draft import BARREL, GROUND, MOST, STROKE, Draft, free_name
from gimcli.exchange.pmks import NO_SPEED
from gimcli.exchange.pmks_plus_codec import HEAD, PlusDocument, document_of, restored
from gimcli.exchange.records import FilePart, FileRecord, by_key

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

AGAIN = "is missing; copy the whole address again"
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
    FilePart(source).refuse(payload.startswith(NEWER), newer)
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
    """The mechanism of a document: its joints and bodies, and all links by their ids; welded bars are one body.

    Older versions of PMKS+ write a slider as three objects: a slider, a pin at the same place, and a block that joins
    them. They become the slider, with the name of the pin, as newer versions write it.

    Further values of a joint: its name in the draft (`named`), its `place`, its bodies (`riders`), and the body and the
    two joints of its slot (`slotted`, None on the ground). Those of a link: its `named`, and its `body`, the link that
    it is welded into, which may be itself; None for blocks.
    """

    def __init__(self, document: PlusDocument, source: str) -> None:
        self.document = document
        self.draft = Draft(PROGRAM, source, resolution=RESOLUTION)
        lists = (document.joints, document.links, document.forces)
        many = f"more than {MOST} joints, links or forces are too many for one mechanism"
        self.draft.refuse(max(map(len, lists)) > MOST, many)
        apply_entries(document, self.draft)
        self._structure()
        self.sense = -1.0 if document.flags[CLOCKWISE] else 1.0
        self._units()
        self._joints()
        for joint in self.joints:
            joint.slot = self._slot(joint) if joint.slides and joint.riders else ""
        self._masses()
        for force in document.forces:
            self._force(force)
        self._inputs()

    def _structure(self) -> None:
        """Find the joints and the bodies."""
        known, self.links = by_key("id", self.document.joints, "joint"), by_key("id", self.document.links, "link")
        for link in self.document.links:
            missing = [*(name for name in link.joints if name not in known),
                       *(name for name in link.parts if name not in self.links)]  # fmt: skip
            link.refuse(missing or not link.joints, f"'{', '.join(missing)}' {AGAIN}")
            link.body = None
        for joint in self.document.joints:
            slot = {joint.start, joint.end}
            joint.check({
                f"the link of its slot {AGAIN}": joint.carrier and joint.carrier not in self.links,
                f"a joint of its slot {AGAIN}": joint.carrier and not slot <= known.keys(),
                "the cylinder has no barrel": joint.slides and joint.sealed and not (joint.fixed or joint.carrier),
            })  # fmt: skip
        for link in self.document.links:
            if link.block:
                slider, pin = _folded(link, [known[name] for name in link.joints])
                known.update({slider.id: pin, pin.id: pin})
        self.bodies = [link for link in self.document.links if link.root and not link.block]
        for link in self.bodies:
            link.joints = list(dict.fromkeys(known[name] for name in link.joints))
            self._claim(link)
        self.joints = [joint for name, joint in known.items() if joint.id == name]
        for joint in self.joints:
            joint.place = complex(joint.x, joint.y)
            joint.riders = [link for link in self.bodies if joint in link.joints]
            ends = (known.get(joint.start), known.get(joint.end))
            joint.slotted = (self.links[joint.carrier].body, *ends) if joint.carrier else None

    def _claim(self, root: FileRecord) -> None:
        """Note the body of its own link and of all bars that are welded into it."""
        open_ends = [root]
        for link in open_ends:
            twice = link.body or (link is not root and link.root)
            link.refuse(twice, "it belongs to two welded links; copy the whole address or file again")
            link.body = root
            open_ends += [self.links[part] for part in link.parts]

    def _units(self) -> None:
        self.unit, _, force, *_ = *self.document.enums, 0, 0, 0
        known = self.unit in range(len(LENGTHS))
        self.draft.refuse(not known, "the unit of length is unknown: a newer version of PMKS+ wrote it")
        self.draft.length, self.draft.mass = LENGTHS[self.unit], MASSES[self.unit]
        other = self.document.forces and self.unit > 0 and force > 1
        self.draft.note(other, "the unit of forces is not newtons or pounds; their numbers are read as newtons")

    # -- joints, bodies and slots ---------------------------------------------------------------

    def _joints(self) -> None:
        for joint in self.joints:
            pinned = [GROUND] * (joint.fixed and not joint.slides)
            joint.named = self.draft.joint(joint.name or joint.id, joint.place, *pinned)
        self.draft.traced = [joint.named for joint in self.joints if joint.traced]
        for link in self.bodies:
            link.named = self.draft.body(link.name or link.id, [joint.named for joint in link.joints])

    def _slot(self, joint: FileRecord) -> str:
        """Add the slot of a joint, on the ground at an angle, or on a body along two of its joints; return its name."""
        carrier, guide, direction = GROUND, None, cmath.rect(1.0, _whole_degrees(joint.angle))
        if joint.slotted:
            body, a, b = joint.slotted
            outside = body is None or a not in body.joints or b not in body.joints
            joint.refuse(outside, f"the joints of its slot are not on link {joint.carrier}")
            carrier, guide, direction = body.named, (a.named, b.named), b.place - a.place
            joint.refuse(abs(direction) <= RESOLUTION, "its slot has no length")
        riders = [rider.named for rider in joint.riders]
        joint.refuse(carrier in riders, "it slides along its own link")
        slot = free_name(f"slide_{joint.named}", [own.name for own in self.draft.slots])
        for number, body in enumerate(riders if joint.welded or joint.sealed else [""]):
            name = f"{slot}_{number + 1}" if number else slot
            self.draft.slot(name, joint.named, carrier, direction, body, guide=guide)
        return slot

    # -- masses and forces ----------------------------------------------------------------------

    def _masses(self) -> None:
        masses = self.draft.masses
        for link in self.bodies:
            mass = {"inertia": max(link.inertia, 0.0) * INERTIAS[self.unit], "centre": complex(link.x, link.y)}
            masses += [(link.named, {"mass": link.mass, **mass})] if link.mass > 0.0 else []
        for joint in self.joints:
            if joint.mass > 0.0 and joint.slot:
                masses.append((self.draft.body(f"block_{joint.named}", [joint.named]), {"mass": joint.mass}))
        if masses and not self.document.flags[NO_GRAVITY]:
            self.draft.gravity = complex(0.0, -GRAVITY)

    def _force(self, force: FileRecord) -> None:
        link = self.links.get(force.link)
        body = link.body if link else None
        if body is None:
            raise force.refused(f"its link {force.link} is missing")
        start = complex(force.x, force.y)
        along = complex(force.x1, force.y1) - start
        if force.size:
            force.refuse(not along, "it has no direction")
            size = force.size * (POUND_FORCE if self.unit == 0 else 1.0) * (1.0 if force.outward else -1.0)
            name, key = free_name(force.name or force.id, self.draft.loads), "follower" if force.local else "force"
            self.draft.loads[name] = {"on": body.named, "at": start, key: size * along / abs(along)}

    # -- inputs ---------------------------------------------------------------------------------

    def _inputs(self) -> None:
        """Add the inputs: all move for one time, a revolution of the fastest or the shortest stroke."""
        driven = [joint for joint in self.joints if joint.driven]
        if not driven:
            self.draft.suggest_input()
        rate = self.sense * (self.document.integers[0] if self.document.integers else 0)
        turns = [(joint, joint.speed or rate) for joint in driven if not joint.slides]
        travels = [(joint, *self._stroke(joint)) for joint in driven if joint.slot]
        times = [abs(stroke / speed) for _, stroke, speed in travels]
        fastest = max((abs(rpm) for _, rpm in turns), default=0.0)
        duration = min(times) if times else 60.0 / fastest if fastest else None
        self.draft.note(turns and duration is None, NO_SPEED)
        single = len(turns) + len(travels) == 1
        for joint, rpm in turns:
            by = 360.0 if duration is None else 6.0 * rpm * duration
            self._turn("motor" if single else f"motor_{joint.named}", joint, by)
        for joint, stroke, speed in travels:
            by = math.copysign(abs(speed) * min(times), stroke)
            self.draft.travel("drive" if single else f"drive_{joint.named}", slot=joint.slot, law={"by": by})
        self.draft.duration = duration

    def _stroke(self, joint: FileRecord) -> tuple[float, float]:
        """Return the stroke of a sliding input, to the end of its slot, and its speed."""
        drawing = self.document.decimals[1] if len(self.document.decimals) > 1 else 0.0
        speed = joint.speed or self.sense * (drawing if drawing > 0.0 else LINEAR_SPEED)
        stroke = math.copysign(STROKE * self.draft.size(), speed)
        if joint.slotted:
            _, a, b = joint.slotted
            length = abs(b.place - a.place)
            at = ((joint.place - a.place) / (b.place - a.place)).real * length
            ends = (length - at, -at * (BARREL if joint.sealed else 1.0))  # ahead and behind
            stroke, other = ends if speed > 0.0 else ends[::-1]
            stroke = other if abs(stroke) <= RESOLUTION else stroke  # it stands at the end: back
        part, shown = ("cylinder", stroke) if joint.carrier else ("input", abs(stroke))
        text = f"the stroke of the {part} at joint {joint.name or joint.id} is not in the file"
        self.draft.note(joint.sealed or not joint.carrier, f"{text}; the law moves it by {shown:.3g}")
        return stroke or RESOLUTION, speed

    def _turn(self, name: str, joint: FileRecord, by: float) -> None:
        links = [rider.named for rider in joint.riders if any(own.slides or not own.fixed for own in rider.joints)]
        sides = [GROUND, *links] if joint.fixed else links
        expected = "one link on the ground, or two moving links"
        joint.refuse(len(sides) != 2, f"the input joins {len(links)} links; expected {expected}")
        self.draft.rotary(name, joint.named, sides[1], sides[0], law={"by": by})


def _whole_degrees(angle: float) -> float:
    """Return an angle [rad]; that of whole degrees if the file's digits cannot distinguish it from them."""
    whole = math.radians(round(math.degrees(angle)))
    return whole if abs(whole - angle) <= HALF else angle


def apply_entries(document: PlusDocument, draft: Draft) -> None:
    """Apply the entries to the records that they name; refuse those that the motion may depend on."""
    for entry in document.entries:
        kind, named = entry[:1], f"the entry '{entry[:20]}'"
        draft.check({
            "the gears of the drawing cannot be converted; add them to the model file as `gears`": kind == "G",
            f"{named} is damaged; copy the whole address or file again": kind == "P" and not restored(document, entry),
            f"{named} is unknown: a newer version of PMKS+ wrote it": kind not in (*APPEARANCE, "G", "P", "T"),
        })  # fmt: skip
        draft.note(kind == "T", "the properties for stresses are left out")
    further = [joint.id for joint in document.joints if any(joint.rest)]
    fields = "friction, names and the like, which newer versions of PMKS+ write for joints"
    draft.note(further, f"{fields}, are left out: {', '.join(further[:10])}")


def _folded(block: FileRecord, ends: list[FileRecord]) -> tuple[FileRecord, FileRecord]:
    """Let the slider and the pin that a block joins be one joint, the pin; return both."""
    ends.sort(key=lambda joint: not joint.slides)
    good = [joint.slides for joint in ends] == [True, False]
    block.refuse(not good, "expected a block with a slider and a pin")
    slider, pin = ends
    for key in ("x", "y", "angle", "carrier", "start", "end", "slides", "sealed"):
        setattr(pin, key, getattr(slider, key))
    pin.fixed = slider.fixed or (pin.fixed and not slider.carrier)
    pin.driven, pin.traced = slider.driven or pin.driven, slider.traced or pin.traced
    pin.speed, pin.mass = slider.speed or pin.speed, block.mass
    return slider, pin
