"""The task of a workspace where inputs follow others: the inputs of the drivers are coordinates too.

The coordinates are x = (positions, inputs of the drivers that move); an input that follows the linkage is among the
positions. The equations are those of the mechanism with released inputs, in which followers are functions of the
drivers: they are not of second degree, and ratios may be any numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.continuation.released import ReleasedPositions
from gimcli.mechanism import FloatArray
from gimcli.reach.task import WorkspaceTask
from gimcli.structure.carried import measured, turned
from gimcli.structure.quadric import Flat, Quadric


@dataclass(frozen=True)
class ReleasedForm(Quadric):
    """Some equations of positions with released inputs, followed by equations of second degree."""

    positions: ReleasedPositions
    chosen: Sequence[int]

    @property
    def m(self) -> int:
        """Number of equations."""
        return len(self.chosen) + super().m

    def value(self, x: FloatArray) -> FloatArray:
        """Return the left sides (..., m) at x (..., n)."""
        return np.concatenate([self.positions.linearised(x)[0][..., self.chosen], super().value(x)], axis=-1)

    def slope(self, x: FloatArray) -> FloatArray:
        """Return the derivatives (..., m, n) of the left sides."""
        return np.concatenate([self.positions.jacobian(x)[..., self.chosen, :], super().slope(x)], axis=-2)

    def weighted(self, weights: FloatArray, x: FloatArray) -> FloatArray:
        """Return the second derivative (..., n, n) at x of the weighted sum of the equations, for weights (..., m)."""
        own, first = self.positions.second(x)[..., self.chosen, :], len(self.chosen)
        found = np.einsum("...imj,...m->...ij", own, weights[..., :first])
        return np.asarray(found + super().weighted(weights[..., first:], x))

    def rows(self, chosen: Sequence[int]) -> ReleasedForm:
        """Return the chosen equations."""
        first = len(self.chosen)
        others = super().rows([k - first for k in chosen if k >= first])
        return self._followed_by([self.chosen[k] for k in chosen if k < first], others)

    def joined(self, *others: Quadric) -> ReleasedForm:
        """Return these equations followed by others."""
        return self._followed_by(self.chosen, Quadric(self.c, self.linear, self.q).joined(*others))

    def _followed_by(self, chosen: Sequence[int], others: Quadric) -> ReleasedForm:
        return ReleasedForm(others.c, others.linear, others.q, self.positions, chosen)


class CoupledTask(WorkspaceTask):
    """The workspace of a point where inputs follow others, as equations and inequalities in x (n,)."""

    @cached_property
    def _released(self) -> ReleasedPositions:
        """All positions, with the inputs of the drivers that move as parameters."""
        mechanism, base = self.mechanism, np.zeros(len(self.mechanism.actuators))
        for r in self.ranges:
            base[r.actuator] = 0.0 if r.half else r.low
        along = mechanism.following[:, [mechanism.drivers.index(k) for k in self.moving]]
        return ReleasedPositions(mechanism, mechanism.coupled(base), along)

    @cached_property
    def _parted(self) -> tuple[Flat, ReleasedForm]:
        """The positions as a part of the coordinates, and the equations."""
        own, n, k = self._released, self.system.n, self._released.count
        flat, nothing = Flat(np.zeros(n), np.eye(n, n + k)), np.zeros((0, n + k, n + k))
        every = ReleasedForm(nothing[:, 0, 0], nothing[:, 0], nothing, own, range(self.system.m))
        return flat, every.joined(*(self._held(name).within(flat) for name in self.orientation))

    def drive(self, actuator: int, value: float) -> Quadric:
        """Return the equation of an actuator with a constant value."""
        row = np.eye(1, self.n, self.system.n + self.moving.index(actuator))
        return Quadric(np.array([-value]), row, np.zeros((1, self.n, self.n)))

    def inputs(self, x: FloatArray) -> FloatArray:
        """Return the values of the inputs (..., actuators)."""
        return np.moveaxis(self._released.inputs(np.moveaxis(x, -1, 0)), 0, -1)

    def rates(self, x: FloatArray) -> FloatArray:
        """Return the derivatives of the inputs by x (..., actuators, n)."""
        return np.swapaxes(self._released.input_rates(x[..., None, :], np.eye(self.n)), -1, -2)

    def coordinates(self, every: FloatArray) -> FloatArray:
        """Return x (..., n) of positions (..., system.n), whose drivers are measured, or of positions and inputs."""
        n, mechanism = self.system.n, self.mechanism
        if every.shape[-1] == self.n:
            return every
        z = self.system.nodes(np.moveaxis(every, -1, 0))
        rows, turn = [mechanism.actuators[k] for k in self.moving], 2.0 * math.pi
        read = np.array([np.angle(turned(mechanism, r, z)) if r.rotary else measured(mechanism, r, z) for r in rows])
        drawn, rotary = (np.array([getattr(row, name) for row in rows]) for name in ("drawn", "rotary"))
        found = np.moveaxis(read.reshape(len(rows), *every.shape[:-1]), 0, -1)
        return np.concatenate([every[..., :n], found + rotary * turn * np.round((drawn - found) / turn)], axis=-1)

    def beside(self, x: FloatArray, here: FloatArray) -> FloatArray:
        """Return x (..., n) with the inputs of its drivers changed by full periods, near others (..., n)."""
        period = np.append(np.full(self.system.n, math.inf), self._periods[list(self.moving)])
        return np.asarray(x + np.where(np.isfinite(period), period, 0.0) * np.round((here - x) / period))
