"""The curve of a motion: positions x and one parameter q, F(x, u(q)) = 0.

If the inputs are on a straight line (a single input always is), q is the parameter of the line: the value of the input
that changes most, or of the one that all others follow. Such a curve has no end; but if several inputs change and one
is rotary, it may never close, and is followed for some turns only, unless the ratios are fractions of small numbers.
Otherwise q is the time of the laws, scaled by the length of the path of the inputs. Then the curve extends beyond the
ends of the laws if these are linear, else it ends there. Inputs that follow the linkage are not functions of q: they
are unknowns in x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.continuation.released import ReleasedPositions
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.positions.inputs import (
    InputLine,
    driven,
    input_line,
    law_inputs,
    law_times,
    leading,
    turns_until_repeated,
)
from gimcli.structure.carried import turn_rates

EVEN = 1e-9
"""Second derivative of a law, relative to its total change, below which the law is linear."""

TURNS = 4
"""Number of turns beyond both ends of its law for which one of several inputs is followed."""

LONGEST = 100
"""Greatest number of turns of an input after which those that follow it are the same again: a longer curve is cut."""


@dataclass(frozen=True)
class Domain:
    """The range of the parameter."""

    low: float = -math.inf
    high: float = math.inf
    ends: bool = True  # whether the curve itself ends there; else it is only not followed further


class PositionCurve(ReleasedPositions):
    """Positions and parameter p = (x, q) (n + 1,) of a mechanism, as the solutions of m >= n equations.

    line: the straight line of the inputs; None: that of their laws.
    """

    def __init__(self, mechanism: Mechanism, line: InputLine | None = None) -> None:
        self.driven, self.rotary = driven(mechanism), np.array([a.rotary for a in mechanism.actuators])
        self.single = leading(self.driven) is not None and (line is None or not mechanism.couplings)
        self.line = line or input_line(self.driven)
        still = np.zeros(len(self.rotary))
        base, along = (still, still) if self.line is None else (self.line.base, self.line.along)
        super().__init__(mechanism, base, along[:, None])
        self.span, self.domain = 1.0, Domain()
        if self.line is None:
            self._stretch()
        elif self.rotary.any() and not (self.single and self.periodic):
            self._bound(self.line)

    @property
    def main(self) -> int:
        """Number of the actuator whose input is the parameter; 0 if the parameter is the time."""
        return 0 if self.line is None else self.line.main

    @cached_property
    def period(self) -> float:
        """Change of the parameter after which all inputs are the same, up to full turns; infinite if there is none."""
        if self.line is None or np.any(self.line.along[~self.rotary] != 0.0):
            return math.inf
        if not (self.single and self.mechanism.couplings):
            return 2.0 * math.pi
        turns = turns_until_repeated(self.driven)
        return math.inf if turns is None or turns > LONGEST else 2.0 * math.pi * turns

    @property
    def periodic(self) -> bool:
        """Whether all inputs are the same again after some turns of the input that is the parameter."""
        return math.isfinite(self.period)

    def _bound(self, line: InputLine) -> None:
        fastest = float(np.max(np.abs(line.along[self.rotary])))
        if fastest > 0.0:
            (low, high), beyond = self.laws, TURNS * 2.0 * math.pi / fastest
            self.domain = Domain(low - beyond, high + beyond, ends=False)

    def _stretch(self) -> None:
        values = law_inputs(self.driven)(law_times(self.driven))
        length = float(np.linalg.norm(np.abs(np.diff(values, axis=1)).sum(axis=1)))
        self.span = length if length > 0.0 else 1.0
        time = np.linspace(0.0, 1.0, 65)
        bent = max((float(np.max(np.abs(a.law(time, 2)))) for a in self.driven.actuators), default=0.0)
        if bent > EVEN * self.span:
            self.domain = Domain(0.0, self.span)

    def at_time(self, time: FloatArray) -> FloatArray:
        """Return the parameters (rows,) at times 0..1 of the laws."""
        return time * self.span if self.line is None else self.driven.actuators[self.main].law(time)

    def begin(self) -> float:
        """Return the parameter at the start of the laws."""
        return float(self.at_time(np.zeros(1))[0])

    @property
    def laws(self) -> tuple[float, float]:
        """The least and greatest parameter of the laws."""
        if self.line is None:
            return 0.0, self.span
        values = self.driven.actuators[self.line.main].law(law_times(self.driven))
        return float(values.min()), float(values.max())

    def forward(self) -> float:
        """Return the sense of the parameter, 1 or -1, at the start of the laws."""
        if self.line is None:
            return 1.0
        values = self.driven.actuators[self.line.main].law(law_times(self.driven))
        moved = values[np.abs(values - values[0]) > 0.0]
        return -1.0 if len(moved) and moved[0] < values[0] else 1.0

    def given(self, q: FloatArray | float) -> FloatArray:
        """Return the inputs (..., actuators) at q (..., 1); those that follow the linkage are not determined by it."""
        return super().given(q) if self.line is not None else self._by_laws(q, 0)

    def rates(self, q: FloatArray | float) -> FloatArray:
        """Return the derivatives of the inputs (actuators, 1), or (..., actuators, 1), at q (..., 1)."""
        return self.along if self.line is not None else self._by_laws(q, 1)[..., None]

    def apart(self, p: FloatArray, other: FloatArray) -> FloatArray:
        """Return p minus another point in coordinates and inputs (coordinates + actuators,), angles modulo 2 pi."""
        change, turn = self.inputs(p) - self.inputs(other), 2.0 * math.pi
        change = np.where(self.rotary, (change + math.pi) % turn - math.pi, change)
        return np.concatenate([(p - other)[: self.system.coordinated], change])

    def turning(self, p: FloatArray, v: FloatArray) -> FloatArray:
        """Return the rotations (moving members,) [rad] per unit of a direction v (n + 1,)."""
        rates = self.system.placed(np.zeros(len(self.mechanism.nodes), dtype=complex), v[:-1])
        return turn_rates(self.mechanism, self.nodes(p), rates)

    def jacobian_along(self, p: FloatArray, v: FloatArray) -> FloatArray:
        """Return the derivative of the Jacobian (m, n + 1) along v (n + 1,)."""
        x, q = p[:-1], p[-1:]
        u = self.given(q)
        table = self._along(self.system.jacobian_along(x, u, np.concatenate([v[:-1], self.rates(q) @ v[-1:]])), q)
        if self.line is None:
            table[:, -1] += v[-1] * self.system.along_inputs(x, u, self._by_laws(q, 2))
        return table

    def third(self, p: FloatArray, v: FloatArray) -> FloatArray:
        """Return the third derivative of the equations (m,) along v (n + 1,), taken three times."""
        x, q = p[:-1], p[-1:]
        u, along = self.given(q), np.concatenate([v[:-1], self.rates(q) @ v[-1:]])
        found = self.system.third(x, u, along)
        if self.line is not None:
            return found
        second, third = (v[-1] ** k * self._by_laws(q, k) for k in (2, 3))
        mixed = self.system.second(x, u, along, np.concatenate([np.zeros(self.system.n), second]))
        return np.asarray(found + 3.0 * mixed + self.system.along_inputs(x, u, third))

    def _by_laws(self, q: float | FloatArray, order: int) -> FloatArray:
        """Return the inputs (..., actuators) under the laws, or their derivatives of an order, at q (..., 1)."""
        time = np.atleast_1d(q) / self.span
        rows = time.ravel() if order == 0 else np.clip(time.ravel(), 0.0, 1.0)
        each = [a.law(rows, order) for a in self.driven.actuators]
        found = np.array(each) / self.span**order if order else law_inputs(self.driven)(rows)
        return np.ascontiguousarray(found.T).reshape(*time.shape[:-1], -1)
