"""A mechanism as programs draw it: pins that join bodies, and joints of bodies that slide along lines.

What these programs have no part for becomes bodies of its own: a cylinder is a barrel and a rod, a node without
members is a block, and the travel of a node beside its line is that of a carriage on which the node slides crosswise.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np

from gimcli.errors import ModelError
from gimcli.exchange.draft import BARREL, GROUND, free_name
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, ComplexArray, Input, Mechanism, PairRow


@dataclass(frozen=True)
class DrawnPose:
    """A mechanism in an assembled position: other programs take all dimensions from it.

    `z`: positions of the nodes (nodes,) in the file's coordinates. `left_out`: sentences about what is not written.
    """

    mechanism: Mechanism
    z: ComplexArray
    left_out: list[str] = field(default_factory=list)


PIECE = 0.1
"""Size of added bodies relative to the size of the mechanism."""
UNIFORM = 1e-9
"""Largest difference of a law from a uniform one, relative to its range."""
STRAIGHT = 1e-9
"""Largest sine of the angle between parallel lines."""


@dataclass
class DrawnSlot:
    """A joint that slides along a line of a carrier; `body` cannot turn against it, "" if the joint is a pin.

    `travel`: the actuator (its number) that drives the joint along the line.
    """

    joint: str
    carrier: str
    direction: complex
    body: str = ""
    travel: int | None = None
    stroke: tuple[complex, complex] | None = None  # of a cylinder: its mount and the other end of its barrel


@dataclass
class DrawnTurn:
    """A rotary input at a pin: the angle of a body against another one."""

    joint: str
    body: str
    reference: str
    actuator: int


@dataclass
class DrawnLinkage:
    """Joints with their places and bodies, slots and inputs, in the file's coordinates."""

    pose: DrawnPose
    program: str
    places: dict[str, complex] = field(default_factory=dict)
    bodies: dict[str, list[str]] = field(default_factory=dict)  # joints by body, GROUND among them
    slots: list[DrawnSlot] = field(default_factory=list)
    turns: list[DrawnTurn] = field(default_factory=list)
    points: dict[str, str] = field(default_factory=dict)  # bodies of the points, which are joints of one body

    def __post_init__(self) -> None:
        """Read the members, the pairs, the inputs and the points of the mechanism."""
        own = self.pose.mechanism
        self.mechanism = own
        self.size = own.size * own.scale
        self.names = [GROUND, *(m.name for m in own.members[1:])]
        self.places = {name: complex(z) for name, z in zip(own.nodes, self.pose.z, strict=True)}
        for name, member in zip(self.names, own.members, strict=True):
            self.bodies[name] = [own.nodes[k] for k in member.nodes]
        self.turned = [self._rotation(k) for k in range(len(own.members))]
        self._pairs()
        for number, actuator in enumerate(own.actuators):
            self._input(number, actuator)
        self._blocks()
        self._points()
        if own.couplings:
            names = ", ".join(own.actuators[coupling.follower].name for coupling in own.couplings)
            self.pose.left_out.append(f"{names}: the coupling is left out; they are inputs with speeds of their own")
        if own.floating:
            self.pose.left_out.append(f"the held member {own.members[FRAME].name} is written as the ground")

    # -- what writers ask -----------------------------------------------------------------------

    def refusal(self, text: str) -> ModelError:
        """Return the error for a part that the program cannot express."""
        return ModelError([f"{self.mechanism.name}: {text}"])

    def bodies_at(self, joint: str) -> list[str]:
        """Return the bodies that a joint belongs to."""
        return [body for body, joints in self.bodies.items() if joint in joints]

    def speed(self, actuator: int) -> float:
        """Return the mean speed of an input: revolutions per minute, or lengths per second."""
        law = self.mechanism.actuators[actuator].law
        first, last = (float(v) for v in law(np.array([0.0, 1.0])))
        rate = (last - first) / self.mechanism.duration
        rotary = self.mechanism.actuators[actuator].rotary
        return rate * 30.0 / math.pi if rotary else rate * self.mechanism.scale

    def note_laws(self, cylinders: bool) -> None:
        """Note what programs that move inputs at constant speed do not have of the laws.

        `cylinders`: the program has cylinders, and so their strokes.
        """
        for actuator in self.mechanism.actuators:
            times = np.linspace(0.0, 1.0, 9)
            values = actuator.law(times)
            span = float(values[-1] - values[0])
            straight = values[0] + span * times
            if not abs(values - straight).max() <= UNIFORM * max(abs(span), 1e-9):
                text = f"{self.program} moves its inputs at constant speed"
                self.pose.left_out.append(f"the profile of the law of {actuator.name} is left out: {text}")
            elif actuator.rotary and abs(abs(span) - 2.0 * math.pi) > 1e-9:
                text = f"{self.program} turns its inputs as far as they can turn"
                self.pose.left_out.append(f"the range of the law of {actuator.name} is left out: {text}")
            elif not actuator.rotary and not (cylinders and actuator.kind == SPAN):
                text = f"{self.program} moves its inputs as far as they can move"
                self.pose.left_out.append(f"the stroke of the law of {actuator.name} is left out: {text}")

    def body(self, name: str, *joints: str) -> str:
        """Add a body; return its name."""
        own = free_name(name, self.bodies)
        self.bodies[own] = list(joints)
        return own

    def joint(self, name: str, place: complex, *bodies: str) -> str:
        """Add a joint of some bodies; return its name."""
        own = free_name(name, self.places)
        self.places[own] = place
        for body in bodies:
            self.bodies[body].append(own)
        return own

    # -- members and pairs ----------------------------------------------------------------------

    def _rotation(self, member: int) -> complex:
        """Return the direction of a member's own x axis."""
        if member == FRAME and not self.mechanism.floating:
            return 1.0 + 0.0j
        first, far, vector = self.mechanism.members[member].ends
        ray = complex(self.pose.z[far] - self.pose.z[first]) / vector
        return ray / abs(ray)

    def at(self, member: int, local: complex) -> complex:
        """Return the place of a point of a member."""
        own = self.mechanism.members[member]
        first = complex(self.pose.z[own.nodes[0]])
        return first + (local - complex(own.shape[0])) * self.turned[member] * self.mechanism.scale

    def _pairs(self) -> None:
        """Add the slots of the prismatic pairs: one for a pin, one for each block."""
        rows: dict[str, list[PairRow]] = defaultdict(list)
        for row in self.mechanism.pairs:
            if row.kind != HEIGHT:
                raise self.refusal(f"the pair {row.pair or row.name} cannot be written for {self.program}")
            rows[row.pair or row.name].append(row)
        for name, own in rows.items():
            direction = own[0].along * self.turned[own[0].guide]
            nodes = [self.mechanism.nodes[row.node] for row in own]
            body = self._common(nodes, but=self.names[own[0].guide]) if len(nodes) > 1 else ""
            if len(nodes) > 1 and not body:
                raise self.refusal(f"the pair {name} cannot be written for {self.program}: its nodes have no link")
            self.slots.append(DrawnSlot(nodes[0], self.names[own[0].guide], direction, body))

    def _common(self, nodes: list[str], but: str) -> str:
        found = [body for body, joints in self.bodies.items() if body != but and set(nodes) <= set(joints)]
        return found[0] if found else ""

    # -- inputs ---------------------------------------------------------------------------------

    def _input(self, number: int, actuator: Input) -> None:
        if actuator.kind == SPAN:
            self._cylinder(number, actuator)
        elif actuator.kind == ANGLE:
            self._turn(number, actuator)
        else:
            self._travel(number, actuator)

    def _cylinder(self, number: int, actuator: Input) -> None:
        """Add a barrel at the first node and a rod at the second; its strokes end where the law ends."""
        a, b = (self.mechanism.nodes[k] for k in actuator.nodes)
        ray = self.places[b] - self.places[a]
        length = abs(ray)
        law = actuator.law(np.array([0.0, 1.0])) * self.mechanism.scale
        change = float(law[1] - law[0])
        inside = -change / BARREL if change < 0.0 else 0.5 * length  # of the barrel, up to the piston
        end = inside + (change if change > 0.0 else 0.0 if change < 0.0 else 0.25 * length)
        unit = ray / length
        barrel = self.body(f"{actuator.name} barrel", a)
        rod = self.body(f"{actuator.name} rod", b)
        piston = self.joint(f"{actuator.name} piston", self.places[a] + inside * unit, rod)
        far = self.places[a] + end * unit
        self.slots.append(DrawnSlot(piston, barrel, unit, rod, number, (self.places[a], far)))

    def _turn(self, number: int, actuator: Input) -> None:
        pivot = self.mechanism.nodes[actuator.node]
        body, reference = (self.names[k] for k in actuator.members)
        slot = next((s for s in self.slots if s.joint == pivot and not s.body and s.carrier == GROUND), None)
        if pivot not in self.bodies[reference] and reference == GROUND and slot is not None:
            reference = self._block_of(slot)
        if pivot not in self.bodies[reference] or pivot not in self.bodies[body]:
            text = f"the input {actuator.name} turns against the ground about a pivot that moves"
            raise self.refusal(f"{text}; {self.program} has no such input")
        self.turns.append(DrawnTurn(pivot, body, reference, number))

    def _block_of(self, slot: DrawnSlot) -> str:
        """Let the pin of a slot turn in a block that slides without turning; return the block."""
        block = self.body(f"{slot.joint} block", slot.joint)
        place = self.places[slot.joint] + PIECE * self.size * slot.direction
        slot.joint = self.joint(f"{slot.joint} slide", place, block)
        slot.body = block
        return block

    def _travel(self, number: int, actuator: Input) -> None:
        node, guide = self.mechanism.nodes[actuator.node], self.names[actuator.guide]
        direction = actuator.normal * self.turned[actuator.guide]
        for slot in self.slots:
            parallel = abs((slot.direction / direction).imag) <= STRAIGHT
            if slot.joint == node and slot.carrier == guide and parallel:
                slot.direction, slot.travel = direction, number
                return
        carriage = self.body(f"{actuator.name} carriage")
        joint = self.joint(f"{actuator.name} slide", self.places[node] + PIECE * self.size * direction, carriage)
        self.slots.append(DrawnSlot(joint, guide, direction, carriage, number))
        self.slots.append(DrawnSlot(node, carriage, 1j * direction))

    # -- blocks and points ----------------------------------------------------------------------

    def _blocks(self) -> None:
        """Give a body to each joint that slides without a member: it does not turn on its first line."""
        for slot in self.slots:
            if not slot.body and not self.bodies_at(slot.joint):
                slot.body = self.body(f"{slot.joint} block", slot.joint)

    def _points(self) -> None:
        for point in self.mechanism.points:
            body = self.names[point.member]
            if body == GROUND:
                self.pose.left_out.append(f"the point {point.name} of the ground is left out")
            else:
                name = self.joint(point.name, self.at(point.member, point.local), body)
                self.points[name] = body
