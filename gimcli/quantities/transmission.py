"""Transmission angle of a joint between a driving and a driven part; the transmission of force is best at 90 degrees.

At a pin it is the angle between the lines of the two members. The line of a binary member joins its nodes; that of an
n-ary member goes from the pin to the node from which its dyad is solved, otherwise to its pivot on the frame. At a
sliding pair it is the angle between the member's line and the normal of the guide (90 degrees minus the pressure
angle), at a ram the angle between ram and member. It is between 0 and 180 degrees, and poor near both.
Source: Norton, Design of Machinery, section 3.3; Balli & Chand, Transmission angle in mechanisms, Mech. Mach. Theory
37 (2002) 175-195.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from gimcli.errors import UsageError, refuse
from gimcli.mechanism import FRAME, SPAN, Mechanism
from gimcli.quantities.quantity import ColumnRange, Head, Kind, Quantity, angle_to_file, place_of
from gimcli.quantities.state import ForceLine, State
from gimcli.rates.member_angles import full_turn
from gimcli.structure.joints import PRISMATIC, sliding_pairs
from gimcli.structure.plan import make_plan
from gimcli.structure.rigid_triangles import rigid_bodies
from gimcli.structure.rotation import members_of
from gimcli.structure.steps import Constraint, Coupled, Dyad


@dataclass(frozen=True)
class TransmissionJoint:
    """Two lines that meet at a node."""

    node: int
    first: ForceLine
    second: ForceLine

    @property
    def names(self) -> frozenset[str]:
        """Names of the two parts."""
        return frozenset((self.first.name, self.second.name))


class Transmission(Quantity):
    """The angle between two lines at a joint."""

    def __init__(self, mechanism: Mechanism, spec: str, joint: TransmissionJoint) -> None:
        self.mechanism, self.spec, self.joint = mechanism, spec, joint
        self.heads = (Head(spec, mechanism.angle_unit, "transmission angle"),)

    def values(self, state: State) -> Sequence[Any]:
        """Return the angle, 0 to 180 degrees."""
        first, second = (state.line(line, self.joint.node) for line in (self.joint.first, self.joint.second))
        product = np.conj(first) * second
        angle = np.arctan2(abs(product.imag), product.real)
        return [angle_to_file(self.mechanism, np.where(product == 0.0, np.nan, angle))]

    def whole(self, state: State, ranges: Mapping[str, ColumnRange]) -> dict[str, Any]:
        """Return the least distance of the angle from 0 and 180 degrees in all rows so far."""
        own = ranges[self.spec]
        worst = min(own.least, full_turn(self.mechanism) / 2.0 - own.greatest)
        return {"worst": worst} if np.isfinite(worst) else {}


# -- joints ---------------------------------------------------------------------------------------------


def member_line(mechanism: Mechanism, index: int, joint: int) -> ForceLine | None:
    """Return a member's line at one of its nodes; None if it is ambiguous."""
    member = mechanism.members[index]
    others = [n for n in member.nodes if n != joint]
    if len(others) > 1:
        others = [n for n in others if n in mechanism.members[FRAME].nodes]
    return ForceLine(member.name, others[0]) if index != FRAME and len(others) == 1 else None


def _joined(mechanism: Mechanism, joint: int) -> Iterator[tuple[ForceLine, ForceLine]]:
    """Yield the pairs of lines at a node: of two members, a member and a guide, or a ram and a member."""
    at = [m for m in members_of(mechanism)[joint] if m != FRAME]
    lines = {m: line for m in at if (line := member_line(mechanism, m, joint)) is not None}
    yield from combinations(lines.values(), 2)
    for pair in sliding_pairs(mechanism):
        for slide in (mechanism.slides[k] for k in pair.slides if mechanism.slides[k].node == joint):
            own = pair.bodies if pair.kind == PRISMATIC else pair.bodies[:1]
            yield from ((line, ForceLine(pair.name, slide=slide)) for m, line in lines.items() if m not in own)
    for ram in mechanism.actuators:
        if ram.kind == SPAN and joint in ram.nodes:
            other = ram.nodes[1 - ram.nodes.index(joint)]
            yield from ((ForceLine(ram.name, other), line) for line in lines.values())


