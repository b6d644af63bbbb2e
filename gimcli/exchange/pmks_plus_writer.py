"""PMKS+: the drawing of a mechanism, as the content of a file or as the address that opens it in PMKS+."""

from __future__ import annotations

import cmath
import math
import re
from urllib.parse import quote

from gimcli.connected import grouped
from gimcli.dynamic_data import NO_NODE, AppliedLoad
from gimcli.exchange.draft import GROUND, DrawnJoint
from gimcli.exchange.drawn_linkage import PIECE, DrawnLinkage
from gimcli.exchange.pmks import letter
from gimcli.exchange.pmks_plus import CLOCKWISE, GRAVITY, INERTIAS, NO_GRAVITY, POUND, POUND_FORCE, PROGRAM
from gimcli.exchange.pmks_plus_codec import FORCE, JOINT, LINK, THOUSANDTHS, PlusDocument, text_of
from gimcli.exchange.records import FileRecord
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
SHOWN = {3: True, 4: True, 7: True}
"""Flags of the settings: the grid and the forces are shown."""
FURTHEST = 1e9
"""Largest coordinate; numbers of PMKS+ are exact up to 2^53 thousandths."""


def write(drawn: DrawnLinkage) -> str:
    """Return the content of a file; `left_out` gets sentences about what PMKS+ has not."""
    return text_of(PlusDrawing(drawn).document) + "\n"


def address(drawn: DrawnLinkage) -> str:
    """Return the address of a mechanism, with the content of its file behind the question mark."""
    return SITE + quote(write(drawn).strip(), safe=SAFE)


