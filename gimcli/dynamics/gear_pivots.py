"""The part of gear reactions that pushes wheels apart or pulls them together, in the reactions of the pivots."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gimcli.coupling_data import RACK, GearPair
from gimcli.dynamics.gear_reactions import gear_force, rack_direction
from gimcli.dynamics.statics import Statics
from gimcli.errors import ModelError
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.structure.carried import unit_of
from gimcli.structure.joints import sliding_pairs

Change = tuple[int, FloatArray]
"""An unknown, and what 1 N of the part adds to it (rows,)."""


def across(statics: Statics, gear: GearPair, z: ComplexArray) -> ComplexArray:
    """Return the force on the second member for |F| = 1 that passes through the pivots (rows,), at z (nodes, rows)."""
    mechanism = statics.mechanism
    factor = gear_force(mechanism, gear).across
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
        if gear_force(mechanism, gear).across == 0.0:
            continue
        slide = mechanism.pairs[gear.slide].pair if gear.kind == RACK else None
        for friction in mechanism.dynamics.frictions:
            on_pivot = friction.slide < 0 and friction.node in gear.pivots
            if friction.mu and (on_pivot or friction.name == slide):
                raise ModelError(
                    [f"friction: '{friction.name}' bears a force of the gear '{gear.name}', and dry friction there is"
                     " not computed; write a number (viscous friction)"]
                )  # fmt: skip
