"""The rows of PMKS text for a mechanism: a line for each joint, the driver first."""

from __future__ import annotations

import cmath
import math
import re
from dataclasses import dataclass

from gimcli.exchange.draft import GROUND
from gimcli.exchange.drawn_linkage import DrawnLinkage, DrawnSlot, DrawnTurn
from gimcli.exchange.pmks_joints import PROGRAM, direction, is_ground

MOST_INPUTS = 1


@dataclass
class PmksRow:
    """A line of the text."""

    links: list[str]
    kind: str
    place: complex
    angle: float
    traced: bool = False
    driver: bool = False

    def text(self) -> str:
        """Return the line; all digits are written."""
        marks = f"{'t' if self.traced else 'f'}ff{'t' if self.driver else 'f'}"
        numbers = (self.place.real, self.place.imag, self.angle)
        return ",".join([*self.links, self.kind, *(repr(value + 0.0) for value in numbers), marks])


class PmksRows:
    """The rows of a drawn linkage."""

    def __init__(self, drawn: DrawnLinkage) -> None:
        self.drawn = drawn
        if len(drawn.mechanism.actuators) > MOST_INPUTS:
            names = ", ".join(actuator.name for actuator in drawn.mechanism.actuators)
            raise drawn.refusal(f"{PROGRAM} has one input, the model has {len(drawn.mechanism.actuators)}: {names}")
        self.rows: list[PmksRow] = []
        self.links = self._links()
        for joint in drawn.places:
            self._joint(joint)
        self._note()

    def text(self) -> str:
        """Return the text: the speed, and the rows with the driver first, which PMKS counts by its number."""
        rows = sorted(self.rows, key=lambda row: not row.driver)
        head = f"set=s{self._speed():.9g}\n" if self.drawn.mechanism.actuators else ""
        return head + "mech=\n" + "".join(f"{row.text()}\n" for row in rows)

    def _speed(self) -> float:
        """Return the speed of the input, against the direction of its slot if PMKS turns this by half a revolution."""
        drives = [slot.direction for slot in self.drawn.slots if slot.travel is not None]
        against = bool(drives) and (direction(cmath.phase(drives[0])) / drives[0]).real < 0.0
        return -self.drawn.speed(0) if against else self.drawn.speed(0)

    def _links(self) -> dict[str, str]:
        """Return names of links as PMKS can read them: without blanks and commas, and not those of the ground."""
        found, taken = {GROUND: GROUND}, {GROUND}
        for body in self.drawn.bodies:
            if body == GROUND:
                continue
            plain = re.sub(r"[^\w.-]+", "_", body).strip("_") or "link"
            if is_ground(plain) or plain.isdecimal():
                plain = f"link_{plain}"
            own, number = plain, 2
            while own.casefold() in taken:
                own, number = f"{plain}_{number}", number + 1
            found[body] = own
            taken.add(own.casefold())
        return found

    def _joint(self, joint: str) -> None:
        """Add the rows of a joint: its slots, its pin, or the row of a tracer."""
        bodies = self.drawn.bodies_at(joint)
        slots = [slot for slot in self.drawn.slots if slot.joint == joint]
        turns = [turn for turn in self.drawn.turns if turn.joint == joint]
        for slot in slots:
            self._slot(slot, bodies)
        if turns or len(bodies) > 1:
            self._pin(joint, bodies, turns)
        elif not slots and bodies != [GROUND] and bodies:
            self._row(bodies, "R", joint)

    def _slot(self, slot: DrawnSlot, bodies: list[str]) -> None:
        driver = slot.travel is not None
        body = slot.body
        if driver and not body:  # PMKS drives blocks, not pins in slots
            body = self.drawn.body(f"{slot.joint} block")
            self.links = self._links()
            self._row([body, bodies[0]], "R", slot.joint)
        if body:
            self._row([slot.carrier, body], "P", slot.joint, slot.direction, driver)
        else:
            self._row([slot.carrier, bodies[0]], "RP", slot.joint, slot.direction)

    def _pin(self, joint: str, bodies: list[str], turns: list[DrawnTurn]) -> None:
        """Add the pin: the links of the driver in a row of their own, then each further link to one of them."""
        first = bodies
        if turns:
            first = [turns[0].reference, turns[0].body]
        self._row(first[:2], "R", joint, driver=bool(turns))
        for body in bodies:
            if body not in first[:2]:
                self._row([first[0], body], "R", joint)

    def _row(self, bodies: list[str], kind: str, joint: str, along: complex = 1.0 + 0.0j, driver: bool = False) -> None:
        angle = math.degrees(cmath.phase(along))
        traced = joint in self.drawn.mechanism.traced
        links = [self.links[body] for body in bodies]
        self.rows.append(PmksRow(links, kind, self.drawn.places[joint], angle, traced, driver))

    def _note(self) -> None:
        left_out = self.drawn.pose.left_out
        self.drawn.note_laws(cylinders=False)
        if self.drawn.mechanism.length_unit != "unit":
            left_out.append(f"{PROGRAM} has no units; lengths are in {self.drawn.mechanism.length_unit}")
        if not self.drawn.mechanism.dynamics.empty:
            left_out.append("masses, loads, springs, dampers and friction are left out")
        if not self.drawn.mechanism.actuators:
            left_out.append(f"the model has no input; {PROGRAM} drives the first joint that can be driven")
