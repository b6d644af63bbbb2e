"""Derivatives along the path of a motion that do not depend on its speed.

A path is a curve in the space of the inputs. Its parameter is the input itself if there is only one, otherwise the
normalised time scaled so that the inputs move at speed 1. Where the laws are at rest, the direction is that of their
first nonzero derivative, so that instant centres and curvatures exist there too.

Those along a circuit are by its arc length: at a limit of the input, derivatives by the input are infinite. Along the
curve G(p) = 0 of positions and parameter, with its unit tangent t:

    G' t = 0,    G' t' = -G''[t, t],    G' t'' = -3 G''[t, t'] - G'''[t, t, t]

with t.t' = 0 and t.t'' = -t'.t'. Source: Allgower & Georg, Introduction to Numerical Continuation Methods, 2003,
chapter 2, differentiated twice more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.continuation.arclength import correct, place
from gimcli.continuation.circuit import CIRCUIT, STEPS
from gimcli.continuation.curve import PositionCurve
from gimcli.mechanism import FRAME, BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.rates.derivatives import MotionRates, law_rates, rates_of_inputs


@dataclass(frozen=True)
class Stillness:
    """Limits for laws at rest."""

    still: float = 1e-6  # derivative, relative to the next ones, that counts as 0: greater than rounding of polynomials
    aligned: float = 1e-9  # sine of the angle below which two derivatives are parallel
    orders: int = 3  # number of derivatives of a law


STILLNESS = Stillness()


@dataclass(frozen=True)
class InputPath:
    """First and second derivative of the inputs by a parameter of their path."""

    first: FloatArray  # (actuators, rows)
    second: FloatArray  # (actuators, rows)
    smooth: BoolArray  # (rows,) whether the second derivative belongs to a regular parameter


def input_path(mechanism: Mechanism, time: FloatArray, given: FloatArray | None = None) -> InputPath:
    """Return the path of the inputs at normalised times, in the direction of the motion.

    `given` are the inputs and their derivatives by the real time (orders, actuators, rows), if not those of the laws.
    """
    if given is None:
        laws = [np.array([a.law(time, k) for a in mechanism.actuators]) for k in range(1, STILLNESS.orders + 1)]
    else:
        laws = [rates * mechanism.duration**k for k, rates in enumerate(given[1:], start=1)]
    length = [np.linalg.norm(law, axis=0) for law in laws]
    order = _first_order(length)
    first, second, smooth = np.zeros_like(laws[0]), np.zeros_like(laws[0]), np.ones(len(time), dtype=bool)
    for k, law in enumerate(laws):
        rows = order == k
        sense = np.where((time[rows] == 1.0) & (k % 2 == 1), -1.0, 1.0)  # at the end, even derivatives point backwards
        first[:, rows] = sense * law[:, rows] / length[k][rows]
        if k == 0:
            second[:, rows] = laws[1][:, rows] / length[0][rows] ** 2
        elif k + 1 < len(laws):
            smooth[rows] = _aligned(law[:, rows], laws[k + 1][:, rows])
    if len(mechanism.actuators) == 1:
        first[first == 0.0] = 1.0
        return InputPath(first, np.zeros_like(second), np.ones_like(smooth))
    return InputPath(first, second, smooth)


def _first_order(length: Sequence[FloatArray]) -> IntArray:
    """Return for every row the order of the first nonzero derivative; -1 if all are 0."""
    order = np.full(length[0].shape, -1)
    for k in range(len(length) - 1, -1, -1):
        rest = np.max(np.array(length[k:]), axis=0)
        order[(length[k] > STILLNESS.still * rest) & (length[k] > 0.0)] = k
    return order


def _aligned(a: FloatArray, b: FloatArray) -> BoolArray:
    """Return for every row whether two vectors are parallel."""
    product = np.sum(a * b, axis=0) ** 2
    squares = np.sum(a * a, axis=0) * np.sum(b * b, axis=0)
    return np.asarray(squares - product <= STILLNESS.aligned**2 * squares)


def rates_along(
    mechanism: Mechanism, inputs: FloatArray, z: ComplexArray, first: FloatArray, second: FloatArray, order: int
) -> MotionRates:
    """Differentiate positions z (nodes, rows) for given derivatives of the inputs, each (actuators, rows)."""
    given = np.array([inputs, first, second, np.zeros_like(first)])[: order + 1]
    return rates_of_inputs(mechanism, z, given)


@dataclass(frozen=True, eq=False)
class PathDerivatives:
    """A motion, or a piece of one, and its derivatives, which are computed on first use."""

    motion: Motion
    given: FloatArray | None = None  # derivatives of the inputs that replace those of the laws

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism of the motion."""
        return self.motion.mechanism

    @cached_property
    def path(self) -> InputPath:
        """The path of the inputs."""
        return input_path(self.mechanism, self.motion.time, self.given)

    @property
    def smooth(self) -> BoolArray:
        """Return for every row whether its second derivatives belong to a regular parameter."""
        return self.path.smooth

    @property
    def clock(self) -> FloatArray:
        """The time of every row (rows,) [s], the variable of `timed`."""
        return self.motion.time * self.mechanism.duration

    @cached_property
    def along(self) -> MotionRates:
        """First and second derivatives by the path's parameter."""
        return self.along_to(2)

    @cached_property
    def timed(self) -> MotionRates:
        """Velocities and accelerations by the real time."""
        given = law_rates(self.mechanism, self.motion.time, 2) if self.given is None else self.given[:3]
        return rates_of_inputs(self.mechanism, self.motion.z, given)

    def along_to(self, order: int, rows: IntArray | slice = slice(None)) -> MotionRates:
        """Return derivatives of some rows by the path's parameter, up to an order of at most 3."""
        motion, path = self.motion, self.path
        return rates_along(
            self.mechanism, motion.inputs[:, rows], motion.z[:, rows], path.first[:, rows], path.second[:, rows], order
        )

    def beside(self, rows: IntArray, step: float) -> MotionRates:
        """Return first and second derivatives at a short step of the parameter from some rows.

        The positions there are computed from three derivatives; their error is of fourth order in the step.
        """
        motion, path = self.motion, self.path
        series = self.along_to(3, rows).nodes
        z = np.asarray(sum(series[k] * step**k / math.factorial(k) for k in range(4)))
        first = path.first[:, rows] + step * path.second[:, rows]
        inputs = motion.inputs[:, rows] + step * path.first[:, rows] + step**2 / 2.0 * path.second[:, rows]
        return rates_along(self.mechanism, inputs, z, first, path.second[:, rows], 2)

    def of_input(self, actuator: int) -> MotionRates:
        """Return first derivatives by one input, the others constant."""
        first = np.zeros_like(self.motion.inputs)
        first[actuator] = 1.0
        return rates_along(self.mechanism, self.motion.inputs, self.motion.z, first, np.zeros_like(first), 1)


