"""Modular reduction: driving links and dyads, one after the other in the order of formation.

A module uses the motion of the links that it is joined to, per unit speed of the driver. It gives the motion of its own
links and their parts of the reduced inertia and torque. z' and z'' are derivatives of a position, w and w' of the angle
of a link, all with respect to the driver's q; s is the travel of a slider along the unit vector u of its guide:

    RRR  a' + i w1 (b - a) = d' + i w2 (b - d)          RRP  a' + i w1 (b - a) = g' + u s'
    RPR  a' = d' + i w (a - d) + u s'                   PRP  g1' + u1 s1' = g2' + u2 s2'
    RPP  a' = g' + u1 s1' + u2 s2'

(g' is that of the guide at the slider). Each is one complex equation in two real unknowns, and so is its derivative.

    J = sum of m |z'|^2 + I w^2,   dJ/dq = 2 sum of m z'.z'' + I w w',   tau = sum of F.z' + T w

Source: Durango, Giraldo, Calle & Mesa 2014, eqs 3-6 and Table 2. Eq. (5) divides by the angular velocity of a link of
the group, which is 0 for the coupler of a parallelogram: here every module is reduced to the driver directly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli import Mechanism, StructureError
from gimcli.dynamics.physical import require_action
from gimcli.mechanism import FRAME, ComplexArray, FloatArray
from gimcli.structure.assur import DYADS, AssurGroup, formation
from gimcli.structure.joints import PRISMATIC, Joint

Places = Any
"""Positions or directions: a complex number, or an array (rows,)."""


@dataclass(frozen=True)
class LinkVelocity:
    """The motion of a link per unit speed of the driver: of its point at z, and its rotation."""

    z: Places = 0.0j
    first: Places = 0.0j  # z'
    second: Places = 0.0j  # z''
    turn: Any = 0.0  # w
    gain: Any = 0.0  # w'

    def at(self, z: Places) -> tuple[Places, Places]:
        """Return z' and z'' of the point of the link at z."""
        arm = z - self.z
        return self.first + 1j * self.turn * arm, self.second + (1j * self.gain - self.turn**2) * arm

    def along(self, z: Places, u: Places, travel: Any, gain: Any) -> tuple[Places, Places]:
        """Return z' and z'' of a point at z that slides along u on the link."""
        first, second = self.at(z)
        return first + u * travel, second + 2j * self.turn * u * travel + u * gain


STILL = LinkVelocity()
"""The frame."""


def shares(u: Places, v: Places, r: Places) -> tuple[Any, Any]:
    """Return the real x and y with x u + y v = r."""
    cross = (np.conj(u) * v).imag
    return (np.conj(r) * v).imag / cross, (np.conj(u) * r).imag / cross


def rotating_driver(base: LinkVelocity, pivot: Places, rate: float = 1.0) -> LinkVelocity:
    """Return the motion of a link that rotates around a point of another link with the driver's speed."""
    return LinkVelocity(pivot, *base.at(pivot), base.turn + rate, base.gain)


def sliding_driver(base: LinkVelocity, z: Places, u: Places, rate: float = 1.0) -> LinkVelocity:
    """Return the motion of a link that slides along u on another with the driver's speed."""
    return LinkVelocity(z, *base.along(z, u, rate, 0.0), base.turn, base.gain)


def rrr(one: LinkVelocity, a: Places, two: LinkVelocity, d: Places, b: Places) -> tuple[LinkVelocity, LinkVelocity]:
    """Return the motions of links a-b and d-b."""
    (va, aa), (vd, ad) = one.at(a), two.at(d)
    p, q = b - a, b - d
    w1, w2 = shares(1j * p, -1j * q, vd - va)
    e1, e2 = shares(1j * p, -1j * q, ad - aa + w1**2 * p - w2**2 * q)
    return LinkVelocity(a, va, aa, w1, e1), LinkVelocity(d, vd, ad, w2, e2)


