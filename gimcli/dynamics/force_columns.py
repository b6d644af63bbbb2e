"""Forces, moments, powers and energies of a motion by name: each is a formula of `Forces`, with its unit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gimcli.coupling_data import BELT, CROSSED, GearPair
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.kinematic_history import reading
from gimcli.dynamics.loading import POWERS
from gimcli.dynamics.physical import input_units, require_action
from gimcli.dynamics.statics import Pin, Statics
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.table import Column, xy_columns

SHARED = "unique"
"""Part of the column name for the component of a reaction that is still determined if the whole reaction is not."""

TANGENTIAL, TENSION, TORQUE = "tangential", "tension", "torque"
"""Ends of the names of columns: tooth force along the pitch lines, difference of the tensions, torque of a belt."""


class ForceColumn(NamedTuple):
    """A formula of forces with its name and unit; of a vector the name is that of its columns without x and y."""

    name: str
    unit: str
    find: Callable[[Forces], NDArray[Any]]  # (rows,), x + iy of a vector
    vector: bool = False
    dry: bool = False  # whether it is found for dry friction along the laws, or at rest

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return (f"{self.name}x", f"{self.name}y") if self.vector else (self.name,)

    def columns(self, forces: Forces) -> list[Column]:
        """Return the columns (rows,)."""
        found = self.find(forces)
        return xy_columns(self.name, found, self.unit) if self.vector else [Column(self.name, found, self.unit)]


def effort_unit(mechanism: Mechanism, actuator: int) -> str:
    """Return the unit of the effort of an actuator."""
    return "N m" if mechanism.actuators[actuator].rotary else "N"


def reactions(statics: Statics) -> Iterator[ForceColumn]:
    """Yield efforts, reactions and moments; an indeterminate reaction is NaN."""
    mechanism = statics.mechanism
    for k, actuator in enumerate(mechanism.actuators):
        if k not in mechanism.geared:
            yield ForceColumn(f"{actuator.name}.effort", effort_unit(mechanism, k), partial(Forces.effort, actuator=k))
    for pin in statics.pins:
        for member in pin.members[1:] if _alone(pin) else pin.members:
            name = reaction_name(statics, pin, member)
            yield ForceColumn(f"{name}.f", "N", partial(Forces.pin, pin=pin, member=member), True)
            if pin.node in statics.open_pins:
                shared = partial(Forces.pin_shared, pin=pin, member=member)
                yield ForceColumn(f"{name}.{SHARED}.f", "N", shared, True)
    for pair in dict.fromkeys(slide.pair for slide in mechanism.slides):
        yield ForceColumn(f"{pair}.normal", "N", partial(Forces.normal, pair=pair))
        if sum(slide.pair == pair for slide in mechanism.slides) > 1:
            yield ForceColumn(f"{pair}.moment", "N m", partial(Forces.moment, pair=pair))
    for gear, unknown in zip(mechanism.gears, statics.teeth, strict=True):
        yield from _of_gear(gear, unknown)


def totals(statics: Statics) -> Iterator[ForceColumn]:
    """Yield the force and the moment on the frame, powers and energies."""
    yield ForceColumn("shaking.f", "N", attrgetter("shaking_force"), True)
    yield ForceColumn("shaking.moment", "N m", attrgetter("shaking_moment"))
    kinds: dict[str, Any] = {
        "drive": attrgetter("drive_power"),
        **{kind: partial(_power, kind=kind) for kind in POWERS},
    }
    for kind, find in {**kinds, "error": attrgetter("power_error")}.items():
        yield ForceColumn(f"power.{kind}", "W", partial(_only, find=find))
    for kind in ("kinetic", "potential"):
        yield ForceColumn(f"energy.{kind}", "J", partial(_only, find=attrgetter(f"loads.{kind}")))


def rotors(statics: Statics) -> Iterator[ForceColumn]:
    """Yield torque [N m] and speed [rev/min] of each rotor, positive in its own positive sense."""
    mechanism = statics.mechanism
    for k, rotor in enumerate(mechanism.dynamics.rotors):
        name = f"{mechanism.actuators[rotor.actuator].name}.rotor"
        yield ForceColumn(f"{name}.torque", "N m", partial(_rotor_torque, number=k))
        yield ForceColumn(f"{name}.speed", "1/min", partial(_rotor_speed, number=k))


def _rotor_torque(forces: Forces, number: int) -> FloatArray:
    rotor = forces.mechanism.dynamics.rotors[number]
    return forces.effort(rotor.actuator) * float(input_units(forces.mechanism)[rotor.actuator]) / rotor.ratio


def _rotor_speed(forces: Forces, number: int) -> FloatArray:
    rotor = forces.mechanism.dynamics.rotors[number]
    rate = reading(forces.mechanism, forces.mechanism.actuators[rotor.actuator], forces.course)[1]
    return forces.only(rotor.ratio * rate * 30.0 / math.pi)


def springs(statics: Statics) -> Iterator[ForceColumn]:
    """Yield length or angle, and force [N] or torque [N m], of springs (of a stretched one positive) and of dampers."""
    mechanism = statics.mechanism
    words = {
        True: ("angle", "torque", mechanism.angle_unit, "N m"),
        False: ("length", "force", mechanism.length_unit, "N"),
    }
    for k, spring in enumerate(mechanism.dynamics.springs):
        value, effort, unit, newton = words[mechanism.gauges[spring.gauge].rotary]
        yield ForceColumn(f"{spring.name}.{value}", unit, partial(_spring_value, number=k))
        yield ForceColumn(f"{spring.name}.{effort}", newton, partial(_effort, number=k))
    for k, damper in enumerate(mechanism.dynamics.dampers, start=len(mechanism.dynamics.springs)):
        newton = words[mechanism.gauges[damper.gauge].rotary][3]
        yield ForceColumn(f"{damper.name}.damping", newton, partial(_effort, number=k))


def _spring_value(forces: Forces, number: int) -> FloatArray:
    own, spring = forces.mechanism, forces.mechanism.dynamics.springs[number]
    factor = own.scale if not own.gauges[spring.gauge].rotary else math.degrees(1.0) if own.angle_unit == "deg" else 1.0
    found: FloatArray = forces.loads.gauges[spring.gauge][0] * factor
    return found


def _effort(forces: Forces, number: int) -> FloatArray:
    found: FloatArray = -forces.loads.efforts[number].amount
    return found


def seen_from_members(statics: Statics) -> Iterator[ForceColumn]:
    """Yield the pin forces in the frames of the members, for polar diagrams: `A@crank.f`.

    The x axis of a member's frame points from its first node to its second one, as in the model file.
    """
    own = {one.name: one for one in reactions(statics)}
    for pin in statics.pins:
        names = dict.fromkeys(reaction_name(statics, pin, member) for member in pin.members)
        for name in [statics.mechanism.nodes[pin.node]] if _alone(pin) else names:
            for member in (k for k in pin.members if k != FRAME):
                find = partial(_turned, reaction=own[f"{name}.f"], member=member)
                yield ForceColumn(f"{name}@{statics.mechanism.members[member].name}.f", "N", find, True)


def columns_of(forces: Forces, formulas: Iterable[ForceColumn]) -> list[Column]:
    """Return the columns of formulas."""
    return [column for one in formulas for column in one.columns(forces)]


def _alone(pin: Pin) -> bool:
    """Return whether a pin has one reaction, between two members, with the name of the node."""
    return len(pin.members) == 2 and not pin.loaded


def _turned(forces: Forces, reaction: ForceColumn, member: int) -> ComplexArray:
    first, second = forces.mechanism.members[member].nodes[:2]
    along = forces.course.nodes[0, second] - forces.course.nodes[0, first]
    with np.errstate(invalid="ignore"):
        found: ComplexArray = reaction.find(forces) * along.conjugate() / abs(along)
    return found


def _of_gear(gear: GearPair, unknown: int) -> Iterator[ForceColumn]:
    """Yield the reactions of gears [N], of belts without radii the torque on the second wheel [N m]."""

    def torque(forces: Forces) -> FloatArray:
        return forces.unknown(unknown) * require_action(forces.mechanism)

    def force(forces: Forces) -> ComplexArray:  # on the second member: of the teeth, or of the strand under tension
        from gimcli.dynamics.gear_reactions import across  # imported late: only for models with gears

        value, own = forces.unknown(unknown), forces.statics
        part = 0.0 if own.reactions[unknown].vector.u < 0 and gear.slide < 0 else forces.direction(unknown)
        return np.asarray(value * part + np.abs(value) * across(own, gear, forces.course.nodes[0]))

    if gear.radii is None:
        yield ForceColumn(f"{gear.name}.{TORQUE}", "N m", torque)
        return
    yield ForceColumn(f"{gear.name}.f", "N", force, True)
    kind = TENSION if gear.kind in (BELT, CROSSED) else TANGENTIAL
    yield ForceColumn(f"{gear.name}.{kind}", "N", partial(Forces.unknown, number=unknown))


def _power(forces: Any, kind: str) -> Any:
    """Return the power of a kind of force; results with such columns are pickled."""
    return forces.loads.power[kind]


def _only(forces: Forces, find: Callable[[Forces], FloatArray]) -> FloatArray:
    return forces.only(find(forces))


def reaction_name(statics: Statics, pin: Pin, member: int) -> str:
    """Return the name of the reaction of a pin on a member, as in the columns of the table."""
    node, alone = statics.mechanism.nodes[pin.node], len(pin.members) == 2 and not pin.loaded
    return node if alone else f"{node}.{statics.mechanism.members[member].name}"
