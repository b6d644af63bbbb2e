"""Masses, loads, springs, dampers and friction in the flat arrays of the reduction kernels.

The pairs with friction, each member on a pin but the first, and each sliding pair, are listed once for all analyses.

A load over a table that ends inside the motion keeps its last factor, which is seldom meant: such tables are listed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from gimcli.dynamic_data import NO_NODE, TIME, AppliedLoad, Friction, Inertia, SpringForce
from gimcli.dynamics.kinematic_history import Course, reading, travel_along, turning
from gimcli.dynamics.statics import Reaction, Statics
from gimcli.kernels.equilibrium import COUPLE
from gimcli.mechanism import FRAME, HEIGHT, SPAN, FloatArray, Input, IntArray, Mechanism
from gimcli.structure.carried import carried_direction
from gimcli.structure.joints import pair_of
from gimcli.structure.rotation import members_of, rotation_classes
from gimcli.structure.steps import NONE

if TYPE_CHECKING:
    from gimcli.kernels.reduction import Acting


@dataclass(frozen=True)
class FrictionPair:
    """A contact with friction: a member on the pin of a node, or a sliding pair."""

    friction: Friction
    member: int = NONE  # that turns on the pin; NONE for a sliding pair
    first: int = NONE  # member to which the pin is fixed; NONE for a sliding pair

    def rate(self, mechanism: Mechanism, course: Course) -> FloatArray:
        """Return the speed of sliding (rows,): rad/s of a pin, normal length per s of a sliding pair."""
        if self.friction.slide == NONE:
            own, other = (turning(mechanism, course, member)[0] for member in (self.member, self.first))
            found: FloatArray = own - other
            return found
        slide = mechanism.slides[self.friction.slide]
        return reading(mechanism, travel_along(slide, slide.name), course)[1]

    @property
    def on_pin(self) -> bool:
        """Whether the friction acts on the pin of a node: of a pin in a slot."""
        return self.friction.slide != NONE and self.friction.length == 0.0

    def forms(self, statics: Statics) -> tuple[dict[int, complex], ...]:
        """Return the vectors w of dry friction, the sum of |w . unknowns|: coefficients by unknown."""
        friction, mu = self.friction, self.friction.mu
        if self.friction.slide == NONE:
            x, y = next(pin for pin in statics.pins if pin.node == friction.node).unknowns[self.member]
            return ({x: complex(friction.circle), y: 1j * friction.circle},)
        pair = pair_of(statics.mechanism, self.friction.slide)
        first, *others = (statics.normals[k] for k in pair.slides)
        if self.on_pin:
            return ({first: complex(mu)},)
        one, two = (statics.mechanism.members[pair.bodies[1]].local(node) for node in pair.nodes)
        lever = complex(mu * abs(two - one) / friction.length)  # 2 |M| / length with M = (N2 - N1) |two - one| / 2
        return {first: complex(mu), others[0]: complex(mu)}, {first: -lever, others[0]: lever}

    def reaction(self, statics: Statics) -> Reaction:
        """Return a unit moment or force in the direction of sliding, as if it were unknown."""
        if self.friction.slide == NONE:
            return Reaction(COUPLE, statics.body_of_member[self.member], statics.body_of_member[self.first])
        slide = statics.mechanism.slides[self.friction.slide]
        along = carried_direction(statics.mechanism, slide.guide, slide.along)
        return replace(statics.reactions[statics.normals[self.friction.slide]], vector=along)


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


COMPONENT = " across"
"""End of the name of a gauge that measures the second component of a spring's vector."""

FRICTION_GAUGE = "friction in "
"""Start of the name of a gauge that measures a sliding pair with friction."""


def is_vector(mechanism: Mechanism, spring: SpringForce) -> bool:
    """Return whether the force of a spring is the vector k (a - b): it is proportional to the distance of two nodes."""
    return mechanism.gauges[spring.gauge].kind == SPAN and spring.proportional