def rrp(one: LinkVelocity, a: Places, two: LinkVelocity, u: Places, b: Places) -> tuple[LinkVelocity, LinkVelocity]:
    """Return the motions of link a-b and of the slider at b on a guide u of `two`."""
    (va, aa), (vg, ag) = one.at(a), two.at(b)
    p = b - a
    w, travel = shares(1j * p, -u, vg - va)
    e, gain = shares(1j * p, -u, ag + 2j * two.turn * u * travel - aa + w**2 * p)
    return LinkVelocity(a, va, aa, w, e), LinkVelocity(b, *two.along(b, u, travel, gain), two.turn, two.gain)


def rpr(one: LinkVelocity, a: Places, two: LinkVelocity, d: Places, u: Places) -> tuple[LinkVelocity, LinkVelocity]:
    """Return the motions of the links at a and at d, which slide along u on each other."""
    (va, aa), (vd, ad) = one.at(a), two.at(d)
    p = a - d
    w, travel = shares(1j * p, u, va - vd)
    e, _ = shares(1j * p, u, aa - ad + w**2 * p - 2j * w * u * travel)
    return LinkVelocity(a, va, aa, w, e), LinkVelocity(d, vd, ad, w, e)


def prp(one: LinkVelocity, u1: Places, two: LinkVelocity, u2: Places, b: Places) -> tuple[LinkVelocity, LinkVelocity]:
    """Return the motions of two sliders that are pinned to each other at b."""
    (v1, a1), (v2, a2) = one.at(b), two.at(b)
    s1, s2 = shares(u1, -u2, v2 - v1)
    g1, g2 = shares(u1, -u2, a2 + 2j * two.turn * u2 * s2 - a1 - 2j * one.turn * u1 * s1)
    return (
        LinkVelocity(b, *one.along(b, u1, s1, g1), one.turn, one.gain),
        LinkVelocity(b, *two.along(b, u2, s2, g2), two.turn, two.gain),
    )


def rpp(one: LinkVelocity, a: Places, u1: Places, two: LinkVelocity, u2: Places) -> tuple[LinkVelocity, LinkVelocity]:
    """Return the motions of the link at a, which slides along u1 on a slider, and of the slider, along u2 on `two`."""
    (va, aa), (vg, ag) = one.at(a), two.at(a)
    s1, s2 = shares(u1, u2, va - vg)
    _, g2 = shares(u1, u2, aa - ag - 2j * two.turn * (u1 * s1 + u2 * s2))
    return LinkVelocity(a, va, aa, two.turn, two.gain), LinkVelocity(a, *two.along(a, u2, s2, g2), two.turn, two.gain)


@dataclass(frozen=True)
class Module:
    """The reduced inertia and torque of a driving link or a dyad."""

    kind: str  # driver, RRR ...
    links: tuple[str, ...]
    inertia: FloatArray  # (rows,) J per (unit speed)^2: kg m2, or kg times the square of a length unit
    inertia_slope: FloatArray  # (rows,)
    torque: FloatArray  # (rows,) J per unit of the driver


def modular_reduction(mechanism: Mechanism, z: ComplexArray, actuator: int = 0) -> tuple[Module, ...]:
    """Reduce weight, constant loads and masses to one input at positions z (nodes, rows), module by module.

    Raises StructureError for a group that is neither a driving link nor a dyad.
    """
    return _Modules(mechanism, z, actuator).modules()