class PlusDrawing:
    """The document of a drawn linkage."""

    def __init__(self, drawn: DrawnLinkage) -> None:
        self.drawn, self.mechanism = drawn, drawn.mechanism
        self.document = PlusDocument()
        self._unit()
        self.joints: dict[str, FileRecord] = {}
        for name in drawn.joints:
            self._joint(name)
        self._apart()
        for slot in drawn.slots:
            self._slot(slot)
        self.links: dict[str, FileRecord] = {}
        for body in self._ordered():
            if len(drawn.bodies[body]) > 1:
                self._link(body, _plain(body), [self.joints[name] for name in drawn.bodies[body]])
        self._inputs()
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
        unit, drawn = self.mechanism.length_unit, self.drawn
        own = {"in": 0, "ft": 0, "m": 2, "km": 2}.get(unit, 1)
        self.metre = metre = METRES.get(unit, 1e-2)
        furthest = max(abs(part) for place in drawn.joints.values() for part in place)
        drawn.refuse(not furthest * metre / UNITS[own] <= FURTHEST, f"the coordinates are too large for {PROGRAM}")
        own = 1 if own == 2 and not self._exact(round(metre / UNITS[2], 12)) else own
        self.unit, self.factor = own, round(metre / UNITS[own], 12)
        drawn.note(unit == "unit", f"{PROGRAM} has no lengths without a unit; they are written as centimetres")
        if not self._exact(self.factor):
            shown = ("inches", "centimetres", "metres")[own]
            drawn.note(True, f"{PROGRAM} has three decimals: coordinates are rounded to 0.001 {shown}")
            found = drawn_mobility(self.mechanism)
            text = "it moves at its exact dimensions only, and rounded ones may lock it"
            drawn.note(found and found.redundant, f"the mechanism has redundant constraints: {text}")

    def _exact(self, factor: float) -> bool:
        """Return whether thousandths hold all coordinates."""
        values = [part * factor * THOUSANDTHS for place in self.drawn.joints.values() for part in place]
        error = max(abs(value - round(value)) for value in values)
        return error / THOUSANDTHS <= EXACT * self.drawn.span * factor

    # -- joints and slots -----------------------------------------------------------------------

    def _joint(self, name: str) -> FileRecord:
        z = self.drawn.z(name) * self.factor
        values = {"fixed": name in self.drawn.bodies[GROUND], "traced": name in self.mechanism.traced}
        own = JOINT.record(PROGRAM, id=letter(len(self.joints)), name=_plain(name), x=z.real, y=z.imag, **values)
        self.joints[name] = own
        return own

    def _added(self, name: str, place: complex, *bodies: str) -> FileRecord:
        """Add a joint that the mechanism has no node for."""
        return self._joint(self.drawn.joint(name, place, *bodies))

    def _slot(self, slot: DrawnJoint) -> None:
        """Let a joint slide along a line; a pin that is also something else gets a slider beside it."""
        drawn, joint, here = self.drawn, self.joints[slot.at], self.drawn.z(slot.at)
        bodies, step = drawn.common(slot.at), PIECE * drawn.span * slot.along
        turned = any(turn.at == slot.at for turn in drawn.turns)
        if joint.slides or joint.fixed or turned or (slot.block and bodies != [slot.block]):
            body = slot.block or bodies[0]
            if body == GROUND:
                body = self._frame(slot.at, step)
            joint = self._added(f"{slot.at} slide", here + (step if slot.block not in ("", GROUND) else 0.0), body)
        elif slot.block and len(drawn.bodies[slot.block]) < 2:
            self._added(f"{slot.at} end", here + step, slot.block)
        joint.slides, joint.welded = True, bool(slot.block)
        self._line(slot, joint)
        self._drive(slot, joint, self.factor)

    def _drive(self, drawn: DrawnJoint, joint: FileRecord, unit: float) -> None:
        """Let a joint be an input if the drawn one has one; `unit`: its speed in the program, by that of the model."""
        if drawn.driver is not None:
            joint.driven, joint.speed = True, self.drawn.speed(drawn.driver) * unit

    def _frame(self, joint: str, step: complex) -> str:
        """Add a bar that is fixed by two pins of the ground, which a moving link slides over; return it."""
        frame = self.drawn.body(f"frame at {joint}", [])
        for end in (step, -step):
            self._added(f"{joint} pin", self.drawn.z(joint) + end, frame).fixed = True
        return frame

    def _line(self, slot: DrawnJoint, joint: FileRecord) -> None:
        """Set the line of a slider: an angle on the ground, or two joints of its carrier."""
        place, angle = complex(joint.x, joint.y) / self.factor, cmath.phase(slot.along)
        joint.sealed = slot.stroke is not None
        joint.fixed = not joint.sealed and slot.carrier == GROUND and _written(angle)
        if joint.fixed:
            joint.angle = angle
            return
        reach = 2.5 * PIECE * self.drawn.span * slot.along
        joint.carrier = slot.carrier
        joint.start, joint.end = (
            self._end(f"{slot.at} {end}", slot.carrier, z).id
            for end, z in zip(("from", "to"), slot.stroke or (place - reach, place + reach), strict=True)
        )

    def _end(self, name: str, body: str, place: complex) -> FileRecord:
        """Return the joint of a body at a place; add it if it has none there."""
        near = [own for own in self.drawn.bodies[body] if abs(self.drawn.z(own) - place) <= EXACT * self.drawn.span]
        known = [self.joints[own] for own in near if not self.joints[own].slides]
        return known[0] if known else self._added(name, place, body)

    # -- links and inputs -----------------------------------------------------------------------

    def _link(self, body: str, name: str, joints: list[FileRecord]) -> str:
        """Add a link with its centre of mass in the middle of its joints; return its id."""
        own: str = "".join(joint.id for joint in joints)
        own += str(len(self.links)) if own in {link.id for link in self.links.values()} else ""
        centre = sum(complex(joint.x, joint.y) for joint in joints) / len(joints)
        values = {"x": centre.real, "y": centre.imag, "joints": [joint.id for joint in joints]}
        self.links[body] = LINK.record(PROGRAM, id=own, name=name, **values)
        return own

    def _inputs(self) -> None:
        """Set the turning inputs, and the names of carriers, which are known now."""
        for joint in self.joints.values():
            if joint.carrier == GROUND:
                ends = [one for end in (joint.start, joint.end) for one in self.joints.values() if one.id == end]
                joint.carrier = self._link(f"{GROUND} {joint.id}", f"guide of {joint.name}", ends)
            elif joint.carrier:
                joint.carrier = self.links[joint.carrier].id
        for turn in self.drawn.turns:
            self._drive(turn, self.joints[turn.at], 1.0)

    def _apart(self) -> None:
        """Let the pin of an input join two links only: further links get a pin of their own at its place."""
        for turn in self.drawn.turns:
            further = [b for b in self.drawn.common(turn.at) if b not in turn.bodies]
            for body in further:
                self.drawn.bodies[body].remove(turn.at)
            if further:
                self._added(f"{turn.at} pin", self.drawn.z(turn.at), turn.carrier, *further)
                for other in self.drawn.turns:
                    if other is not turn and other.at == turn.at and other.bodies[1] in further:
                        other.at = next(reversed(self.joints))

    def _ordered(self) -> list[str]:
        """Return the bodies, each input's reference before the body that it turns: PMKS+ takes them in this order."""
        order = [body for body in self.drawn.bodies if body != GROUND]
        for turn in self.drawn.turns:
            reference, body = turn.bodies
            if reference != GROUND and order.index(body) < order.index(reference):
                order.remove(body)
                order.insert(order.index(reference) + 1, body)
        return order

    # -- masses and forces ----------------------------------------------------------------------

    def _dynamics(self) -> None:
        own = self.mechanism.dynamics
        self._masses()
        for load in own.loads:
            if load.member != FRAME:
                self._load(load)
        other = own.inertias and own.gravity and abs(own.gravity + 1j * GRAVITY) > 1e-3 * GRAVITY
        self.drawn.note(own.springs or own.dampers or own.frictions, "springs, dampers and friction are left out")
        self.drawn.note(other, f"{PROGRAM} has a gravity of {GRAVITY:g} m/s^2 downwards, not that of the model")

    def _masses(self) -> None:
        """Set the masses of links; a point mass at a pin belongs to its slider, or to the first of its links."""
        parts: list[tuple[str, tuple[float, float, complex]]] = []
        for inertia in (one for one in self.mechanism.dynamics.inertias if one.member != FRAME):
            body, place = self._on(inertia.node, inertia.member, inertia.centre)
            pin = self.joints[self.mechanism.nodes[inertia.node]] if inertia.node != NO_NODE else None
            if pin and pin.slides:
                pin.mass += inertia.mass / KILOGRAMS[self.unit]
            elif body:
                parts.append((body, (inertia.mass, inertia.moment, place)))
            else:
                self.drawn.note(True, f"the mass at {self.mechanism.nodes[inertia.node]} is left out: no link has it")
        for body, own in grouped(parts).items():
            mass = sum(part[0] for part in own)
            if not mass:
                continue
            centre = sum(part[0] * part[2] for part in own) / mass
            moment = sum(turning + m * abs((place - centre) * self.metre) ** 2 for m, turning, place in own)  # Steiner
            link, z = self.links[body], centre * self.factor
            link.mass, link.inertia = mass / KILOGRAMS[self.unit], moment / INERTIAS[self.unit]
            link.x, link.y = z.real, z.imag

    def _on(self, node: int, member: int, local: complex) -> tuple[str, complex]:
        """Return the body and the place of a mass or a force on a node, else on a member; "" if no link has it."""
        if node == NO_NODE:
            return self.drawn.names[member], self.drawn.at(member, local)
        name = self.mechanism.nodes[node]
        return next((body for body in self.drawn.common(name) if body in self.links), ""), self.drawn.z(name)

    def _load(self, load: AppliedLoad) -> None:
        body, place = self._on(load.node, load.member, load.point)
        turned = self.drawn.turned[load.member] if load.follows and load.node == NO_NODE else 1.0 + 0.0j
        faults = {
            "no link has its node": not body, "it is a torque": load.torque, "it has a table": load.curve is not None,
        }  # fmt: skip
        notes = [text for text, holds in faults.items() if holds]
        force, start = load.force * turned, place * self.factor
        if notes:
            self.drawn.note(True, f"the load {load.name} is left out: {notes[0]}")
        elif force:
            end = start + force / abs(force) * PIECE * self.drawn.span * self.factor
            values = {"x": start.real, "y": start.imag, "x1": end.real, "y1": end.imag,
                      "size": abs(force) / (POUND_FORCE if self.unit == 0 else 1.0)}  # fmt: skip
            own, names = f"F{len(self.document.forces) + 1}", {"link": self.links[body].id, "name": _plain(load.name)}
            flags = {"local": load.follows, "outward": True}
            self.document.forces.append(FORCE.record(PROGRAM, id=own, **names, **values, **flags))

    def _settings(self) -> None:
        self.drawn.note_laws(cylinders=True)
        speeds = [joint.speed for joint in self.joints.values() if joint.driven and not joint.slides]
        first = speeds[0] if speeds else 10.0
        weightless = bool(self.mechanism.dynamics.inertias) and not self.mechanism.dynamics.gravity
        flags = {CLOCKWISE: first < 0.0, NO_GRAVITY: weightless, **SHOWN}
        self.document.flags = [flags.get(k, False) for k in range(9)]
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
