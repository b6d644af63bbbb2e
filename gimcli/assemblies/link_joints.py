"""A mechanism as bodies and nodes connected by joints, from which its loops are derived.

A joint gives the position of a node in a body: z_node = z_body + e^(i phi) (point + s direction), with s = 0 for a pin.
Members are bodies; a driven distance is a body too, a bar of that length. A node of k members has k joints, so that
multiple pairs need no special treatment. Members that turn together (true prismatic pairs, driven angles) have the same
rotation class; e^(i phi) of a body is a known phase times that of its class.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from gimcli.errors import StructureError
from gimcli.mechanism import HEIGHT, SPAN, ComplexArray, FloatArray, Input, Mechanism, PairRow
from gimcli.structure.derived import derived
from gimcli.structure.joints import sliding_pairs
from gimcli.structure.rotation import Phase, rotation_classes, ties, united

NONE = -1
PARALLEL = 1e-12
"""Sine, or distance relative to the size, below which rails are parallel or pass through a pin (rounding)."""


@dataclass(frozen=True)
class BodyJoint:
    """The position of a node in a body; driven lengths are added to the constant point."""

    name: str
    body: int
    node: int
    point: complex  # in the coordinate system of the body
    direction: complex | None = None  # unit vector of a slide's rail; None for a pin
    actuator: int = NONE  # actuator whose value times `along` is added to the point
    along: complex = 0.0j
    through: int = NONE  # pin of the same body through which the rail passes
    parallel: int = NONE  # first joint with a parallel rail that turns with this one
    slack: bool = False  # a redundant pin replaced by a slide; its residual is checked


@dataclass(frozen=True)
class Linkage:
    """Bodies, nodes and joints; body 0 is the frame. Vertices are the bodies, then the nodes."""

    mechanism: Mechanism
    joints: tuple[BodyJoint, ...]  # joints at nodes with at least two joints
    carried: tuple[BodyJoint, ...]  # joints of nodes with only one joint
    classes: tuple[int, ...]  # (bodies,) rotation class, NONE for the frame's
    phases: tuple[Phase, ...]  # (bodies,)
    dropped: frozenset[int] = frozenset()  # bodies that are computed from their nodes afterwards

    @property
    def bodies(self) -> int:
        """Number of bodies, including the frame."""
        return len(self.classes)

    @property
    def loose(self) -> tuple[int, ...]:
        """Nodes whose only joint is a slide; they can move freely along it."""
        return tuple(j.node for j in self.carried if j.direction is not None)

    @property
    def vertices(self) -> int:
        """Number of bodies and nodes."""
        return self.bodies + len(self.mechanism.nodes)

    def numbers(self, inputs: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return points and rails (joints, rows), turned by their bodies' phases; and the phases (bodies, rows)."""
        phases = np.array([p.at(inputs) for p in self.phases])
        points = np.empty((len(self.joints), inputs.shape[1]), dtype=complex)
        rails = np.ones_like(points)
        for k, joint in enumerate(self.joints):
            points[k] = joint.point
            if joint.actuator != NONE:
                points[k] += joint.along * inputs[joint.actuator]
            points[k] *= phases[joint.body]
            if joint.direction is not None:
                rails[k] = joint.direction * phases[joint.body]
        return points, rails, phases

    def sense(self, a: BodyJoint, b: BodyJoint) -> int:
        """Return +1 or -1 if two rails turn together and are parallel (same or opposite sense), else 0."""
        if a.direction is None or b.direction is None or a.slack or b.slack:
            return 0
        own, its = self.phases[a.body], self.phases[b.body]
        if self.classes[a.body] != self.classes[b.body] or own.turns != its.turns:
            return 0
        along = a.direction * own.constant * (b.direction * its.constant).conjugate()
        return 0 if abs(along.imag) > PARALLEL else 1 if along.real > 0.0 else -1

    def same_rail(self, a: int, b: int) -> bool:
        """Return whether the rails of two joints have the same direction."""
        first = [self.joints[k].parallel if self.joints[k].parallel != NONE else k for k in (a, b)]
        return first[0] == first[1]


@derived
def linkage(mechanism: Mechanism) -> Linkage:
    """Return the bodies, nodes and joints of a mechanism; raise StructureError if an angle is driven twice."""
    bars = [k for k, a in enumerate(mechanism.actuators) if a.kind == SPAN]
    classes, phases = _classes(mechanism, len(bars))
    joints = [
        BodyJoint(m.name, b, node, complex(m.shape[k]))
        for b, m in enumerate(mechanism.members)
        for k, node in enumerate(m.nodes)
    ]
    joints += _sliding(mechanism, rotation_classes(mechanism).implied)
    for body, k in enumerate(bars, start=len(mechanism.members)):
        a = mechanism.actuators[k]
        first, second = a.nodes
        joints.append(BodyJoint(a.name, body, first, 0.0j))
        joints.append(BodyJoint(a.name, body, second, 0.0j, actuator=k, along=1.0 + 0.0j))
    return pruned(Linkage(mechanism, (), (), classes, phases), joints)


