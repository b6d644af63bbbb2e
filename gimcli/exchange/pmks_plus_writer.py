"""PMKS+: the drawing of a mechanism, and the address that opens it in PMKS+."""

from __future__ import annotations

import cmath
import math
import re
from collections import defaultdict
from urllib.parse import quote

from gimcli.dynamic_data import NO_NODE, AppliedLoad
from gimcli.exchange.draft import GROUND, DrawnSlot
from gimcli.exchange.drawn_linkage import PIECE, DrawnLinkage, DrawnPose
from gimcli.exchange.pmks_joints import letter
from gimcli.exchange.pmks_plus import CLOCKWISE, GRAVITY, INERTIAS, NO_GRAVITY, POUND, POUND_FORCE, PROGRAM
from gimcli.exchange.pmks_plus_codec import FORCE, JOINT, LINK, THOUSANDTHS, PlusDocument, text_of
from gimcli.exchange.records import Record
from gimcli.mechanism import FRAME
from gimcli.model.units import METRES
from gimcli.structure.mobility import drawn_mobility

SITE = "https://app.pmksplus.com/?"
SAFE = "-_.~*,"
"""Characters that stand in addresses as they are, besides letters and digits."""
UNITS = (0.0254, 1e-2, 1.0)
"""Lengths of the units of PMKS+ [m]: inches, centimetres, metres."""
KILOGRAMS = (POUND, 1e-3, 1.0)
EXACT = 1e-9
"""Largest error of a number that counts as exact, relative to the size of the mechanism."""
SCALE, LINEAR = 0.7, 5.0
"""Settings of PMKS+: the size of its symbols, and the speed of sliding inputs [length/s]."""
FURTHEST = 1e9
"""Largest coordinate; numbers of PMKS+ are exact up to 2^53 thousandths."""


def write(pose: DrawnPose) -> str:
    """Return the address of a mechanism; `pose.left_out` gets sentences about what PMKS+ has not."""
    return SITE + quote(drawing_text(pose), safe=SAFE)


def drawing_text(pose: DrawnPose) -> str:
    """Return the text of a drawing, the part of an address behind the question mark."""
    return text_of(PlusDrawing(DrawnLinkage(pose, PROGRAM)).document)


