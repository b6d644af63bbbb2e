"""Pairs with dry friction: how their friction depends on the reactions, and on which bodies it acts.

The friction of each pair is phi(x) = max |w . x| over one or two complex vectors w, x being the unknown reactions:

    pin            moment rho |R|                          w = rho on the x force, i rho on the y force
    pin in a slot  force mu |N|                            w = mu
    guide          force mu max(|N|, 2 |M| / length)       w = mu (1, 1); w = mu (distance of nodes / length) (-1, 1)

rho = r mu / sqrt(1 + mu^2) is the radius of the friction circle. The guide has two contacts at +-length/2 from the
middle of the two nodes: N1 + N2 = N and (N2 - N1) length/2 = M, M about the middle, so |N1| + |N2| is the maximum.
Always phi(a + b) <= phi(a) + phi(b). Moments are in N times the length unit of the normal frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.dynamic_data import Friction
from gimcli.dynamics.kinematic_history import Course, reading, travel_along, turning
from gimcli.dynamics.statics import Statics
from gimcli.kernels.equilibrium import MOMENT
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.sliding_pairs import pair_of
from gimcli.structure.steps import NONE

FORMS = 2
"""Most vectors w of a pair."""


@dataclass(frozen=True)
class DryPair:
    """A contact with dry friction: a member on the pin of a node, or a sliding pair."""

    name: str  # of the entry in `friction`
    member: int = NONE  # that turns on the pin; NONE for a sliding pair
    first: int = NONE  # member to which the pin is fixed; NONE for a sliding pair
    slide: int = NONE  # number of the first height of a sliding pair; NONE for a pin

    def rate(self, mechanism: Mechanism, course: Course) -> FloatArray:
        """Return the speed of sliding (rows,): rad/s of a pin, normal length per s of a sliding pair."""
        if self.slide == NONE:
            return np.asarray(turning(mechanism, course, self.member)[0] - turning(mechanism, course, self.first)[0])
        return self._travel(mechanism, course)[1]

    def direction(self, mechanism: Mechanism, course: Course) -> ComplexArray:
        """Return the direction of sliding of a sliding pair, of the node along the guide (rows,)."""
        return self._travel(mechanism, course)[2]

    def _travel(self, mechanism: Mechanism, course: Course) -> tuple[FloatArray, FloatArray, ComplexArray]:
        slide = mechanism.slides[self.slide]
        return reading(mechanism, travel_along(slide, slide.name), course)


@dataclass(frozen=True)
class RubbingPair(DryPair):
    """A contact whose friction depends on reactions."""

    forms: tuple[dict[int, complex], ...] = ()  # the vectors w: coefficients by unknown

    def column(self, statics: Statics, course: Course) -> FloatArray:
        """Return the equations of a unit moment or force in the direction of sliding (equations, rows)."""
        found = np.zeros((statics.equations, len(course.time)))
        if self.slide == NONE:
            for member, sense in ((self.member, 1.0), (self.first, -1.0)):
                body = statics.body_of_member[member]
                if body != NONE:
                    found[statics.first_row[body] + MOMENT] += sense
            return found
        z, unit = course.nodes[0], self.direction(statics.mechanism, course)
        node = statics.mechanism.slides[self.slide].node
        reaction = statics.reactions[statics.normals[self.slide]]
        for body, sense in ((reaction.plus, 1.0), (reaction.minus, -1.0)):
            if body != NONE:
                row, own = statics.first_row[body], statics.bodies[body]
                found[row], found[row + 1] = found[row] + sense * unit.real, found[row + 1] + sense * unit.imag
                if own.member != NONE:
                    found[row + MOMENT] += sense * ((z[node] - z[own.node]).conj() * unit).imag
        return found

    @property
    def on_pin(self) -> bool:
        """Whether the friction acts on the pin of a node: of a pin in a slot."""
        return self.slide != NONE and len(self.forms) == 1


def rubbing_pairs(statics: Statics) -> tuple[RubbingPair, ...]:
    """Return the contacts with dry friction, in the order of the file."""
    found: list[RubbingPair] = []
    for friction in statics.mechanism.dynamics.frictions:
        if friction.mu > 0.0:
            found += [_sliding(statics, friction)] if friction.slide != NONE else _turning(statics, friction)
    return tuple(found)


def _turning(statics: Statics, friction: Friction) -> list[RubbingPair]:
    """Return a contact for each member on a pin but the first, to which the pin is fixed."""
    pin = next(pin for pin in statics.pins if pin.node == friction.node)
    rho, found = friction.circle, []
    for k, member in enumerate(pin.members[1:]):
        unknown = pin.first + 2 * k
        forms = ({unknown: complex(rho), unknown + 1: 1j * rho},)
        found.append(RubbingPair(friction.name, member, pin.members[0], NONE, forms))
    return found


def _sliding(statics: Statics, friction: Friction) -> RubbingPair:
    mechanism, mu = statics.mechanism, friction.mu
    pair = pair_of(mechanism, friction.slide)
    normals = [statics.normals[k] for k in pair.slides]
    if friction.length == 0.0:
        return RubbingPair(friction.name, NONE, NONE, friction.slide, ({normals[0]: complex(mu)},))
    one, two = (mechanism.members[pair.body].local(mechanism.slides[k].node) for k in pair.slides)
    lever = complex(mu * abs(two - one) / friction.length)  # 2 |M| / length with M = (N2 - N1) |two - one| / 2
    forms = ({normals[0]: complex(mu), normals[1]: complex(mu)}, {normals[0]: -lever, normals[1]: lever})
    return RubbingPair(friction.name, NONE, NONE, friction.slide, forms)


def form_table(pairs: tuple[RubbingPair, ...], unknowns: int) -> ComplexArray:
    """Return the vectors w of all pairs (FORMS, pairs, unknowns); 0 where a pair has only one."""
    table = np.zeros((FORMS, len(pairs), unknowns), dtype=complex)
    for k, pair in enumerate(pairs):
        for g, form in enumerate(pair.forms):
            for unknown, weight in form.items():
                table[g, k, unknown] = weight
    return table
