"""Derivatives of generalised forces by the coordinates and their rates: stiffness and damping matrix.

    K_ij = -sum of F.B_ij + dF/ds_j.B_i + T w_ij,   C_ij = sum of c R_i R_j

B_i, B_ij: first and second influence coefficients of the point where a force F acts; w_ij: those of the direction of a
member on which a torque T acts; R_i: those of the quantity that a damper measures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.dynamic_data import TIME, AppliedLoad, DrivingEffort, LoadCurve
from gimcli.kernels.reduction import Acting
from gimcli.mechanism import ANGLE, SPAN, ComplexArray, FloatArray
from gimcli.structure.steps import NONE

LEVER = 1e-3
"""Least lever of a force in its scale, relative to the greatest of all nodes; without a lever a force is balanced."""


@dataclass(frozen=True)
class InfluenceCoefficients:
    """First and second influence coefficients at a position, k coordinates."""

    v: FloatArray  # (variables,) x and y of nodes, readings, 1
    first: int  # the variable that is the first reading
    z: ComplexArray  # (nodes,)
    b: ComplexArray  # (k, nodes)
    bb: ComplexArray  # (k, k, nodes)
    r: FloatArray  # (k, readings)
    rr: FloatArray  # (k, k, readings)


class ForceSlopes:
    """Stiffness and damping of all forces at a position at rest, with the scales that rounding is relative to."""

    def __init__(
        self, acting: Acting, loads: Sequence[AppliedLoad], efforts: Sequence[DrivingEffort], released: Sequence[int],
        size: float, near: Sequence[int], time: float,
    ) -> None:  # fmt: skip
        """near: the nodes that are not remote."""
        self.acting, self.loads, self.efforts, self.released = acting, loads, efforts, released
        self.size, self.near, self.time = size, list(near), time

    def at(self, place: InfluenceCoefficients) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return stiffness (k, k), its scale, the scale of the forces (k,), and damping (k, k)."""
        k = len(place.b)
        self.total, self.rough, self.scale = np.zeros((k, k)), np.zeros((k, k)), np.zeros(k)
        self.least = LEVER * np.max(np.abs(place.b[:, self.near]), axis=1)
        self._add_weights(place)
        self._add_loads(place)
        self._add_springs(place)
        self._add_efforts(place)
        return -self.total, self.rough, self.scale, self._damping(place)

    def factor(self, load: AppliedLoad, place: InfluenceCoefficients) -> float:
        """Return the factor by which the table of a load multiplies it."""
        at = self.time if load.over == TIME else place.v[place.first + load.over]
        return 1.0 if load.curve is None else value_of(load.curve, at)

    def effort(self, number: int, place: InfluenceCoefficients) -> float:
        """Return the driving effort at rest of a released input."""
        effort = self.efforts[number]
        return effort.constant if effort.curve is None else value_of(effort.curve, self._argument(number, place))

    def _argument(self, number: int, place: InfluenceCoefficients) -> float:
        value = float(place.v[place.first + self.released[number]])
        return {"time": self.time, "value": value, "speed": 0.0}[self.efforts[number].over]

    def _add(self, slopes: FloatArray, scale: FloatArray, bend: FloatArray) -> None:
        """Add the derivatives of a force (k, k), its scale (k,), and the scale of its derivatives (k, k)."""
        self.total += slopes
        self.rough += np.abs(slopes) + bend
        self.scale += scale

    def _lever(self, rates: FloatArray | ComplexArray, turns: bool = False) -> FloatArray:
        """Return the magnitudes of rates (k,) of a place, or of a rotation, at least those of the least lever."""
        return np.asarray(np.maximum(np.abs(rates), self.least / (self.size if turns else 1.0)))

    def _add_weights(self, at: InfluenceCoefficients) -> None:
        p, size = self.acting, self.size
        gravity = complex(*p.gravity) * p.metre
        for (u, v), (x, y, mass, *_) in zip(p.masses, p.mass, strict=True):
            lever = self._lever(carried(at.b, u, v, complex(x, y)))
            slopes = mass * (np.conj(gravity) * carried(at.bb, u, v, complex(x, y))).real
            self._add(slopes, mass * abs(gravity) * lever, mass * abs(gravity) / size * _outer(lever))

    def _add_loads(self, at: InfluenceCoefficients) -> None:
        p, size = self.acting, self.size
        for load, (u, v, follows), (x, y, fx, fy, torque, square) in zip(self.loads, p.loads, p.load, strict=True):
            arm, point = at.z[v] - at.z[u], complex(x, y)
            force = complex(fx, fy) * p.metre * (arm if follows else 1.0)
            rates, turns = carried(at.b, u, v, point), turned(arm, at.b, u, v, square)
            along = (np.conj(force) * rates).real + torque * turns
            slopes = (np.conj(force) * carried(at.bb, u, v, point)).real + torque * turned(arm, at.bb, u, v, square)
            if follows:
                slopes = slopes + (np.conj(1j * force) * rates).real[:, None] * turns
            factor = self.factor(load, at)
            slopes = factor * slopes
            if load.curve is not None and load.over != TIME:
                value = at.v[at.first + load.over]
                slopes = slopes + load.curve.slope(value) * along[:, None] * at.r[:, load.over]
            far, twist = abs(factor * force) * self._lever(rates), abs(factor * torque) * self._lever(turns, True)
            bend = abs(factor * force) / size * _outer(np.abs(rates)) + abs(factor * torque) * _outer(np.abs(turns))
            self._add(slopes, far + twist, bend)

    def _add_springs(self, at: InfluenceCoefficients) -> None:
        p = self.acting
        for (variable, kind), (stiffness, free) in zip(p.springs, p.spring, strict=True):
            rates, bends, value = at.r[:, variable - at.first], at.rr[..., variable - at.first], at.v[variable]
            stretch = value + free if kind == SPAN and value < 0.0 else value - free
            factor = stiffness * (1.0 if kind == ANGLE else p.metre**2)
            own, other, lever = factor * _outer(rates), factor * stretch * bends, self._lever(rates, kind == ANGLE)
            self._add(-own - other, factor * (abs(value) + abs(free)) * lever, np.abs(own) + np.abs(other))

    def _add_efforts(self, at: InfluenceCoefficients) -> None:
        """Add the driving efforts, which can depend on the value of their own inputs."""
        p = self.acting
        for k, (actuator, effort) in enumerate(zip(self.released, self.efforts, strict=True)):
            unit, size = (1.0, 1.0) if p.motors[k, 1] else (p.metre, self.size)
            now = unit * self.effort(k, at)
            rates, slopes = at.r[:, actuator], now * at.rr[..., actuator]
            if effort.curve is not None and effort.over == "value":
                slopes = slopes + effort.curve.slope(self._argument(k, at)) * unit * _outer(rates)
            self._add(
                slopes, abs(now) * self._lever(rates, bool(p.motors[k, 1])), abs(now) / size * _outer(np.abs(rates))
            )

    def _damping(self, at: InfluenceCoefficients) -> FloatArray:
        """Return the matrix of dampers, viscous friction, and driving efforts that depend on the speed."""
        p = self.acting
        total = np.zeros((len(at.b), len(at.b)))
        for (variable, angle), damping in zip(p.dampers, p.damper, strict=True):
            rates = at.r[:, variable - at.first] * (1.0 if angle else p.metre)
            total += damping * _outer(rates)
        for (u, v, m, n), (damping, one, other) in zip(p.rubs, p.rub, strict=True):
            rates = self._turning(at, u, v, one) - self._turning(at, m, n, other)
            total += damping * _outer(rates)
        for actuator, effort, (_, angle) in zip(self.released, self.efforts, p.motors, strict=True):
            unit, rates = 1.0 if angle else p.metre, at.r[:, actuator]
            slope = effort.curve.slope(0.0) if effort.curve is not None and effort.over == "speed" else 0.0
            if effort.idle:
                slope -= effort.constant / effort.idle
            total -= slope * unit * _outer(rates)
        return total

    def _turning(self, at: InfluenceCoefficients, u: int, v: int, square: float) -> FloatArray:
        return np.zeros(len(at.b)) if u == NONE else turned(at.z[v] - at.z[u], at.b, u, v, square)


def carried(x: ComplexArray, u: int, v: int, z: complex) -> ComplexArray:
    """Return the derivatives of the point u + z (v - u) from those of the nodes (..., nodes)."""
    return np.asarray(x[..., u] + z * (x[..., v] - x[..., u]))


def turned(arm: complex, x: ComplexArray, u: int, v: int, square: float) -> FloatArray:
    """Return the derivatives of the direction of an arm from those of the nodes (..., nodes), first or second."""
    return np.asarray((np.conj(arm) * (x[..., v] - x[..., u])).imag / square)


def _outer(rates: FloatArray) -> FloatArray:
    """Return the products of rates (k,) in pairs (k, k)."""
    return np.asarray(rates[:, None] * rates)


def value_of(curve: LoadCurve, at: float) -> float:
    """Return the value of a curve."""
    return float(curve(np.array([at]))[0])
