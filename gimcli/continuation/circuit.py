"""A circuit: all positions that a mechanism can reach from one position without disassembly, as a curve.

The curve is followed by steps along its tangent, through limits of the input. If its Jacobian is about to lose rank,
the singular position is located first. If branches meet there, the curve passes through it along the branch tangent
(from second derivatives). If the curve only passes near it, steps are limited to a fraction of the distance to it, so
that the other branch is not entered. The circuit is closed when the mechanism is back in its initial configuration. A
curve that goes to infinity, such as that of a pin in two slots that become parallel, is followed by longer and longer
steps until the parameter that it approaches is known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from gimcli.continuation.arclength import (
    ArclengthConstants,
    ArclengthFollower,
    CurvePoint,
    beside,
    between,
    correct,
    place,
)
from gimcli.continuation.bifurcation import Crossing, crossing
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import StructureError
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.numerics.along import lagrange
from gimcli.progress import spend

RESTS = 1e-6
"""Component of a unit tangent below which the input, or a member, is stationary."""

STEPS = ArclengthConstants(longest=0.1, shortest=1e-10, rounding=1e-8, noise=1e-8)
"""Constants of the steps along a circuit."""


@dataclass(frozen=True)
class CircuitConstants:
    """Constants for following a circuit; lengths are those of the space of positions and inputs."""

    exact: float = 2e-14  # residual below which branches meet: a few rounding errors of the equations
    ahead: float = 2.0  # number of steps within which a loss of rank is expected
    near: float = 0.25  # greatest step, relative to the distance from a singular position that is not on the curve
    landing: float = 1e-3  # step from a singular position to the next point
    landings: tuple[float, ...] = tuple(1e-3 * 0.25**k for k in range(5))  # steps that are tried one after another
    approach: float = 4.0  # distance from a singular position, in landings, below which it is passed
    shortest_landing: float = 1e-6
    beside: float = 2e-5  # distance from a singular position within which rows are interpolated, not corrected
    singular: float = 1e-7  # ratio of least to greatest singular value below which a start position is singular
    closure: float = 1e-8  # distance from the start within which a circuit is closed
    longest: float = 400.0  # greatest length of a circuit
    points: int = 10_000  # most points of a circuit in one sense
    outside: float = 10.0  # coordinate, in sizes, above which steps increase in proportion to it
    stride: float = 0.25  # ratio of such steps to the coordinate
    infinity: float = 1e6  # coordinate at which a curve counts as going to infinity
    towards: int = 6  # number of points from which the parameter at infinity is extrapolated
    settled: float = 1e-10  # greatest relative change of this parameter if one point is omitted


CIRCUIT = CircuitConstants()


class Ended:
    """The reasons why a circuit ends."""

    CLOSED = "closed"
    LAW = "end of a law"
    LOST = "singular position that cannot be passed"
    LONG = "no end in reach"
    INFINITE = "runs to infinity"
    WORK = "work limit"


@dataclass(frozen=True)
class Circuit:
    """A circuit as points of its curve; if it is closed, the last point is the first one again."""

    curve: PositionCurve = field(repr=False)
    places: tuple[CurvePoint, ...] = field(repr=False)
    crossings: dict[int, Crossing] = field(repr=False)  # {index of the point: crossing of branches there}
    ended: str  # one of Ended
    turns: float = 0.0  # of the rotary input that is the parameter, from the start to the end
    start: int = 0  # index of the point from which it was followed
    infinite: tuple[float | None, float | None] = (None, None)  # parameter at infinity at both ends, if it goes there

    @property
    def closed(self) -> bool:
        """Whether the mechanism returns to its initial configuration."""
        return self.ended == Ended.CLOSED

    @property
    def turning(self) -> bool:
        """Whether inputs turn on without a limit: the curve closes after turns, or has no end in reach."""
        return self.turns != 0.0 or self.ended == Ended.LONG

    @cached_property
    def p(self) -> FloatArray:
        """Positions and parameter (n + 1, points)."""
        return np.array([here.p for here in self.places]).T

    @cached_property
    def tangents(self) -> FloatArray:
        """The unit tangents (points, n + 1)."""
        return np.array([here.tangent for here in self.places])

    @cached_property
    def lengths(self) -> FloatArray:
        """The arc length up to every point (points,)."""
        steps = np.linalg.norm(np.diff(self.p, axis=1), axis=0)
        return np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism that moves."""
        return self.curve.mechanism


