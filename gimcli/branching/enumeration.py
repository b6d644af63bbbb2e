"""The circuits of a mechanism: the sets of configurations that are connected by motions.

A circuit contains all positions that can be reached from one without disassembly; a branch is a part of it between two
limits of the input. All configurations are found at many values of the input. Each that is on no known curve is
followed, through limits and change points, until it is back in its initial configuration. Source: Chase & Mirth,
Circuits and branches of single-degree-of-freedom planar linkages, J. Mech. Design 115, 1993.

Test which of several positions at the same input are on a circuit, in one pass over its points.
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
from gimcli.continuation import gauss_newton
from gimcli.continuation.branches import all_circuits, first_circuit
from gimcli.continuation.circuit import Circuit
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError, StructureError
from gimcli.mechanism import SPAN, BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.numerics.along import hermite
from gimcli.positions.options import TOLERANCE
from gimcli.progress import Progress, no_progress, spend
from gimcli.structure.mobility import require_driven

SETTLING = gauss_newton.GaussNewtonConstants(iterations=8)
"""The cubic between two points deviates from the circuit by some 1e-5 at most, so few iterations suffice."""


SAME, NEAR = 1e-7, 0.5
"""Distance within which a position is on a circuit; distance, in steps, within which it is tested exactly."""


class Visits:
    """The points of a circuit as arrays. turning: its parameter is an angle with a period."""

    def __init__(self, circuit: Circuit, turning: bool) -> None:
        self.circuit, self.curve, self.p = circuit, circuit.curve, circuit.p.T
        self.step = np.diff(circuit.lengths)
        around = abs(float(self.p[-1, -1] - self.p[0, -1]))
        closes = circuit.closed and around > SAME
        self.period = circuit.curve.period if turning else around if closes else math.inf

    def locations(self, x: FloatArray, q: float) -> FloatArray:
        """Return the locations (0..1) on the circuit of positions x (rows, n) at parameter q; NaN if not on it."""
        found, marks = np.full(len(x), np.nan), self.circuit.lengths
        k = self._passing(q)
        part = self._parts(k, q)
        x = x[:, : self.curve.system.coordinated]
        apart = np.linalg.norm(self._between(k, part)[:, None, : x.shape[1]] - x, axis=2)
        near = apart <= (NEAR * self.step[k] + SAME)[:, None]
        asked = near.any(axis=1)
        if not asked.any():
            return found
        k, part, apart, near = k[asked], part[asked], apart[asked], near[asked]
        hit = near & self._meets(k, part, x, q)
        best = np.argmin(np.where(hit, apart, np.inf), axis=0)
        on = hit.any(axis=0)
        found[on] = ((marks[k] + part * self.step[k]) / marks[-1])[best[on]]
        return found

    def _meets(self, k: IntArray, part: FloatArray, x: FloatArray, q: float) -> BoolArray:
        """Return (steps, rows) whether the exact point of some steps at the parameter is at coordinates x (rows, c)."""
        guess, system = self._between(k, part)[:, :-1], self.curve.system
        exact, good = gauss_newton.settle(system.equations_at(self.curve.given(q)), guess, SETTLING)
        corrected = np.where(good[:, None], exact, guess)
        room = np.where(good, SAME, NEAR * self.step[k])
        return np.asarray(np.linalg.norm(corrected[:, None, : x.shape[1]] - x, axis=2) <= room[:, None])

    def _passing(self, q: float) -> IntArray:
        """Return the steps in which the parameter passes a value, or comes close to it, as at a fold."""
        change = np.diff(self.p[:, -1])
        near = self._away(self.p[:-1, -1], q)
        ahead = near + change
        passed = (near > 0.0) != (ahead > 0.0)
        close = np.minimum(np.abs(near), np.abs(ahead)) <= np.abs(change)
        return np.flatnonzero(passed | close)

    def _parts(self, k: IntArray, q: float) -> FloatArray:
        """Return the fractions of some steps at which the parameter has a value."""
        near, change = self._away(self.p[k, -1], q), self.p[k + 1, -1] - self.p[k, -1]
        return np.asarray(np.clip(np.where(change == 0.0, 0.0, -near / np.where(change == 0.0, 1.0, change)), 0.0, 1.0))

    def _away(self, q: FloatArray, wanted: float) -> FloatArray:
        """Return the differences of parameters from one, modulo the period."""
        change = q - wanted
        return change - self.period * np.round(change / self.period) if math.isfinite(self.period) else change

    def _between(self, k: IntArray, part: FloatArray) -> FloatArray:
        """Return points (steps, n + 1) on the cubics between the points before and after some steps."""
        ahead, h = self.circuit.tangents, self.step[k, None]
        return hermite(self.p[k], h * ahead[k], self.p[k + 1], h * ahead[k + 1], part[:, None])


@dataclass(frozen=True)
class EnumerationConstants:
    """Constants of the search."""

    samples: int = 72  # values of the input at which all configurations are found
    aside: float = 0.3819660112501051  # offset of these values in steps, since change points are at round values
    narrow: float = 0.7  # fraction of the searched range below which the range of the result is searched once more


@dataclass(frozen=True)
class CircuitBranch:
    """The part of a curve between two limits, or the whole curve if there are none."""

    start: FloatArray  # position and parameter (n + 1,)
    end: FloatArray
    fractions: tuple[float, float]  # of the length of the curve; above 1 if the part contains its start


@dataclass(frozen=True)
class Strand:
    """One curve of a circuit; the curves of a circuit intersect at change points."""

    number: int  # of the circuit, from 0
    circuit: Circuit = field(repr=False)
    limits: tuple[Singularity, ...] = field(repr=False)
    interval: tuple[float, float]
    branches: tuple[CircuitBranch, ...]
    visits: Visits = field(repr=False)


@dataclass(frozen=True)
class Circuits:
    """The circuits that were found, and how complete they are."""

    curve: PositionCurve = field(repr=False)
    strands: tuple[Strand, ...]
    sampled: FloatArray = field(repr=False)  # parameters at which all configurations were found
    spacing: float  # greatest spacing of these parameters: circuits with a smaller range may be missed
    complete: bool  # at each parameter the list of configurations is proved, and all are on the curves
    lost: int  # number of configurations that could not be followed
    start: Configurations  # configurations at the start of the law
    places: tuple[tuple[tuple[int, int], ...], ...]  # numbers of curve and branch of each of these

    @property
    def count(self) -> int:
        """Number of circuits."""
        return 1 + max((strand.number for strand in self.strands), default=-1)


def circuits(
    mechanism: Mechanism, constants: EnumerationConstants | None = None, progress: Progress = no_progress
) -> Circuits:
    """Find the circuits of a mechanism driven by one input, or by several that follow their laws together.

    Raises StructureError if there is no actuator, or the mechanism is underdriven or overdriven.
    """
    if not mechanism.actuators:
        raise StructureError(f"{mechanism.name} has no actuator: add one, or use `gim solve --all`")
    require_driven(mechanism)
    curve = PositionCurve(mechanism)
    search = CircuitSearch(curve, curve.single and curve.periodic, constants or EnumerationConstants(), progress)
    search.run()
    start = all_configurations(mechanism, search.curve.given(search.curve.begin()))
    places = tuple(tuple(search.places(z, search.curve.begin())) for z in start.z)
    return Circuits(
        search.curve, tuple(search.strands), np.array(search.sampled), search.spacing,
        search.complete and not search.lost, search.lost, start, places,
    )  # fmt: skip


class CircuitSearch:
    """Search for circuits; `turning`: the parameter is an angle, and all inputs are the same after some turns."""

    def __init__(
        self, curve: PositionCurve, turning: bool, constants: EnumerationConstants, progress: Progress
    ) -> None:
        self.mechanism, self.curve, self.turning = curve.mechanism, curve, turning
        self.constants, self.progress = constants, progress
        self.strands: list[Strand] = []
        self.sampled: list[float] = []
        self.complete, self.lost, self.number, self.spacing = True, 0, 0, 0.0

    def run(self) -> None:
        """Return the circuits over the range of the input, the one of the initial position first."""
        self.begin()
        low, high = self._range()
        self.sample(low, high)
        if self.turning or not self.curve.single or self.curve.rotary[self.curve.main]:
            return
        for turned in (1.0, -1.0):  # a linear input: its own range and that of the mirrored one
            ends = [turned * q for strand in self.strands for q in strand.interval] or [low, high]
            own = max(low, min(ends)), min(high, max(ends))
            if 0.0 < own[1] - own[0] < self.constants.narrow * (high - low) and not spend():
                self.sample(*own)

    def begin(self) -> None:
        """Follow the circuit of the initial position."""
        with suppress(GimError):  # other configurations may exist if the initial one cannot be assembled
            self._take(drawn_circuit(self.mechanism, TOLERANCE))

    def _range(self) -> tuple[float, float]:
        """Return the range of parameters: turns of a period, time of the laws, or reach of the members."""
        if self.turning:
            begin = self.curve.begin()
            return begin, begin + self.curve.period
        if not self.curve.single or self.curve.rotary[self.curve.main]:
            return self.curve.laws
        reach = sum(member.extent for member in self.mechanism.members) + float(
            np.max(np.abs([s.point for s in self.mechanism.slides]), initial=0.0)
        )
        distance = self.mechanism.actuators[self.curve.main].kind == SPAN
        return (0.0 if distance else -reach), reach

    def sample(self, low: float, high: float) -> None:
        """Find all configurations at evenly spaced parameters, and follow those that are new."""
        count = self.constants.samples * (round(self.curve.period / (2.0 * math.pi)) if self.turning else 1)
        q = low + (high - low) * (np.arange(count) + self.constants.aside) / count
        inputs = np.array([self.curve.given(value) for value in q.tolist()]).T
        every = configurations_over(self.mechanism, inputs, progress=lambda done, of: self._report(done, of, 0, 1))
        self.sampled += q.tolist()[: len(every)]
        self.complete &= all(found.complete for found in every)
        left = {value: self._sure(found) for value, found in zip(q.tolist(), every, strict=False)}
        for strand in self.strands:
            _remove_known(strand, left)
        known = sum(map(len, left.values()))
        for value in left:
            while len(left[value]) and not spend():
                self._report(1, 1, known - sum(map(len, left.values())), known)
                self._follow(value, left)
        self._report(1, 1, 1, 1)
        self.spacing, self.complete = self.spacing or float(q[1] - q[0]), self.complete and not spend()

    def _report(self, listed: int, of_values: int, followed: int, of_configurations: int) -> None:
        """Report the progress of a sample: half of it for finding configurations, half for following them."""
        self.progress(int(50.0 * (listed / of_values + followed / of_configurations)), 100)

    def _sure(self, found: Configurations) -> FloatArray:
        """Return the coordinates (rows, n) of the configurations that are proved."""
        rows = (self.curve.system.coordinates(z) for z in found.z[np.isfinite(found.radius)])
        return np.reshape([*rows], (-1, self.curve.system.n))

    def _follow(self, q: float, left: dict[float, FloatArray]) -> None:
        """Follow the first configuration at a parameter, and remove all configurations that are on its circuit."""
        first, known = left[q][0], len(self.strands)
        with suppress(GimError):
            self._take(first_circuit(self.curve, self.curve.system.nodes(first), q))
        for strand in self.strands[known:]:
            _remove_known(strand, left)
        if len(left[q]) and np.array_equal(left[q][0], first):
            self.lost += 1
            left[q] = left[q][1:]

    def _take(self, first: Circuit) -> None:
        """Add a circuit with all curves that intersect it."""
        for circuit in all_circuits(first).circuits:
            found = limits(circuit)
            ends = interval(circuit, found)
            branches, visits = tuple(_branches(circuit, found)), Visits(circuit, self.turning)
            self.strands.append(Strand(self.number, circuit, tuple(found), ends, branches, visits))
        self.number += 1

    def places(self, z: ComplexArray, q: float) -> Iterator[tuple[int, int]]:
        """Yield the numbers of the curves through a position z (nodes,) at a parameter, and of their branches."""
        x = self.curve.system.coordinates(z)
        for number, strand in enumerate(self.strands):
            (fraction,) = strand.visits.locations(x[None, :], q).tolist()
            if not math.isnan(fraction):
                yield number, _branch_at(strand, fraction)


def _remove_known(strand: Strand, left: dict[float, FloatArray]) -> None:
    """Remove the configurations that are on a curve from those (rows, n) at each parameter."""
    for q, x in left.items():
        if len(x):
            left[q] = x[np.isnan(strand.visits.locations(x, q))]


def _branches(circuit: Circuit, found: list[Singularity]) -> Iterator[CircuitBranch]:
    """Yield the branches of a circuit."""
    folds = [(s.fraction, s.p) for s in found if s.kind == LIMIT]
    first, last = circuit.places[0].p, circuit.places[-1].p
    if circuit.closed and folds:  # last - first: full turns of the inputs
        marks = [*folds, (folds[0][0] + 1.0, folds[0][1] + last - first)]
    else:
        marks = [(0.0, first), *folds, (1.0, last)]
    for (a, pa), (b, pb) in pairwise(marks):
        if b > a:
            yield CircuitBranch(pa, pb, (a, b))


def _branch_at(strand: Strand, fraction: float) -> int:
    """Return the number of the branch that contains a fraction of the length of a curve."""
    for k, branch in enumerate(strand.branches):
        low, high = branch.fractions
        if low <= fraction <= high or low <= fraction + 1.0 <= high:
            return k
    return 0
