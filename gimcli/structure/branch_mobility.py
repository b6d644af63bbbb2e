"""The branches through an assembled position, with the freedoms, undriven nodes and surplus actuators of each.

A branch is found by a step along a motion in the null space of the Jacobian that is kept while the constraints are
restored, and is followed back to the position. Where equations remain dependent on a branch (left null vectors w), a
motion u of it satisfies w' G_pp u v = 0 for all v in the null space, because w' G_p v = 0 holds along the branch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.structure.constraint_jacobian import ASSEMBLED, RANK, ROUNDING, Jacobian, full_pivoting
from gimcli.structure.kinematic_nodes import carry

STEPS = (1e-2, 1e-3, 1e-4)
"""Lengths of the step to a neighbouring position, relative to the size, tried in this order."""

TRIALS, MORE = 4, 40
"""Number of neighbouring positions, and for each apparent freedom if branches meet."""

NEAREST, FARTHEST = 0.1, 10.0
"""Range of the distance to a neighbour, in steps: below, it is the same position; above, an unrelated one."""

CLOSE, SHRUNK, ASIDE = 2e-5, 0.1, 2.0
"""A branch is followed back to this distance, in steps of this ratio, each of at most this length of the straight."""

CURVED = 1e-6
"""The least second derivative that is not 0."""

MOVES = 1e-6
"""In a motion of length 1, a node that moves by less is fixed."""


@dataclass(frozen=True)
class Branch:
    """What moves on a branch, and what its actuators do."""

    mobility: int  # number of freedoms
    undriven: tuple[str, ...]  # nodes that can move while all inputs are constant
    overdriven: tuple[str, ...]  # actuators of freedoms that are already driven or constrained

    @property
    def driven(self) -> bool:
        """Whether the actuators match the freedoms."""
        return not self.undriven and not self.overdriven


def branches(jacobian: Jacobian, z: ComplexArray) -> Iterator[tuple[Branch, ComplexArray]]:
    """Yield the branches through an assembled position z (nodes,) that differ, each with a position on it."""
    goal, rank = jacobian.values(z), jacobian.ranks(z)[0]
    found: set[Branch] = set()
    for step in STEPS if rank < 2 * len(jacobian.free) else ():
        meeting, length = False, step * jacobian.size
        for number, there in enumerate(_neighbours(jacobian, z, length), start=1):
            one = at_position(jacobian, there)
            meeting = meeting or jacobian.ranks(there)[0] > rank
            if one not in found:  # it may be another singular position
                aside = next(_neighbours(jacobian, there, SHRUNK * length), there)
                if (other := at_position(jacobian, aside)) != one:
                    there, one = aside, other
            if one not in found and _leads_to(jacobian, z, there, goal):
                found.add(one)
                yield one, there
            if number >= TRIALS and not meeting:
                break
        if found:
            break


def at_position(jacobian: Jacobian, z: ComplexArray) -> Branch:
    """Return the freedoms and drives at a position z (nodes,) on one branch only."""
    table = fixed(jacobian, z)
    driven = np.vstack([table, jacobian.drives(z)])
    ranks = [full_pivoting(driven[:k])[0] for k in range(len(table), len(driven) + 1)]
    count = 2 * len(jacobian.free) - ranks[0]
    inputs_of = [jacobian.mechanism.actuators[k].name for k in jacobian.mechanism.drivers]
    useful = {name for name, low, high in zip(inputs_of, ranks, ranks[1:], strict=False) if high > low}
    loose = (
        carry(jacobian.mechanism, jacobian.motions(driven)) if ranks[-1] < 2 * len(jacobian.free) else z[:, None] * 0
    )
    moving = np.flatnonzero(np.linalg.norm(loose, axis=1) > MOVES).tolist()
    return Branch(
        count, tuple(jacobian.mechanism.nodes[n] for n in moving), tuple(n for n in inputs_of if n not in useful)
    )


def fixed(jacobian: Jacobian, z: ComplexArray) -> FloatArray:
    """Return rows (., 2 x free nodes) that are 0 for the motions of the branch at positions z (nodes,)."""
    norm = np.linalg.norm(jacobian.slopes(z), axis=1, keepdims=True)
    table = jacobian.rows(z)
    if not table.size:
        return table
    left, values, right = np.linalg.svd(table)
    rank = int(np.sum(values > RANK * max(float(values[0]), 1e-300)))
    left, right = left[:, rank:] / np.where(norm > ROUNDING, norm, 1.0), right[rank:]
    if not left.size or not right.size:
        return table
    forms = [left.T @ jacobian.slopes_along(z, one) @ right.T for one in jacobian.motions(table).T]
    _, values, turned = np.linalg.svd(np.vstack(forms))
    return np.vstack([table, turned[: int(np.sum(values > CURVED))] @ right])


def _neighbours(jacobian: Jacobian, z: ComplexArray, step: float) -> Iterator[ComplexArray]:
    """Yield assembled positions at a distance of about `step` from z; every other one is sought where drives move."""
    generator = np.random.default_rng(0)
    goal, drives = jacobian.values(z), jacobian.drives(z)
    null = jacobian.motions(jacobian.rows(z))
    for number in range(MORE * null.shape[1]):
        motion = null @ generator.standard_normal(null.shape[1])
        motion *= step / np.linalg.norm(motion)
        along = generator.standard_normal(len(drives)) @ drives if number % 2 and len(drives) else None
        there = _restored(jacobian, z + motion, goal, jacobian.vector(motion) if along is None else along)
        if there is not None and NEAREST * step < np.linalg.norm(there - z) < FARTHEST * step:
            yield there


def _leads_to(jacobian: Jacobian, z: ComplexArray, there: ComplexArray, goal: FloatArray) -> bool:
    """Return whether a branch can be followed from a position on it to z."""
    while np.linalg.norm(there - z) > CLOSE * jacobian.size:
        way = SHRUNK * (there - z)
        nearer = _restored(jacobian, z + way, goal, jacobian.vector(way))
        if nearer is None or np.linalg.norm(nearer - z) > ASIDE * np.linalg.norm(way):
            return False
        there = nearer
    return True


def _restored(jacobian: Jacobian, trial: ComplexArray, goal: FloatArray, along: FloatArray) -> ComplexArray | None:
    """Return the assembled position found from a trial position, moved only across `along`; None if that fails."""
    size = float(np.linalg.norm(along))
    z, error = jacobian.nearest(trial, goal, along / (size or 1.0))
    return z if error < ASSEMBLED * jacobian.size else None