def rolled(circuit: Circuit, index: int, start: int) -> Circuit:
    """Return a closed circuit that begins at point `index` one round earlier; start: index of its start point."""
    last, shift = len(circuit.places) - 1, 2.0 * math.pi * circuit.turns

    back = (replace(at, p=np.append(at.p[:-1], at.p[-1] - shift)) for at in circuit.places[index:last])
    places = (*back, *circuit.places[: index + 1])
    crossings = {k - index: met for k, met in circuit.crossings.items() if index <= k < last}
    crossings |= {k + last - index: met for k, met in circuit.crossings.items() if k <= index}
    return Circuit(circuit.curve, places, crossings, circuit.ended, circuit.turns, start)


def nearby(circuit: Circuit) -> tuple[int, int]:
    """Return the indices of the first and the last point that are not far outside, towards infinity."""
    inside = np.flatnonzero(near(circuit))
    behind, ahead = circuit.infinite
    last = len(circuit.places) - 1
    if not len(inside):
        return 0, last
    return int(inside[0]) if behind is not None else 0, int(inside[-1]) if ahead is not None else last


def near(circuit: Circuit) -> BoolArray:
    """Return (points,) whether the coordinates are not far outside the mechanism's size."""
    coordinates = circuit.p[: circuit.curve.system.coordinated]
    return np.asarray(np.max(np.abs(coordinates), axis=0, initial=0.0) <= CIRCUIT.outside)


def start_place(curve: PositionCurve, z: ComplexArray, q: float) -> tuple[CurvePoint, Crossing | None]:
    """Return the point of positions z (nodes,) at parameter q, and the singular position if it is singular.

    Raises StructureError if the actuators do not drive all freedoms.
    """
    along = np.append(np.zeros(curve.system.n), curve.forward())
    if curve.system.m < curve.system.n:
        raise StructureError(f"the actuators of {curve.mechanism.name} do not drive all freedoms: see `gim mobility`")
    here = place(curve, curve.point(z, q), along)
    if here.regular > CIRCUIT.singular:
        settled = correct(curve, here.p, STEPS, along)  # exactly at this input, if possible
        return (here if settled is None else place(curve, settled, along)), None
    return here, crossing(curve, here.p)


def ordered(curve: PositionCurve, met: Crossing) -> tuple[FloatArray, ...]:
    """Return the tangents of the branches that meet, in the sense of the laws.

    The first is that with the greatest change of the input (an input moves the members least). If two are equal, the
    first is that whose members rotate faster counter-clockwise.
    """
    directed = [oriented(curve, met.p, t) for t in met.tangents]
    turns = [curve.turning(met.p, t).tolist() for t in directed]
    keys = [(-round(abs(float(t[-1])), 6), [-round(w, 6) for w in own]) for t, own in zip(directed, turns, strict=True)]
    return tuple(directed[k] for k in sorted(range(len(directed)), key=lambda k: keys[k]))


def oriented(curve: PositionCurve, p: FloatArray, tangent: FloatArray) -> FloatArray:
    """Return a tangent (n + 1,) in the sense of the laws.

    If the input is stationary, the first member that rotates does so counter-clockwise.
    """
    if abs(tangent[-1]) > RESTS:
        return tangent if tangent[-1] * curve.forward() > 0.0 else -tangent
    turns = [*curve.turning(p, tangent).tolist(), *tangent[np.abs(tangent) > 0.0].tolist()]
    most = max(map(abs, turns))
    first = next(rate for rate in turns if abs(rate) > RESTS * most)
    return tangent if first > 0.0 else -tangent


