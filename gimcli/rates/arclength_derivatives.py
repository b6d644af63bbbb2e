"""Derivatives along a circuit by its arc length; at a limit of the input, derivatives by the input are infinite.

Along the curve G(p) = 0 of positions and parameter, with its unit tangent t:

    G' t = 0,    G' t' = -G''[t, t],    G' t'' = -3 G''[t, t'] - G'''[t, t, t]

with t.t' = 0 and t.t'' = -t'.t'. Source: Allgower & Georg, Introduction to Numerical Continuation Methods, 2003,
chapter 2, differentiated twice more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.continuation.arclength import correct, place
from gimcli.continuation.circuit import CIRCUIT, STEPS
from gimcli.continuation.curve import PositionCurve
from gimcli.mechanism import FRAME, BoolArray, ComplexArray, FloatArray, IntArray
from gimcli.motion.motion import Motion
from gimcli.rates.derivatives import MotionRates
from gimcli.rates.path_derivatives import PathDerivatives

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

    @cached_property
    def along(self) -> MotionRates:
        """First and second derivatives by the arc length."""
        return self.along_to(2)

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
