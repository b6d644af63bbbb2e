"""Positions, velocities and accelerations of a motion as arrays, and quantities computed from them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gimcli.canonical import beside
from gimcli.mechanism import FRAME, HEIGHT, SPAN, ComplexArray, FloatArray, Input, Mechanism, PairRow
from gimcli.motion.motion import Motion
from gimcli.positions.dispatch import choose
from gimcli.progress import Notify
from gimcli.rates.derivatives import ORDERS, law_rates
from gimcli.rates.differentiator import Differentiator
from gimcli.structure.plan import make_plan


@dataclass(frozen=True)
class Course:
    """A motion as arrays; rows are the last axis."""

    time: FloatArray  # (rows,) s
    inputs: FloatArray  # (actuators, rows) rad, or length in the normal frame
    nodes: ComplexArray = field(repr=False)  # (3, nodes, rows): position, velocity, acceleration by s, normal frame
    angles: FloatArray | None = field(default=None, repr=False)  # (2, members, rows) omega, alpha; all but the frame


class Courses:
    """Computes velocities and accelerations of a motion in pieces."""

    def __init__(self, mechanism: Mechanism, rows: int = 0, jit: str = "off", notify: Notify | None = None) -> None:
        self.mechanism = mechanism
        self._made = Differentiator(mechanism, make_plan(mechanism), ORDERS[:2], mechanism.nodes)
        self._run = choose(jit, self._made.plain_seconds(rows), notify, ("play",))

    def __call__(self, motion: Motion) -> Course:
        """Return positions, velocities and accelerations of a piece, the inputs following their laws."""
        nodes, angles = self._made(motion.z, law_rates(self.mechanism, motion.time, 2), self._run)
        return Course(motion.time * self.mechanism.duration, motion.inputs, nodes, angles)

    def at_unit_speed(self, motion: Motion) -> Course:
        """Return positions and velocities of a piece; the independent inputs move at 1 rad, or length, per s."""
        given = law_rates(self.mechanism, motion.time, 2)
        given[1], given[2] = self.mechanism.following.sum(axis=1)[:, None], 0.0
        nodes, angles = self._made(motion.z, given, self._run)
        return Course(motion.time * self.mechanism.duration, motion.inputs, nodes, angles)


class Turns:
    """Continues angles from piece to piece without jumps, so that a torsion spring can make whole turns."""

    def __init__(self) -> None:
        self.last: dict[int, float] = {}

    def copy(self) -> Turns:
        """Return a copy, which continues from the same angles."""
        copy = Turns()
        copy.last = dict(self.last)
        return copy

    def followed(self, key: int, angle: FloatArray, drawn: float) -> FloatArray:
        """Return an angle [rad] without jumps (rows,), continued from the last one or from the initial one."""
        good = np.flatnonzero(np.isfinite(angle))
        if not len(good):
            return angle
        path = np.unwrap(np.concatenate(([self.last.get(key, drawn)], angle[good])))[1:]
        self.last[key] = float(path[-1])
        result = np.full_like(angle, np.nan)
        result[good] = path
        return result


def carried(mechanism: Mechanism, nodes: ComplexArray, index: int, local: complex) -> ComplexArray:
    """Return position, velocity ... of a point of a member from those of the nodes (., nodes, rows).

    `local` is the point in the member's own frame; the result is in the normal frame (., rows).
    """
    if index == FRAME:
        jet = np.zeros((len(nodes), nodes.shape[2]), dtype=complex)
        jet[0] = local
        return jet
    member = mechanism.members[index]
    u, v, span = member.ends
    share, z, other = (local - complex(member.shape[0])) / span, nodes[:, u], nodes[:, v]
    return np.asarray(z + share * (other - z)) if share else np.asarray(z)


def unit_of(mechanism: Mechanism, z: ComplexArray, index: int) -> ComplexArray:
    """Return e^(i phi) of a member (rows,) at positions z (nodes, rows)."""
    if index == FRAME:
        return np.ones(z.shape[1], dtype=complex)
    u, v, span = mechanism.members[index].ends
    return np.asarray((z[v] - z[u]) / span)


def turning(mechanism: Mechanism, course: Course, index: int) -> FloatArray:
    """Return omega and alpha of a member (2, rows) [rad/s, rad/s^2]."""
    if index == FRAME:
        return np.zeros((2, len(course.time)))
    if course.angles is not None:
        return np.asarray(course.angles[:, index - 1])
    u, v, span = mechanism.members[index].ends
    arm = course.nodes[:, v] - course.nodes[:, u]
    return np.asarray((arm[0].conj() * arm[1:]).imag / abs(span) ** 2)  # a = (i alpha - omega^2) arm


def reading(mechanism: Mechanism, gauge: Input, course: Course) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """Return value, rate and unit direction of the quantity of a gauge or an actuator (rows,)."""
    nodes, member = course.nodes, gauge.guide
    if gauge.rotary:
        arm = unit_of(mechanism, nodes[0], gauge.members[0]) * gauge.arm
        reference = unit_of(mechanism, nodes[0], member) * gauge.reference
        speed = turning(mechanism, course, gauge.members[0])[0] - turning(mechanism, course, member)[0]
        return np.angle(arm * reference.conj()), speed, arm
    if gauge.kind == SPAN:
        arm, rate = nodes[0, gauge.nodes[1]] - nodes[0, gauge.node], nodes[1, gauge.nodes[1]] - nodes[1, gauge.node]
        length = np.abs(arm)
        unit = np.divide(arm, length, out=np.full_like(arm, np.nan), where=length > 0.0)  # NaN in unsolved rows
        return length, (unit.conj() * rate).real, unit
    unit = unit_of(mechanism, nodes[0], member) * gauge.normal
    origin = carried(mechanism, nodes[:2], member, gauge.point)
    omega = turning(mechanism, course, member)[0]
    away, rate = nodes[0, gauge.node] - origin[0], nodes[1, gauge.node] - origin[1]
    return (unit.conj() * away).real, (unit.conj() * (rate - 1j * omega * away)).real, unit


def acceleration(mechanism: Mechanism, gauge: Input, course: Course) -> FloatArray:
    """Return the second derivative by s of the quantity of a gauge or an actuator (rows,)."""
    nodes, member = course.nodes, gauge.guide
    if gauge.rotary:
        return np.asarray(turning(mechanism, course, gauge.members[0])[1] - turning(mechanism, course, member)[1])
    length, rate, unit = reading(mechanism, gauge, course)
    if gauge.kind == SPAN:
        _, speed, gain = nodes[:, gauge.nodes[1]] - nodes[:, gauge.node]
        return np.asarray((unit.conj() * gain).real + (np.abs(speed) ** 2 - rate**2) / length)
    away, speed, gain = nodes[:, gauge.node] - carried(mechanism, nodes, member, gauge.point)
    omega, alpha = turning(mechanism, course, member)
    relative = gain - 1j * alpha * away - 2j * omega * speed - omega**2 * away
    return np.asarray((unit.conj() * relative).real)


def travel_along(slide: PairRow, name: str) -> Input:
    """Return a gauge that measures the travel of a node along its guide."""
    return Input(name, HEIGHT, slide.nodes, slide.members, slide.point, slide.along)


def read_at(mechanism: Mechanism, gauge: Input, z: ComplexArray, near: float) -> float:
    """Return the value of a gauge at a position (nodes,); angles are within half a turn of `near`."""
    still = Course(np.zeros(1), np.zeros((0, 1)), np.array([z, np.zeros_like(z)])[:, :, None])
    value = float(reading(mechanism, gauge, still)[0][0])
    return float(beside(value, near)) if gauge.rotary else value