class CircuitWalker(ArclengthFollower):
    """Follows a curve point by point, through singular positions."""

    def __init__(self, curve: PositionCurve, start: CurvePoint) -> None:
        super().__init__(curve, start, STEPS)
        self.curve, self.crossings = curve, dict[int, Crossing]()
        self.missed: list[FloatArray] = []  # singular positions near the curve but not on it
        self.waiting: Crossing | None = None  # a crossing to be passed when the curve is closer to it
        self.length = 0.0
        self.infinite: float | None = None  # parameter at infinity, if the curve goes there

    def run(self, closes: bool = True) -> str:
        """Follow the curve until the circuit ends; return the reason (one of Ended)."""
        while True:
            before = len(self.places)
            if not self.go():
                return Ended.LONG if self._reach(self.places[-1]) > CIRCUIT.outside else Ended.LOST
            for index in range(before, len(self.places)):
                if closes and index > 1 and self._closes(index):
                    return Ended.CLOSED
                if self._leaves(index):
                    return Ended.LAW if self.curve.domain.ends else Ended.LONG
            if spend(1) or len(self.places) > CIRCUIT.points:
                return Ended.WORK
            if self._reach(self.places[-1]) > CIRCUIT.outside:
                if self.escaped:
                    self.infinite = self.at_infinity()
                    return Ended.LONG if self.infinite is None else Ended.INFINITE
                continue
            self.length += sum(
                float(np.linalg.norm(self.places[k].p - self.places[k - 1].p)) for k in range(before, len(self.places))
            )
            if self.length > CIRCUIT.longest:
                return Ended.LONG

    @property
    def escaped(self) -> bool:
        """Whether the curve has gone so far that it counts as going to infinity."""
        return self._reach(self.places[-1]) > CIRCUIT.infinity

    def at_infinity(self) -> float | None:
        """Return the limit of the parameter as the curve goes to infinity (may be infinite); None if not determined."""
        last = self.places[-CIRCUIT.towards :]
        q, w = [float(at.p[-1]) for at in last], [1.0 / self._reach(at) for at in last]
        if abs(q[-1]) * w[-1] > 1.0 / CIRCUIT.outside:
            return math.copysign(math.inf, q[-1])
        one, other = (sum(a * b for a, b in zip(lagrange(w[k:], 0.0), q[k:], strict=True)) for k in (0, 1))
        return one if abs(one - other) <= CIRCUIT.settled * max(1.0, abs(one)) else None

    def go(self) -> bool:
        """Add the next point, or a singular position with the points around it; return whether there was one."""
        here, met = self.places[-1], self.waiting
        if met is not None and np.linalg.norm(met.p - here.p) <= CIRCUIT.approach * CIRCUIT.landing:
            self.waiting = None
            if self._pass(here, met):
                return True
        return super().go()

    def predict(self) -> FloatArray:
        """Return the point (n + 1,) after a step, which is shorter near a singular position beside the curve."""
        self.step = min(self.step, self._room(self.places[-1]))
        return super().predict()

    def accept(self, there: CurvePoint) -> bool:
        """Add a point, or the crossing before it; return False if the step may have jumped to another branch."""
        verdict = self._meets(self.places[-1], there)
        return verdict == "passed" or (verdict == "well" and super().accept(there))

    def longest(self, there: CurvePoint) -> float:
        """Return the greatest step; far outside the mechanism's size it increases with the distance."""
        far = self._reach(there)
        return CIRCUIT.stride * far if far > CIRCUIT.outside else STEPS.longest

    def _reach(self, here: CurvePoint) -> float:
        """Return the greatest coordinate of a point."""
        return float(np.max(np.abs(here.p[: self.curve.system.coordinated]), initial=0.0))

    def _room(self, here: CurvePoint) -> float:
        """Return the greatest step that cannot jump to another branch near a singular position beside the curve."""
        gaps = [float(np.linalg.norm(self.curve.apart(here.p, p))) for p in self.missed]
        return max(CIRCUIT.near * min(gaps, default=math.inf), 2.0 * STEPS.shortest)

    def _meets(self, here: CurvePoint, there: CurvePoint) -> str:
        """Check a step for crossings: "well", "jumps" (too long), or "passed" (a crossing; its points were added)."""
        a, b = here.orientation(here.left), there.orientation(here.left)
        chord = there.p - here.p
        if a * b < 0.0:
            guess, found = here.p + chord * (a / (a - b)), "jumps"
        else:
            fall = (here.values[-1] - there.values[-1]) / max(float(np.linalg.norm(chord)), 1e-300)
            if not fall * CIRCUIT.ahead * self.step > there.values[-1]:
                return "well"
            guess, found = there.p + there.tangent * (there.values[-1] / fall), "well"
        met = crossing(self.curve, guess)
        if met is None or np.linalg.norm(met.p - here.p) > 4.0 * CIRCUIT.ahead * self.step:
            return found
        gap = float(np.linalg.norm(met.p - here.p))
        if met.miss <= CIRCUIT.exact:
            if self._pass(here, met):
                return "passed"
            self.waiting = met
        if not any(np.linalg.norm(self.curve.apart(met.p, p)) <= 0.1 * gap for p in self.missed):
            self.missed.append(met.p)
        return "well" if found == "well" and self.step <= CIRCUIT.near * gap else "jumps"

    def _pass(self, here: CurvePoint, met: Crossing) -> bool:
        """Pass through a singular position; return whether it is on the curve ahead."""
        chord = met.p - here.p
        gap = float(np.linalg.norm(chord))
        along = chord / gap if gap > CIRCUIT.shortest_landing else here.tangent
        if here.tangent @ along < 0.5:
            return False
        ahead = met.near(along)
        if ahead is None or not ahead @ along >= math.cos(2.0 * STEPS.bend):
            # not determined by second derivatives: use the direction from a closer point
            if gap > CIRCUIT.approach * CIRCUIT.landing:
                return False
            ahead = _through(self.curve, met, along)
        middle = replace(place(self.curve, met.p, ahead), tangent=ahead)
        after = landed(self.curve, met, ahead)
        if after is None:
            return False
        size = float(np.linalg.norm(after.p - met.p))
        if gap > 2.0 * size:
            before = landed(self.curve, met, -ahead)
            if before is None:
                return False
            self.places.append(place(self.curve, before.p, ahead))
        self.crossings[len(self.places)] = met
        self.places += [middle, after]
        self.missed = [p for p in self.missed if np.linalg.norm(self.curve.apart(met.p, p)) > CIRCUIT.landing]
        self.waiting, self.step = None, size
        return True

    def _closes(self, index: int) -> bool:
        """Return whether the step to a point passes the start; the circuit then ends exactly there."""
        curve, start = self.curve, self.places[0]
        here, there = self.places[index - 1], self.places[index]
        normal = np.append(start.tangent[: curve.system.coordinated], curve.input_rates(start.p, start.tangent))
        normal = normal / max(float(np.linalg.norm(normal)), math.ulp(1.0))

        def over(at: CurvePoint) -> float:
            return float(curve.apart(at.p, start.p) @ normal)

        passed = over(here) < -CIRCUIT.closure <= over(there) and there.tangent @ start.tangent >= 0.5
        if not (passed and np.linalg.norm(curve.apart(there.p, start.p)) < 3.0 * np.linalg.norm(there.p - here.p)):
            return False
        found = there if over(there) <= 0.0 else between(curve, here, there, over, STEPS)
        if found is None or not np.linalg.norm(curve.apart(found.p, start.p)) <= CIRCUIT.closure:
            return False
        self.places[index:] = [place(curve, found.p, here.tangent)]
        self.crossings = {k: met for k, met in self.crossings.items() if k < index}
        return True

    def _leaves(self, index: int) -> bool:
        """Return whether a point is outside the parameter's domain; the circuit then ends at the end of the domain."""
        domain, q = self.curve.domain, float(self.places[index].p[-1])
        if domain.low <= q <= domain.high:
            return False
        end, (here, there) = min(max(q, domain.low), domain.high), self.places[index - 1 : index + 1]
        found = between(self.curve, here, there, lambda at: float(at.p[-1]) - end, STEPS)
        self.places[index:] = [] if found is None else [found]
        return True