ROUNDS = 3
"""Iterations for the length between two rows; each adds two orders of accuracy."""


@dataclass(frozen=True, eq=False)
class ArclengthDerivatives(PathDerivatives):
    """A motion along a curve of positions and inputs, and its derivatives by the arc length of the curve.

    Second and third derivatives are NaN at intersections of branches and in rows in which the motion reverses.
    """

    @cached_property
    def curve(self) -> PositionCurve:
        """The curve of positions and parameter."""
        return PositionCurve(self.mechanism)

    @property
    def smooth(self) -> BoolArray:
        """Return for every row whether its second derivatives belong to a regular parameter (always true)."""
        return np.ones(len(self.motion.time), dtype=bool)

    @property
    def timed(self) -> MotionRates:
        """First and second derivatives by the `clock`, which is the arc length."""
        return self.along

    @cached_property
    def clock(self) -> FloatArray:
        """Arc length up to every row (rows,), accurate to fourth order, from tangents and curvatures of the rows."""
        t, bend = self._series[1], self._series[2]
        chord = np.diff(self._series[0])
        middle, change = 0.5 * (t[:, 1:] + t[:, :-1]), bend[:, 1:] - bend[:, :-1]
        h = np.linalg.norm(chord, axis=0)
        for _ in range(ROUNDS):
            h = np.sum((chord + h**2 / 12.0 * change) * middle, axis=0) / np.sum(middle**2, axis=0)
        plain = np.linalg.norm(chord, axis=0)
        h = np.where(np.isfinite(h), h, np.where(np.isfinite(plain), plain, 1.0))
        return np.concatenate([[0.0], np.cumsum(h)])

    def along_to(self, order: int, rows: IntArray | slice = slice(None)) -> MotionRates:
        """Return derivatives of some rows by the arc length, up to an order of at most 3."""
        return self._rates(self._series[: order + 1, :, rows], self.motion.z[:, rows])

    def beside(self, rows: IntArray, step: float) -> MotionRates:
        """Return first and second derivatives at a short distance (arc length) from some rows."""
        series = self._series[:, :, rows]
        found = np.full((3, *series.shape[1:]), np.nan)
        for k, near in enumerate(np.moveaxis(series, 2, 0)):
            guess = np.asarray(sum(near[i] * step**i / math.factorial(i) for i in range(4)))
            exact = correct(self.curve, guess, STEPS, near[1]) if np.all(np.isfinite(guess)) else None
            if exact is not None:
                found[:, :, k] = _derivatives(self.curve, exact, near[1])[:3]
        return self._rates(found, self.curve.nodes(found[0]))

    @cached_property
    def _series(self) -> FloatArray:
        """Position and parameter with three derivatives by the arc length (4, n + 1, rows)."""
        assert self.motion.parameter is not None
        places = [self.curve.point(z, q) for z, q in zip(self.motion.z.T, self.motion.parameter.tolist(), strict=True)]
        p = np.array(places).T
        along = headings(self.motion, p)
        series = [_derivatives(self.curve, p[:, k], along[:, k]) for k in range(p.shape[1])]
        return np.moveaxis(np.array(series), 0, 2)

    def _rates(self, series: FloatArray, z: ComplexArray) -> MotionRates:
        """Return the rates of nodes and members from derivatives (order + 1, n + 1, rows)."""
        nodes = np.zeros((len(series), *z.shape), dtype=complex)
        nodes[0] = z
        nodes[1:] = [self.curve.system.placed(order, x) for order, x in zip(nodes[1:], series[1:, :-1], strict=True)]
        nodes[1:] = np.where(np.isfinite(series[1:, :1]), nodes[1:], complex(np.nan, np.nan))
        members = self.mechanism.members[FRAME + 1 :]
        turns = [_turning(nodes[:, m.ends[1]] - nodes[:, m.ends[0]]) for m in members]
        return MotionRates(self.mechanism, len(series) - 1, nodes, np.moveaxis(np.array(turns), 0, 1))


