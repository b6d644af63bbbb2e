"""A mechanism as other programs have it: read from a file to become a model, or made of a model to be written.

The programs draw one assembled position: joints with two or three coordinates, and rigid bodies that share joints. A
reader adds the joints, bodies, slots, inputs, tracers, masses and loads of its file to a `Draft`, from which
`assembling.model_of` makes the plain data of a model file in the plane. Writers get the draft of a mechanism,
`drawn_linkage.DrawnLinkage`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from gimcli.errors import ModelError
from gimcli.exchange.records import FilePart, Refusing

GROUND = "ground"

BARREL = 0.9
"""Part of the distance to the mount of its barrel by which the piston of a cylinder moves when it retracts."""
MOST, MOST_PLACES = 500, 3000
"""Most joints or links, and most joints of all links together."""
STROKE = 0.1
"""Travel of a sliding input that has no ends, relative to the size of the mechanism."""
PARALLEL = 1e-9
"""Largest sine of the angle between a slot and a line through two joints that is its guide."""

Place = tuple[float, ...]
"""The coordinates of a place, or of a direction: two in the plane, three in space."""


def coordinates(place: Place | complex) -> Place:
    """Return the coordinates of a place, which may be given as x + iy."""
    return place if isinstance(place, tuple) else (place.real, place.imag)


@dataclass
class DrawnJoint:
    """A joint of bodies: a pin (R), or a slot of the first one in which a pin (RP) or a block (P) of the others slides.

    `at` is the name of its place in the draft. In space, pins have a direction, too. An input turns or moves the second
    body against the first one.
    """

    kind: str  # R, P or RP; G for gear teeth
    bodies: tuple[str, ...]
    place: Place = (0.0, 0.0)
    direction: Place = (1.0, 0.0)  # of the slot
    at: str = ""
    name: str = ""  # of its pair or its input in the model
    guide: tuple[str, str] | None = None  # places on the line of the slot, which are joints of the first body
    arm: str = ""  # place of the second body whose direction is the angle of the input; "": the farthest one
    keys: dict[str, Any] = field(default_factory=dict)  # of the input
    driver: int | None = None  # actuator that drives it, by its number in the mechanism that is written
    stroke: tuple[complex, complex] | None = None  # the two ends of the barrel of a cylinder, in the plane
    traced: bool = False
    own: FilePart = field(default_factory=lambda: FilePart(""))  # for messages

    @property
    def along(self) -> complex:
        """The direction of a slot in the plane."""
        return complex(*self.direction)

    @property
    def carrier(self) -> str:
        """The body that has the slot."""
        return self.bodies[0]

    @property
    def block(self) -> str:
        """The body that slides without turning; "" if there is none."""
        return self.bodies[1] if self.kind == "P" else ""


@dataclass
class Draft(Refusing):
    """A mechanism as other programs have it; all coordinates are those of its drawn position, in the plane y upwards.

    `joints`: the places. `bodies`: joints by body, GROUND among them. `slots`, `turns`: sliding joints, and pins with
    an input. `tracers`: points of bodies, with their places.
    `travels`, `gears`, `masses`, `loads`: parts as in the model file, with the names of bodies and joints of the draft
    and, in the plane, x + iy for places and vectors; without `centre` the centre of mass is the mean of the joints.
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
    joints: dict[str, Place] = field(default_factory=dict)
    bodies: dict[str, list[str]] = field(default_factory=lambda: {GROUND: []})
    slots: list[DrawnJoint] = field(default_factory=list)
    turns: list[DrawnJoint] = field(default_factory=list)
    travels: dict[str, dict[str, Any]] = field(default_factory=dict)
    tracers: dict[str, tuple[str, Place]] = field(default_factory=dict)
    traced: list[str] = field(default_factory=list)  # joints and tracers whose paths the program draws
    gears: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    masses: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    loads: dict[str, dict[str, Any]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    # -- what readers call ----------------------------------------------------------------------

    def joint(self, name: str, place: Place | complex, *bodies: str) -> str:
        """Add a joint of some bodies; return its name, which is changed if another joint has it."""
        own, found = free_name(name, self.joints), coordinates(place)
        self.refuse(not all(map(math.isfinite, found)), f"joint {name}: the coordinates are not finite numbers")
        self.joints[own] = found
        for body in bodies:
            self.bodies[body].append(own)
        self._refuse_many()
        return own

    def body(self, name: str, joints: Iterable[str]) -> str:
        """Add a rigid body with its joints; return its name, which is changed if another body has it."""
        own = free_name(name, self.bodies)
        self.bodies[own] = list(dict.fromkeys(joints))
        self._refuse_many()
        return own

    def _refuse_many(self) -> None:
        places = sum(map(len, self.bodies.values()))
        counts = {"joints": (len(self.joints) + len(self.tracers), MOST), "links": (len(self.bodies) - 1, MOST),
                  "joints of links": (places, MOST_PLACES)}  # fmt: skip
        self.check({f"more than {most} {what} are too many for one mechanism": count > most
                    for what, (count, most) in counts.items()})  # fmt: skip

    def z(self, joint: str) -> complex:
        """Return the place of a joint in the plane."""
        return complex(*self.joints[joint])

    def common(self, *joints: str) -> list[str]:
        """Return the bodies that have all of some joints, the ground first."""
        return [body for body, own in self.bodies.items() if set(joints) <= set(own)]

    def point(self, name: str, body: str, place: Place | complex) -> None:
        """Add a point of a body whose path counts; its name is changed if another point has it."""
        self.tracers[free_name(name, [*self.joints, *self.tracers])] = (body, coordinates(place))
        self._refuse_many()

    def slot(
        self, name: str, joint: str, carrier: str, direction: Place | complex, body: str = "", **more: Any
    ) -> None:  # fmt: skip
        """Let a joint slide along a line through its place, in a direction of any length that is fixed to a carrier.

        With `body` the joint is a block of this body, which slides without turning against the carrier. `more`: what a
        DrawnJoint further has, such as its guide.
        """
        kind, bodies = ("P", (carrier, body)) if body else ("RP", (carrier,))
        place, along = self.joints[joint], coordinates(direction)
        unit = tuple(part / math.hypot(*along) for part in along)
        self.slots.append(DrawnJoint(kind, bodies, place, unit, joint, name, **more))

    def linked(self, joints: Iterable[DrawnJoint], key: Callable[[str], str]) -> list[DrawnJoint]:
        """Add the links of joints as bodies without joints; return the joints with the names of these bodies.

        Links with the same key are one body, which has the name of the first one, or is the GROUND.
        """
        names, found = {GROUND: GROUND}, []
        for joint in joints:
            for link in joint.bodies:
                if key(link) not in names:
                    names[key(link)] = self.body(link, ())
            found.append(replace(joint, bodies=tuple(dict.fromkeys(names[key(link)] for link in joint.bodies))))
        return found

    def listed(self, name: str, joint: DrawnJoint, slot: str) -> str:
        """Add a joint of bodies of the draft, and its slot, if it has one; return the name of its place.

        `slot` is the word before this name in that of the slot.
        """
        bodies = joint.bodies
        if joint.kind == "P" and bodies[1:] == (GROUND,):  # the slot slides over a block of the ground
            bodies = (GROUND, bodies[0])
        own = self.joint(name, joint.place, *(bodies if joint.kind == "R" else bodies[1:]))
        if joint.kind != "R" and len(bodies) > 1:
            self.slot(f"{slot}_{own}", own, bodies[0], joint.direction, body=bodies[1] if joint.kind == "P" else "")
        return own

    def rotary(
        self, name: str, pivot: str, body: str, reference: str = GROUND, *, arm: str = "", **keys: Any
    ) -> None:  # fmt: skip
        """Add a rotary input, with further keys of an actuator, such as law={"by": 360}.

        law={"over": (a, b)} runs from a to b relative to the value at the drawn position.
        """
        self.turns.append(DrawnJoint("R", (reference, body), at=pivot, name=name, arm=arm, keys=keys))

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
        arms = [f"pivot: {pivot}, arm: {joint}" for pivot, own in pinned for joint in own if joint not in ground]
        own = f"`motor: {{type: rotary, {''.join(arms[:1])}}}` in `actuators`"
        self.note(arms, f"the file has no inputs; add one, such as {own}")

    def note(self, holds: object, text: str) -> None:
        """Name something that is left out, if it holds."""
        self.left_out += [text] if holds else []

    def size(self) -> float:
        """Return the diagonal of the joints; 1 where they coincide."""
        axes = zip(*self.joints.values(), strict=True)
        return math.hypot(*(max(values) - min(values) for values in axes)) or 1.0

    def refused(self, text: str) -> ModelError:
        """Return the error for a part of the file that cannot become a model."""
        return FilePart(self.source).refused(text)


def free_name(name: str, taken: Iterable[str], same: Callable[[str], str] = str) -> str:
    """Return a name as a model file can have it, with a number if it is taken.

    `same` returns what two names that count as one have in common.
    """
    plain = " ".join("".join(c if c.isprintable() else " " for c in name).split()) or "unnamed"
    known, own, number = set(map(same, taken)), plain, 2
    while same(own) in known:
        own, number = f"{plain}_{number}", number + 1
    return own