def _sliding(mechanism: Mechanism, implied: frozenset[PairRow]) -> list[BodyJoint]:
    """Return the joints of slides and travels; both together on one rail are a pin."""
    joints = []
    travels = {k: a for k, a in enumerate(mechanism.actuators) if a.kind == HEIGHT}
    for pair in sliding_pairs(mechanism):
        for slide in (mechanism.slides[k] for k in pair.slides):
            a = travels.get(pair.actuator)
            if slide in implied:
                continue
            if a is None or a.node != slide.node:
                joints.append(BodyJoint(slide.name, slide.guide, slide.node, slide.point, slide.along))
                continue
            height = (1j * a.normal).conjugate() * (slide.point - a.point)
            held = a.point + 1j * a.normal * height.real
            joints.append(BodyJoint(slide.name, slide.guide, slide.node, held, actuator=pair.actuator, along=a.normal))
            del travels[pair.actuator]
    return joints + [_travel(k, a) for k, a in travels.items()]


def _travel(number: int, a: Input) -> BodyJoint:
    """Return the joint of a travel without a slide: the node is on a line normal to the guide."""
    return BodyJoint(a.name, a.guide, a.node, a.point, 1j * a.normal, actuator=number, along=a.normal)


def _classes(mechanism: Mechanism, bars: int) -> tuple[tuple[int, ...], tuple[Phase, ...]]:
    """Return class and phase of every body, from prismatic pairs and driven angles."""
    still = Phase(turns=(0,) * len(mechanism.actuators))
    tied = [(tie.body, tie.guide, replace(still, constant=tie.turn)) for tie in ties(mechanism)]
    inputs = [(k, a) for k, a in enumerate(mechanism.actuators) if a.rotary]
    turns = [tuple(int(j == k) for j in range(len(still.turns))) for k, _ in inputs]
    driven = [(a.members[0], a.guide, Phase(a.reference / a.arm, t)) for (_, a), t in zip(inputs, turns, strict=True)]
    found, idle = united(len(mechanism.members) + bars, [*tied, *driven], still)
    for number in idle:
        if number >= len(tied):
            raise StructureError(
                f"over-driven: actuator '{inputs[number - len(tied)][1].name}' drives an angle that is fixed or"
                " already driven; remove it"
            )
    numbers = {root: k for k, root in enumerate(dict.fromkeys(root for root, _ in found), start=NONE)}
    return tuple(numbers[root] for root, _ in found), tuple(phase for _, phase in found)


def pruned(linkage: Linkage, joints: list[BodyJoint]) -> Linkage:
    """Return the linkage whose nodes with a single joint are moved from `joints` to `carried`."""
    carried = list(linkage.carried)
    while True:
        degree = Counter(j.node for j in joints)
        loose = [j for j in joints if degree[j.node] == 1]
        if not loose:
            break
        carried += loose
        joints = [j for j in joints if degree[j.node] > 1]
    return replace(linkage, joints=tuple(_related(linkage, joints)), carried=tuple(carried))


def _related(linkage: Linkage, joints: list[BodyJoint]) -> list[BodyJoint]:
    """Mark rails that pass through a pin of their body, or are parallel to an earlier rail that turns with them."""
    result: list[BodyJoint] = []
    for k, joint in enumerate(joints):
        if joint.direction is None or joint.slack:
            result.append(joint)
            continue
        own = [i for i, other in enumerate(joints) if other.body == joint.body and i != k]
        through = next((i for i in own if _runs_through(linkage.mechanism, joint, joints[i])), NONE)
        parallel = next((i for i in range(k) if linkage.sense(joint, joints[i])), NONE)
        point = joints[through].point if through != NONE else joint.point
        result.append(replace(joint, through=through, parallel=parallel, point=point))
    return result


def _runs_through(mechanism: Mechanism, rail: BodyJoint, pin: BodyJoint) -> bool:
    if pin.direction is not None or pin.actuator != NONE or rail.actuator != NONE or rail.direction is None:
        return False
    return abs(((pin.point - rail.point) * rail.direction.conjugate()).imag) <= PARALLEL * mechanism.size
