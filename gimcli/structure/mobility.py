"""Mobility: Grübler's count, the rank of the constraint Jacobian, redundant and undriven parts.

The Jacobian holds one row a restriction in the coordinates of the free nodes. Elimination with full
pivoting tells its rank, the rows without a pivot are the redundant ones (Fraczek & Wojtyra, section
1.3). A rank loss at one position alone is not a freedom: it is confirmed at assembled neighbours.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.errors import StructureError
from gimcli.mechanism import ANGLE, FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.gradients import gradient, measure
from gimcli.structure.kinematic_nodes import carry, free_nodes, kinematic_nodes, loose_nodes
from gimcli.structure.residual import errors
from gimcli.structure.restrictions import Restriction, member_models, pair_restrictions
from gimcli.structure.rotation import members_of

ROUNDING = 1e-14
"""A gradient in the normal frame below this is none: that of an angle between members that are one."""

RANK = 1e-8
"""A pivot below this part of the greatest is none: rows are scaled to length 1."""

STEPS = (1e-2, 1e-3, 1e-4)
"""Lengths of the step to a neighbouring position, relative to the size; a shorter one where none is found."""

TRIALS, MORE = 4, 40
"""Neighbouring positions that are looked for; more where branches meet and none yet is on one that the inputs drive."""

EXTENT = 4.0
"""Greatest members whose length is the size of the mechanism; nodes may be drawn much farther away."""

BACK, ASTRAY = 0.1, 10.0
"""Parts of a step between which a neighbour lies: nearer it is the position itself, farther another one."""

ASSEMBLED, ALMOST = 1e-13, 0.1
"""Error of the constraints, relative to the size, of a position that is assembled, or contradicts itself by little."""

ITERATIONS = 60
"""Iterations of Gauss-Newton."""

STARTS = 24
"""Drawings, disturbed more and more, from which an assembled position is looked for."""

NEAR = 1e-6
"""Error of a constraint, relative to the size or in rad, that is rounding: a block turned end for end is pi off."""

MOVES = 1e-6
"""A node that moves by less, of a motion of length 1, stands still."""


@dataclass(frozen=True)
class Mobility:
    """What the count and the rank say at one assembled position."""

    gruebler: int
    rank: int  # of the constraint Jacobian at the position, actuators left out
    mobility: int  # confirmed freedoms
    apparent: int  # coordinates minus rank at the position
    redundant: tuple[str, ...]  # names of the surplus constraints
    undriven: tuple[str, ...]  # nodes that can still move with all actuators held
    actuators: tuple[str, ...]
    overdriven: tuple[str, ...]  # actuators that drive what is driven or held already
    stuck: bool  # the inputs determine less at the position than next to it

    @property
    def singular(self) -> bool:
        """Tell whether the rank at this position is lower than next to it."""
        return self.apparent != self.mobility


def gruebler(mechanism: Mechanism) -> int:
    """Return 3 L - 2 J: k members at a node are k-1 pairs, a pin in a slot takes one freedom."""
    members = members_of(mechanism)
    moving = len(mechanism.members) - 1
    pairs = sum(len(at) - 1 for at in members if len(at) > 1)
    rows = len(mechanism.pairs) - 2 * len(loose_nodes(mechanism))
    return 3 * moving - 2 * pairs - rows


class Jacobian:
    """The restrictions of a mechanism and their gradients in the coordinates of the free nodes."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        kinematic = kinematic_nodes(mechanism)
        frame = set(mechanism.members[FRAME].nodes)
        self.free = list(free_nodes(mechanism))
        self.column = {n: 2 * k for k, n in enumerate(self.free)}
        restrictions: list[Restriction] = []
        for index, nodes in enumerate(kinematic):
            if index != FRAME and not set(nodes) <= frame:
                ranked = sorted(nodes, key=lambda n: n not in frame)
                restrictions += member_models(mechanism, index, ranked, frame)[0]
        pairs = pair_restrictions(mechanism, frame, kinematic)
        drives = {a.name for a in mechanism.actuators}
        self.constraints = restrictions + [r for r in pairs if r.name not in drives]
        self.drives = [r for r in pairs if r.name in drives]

    @cached_property
    def size(self) -> float:
        """Length that steps and errors are relative to: nodes that are drawn far away do not count."""
        spans = [float(np.max(np.abs(m.shape[:, None] - m.shape))) for m in self.mechanism.members if len(m.nodes)]
        extent = EXTENT * max(spans, default=0.0)
        return min(self.mechanism.size, extent) if extent > 0.0 else self.mechanism.size

    def rows(self, restrictions: list[Restriction], z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return the gradients, each row scaled to length 1; what rounding leaves of none is none."""
        table = self.slopes(restrictions, z, inputs)
        norm = np.linalg.norm(table, axis=1, keepdims=True)
        return np.where(norm > ROUNDING, table / np.where(norm > ROUNDING, norm, 1.0), 0.0)

    def slopes(self, restrictions: list[Restriction], z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return the gradients (restrictions, 2 x free nodes)."""
        table = np.zeros((len(restrictions), 2 * len(self.free)))
        for k, restriction in enumerate(restrictions):
            for node, g in gradient(restriction, z, inputs).items():
                if node in self.column:
                    at = self.column[node]
                    table[k, at : at + 2] += g.real, g.imag
        return table

    def ranks(self, z: ComplexArray, inputs: FloatArray) -> tuple[int, int]:
        """Return the rank of the constraints, and of constraints and drives."""
        table = self.rows(self.constraints, z, inputs)
        both = np.vstack([table, self.rows(self.drives, z, inputs)])
        first, second = (full_pivoting(part)[0] if part.size else 0 for part in (table, both))
        return first, second

    def motions(self, table: FloatArray) -> ComplexArray:
        """Return velocities (nodes, motions) that a table of gradients allows."""
        null = np.eye(2 * len(self.free))
        if table.size:
            _, s, v = np.linalg.svd(table)
            null = v[int(np.sum(s > RANK * max(float(s[0]), 1e-300))) :]
        motion = np.zeros((len(self.mechanism.nodes), len(null)), dtype=complex)
        motion[self.free] = (null[:, 0::2] + 1j * null[:, 1::2]).T
        return motion


@derived
def constraint_jacobian(mechanism: Mechanism) -> Jacobian:
    """Return the restrictions of a mechanism and their gradients."""
    return Jacobian(mechanism)


def full_pivoting(table: FloatArray, tolerance: float = RANK) -> tuple[int, list[int]]:
    """Eliminate with full pivoting; return the rank and the rows that found no pivot."""
    a = table.copy()
    rows = list(range(a.shape[0]))
    rank, first = 0, 0.0
    for k in range(min(a.shape)):
        at = np.unravel_index(np.argmax(np.abs(a[k:, k:])), a[k:, k:].shape)
        i, j = int(at[0]) + k, int(at[1]) + k
        first = first or abs(a[i, j])
        if not abs(a[i, j]) > tolerance * max(first, 1e-300):
            break
        a[[k, i]], rows[k], rows[i] = a[[i, k]], rows[i], rows[k]
        a[:, [k, j]] = a[:, [j, k]]
        a[k + 1 :] -= np.outer(a[k + 1 :, k] / a[k, k], a[k])
        rank += 1
    return rank, sorted(rows[rank:])


def mobility(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> Mobility:
    """Analyse the mobility at an assembled position z (nodes,) and its inputs (actuators,).

    Freedoms, drives and redundant constraints are judged at one and the same position: a regular one next to z.
    """
    jacobian = constraint_jacobian(mechanism)
    here = jacobian.ranks(z, inputs)
    coordinates = 2 * len(jacobian.free)
    found, z = _regular(jacobian, z, inputs, coordinates - here[0])
    table = jacobian.rows(jacobian.constraints, z, inputs)
    driven = np.vstack([table, jacobian.rows(jacobian.drives, z, inputs)])
    rank = full_pivoting(driven)[0] if driven.size else 0
    loose = _moving(jacobian, driven) if found > 0 and rank < coordinates else []
    names = tuple(a.name for a in mechanism.actuators)
    spare = full_pivoting(table)[1] if table.size else []
    return Mobility(
        gruebler(mechanism), here[0], found, coordinates - here[0],
        tuple(jacobian.constraints[k].name for k in spare), tuple(mechanism.nodes[n] for n in loose), names,
        _idle(jacobian, table, driven) if found > 0 else names, here[1] < rank,
    )  # fmt: skip


def _idle(jacobian: Jacobian, table: FloatArray, driven: FloatArray) -> tuple[str, ...]:
    """Return the actuators that add nothing to the constraints and the actuators before them."""
    fixed = {a.name for a in jacobian.mechanism.actuators} - {r.name for r in jacobian.drives}
    idle, rank = [], full_pivoting(table)[0] if table.size else 0
    for k, drive in enumerate(jacobian.drives, start=len(table) + 1):
        now = full_pivoting(driven[:k])[0]
        if now == rank:
            idle.append(drive.name)
        rank = now
    return tuple(a.name for a in jacobian.mechanism.actuators if a.name in {*idle, *fixed})


def _moving(jacobian: Jacobian, table: FloatArray) -> list[int]:
    """Return the nodes that the null space of a table moves, those that are only carried too."""
    motion = carry(jacobian.mechanism, jacobian.motions(table))
    return np.flatnonzero(np.linalg.norm(motion, axis=1) > MOVES).tolist()


def _regular(jacobian: Jacobian, z: ComplexArray, inputs: FloatArray, apparent: int) -> tuple[int, ComplexArray]:
    """Return the freedoms that neighbouring assembled positions confirm, and the neighbour where least is lost.

    A step is taken along motions that the Jacobian allows and the constraints are restored: where
    this leads back to the start, the motion was infinitesimal only.
    """
    best: tuple[tuple[int, int], ComplexArray] | None = None
    coordinates = 2 * len(jacobian.free)
    for step in STEPS if apparent else ():
        for number, there in enumerate(_neighbours(jacobian, z, inputs, step * jacobian.size), start=1):
            ranks = jacobian.ranks(there, inputs)
            if best is None or ranks > best[0]:
                best = ranks, there
            meeting = best[0][0] > coordinates - apparent  # of branches; the inputs may rest on the one found
            if number >= TRIALS and not (meeting and best[0][1] < coordinates):
                break
        if best is not None:
            return 2 * len(jacobian.free) - best[0][0], best[1]
    return 0, z


def _neighbours(jacobian: Jacobian, z: ComplexArray, inputs: FloatArray, step: float) -> Iterator[ComplexArray]:
    """Yield assembled positions about a step away from one."""
    null = jacobian.motions(jacobian.rows(jacobian.constraints, z, inputs))
    generator = np.random.default_rng(0)
    goal = np.array([measure(r, z, inputs) for r in jacobian.constraints])
    for _ in range(MORE):
        motion = null @ generator.standard_normal(null.shape[1])
        there = _restore(jacobian, z + step * motion / np.linalg.norm(motion), goal, inputs)
        if there is not None and BACK * step < np.linalg.norm(there - z) < ASTRAY * step:
            yield there


def _restore(jacobian: Jacobian, trial: ComplexArray, goal: FloatArray, inputs: FloatArray) -> ComplexArray | None:
    """Put a trial position on the constraints: measures as in goal; None where that fails."""
    z, error = _nearest(jacobian, trial, goal, inputs)
    return z if error < ASSEMBLED * jacobian.size else None


def _nearest(
    jacobian: Jacobian, trial: ComplexArray, goal: FloatArray, inputs: FloatArray
) -> tuple[ComplexArray, float]:
    """Return where Gauss-Newton by least motion ends, and the greatest error there; infinite where it diverges."""
    size = jacobian.size
    with np.errstate(all="ignore"):
        for _ in range(ITERATIONS):
            error = np.array([measure(r, trial, inputs) for r in jacobian.constraints]) - goal
            worst = float(np.max(np.abs(error), initial=0.0))
            if not np.isfinite(worst):
                return trial, np.inf
            if worst < ASSEMBLED * size:
                break
            step = np.linalg.lstsq(jacobian.slopes(jacobian.constraints, trial, inputs), error, rcond=1e-10)[0]
            trial = trial.copy()
            trial[jacobian.free] -= step[0::2] + 1j * step[1::2]
    return trial, worst


def check_driven(mechanism: Mechanism, found: Mobility) -> None:
    """Raise StructureError where the actuators do not fit the mobility."""
    count = len(found.actuators)
    if count and found.mobility == 0:
        raise StructureError(
            f"{mechanism.name} is a structure (mobility 0): actuator{'s' * (count != 1)}"
            f" {', '.join(found.actuators)} cannot move it; remove a member or the actuator"
        )
    if found.overdriven:
        loose = f"; nothing drives nodes {', '.join(found.undriven)}" if found.undriven else ""
        raise StructureError(
            f"over-driven: {count} actuators on a mechanism of mobility {found.mobility};"
            f" {', '.join(found.overdriven)} drives what is driven already: remove"
            f" {'it' if len(found.overdriven) == 1 else 'them'}{loose}"
        )
    if found.undriven:
        raise StructureError(
            f"nothing drives nodes {', '.join(found.undriven)}: mobility {found.mobility}, {count}"
            f" actuator{'s' * (count != 1)}; add an actuator for each freedom"
        )


def refuse_unfit(mechanism: Mechanism) -> None:
    """Raise StructureError where the actuators do not fit the mobility near the drawn position, if one is found."""
    found = judged(mechanism)
    if found is not None:
        check_driven(mechanism, found)


def judged(mechanism: Mechanism) -> Mobility | None:
    """Return the mobility near the drawn position; None where no assembled position is found near it."""
    z = assembled(mechanism)
    return None if z is None else mobility(mechanism, z, mechanism.drawn_inputs)


def assembled(mechanism: Mechanism) -> ComplexArray | None:
    """Return an assembled position near the drawn one, the inputs left free; None where none is found.

    Gauss-Newton from the drawing, and where that does not converge from the drawing disturbed more and more.
    """
    jacobian, inputs = constraint_jacobian(mechanism), mechanism.drawn_inputs
    goal = np.array([_target(r) for r in jacobian.constraints])
    generator = np.random.default_rng(0)
    for k in range(STARTS):
        start = mechanism.drawn.copy()
        noise = generator.standard_normal((2, len(jacobian.free))) * jacobian.size * k / STARTS
        start[jacobian.free] += noise[0] + 1j * noise[1]
        z, error = _nearest(jacobian, start, goal, inputs)
        if error < ASSEMBLED * jacobian.size and _fulfilled(mechanism, carry(mechanism, z), inputs):
            return carry(mechanism, z)
        if k == 0 and ASSEMBLED < error / jacobian.size < ALMOST:
            return None  # the drawn position contradicts itself by little: another one would not stand for it
    return None


def _fulfilled(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> bool:
    """Tell whether a position fulfils what is not an actuator's, the sense of blocks and elements included."""
    drives = {a.name for a in mechanism.actuators}
    found = (float(error[0]) for name, _, error in errors(mechanism, z[:, None], inputs[:, None]) if name not in drives)
    return all(error <= NEAR for error in found)


def _target(restriction: Restriction) -> float:
    return 0.0 if restriction.kind == ANGLE else restriction.value.constant
