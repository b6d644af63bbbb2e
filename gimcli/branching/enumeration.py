"""The circuits of a mechanism: which of its configurations the motion joins.

A circuit is all that is reached from a configuration without taking the mechanism apart; a branch of it is a stretch
between two limits of the input. All configurations are listed at many values of the input; each that lies on no
curve known so far is followed, through limits and change points, until it is home. Source: Chase & Mirth, Circuits
and branches of single-degree-of-freedom planar linkages, J. Mech. Design 115, 1993.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from gimcli.assemblies import Configurations, all_configurations, configurations_over
from gimcli.branching.singular_positions import drawn_circuit
from gimcli.branching.singularities import LIMIT, Singularity, interval, limits
from gimcli.continuation.branches import all_circuits, first_circuit
from gimcli.continuation.circuit import Circuit
from gimcli.continuation.curve import PositionCurve
from gimcli.continuation.visits import Visits
from gimcli.errors import GimError, StructureError
from gimcli.mechanism import SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.progress import Progress, no_progress
from gimcli.structure.mobility import refuse_unfit

TOLERANCE = 1e-10
"""Of the drawn position, relative to the size."""


@dataclass(frozen=True)
class EnumerationConstants:
    """Constants of the search."""

    samples: int = 72  # values of the input at which all configurations are listed
    aside: float = 0.3819660112501051  # part of a step by which they stand off round values, where change points are
    narrow: float = 0.7  # part of the range looked at below which what was found there is looked at once more


@dataclass(frozen=True)
class CircuitBranch:
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
    branches: tuple[CircuitBranch, ...]
    visits: Visits = field(repr=False)


@dataclass
class _Asked:
    """A parameter and the configurations x (rows, n) there that lie on no strand known so far."""

    q: float
    x: FloatArray


@dataclass(frozen=True)
class Circuits:
    """All circuits that were met, and what is known of their being all."""

    curve: PositionCurve = field(repr=False)
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


def circuits(
    mechanism: Mechanism, constants: EnumerationConstants | None = None, progress: Progress = no_progress
) -> Circuits:
    """Find the circuits of a mechanism driven by one input, or by several that follow their laws together.

    Raises StructureError without an actuator, or where it is not driven or over-driven.
    """
    if not mechanism.actuators:
        raise StructureError(f"{mechanism.name} has no actuator: nothing moves; add one, or use `gim solve --all`")
    refuse_unfit(mechanism)
    curve = PositionCurve(mechanism)
    search = CircuitSearch(curve, curve.single and bool(curve.rotary[0]), constants or EnumerationConstants(), progress)
    search.run()
    start = all_configurations(mechanism, search.curve.inputs(search.curve.begin()))
    places = tuple(tuple(search.places(z, search.curve.begin())) for z in start.z)
    return Circuits(
        search.curve, tuple(search.strands), np.array(search.sampled), search.sampled[1] - search.sampled[0],
        search.complete and not search.lost, search.lost, start, places,
    )  # fmt: skip


class CircuitSearch:
    """The strands found so far. `turning`: the parameter is an angle that may turn fully."""

    def __init__(
        self, curve: PositionCurve, turning: bool, constants: EnumerationConstants, progress: Progress
    ) -> None:
        self.curve, self.turning, self.constants, self.progress = curve, turning, constants, progress
        self.strands: list[Strand] = []
        self.sampled: list[float] = []
        self.complete, self.lost, self.number = True, 0, 0

    @property
    def mechanism(self) -> Mechanism:
        """What moves."""
        return self.curve.mechanism

    def run(self) -> None:
        """Look at all that the input can reach, from the drawn circuit on."""
        self.begin()
        low, high = self._range()
        self.sample(low, high)
        if self.turning or not self.curve.single:
            return
        for turned in (1.0, -1.0):  # a linear input: as fine where it moves, and where a mirrored assembly would
            ends = [turned * q for strand in self.strands for q in strand.interval] or [low, high]
            own = max(low, min(ends)), min(high, max(ends))
            if 0.0 < own[1] - own[0] < self.constants.narrow * (high - low):
                self.sample(*own)

    def begin(self) -> None:
        """Take the drawn circuit."""
        with suppress(GimError):  # other configurations may be assembled where the drawn one is not
            self._take(drawn_circuit(self.mechanism, TOLERANCE))

    def _range(self) -> tuple[float, float]:
        """Return the parameters to look at: a turn, the laws' time, or as far as members reach."""
        if self.turning:
            begin = self.curve.begin()
            return begin, begin + 2.0 * math.pi
        if not self.curve.single:
            return self.curve.laws
        spans = [float(np.max(np.abs(m.shape[:, None] - m.shape))) for m in self.mechanism.members]
        reach = sum(spans) + float(np.max(np.abs([s.point for s in self.mechanism.slides]), initial=0.0))
        distance = self.mechanism.actuators[0].kind == SPAN
        return (0.0 if distance else -reach), reach

    def sample(self, low: float, high: float) -> None:
        """Ask for all configurations at evenly spaced parameters and follow those that are new."""
        count = self.constants.samples
        q = low + (high - low) * (np.arange(count) + self.constants.aside) / count
        inputs = np.array([self.curve.inputs(value) for value in q.tolist()]).T
        every = configurations_over(self.mechanism, inputs, progress=lambda done, of: self._report(done, of, 0, 1))
        self.sampled += q.tolist()
        self.complete &= all(found.complete for found in every)
        left = [_Asked(value, self._sure(found)) for value, found in zip(q.tolist(), every, strict=True)]
        for strand in self.strands:
            _cross_off(strand, left)
        known = sum(len(asked.x) for asked in left)
        for asked in left:
            while len(asked.x):
                self._report(1, 1, known - sum(len(other.x) for other in left), known)
                self._follow(asked, left)
        self._report(1, 1, 1, 1)

    def _report(self, listed: int, of_values: int, followed: int, of_configurations: int) -> None:
        """Report how far a sample has come: half of it is to list configurations, half to follow them."""
        part = listed / of_values + followed / of_configurations
        self.progress(int(50.0 * part), 100)

    def _sure(self, found: Configurations) -> FloatArray:
        """Return the coordinates (rows, n) of the configurations that are proved."""
        rows = [self.curve.system.coordinates(z) for z in found.z[np.isfinite(found.radius)]]
        return np.array(rows).reshape(len(rows), self.curve.system.n)

    def _follow(self, asked: _Asked, left: list[_Asked]) -> None:
        """Follow the first configuration at a parameter and cross off all that lie on its circuit."""
        first, known = asked.x[0], len(self.strands)
        with suppress(GimError):
            self._take(first_circuit(self.curve, self.curve.system.nodes(first), asked.q))
        for strand in self.strands[known:]:
            _cross_off(strand, left)
        if len(asked.x) and np.array_equal(asked.x[0], first):
            self.lost += 1
            asked.x = asked.x[1:]

    def _take(self, first: Circuit) -> None:
        """Add a circuit with all that meet it."""
        for circuit in all_circuits(first).circuits:
            found = limits(circuit)
            ends = interval(circuit, found)
            branches, visits = tuple(_branches(circuit, found)), Visits(circuit, self.turning)
            self.strands.append(Strand(self.number, circuit, tuple(found), ends, branches, visits))
        self.number += 1

    def places(self, z: ComplexArray, q: float) -> Iterator[tuple[int, int]]:
        """Yield the strands, and their branches, that run through positions z (nodes,) at a parameter."""
        x = self.curve.system.coordinates(z)
        for number, strand in enumerate(self.strands):
            (way,) = strand.visits.locations(x[None, :], q).tolist()
            if not math.isnan(way):
                yield number, _branch_at(strand, way)


