"""Mobility: Grübler's count, the rank of the constraint Jacobian, redundant and undriven parts.

The Jacobian holds one row a restriction in the coordinates of the free nodes. Elimination with full
pivoting tells its rank, the rows without a pivot are the redundant ones (Fraczek & Wojtyra, section
1.3). A rank loss at one position alone is not a freedom: it is confirmed at assembled neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.errors import StructureError
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.structure.kinematic import kinematic_nodes, loose_nodes
from gimcli.structure.restrictions import Restriction, gradient, measure, member_models, pair_restrictions
from gimcli.structure.rotation import members_of

RANK = 1e-8
"""A pivot below this part of the greatest is none: rows are scaled to length 1."""

STEP = 1e-2
"""Length of the step to a neighbouring position, relative to the size."""


@dataclass(frozen=True)
class Mobility:
    """What the count and the rank say at one assembled position."""

    gruebler: int
    rank: int  # of the constraint Jacobian at the position, actuators left out
    mobility: int  # confirmed freedoms
    apparent: int  # coordinates minus rank at the position
    redundant: tuple[str, ...]  # names of the surplus constraints
    undriven: tuple[str, ...]  # nodes that can still move with all actuators held
    actuators: int
    overdriven: tuple[str, ...]  # actuators that drive what is driven or held already

    @property
    def singular(self) -> bool:
        """Tell whether the rank at this position is lower than next to it."""
        return self.apparent != self.mobility


def gruebler(mechanism: Mechanism) -> int:
    """Return 3 L - 2 J: k members at a node are k-1 pairs, a pin in a slot takes one freedom."""
    members = members_of(mechanism)
    moving = len(mechanism.members) - 1
    pairs = sum(len(at) - 1 for at in members if len(at) > 1)
    slides = len(mechanism.slides) - 2 * len(loose_nodes(mechanism))
    return 3 * moving - 2 * pairs - slides


class Jacobian:
    """The restrictions of a mechanism and their gradients in the coordinates of the free nodes."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        kinematic = kinematic_nodes(mechanism)
        frame = set(mechanism.members[FRAME].nodes)
        active = {n for nodes in kinematic for n in nodes} | set(loose_nodes(mechanism))
        self.free = [n for n in range(len(mechanism.nodes)) if n in active and n not in frame]
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

    def rows(self, restrictions: list[Restriction], z: ComplexArray, inputs: FloatArray) -> FloatArray:
        """Return the gradients, each row scaled to length 1."""
        table = np.zeros((len(restrictions), 2 * len(self.free)))
        for k, restriction in enumerate(restrictions):
            for node, g in gradient(restriction, z, inputs).items():
                if node in self.column:
                    at = self.column[node]
                    table[k, at : at + 2] += g.real, g.imag
        norm = np.linalg.norm(table, axis=1, keepdims=True)
        return np.asarray(table / np.where(norm > 0.0, norm, 1.0))


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
    """Analyse the mobility at an assembled position z (nodes,) and its inputs (actuators,)."""
    jacobian = Jacobian(mechanism)
    table = jacobian.rows(jacobian.constraints, z, inputs)
    coordinates = 2 * len(jacobian.free)
    rank, spare = full_pivoting(table) if table.size else (0, [])
    apparent = coordinates - rank
    found, z = _confirmed(jacobian, z, inputs, apparent)
    if found not in (0, apparent):  # names are told where the position is not singular
        table = jacobian.rows(jacobian.constraints, z, inputs)
        spare = full_pivoting(table)[1]
    driven = np.vstack([table, jacobian.rows(jacobian.drives, z, inputs)])
    held = full_pivoting(driven)[0] if driven.size else 0
    loose = _moving(jacobian, driven) if held < coordinates and found > 0 else []
    over = _idle(jacobian, table, driven)
    return Mobility(
        gruebler(mechanism), rank, found, apparent, tuple(jacobian.constraints[k].name for k in spare),
        tuple(mechanism.nodes[n] for n in loose), len(mechanism.actuators),
        over,
    )  # fmt: skip


def _idle(jacobian: Jacobian, table: FloatArray, driven: FloatArray) -> tuple[str, ...]:
    """Return the actuators that add nothing to the constraints and the actuators before them."""
    idle, rank = [], full_pivoting(table)[0] if table.size else 0
    for k, drive in enumerate(jacobian.drives, start=len(table) + 1):
        now = full_pivoting(driven[:k])[0]
        if now == rank:
            idle.append(drive.name)
        rank = now
    return tuple(idle)


