"""Positions of static equilibrium, and what it takes to leave them.

The generalised force along the circuit of one released input, as a function of the arc length.

Q(s) is the force along the unit tangent of the curve of positions and input, so that limits and dead points of the
input are ordinary points. Q and its exact derivative are known at every point. Points are added until the cubic through
two neighbours also gives Q between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from operator import attrgetter

import numpy as np

from gimcli.branching.resampling import exact_tangents
from gimcli.continuation.arclength import ArclengthConstants, all_beside
from gimcli.continuation.circuit import CIRCUIT, Circuit
from gimcli.dynamics.equilibria_balance import GeneralisedForces, StaticBalance, position_jet
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.numerics.along import roots
from gimcli.progress import spend
from gimcli.status import Status

STABLE, UNSTABLE, UNDECIDED = "stable", "unstable", "undecided"
"""Stability; undecided: the second derivatives of the potential do not decide it, such as at a double root."""


@dataclass(frozen=True)
class Push:
    """The least effort of a released input that pushes the mechanism from a stable equilibrium over the next one."""

    sense: int  # 1 or -1: of the input at the start
    effort: float | None  # N m, or N; None where the input reaches a limit before
    inputs: FloatArray  # (actuators,) at the greatest effort; at the limit if there is one
    barrier: float  # J, difference of the potential
    target: int  # number of the other equilibrium in the list


@dataclass(frozen=True)
class Equilibrium:
    """A position in which all forces balance."""

    z: ComplexArray = field(repr=False)  # (nodes,)
    inputs: FloatArray  # (actuators,) rad, or length of the normal frame
    potential: float  # J
    stability: str
    negative: int  # number of directions in which the potential decreases
    multiplicity: int  # 1; 2: a double root; 0: one of a continuum
    stiffness: FloatArray | None  # (k, k) N m/rad, N or N/m, of the released inputs; None at a limit of an input
    residual: float  # force, relative to the sum of its contributions
    status: Status = Status.OK
    fraction: float = 0.0  # of the length of the circuit; below 0 and above 1 in further rounds
    pushes: tuple[Push, ...] = ()


@dataclass(frozen=True)
class BalanceHistory:
    """The forces along the circuit of one released input."""

    z: ComplexArray = field(repr=False)  # (nodes, rows)
    inputs: FloatArray  # (actuators, rows)
    fraction: FloatArray  # (rows,) of the length of the circuit
    potential: FloatArray  # (rows,) J
    effort: FloatArray  # (rows,) N m, or N, that holds the input; infinite at its limits


@dataclass(frozen=True)
class Equilibria:
    """All equilibria that were found."""

    found: tuple[Equilibrium, ...]
    released: tuple[int, ...]
    start: ComplexArray = field(repr=False)  # (nodes,) position from which they were searched
    start_inputs: FloatArray  # (actuators,)
    holding: FloatArray  # (k,) N m, or N, efforts of the released inputs that hold the mechanism there
    conservative: bool
    everywhere: bool  # all positions that were examined are in equilibrium
    size: float  # greatest sum of the magnitudes of all contributions to a force [J per rad or normal length]
    history: BalanceHistory | None = None  # of one released input
    closed: bool = False  # whether its circuit is closed
    ended: str = ""  # why it ends
    crossings: int = 0  # number of change points on it, where other branches leave
    gain: float = 0.0  # J, change of the potential in one round of a closed circuit
    winds: bool = False  # whether a torsion spring is wound in each round
    cut: bool = False  # whether further rounds were not examined
    starts: int = 0  # number of starts of the search with several released inputs
    limited: bool = False  # whether the search ended at its bound on work
    failed: int = 0  # number of starts from which it did not converge


@dataclass(frozen=True)
class BalanceConstants:
    """Constants of the search along a circuit; forces are relative to the sum of their contributions."""

    resolved: float = 2e-4  # greatest error of the cubic between two points
    integrated: float = 2e-6  # the same, where the force is integrated
    depth: int = 12  # most halvings of the interval between two points of the circuit
    nothing: float = 1e-11  # a force below this everywhere is 0
    touching: float = 1e-12  # a least force below this is a double root
    residual: float = 1e-10  # greatest force at a root
    flat: float = 1e-5  # slope below which a root may be a multiple one
    window: float = 0.02  # half the width of the interval in which a multiple root is examined
    cluster: float = 1e-4  # greatest distance of the roots of a polynomial that are one multiple root
    rounds: int = 12  # most rounds in each sense over which a torsion spring is wound
    work: int = 8_000  # positions after which the forces are not examined further; mechanisms need some hundreds
    more: float = 1.5  # relative number of positions after which no root is searched


BALANCE = BalanceConstants()

CORRECTIONS = ArclengthConstants(corrections=12, rounding=1e-10, noise=1e-10, pull=0.2, bend=math.acos(0.9))
"""Constants of the points beside a root."""


@dataclass(frozen=True)
class CurveStop:
    """Where a point is on a circuit: after point `index` of the circuit, in some round."""

    round: int
    index: int
    part: float  # 0..1, fraction of the step to the next point

    def mark(self, count: int) -> float:
        """Return a number that grows along the circuit; `count` is the number of steps of a round."""
        return self.round * count + self.index + self.part


@dataclass(frozen=True)
class BalancePoint:
    """A position on the circuit with the force along it."""

    stop: CurveStop
    mark: float
    p: FloatArray = field(repr=False)  # (n + 1,)
    tangent: FloatArray = field(repr=False)  # (n + 1,)
    bend: FloatArray = field(repr=False)  # (n + 1,) second derivative by the arc length
    potential: float  # J
    force: float  # J per unit of length
    slope: float  # its derivative
    rest: float  # the part of the force without a potential
    rest_slope: float
    size: float
    angles: FloatArray = field(repr=False)

    @property
    def rate(self) -> float:
        """The derivative of the released input by the arc length."""
        return float(self.tangent[-1])

    @property
    def effort(self) -> float:
        """The effort that holds the input [J per unit of the input]; infinite at a dead point of the input."""
        return -self.force / self.rate if self.rate else math.inf

    @property
    def effort_slope(self) -> float:
        """The derivative of the effort by the arc length, times the square of `rate`."""
        return self.force * float(self.bend[-1]) - self.slope * self.rate


class BalanceCurve:
    """The force along a circuit."""

    def __init__(self, circuit: Circuit, balance: StaticBalance) -> None:
        assert circuit.curve.line is not None
        self.circuit, self.balance, self.evaluated = circuit, balance, 0
        self.count = len(circuit.places) - 1

    def ended(self, more: float = 1.0) -> bool:
        """Return whether the search is at its bound on work."""
        return self.evaluated > more * BALANCE.work or spend()

    # -- points ---------------------------------------------------------------------------------------

    @cached_property
    def places(self) -> list[BalancePoint]:
        """The points of the circuit, in the round 0."""
        own = self.circuit.places
        stops = [CurveStop(0, k, 0.0) for k in range(len(own))]
        found = self._points(stops, self.circuit.p.T, self.circuit.tangents, self._begin())
        turned = found[-1].angles - found[0].angles
        if self.circuit.closed and not np.any(np.abs(turned[: len(self.balance.twisted)]) > 1.0):
            found[-1] = joined(found[-1], found[0])
        return found

    def _begin(self) -> FloatArray:
        """Return the angles near the first point of the circuit: at its start they are near the initial ones."""
        start, initial = self.circuit.start, self.balance.initial_angles()
        if not len(initial):
            return initial
        stops, back = [CurveStop(0, 0, 0.0)] * (start + 1), slice(start, None, -1)
        return self._points(stops, self.circuit.p.T[back], self.circuit.tangents[back], initial)[-1].angles

    @cached_property
    def winding(self) -> FloatArray:
        """Whole turns [rad] by which the angles grow in one round."""
        change = self.places[-1].angles - self.places[0].angles
        turn = 2.0 * math.pi
        return turn * np.round(change / turn) if self.circuit.closed else 0.0 * change

    @cached_property
    def turn(self) -> float:
        """The growth of the released input in one round."""
        change = float(self.circuit.places[-1].p[-1] - self.circuit.places[0].p[-1])
        line = self.circuit.curve.line
        rotary = line is not None and self.circuit.mechanism.actuators[line.main].rotary
        return 2.0 * math.pi * round(change / (2.0 * math.pi)) if rotary and self.circuit.closed else 0.0

    @property
    def winds(self) -> bool:
        """Whether a torsion spring is wound further in each round, so that rounds differ."""
        return bool(np.any(self.winding[: len(self.balance.twisted)]))

    def round(self, number: int) -> list[BalancePoint]:
        """Return the points of the circuit in a round."""
        if number == 0:
            return self.places
        stops = [CurveStop(number, k, 0.0) for k in range(len(self.places))]
        return self._in_rounds(stops, self.circuit.p.T, self.circuit.tangents)

    def all_at(self, stops: Sequence[CurveStop]) -> list[BalancePoint]:
        """Return the points at some stops."""
        if not stops:
            return []
        index, part = np.array([(stop.index, stop.part) for stop in stops]).T
        return self._in_rounds(stops, *exact_tangents(self.circuit, index.astype(int), part))

    def beside(self, points: Sequence[BalancePoint], offsets: FloatArray) -> list[BalancePoint | None]:
        """Return the points at distances (points,) along the tangents of other points; None where there is none."""
        if not points:
            return []
        ahead, p = np.array([at.tangent for at in points]), np.array([at.p for at in points])
        p[:, -1] -= np.array([at.stop.round for at in points]) * self.turn
        found, there, good = all_beside(self.circuit.curve, ahead, p + offsets[:, None] * ahead, offsets, CORRECTIONS)
        stops = [at.stop for at, own in zip(points, good, strict=True) if own]
        each = iter(self._in_rounds(stops, found[good], there[good]) if stops else ())
        return [next(each) if own else None for own in good]

    def _in_rounds(self, stops: Sequence[CurveStop], p: FloatArray, tangents: FloatArray) -> list[BalancePoint]:
        """Return the points at stops in their rounds, from positions and tangents (stops, n + 1) in the round 0."""
        rounds = np.array([stop.round for stop in stops])
        moved = np.column_stack([p[:, :-1], p[:, -1] + rounds * self.turn])
        near = [self.places[stop.index].angles + stop.round * self.winding for stop in stops]
        return self._points(stops, moved, tangents, np.array(near).T)

    def _points(
        self, stops: Sequence[CurveStop], p: FloatArray, tangents: FloatArray, near: FloatArray
    ) -> list[BalancePoint]:
        """Return points with the forces; `near` as in `GeneralisedForces`."""
        self.evaluated += len(stops)
        bends = self.circuit.curve.bends(p, tangents[:, None])[:, 0, 0]
        for k, stop in enumerate(stops):
            self._correct_bend(bends[k], stop, p[k])
        jet = position_jet(self.circuit.curve, p, tangents[None], bends[None, None])
        found = GeneralisedForces(self.balance, jet, near)
        return [
            BalancePoint(
                stop, stop.mark(self.count), p[k], tangents[k], bends[k], float(found.potential[k]),
                float(found.q[0, k]), float(found.slope[0, 0, k]), float(found.rest[0, k]),
                float(found.rest_slope[0, 0, k]), float(found.size[0, k]),
                found.angles[:, k],
            )
            for k, stop in enumerate(stops)
        ]  # fmt: skip

    def _correct_bend(self, bend: FloatArray, stop: CurveStop, p: FloatArray) -> None:
        """Set the second derivative of a point by the arc length where branches meet, from the points beside it."""
        circuit, k = self.circuit, stop.index
        met = [j for j in (k, k + 1) if j in circuit.crossings]
        if any(np.linalg.norm(circuit.places[j].p[:-1] - p[:-1]) <= CIRCUIT.beside for j in met):
            low, high = circuit.places[max(met[0] - 1, 0)], circuit.places[min(met[0] + 1, self.count)]
            bend[:] = (high.tangent - low.tangent) / np.linalg.norm(high.p - low.p)

    # -- resolution -----------------------------------------------------------------------------------

    def resolved(self, number: int) -> list[BalancePoint]:
        """Return so many points of a round, from its first to its last, that cubics give the force between them."""
        own = self.round(number)
        least = BALANCE.nothing * float(np.median([at.size for at in own]))
        found, open_ones = list(own), list(pairwise(own))
        for _ in range(BALANCE.depth):
            if not open_ones or self.ended():
                break
            middles = self.middles((a, b, 0.5) for a, b in open_ones)
            found += middles
            each = [
                (a, m, b) for (a, b), m in zip(open_ones, middles, strict=True) if not self._is_cubic(a, m, b, least)
            ]
            open_ones = [pair for a, m, b in each for pair in ((a, m), (m, b))]
        return sorted(found, key=lambda at: at.mark)

    def _is_cubic(self, a: BalancePoint, middle: BalancePoint, b: BalancePoint, least: float) -> bool:
        """Return whether the cubic between two points gives the force at the middle; `least`: size of no force."""
        guess = 0.5 * (a.force + b.force) + 0.125 * distance(a, b) * (a.slope - b.slope)
        scale = max(a.size, b.size, middle.size)
        error = BALANCE.resolved if self.balance.conservative else BALANCE.integrated
        return scale <= least or abs(guess - middle.force) <= error * scale

    def middles(self, pairs: Iterable[tuple[BalancePoint, BalancePoint, float]]) -> list[BalancePoint]:
        """Return the points at fractions between two points each of the same step of the circuit."""
        each = [(a.stop, *self.parts(a, b), part) for a, b, part in pairs]
        return self.all_at([CurveStop(s.round, s.index, low + part * (high - low)) for s, low, high, part in each])

    def parts(self, a: BalancePoint, b: BalancePoint) -> tuple[float, float]:
        """Return the fractions of two points of the same step, the second of which may be the end of the step."""
        return a.stop.part, b.stop.part if b.stop.index == a.stop.index else 1.0

    def between(self, pairs: Sequence[tuple[BalancePoint, BalancePoint]], name: str) -> list[BalancePoint]:
        """Return the points, each between two points of the same step, at which a field of them changes its sign."""
        ends = [((low, a), (high, b)) for a, b in pairs for low, high in [self.parts(a, b)]]

        def at(numbers: list[int], places: list[float]) -> list[BalancePoint]:
            stops = (pairs[k][0].stop for k in numbers)
            return self.all_at([CurveStop(s.round, s.index, part) for s, part in zip(stops, places, strict=True)])

        return roots(at, attrgetter(name), ends, 1e-15)

    def work(self, points: Sequence[BalancePoint]) -> FloatArray:
        """Return the work (points,) of the forces without a potential from the first point on [J].

        It is the integral of the cubic through each two points, which are resolved.
        """
        if self.balance.conservative:
            return np.zeros(len(points))
        each = [0.0]
        for a, b in pairwise(points):
            h = arc_length(a, b)
            each.append(0.5 * h * (a.rest + b.rest) + h**2 / 12.0 * (a.rest_slope - b.rest_slope))
        return np.cumsum(each)


def arc_length(a: BalancePoint, b: BalancePoint) -> float:
    """Return the arc length between two points: that of a circle of the mean square of their curvatures."""
    chord, square = distance(a, b), 0.5 * float(a.bend @ a.bend + b.bend @ b.bend)
    bent = square * chord**2
    return chord * (1.0 + bent / 24.0 + 3.0 * bent**2 / 640.0)


def joined(point: BalancePoint, same: BalancePoint) -> BalancePoint:
    """Return a point with the force of the same point in another round: rounding may give it the other sign."""
    return replace(point, force=same.force, slope=same.slope)


def distance(a: BalancePoint, b: BalancePoint) -> float:
    """Return the distance of two points in the space of positions and inputs."""
    return float(np.linalg.norm(b.p - a.p))