def _cross_off(strand: Strand, left: list[_Asked]) -> None:
    """Leave out the configurations that a strand runs through."""
    for asked in left:
        if len(asked.x):
            asked.x = asked.x[np.isnan(strand.visits.locations(asked.x, asked.q))]


def _branches(circuit: Circuit, found: list[Singularity]) -> Iterator[CircuitBranch]:
    """Yield the stretches between limits along a circuit."""
    folds = [(s.way, float(s.p[-1])) for s in found if s.kind == LIMIT]
    first, last = float(circuit.p[-1, 0]), float(circuit.p[-1, -1])
    if not folds:
        yield CircuitBranch(first, last, (0.0, 1.0))
    elif circuit.closed:
        shift = last - first  # turns of the input
        rounds = [*folds, (folds[0][0] + 1.0, folds[0][1] + shift)]
        for (a, qa), (b, qb) in pairwise(rounds):
            yield CircuitBranch(qa, qb, (a, b))
    else:
        ends = [(0.0, first), *folds, (1.0, last)]
        for (a, qa), (b, qb) in pairwise(ends):
            if b > a:
                yield CircuitBranch(qa, qb, (a, b))


def _branch_at(strand: Strand, way: float) -> int:
    """Return which branch of a strand holds a place of its way."""
    for k, branch in enumerate(strand.branches):
        if branch.way[0] <= way <= branch.way[1] or branch.way[0] <= way + 1.0 <= branch.way[1]:
            return k
    return 0
