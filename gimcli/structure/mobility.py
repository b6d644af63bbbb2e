"""Mobility: Grübler's count, the rank of the constraint Jacobian, redundant and undriven parts.

The Jacobian has one row for each restriction, in the coordinates of the free nodes. Elimination with full pivoting
determines its rank; the rows without a pivot are redundant (Fraczek & Wojtyra, section 1.3). A rank loss at a single
position is not a freedom: freedoms are confirmed at neighbouring assembled positions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.canonical import first_greatest, first_least
from gimcli.errors import StructureError
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, ComplexArray, FloatArray, Input, Mechanism
from gimcli.structure.coupled_rows import CoupledRow
from gimcli.structure.derived import derived
from gimcli.structure.gradients import gradient, measure
from gimcli.structure.kinematic_nodes import carry, free_nodes, kinematic_nodes, loose_nodes
from gimcli.structure.residual import errors
from gimcli.structure.restrictions import Restriction, member_models, pair_restrictions
from gimcli.structure.rotation import members_of

ROUNDING = 1e-14
"""A gradient in the normal frame below this is 0, such as that of an angle that other constraints keep constant."""

RANK = 1e-8
"""A pivot below this fraction of the greatest is 0; rows are scaled to length 1."""

STEPS = (1e-2, 1e-3, 1e-4)
"""Lengths of the step to a neighbouring position, relative to the size, tried in this order."""

TRIALS, MORE = 4, 40
"""Number of neighbouring positions; greater if branches meet and none was found on a branch that the inputs drive."""

EXTENT = 4.0
"""The size is limited to this multiple of the greatest member, because nodes may be drawn far away."""

NEAREST, FARTHEST = 0.1, 10.0
"""Range of the distance to a neighbour, in steps: below, it is the same position; above, an unrelated one."""

ASSEMBLED, ALMOST = 1e-13, 0.1
"""Error of the constraints, relative to the size, of an assembled position, and of slightly inconsistent dimensions."""

ITERATIONS = 60
"""Iterations of Gauss-Newton."""

STARTS = 24
"""Number of initial positions, with increasing random perturbation, for the search of an assembled position."""

NEAR = 1e-6
"""Tolerance of the final check, relative or in rad; a block rotated by 180 deg has an error of pi."""

MOVES = 1e-6
"""In a motion of length 1, a node that moves by less is fixed."""

Rows = Sequence[Restriction | CoupledRow]
"""Constraints of positions."""


@dataclass(frozen=True)
class Mobility:
    """Mobility, redundant constraints and drives at one assembled position."""

    gruebler: int  # Grübler's count
    rank: int  # of the constraint Jacobian at the position, without actuators
    mobility: int  # number of confirmed freedoms
    apparent: int  # coordinates minus rank at the position
    redundant: tuple[str, ...]  # names of the redundant constraints
    undriven: tuple[str, ...]  # nodes that can move while all inputs are constant
    actuators: tuple[str, ...]  # names of all actuators
    overdriven: tuple[str, ...]  # actuators of freedoms that are already driven or constrained
    stuck: bool  # constraints and inputs have a lower rank at the position than next to it

    @property
    def singular(self) -> bool:
        """Whether the rank of the constraints at this position is lower than next to it."""
        return self.apparent != self.mobility


def of_machines(parts: Sequence[Mobility]) -> Mobility:
    """Return the mobility of independent machines together."""
    if len(parts) == 1:
        return parts[0]

    def total(name: str) -> Any:
        return sum((getattr(part, name) for part in parts[1:]), start=getattr(parts[0], name))

    joined = {field.name: total(field.name) for field in fields(Mobility)}
    return Mobility(**{**joined, "stuck": any(part.stuck for part in parts)})


def gruebler(mechanism: Mechanism) -> int:
    """Return Grübler's count 3 L + 2 N - 2 J - C.

    L: moving members. N: nodes of sliding pairs or actuators without a member. J: revolute pairs, k-1 at a node of k
    members. C: constraints of sliding pairs, and couplings of inputs.
    """
    members = members_of(mechanism)
    moving = len(mechanism.members) - 1
    pairs = sum(len(at) - 1 for at in members if len(at) > 1)
    rows = len(mechanism.pairs) - 2 * len(loose_nodes(mechanism))
    return 3 * moving - 2 * pairs - rows - len(mechanism.couplings)


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
            for node, g in _gradient(restriction, z, inputs).items():
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
        at = np.unravel_index(first_greatest(np.abs(a[k:, k:]).ravel()), a[k:, k:].shape)
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

    If z is singular, freedoms, drives and redundant constraints are evaluated at a regular position next to it.
    """
    mechanism, z = mechanism.nearby, mechanism.near(z)
    jacobian = constraint_jacobian(mechanism)
    here = jacobian.ranks(z, inputs)
    coordinates = 2 * len(jacobian.free)
    found, z = _regular(jacobian, z, inputs, coordinates - here[0])
    table = jacobian.rows(jacobian.constraints, z, inputs)
    driven = np.vstack([table, jacobian.rows(jacobian.drives, z, inputs)])
    rank = full_pivoting(driven)[0] if driven.size else 0
    loose = _moving(jacobian, driven) if found > 0 and rank < coordinates else []
    names = tuple(mechanism.actuators[k].name for k in mechanism.drivers)
    spare = full_pivoting(table)[1] if table.size else []
    return Mobility(
        gruebler(mechanism), here[0], found, coordinates - here[0],
        tuple(jacobian.constraints[k].name for k in spare), tuple(mechanism.nodes[n] for n in loose), names,
        _redundant_actuators(jacobian, table, driven) if found > 0 else names, here[1] < rank,
    )  # fmt: skip


