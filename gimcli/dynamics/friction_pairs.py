"""Pairs with friction: each member on a pin but the first, and each sliding pair, listed once for all analyses."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gimcli.dynamic_data import Friction
from gimcli.dynamics.kinematic_history import Course, reading, travel_along, turning
from gimcli.dynamics.statics import Reaction, Statics
from gimcli.kernels.equilibrium import COUPLE
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.carried import carried_direction
from gimcli.structure.rotation import members_of
from gimcli.structure.steps import NONE


@dataclass(frozen=True)
class FrictionPair:
    """A contact with friction: a member on the pin of a node, or a sliding pair."""

    friction: Friction
    member: int = NONE  # that turns on the pin; NONE for a sliding pair
    first: int = NONE  # member to which the pin is fixed; NONE for a sliding pair

    @property
    def name(self) -> str:
        """The name of the entry in `friction`."""
        return self.friction.name

    @property
    def slide(self) -> int:
        """The number of the first height of a sliding pair; NONE for a pin."""
        return self.friction.slide

    def rate(self, mechanism: Mechanism, course: Course) -> FloatArray:
        """Return the speed of sliding (rows,): rad/s of a pin, normal length per s of a sliding pair."""
        if self.slide == NONE:
            own, other = (turning(mechanism, course, member)[0] for member in (self.member, self.first))
            found: FloatArray = own - other
            return found
        return self._travel(mechanism, course)[1]

    def direction(self, mechanism: Mechanism, course: Course) -> ComplexArray:
        """Return the direction of sliding of a sliding pair, of the node along the guide (rows,)."""
        return self._travel(mechanism, course)[2]

    def _travel(self, mechanism: Mechanism, course: Course) -> tuple[FloatArray, FloatArray, ComplexArray]:
        slide = mechanism.slides[self.slide]
        return reading(mechanism, travel_along(slide, slide.name), course)

    def forces(self, statics: Statics) -> tuple[int, int]:
        """Return the unknowns of the force of a pin on the member that turns."""
        pin = next(pin for pin in statics.pins if pin.node == self.friction.node)
        first = pin.first + 2 * (pin.members.index(self.member) - 1)
        return first, first + 1

    def reaction(self, statics: Statics) -> Reaction:
        """Return a unit moment or force in the direction of sliding, as if it were unknown."""
        if self.slide == NONE:
            return Reaction(COUPLE, statics.body_of_member[self.member], statics.body_of_member[self.first])
        slide = statics.mechanism.slides[self.slide]
        along = carried_direction(statics.mechanism, slide.guide, slide.along)
        return replace(statics.reactions[statics.normals[self.slide]], vector=along)


def friction_pairs(mechanism: Mechanism) -> list[FrictionPair]:
    """Return the contacts with friction, in the order of the file."""
    found: list[FrictionPair] = []
    for friction in mechanism.dynamics.frictions:
        if friction.slide != NONE:
            found.append(FrictionPair(friction))
        else:
            first, *others = members_of(mechanism)[friction.node]
            found += [FrictionPair(friction, member, first) for member in others]
    return found
