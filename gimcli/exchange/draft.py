"""A mechanism as other programs have it: read from a file to become a model, or made of a model to be written.

The programs draw one assembled position: joints with coordinates, and rigid bodies that share joints. A reader adds the
joints, bodies, slots, inputs, tracers, masses and loads of its file to a `Draft`, from which `assembling.model_of`
makes the plain data of a model file. Writers get the draft of a mechanism, `drawn_linkage.DrawnLinkage`.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any

from gimcli.errors import ModelError
from gimcli.exchange.records import Refusing

GROUND = "ground"

BARREL = 0.9
"""Part of the distance to the mount of its barrel by which the piston of a cylinder moves when it retracts."""
MOST_PLACES = 3000
"""Most joints, or connectors, of all links together."""
STROKE = 0.1
"""Travel of a sliding input that has no ends, relative to the size of the mechanism."""
PARALLEL = 1e-9
"""Largest sine of the angle between a slot and a line through two joints that is its guide."""


@dataclass(frozen=True)
class DrawnJoint:
    """A joint as programs list it: a pin of its links (R), or a pin (RP) or a block (P) in a slot of the first one.

    `angle` is the direction of the slot [rad], `where` its place in the file for messages.
    """

    links: tuple[str, ...]
    kind: str  # R, P or RP; G for gear teeth
    place: complex
    angle: float = 0.0
    where: str = ""
    traced: bool = False
    driver: bool = False


@dataclass
class DrawnSlot:
    """A joint that slides along a line fixed to a carrier; `body` is the one that slides, "" if it may turn.

    `guide`: two joints of the carrier on the line. In a mechanism that is written, `travel` is the actuator (its
    number) that drives the joint along the line, and `stroke` the two ends of the barrel of a cylinder.
    """

    joint: str
    carrier: str
    direction: complex
    body: str = ""
    travel: int | None = None
    stroke: tuple[complex, complex] | None = None
    name: str = ""
    guide: tuple[str, str] | None = None


@dataclass
class Turn:
    """A rotary input: the angle of `body` against `reference` about a joint.

    `number` is that of the actuator in a mechanism that is written; the other fields are those of an input to be read.
    """

    pivot: str
    body: str
    reference: str
    number: int = 0
    name: str = ""
    arm: str = ""  # joint of the body whose direction is the angle; "": the farthest one
    keys: dict[str, Any] = field(default_factory=dict)


@dataclass
class Draft(Refusing):
    """A mechanism as other programs have it; all coordinates are those of its drawn position, y upwards.

    `bodies`: joints by body, GROUND among them. `tracers`: points of bodies, with their places.
    `travels`, `gears`, `masses`, `loads`: parts as in the model file, with the names of bodies and joints of the draft
    and with complex numbers for places and vectors; without `centre` the centre of mass is the mean of the joints.
    `resolution`: distance below which two joints of a body coincide, the last digit of the file's coordinates.
    `left_out`: sentences that name what the file has and the model has not, as the motion does not depend on it.
    """

    program: str
    source: str
    name: str = ""
    length: str = "unit"  # a unit of the model file
    mass: str = "kg"
    resolution: float = 0.0
    duration: float | None = None
    gravity: complex | None = None
    joints: dict[str, complex] = field(default_factory=dict)
    bodies: dict[str, list[str]] = field(default_factory=lambda: {GROUND: []})
    slots: list[DrawnSlot] = field(default_factory=list)
    turns: list[Turn] = field(default_factory=list)
    travels: dict[str, dict[str, Any]] = field(default_factory=dict)
    tracers: dict[str, tuple[str, complex]] = field(default_factory=dict)
    traced: list[str] = field(default_factory=list)  # joints and tracers whose paths the program draws
    gears: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    masses: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    loads: dict[str, dict[str, Any]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    # -- what readers call ----------------------------------------------------------------------

    def joint(self, name: str, place: complex, *bodies: str) -> str:
        """Add a joint of some bodies; return its name, which is changed if another joint has it."""
        self.refuse(
            not (math.isfinite(place.real) and math.isfinite(place.imag)),
            f"joint {name}: the coordinates are not finite numbers",
        )
        own = free_name(name, self.joints)
        self.joints[own] = place
        for body in bodies:
            self.bodies[body].append(own)
        return own

    def body(self, name: str, joints: Iterable[str]) -> str:
        """Add a rigid body with its joints; return its name, which is changed if another body has it."""
        own = free_name(name, self.bodies)
        self.bodies[own] = list(dict.fromkeys(joints))
        return own

    def common(self, *joints: str) -> list[str]:
        """Return the bodies that have all of some joints, the ground first."""
        return [body for body, own in self.bodies.items() if set(joints) <= set(own)]

    def point(self, name: str, body: str, place: complex) -> str:
        """Add a point of a body whose path counts; return its name, which is changed if another point has it."""
        own = free_name(name, [*self.joints, *self.tracers])
        self.tracers[own] = (body, place)
        return own

    def slot(
        self, name: str, joint: str, carrier: str, direction: complex, *, body: str = "",
        guide: tuple[str, str] | None = None,
    ) -> None:  # fmt: skip
        """Let a joint slide along a line through its place, fixed to a carrier: a body or GROUND.

        With `body` the joint is a block of this body, which slides without turning against the carrier. `guide`: two
        joints of the carrier on the line, if the file names them.
        """
        self.slots.append(DrawnSlot(joint, carrier, direction / abs(direction), body, name=name, guide=guide))

    def linked(self, joints: list[DrawnJoint], key: Callable[[str], str]) -> list[DrawnJoint]:
        """Add the links of joints as bodies without joints; return the joints with the names of these bodies.

        Links with the same key are one body, which has the name of the first one, or is the GROUND.
        """
        bodies = {GROUND: GROUND}
        for link in (link for joint in joints for link in joint.links):
            if key(link) not in bodies:
                bodies[key(link)] = self.body(link, ())
        links = [tuple(dict.fromkeys(bodies[key(link)] for link in joint.links)) for joint in joints]
        return [replace(joint, links=own) for joint, own in zip(joints, links, strict=True)]

    def listed(self, name: str, joint: DrawnJoint, slot: str) -> str:
        """Add a joint whose links are bodies, and its slot, if it has one; return its name.

        `slot` is the word before the name of the joint in that of the slot.
        """
        links = joint.links
        if joint.kind == "P" and links[1:] == (GROUND,):  # the slot slides over a block of the ground
            links = (GROUND, links[0])
        own = self.joint(name, joint.place, *(links if joint.kind == "R" else links[1:]))
        if joint.kind != "R" and len(links) > 1:
            body = links[1] if joint.kind == "P" else ""
            self.slot(f"{slot}_{own}", own, links[0], cmath.rect(1.0, joint.angle), body=body)
        return own

    def rotary(
        self, name: str, pivot: str, body: str, reference: str = GROUND, *, arm: str = "", **keys: Any
    ) -> None:  # fmt: skip
        """Add a rotary input, with further keys of an actuator, such as law={"by": 360}.

        law={"over": (a, b)} runs from a to b relative to the value at the drawn position.
        """
        self.turns.append(Turn(pivot, body, reference, 0, name, arm, keys))

    def travel(self, name: str, **keys: Any) -> None:
        """Add a linear input, with keys of an actuator.

        slot=NAME drives the travel of the joint of a slot, positive along its direction, relative to the carrier;
        type="linear", nodes=[A, B] drives the distance of two joints.
        """
        self.travels[free_name(name, self.travels)] = keys

    def suggest_input(self) -> None:
        """Name an input that could be added to a mechanism without one: a link on a fixed pin."""
        ground = self.bodies[GROUND]
        pinned = ((pivot, own) for pivot in ground for own in self.bodies.values() if pivot in own)
        arms = ((pivot, joint) for pivot, own in pinned for joint in own if joint not in ground)
        for pivot, arm in islice(arms, 1):
            own = f"`motor: {{type: rotary, pivot: {pivot}, arm: {arm}}}` in `actuators`"
            self.left_out.append(f"the file has no inputs; add one, such as {own}")

    def note(self, holds: object, text: str) -> None:
        """Name something that is left out, if it holds."""
        self.left_out += [text] if holds else []

    def refuse_many(self, places: int) -> None:
        """Raise ModelError if all links together have too many joints."""
        self.refuse(places > MOST_PLACES, f"more than {MOST_PLACES} joints of links are too many for one mechanism")

    def size(self) -> float:
        """Return the diagonal of the joints; 1 where they coincide."""
        places = list(self.joints.values())
        spans = [max(values) - min(values) for values in ([z.real for z in places], [z.imag for z in places])]
        return math.hypot(*spans) or 1.0

    def refused(self, text: str) -> ModelError:
        """Return the error for a part of the file that cannot become a model."""
        return ModelError([f"{self.source}: {text}"])


def free_name(name: str, taken: Iterable[str], same: Callable[[str], str] = str) -> str:
    """Return a name as a model file can have it, with a number if it is taken.

    `same` returns what two names that count as one have in common.
    """
    plain = " ".join("".join(c if c.isprintable() else " " for c in name).split()) or "unnamed"
    known, own, number = set(map(same, taken)), plain, 2
    while same(own) in known:
        own, number = f"{plain}_{number}", number + 1
    return own
