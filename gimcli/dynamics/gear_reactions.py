"""Reactions of gears: tooth forces along the line of action, tensions of belts.

The two wheels turn about P1 and P2 on the carrier; D is the distance of the pivots, u the unit vector from P1 to P2, n
that normal to u, to its left; R is the ratio (turns of the second wheel for one of the first, signed), r the radius of
the second wheel. Each gear has one unknown F: the tangential tooth force, or the difference of the tensions of the two
strands of a belt. It gives

    on the second wheel   the force  k F n + s |F| u  at P2  and the couple  r F          k = -(1 - R) r / D
    on the first wheel    the force -k F n - s |F| u  at P1  and the couple -R r F

which are equal and opposite forces on one line. Teeth: k = 1 or -1, so that these are forces at the pitch point;
s = tan(alpha) with the pressure angle alpha, which pushes the wheels apart (-tan(alpha) inside a ring). Belts and
chains: one strand pulls along its tangent line, the other one has no tension: s = -sqrt(1 - k^2). A belt without radii
transmits couples: F is the one on the second wheel, -R F that on the first; the carrier bears the sum, -(1 - R) F.

On a rack, F d acts in the direction d of its travel, at the pitch line, and |F| tan(alpha) away from the pinion.

The forces with |F| pass through the pivots and do not change F. They are added to the reactions of the pivots, and of
the slide of a rack, after the equations were solved. Source: Shigley & Mischke, Mechanical Engineering Design, 1989,
sections 13-15 (spur gears) and 17-2 (flat belts).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from gimcli.coupling_data import BELT, CROSSED, EXTERNAL, INTERNAL, RACK, GearPair
from gimcli.mechanism import Mechanism
from gimcli.structure.carried import carried_direction
from gimcli.structure.steps import Vector

LEAST = 1e-12
"""Part k of a belt force below which it is 0: the wheels are of equal size."""


@dataclass(frozen=True)
class GearForce:
    """What a unit of F exerts: `vector` at `nodes[1]` of the second member, the opposite at `nodes[0]` of the first."""

    vector: Vector | None  # None: only couples
    nodes: tuple[int, int]
    couples: tuple[tuple[int, float], ...]  # (member, factor); without a force about any point
    across: float = 0.0  # s: factor of |F|, of wheels along u on the second one, of a rack away from the pinion


def gear_force(mechanism: Mechanism, gear: GearPair) -> GearForce:
    """Return the reaction of a gear."""
    first, second = gear.members
    if gear.kind == RACK:
        along = carried_direction(mechanism, mechanism.pairs[gear.slide].guide, rack_direction(mechanism, gear))
        own = (second, gear.ratio), (first, -gear.ratio)
        return GearForce(along, (gear.pivots[0],) * 2, own, math.tan(gear.pressure_angle))
    if gear.radii is None:
        couples = ((second, 1.0), (first, -gear.ratio), (gear.carrier, -(1.0 - gear.ratio)))
        return GearForce(None, gear.pivots, couples)
    one, other = (mechanism.members[gear.carrier].local(node) for node in gear.pivots)
    apart, radius = abs(other - one), gear.radii[1]
    part = -(1.0 - gear.ratio) * radius / apart
    vector = Vector(1j * part / apart, *gear.pivots) if abs(part) > LEAST else None
    return GearForce(vector, gear.pivots, ((second, radius), (first, -gear.ratio * radius)), _across(gear, part))


def rack_direction(mechanism: Mechanism, gear: GearPair) -> complex:
    """Return the direction in which a rack moves when its travel increases, in the own frame of the guide."""
    slide = mechanism.pairs[gear.slide]
    return slide.along if slide.guide == gear.carrier else -slide.along


def _across(gear: GearPair, part: float) -> float:
    if gear.kind in (BELT, CROSSED):
        return -math.sqrt(max(0.0, 1.0 - part * part))
    return {EXTERNAL: 1.0, INTERNAL: -1.0}[gear.kind] * math.tan(gear.pressure_angle)