def with_force_gauges(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with gauges for sliding pairs that have friction, and for springs of free length 0."""
    mechanism, extra = _with_components(mechanism), list[Input]()
    for friction in mechanism.dynamics.frictions:
        if friction.slide >= 0:
            slide = mechanism.slides[friction.slide]
            away = complex(mechanism.drawn[slide.node])
            extra.append(replace(travel_along(slide, FRICTION_GAUGE + friction.name), drawn=abs(away)))
    return replace(mechanism, gauges=(*mechanism.gauges, *extra))


def _with_components(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with two components of the vector in place of the length of springs of free length 0.

    The components are heights over one end in the frame of its first member; they are regular where the ends meet.
    """
    gauges, springs, holders = list(mechanism.gauges), list(mechanism.dynamics.springs), members_of(mechanism)
    for spring in mechanism.dynamics.springs:
        gauge = mechanism.gauges[spring.gauge]
        ends = [n for n in gauge.nodes[:2] if holders[n]] if is_vector(mechanism, spring) else []
        if not ends:  # else both ends are blocks without a member
            continue
        end = min(ends, key=lambda n: holders[n][0] != FRAME)
        held, other = holders[end][0], gauge.nodes[gauge.nodes[0] == end]
        member = mechanism.members[held]
        place = complex(member.shape[member.nodes.index(end)])
        for normal, name in ((1.0 + 0.0j, gauge.name), (1.0j, gauge.name + COMPONENT)):
            gauges.append(Input(name, HEIGHT, (other, end), (held,), place, normal))
        gauges[spring.gauge] = gauges.pop(-2)
        springs.append(replace(spring, gauge=len(gauges) - 1))
    dynamics = replace(mechanism.dynamics, springs=tuple(springs))
    return replace(mechanism, gauges=tuple(gauges), dynamics=dynamics)


def acting(mechanism: Mechanism, released: Sequence[int], metre: float) -> Acting:
    """Return the arrays of a mechanism returned by `with_force_gauges`; `released` are its free inputs."""
    dynamics, read = mechanism.dynamics, mechanism.gauges
    first = 2 * len(mechanism.nodes)
    gauges = first + len(mechanism.actuators)
    masses = [(part, *_arm_of(mechanism, part, part.centre)) for part in dynamics.inertias if part.member != FRAME]
    loads = [(part, *_arm_of(mechanism, part, part.point)) for part in moving_loads(mechanism)]
    # the kernel multiplies forces that follow a member by its arm, not by a unit vector
    forces = [part.force / mechanism.members[part.member].ends[2] if part.follows else part.force for part, *_ in loads]
    slid = [f for f in dynamics.frictions if f.slide >= 0]
    dampers = [(gauges + d.gauge, d.damping) for d in dynamics.dampers]
    dampers += [(gauges + len(read) - len(slid) + k, f.damping) for k, f in enumerate(slid)]
    rubs, rub = _pivots(mechanism)
    efforts = {r.actuator: r.effort for r in dynamics.releases}
    units = [*[metre] * first, *(1.0 if row.rotary else metre for row in (*mechanism.actuators, *read))]
    from gimcli.kernels.reduction import Acting

    return Acting(
        metre,
        np.array(units),
        ints([(u, v) for _, u, v, *_ in masses], 2),
        _floats([(z.real, z.imag, m.mass, m.moment, square) for m, _, _, z, square in masses], 5),
        np.array([dynamics.gravity.real, dynamics.gravity.imag]),
        ints([(u, v, int(load.follows)) for load, u, v, *_ in loads], 3),
        _floats([
            (z.real, z.imag, force.real, force.imag, load.torque, square)
            for (load, _, _, z, square), force in zip(loads, forces, strict=True)
        ], 6),
        ints([(gauges + s.gauge, int(read[s.gauge].kind == SPAN)) for s in dynamics.springs], 2),
        np.array([s.law for s in dynamics.springs] or np.empty((0, 1)), dtype=float),
        np.array([d[0] for d in dampers], dtype=np.int64),
        np.array([d[1] for d in dampers], dtype=float),
        ints(rubs, 4),
        _floats(rub, 3),
        np.array([first + k for k in released], dtype=np.int64),
        _floats([(efforts[k].constant, efforts[k].idle) for k in released], 2),
        np.array([first + rotor.actuator for rotor in dynamics.rotors], dtype=np.int64),
        np.array([rotor.reflected for rotor in dynamics.rotors], dtype=float),
    )  # fmt: skip


def point_masses(mechanism: Mechanism) -> list[str]:
    """Return the names of the members that can turn and have a mass, but no moment of inertia in the file."""
    turning = rotation_classes(mechanism).of
    own = [i for i in mechanism.dynamics.inertias if i.mass > 0.0 and not i.stated]
    return [mechanism.members[i.member].name for i in own if turning[i.member] != turning[FRAME]]


def moving_loads(mechanism: Mechanism) -> list[AppliedLoad]:
    """Return the loads on members that move."""
    return [load for load in mechanism.dynamics.loads if load.member != FRAME]


def _pivots(mechanism: Mechanism) -> tuple[Sequence[Sequence[int]], Sequence[Sequence[float]]]:
    """Return the members with friction in revolute pairs, each paired with the first member at the node."""
    pins = [pair for pair in friction_pairs(mechanism) if pair.friction.slide == NONE]
    arms = [(_arm(mechanism, pair.member, 0j), _arm(mechanism, pair.first, 0j)) for pair in pins]
    rubs = [(*own[:2], *other[:2]) for own, other in arms]
    return rubs, [(pair.friction.damping, own[3], other[3]) for pair, (own, other) in zip(pins, arms, strict=True)]


def _arm_of(mechanism: Mechanism, part: Inertia | AppliedLoad, local: complex) -> tuple[int, int, complex, float]:
    """Return the arm that carries the point of a part, as `_arm`; of a part at a node, this node twice."""
    return _arm(mechanism, part.member, local) if part.node == NO_NODE else (part.node, part.node, 0j, 1.0)


def _arm(mechanism: Mechanism, index: int, local: complex) -> tuple[int, int, complex, float]:
    """Return u, v and z of a point u + z (v - u) of a member, and the square of its arm, which divides its rates."""
    if index == FRAME:
        return NONE, NONE, 0j, 1.0
    member = mechanism.members[index]
    u, v, span = member.ends
    return u, v, (local - complex(member.shape[0])) / span, float(abs(span) ** 2)


def ints(table: Sequence[Sequence[int]], width: int) -> IntArray:
    """Return a table of whole numbers of some width, which may be empty."""
    return np.array(table, dtype=np.int64).reshape(-1, width)


def _floats(table: Sequence[Sequence[float]], width: int) -> FloatArray:
    return np.array(table, dtype=float).reshape(-1, width)


SAMPLES = 513
"""Times at which a law is evaluated for its range."""

OUTSIDE = 1e-9
"""Part of the range of a law that may be outside of a table."""


def short_tables(mechanism: Mechanism) -> Iterator[tuple[str, str, list[float], list[float]]]:
    """Yield load, actuator, range of the table and range of the law, where the table does not cover the law.

    The ranges are in the file's units. Tables over the time are left out: a load may well end before the motion does.
    """
    for load in mechanism.dynamics.loads:
        if load.curve is None or load.over == TIME:
            continue
        values = mechanism.actuators[load.over].law(np.linspace(0.0, 1.0, SAMPLES))
        law, table = (np.array([np.min(v), np.max(v)]) for v in (values, load.curve.at))
        slack = OUTSIDE * max(float(law[1] - law[0]), 1e-12)
        if law[0] < table[0] - slack or law[1] > table[1] + slack:
            own, whole = (mechanism.value_to_file(load.over, span).tolist() for span in (table, law))
            yield load.name, mechanism.actuators[load.over].name, own, whole
