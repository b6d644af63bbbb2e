"""Inputs that follow the linkage itself, such as the angle of a gear that a rocker turns, along a motion.

Such an input is an unknown of the curve of positions. This curve is followed from the drawing to the start of the laws
and along them, to a limit if there is one; a law of the input is then the curve at the parameter of each time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter

import numpy as np

from gimcli.continuation import gauss_newton
from gimcli.continuation.arclength import CurvePoint, between, correct, place, walk
from gimcli.continuation.circuit import STEPS
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import UnassembledError
from gimcli.mechanism import BoolArray, FloatArray, Mechanism
from gimcli.numerics.along import bisected, hermite, sign_changes
from gimcli.positions.inputs import InputLine, driven, line_through, nearest_turns
from gimcli.structure.system import system_of

SAMPLES = 1025
"""Times between which a law that follows is searched for changes of its sense."""

ORDERS = 3
"""Of the derivatives of such a law."""

ROUND = 1e-12
"""Distance beyond the ends of a curve, relative to the parameter, that is rounding."""


class InputBranch:
    """The part of a curve around a start on which its parameter is from `low` to `high`, or up to limits before."""

    def __init__(self, curve: PositionCurve, start: FloatArray, low: float, high: float) -> None:
        self.curve, along = curve, np.append(np.zeros(curve.system.n), 1.0)
        behind, ahead = (_until(curve, place(curve, start, k * along), end) for k, end in ((-1.0, low), (1.0, high)))
        every = [*(replace(at, tangent=-at.tangent) for at in reversed(behind[1:])), *ahead]
        self.p, self.tangent = (np.array([getattr(at, name) for at in every]) for name in ("p", "tangent"))

    def covers(self, q: FloatArray) -> BoolArray:
        """Return (rows,) whether parameters are not beyond the ends."""
        ends = self.p[[0, -1], -1]
        room = ROUND * np.maximum(1.0, np.abs(ends))
        return np.asarray((q >= ends[0] - room[0]) & (q <= ends[1] + room[1]))

    def at(self, q: FloatArray) -> FloatArray:
        """Return the unknowns (rows, n) at parameters (rows,); beyond the ends those there."""
        p, tangent = self.p, self.tangent
        if len(p) == 1:
            return np.repeat(p[:, :-1], len(q), axis=0)
        q = np.clip(q, p[0, -1], p[-1, -1])
        k = np.clip(np.searchsorted(p[:, -1], q, side="right") - 1, 0, len(p) - 2)
        h = np.linalg.norm(p[k + 1] - p[k], axis=1)[:, None]
        ends = p[k], h * tangent[k], p[k + 1], h * tangent[k + 1]
        one, low, other, high = (v[:, -1] for v in ends)
        part = bisected(lambda t: hermite(one, low, other, high, t) >= q, np.zeros(len(q)), np.ones(len(q)))[1]
        u = np.array([self.curve.given(value) for value in q.tolist()])
        system, guess = self.curve.system, hermite(*ends, part[:, None])[:, :-1]
        return gauss_newton.settle(lambda x, k: (system.residual(x, u[k]), system.jacobian(x, u[k])), guess)[0]


def _until(curve: PositionCurve, start: CurvePoint, end: float) -> list[CurvePoint]:
    """Return the points from a start to the parameter `end`, or to the limit before it."""
    found = [start]
    for there in walk(curve, start, STEPS) if (end - start.p[-1]) * start.rate > 0.0 else ():
        limit = between(curve, found[-1], there, attrgetter("rate"), STEPS)
        found.append(limit or there)
        if limit or (end - there.p[-1]) * start.rate <= 0.0:
            break
    return found


class LinkedMotion:
    """The inputs that follow the linkage along the laws of the drivers."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._last: tuple[bytes, FloatArray] | None = None

    @cached_property
    def curve(self) -> PositionCurve:
        """The curve of the laws."""
        return PositionCurve(self.mechanism)

    @cached_property
    def branch(self) -> InputBranch:
        """The part of the curve that the laws use."""
        q = self.curve.begin()
        start = np.append(moved_from_drawing(self.mechanism, self.curve.given(q)), q)
        return InputBranch(self.curve, start, *self.curve.laws)

    @cached_property
    def limit(self) -> float | None:
        """The normalised time at which the motion ends before that of the laws."""

        def beyond(time: FloatArray) -> BoolArray:
            return ~self.branch.covers(self._parameter(time))

        times = np.linspace(0.0, 1.0, SAMPLES)
        k = np.flatnonzero(beyond(times))[:1]
        return float(bisected(beyond, times[np.maximum(k - 1, 0)], times[k])[0][0]) if len(k) else None

    def values(self, time: FloatArray) -> FloatArray:
        """Return the followers and their derivatives by the normalised time (orders, followers, rows)."""
        key = time.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = key, self._values(time)
        return self._last[1]

    def _values(self, time: FloatArray) -> FloatArray:
        end, system = 1.0 if self.limit is None else self.limit, self.curve.system
        inside = np.clip(time, 0.0, end)
        laws = [actuator.law for actuator in self.curve.driven.actuators]
        rates = np.array([[law(inside, order) for law in laws] for order in range(ORDERS + 1)])
        x = self.branch.at(self._parameter(inside))
        found = np.moveaxis(system.following(system.derivatives(x, np.moveaxis(rates, 1, 2))), 1, 2)
        found[1:, :, time > end] = 0.0
        return found

    def _parameter(self, time: FloatArray) -> FloatArray:
        """Return the parameters of the curve at normalised times."""
        if self.curve.line is None:
            return time * self.curve.span
        return self.curve.driven.actuators[self.curve.main].law(time)