class PlusDrawing:
    """The document of a drawn linkage."""

    def __init__(self, drawn: DrawnLinkage) -> None:
        self.drawn, self.mechanism = drawn, drawn.mechanism
        self.left_out = drawn.left_out
        self.document = PlusDocument()
        self._unit()
        self.joints: dict[str, Record] = {}
        for name, place in drawn.joints.items():
            self._joint(name, place)
        self._apart()
        for slot in drawn.slots:
            self._slot(slot)
        self.links: dict[str, Record] = {}
        for body in self._ordered():
            if len(drawn.bodies[body]) > 1:
                self._link(body, drawn.bodies[body])
        self._turns()
        self._dynamics()
        self._settings()
        used = {name for joints in drawn.bodies.values() for name in joints}
        ids = {one for link in self.links.values() for one in link.joints}
        shown = [joint for name, joint in self.joints.items() if name in used and (joint.id in ids or joint.slides)]
        self.document.joints = shown  # ground nodes only if a link or a slot needs them
        self.document.links = list(self.links.values())

    # -- units ----------------------------------------------------------------------------------

    def _unit(self) -> None:
        """Choose the unit of length: that of the model if it has all digits, else centimetres or inches."""
        unit = self.mechanism.length_unit
        own = {"in": 0, "ft": 0, "m": 2, "km": 2}.get(unit, 1)
        self.metre = metre = METRES.get(unit, 1e-2)
        furthest = max(max(abs(place.real), abs(place.imag)) for place in self.drawn.joints.values())
        self.drawn.refuse(not furthest * metre / UNITS[own] <= FURTHEST, f"the coordinates are too large for {PROGRAM}")
        if own == 2 and not self._exact(round(metre / UNITS[2], 12)):
            own = 1
        self.unit, self.factor = own, round(metre / UNITS[own], 12)
        if unit == "unit":
            self.left_out.append(f"{PROGRAM} has no lengths without a unit; they are written as centimetres")
        if not self._exact(self.factor):
            shown = ("inches", "centimetres", "metres")[own]
            self.left_out.append(f"{PROGRAM} has three decimals: coordinates are rounded to 0.001 {shown}")
            found = drawn_mobility(self.mechanism)
            if found is not None and found.redundant:
                text = "it moves at its exact dimensions only, and rounded ones may lock it"
                self.left_out.append(f"the mechanism has redundant constraints: {text}")

    def _exact(self, factor: float) -> bool:
        """Return whether thousandths hold all coordinates."""
        numbers = (part for place in self.drawn.joints.values() for part in (place.real, place.imag))
        values = [number * factor * THOUSANDTHS for number in numbers]
        error = max(abs(value - round(value)) for value in values)
        return error / THOUSANDTHS <= EXACT * self.drawn.span * factor

    # -- joints and slots -----------------------------------------------------------------------

    def _joint(self, name: str, place: complex) -> Record:
        own = letter(len(self.joints))
        z = place * self.factor
        fixed, traced = name in self.drawn.bodies[GROUND], name in self.mechanism.traced
        values = {"id": own, "name": _plain(name), "x": z.real, "y": z.imag, "fixed": fixed, "traced": traced}
        self.joints[name] = JOINT.record(PROGRAM, **values)
        return self.joints[name]

    def _added(self, name: str, place: complex, *bodies: str) -> Record:
        """Add a joint that the mechanism has no node for."""
        return self._joint(self.drawn.joint(name, place, *bodies), place)

    def _slot(self, slot: DrawnSlot) -> None:
        """Let a joint slide along a line; a pin that is also something else gets a slider beside it."""
        drawn = self.drawn
        bodies = drawn.common(slot.joint)
        joint = self.joints[slot.joint]
        turned = any(turn.pivot == slot.joint for turn in drawn.turns)
        if joint.slides or joint.fixed or turned or (slot.body and bodies != [slot.body]):
            body = slot.body or bodies[0]
            if body == GROUND:
                body = self._frame(slot.joint, slot.direction)
            beside = PIECE * drawn.span * slot.direction if slot.body not in ("", GROUND) else 0.0
            joint = self._added(f"{slot.joint} slide", drawn.joints[slot.joint] + beside, body)
        elif slot.body and len(drawn.bodies[slot.body]) < 2:
            self._added(f"{slot.joint} end", drawn.joints[slot.joint] + PIECE * drawn.span * slot.direction, slot.body)
        joint.slides, joint.welded = True, bool(slot.body)
        self._line(slot, joint)
        if slot.travel is not None:
            joint.driven, joint.speed = True, drawn.speed(slot.travel) * self.factor

    def _frame(self, joint: str, direction: complex) -> str:
        """Add a bar that is fixed by two pins of the ground, which a moving link slides over; return it."""
        frame = self.drawn.body(f"frame at {joint}", [])
        for end in (direction, -direction):
            pin = self._added(f"{joint} pin", self.drawn.joints[joint] + PIECE * self.drawn.span * end, frame)
            pin.fixed = True
        return frame

    def _line(self, slot: DrawnSlot, joint: Record) -> None:
        """Set the line of a slider: an angle on the ground, or two joints of its carrier."""
        place = complex(joint.x, joint.y) / self.factor
        if slot.stroke is not None:
            ends = self._ends(slot, slot.stroke)
            joint.sealed = True
        elif slot.carrier == GROUND and _written(cmath.phase(slot.direction)):
            joint.fixed, joint.angle = True, cmath.phase(slot.direction)
            return
        else:
            reach = 2.5 * PIECE * self.drawn.span * slot.direction
            ends = self._ends(slot, (place - reach, place + reach))
        joint.fixed = False
        joint.start, joint.end = ends
        joint.carrier = slot.carrier

    def _ends(self, slot: DrawnSlot, places: tuple[complex, complex]) -> list[str]:
        """Return two joints of the carrier along the line; add those that it has not."""
        found = []
        for end, place in zip(("from", "to"), places, strict=True):
            near = [
                name
                for name in self.drawn.bodies[slot.carrier]
                if abs(self.drawn.joints[name] - place) <= EXACT * self.drawn.span and not self.joints[name].slides
            ]
            own = self.joints[near[0]] if near else self._added(f"{slot.joint} {end}", place, slot.carrier)
            found.append(own.id)
        return found

    # -- links and inputs -----------------------------------------------------------------------

    def _link(self, body: str, joints: list[str]) -> None:
        own = "".join(self.joints[name].id for name in joints)
        if own in {link.id for link in self.links.values()}:
            own += str(len(self.links))
        self.links[body] = self._plain_link(own, _plain(body), [self.joints[name] for name in joints])

    def _plain_link(self, own: str, name: str, joints: list[Record]) -> Record:
        """Return a link with its centre of mass in the middle of its joints."""
        centre = sum(complex(joint.x, joint.y) for joint in joints) / len(joints)
        values = {"x": centre.real, "y": centre.imag, "joints": [joint.id for joint in joints]}
        return LINK.record(PROGRAM, id=own, name=name, **values)

    def _turns(self) -> None:
        """Set the turning inputs, and the names of carriers, which are known now."""
        for joint in self.joints.values():
            if joint.carrier:
                joint.carrier = self._carrier(joint)
        for turn in self.drawn.turns:
            joint = self.joints[turn.pivot]
            joint.driven, joint.speed = True, self.drawn.speed(turn.number)

    def _apart(self) -> None:
        """Let the pin of an input join two links only: further links get a pin of their own at its place."""
        for turn in self.drawn.turns:
            further = [b for b in self.drawn.common(turn.pivot) if b not in (turn.body, turn.reference)]
            if further:
                for body in further:
                    self.drawn.bodies[body].remove(turn.pivot)
                pin = self._added(f"{turn.pivot} pin", self.drawn.joints[turn.pivot], turn.reference, *further)
                for other in self.drawn.turns:
                    if other is not turn and other.pivot == turn.pivot and other.body in further:
                        other.pivot = pin.name

    def _ordered(self) -> list[str]:
        """Return the bodies, each input's reference before the body that it turns: PMKS+ takes them in this order."""
        order = [body for body in self.drawn.bodies if body != GROUND]
        for turn in self.drawn.turns:
            if turn.reference != GROUND and order.index(turn.body) < order.index(turn.reference):
                order.remove(turn.body)
                order.insert(order.index(turn.reference) + 1, turn.body)
        return order

    def _carrier(self, joint: Record) -> str:
        if joint.carrier == GROUND:
            ends = [one for end in (joint.start, joint.end) for one in self.joints.values() if one.id == end]
            frame = self._plain_link("".join((joint.start, joint.end)), f"guide of {joint.name}", ends)
            self.links[f"{GROUND} {joint.id}"] = frame
            return frame.id
        return self.links[joint.carrier].id

    # -- masses and forces ----------------------------------------------------------------------

    def _dynamics(self) -> None:
        own = self.mechanism.dynamics
        if own.empty:
            return
        self._masses()
        for load in own.loads:
            self._load(load)
        if own.springs or own.dampers or own.frictions:
            self.left_out.append("springs, dampers and friction are left out")
        if own.inertias and own.gravity and abs(own.gravity + 1j * GRAVITY) > 1e-3 * GRAVITY:
            self.left_out.append(f"{PROGRAM} has a gravity of {GRAVITY:g} m/s^2 downwards, not that of the model")

    def _masses(self) -> None:
        """Set the masses of links; a point mass at a pin belongs to its slider, or to the first of its links."""
        parts: dict[str, list[tuple[float, float, complex]]] = defaultdict(list)
        for inertia in self.mechanism.dynamics.inertias:
            if inertia.node != NO_NODE:
                node = self.mechanism.nodes[inertia.node]
                body = self._link_at(node)
                if self.joints[node].slides:
                    self.joints[node].mass += inertia.mass / KILOGRAMS[self.unit]
                elif body:
                    parts[body].append((inertia.mass, 0.0, self.drawn.joints[node]))
                else:
                    self.left_out.append(f"the mass at {node} is left out: no link has it")
            elif inertia.member != FRAME:
                place = self.drawn.at(inertia.member, inertia.centre)
                parts[self.drawn.names[inertia.member]].append((inertia.mass, inertia.moment, place))
        for body, own in parts.items():
            self._joined(self.links[body], own)

    def _link_at(self, node: str) -> str:
        found = [body for body in self.drawn.common(node) if body in self.links]
        return found[0] if found else ""

    def _joined(self, link: Record, parts: list[tuple[float, float, complex]]) -> None:
        """Set the mass of a link, its centre and its moment of inertia, from those of its parts (Steiner)."""
        mass = sum(part[0] for part in parts)
        if not mass:
            return
        centre = sum(part[0] * part[2] for part in parts) / mass
        moment = sum(own + m * abs((place - centre) * self.metre) ** 2 for m, own, place in parts)
        link.mass, link.inertia = mass / KILOGRAMS[self.unit], moment / INERTIAS[self.unit]
        link.x, link.y = centre.real * self.factor, centre.imag * self.factor

    def _load(self, load: AppliedLoad) -> None:
        if load.member == FRAME:
            return
        if load.node != NO_NODE:
            node = self.mechanism.nodes[load.node]
            body, place, turned = self._link_at(node), self.drawn.joints[node], 1.0 + 0.0j
        else:
            body, place = self.drawn.names[load.member], self.drawn.at(load.member, load.point)
            turned = self.drawn.turned[load.member] if load.follows else 1.0 + 0.0j
        notes = {
            "no link has its node": not body, "it is a torque": load.torque, "it has a table": load.curve is not None,
        }  # fmt: skip
        note = next((text for text, holds in notes.items() if holds), "")
        if note:
            self.left_out.append(f"the load {load.name} is left out: {note}")
            return
        force = load.force * turned
        size = abs(force) / (POUND_FORCE if self.unit == 0 else 1.0)
        if size:
            start = place * self.factor
            end = start + force / abs(force) * PIECE * self.drawn.span * self.factor
            places = {"x": start.real, "y": start.imag, "x1": end.real, "y1": end.imag}
            own, link, name = f"F{len(self.document.forces) + 1}", self.links[body].id, _plain(load.name)
            flags = {"local": load.follows, "outward": True}
            self.document.forces.append(
                FORCE.record(PROGRAM, id=own, link=link, name=name, size=size, **places, **flags)
            )

    def _settings(self) -> None:
        self.drawn.note_laws(cylinders=True)
        speeds = [joint.speed for joint in self.joints.values() if joint.driven and not joint.slides]
        first = speeds[0] if speeds else 10.0
        flags = self.document.flags
        flags[CLOCKWISE] = first < 0.0
        flags[3] = flags[4] = flags[7] = True  # the grid and the forces are shown
        flags[NO_GRAVITY] = bool(self.mechanism.dynamics.inertias) and not self.mechanism.dynamics.gravity
        force, system = (0, 0) if self.unit == 0 else (1, self.unit)
        self.document.decimals = [SCALE, LINEAR]
        self.document.integers = [float(round(abs(first))), 0.0]
        self.document.enums = [self.unit, 0 if self.mechanism.angle_unit == "deg" else 1, force, system]


def _plain(name: str) -> str:
    """Return a name without the characters that separate fields and records."""
    return re.sub(r"[,.*~?#&%+]+", "_", name)


def _written(angle: float) -> bool:
    """Return whether thousandths hold an angle [rad]."""
    return abs(angle * THOUSANDTHS - round(angle * THOUSANDTHS)) <= EXACT * math.pi