def _redundant_actuators(jacobian: Jacobian, table: FloatArray, driven: FloatArray) -> tuple[str, ...]:
    """Return the actuators that do not increase the rank of the constraints and the actuators before them."""
    own = [jacobian.mechanism.actuators[k] for k in jacobian.mechanism.drivers]
    fixed = {a.name for a in own} - {r.name for r in jacobian.drives}
    redundant, rank = [], full_pivoting(table)[0] if table.size else 0
    for k, drive in enumerate(jacobian.drives, start=len(table) + 1):
        now = full_pivoting(driven[:k])[0]
        if now == rank:
            redundant.append(drive.name)
        rank = now
    return tuple(a.name for a in own if a.name in {*redundant, *fixed})


def _moving(jacobian: Jacobian, table: FloatArray) -> list[int]:
    """Return the nodes, including carried ones, that move in the null space of a table of gradients."""
    motion = carry(jacobian.mechanism, jacobian.motions(table))
    return np.flatnonzero(np.linalg.norm(motion, axis=1) > MOVES).tolist()


def _regular(jacobian: Jacobian, z: ComplexArray, inputs: FloatArray, apparent: int) -> tuple[int, ComplexArray]:
    """Return the freedoms confirmed at neighbouring assembled positions, and the neighbour of greatest rank.

    A neighbour is found by a step along a motion in the null space of the Jacobian, then by restoring the constraints.
    If this returns to the start position, the motion was only infinitesimal.
    """
    best: tuple[tuple[int, int], ComplexArray] | None = None
    coordinates = 2 * len(jacobian.free)
    for step in STEPS if apparent else ():
        for number, there in enumerate(_neighbours(jacobian, z, inputs, step * jacobian.size), start=1):
            ranks = jacobian.ranks(there, inputs)
            if best is None or ranks > best[0]:
                best = ranks, there
            meeting = best[0][0] > coordinates - apparent  # branches meet; on the one found the inputs may be constant
            if number >= TRIALS and not (meeting and best[0][1] < coordinates):
                break
        if best is not None:
            return 2 * len(jacobian.free) - best[0][0], best[1]
    return 0, z


def _neighbours(jacobian: Jacobian, z: ComplexArray, inputs: FloatArray, step: float) -> Iterator[ComplexArray]:
    """Yield assembled positions at a distance of about `step` from z."""
    null = jacobian.motions(jacobian.rows(jacobian.constraints, z, inputs))
    generator = np.random.default_rng(0)
    goal = np.array([_measure(r, z, inputs) for r in jacobian.constraints])
    for _ in range(MORE):
        motion = null @ generator.standard_normal(null.shape[1])
        there = _restore(jacobian, z + step * motion / np.linalg.norm(motion), goal, inputs)
        if there is not None and NEAREST * step < np.linalg.norm(there - z) < FARTHEST * step:
            yield there


def _restore(jacobian: Jacobian, trial: ComplexArray, goal: FloatArray, inputs: FloatArray) -> ComplexArray | None:
    """Return the assembled position found from a trial position, with constraint values `goal`; None if that fails."""
    z, error = _nearest(jacobian, trial, goal, inputs)
    return z if error < ASSEMBLED * jacobian.size else None


def _nearest(
    jacobian: Jacobian, trial: ComplexArray, goal: FloatArray, inputs: FloatArray
) -> tuple[ComplexArray, float]:
    """Return the final position of Gauss-Newton with least-norm steps, and its greatest error (inf if it diverges)."""
    size = jacobian.size
    with np.errstate(all="ignore"):
        for _ in range(ITERATIONS):
            error = np.array([_measure(r, trial, inputs) for r in jacobian.constraints]) - goal
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
    """Raise StructureError if the actuators do not match the mobility."""
    count = len(found.actuators)
    if count and found.mobility == 0:
        raise StructureError(
            f"{mechanism.name} is a structure (mobility 0): actuator{'s' * (count != 1)}"
            f" {', '.join(found.actuators)} cannot move it; remove a member or the actuator"
        )
    if found.overdriven:
        loose = f"; nothing drives nodes {', '.join(found.undriven)}" if found.undriven else ""
        one = len(found.overdriven) == 1
        raise StructureError(
            f"over-driven: {count} actuators on a mechanism of mobility {found.mobility};"
            f" {', '.join(found.overdriven)} {'is' if one else 'are'} redundant (the same freedom is already driven):"
            f" remove {'it' if one else 'them'}{loose}"
        )
    if found.undriven:
        raise StructureError(
            f"nothing drives nodes {', '.join(found.undriven)}: mobility {found.mobility},"
            f" {count or 'no'} actuator{'s' * (count > 1)}; fix nodes in `ground`, or add an actuator for each freedom"
            f"{_cure(mechanism, found)}"
        )