class _Modules:
    def __init__(self, mechanism: Mechanism, z: ComplexArray, actuator: int) -> None:
        self.mechanism, self.z, self.actuator, self.metre = mechanism, z, actuator, require_action(mechanism)
        self.moved: dict[int, LinkVelocity] = {FRAME: STILL}
        self.links: tuple[str, ...] = ()

    def modules(self) -> tuple[Module, ...]:
        """Return the modules of the groups in the order of formation."""
        formed = formation(self.mechanism)
        self.links = formed.links
        result = []
        for group in formed.groups:
            kind = "driver" if group.driving else group.dyad
            self._move(group, kind)
            names = tuple(formed.links[link] for link in group.links)
            result.append(Module(kind, names, *self._added(group.links)))
        return tuple(result)

    def _move(self, group: AssurGroup, kind: str) -> None:
        if group.driving and len(group.outer) == 1:
            self.moved[group.links[0]] = self._driver(group)
            return
        if kind not in DYADS or group.drivers or group.surplus:
            names = ", ".join(self.links[link] for link in group.links)
            raise StructureError(f"the modular reduction knows driving links and dyads; {names} are another group")
        (inner,), (p, q) = group.inner, group.outer
        if p.kind + inner.kind + q.kind != kind:
            p, q = q, p
        i, base_p = self._sides(p, group)
        j, base_q = self._sides(q, group)
        one, two = self.moved[base_p], self.moved[base_q]
        x, y, mid = self._where(p), self._where(q), self._where(inner)
        if kind == "RRR":
            self.moved[i], self.moved[j] = rrr(one, x, two, y, mid)
        elif kind == "RRP":
            self.moved[i], self.moved[j] = rrp(one, x, two, y, mid)
        elif kind == "RPR":
            self.moved[i], self.moved[j] = rpr(one, x, two, y, mid)
        elif kind == "PRP":
            self.moved[i], self.moved[j] = prp(one, x, two, y, mid)
        else:
            self.moved[i], self.moved[j] = rpp(one, x, mid, two, y)

    def _driver(self, group: AssurGroup) -> LinkVelocity:
        (pair,), (number,) = group.outer, group.drivers
        link, base = self._sides(pair, group)
        actuator, rate = self.mechanism.actuators[number], float(number == self.actuator)
        if actuator.rotary:
            other = actuator.guide if actuator.members[0] == link else actuator.members[0]
            sense = 1.0 if actuator.members[0] == link else -1.0
            base_motion, reference = self.moved[base], self.moved[other]
            pivot = self._where(pair)
            return LinkVelocity(pivot, *base_motion.at(pivot), reference.turn + sense * rate, reference.gain)
        u = self._turn(actuator.guide) * actuator.normal
        sense = 1.0 if actuator.guide != link else -1.0
        return sliding_driver(self.moved[base], self.z[actuator.node], u, sense * rate)

    def _sides(self, pair: Joint, group: AssurGroup) -> tuple[int, int]:
        """Return the link of the group and the other one."""
        first, second = pair.bodies
        return (first, second) if first in group.links else (second, first)

    def _where(self, pair: Joint) -> Places:
        """Return the position of a revolute pair, or the direction of a prismatic pair."""
        if pair.kind != PRISMATIC:
            return self.z[self.mechanism.nodes.index(pair.name)]
        slide = next(s for s in self.mechanism.slides if s.pair == pair.name)
        return self._turn(slide.guide) * slide.along

    def _turn(self, index: int) -> Places:
        """Return e^(i phi) of a member."""
        if index == FRAME:
            return 1.0 + 0.0j
        member = self.mechanism.members[index]
        far = member.base
        return (self.z[member.nodes[far]] - self.z[member.nodes[0]]) / complex(member.shape[far] - member.shape[0])

    def _added(self, links: Sequence[int]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return reduced inertia, its derivative and torque of the masses and loads on some links."""
        rows, dynamics, square = self.z.shape[1], self.mechanism.dynamics, self.metre**2
        inertia, slope, torque = np.zeros(rows), np.zeros(rows), np.zeros(rows)
        for body in dynamics.inertias:
            if body.member in links:
                moved = self.moved[body.member]
                first, second = moved.at(self._place(body.member, body.centre))
                inertia += body.mass * square * np.abs(first) ** 2 + body.moment * moved.turn**2
                slope += 2.0 * body.mass * square * (np.conj(first) * second).real
                slope += 2.0 * body.moment * moved.turn * moved.gain
                torque += body.mass * self.metre * (np.conj(dynamics.gravity) * first).real
        for load in dynamics.loads:
            if load.member in links:
                moved = self.moved[load.member]
                force = load.force * (self._turn(load.member) if load.follows else 1.0)
                first, _ = moved.at(self._place(load.member, load.point))
                torque += self.metre * (np.conj(force) * first).real + load.torque * moved.turn
        return inertia, slope, torque

    def _place(self, index: int, local: complex) -> Places:
        member = self.mechanism.members[index]
        return self.z[member.nodes[0]] + self._turn(index) * (local - complex(member.shape[0]))