@dataclass(frozen=True)
class LinkedLaw:
    """The law of an input that follows the linkage."""

    motion: LinkedMotion
    number: int  # of the follower

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value or a derivative by the normalised time."""
        t = np.asarray(time, dtype=float)
        return np.asarray(self.motion.values(t.ravel())[order, self.number].reshape(t.shape))

    def stops(self) -> FloatArray:
        """Return the times at which the law reverses, and those at which a driver may."""
        found = [actuator.law.stops() for actuator in self.motion.curve.driven.actuators]
        return np.unique(np.concatenate([self._reversals, *found]))

    @cached_property
    def _reversals(self) -> FloatArray:
        """The times at which the derivative changes its sign (rows,), to rounding."""
        return sign_changes(lambda time: self(time, 1), np.linspace(0.0, 1.0, SAMPLES))


def moved_from_drawing(mechanism: Mechanism, inputs: FloatArray) -> FloatArray:
    """Return the unknowns x (n,) at drivers' inputs (actuators,) that is reached from the drawing without disassembly.

    Raises UnassembledError if it is not reached.
    """
    own = driven(mechanism)
    begin = own.coupled(nearest_turns(mechanism, mechanism.drawn_inputs, inputs))
    line = line_through(own, np.stack([begin, own.coupled(inputs)], axis=1))
    line = line or InputLine(begin, np.zeros(len(begin)), own.drivers[0])
    curve, (q, end) = PositionCurve(mechanism, line), (float(at[line.main]) for at in (begin, inputs))
    across = np.append(np.zeros(curve.system.n), 1.0)
    start = correct(curve, curve.point(mechanism.drawn, q), STEPS, across)
    if start is not None:
        branch = InputBranch(curve, start, min(q, end), max(q, end))
        if branch.covers(np.array([end]))[0]:
            return np.asarray(branch.at(np.array([end]))[0])
    names = ", ".join(f"'{mechanism.actuators[k].name}'" for k in curve.system.followers)
    raise UnassembledError(
        f"{mechanism.name}: the linkage that turns {names} cannot reach these inputs from the drawing; use other"
        " inputs, or initial coordinates closer to an assembled position"
    )


def followed(mechanism: Mechanism, inputs: FloatArray) -> FloatArray:
    """Return inputs (actuators,) in which the followers have the values that those of the drivers give.

    Raises UnassembledError if the linkage that turns a gear cannot reach them from the drawing.
    """
    found = mechanism.coupled(inputs)
    if mechanism.complete is not None:
        system = system_of(mechanism)
        found[system.followers] = system.following(moved_from_drawing(mechanism, inputs))
    return found


def linked_limit(mechanism: Mechanism) -> float | None:
    """Return the normalised time at which the motion of the linkage that turns gears ends before that of the laws."""
    laws = (mechanism.actuators[c.follower].law for c in mechanism.couplings if c.reads)
    return next(law.motion.limit for law in laws if isinstance(law, LinkedLaw))


def with_linked_laws(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose inputs that follow the linkage have their laws; others are returned unchanged."""
    linked = [coupling.follower for coupling in mechanism.couplings if coupling.reads]
    if not linked:
        return mechanism
    motion, actuators = LinkedMotion(mechanism), list(mechanism.actuators)
    for number, follower in enumerate(linked):
        actuators[follower] = replace(actuators[follower], law=LinkedLaw(motion, number))
    return replace(mechanism, actuators=tuple(actuators), complete=with_linked_laws)
