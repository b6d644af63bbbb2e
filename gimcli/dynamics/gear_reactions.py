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
from collections.abc import Iterator

import numpy as np

from gimcli.coupling_data import BELT, CROSSED, INTERNAL, RACK, GearPair
from gimcli.dynamics.statics import Statics, across_part, rack_direction
from gimcli.errors import ModelError
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.carried import unit_of
from gimcli.structure.joints import sliding_pairs


def across_factor(mechanism: Mechanism, gear: GearPair) -> float:
    """Return s, the factor of |F|: of wheels along u on the second one, of a rack away from the pinion."""
    if gear.radii is None and gear.kind != RACK:
        return 0.0
    if gear.kind in (BELT, CROSSED):
        return -math.sqrt(max(0.0, 1.0 - across_part(mechanism, gear)[0] ** 2))
    return math.tan(gear.pressure_angle) * (-1.0 if gear.kind == INTERNAL else 1.0)


Change = tuple[int, FloatArray]
"""An unknown, and what 1 N of the part adds to it (rows,)."""


def across(statics: Statics, gear: GearPair, z: ComplexArray) -> ComplexArray:
    """Return the force on the second member for |F| = 1 that passes through the pivots (rows,), at z (nodes, rows)."""
    mechanism = statics.mechanism
    factor = across_factor(mechanism, gear)
    if gear.kind == RACK:
        along = unit_of(mechanism, z, mechanism.pairs[gear.slide].guide) * rack_direction(mechanism, gear)
        return np.asarray(-np.sign(gear.ratio) * factor * 1j * along)
    line = z[gear.pivots[1]] - z[gear.pivots[0]]
    return np.asarray(factor * line / np.abs(line))


def add_across(statics: Statics, z: ComplexArray, found: FloatArray, free: FloatArray) -> None:
    """Add these forces to reactions (unknowns, rows), and their changes to self-stresses (., unknowns, rows)."""
    for gear, unknown in zip(statics.mechanism.gears, statics.teeth, strict=True):
        own, stresses = found[unknown].copy(), free[:, unknown].copy()
        for c, change in _changes(statics, gear, z):
            found[c] += np.abs(own) * change
            free[:, c] += np.sign(own) * stresses * change


def _changes(statics: Statics, gear: GearPair, z: ComplexArray) -> Iterator[Change]:
    """Yield what the force for |F| = 1 adds to the reactions that bear it."""
    force = across(statics, gear, z)
    if not np.any(force):
        return
    yield from _on_pivot(statics, gear, 0, -force)
    if gear.kind == RACK:
        yield from _on_slide(statics, gear, z, force)
    else:
        yield from _on_pivot(statics, gear, 1, force)


def _on_pivot(statics: Statics, gear: GearPair, wheel: int, force: ComplexArray) -> Iterator[Change]:
    """Yield the changes of the pin forces on a wheel and on the carrier that balance a force on the wheel."""
    pin = next(pin for pin in statics.pins if pin.node == gear.pivots[wheel])
    for member, sense in ((gear.members[wheel], -1.0), (gear.carrier, 1.0)):
        yield from zip(pin.unknowns.get(member, ()), (sense * force.real, sense * force.imag), strict=False)


def _on_slide(statics: Statics, gear: GearPair, z: ComplexArray, force: ComplexArray) -> Iterator[Change]:
    """Yield the changes of the two normal forces that balance a force on the rack, on a line through the pivot."""
    mechanism = statics.mechanism
    pair = next(pair for pair in sliding_pairs(mechanism) if pair.name == mechanism.pairs[gear.slide].pair)
    (one, two), guide = pair.slides, pair.bodies[0]
    normal = unit_of(mechanism, z, guide) * mechanism.slides[one].normal
    pressed = (force * normal.conj()).real * (-1.0 if guide == gear.carrier else 1.0)
    start, end = z[mechanism.slides[one].node], z[mechanism.slides[two].node]
    share = _height(z[gear.pivots[0]] - start, normal) / _height(end - start, normal)
    yield statics.normals[two], pressed * share
    yield statics.normals[one], pressed * (1.0 - share)


def _height(arm: ComplexArray, direction: ComplexArray) -> FloatArray:
    """Return the moment of a unit force about a point at the distance `arm` (rows,)."""
    return np.asarray((arm.conj() * direction).imag)


def refuse_dry_friction(statics: Statics) -> None:
    """Raise ModelError for dry friction in a pair whose reaction has such a part: it is not in the friction."""
    mechanism = statics.mechanism
    for gear in mechanism.gears:
        if across_factor(mechanism, gear) == 0.0:
            continue
        slide = mechanism.pairs[gear.slide].pair if gear.kind == RACK else None
        for friction in mechanism.dynamics.frictions:
            on_pivot = friction.slide < 0 and friction.node in gear.pivots
            if friction.mu and (on_pivot or friction.name == slide):
                raise ModelError(
                    [f"friction: '{friction.name}' bears a force of the gear '{gear.name}', and dry friction there is"
                     " not computed; write a number (viscous friction)"]
                )  # fmt: skip
