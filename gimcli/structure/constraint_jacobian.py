"""The constraint Jacobian: one row for each restriction, in the coordinates of the free nodes.

Elimination with full pivoting determines its rank; the rows without a pivot are redundant (Fraczek & Wojtyra, section
1.3). Gauss-Newton with least-norm steps restores the constraints.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from gimcli.canonical import first_greatest
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.structure.coupled_rows import CoupledRow
from gimcli.structure.derived import derived
from gimcli.structure.kinematic_nodes import free_nodes, kinematic_nodes
from gimcli.structure.restrictions import Restriction, member_models, pair_restrictions

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

Rows = Sequence[Restriction | CoupledRow]
"""Constraints of positions."""


class Jacobian:
    """The restrictions of a mechanism and their gradients in the coordinates of the free nodes."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        kinematic = kinematic_nodes(mechanism)
        frame = set(mechanism.members[FRAME].nodes)
        self.free = list(free_nodes(mechanism))
        self.column = {n: 2 * k for k, n in enumerate(self.free)}
        models = [
            member_models(mechanism, index, sorted(nodes, key=lambda n: n not in frame), frame)[0]
            for index, nodes in enumerate(kinematic)
            if index != FRAME and not set(nodes) <= frame
        ]
        pairs = pair_restrictions(mechanism, frame, kinematic)
        drives = {a.name for a in mechanism.actuators}
        independent = {mechanism.actuators[k].name for k in mechanism.drivers}
        self.constraints: list[Restriction | CoupledRow] = [
            *(restriction for model in models for restriction in model),
            *(r for r in pairs if r.name not in drives),
            *(CoupledRow(mechanism, coupling) for coupling in mechanism.couplings),
        ]
        self.drives = [r for r in pairs if r.name in independent]

    @cached_property
    def size(self) -> float:
        """Reference length of steps and errors; nodes that are drawn far away do not increase it."""
        extent = EXTENT * max((member.extent for member in self.mechanism.members), default=0.0)
        return min(self.mechanism.size, extent) if extent > 0.0 else self.mechanism.size

    def rows(self, restrictions: Rows, z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return the gradients (restrictions, 2 x free nodes), scaled to length 1, or to 0 for rounding errors."""
        table = self.slopes(restrictions, z, inputs)
        norm = np.linalg.norm(table, axis=1, keepdims=True)
        return np.where(norm > ROUNDING, table / np.where(norm > ROUNDING, norm, 1.0), 0.0)

    def slopes(self, restrictions: Rows, z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return the gradients (restrictions, 2 x free nodes)."""
        table = np.zeros((len(restrictions), 2 * len(self.free)))
        for k, restriction in enumerate(restrictions):
            for node, g in restriction.gradient(z, inputs).items():
                if node in self.column:
                    at = self.column[node]
                    table[k, at : at + 2] += g.real, g.imag
        return table

    def ranks(self, z: ComplexArray, inputs: FloatArray) -> tuple[int, int]:
        """Return the rank of the constraints, and the rank of constraints and drives together."""
        table = self.rows(self.constraints, z, inputs)
        both = np.vstack([table, self.rows(self.drives, z, inputs)])
        first, second = (full_pivoting(part)[0] if part.size else 0 for part in (table, both))
        return first, second

    def motions(self, table: FloatArray) -> ComplexArray:
        """Return a basis of the velocities (nodes, motions) in the null space of a table of gradients."""
        null = np.eye(2 * len(self.free))
        if table.size:
            _, s, v = np.linalg.svd(table)
            null = v[int(np.sum(s > RANK * max(float(s[0]), 1e-300))) :]
        motion = np.zeros((len(self.mechanism.nodes), len(null)), dtype=complex)
        motion[self.free] = (null[:, 0::2] + 1j * null[:, 1::2]).T
        return motion

    def vector(self, motion: ComplexArray) -> FloatArray:
        """Return the coordinates (2 x free nodes,) of a motion (nodes,)."""
        return np.column_stack([motion[self.free].real, motion[self.free].imag]).ravel()

    def values(self, z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return the values (constraints,) of the constraints at positions z (nodes,)."""
        return np.array([r.measure(z, inputs) for r in self.constraints])

    def nearest(
        self, trial: ComplexArray, goal: FloatArray, inputs: FloatArray, along: FloatArray | None = None
    ) -> tuple[ComplexArray, float]:
        """Return the final position of Gauss-Newton with least-norm steps, and its greatest error (inf if it diverges).

        goal: values (constraints,). along: a direction (2 x free nodes,) in which the trial position is not changed.
        """
        errors: list[float] = []
        size, fixed = self.size, np.zeros((0, 2 * len(self.free))) if along is None else along[None]
        with np.errstate(all="ignore"):
            for _ in range(ITERATIONS):
                error = self.values(trial, inputs) - goal
                worst = float(np.max(np.abs(error), initial=0.0))
                if not np.isfinite(worst):
                    return trial, np.inf
                errors.append(worst)
                stalled = len(fixed) > 0 and len(errors) > STALLED and worst > 0.5 * errors[-1 - STALLED]
                if worst < ASSEMBLED * size or stalled:
                    break
                table = np.vstack([self.slopes(self.constraints, trial, inputs), fixed])
                step = np.linalg.lstsq(table, np.append(error, np.zeros(len(fixed))), rcond=1e-10)[0]
                trial = trial.copy()
                trial[self.free] -= step[0::2] + 1j * step[1::2]
        return trial, worst


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
