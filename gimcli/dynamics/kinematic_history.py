"""Positions, velocities and accelerations of a motion as arrays, and quantities computed from them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import nominal
from gimcli.calculus.series import Series
from gimcli.canonical import beside, counted, filled
from gimcli.mechanism import FRAME, HEIGHT, ComplexArray, FloatArray, Input, Mechanism, PairRow
from gimcli.motion.motion import Motion
from gimcli.positions.dispatch import choose
from gimcli.progress import Notify
from gimcli.rates.derivatives import ORDERS, Differentiator, drive_followers, law_rates
from gimcli.structure.carried import measured
from gimcli.structure.plan import make_plan

FACTORS = np.array([1.0, 1.0, 0.5])
"""Coefficients of a series by its derivatives."""


@dataclass(frozen=True)
class Course:
    """A motion as arrays; rows are the last axis."""

    time: FloatArray  # (rows,) s
    inputs: FloatArray  # (actuators, rows) rad, or length in the normal frame
    nodes: ComplexArray = field(repr=False)  # (3, nodes, rows): position, velocity, acceleration by s, normal frame
    angles: FloatArray | None = field(default=None, repr=False)  # (2, members, rows) omega, alpha; all but the frame

    @cached_property
    def moving(self) -> list[Series]:
        """The places of the nodes with their rates, as series in the time."""
        return [Series(part) for part in np.moveaxis(self.nodes[:2], 1, 0)]

    @cached_property
    def series(self) -> list[Series]:
        """The places of the nodes as series in the time."""
        factors = FACTORS[: len(self.nodes)].reshape(-1, *[1] * (np.ndim(self.nodes) - 1))
        return [Series(part) for part in np.moveaxis(self.nodes * factors, 1, 0)]


class Courses:
    """Computes velocities and accelerations of a motion in pieces."""

    def __init__(
        self, mechanism: Mechanism, rows: int = 0, jit: str = "off", notify: Notify | None = None,
        given: FloatArray | None = None,
    ) -> None:  # fmt: skip
        """Take a mechanism; `given` are the inputs' derivatives (orders, actuators, rows), if not those of the laws."""
        self.mechanism, self._given = mechanism, given
        self._made = Differentiator(mechanism, make_plan(mechanism), ORDERS[:2], mechanism.nodes)
        self._run = choose(jit, self._made.plain_seconds(rows), notify, ("play",))

    def __call__(self, motion: Motion) -> Course:
        """Return positions, velocities and accelerations of a piece, the inputs following their laws."""
        nodes, angles = self._made(motion.z, self._inputs(motion), self._run)
        return Course(motion.time * self.mechanism.duration, motion.inputs, nodes, angles)

    def _inputs(self, motion: Motion) -> FloatArray:
        """Return the inputs with their rates and accelerations (3, actuators, rows)."""
        return law_rates(self.mechanism, motion.time, 2) if self._given is None else self._given[:3].copy()

    def by_input(self, motion: Motion, actuator: int) -> Course:
        """Return a piece in dual numbers with the derivatives by one input, which moves at 1 rad, or length, per s."""
        given = np.zeros((3, *motion.inputs.shape))
        given[0], given[1, actuator] = motion.inputs, 1.0
        drive_followers(self.mechanism, motion.z, given)
        nodes, angles = (_along(part) for part in self._made(motion.z, given, self._run))
        return Course(motion.time * self.mechanism.duration, _along(given)[0], nodes, angles)


def _along(rates: Any) -> Any:
    """Return derivatives (orders, ...) with those of the next order; that of the last one is not known."""
    return Dual(rates, np.concatenate([rates[1:], np.nan * rates[:1]])[None])


class Turns:
    """Continues angles from piece to piece without jumps, so that a torsion spring can make whole turns."""

    def __init__(self) -> None:
        self.last: dict[int, float] = {}

    def followed(self, key: int, angle: Any, drawn: float) -> Any:
        """Return an angle [rad] without jumps (rows,), continued from the last one or from the initial one."""
        plain = nominal(angle)
        path = counted(np.append(self.last.get(key, drawn), plain))
        self.last[key] = float(filled(path)[-1])
        return path[1:] + (angle - plain)


class SeparateTurns(Turns):
    """Angles of separate positions: each is within half a turn of the initial one."""

    def followed(self, key: int, angle: FloatArray, drawn: float) -> FloatArray:
        """Return an angle [rad] (rows,)."""
        return np.asarray(beside(angle, drawn))


def turning(mechanism: Mechanism, course: Course, index: int) -> FloatArray:
    """Return omega and alpha of a member (2, rows) [rad/s, rad/s^2]."""
    if index == FRAME:
        return np.zeros((2, *np.shape(course.time)))
    if course.angles is not None:
        return course.angles[:, index - 1]
    u, v, span = mechanism.members[index].ends
    arm = course.nodes[:, v] - course.nodes[:, u]
    turns = np.stack([(arm[0].conjugate() * rate).imag for rate in arm[1:]])  # a = (i alpha - omega^2) arm
    found: FloatArray = turns / abs(span) ** 2
    return found


def reading(mechanism: Mechanism, gauge: Input, course: Course) -> tuple[FloatArray, FloatArray]:
    """Return value and rate of the quantity of a gauge or an actuator (rows,)."""
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN in unsolved rows, and where the ends of a length meet
        value, rate = measured(mechanism, gauge, course.moving).c
    return value, rate


def travel_along(slide: PairRow, name: str) -> Input:
    """Return a gauge that measures the travel of a node along its guide."""
    return Input(name, HEIGHT, slide.nodes, slide.members, slide.point, slide.along)
