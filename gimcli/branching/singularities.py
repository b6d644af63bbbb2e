"""Limits, dead points, change points and stationary positions along a circuit.

Along a circuit with unit tangent t the input rate is zero where t_q = 0: there F_x is singular and the input cannot
drive. The input reverses (limit) or not (dead point). If [F_x F_q] loses rank too, branches intersect (change point),
or there is only one, which is double (tangency). A member hinged to the frame, or a slider on it, is stationary where
its rate is 0 (often called a dead centre). The kind of a singular initial position is determined on the curve that
`trace` and `singularities` follow.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from operator import attrgetter

import numpy as np

from gimcli.canonical import first_greatest, ranks
from gimcli.continuation.arclength import CurvePoint, between
from gimcli.continuation.bifurcation import BRANCHING, Crossing
from gimcli.continuation.branches import departure
from gimcli.continuation.circuit import STEPS, Circuit, ordered
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError
from gimcli.mechanism import FRAME, HEIGHT, ComplexArray, FloatArray, Mechanism
from gimcli.positions.options import TOLERANCE
from gimcli.structure.tangency import tangent_position

TOGETHER = 1e-9
"""Difference of two positions at the same place, as a fraction of the length."""

REST = 1e-9
"""A component of a unit tangent below this is 0."""

Rate = Callable[[CurvePoint], float]
"""Rate of an input, or of a member, along the curve."""

LIMIT, DEAD, STATIONARY = "limit", "dead point", "stationary"


@dataclass(frozen=True)
class Bounds:
    """Constants of the search."""

    still: float = 1e-7  # component of a unit tangent that counts as 0 at a minimum
    slow: float = 0.2  # component of a unit tangent below which a minimum is searched
    share: float = 0.05  # least entry of a null vector, relative to the greatest, for a constraint to be named


BOUNDS = Bounds()


@dataclass(frozen=True)
class Singularity:
    """A singular or stationary position of a circuit."""

    kind: str
    fraction: float  # of the length of the circuit, 0..1
    p: FloatArray = field(repr=False)  # (n + 1,) position and parameter
    tangent: FloatArray = field(repr=False)  # (n + 1,) of the circuit
    about: tuple[str, ...]  # constraints with a self-stress, or the stationary members
    branches: tuple[FloatArray, ...] = field(repr=False, default=())  # tangents of all branches (n + 1,)
    end: str = ""  # of a limit: "upper" or "lower"
    circuit: int = 0  # number of the circuit
    loose: bool = False  # positions with more than one degree of freedom intersect the circuit there


def singularities(circuit: Circuit, number: int = 0) -> list[Singularity]:
    """Return the singular and stationary positions of a circuit, in order along it."""
    search = _SingularitySearch(circuit, number)
    return _in_order([*search.crossings(), *search.limits(), *search.dead_points(), *search.stationary()])


def limits(circuit: Circuit) -> list[Singularity]:
    """Return only the limits of the input."""
    return _in_order(_SingularitySearch(circuit, 0).limits())


def dead_points(circuit: Circuit) -> list[Singularity]:
    """Return the positions with zero input rate in which the input does not reverse."""
    return _in_order(_SingularitySearch(circuit, 0).dead_points())


def _in_order(found: Iterable[Singularity]) -> list[Singularity]:
    """Return positions in order along the circuit; those at the same place keep the order in which they were found."""
    listed = list(found)
    order = np.argsort(ranks(np.array([one.fraction for one in listed]), TOGETHER), kind="stable")
    return [listed[k] for k in order]


def interval(circuit: Circuit, found: list[Singularity]) -> tuple[float, float]:
    """Return the least and greatest parameter of a circuit with the limits `found`; an end at infinity is excluded."""
    ends = [q for q in circuit.infinite if q is not None]
    q = np.concatenate([circuit.p[-1], [s.p[-1] for s in found if s.kind == LIMIT], ends])
    return float(q.min()), float(q.max())


def input_ends(circuit: Circuit, ends: tuple[float, float]) -> FloatArray:
    """Return the inputs (2, actuators) at two parameters; those that follow the linkage are least and greatest."""
    found, system = np.array([circuit.curve.given(q) for q in ends]), circuit.curve.system
    for k, follower in enumerate(system.followers, start=system.coordinated):
        turned = [here.p[k] for _, here, _ in reversals(circuit, partial(_rate, k))]
        values = np.append(circuit.p[k], turned)
        found[:, follower] = values.min(), values.max()
    return found


def _rate(unknown: int, at: CurvePoint) -> float:
    return float(at.tangent[unknown])


@dataclass(frozen=True)
class BranchRates:
    """Rates of inputs and members on a branch (file's units), relative to the rate of the input that moves most.

    If all input rates are zero they are relative to the rate of the first member that turns fastest.
    """

    inputs: dict[str, float]
    members: dict[str, float]  # rotation

    @property
    def rests(self) -> bool:
        """Return whether all input rates are zero."""
        return not any(self.inputs.values())


def rates(curve: PositionCurve, p: FloatArray, v: FloatArray) -> BranchRates:
    """Return the rates along the tangent v (n + 1,) of a branch."""
    mechanism, turns = curve.mechanism, curve.turning(p, v).tolist()
    driven = curve.input_rates(p, v) * (abs(v[-1]) > BOUNDS.still)
    degree = float(np.degrees(1.0)) if mechanism.angle_unit == "deg" else 1.0
    inputs = {
        a.name: rate * (degree if a.rotary else mechanism.scale)
        for a, rate in zip(mechanism.actuators, driven.tolist(), strict=True)
    }
    dust = REST * max(map(abs, turns), default=0.0)  # rotations below this are rounding
    members = {
        member.name: degree * rate if abs(rate) > dust else 0.0
        for member, rate in zip(mechanism.members[FRAME + 1 :], turns, strict=True)
    }
    fast = np.array([0.0, *(inputs if any(inputs.values()) else members).values()])
    unit = float(fast[first_greatest(np.abs(fast))]) or 1.0
    return BranchRates({k: r / unit + 0.0 for k, r in inputs.items()}, {k: r / unit + 0.0 for k, r in members.items()})


class _SingularitySearch:
    """The search along one circuit."""

    def __init__(self, circuit: Circuit, number: int) -> None:
        self.circuit, self.curve, self.number = circuit, circuit.curve, number
        self.places = circuit.places
        self.fractions = circuit.lengths / max(float(circuit.lengths[-1]), 1e-300)

    def crossings(self) -> Iterator[Singularity]:
        """Yield the positions where the Jacobian with the input loses rank."""
        for index, crossing in self.circuit.crossings.items():
            if self.circuit.closed and index == len(self.places) - 1:
                continue
            about = _involved(self.curve, crossing.left)
            yield self._position(crossing.kind, index, self.places[index], about, crossing)

    def limits(self) -> Iterator[Singularity]:
        """Yield the positions in which the parameter reverses."""
        for index, here, side in reversals(self.circuit, attrgetter("rate")):
            yield self._position(LIMIT, index, here, self._held(here), end="upper" if side < 0.0 else "lower")

    def dead_points(self) -> Iterator[Singularity]:
        """Yield the positions in which the parameter rate is zero without reversal; one if it is zero everywhere."""
        speed = np.abs([here.rate for here in self.places])
        if np.all(speed <= BOUNDS.still):
            yield self._position(DEAD, 0, self.places[0], self._held(self.places[0]))
            return
        inner = np.arange(1, len(speed) - 1)
        low = inner[(speed[inner] <= speed[inner - 1]) & (speed[inner] < speed[inner + 1])]
        for k in low[speed[low] < BOUNDS.slow].tolist():
            ends = self.places[k - 1], self.places[k + 1]
            if np.sign(ends[0].rate) != np.sign(ends[1].rate) or k in self.circuit.crossings:
                continue
            found = between(self.curve, *ends, lambda at: float(bend(self.curve, at)[-1]), STEPS)
            if found is not None and abs(found.rate) <= BOUNDS.still:
                yield self._position(DEAD, k - 1, found, self._held(found))

    def stationary(self) -> Iterator[Singularity]:
        """Yield the positions in which members hinged to the frame, or sliders on it, reverse."""
        for name, rate in outputs(self.curve):
            for index, here, _ in reversals(self.circuit, rate):
                yield self._position(STATIONARY, index, here, (name,))

    def _position(
        self, kind: str, index: int, here: CurvePoint, about: tuple[str, ...], crossing: Crossing | None = None,
        end: str = ""
    ) -> Singularity:  # fmt: skip
        ahead = min(index + 1, len(self.places) - 1)
        part = np.linalg.norm(here.p - self.places[index].p)
        whole = max(float(np.linalg.norm(self.places[ahead].p - self.places[index].p)), 1e-300)
        fraction = float(
            self.fractions[index] + (self.fractions[ahead] - self.fractions[index]) * min(part / whole, 1.0)
        )
        branches = () if crossing is None else ordered(self.curve, crossing)
        loose = crossing is not None and crossing.loose
        return Singularity(kind, fraction, here.p, here.tangent, about, branches, end, self.number, loose)

    def _held(self, here: CurvePoint) -> tuple[str, ...]:
        """Return the constraints with a self-stress while the input is fixed."""
        return _involved(self.curve, _null_left(here.jacobian[:, :-1], here.left.shape[1]))


def reversals(circuit: Circuit, rate: Rate) -> Iterator[tuple[int, CurvePoint, float]]:
    """Yield the points at which a rate changes its sign: index of the point before, the point, and the sign after."""
    places = circuit.places
    values = np.array([rate(here) for here in places])
    moving = np.flatnonzero(np.abs(values) > REST).tolist()
    for i, j in pairwise(moving):
        if values[i] * values[j] < 0.0:
            resting = next((k for k in range(i + 1, j) if k in circuit.crossings), None)
            found = between(circuit.curve, places[i], places[j], rate, STEPS) if resting is None else places[resting]
            if found is not None:
                yield i if resting is None else resting, found, float(np.sign(values[j]))
    if circuit.closed and moving and moving[0] > 0 and values[moving[0]] * values[moving[-1]] < 0.0:
        yield 0, places[0], float(np.sign(values[moving[0]]))


def bend(curve: PositionCurve, here: CurvePoint) -> FloatArray:
    """Return the derivative of the tangent (n + 1,) by the arc length."""
    table = np.vstack([here.jacobian, here.tangent])
    wanted = np.append(-curve.jacobian_along(here.p, here.tangent) @ here.tangent, 0.0)
    return np.asarray(np.linalg.lstsq(table, wanted, rcond=None)[0])


def outputs(curve: PositionCurve) -> Iterator[tuple[str, Rate]]:
    """Yield name and rate of members hinged to the frame and sliders on it, except those driven by an input."""
    mechanism, column = curve.mechanism, {n: 2 * k for k, n in enumerate(curve.system.free)}
    frame = set(mechanism.members[FRAME].nodes)
    driven = {a.members[0] for a in mechanism.actuators if a.rotary and a.guide == FRAME}
    moved = {a.node for a in mechanism.actuators if a.kind == HEIGHT and a.guide == FRAME}
    for index, member in enumerate(mechanism.members[FRAME + 1 :], start=FRAME + 1):
        hinges, free = [n for n in member.nodes if n in frame], [n for n in member.nodes if n in column]
        if hinges and free and index not in driven:
            yield member.name, _turning(curve, hinges[0], free[-1], column[free[-1]])
    for slide in mechanism.slides:
        if slide.guide == FRAME and slide.node in column and slide.node not in moved:
            yield slide.pair, _sliding(column[slide.node], slide.along)


def _turning(curve: PositionCurve, hinge: int, node: int, at: int) -> Rate:
    def rate(here: CurvePoint) -> float:
        z = curve.nodes(here.p)
        return float(((z[node] - z[hinge]).conjugate() * complex(*here.tangent[at : at + 2])).imag)

    return rate


def _sliding(at: int, direction: complex) -> Rate:
    return lambda here: float((direction.conjugate() * complex(*here.tangent[at : at + 2])).real)


def _null_left(table: FloatArray, rank: int) -> FloatArray:
    """Return the left null vectors (m, r), r >= 1, of which positions of full `rank` have none."""
    left, values, _ = np.linalg.svd(table)
    lost = max(1, int(np.sum(values[:rank] <= BRANCHING.lost * values[0])))
    return np.asarray(left[:, rank - lost : rank])


def _involved(curve: PositionCurve, left: FloatArray) -> tuple[str, ...]:
    """Return the names of the constraints with significant entries in left null vectors (m, r)."""
    weight = np.linalg.norm(left, axis=1)
    chosen = weight > BOUNDS.share * float(weight.max(initial=1e-300))
    return tuple(dict.fromkeys(name for name, own in zip(curve.system.names, chosen, strict=True) if own))


SINGULAR = "singular"
"""Kind of a position at which the curve has no unique direction, or that is not on the curve."""

TANGENT = "tangent"
"""Kind of a position that is a double root of the equations, as those near it."""


def singular_start(mechanism: Mechanism, z: ComplexArray) -> str:
    """Return the kind (limit, change point, ...) of an assembled position z (nodes,) that inputs do not determine."""
    curve, inputs = PositionCurve(mechanism), mechanism.drawn_inputs
    if tangent_position(mechanism, z, inputs, TOLERANCE) is not None:
        return TANGENT
    q = float(inputs[curve.main]) if curve.single else curve.begin()
    if not np.allclose(curve.given(q), inputs, rtol=0.0, atol=1e-9):
        return SINGULAR  # the laws of several inputs begin at other values
    try:
        left = departure(curve, z, q)
    except GimError:
        return SINGULAR
    if left.met is not None:
        return left.met.kind
    return LIMIT if left.limit else SINGULAR
