"""The constraint Jacobian: one row for each restriction, in the coordinates of the free nodes.

Elimination with full pivoting determines its rank; the rows without a pivot are redundant (Fraczek & Wojtyra, section
1.3). Gauss-Newton with least-norm steps restores the constraints.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from gimcli.canonical import TURN, first_greatest
from gimcli.mechanism import ANGLE, FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.equations import followed, with_gauges, with_linked_gauges
from gimcli.structure.kinematic_nodes import free_nodes, kinematic_nodes
from gimcli.structure.pair_rows import constraint_of
from gimcli.structure.readings import Readings
from gimcli.structure.restrictions import member_models, pair_restrictions
from gimcli.structure.steps import Value
from gimcli.structure.terms import coordinates, places

ROUNDING = 1e-14
"""A gradient in the normal frame below this is 0, such as that of an angle that other constraints keep constant."""

RANK = 1e-8
"""A pivot below this fraction of the greatest is 0; rows are scaled to length 1."""

EXTENT = 4.0
"""The size is limited to this multiple of the greatest member, because nodes may be drawn far away."""

ASSEMBLED, ALMOST = 1e-13, 0.1
"""Error of the constraints, relative to the size, of an assembled position, and of slightly inconsistent dimensions."""

ITERATIONS = 60
"""Iterations of Gauss-Newton."""

STALLED = 8
"""Iterations in which the error is at least halved, or a position in a given direction does not exist."""


class Jacobian:
    """The constraints and drives of a mechanism, and their gradients in the coordinates of the free nodes.

    A constraint is a distance, an angle or a height, or an input that follows others: the sum of ratio times quantity.
    Values are lengths: an angle between nodes is multiplied by its arm.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        kinematic = kinematic_nodes(mechanism)
        frame = set(mechanism.members[FRAME].nodes)
        self.free = list(free_nodes(mechanism))
        self._columns = [2 * n + c for n in self.free for c in (0, 1)]
        models = [
            member_models(mechanism, index, sorted(nodes, key=lambda n: n not in frame), frame)[0]
            for index, nodes in enumerate(kinematic)
            if index != FRAME and not set(nodes) <= frame
        ]
        names = [a.name for a in mechanism.actuators]
        pairs = pair_restrictions(mechanism, frame, kinematic)
        own = [*(r for model in models for r in model), *(r for r in pairs if r.name not in names)]
        followers = [coupling.follower for coupling in mechanism.couplings]
        self.names = [*(r.name for r in own), *(names[k] for k in followers)]
        self.goal = np.array([0.0 if r.kind == ANGLE else r.value.constant for r in own] + [0.0] * len(followers))
        read = with_gauges(with_linked_gauges(replace(mechanism, gauges=())))
        inputs = [constraint_of(read, row, Value(0.0), kinematic) for row in read.actuators]
        self._first = len(own)  # of the quantities of inputs, if some follow others
        self._readings = Readings([*own, *(inputs if followers else ())], len(mechanism.nodes))
        self._drives = Readings([inputs[k] for k in mechanism.drivers], len(mechanism.nodes))
        self._drawn = self._readings.values(mechanism.drawn) * (np.arange(self._readings.count) >= self._first)
        self._mix = np.zeros((len(self.names), self._readings.count))
        self._mix[: self._first, : self._first] = np.eye(self._first)
        for row, coupling in zip(self._mix[self._first :, self._first :], mechanism.couplings, strict=True):
            row[coupling.follower] = 1.0
            for k, ratio in followed(read, coupling):
                row[k] -= ratio

    @cached_property
    def size(self) -> float:
        """Reference length of steps and errors; nodes that are drawn far away do not increase it."""
        extent = EXTENT * max((member.extent for member in self.mechanism.members), default=0.0)
        return min(self.mechanism.size, extent) if extent > 0.0 else self.mechanism.size

    def rows(self, z: ComplexArray) -> FloatArray:
        """Return the gradients (constraints, 2 x free nodes), scaled to length 1, or to 0 for rounding errors."""
        return _scaled(self.slopes(z))

    def drives(self, z: ComplexArray) -> FloatArray:
        """Return the gradients (drives, 2 x free nodes) of the independent inputs, scaled likewise."""
        return _scaled(self._drives.slopes(z)[:, self._columns])

    def slopes(self, z: ComplexArray) -> FloatArray:
        """Return the gradients (constraints, 2 x free nodes) at positions z (nodes,)."""
        return self._mixed(z, self._readings.slopes(z)[:, self._columns])

    def slopes_along(self, z: ComplexArray, motion: ComplexArray) -> FloatArray:
        """Return the derivatives of the slopes along a motion (nodes,) that the constraints allow."""
        return self._mixed(z, self._readings.slopes_along(z, motion)[:, self._columns])

    def values(self, z: ComplexArray) -> FloatArray:
        """Return the values (constraints,) at positions z (nodes,).

        Those of followers are 0 at the drawing; angles differ from it by less than half a turn.
        """
        change = self._readings.values(z) - self._drawn
        return self._mixed(z, change - self._readings.angles * TURN * np.round(change / TURN))

    def _mixed(self, z: ComplexArray, found: FloatArray) -> FloatArray:
        arms = self._readings.arms(z)
        arms[self._first :] = 1.0
        return np.asarray((self._mix * arms) @ found)

    def ranks(self, z: ComplexArray) -> tuple[int, int]:
        """Return the rank of the constraints, and the rank of constraints and drives together."""
        table = self.rows(z)
        return full_pivoting(table)[0], full_pivoting(np.vstack([table, self.drives(z)]))[0]

    def motions(self, table: FloatArray) -> ComplexArray:
        """Return a basis of the velocities (nodes, motions) in the null space of a table of gradients."""
        null = np.eye(2 * len(self.free))
        if table.size:
            _, s, v = np.linalg.svd(table)
            null = v[int(np.sum(s > RANK * max(float(s[0]), 1e-300))) :]
        motion = np.zeros((len(self.mechanism.nodes), len(null)), dtype=complex)
        motion[self.free] = places(null).T
        return motion

    def vector(self, motion: ComplexArray) -> FloatArray:
        """Return the coordinates (2 x free nodes,) of a motion (nodes,)."""
        return coordinates(motion[self.free])

    def nearest(
        self, trial: ComplexArray, goal: FloatArray, along: FloatArray | None = None
    ) -> tuple[ComplexArray, float]:
        """Return the final position of Gauss-Newton with least-norm steps, and its greatest error (inf if it diverges).

        goal: values (constraints,). along: a direction (2 x free nodes,) in which the trial position is not changed.
        """
        errors: list[float] = []
        size, fixed = self.size, np.zeros((0, 2 * len(self.free))) if along is None else along[None]
        with np.errstate(all="ignore"):
            for _ in range(ITERATIONS):
                error = self.values(trial) - goal
                worst = float(np.max(np.abs(error), initial=0.0))
                if not np.isfinite(worst):
                    return trial, np.inf
                errors.append(worst)
                stalled = len(fixed) > 0 and len(errors) > STALLED and worst > 0.5 * errors[-1 - STALLED]
                if worst < ASSEMBLED * size or stalled:
                    break
                table = np.vstack([self.slopes(trial), fixed])
                step = np.linalg.lstsq(table, np.append(error, np.zeros(len(fixed))), rcond=1e-10)[0]
                trial = trial.copy()
                trial[self.free] -= places(np.asarray(step, dtype=float))
        return trial, worst


