"""A mechanism as programs draw it: pins that join bodies, and joints of bodies that slide along lines.

What these programs have no part for becomes bodies of its own: a cylinder is a barrel and a rod, a node without
members is a block, and the travel of a node beside its line is that of a carriage on which the node slides crosswise.
"""

from __future__ import annotations

import math

import numpy as np

from gimcli.connected import grouped
from gimcli.exchange.draft import BARREL, GROUND, Draft, DrawnJoint, coordinates
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, ComplexArray, Input, Mechanism
from gimcli.structure.carried import unit_of

PIECE = 0.1
"""Size of added bodies relative to the size of the mechanism."""
UNIFORM = 1e-9
"""Largest difference of a law from a uniform one, relative to its range."""
STRAIGHT = 1e-9
"""Largest sine of the angle between parallel lines."""


class DrawnLinkage(Draft):
    """The members, the pairs, the inputs and the points of a mechanism in an assembled position.

    Other programs take all dimensions from it. `places`: positions of the nodes (nodes,) in the file's coordinates.
    Points are joints of one body. `left_out`: sentences about what is not written.
    """

    def __init__(self, own: Mechanism, places: ComplexArray, program: str) -> None:
        super().__init__(program, own.name)
        self.places, self.mechanism = places, own
        self.span = own.size * own.scale
        self.names = [GROUND, *(m.name for m in own.members[1:])]
        self.joints = {name: (float(z.real), float(z.imag)) for name, z in zip(own.nodes, places, strict=True)}
        self.bodies = {n: [own.nodes[k] for k in m.nodes] for n, m in zip(self.names, own.members, strict=True)}
        turned = (complex(unit_of(own, places, k)) for k in range(len(own.members)))
        self.turned = [ray / abs(ray) for ray in turned]  # e^(i phi)
        self._pairs()
        added = {SPAN: self._cylinder, ANGLE: self._turn}
        for number, actuator in enumerate(own.actuators):
            added.get(actuator.kind, self._travel)(number, actuator)
        self._blocks()
        self._points()
        names = ", ".join(own.actuators[coupling.follower].name for coupling in own.couplings)
        self.note(names, f"{names}: the coupling is left out; they are inputs with speeds of their own")
        self.note(own.floating, f"the held member {own.members[FRAME].name} is written as the ground")

    # -- what writers ask -----------------------------------------------------------------------

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
            even = abs(values - (values[0] + span * times)).max() <= UNIFORM * max(abs(span), 1e-9)
            whole = abs(abs(span) - 2.0 * math.pi) <= 1e-9
            notes = {
                "profile": (not even, "moves its inputs at constant speed"),
                "range": (actuator.rotary and not whole, "turns its inputs as far as they can turn"),
                "stroke": (
                    not (actuator.rotary or (cylinders and actuator.kind == SPAN)),
                    "moves its inputs as far as they can move",
                ),
            }
            texts = [f"the {part} of the law of {actuator.name} is left out: {self.program} {how}"
                     for part, (holds, how) in notes.items() if holds]  # fmt: skip
            self.left_out += texts[:1]

    # -- members and pairs ----------------------------------------------------------------------

    def at(self, member: int, local: complex) -> complex:
        """Return the place of a point of a member."""
        own = self.mechanism.members[member]
        first = complex(self.places[own.nodes[0]])
        return first + (local - complex(own.shape[0])) * self.turned[member] * self.mechanism.scale

    def _pairs(self) -> None:
        """Add the slots of the prismatic pairs: one for a pin, one for each block."""
        for row in self.mechanism.pairs:
            self.refuse(row.kind != HEIGHT, f"the pair {row.pair or row.name} cannot be written for {self.program}")
        for name, own in grouped((row.pair or row.name, row) for row in self.mechanism.pairs).items():
            guide, direction = self.names[own[0].guide], own[0].along * self.turned[own[0].guide]
            nodes = [self.mechanism.nodes[row.node] for row in own]
            bodies = [body for body in self.common(*nodes) if body != guide] if len(nodes) > 1 else [""]
            self.refuse(not bodies, f"the pair {name} cannot be written for {self.program}: its nodes have no link")
            self.slot(name, nodes[0], guide, direction, body=bodies[0])

    # -- inputs ---------------------------------------------------------------------------------

    def _cylinder(self, number: int, actuator: Input) -> None:
        """Add a barrel at the first node and a rod at the second; its strokes end where the law ends."""
        a, b = (self.mechanism.nodes[k] for k in actuator.nodes)
        ray = self.z(b) - self.z(a)
        length = abs(ray)
        law = actuator.law(np.array([0.0, 1.0])) * self.mechanism.scale
        change = float(law[1] - law[0])
        inside = -change / BARREL if change < 0.0 else 0.5 * length  # of the barrel, up to the piston
        end = inside + (change if change > 0.0 else 0.0 if change < 0.0 else 0.25 * length)
        unit = ray / length
        barrel = self.body(f"{actuator.name} barrel", [a])
        rod = self.body(f"{actuator.name} rod", [b])
        piston = self.joint(f"{actuator.name} piston", self.z(a) + inside * unit, rod)
        far = self.z(a) + end * unit
        self.slot(actuator.name, piston, barrel, unit, body=rod, driver=number, stroke=(self.z(a), far))

    def _turn(self, number: int, actuator: Input) -> None:
        pivot = self.mechanism.nodes[actuator.node]
        body, reference = (self.names[k] for k in actuator.members)
        slot = next((s for s in self.slots if s.at == pivot and not s.block and s.carrier == GROUND), None)
        if pivot not in self.bodies[reference] and reference == GROUND and slot is not None:
            reference = self._block_of(slot)
        self.refuse(
            pivot not in self.bodies[reference] or pivot not in self.bodies[body],
            f"the input {actuator.name} turns against the ground about a pivot that moves; "
            f"{self.program} has no such input",
        )
        self.turns.append(DrawnJoint("R", (reference, body), at=pivot, driver=number))

    def _block_of(self, slot: DrawnJoint) -> str:
        """Let the pin of a slot turn in a block that slides without turning; return the block."""
        block = self.body(f"{slot.at} block", [slot.at])
        place = self.z(slot.at) + PIECE * self.span * slot.along
        slot.at, slot.kind, slot.bodies = self.joint(f"{slot.at} slide", place, block), "P", (slot.carrier, block)
        return block

    def _travel(self, number: int, actuator: Input) -> None:
        node, guide = self.mechanism.nodes[actuator.node], self.names[actuator.guide]
        direction = actuator.normal * self.turned[actuator.guide]
        for slot in self.slots:
            parallel = abs((slot.along / direction).imag) <= STRAIGHT
            if slot.at == node and slot.carrier == guide and parallel:
                slot.direction, slot.driver = coordinates(direction), number
                return
        carriage = self.body(f"{actuator.name} carriage", [])
        joint = self.joint(f"{actuator.name} slide", self.z(node) + PIECE * self.span * direction, carriage)
        self.slot(actuator.name, joint, guide, direction, body=carriage, driver=number)
        self.slot(actuator.name, node, carriage, 1j * direction)

    # -- blocks and points ----------------------------------------------------------------------

    def _blocks(self) -> None:
        """Give a body to each joint that slides without a member: it does not turn on its first line."""
        for slot in self.slots:
            if not slot.block and not self.common(slot.at):
                slot.kind, slot.bodies = "P", (slot.carrier, self.body(f"{slot.at} block", [slot.at]))

    def _points(self) -> None:
        for point in self.mechanism.points:
            grounded = self.names[point.member] == GROUND
            self.note(grounded, f"the point {point.name} of the ground is left out")
            if not grounded:
                self.joint(point.name, self.at(point.member, point.local), self.names[point.member])