def output_joints(mechanism: Mechanism, coupled: bool = True) -> list[TransmissionJoint]:
    """Return the joints inside the dyads, and the pins of strongly `coupled` groups.

    The transmission angles inside dyads are 0 or 180 degrees at dead points only. Joints inside a rigid triangle of
    bars, whose angles are constant, are left out.
    """
    found, body = list[TransmissionJoint](), rigid_bodies(mechanism)
    for step in make_plan(mechanism).steps:
        if isinstance(step, Dyad):
            found += _of_dyad(mechanism, step)
        elif coupled and isinstance(step, Coupled):
            found += [TransmissionJoint(n, *pair) for n in step.nodes for pair in _joined(mechanism, n)]
    return [j for j in found if body.get(j.first.name, j.first.name) != body.get(j.second.name, j.second.name)]


def _of_dyad(mechanism: Mechanism, step: Dyad) -> list[TransmissionJoint]:
    """Return the joint of a dyad between the lines from which its node is solved, so that n-ary members have one too.

    Empty for two guides, or if a line is not known.
    """
    lines = [_locus_line(mechanism, locus) for locus in (step.first, step.second)]
    known = [line for line in lines if line is not None]
    if len(known) < 2 or all(line.slide is not None for line in known):
        return []
    return [TransmissionJoint(step.node, *sorted(known, key=lambda line: line.slide is not None))]


def _locus_line(mechanism: Mechanism, locus: Constraint) -> ForceLine | None:
    """Return the line of the member or ram, or the normal of the guide, that gives a locus of a dyad; None if none."""
    if locus.offset is not None:
        return None
    if locus.kind == SPAN:
        return ForceLine(locus.name, locus.q)
    slides = [s for s in mechanism.slides if s.name == locus.name]
    return ForceLine(slides[0].pair, slide=slides[0]) if slides else None


def joints_at(mechanism: Mechanism, node: int) -> list[TransmissionJoint]:
    """Return all joints at a node, each combination of parts once."""
    own = [joint for joint in output_joints(mechanism) if joint.node == node]
    known = {joint.names for joint in own}
    return own + [j for pair in _joined(mechanism, node) if (j := TransmissionJoint(node, *pair)).names not in known]


# -- construction ---------------------------------------------------------------------------------------


def _make(mechanism: Mechanism, spec: str, names: Sequence[str]) -> Sequence[Quantity]:
    if not names:
        found = output_joints(mechanism)
        refuse((not found, f"measure '{KIND.name}': no output joint was found; write {KIND.name}:NODE/JOINT/NODE"))
        return [_measure(mechanism, joint) for joint in found]
    if len(names) == 1:
        return _at_node(mechanism, spec, place_of(spec, "node", names[0], mechanism.nodes))
    if len(names) == 3:
        first, joint, second = (place_of(spec, "node", name, mechanism.nodes) for name in names)
        refuse((joint in (first, second) or first == second, f"measure '{spec}': expected three different nodes"))
        return [
            Transmission(
                mechanism, spec, TransmissionJoint(joint, ForceLine(names[0], first), ForceLine(names[2], second))
            )
        ]
    return [_between(mechanism, spec, *names)]


def _measure(mechanism: Mechanism, joint: TransmissionJoint) -> Transmission:
    return Transmission(mechanism, f"{KIND.name}:{joint.first.name}/{joint.second.name}", joint)


def _at_node(mechanism: Mechanism, spec: str, node: int) -> Sequence[Quantity]:
    found = joints_at(mechanism, node)
    if not found:
        raise UsageError(
            f"measure '{spec}': no two parts with a unique line meet there; write"
            f" {KIND.name}:NODE/{mechanism.nodes[node]}/NODE"
        )
    return [_measure(mechanism, joint) for joint in found]


def _between(mechanism: Mechanism, spec: str, first: str, second: str) -> Quantity:
    known = [
        *(m.name for m in mechanism.members[FRAME + 1 :]),
        *(s.pair for s in mechanism.slides),
        *(a.name for a in mechanism.actuators if a.kind == SPAN),
    ]
    for name in (first, second):
        place_of(spec, "member, sliding pair or linear actuator", name, known)
    for node in range(len(mechanism.nodes)):
        for joint in joints_at(mechanism, node):
            if joint.names == {first, second}:
                return Transmission(mechanism, spec, joint)
    raise UsageError(
        f"measure '{spec}': the two parts have no common joint at which the lines of both are unique; write"
        f" {KIND.name}:NODE/JOINT/NODE"
    )


KIND = Kind(
    "transmission",
    "NODE, PART/PART, NODE/JOINT/NODE, or nothing for all output joints",
    "transmission angle (0 to 180 deg, 90 is best) of two members, a member and a sliding pair, or a linear actuator"
    " and a member",
    (0, 1, 2, 3),
    _make,
)