def _moving(jacobian: Jacobian, table: FloatArray) -> list[int]:
    """Return the nodes that the null space of a table moves."""
    _, s, v = np.linalg.svd(table)
    rank = int(np.sum(s > RANK * max(float(s[0]), 1e-300)))
    motion = np.linalg.norm(v[rank:].reshape(-1, len(jacobian.free), 2), axis=(0, 2))
    return [n for n, m in zip(jacobian.free, motion, strict=True) if m > 1e-6]


def _confirmed(jacobian: Jacobian, z: ComplexArray, inputs: FloatArray, apparent: int) -> tuple[int, ComplexArray]:
    """Return the freedoms that neighbouring assembled positions confirm, and the neighbour with the least.

    A step is taken along motions that the Jacobian allows and the constraints are restored: where
    this leads back to the start, the motion was infinitesimal only.
    """
    if apparent == 0:
        return 0, z
    table = jacobian.rows(jacobian.constraints, z, inputs)
    _, s, v = np.linalg.svd(table)
    null = v[int(np.sum(s > RANK * max(float(s[0]), 1e-300))) :] if len(s) else np.eye(2 * len(jacobian.free))
    generator = np.random.default_rng(0)
    home = np.array([measure(r, z, inputs) for r in jacobian.constraints])
    step = STEP * jacobian.mechanism.size
    least: tuple[int, ComplexArray] | None = None
    for _ in range(4):
        motion = generator.standard_normal(len(null)) @ null
        trial = z.copy()
        trial[jacobian.free] += step * (motion[0::2] + 1j * motion[1::2]) / np.linalg.norm(motion)
        there = _restore(jacobian, trial, home, inputs)
        if there is None or np.linalg.norm(there - z) < 0.1 * step:
            continue
        rank, _ = full_pivoting(jacobian.rows(jacobian.constraints, there, inputs))
        freedoms = 2 * len(jacobian.free) - rank
        if least is None or freedoms < least[0]:
            least = freedoms, there
    return least if least is not None else (0, z)


def _restore(jacobian: Jacobian, trial: ComplexArray, goal: FloatArray, inputs: FloatArray) -> ComplexArray | None:
    """Put a trial position on the constraints: measures as in goal (Gauss-Newton, least motion)."""
    with np.errstate(all="ignore"):
        for _ in range(60):
            error = np.array([measure(r, trial, inputs) for r in jacobian.constraints]) - goal
            if not np.all(np.isfinite(error)):
                return None
            if np.max(np.abs(error), initial=0.0) < 1e-13 * jacobian.mechanism.size:
                return trial
            table = np.zeros((len(error), 2 * len(jacobian.free)))
            for k, r in enumerate(jacobian.constraints):
                for node, g in gradient(r, trial, inputs).items():
                    if node in jacobian.column:
                        at = jacobian.column[node]
                        table[k, at : at + 2] += g.real, g.imag
            step = np.linalg.lstsq(table, error, rcond=1e-10)[0]
            trial = trial.copy()
            trial[jacobian.free] -= step[0::2] + 1j * step[1::2]
    return None


def check_driven(mechanism: Mechanism, found: Mobility) -> None:
    """Raise StructureError where the actuators do not fit the mobility."""
    count = found.actuators
    if count and found.mobility == 0:
        raise StructureError(
            f"{mechanism.name} is a structure (mobility 0): actuator{'s' * (count != 1)}"
            f" {', '.join(a.name for a in mechanism.actuators)} cannot move it; remove a member or the actuator"
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


def assembled(mechanism: Mechanism) -> ComplexArray | None:
    """Return the assembled position nearest to the drawn one, the inputs left free (Gauss-Newton)."""
    jacobian = Jacobian(mechanism)
    inputs = np.array([a.drawn for a in mechanism.actuators], dtype=float)
    goal = np.array([_target(r) for r in jacobian.constraints])
    return _restore(jacobian, mechanism.drawn.copy(), goal, inputs)


def _target(restriction: Restriction) -> float:
    return 0.0 if restriction.kind == "RA" else restriction.value.constant
