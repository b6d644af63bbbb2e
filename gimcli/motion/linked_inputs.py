"""Inputs that follow the linkage itself, such as the angle of a gear that a rocker turns, along a motion.

Such an input is an unknown of the curve of positions. This curve is followed from the drawing to the start of the laws
and along them, to a limit if there is one; a law of the input is then the curve at the parameter of each time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial
from operator import attrgetter

import numpy as np

from gimcli.continuation import gauss_newton
from gimcli.continuation.arclength import CurvePoint, between, correct, corrected, place, tangents
from gimcli.continuation.bifurcation import Crossing
from gimcli.continuation.circuit import RESTS, STEPS, CircuitWalker
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import UnassembledError
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.motion.follow import FollowedPath, PassedMeeting
from gimcli.numerics.along import bisected, hermite, sign_changes
from gimcli.positions.inputs import InputLine, driven, line_through, nearest_turns
from gimcli.progress import spend
from gimcli.status import Status
from gimcli.structure.derived import derived
from gimcli.structure.system import system_of

SAMPLES = 1025
"""Times between which a law that follows is searched for changes of its sense."""

ORDERS = 3
"""Of the derivatives of such a law."""

BESIDE = 0.97
"""Least cosine of the angles between a step, and the tangents at its ends, of a branch found from that of another
design: twice the greatest angle of a step that is followed."""

ROUND = 1e-12
"""Distance beyond the ends of a curve, relative to the parameter, that is rounding."""


class InputBranch:
    """The part of a curve around a start on which its parameter is from `low` to `high`, or up to limits before.

    through: it continues through limits. Places on it are parameters which are mirrored at each limit, so that they
    increase along the curve; on the branch of the start they are the parameters themselves.
    """

    def __init__(
        self, curve: PositionCurve, start: FloatArray, low: float, high: float, through: bool = False,
        near: InputBranch | None = None,
    ) -> None:  # fmt: skip
        """Follow the curve from a start (n + 1,); `near` is a branch of another design of the mechanism, if known."""
        self.curve, self.meetings, self.limits = curve, list[tuple[float, Crossing]](), np.empty(0)
        if near is None or not self._is_beside(near, start, low, high):
            self._walk(start, low, high, through)

    def _hold(self, p: FloatArray, tangent: FloatArray, start: int) -> None:
        """Take the points (rows, n + 1), their tangents and the number of that of the start."""
        self.p, self.tangent, q = p, tangent, p[:, -1]
        self.mirror = np.where(np.diff(q, append=q[-1] + 1.0) >= 0.0, 1.0, -1.0)  # of steps: place = mirror q + shift
        turned = np.append(0.0, np.cumsum((self.mirror[:-1] - self.mirror[1:]) * q[1:]))
        self.shift = turned - turned[start]
        self.places = self.mirror * q + self.shift
        self.limits = self.places[1:][np.diff(self.mirror) != 0.0]

    def _is_beside(self, near: InputBranch, start: FloatArray, low: float, high: float) -> bool:
        """Return whether the branch, all of whose points are then corrected together, is beside another one."""
        p, good = corrected(self.curve, near.p, STEPS, near.tangent)
        if near.meetings or not good.all():
            return False
        tangent, step = tangents(self.curve, p, near.tangent), np.diff(p, axis=0)
        self._hold(p, tangent, 0)
        turned = np.einsum("rn,rn->r", tangent[:-1], tangent[1:])
        ahead = np.einsum("rn,rn->r", step, tangent[:-1]) / np.linalg.norm(step, axis=1)
        fine = np.all((ahead >= BESIDE) & (turned >= BESIDE)) and np.all(tangent[:, -1] > 0.0)
        ends = fine and p[0, -1] <= low and p[-1, -1] >= high
        return bool(ends and np.linalg.norm(self.at(start[-1:])[0] - start) <= STEPS.rounding)

    def _walk(self, start: FloatArray, low: float, high: float, through: bool) -> None:
        curve, along = self.curve, np.append(np.zeros(self.curve.system.n), 1.0)
        behind, ahead = (_until(curve, place(curve, start, k * along), k * (end - start[-1]), through)
                         for k, end in ((-1.0, low), (1.0, high)))  # fmt: skip
        every = [*((replace(at, tangent=-at.tangent), met) for at, met in reversed(behind[1:])), *ahead]
        points, found = ([getattr(at, name) for at, _ in every] for name in ("p", "tangent"))
        self._hold(np.array(points), np.array(found), len(behind) - 1)
        self.meetings += [(at, met) for at, (_, met) in zip(self.places.tolist(), every, strict=True) if met]

    def covers(self, places: FloatArray) -> BoolArray:
        """Return (rows,) whether places are not beyond the ends."""
        ends = self.places[[0, -1]]
        room = ROUND * np.maximum(1.0, np.abs(ends))
        return np.asarray((places >= ends[0] - room[0]) & (places <= ends[1] + room[1]))

    def at(self, places: FloatArray) -> FloatArray:
        """Return the points (rows, n + 1) at places (rows,); beyond the ends those there."""
        p, tangent = self.p, self.tangent
        if len(p) == 1:
            return np.repeat(p, len(places), axis=0)
        places = np.clip(places, *self.places[[0, -1]])
        k = np.clip(np.searchsorted(self.places, places, side="right") - 1, 0, len(p) - 2)
        h = np.linalg.norm(p[k + 1] - p[k], axis=1)[:, None]
        ends, q = (p[k], h * tangent[k], p[k + 1], h * tangent[k + 1]), (places - self.shift[k]) * self.mirror[k]
        a, low, b, high = (self.mirror[k] * v[:, -1] for v in ends)
        wanted = self.mirror[k] * q
        part = bisected(lambda t: hermite(a, low, b, high, t) >= wanted, np.zeros(len(q)), np.ones(len(q)))[1]
        u, system = self.curve.given(q[:, None]), self.curve.system
        guess = hermite(*ends, part[:, None])[:, :-1]
        x = gauss_newton.settle(lambda x, k: (system.residual(x, u[k]), system.jacobian(x, u[k])), guess)[0]
        return np.column_stack([x, q])


def _until(
    curve: PositionCurve, start: CurvePoint, left: float, through: bool
) -> list[tuple[CurvePoint, Crossing | None]]:
    """Return the points from a start until the parameter has changed by `left`, and a step more, or to a limit before.

    With each comes the crossing of branches there, if it is one. through: it continues through limits.
    """
    walker, done, found = CircuitWalker(curve, start), 1, list[tuple[CurvePoint, Crossing | None]]([(start, None)])
    while left > -STEPS.longest and abs(start.rate) > RESTS and not walker.escaped and walker.go() and not spend(1):
        for k in range(done, len(walker.places)):
            (here, before), there, met = found[-1], walker.places[k], walker.crossings.get(k)
            limit = None if before or met else between(curve, here, there, attrgetter("rate"), STEPS)
            found += [(limit, None)] if limit else []
            if not through and start.rate * there.rate < 0.0:
                return found
            found.append((there, met))
            left -= abs(there.p[-1] - here.p[-1])
        done = len(walker.places)
    return found


class LinkedMotion:
    """The motion of the linkage that turns gears along the laws of the drivers; these reverse at limits if `through`.

    Times are normalised.
    """

    def __init__(self, mechanism: Mechanism, through: bool = False, near: LinkedMotion | None = None) -> None:
        """Take a mechanism; `near` is the motion of another design of it, if it is known."""
        self.mechanism, self.through, self.near = mechanism, through, near
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
        return InputBranch(self.curve, start, *self.curve.laws, self.through, self.near.branch if self.near else None)

    @cached_property
    def limit(self) -> float | None:
        """The time at which the motion ends before that of the laws."""

        def inside(time: FloatArray) -> FloatArray:
            return np.where(self.branch.covers(self.curve.at_time(time)), 1.0, -1.0)

        return next(iter(sign_changes(inside, np.linspace(0.0, 1.0, SAMPLES)).tolist()), None)

    def values(self, time: FloatArray) -> FloatArray:
        """Return the followers and their derivatives by the time (orders, followers, rows)."""
        key = time.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = key, self._values(time)
        return self._last[1]

    def _values(self, time: FloatArray) -> FloatArray:
        end, system = 1.0 if self.limit is None else self.limit, self.curve.system
        inside = np.clip(time, 0.0, end)
        laws = [actuator.law for actuator in self.curve.driven.actuators]
        rates = np.array([[law(inside, order) for law in laws] for order in range(ORDERS + 1)])
        x = self.branch.at(self.curve.at_time(inside))[:, :-1]
        found = np.moveaxis(system.following(system.derivatives(x, np.moveaxis(rates, 1, 2))), 1, 2)
        found[1:, :, time > end] = 0.0
        return found

    def place(self, path: FollowedPath, places: FloatArray, within: BoolArray | bool = True) -> FloatArray:
        """Solve the rows of a path at places on the branch; return the points (rows, n + 1).

        within: whether rows (rows,) may have a position; those beyond the ends of the branch have none.
        """
        curve, p = self.curve, self.branch.at(places)
        within, moved = within & self.branch.covers(places), slice(None) if self.through else curve.system.followers
        path.z, path.codes[~within] = curve.nodes(p.T), int(Status.LIMIT)
        path.inputs[moved] = np.where(within, curve.inputs(p.T)[moved], path.inputs[moved])
        return p

    def solve(self, path: FollowedPath, skips: bool, since: float = -1.0) -> None:
        """Solve the rows of a path along the laws, and record the events after the time `since`.

        skips: rows behind a limit that the laws reach again are solved too.
        """
        curve, end = self.curve, math.inf if skips or self.limit is None else self.limit
        p = self.place(path, self.curve.at_time(path.time), path.time <= end)
        path.limit = self.limit if path.codes.any() else None
        for at, met in self.branch.meetings:
            path.bridged += (times := self._times(at, since, path.time[-1])).tolist()
            path.meetings += [PassedMeeting(curve.nodes(met.p), curve.inputs(met.p), met)] * len(times)
        if self.through:
            path.parameter = p[:, -1]
            for at in self.branch.limits:
                there = tuple(curve.inputs(self.branch.at(np.array([at]))[0]).tolist())
                path.turned_back += [(time, there) for time in self._times(at, since, path.time[-1]).tolist()]
            path.limit = min((time for time, _ in path.turned_back), default=path.limit)

    def _times(self, place: float, first: float, last: float) -> FloatArray:
        """Return the times after `first`, up to `last`, at which the laws pass a place."""
        found = sign_changes(lambda time: self.curve.at_time(time) - place, np.linspace(0.0, 1.0, SAMPLES))
        return found[(found > first) & (found <= last)]


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
        """Return the times at which a driver may reverse; the law itself may reverse between them."""
        return np.concatenate([actuator.law.stops() for actuator in self.motion.curve.driven.actuators])


def moved_from_drawing(mechanism: Mechanism, inputs: FloatArray) -> FloatArray:
    """Return the unknowns x (n,) at drivers' inputs (actuators,) that is reached from the drawing without disassembly.

    Raises UnassembledError if it is not reached.
    """
    begin = nearest_turns(mechanism, mechanism.drawn_inputs, inputs)
    curve, (q, end) = _curve_along(mechanism, np.stack([begin, inputs], axis=1))
    start = correct(curve, curve.point(mechanism.drawn, q), STEPS, np.append(np.zeros(curve.system.n), 1.0))
    if start is not None:
        branch = InputBranch(curve, start, min(q, end), max(q, end))
        if branch.covers(np.array([end]))[0]:
            return np.asarray(branch.at(np.array([end]))[0, :-1])
    names = ", ".join(f"'{mechanism.actuators[k].name}'" for k in curve.system.followers)
    raise UnassembledError(
        f"{mechanism.name}: the linkage that turns {names} cannot reach these inputs from the drawing; use other"
        " inputs, or initial coordinates closer to an assembled position"
    )


def _curve_along(mechanism: Mechanism, values: FloatArray) -> tuple[PositionCurve, FloatArray]:
    """Return the curve of positions on a line of drivers' inputs (actuators, rows), and its parameters (rows,)."""
    own = driven(mechanism)
    line = line_through(own, own.coupled(values))
    line = line or InputLine(own.coupled(values[:, 0]), np.zeros(len(values)), own.drivers[0])
    return PositionCurve(mechanism, line), values[line.main]