def _through(curve: PositionCurve, met: Crossing, along: FloatArray) -> FloatArray:
    """Return the tangent, at a singular position, of the branch closest to a direction, from points on both sides."""
    ahead = _flattened(met, along)
    one, other = landed(curve, met, ahead), landed(curve, met, -ahead)
    if one is None or other is None:
        return ahead
    span = float((one.p - other.p) @ ahead)  # below: slope of the cubic through both points, at its middle
    return _flattened(met, 1.5 * (one.p - other.p) / span - 0.25 * (one.tangent - other.tangent))


def _flattened(met: Crossing, along: FloatArray) -> FloatArray:
    """Return the unit vector of the null space closest to a direction."""
    ahead = met.right @ (met.right.T @ along)
    return np.asarray(ahead / np.linalg.norm(ahead))


def landed(curve: PositionCurve, met: Crossing, ahead: FloatArray) -> CurvePoint | None:
    """Return a point near a singular position on the branch along a tangent; None if none is found."""
    tried = (beside(curve, ahead, met.p + size * ahead, size, STEPS, ahead) for size in CIRCUIT.landings)
    return next((there for there in tried if there is not None), None)


def follow_circuit(curve: PositionCurve, start: CurvePoint) -> Circuit:
    """Follow the circuit through a point, in the sense of its tangent; if it is not closed, to both ends."""
    walker = CircuitWalker(curve, start)
    ended = walker.run()
    places, crossings = walker.places, walker.crossings
    if ended == Ended.CLOSED:
        return Circuit(curve, tuple(places), crossings, ended, _turns(curve, places))
    back = CircuitWalker(curve, place(curve, start.p, -start.tangent))
    other = back.run(closes=False)
    if ended != Ended.INFINITE == other:
        ended = other
    behind = [replace(at, tangent=-at.tangent) for at in reversed(back.places[1:])]
    known = {len(behind) - k: met for k, met in back.crossings.items()}
    known |= {len(behind) + k: met for k, met in crossings.items()}
    return Circuit(curve, (*behind, *places), known, ended, 0.0, len(behind), (back.infinite, walker.infinite))


def _turns(curve: PositionCurve, places: list[CurvePoint]) -> float:
    if curve.line is not None and curve.rotary[curve.main]:
        return float(round((places[-1].p[-1] - places[0].p[-1]) / (2.0 * math.pi)))
    return 0.0