def headings(motion: Motion, p: FloatArray) -> FloatArray:
    """Return the direction (n + 1, rows) of a motion at its positions p; NaN where it reverses.

    If the motion has no directions, they are taken from the differences of its rows.
    """
    if motion.headings is not None:
        return motion.headings
    steps = np.diff(p, axis=1)
    none = np.full((len(p), 1), np.nan)
    ahead, behind = np.hstack([steps, none]), np.hstack([none, steps])
    back = np.sum(ahead * behind, axis=0) < 0.0
    heading = np.where(np.isfinite(ahead), ahead, 0.0) + np.where(np.isfinite(behind), behind, 0.0)
    return np.where(back | ~np.any(heading, axis=0), np.nan, heading)


def _derivatives(curve: PositionCurve, p: FloatArray, heading: FloatArray) -> FloatArray:
    """Return a position with three derivatives by the arc length (4, n + 1), oriented along a direction."""
    found = np.full((4, len(p)), np.nan)
    found[0] = p
    if not (np.all(np.isfinite(p)) and np.all(np.isfinite(heading))):
        return found
    here = place(curve, p, heading)
    if here.regular <= CIRCUIT.singular:
        found[1] = heading / np.linalg.norm(heading)
        return found
    t = here.tangent
    table = np.vstack([here.jacobian, t])
    second = curve.jacobian_along(p, t)
    bend = np.linalg.lstsq(table, np.append(-second @ t, 0.0), rcond=None)[0]
    third = -3.0 * second @ bend - curve.third(p, t)
    found[1:] = t, bend, np.linalg.lstsq(table, np.append(third, -bend @ bend), rcond=None)[0]
    return found


def _turning(arm: ComplexArray) -> FloatArray:
    """Return the derivatives (order, rows) of the angle of a vector of constant length (order + 1, rows)."""
    with np.errstate(all="ignore"):
        turn = (arm[1:] / arm[:1]).imag
    if len(turn) > 2:  # (e^if)''' = (if''' - 3 f'f'' - if'^3) e^if
        turn[2] += turn[0] ** 3
    return np.asarray(turn)
