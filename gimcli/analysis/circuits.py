"""The circuits of a mechanism: which of its configurations the motion joins.

A circuit is all that is reached from a configuration without taking the mechanism apart; a branch of it is a stretch
between two limits of the input. All configurations are listed at many values of the input; each that lies on no
curve known so far is followed, through limits and change points, until it is home. Source: Chase & Mirth, Circuits
and branches of single-degree-of-freedom planar linkages, J. Mech. Design 115, 1993.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from gimcli.analysis.configurations import Configurations, all_configurations, configurations_over
from gimcli.analysis.singularities import LIMIT, Singularity, interval, limits
from gimcli.analysis.survey import drawn_circuit
from gimcli.errors import GimError, StructureError
from gimcli.mechanism import ComplexArray, Drive, FloatArray, Mechanism
from gimcli.motion.branches import all_circuits, first_circuit
from gimcli.motion.circuit import Circuit
from gimcli.motion.circuit import Policy as Following
from gimcli.motion.curve import Curve
from gimcli.motion.stations import between
from gimcli.solvers.arclength import correct

Progress = Callable[[int, int], None]

TOLERANCE = 1e-10
"""Of the drawn position, relative to the size."""


@dataclass(frozen=True)
class Policy:
    """Constants of the search."""

    samples: int = 72  # values of the input at which all configurations are listed
    aside: float = 0.3819660112501051  # part of a step by which they stand off round values, where change points are
    same: float = 1e-7  # distance within which a configuration lies on a curve
    near: float = 0.5  # part of a step of the curve within which that is worth asking
    narrow: float = 0.7  # part of the range looked at below which what was found there is looked at once more


@dataclass(frozen=True)
class Branch:
    """A stretch of a curve between two limits, or the whole where there is none."""

    start: float  # parameter
    end: float
    way: tuple[float, float]  # 0..1 along the curve; beyond 1: through its start


@dataclass(frozen=True)
class Strand:
    """One curve of a circuit; those of a circuit meet at change points."""

    number: int  # of the circuit, from 0
    circuit: Circuit = field(repr=False)
    limits: tuple[Singularity, ...] = field(repr=False)
    interval: tuple[float, float]
    branches: tuple[Branch, ...]


@dataclass(frozen=True)
class Circuits:
    """All circuits that were met, and what is known of their being all."""

    curve: Curve = field(repr=False)
    strands: tuple[Strand, ...]
    sampled: FloatArray = field(repr=False)  # parameters at which all configurations were asked for
    spacing: float  # of these over the whole range: a circuit that spans less may be missed
    complete: bool  # the list of configurations was proved at each, and each lies on one of the strands
    lost: int  # configurations that could not be followed
    start: Configurations  # those at the start of the law
    places: tuple[tuple[tuple[int, int], ...], ...]  # strand and branch of each of these

    @property
    def count(self) -> int:
        """Number of circuits."""
        return 1 + max((strand.number for strand in self.strands), default=-1)


def circuits(mechanism: Mechanism, policy: Policy | None = None, progress: Progress | None = None) -> Circuits:
    """Find the circuits of a mechanism driven by one input, or by several that follow their laws together.

    Raises StructureError without an actuator, or where it is not driven or over-driven.
    """
    if not mechanism.actuators:
        raise StructureError(f"{mechanism.name} has no actuator: nothing moves; add one, or use `gim solve --all`")
    search = _Search(mechanism, policy or Policy(), progress)
    search.run()
    start = all_configurations(mechanism, search.curve.inputs(search.curve.begin()))
    places = tuple(tuple(search.places(z, search.curve.begin())) for z in start.z)
    return Circuits(
        search.curve, tuple(search.strands), np.array(search.sampled), search.sampled[1] - search.sampled[0],
        search.complete and not search.lost, search.lost, start, places,
    )  # fmt: skip


class _Search:
    """The strands found so far."""

    def __init__(self, mechanism: Mechanism, policy: Policy, progress: Progress | None) -> None:
        self.mechanism, self.policy, self.progress = mechanism, policy, progress
        self.curve = Curve(mechanism)
        self.turning = self.curve.single and bool(self.curve.rotary[0])
        self.strands: list[Strand] = []
        self.sampled: list[float] = []
        self.complete, self.lost, self.number = True, 0, 0

    def run(self) -> None:
        with suppress(GimError):  # other configurations may be assembled where the drawn one is not
            self._take(drawn_circuit(self.mechanism, TOLERANCE))
        low, high = self._range()
        self._sample(low, high)
        if self.turning or not self.curve.single:
            return
        for turned in (1.0, -1.0):  # a linear input: as fine where it moves, and where a mirrored assembly would
            ends = [turned * q for strand in self.strands for q in strand.interval] or [low, high]
            own = max(low, min(ends)), min(high, max(ends))
            if 0.0 < own[1] - own[0] < self.policy.narrow * (high - low):
                self._sample(*own)

    def _range(self) -> tuple[float, float]:
        """Return the parameters to look at: a turn, the laws' time, or as far as members reach."""
        if self.turning:
            begin = self.curve.begin()
            return begin, begin + 2.0 * math.pi
        if not self.curve.single:
            return self.curve.laws
        spans = [float(np.max(np.abs(m.shape[:, None] - m.shape))) for m in self.mechanism.members]
        reach = sum(spans) + float(np.max(np.abs([s.point for s in self.mechanism.slides]), initial=0.0))
        distance = self.mechanism.actuators[0].drive is Drive.DISTANCE
        return (0.0 if distance else -reach), reach

    def _sample(self, low: float, high: float) -> None:
        """Ask for all configurations at evenly spaced parameters and follow those that are new."""
        count = self.policy.samples
        q = low + (high - low) * (np.arange(count) + self.policy.aside) / count
        inputs = np.array([self.curve.inputs(value) for value in q.tolist()]).T
        for value, found in zip(
            q.tolist(), configurations_over(self.mechanism, inputs, progress=self.progress), strict=True
        ):
            self.sampled.append(value)
            self.complete &= found.complete
            for z, sure in zip(found.z, np.isfinite(found.radius).tolist(), strict=True):
                if sure and not any(True for _ in self.places(z, value)):
                    self._follow(z, value)

    def _follow(self, z: ComplexArray, q: float) -> None:
        try:
            self._take(first_circuit(self.curve, z, q))
        except GimError:
            self.lost += 1
            return
        if not any(True for _ in self.places(z, q)):
            self.lost += 1

    def _take(self, first: Circuit) -> None:
        """Add a circuit with all that meet it."""
        for circuit in all_circuits(first).circuits:
            found = limits(circuit)
            ends = interval(circuit, found)
            self.strands.append(Strand(self.number, circuit, tuple(found), ends, tuple(_branches(circuit, found))))
        self.number += 1

    def places(self, z: ComplexArray, q: float) -> Iterator[tuple[int, int]]:
        """Yield the strands, and their branches, that run through positions z (nodes,) at a parameter."""
        p = self.curve.point(z, q)
        for number, strand in enumerate(self.strands):
            way = self._way(strand.circuit, p)
            if way is not None:
                yield number, _branch_at(strand, way)

    def _way(self, circuit: Circuit, p: FloatArray) -> float | None:
        """Return where (0..1) a circuit runs through a position; None where it does not."""
        points = circuit.p
        steps = np.linalg.norm(np.diff(points, axis=1), axis=0)
        marks = np.concatenate([[0.0], np.cumsum(steps)])
        period = self._period(circuit)
        for k in _passing(points[-1], float(p[-1]), period):
            part = _part(points[-1, k : k + 2], float(p[-1]), period)
            guess, _ = between(circuit.places[k], circuit.places[k + 1], part)
            if np.linalg.norm(guess[:-1] - p[:-1]) > self.policy.near * steps[k] + self.policy.same:
                continue
            guess[-1] = p[-1]
            held = np.append(np.zeros(len(p) - 1), 1.0)
            exact = correct(circuit.curve, guess, Following().steps, held)
            told = guess if exact is None else exact
            room = self.policy.same if exact is not None else self.policy.near * float(steps[k])
            if np.linalg.norm(told[:-1] - p[:-1]) <= room:
                return float((marks[k] + part * steps[k]) / marks[-1])
        return None

    def _period(self, circuit: Circuit) -> float:
        """Return the change of the parameter after which the inputs are the same; infinite without one."""
        if self.turning:
            return 2.0 * math.pi
        around = abs(float(circuit.p[-1, -1] - circuit.p[-1, 0]))
        return around if circuit.closed and around > self.policy.same else math.inf