def followed_line(mechanism: Mechanism, values: FloatArray, row: int) -> tuple[ComplexArray, FloatArray]:
    """Return positions (nodes, rows) and all inputs (actuators, rows) along a line of the drivers' inputs.

    It is followed in both senses from one of its rows; beyond limits positions are NaN. Raises UnassembledError if that
    row is not reached from the drawing.
    """
    x, (curve, q) = moved_from_drawing(mechanism, values[:, row]), _curve_along(mechanism, values)
    branch = InputBranch(curve, np.append(x, q[row]), float(q.min()), float(q.max()))
    p = branch.at(q)
    return np.where(branch.covers(q), curve.nodes(p.T), complex(np.nan, np.nan)), curve.inputs(p.T)


def followed(mechanism: Mechanism, inputs: FloatArray) -> FloatArray:
    """Return inputs (actuators,) in which the followers have the values that those of the drivers give.

    Raises UnassembledError if the linkage that turns a gear cannot reach them from the drawing.
    """
    found = mechanism.coupled(inputs)
    if mechanism.complete is not None:
        system = system_of(mechanism)
        found[system.followers] = system.following(moved_from_drawing(mechanism, inputs))
    return found


@derived
def linked_motion(mechanism: Mechanism, through: bool) -> LinkedMotion:
    """Return the motion of a mechanism whose linkage turns gears, whose drivers reverse at limits if `through`."""
    laws = (mechanism.actuators[c.follower].law for c in mechanism.couplings if c.reads)
    found = next(law.motion for law in laws if isinstance(law, LinkedLaw))
    return LinkedMotion(mechanism, through) if through else found


def with_linked_laws(mechanism: Mechanism, near: LinkedMotion | None = None) -> Mechanism:
    """Return a mechanism whose inputs that follow the linkage have their laws; others are returned unchanged.

    near: the motion of another design of the mechanism, if it is known.
    """
    linked = [coupling.follower for coupling in mechanism.couplings if coupling.reads]
    if not linked:
        return mechanism
    motion, actuators = LinkedMotion(mechanism, near=near), list(mechanism.actuators)
    for number, follower in enumerate(linked):
        actuators[follower] = replace(actuators[follower], law=LinkedLaw(motion, number))
    return replace(mechanism, actuators=tuple(actuators), complete=partial(with_linked_laws, near=motion))
