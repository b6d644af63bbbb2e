"""The curve of a motion: positions x and one parameter, F(x, u(q)) = 0.

One actuator: the parameter q is its value. Several actuators follow their laws together: q is the laws' time,
stretched so that a step of it is about as long as the way of the inputs. Laws that run evenly go on beyond their
ends; at the ends of others the curve ends.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import ComplexArray, Drive, FloatArray, Mechanism
from gimcli.motion.inputs import law_inputs
from gimcli.structure.system import System

SAMPLES = 65
"""Times at which the laws are looked at."""

EVEN = 1e-9
"""Second derivative of a law, over its way, below which it runs evenly."""


@dataclass(frozen=True)
class Domain:
    """Where the parameter may be."""

    low: float = -math.inf
    high: float = math.inf


class Curve:
    """Positions and parameter p = (x, q) (n + 1,) of a mechanism as the solutions of m >= n equations."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.system = mechanism, System(mechanism)
        self.rotary = np.array([a.drive is Drive.ROTARY for a in mechanism.actuators])
        self.single = len(mechanism.actuators) == 1
        self.span, self.domain = 1.0, Domain()
        if not self.single:
            self._stretch()

    def _stretch(self) -> None:
        time = np.linspace(0.0, 1.0, SAMPLES)
        values = law_inputs(self.mechanism)(time)
        way = float(np.linalg.norm(np.abs(np.diff(values, axis=1)).sum(axis=1)))
        self.span = way if way > 0.0 else 1.0
        bent = max(float(np.max(np.abs(a.law(time, 2)))) for a in self.mechanism.actuators)
        if bent > EVEN * self.span:
            self.domain = Domain(0.0, self.span)

    @property
    def names(self) -> tuple[str, ...]:
        """The constraint that each equation is of."""
        return self.system.names

    def point(self, z: ComplexArray, q: float) -> FloatArray:
        """Return p of positions z (nodes,)."""
        return np.append(self.system.coordinates(z), q)

    def nodes(self, p: FloatArray) -> ComplexArray:
        """Return positions (nodes,) of p (n + 1,), or (nodes, rows) of p (n + 1, rows)."""
        return self.system.nodes(p[:-1])

    def begin(self) -> float:
        """Return the parameter at the start of the laws."""
        return float(self.mechanism.actuators[0].law(np.zeros(1))[0]) if self.single else 0.0

    def forward(self) -> float:
        """Return the sense of the parameter, 1 or -1, in which the laws set out."""
        if not self.single:
            return 1.0
        values = self.mechanism.actuators[0].law(np.linspace(0.0, 1.0, SAMPLES))
        moved = values[np.abs(values - values[0]) > 0.0]
        return -1.0 if len(moved) and moved[0] < values[0] else 1.0

    def inputs(self, q: float) -> FloatArray:
        """Return the inputs (actuators,) at a parameter."""
        return self._inputs(q, 0)

    def travel(self, v: FloatArray, q: float) -> FloatArray:
        """Return a direction v (n + 1,) in coordinates and inputs (n + actuators,)."""
        return np.concatenate([v[:-1], v[-1] * self._inputs(q, 1)])

    def apart(self, p: FloatArray, home: FloatArray) -> FloatArray:
        """Return how far p is from another place in coordinates and inputs (n + actuators,), turns not counted."""
        way = self.inputs(float(p[-1])) - self.inputs(float(home[-1]))
        turn = 2.0 * math.pi
        way = np.where(self.rotary, (way + math.pi) % turn - math.pi, way)
        return np.concatenate([p[:-1] - home[:-1], way])

    def residual(self, p: FloatArray) -> FloatArray:
        """Return the equations (m,) at p (n + 1,)."""
        return self.system.residual(p[:-1], self.inputs(float(p[-1])))

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return their derivatives (m, n + 1)."""
        x, u = p[:-1], self.inputs(float(p[-1]))
        column = self.system.by_inputs(x, u) @ self._inputs(float(p[-1]), 1)
        return np.hstack([self.system.jacobian(x, u), column[:, None]])

    def jacobian_along(self, p: FloatArray, v: FloatArray) -> FloatArray:
        """Return the derivative of the Jacobian (m, n + 1) along v (n + 1,)."""
        x, q, n = p[:-1], float(p[-1]), len(p) - 1
        u, rate = self.inputs(q), self._inputs(q, 1)
        table = self.system.jacobian_along(x, u, np.concatenate([v[:-1], v[-1] * rate]))
        column = table[:, n:] @ rate
        if not self.single:
            column = column + v[-1] * self.system.by_inputs(x, u) @ self._inputs(q, 2)
        return np.hstack([table[:, :n], column[:, None]])

    def third(self, p: FloatArray, v: FloatArray) -> FloatArray:
        """Return the third derivative of the equations (m,) along v (n + 1,), taken three times."""
        x, q, n = p[:-1], float(p[-1]), self.system.n
        u, rest = self.inputs(q), np.zeros(n)
        way, bend, twist = (v[-1] ** k * self._inputs(q, k) for k in (1, 2, 3))
        along = np.concatenate([v[:-1], way])
        found = self.system.third(x, u, along)
        if self.single:
            return found
        mixed = self.system.second(x, u, along, np.concatenate([rest, bend]))
        return np.asarray(found + 3.0 * mixed + self.system.by_inputs(x, u) @ twist)

    def _inputs(self, q: float, order: int) -> FloatArray:
        """Return the inputs, or their derivatives by the parameter."""
        if self.single:
            return np.array([(q, 1.0, 0.0, 0.0)[order]])
        time = np.array([q / self.span])
        inside = np.clip(time, 0.0, 1.0)
        values = []
        for actuator in self.mechanism.actuators:
            slope = actuator.law(inside, 1)
            value = actuator.law(inside) + (time - inside) * slope
            straight = (value, slope, actuator.law(inside, 2), actuator.law(inside, 3))[order]
            values.append(float(straight[0]) / self.span**order)
        return np.array(values)
