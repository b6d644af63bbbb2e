"""Derivatives along the path of a motion that do not depend on its speed.

A path is a curve in the space of the inputs. Its parameter is the input itself if there is only one, otherwise the
normalised time scaled so that the inputs move at speed 1. Where the laws are at rest, the direction is that of their
first nonzero derivative, so that instant centres and curvatures exist there too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.rates.derivatives import MotionRates, rates, rates_of_inputs
from gimcli.rates.member_angles import Angles, in_rows


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
    angles: Angles = in_rows
    given: FloatArray | None = None  # derivatives of the inputs that replace those of the laws

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism of the motion."""
        return self.motion.mechanism

    def angle(self, member: int) -> FloatArray:
        """Return the direction of a member (rows,) in the file's angle unit, full turns counted."""
        return self.angles(self.motion, member)

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
        if self.given is not None:
            return rates_of_inputs(self.mechanism, self.motion.z, self.given[:3])
        return rates(self.mechanism, self.motion.time, self.motion.z, 2)

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
