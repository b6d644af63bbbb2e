"""The task of a workspace: a mechanism, the ranges of its inputs, a point and given orientations.

The coordinates x are those of the moving nodes after elimination by the linear equations: a node that other nodes
determine linearly has none. They fulfil G(x) = 0, the equations of members and pairs without actuators; the point is
y = Y x + y0. The value of an input is a function of x, and its range an inequality.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from gimcli.errors import UsageError
from gimcli.mechanism import FRAME, SPAN, BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.nearest import guess
from gimcli.positions.inputs import turns_until_repeated
from gimcli.positions.options import TOLERANCE
from gimcli.structure.carried import carried_point
from gimcli.structure.quadric import Flat, Quadric
from gimcli.structure.residual import holds
from gimcli.structure.system import System, system_of

FULL = 1.0 - 1e-12
"""Range of an input, in periods, from which on it has no limits."""

SLACK = 1e-9
"""Excess over its range [rad, or sizes] at which an input still counts as at the end."""


SETTLED = 1e-6
"""Greatest residual of positions from random starts: near singular positions they are less accurate."""

TINY = float(np.finfo(float).tiny)
"""Divisor in place of 0."""

RANK = 1e-8
"""Pivot relative to the greatest below which it counts as 0."""


@dataclass(frozen=True)
class InputRange:
    """Values that an actuator may take: rad, or lengths in the normal frame."""

    actuator: int
    low: float
    high: float

    @property
    def middle(self) -> float:
        """Mean of the ends."""
        return 0.5 * (self.low + self.high)

    @property
    def half(self) -> float:
        """Half the width; 0 if the input is constant."""
        return 0.5 * (self.high - self.low)


@dataclass(frozen=True)
class WorkspaceTask:
    """The workspace of a point as equations and inequalities in x (n,)."""

    mechanism: Mechanism
    point: str
    orientation: Mapping[str, float] = field(default_factory=dict)  # rad, direction of a member's first -> second node

    @cached_property
    def system(self) -> System:
        """The equations of the mechanism, including those of the actuators."""
        return system_of(self.mechanism)

    @cached_property
    def ranges(self) -> tuple[InputRange, ...]:
        """Ranges of the inputs, without those that make a full turn."""
        found = (law_range(self.mechanism, k) for k in self.mechanism.drivers)
        return tuple(r for r in found if 2.0 * r.half < FULL * self._periods[r.actuator])

    @cached_property
    def _periods(self) -> FloatArray:
        return periods(self.mechanism)

    @cached_property
    def limited(self) -> tuple[InputRange, ...]:
        """Ranges of the inputs that move."""
        return tuple(r for r in self.ranges if r.half > 0.0)

    @cached_property
    def output(self) -> tuple[FloatArray, FloatArray]:
        """Y (2, n) and y0 (2,)."""
        n = self.system.n
        z = self.system.nodes(np.hstack([np.zeros((n, 1)), np.eye(n)]))
        path = np.asarray(carried_point(self.mechanism, self.point, z))
        y = np.array([path.real, path.imag])
        table = y[:, 1:] - y[:, :1]
        if not np.any(table):
            raise UsageError(f"'{self.point}' does not move: give a moving node or point")
        flat = self._parted[0]
        return table @ flat.basis, y[:, 0] + table @ flat.origin

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return int(self._parted[0].basis.shape[1])

    def nodes(self, x: FloatArray) -> ComplexArray:
        """Return the nodes' positions (nodes, rows) at x (rows, n)."""
        return self.system.nodes(self._parted[0].lift(x).T)

    def coordinates(self, every: FloatArray) -> FloatArray:
        """Return x (..., n) of the moving nodes' coordinates (..., system.n), which others may follow."""
        return self._parted[0].drop(every[..., : self.system.n])

    def beside(self, x: FloatArray, here: FloatArray) -> FloatArray:
        """Return x, which is the same after full turns, near other coordinates."""
        return x

    def place(self, x: FloatArray) -> FloatArray:
        """Return y (..., 2) at x (..., n)."""
        table, shift = self.output
        return np.asarray(x @ table.T + shift)

    @property
    def whole(self) -> Quadric:
        """The nonlinear equations of members, pairs, orientations and constant inputs."""
        return self._parted[1]

    @cached_property
    def _parted(self) -> tuple[Flat, Quadric]:
        """The affine space in which the linear equations hold, and the nonlinear equations in its coordinates."""
        count = len(self.mechanism.actuators)
        members = self.system.quadric(np.zeros(count)).rows(range(self.system.m - count))
        still = [self._drive(r.actuator, r.low) for r in self.ranges if r.half == 0.0]
        every = members.joined(*still, *map(self._held, self.orientation))
        return every.split_linear(self.system.coordinates(self.mechanism.drawn))

    @cached_property
    def free(self) -> Quadric:
        """The independent equations of `whole`; `fulfilled` checks the others."""
        return _independent(self.whole, self)

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """The actuators whose inputs are not constant."""
        still = {r.actuator for r in self.ranges if r.half == 0.0}
        return tuple(k for k in self.mechanism.drivers if k not in still)

    @cached_property
    def freedoms(self) -> int:
        """Dimension of the set of positions."""
        return self.n - self.free.m

    def drive(self, actuator: int, value: float) -> Quadric:
        """Return the equation of an actuator with a constant value."""
        return self._drive(actuator, value).within(self._parted[0])

    def _drive(self, actuator: int, value: float) -> Quadric:
        """Return that equation in the coordinates of all moving nodes, its value in lengths, or their squares."""
        count = len(self.mechanism.actuators)
        u, row = np.zeros(count), self.system.m - count + actuator
        u[actuator] = value
        return self.system.quadric(u).rows([row]).divided(float(self.system.scale[row]))

    def inputs(self, x: FloatArray) -> FloatArray:
        """Return the values of the inputs (..., actuators), angles in -pi..pi."""
        raw, (rotary, spans) = self._drives.value(x), self._kinds
        count = len(rotary)
        values = raw[..., :count]
        values[..., rotary] = np.arctan2(raw[..., :count][..., rotary], -raw[..., count:])
        values[..., spans] = np.sqrt(np.maximum(values[..., spans], TINY))
        return values

    def rates(self, x: FloatArray) -> FloatArray:
        """Return the derivatives of the inputs by x (..., actuators, n)."""
        raw, table, (rotary, spans) = self._drives.value(x), self._drives.slope(x), self._kinds
        count = len(rotary)
        rates, sine, cosine = table[..., :count, :], raw[..., :count][..., rotary], -raw[..., count:]
        square = np.maximum(sine**2 + cosine**2, TINY)[..., None]
        down = sine[..., None] * table[..., count:, :]
        rates[..., rotary, :] = (cosine[..., None] * rates[..., rotary, :] + down) / square
        rates[..., spans, :] /= 2.0 * np.sqrt(np.maximum(raw[..., :count][..., spans], TINY))[..., None]
        return rates

    def excess(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the excess of inputs over their ranges (..., limited), negative inside, and derivatives (..., n)."""
        apart, (which, _, half) = self._apart(x), self._spans
        return np.abs(apart) - half, np.where(apart >= 0.0, 1.0, -1.0)[..., None] * self.rates(x)[..., which, :]

    def margins(self, x: FloatArray) -> FloatArray:
        """Return the distances of inputs above their low ends and below their high ends (..., 2 limited)."""
        apart, half = self._apart(x), self._spans[2]
        return np.concatenate([half + apart, half - apart], axis=-1)

    def room(self, x: FloatArray) -> FloatArray:
        """Return smooth functions (..., limited) that are positive inside the ranges of the inputs."""
        apart, (which, _, half) = self._apart(x), self._spans
        turn = 2.0 * math.pi / self._periods[which]
        return np.where(turn > 0.0, np.cos(turn * apart) - np.cos(turn * half), half**2 - apart**2)

    def _apart(self, x: FloatArray) -> FloatArray:
        """Return the differences of inputs from the middles of their ranges (..., limited)."""
        which, middle, _ = self._spans
        apart = self.inputs(x)[..., which] - middle
        period = self._periods[which]
        return np.asarray(apart - np.where(np.isfinite(period), period, 0.0) * np.round(apart / period))

    @cached_property
    def _spans(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Actuators, middles and half widths (limited,) of the ranges."""
        which = np.array([r.actuator for r in self.limited], dtype=int)
        return which, np.array([r.middle for r in self.limited]), np.array([r.half for r in self.limited])

    def fulfilled(self, x: FloatArray, tolerance: float = TOLERANCE) -> BoolArray:
        """Return for x (rows, n) whether every constraint of the mechanism holds, for any inputs (rows,)."""
        return holds(self.mechanism, self.nodes(x), self.inputs(x).T, tolerance)

    def allowed(self, x: FloatArray) -> np.ndarray:
        """Return for x (rows, n) whether they are configurations with all inputs within their ranges.

        The solved equations do not include redundant constraints, and allow blocks and fixed directions to be reversed.
        """
        fits = np.all(self.excess(x)[0] <= SLACK, axis=-1) & self.fulfilled(x, SETTLED)
        for name, angle in self.orientation.items():
            z = self._arm(name, self._parted[0].lift(x))
            fits &= (z * cmath.exp(-1j * angle)).real > 0.0
        return np.asarray(fits)

    @cached_property
    def _kinds(self) -> tuple[BoolArray, BoolArray]:
        """Return for every actuator whether it is rotary, and whether it drives a distance."""
        actuators = self.mechanism.actuators
        return np.array([a.rotary for a in actuators]), np.array([a.kind == SPAN for a in actuators])

    @cached_property
    def _drives(self) -> Quadric:
        """The equations of the actuators at 0, then those of rotary ones at a quarter turn: sines, -cosines."""
        first, *others = [self.drive(k, 0.0) for k in range(len(self.mechanism.actuators))]
        return first.joined(*others, *(self.drive(int(k), math.pi / 2) for k in np.flatnonzero(self._kinds[0])))

    def _arm(self, name: str, x: FloatArray) -> ComplexArray:
        """Return the vector (...) from a member's first to its second node at moving nodes x (..., system.n)."""
        nodes = {m.name: m.nodes for m in self.mechanism.members[FRAME + 1 :]}
        if name not in nodes:
            raise UsageError(f"orientation: no moving member '{name}'; {guess(name, list(nodes))}")
        z = self.system.nodes(x.reshape(-1, self.system.n).T)
        return np.asarray((z[nodes[name][1]] - z[nodes[name][0]]).reshape(x.shape[:-1]))

    def _held(self, name: str) -> Quadric:
        """Return the equation of a member's given direction, in the coordinates of all moving nodes."""
        n, turn = self.system.n, cmath.exp(-1j * self.orientation[name])
        height = (self._arm(name, np.vstack([np.zeros(n), np.eye(n)])) * turn).imag
        return Quadric(height[:1], (height[1:] - height[0])[None, :], np.zeros((1, n, n)))


def unreached(task: WorkspaceTask) -> str:
    """Return the message that no position exists."""
    held = f" with {', '.join(task.orientation)} held" if task.orientation else ""
    return (
        f"{task.mechanism.name}{held} has no position within the ranges of its inputs: widen their laws, or check"
        " the lengths by `gim solve`"
    )


def law_range(mechanism: Mechanism, actuator: int) -> InputRange:
    """Return the least and greatest value of an actuator's law."""
    law = mechanism.actuators[actuator].law
    values = law(np.append(law.stops(), [0.0, 1.0]))
    return InputRange(actuator, float(np.min(values)), float(np.max(values)))


def periods(mechanism: Mechanism) -> FloatArray:
    """Return the changes (actuators,) of inputs after which all inputs are the same but for full turns.

    Infinite if there is none.
    """
    found = np.where([a.rotary for a in mechanism.actuators], 2.0 * math.pi, math.inf)
    for k in mechanism.drivers if mechanism.couplings else ():
        found[k] *= turns_until_repeated(mechanism, k) or math.inf
    return found


def _independent(whole: Quadric, task: WorkspaceTask) -> Quadric:
    """Return independent equations, chosen by their general rank near the initial position."""
    from scipy.linalg import qr

    from gimcli.continuation.gauss_newton import settle

    rng = np.random.default_rng(1)
    drawn = task.coordinates(task.system.coordinates(task.mechanism.drawn))
    start = drawn + rng.normal(0.0, 0.05, (40, task.n))
    x, good = settle(lambda at, _: (whole.value(at), whole.slope(at)), start)
    if not good.any() or not whole.m:
        return whole
    near = x[good][np.argsort(np.linalg.norm(x[good] - drawn, axis=1))[:9]]
    found: list[list[int]] = []
    for place in near:  # some may be singular, or of another configuration
        r, order = qr(whole.slope(place).T, mode="r", pivoting=True)
        size = np.abs(np.diag(r))
        found.append(sorted(order[: int(np.sum(size > RANK * size[0]))].tolist()))
    ranks = [len(rows) for rows in found]
    best = max(found, key=lambda rows: (ranks.count(len(rows)), len(rows)))
    return whole.rows(best)