def _scaled(table: FloatArray) -> FloatArray:
    norm = np.linalg.norm(table, axis=1, keepdims=True)
    return np.where(norm > ROUNDING, table / np.where(norm > ROUNDING, norm, 1.0), 0.0)


@derived
def constraint_jacobian(mechanism: Mechanism) -> Jacobian:
    """Return the constraint Jacobian of a mechanism."""
    return Jacobian(mechanism)


def full_pivoting(table: FloatArray, tolerance: float = RANK) -> tuple[int, list[int]]:
    """Eliminate with full pivoting; return the rank and the numbers of the rows without a pivot."""
    a = table.copy()
    rows = list(range(a.shape[0]))
    rank, first = 0, 0.0
    for k in range(min(a.shape)):
        i, j = (k + at for at in divmod(first_greatest(np.abs(a[k:, k:]).ravel()), a.shape[1] - k))
        first = first or abs(a[i, j])
        if not abs(a[i, j]) > tolerance * max(first, 1e-300):
            break
        a[[k, i]], rows[k], rows[i] = a[[i, k]], rows[i], rows[k]
        a[:, [k, j]] = a[:, [j, k]]
        a[k + 1 :, k:] -= (a[k + 1 :, k] / a[k, k])[:, None] * a[k, k:]
        rank += 1
    return rank, sorted(rows[rank:])


def dependent(table: FloatArray) -> dict[int, list[int]]:
    """Return for each row without a pivot the other rows that could take its place: those that it depends on."""
    spare = full_pivoting(table)[1] if table.size else []
    own = [k for k in range(len(table)) if k not in spare]
    if not spare:
        return {}
    parts = np.linalg.lstsq(table[own].T, table[spare].T, rcond=None)[0]
    used = np.abs(parts.T) > RANK
    return {row: [own[k] for k in np.flatnonzero(mask)] for row, mask in zip(spare, used, strict=True)}
