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

from gimcli.dynamics.equilibrium_equations import coefficients
from gimcli.dynamics.friction_pairs import FrictionPair, friction_pairs
from gimcli.dynamics.kinematic_history import Course
from gimcli.dynamics.statics import Statics
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.structure.sliding_pairs import pair_of
from gimcli.structure.steps import NONE

FORMS = 2
"""Most vectors w of a pair."""


@dataclass(frozen=True)
class RubbingPair(FrictionPair):
    """A contact with dry friction, which depends on reactions."""

    forms: tuple[dict[int, complex], ...] = ()  # the vectors w: coefficients by unknown

    def column(self, statics: Statics, course: Course) -> FloatArray:
        """Return the equations of a unit moment or force in the direction of sliding (equations, rows)."""
        found = np.zeros((statics.equations, len(course.time)))
        for row, part in coefficients(statics, self.reaction(statics), course.nodes[0]):
            found[row] += part
        return found

    @property
    def on_pin(self) -> bool:
        """Whether the friction acts on the pin of a node: of a pin in a slot."""
        return self.slide != NONE and len(self.forms) == 1


def rubbing_pairs(statics: Statics) -> tuple[RubbingPair, ...]:
    """Return the contacts with dry friction, in the order of the file."""
    dry = [pair for pair in friction_pairs(statics.mechanism) if pair.friction.mu > 0.0]
    return tuple(RubbingPair(pair.friction, pair.member, pair.first, _forms(statics, pair)) for pair in dry)


def _forms(statics: Statics, contact: FrictionPair) -> tuple[dict[int, complex], ...]:
    mechanism, friction, mu = statics.mechanism, contact.friction, contact.friction.mu
    if contact.slide == NONE:
        x, y = contact.forces(statics)
        return ({x: complex(friction.circle), y: 1j * friction.circle},)
    pair = pair_of(mechanism, contact.slide)
    normals = [statics.normals[k] for k in pair.slides]
    if friction.length == 0.0:
        return ({normals[0]: complex(mu)},)
    one, two = (mechanism.members[pair.body].local(mechanism.slides[k].node) for k in pair.slides)
    lever = complex(mu * abs(two - one) / friction.length)  # 2 |M| / length with M = (N2 - N1) |two - one| / 2
    return {normals[0]: complex(mu), normals[1]: complex(mu)}, {normals[0]: -lever, normals[1]: lever}


def form_table(pairs: tuple[RubbingPair, ...], unknowns: int) -> ComplexArray:
    """Return the vectors w of all pairs (FORMS, pairs, unknowns); 0 where a pair has only one."""
    table = np.zeros((FORMS, len(pairs), unknowns), dtype=complex)
    for k, pair in enumerate(pairs):
        for g, form in enumerate(pair.forms):
            for unknown, weight in form.items():
                table[g, k, unknown] = weight
    return table