def _away(q: FloatArray, wanted: float, period: float) -> FloatArray:
    """Return how far parameters are from one, whole periods after the first left out."""
    away = q - wanted
    return away - period * np.round(away / period) if math.isfinite(period) else away


def _passing(q: FloatArray, wanted: float, period: float) -> list[int]:
    """Return the steps on which the parameter passes a value, or comes close to it as at a fold."""
    near = _away(q[:-1], wanted, period)
    ahead = near + np.diff(q)
    passed = (near > 0.0) != (ahead > 0.0)
    close = np.minimum(np.abs(near), np.abs(ahead)) <= np.abs(np.diff(q))
    return np.flatnonzero(passed | close).tolist()


def _part(ends: FloatArray, wanted: float, period: float) -> float:
    """Return the part of a step at which the parameter has a value."""
    near, step = float(_away(ends[:1], wanted, period)[0]), float(ends[1] - ends[0])
    return min(max(-near / step, 0.0), 1.0) if step else 0.0


def _branches(circuit: Circuit, found: list[Singularity]) -> Iterator[Branch]:
    """Yield the stretches between limits along a circuit."""
    folds = [(s.way, float(s.p[-1])) for s in found if s.kind == LIMIT]
    first, last = float(circuit.p[-1, 0]), float(circuit.p[-1, -1])
    if not folds:
        yield Branch(first, last, (0.0, 1.0))
    elif circuit.closed:
        shift = last - first  # turns of the input
        rounds = [*folds, (folds[0][0] + 1.0, folds[0][1] + shift)]
        for (a, qa), (b, qb) in pairwise(rounds):
            yield Branch(qa, qb, (a, b))
    else:
        ends = [(0.0, first), *folds, (1.0, last)]
        for (a, qa), (b, qb) in pairwise(ends):
            if b > a:
                yield Branch(qa, qb, (a, b))


def _branch_at(strand: Strand, way: float) -> int:
    """Return which branch of a strand holds a place of its way."""
    for k, branch in enumerate(strand.branches):
        if branch.way[0] <= way <= branch.way[1] or branch.way[0] <= way + 1.0 <= branch.way[1]:
            return k
    return 0