def _guide(mechanism: Mechanism, one: Input) -> str:
    """Return the names of the two nodes on the line of a travel."""
    member = mechanism.members[one.guide]
    rays = (member.shape - one.point) * np.conj(one.normal)
    first = first_least(np.abs(rays), RANK * mechanism.size)
    slopes = np.array([9.0 if k == first else abs(ray.imag) / abs(ray) for k, ray in enumerate(rays)])
    return ", ".join(mechanism.nodes[member.nodes[k]] for k in (first, first_least(slopes, RANK)))


def _cure(mechanism: Mechanism, found: Mobility) -> str:
    """Return the lines that a mechanism with freedoms may lack: an actuator, or the pair of a node on a guide."""
    for one in mechanism.actuators:
        node = mechanism.nodes[one.node]
        held = any(one.node in row.nodes and row.guide == one.guide for row in mechanism.slides)
        if one.kind == HEIGHT and not held and node in found.undriven:
            text = f"; '{one.name}' measures the travel of node {node}, which is not held on the guide"
            return f"{text}: add `prismatic: {{slide: {{node: {node}, guide: [{_guide(mechanism, one)}]}}}}`"
    ground = set(mechanism.members[FRAME].nodes)
    for member in () if found.actuators else mechanism.members[1:]:
        pivots = [n for n in member.nodes if n in ground]
        arms = [n for n in member.nodes if mechanism.nodes[n] in found.undriven]
        if pivots and arms:
            pivot, arm = mechanism.nodes[pivots[0]], mechanism.nodes[arms[0]]
            return f", for example `actuators: {{motor: {{pivot: {pivot}, arm: {arm}}}}}`"
    return ""


def require_driven(mechanism: Mechanism) -> None:
    """Raise StructureError if the actuators do not match the mobility near the drawn position.

    Nothing is checked if no assembled position is found there.
    """
    found = drawn_mobility(mechanism)
    if found is not None:
        check_driven(mechanism, found)


def drawn_mobility(mechanism: Mechanism) -> Mobility | None:
    """Return the mobility near the drawn position; None if no assembled position is found there."""
    found = []
    for one in (machine.mechanism for machine in mechanism.machines):
        z = assembled(one)
        if z is None:
            return None
        found.append(mobility(one, z, one.drawn_inputs))
    return of_machines(found)


def assembled(mechanism: Mechanism) -> ComplexArray | None:
    """Return an assembled position (nodes,) near the drawn one, with any inputs; None if none is found.

    Gauss-Newton starts from the drawn position, then from increasing random perturbations of it.
    """
    near, inputs = mechanism.nearby, mechanism.drawn_inputs
    jacobian = constraint_jacobian(near)
    goal = np.array([_target(r) for r in jacobian.constraints])
    generator = np.random.default_rng(0)
    for k in range(STARTS):
        start = near.drawn.copy()
        noise = generator.standard_normal((2, len(jacobian.free))) * jacobian.size * k / STARTS
        start[jacobian.free] += noise[0] + 1j * noise[1]
        z, error = _nearest(jacobian, start, goal, inputs)
        if error < ASSEMBLED * jacobian.size and _fulfilled(near, carry(near, z), inputs):
            return mechanism.whole(carry(near, z))
        if k == 0 and ASSEMBLED < error / jacobian.size < ALMOST:
            return None  # slightly inconsistent dimensions: a distant position would not represent the drawn one
    return None


def _fulfilled(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> bool:
    """Return whether a position satisfies all constraints except inputs, including the sense of blocks and elements."""
    drives = {a.name for a in mechanism.actuators}
    found = (float(error[0]) for name, _, error in errors(mechanism, z[:, None], inputs[:, None]) if name not in drives)
    return all(error <= NEAR for error in found)


def _target(restriction: Restriction | CoupledRow) -> float:
    """Return the value of a constraint; that of a coupling is 0 as drawn."""
    return 0.0 if isinstance(restriction, CoupledRow) or restriction.kind == ANGLE else restriction.value.constant


def _gradient(restriction: Restriction | CoupledRow, z: ComplexArray, inputs: FloatArray) -> dict[int, complex]:
    return restriction.gradient(z) if isinstance(restriction, CoupledRow) else gradient(restriction, z, inputs)


def _measure(restriction: Restriction | CoupledRow, z: ComplexArray, inputs: FloatArray) -> float:
    return restriction.measure(z) if isinstance(restriction, CoupledRow) else measure(restriction, z, inputs)
