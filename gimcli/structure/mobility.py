"""Mobility: Grübler's count, the rank of the constraint Jacobian, redundant and undriven parts.

The Jacobian has one row for each restriction, in the coordinates of the free nodes. Elimination with full pivoting
determines its rank; the rows without a pivot are redundant (Fraczek & Wojtyra, section 1.3). A rank loss at a single
position is not a freedom: freedoms are confirmed at neighbouring assembled positions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from itertools import islice, product
from typing import Any

import numpy as np

from gimcli.canonical import first_least
from gimcli.errors import StructureError, refuse
from gimcli.mechanism import FRAME, HEIGHT, ComplexArray, FloatArray, Input, Mechanism
from gimcli.structure.branch_mobility import Branch, branches
from gimcli.structure.constraint_jacobian import ALMOST, ASSEMBLED, RANK, constraint_jacobian, dependent
from gimcli.structure.derived import derived
from gimcli.structure.joints import joints
from gimcli.structure.kinematic_nodes import carry, loose_nodes
from gimcli.structure.residual import errors

MOST = 64
"""Most combinations of the branches of independent machines."""

STARTS = 24
"""Number of initial positions, with increasing random perturbation, for the search of an assembled position."""

NEAR = 1e-6
"""Tolerance of the final check, relative or in rad; a block rotated by 180 deg has an error of pi."""


@dataclass(frozen=True)
class Mobility:
    """Mobility, redundant constraints and drives at one assembled position."""

    gruebler: int  # Grübler's count
    rank: int  # of the constraint Jacobian at the position, without actuators
    mobility: int  # number of freedoms of the branch that has most
    apparent: int  # coordinates minus rank at the position
    redundant: tuple[str, ...]  # names of the redundant constraints
    alternatives: tuple[tuple[str, ...], ...]  # for each of these, others that could take its place
    undriven: tuple[str, ...]  # nodes that can move while all inputs are constant
    actuators: tuple[str, ...]  # names of all actuators
    overdriven: tuple[str, ...]  # actuators of freedoms that are already driven or constrained
    stuck: bool  # constraints and inputs have a lower rank at the position than next to it
    branches: tuple[Branch, ...]  # through the position, as far as they differ; that of the drives first

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
    combined = islice(product(*(part.branches for part in parts)), MOST)
    mixed = tuple(
        Branch(*(sum(one, start=type(one[0])()) for one in zip(*map(astuple, own), strict=True))) for own in combined
    )
    return Mobility(**{**joined, "stuck": any(part.stuck for part in parts), "branches": mixed})


def gruebler(mechanism: Mechanism) -> int:
    """Return Grübler's count 3 L + 2 N - C.

    L: moving members. N: nodes of sliding pairs or actuators without a member. C: constraints of the joints, 3 less the
    freedoms that each leaves, and couplings of inputs.
    """
    bodies = 3 * (len(mechanism.members) - 1) + 2 * len(loose_nodes(mechanism))
    held = sum(joint.pairs * (3 - len(joint.kind)) for joint in joints(mechanism))
    return bodies - held - len(mechanism.couplings)


def mobility(mechanism: Mechanism, z: ComplexArray, enough: bool = False) -> Mobility:
    """Analyse the mobility at an assembled position z (nodes,).

    Freedoms, drives and redundant constraints are those of the branches through z, at positions next to it; drives are
    judged on the branch that they move. enough: the first such branch is enough.
    """
    mechanism, z = mechanism.nearby, mechanism.near(z)
    jacobian = constraint_jacobian(mechanism)
    here = jacobian.ranks(z)
    coordinates = 2 * len(jacobian.free)
    names = tuple(mechanism.actuators[k].name for k in mechanism.drivers)
    found: dict[Branch, ComplexArray] = {}
    for one, there in branches(jacobian, z):
        found[one] = there
        if enough and one.driven:
            break
    found = found or {Branch(0, (), names): z}
    judged = min(found, key=lambda one: (len(one.overdriven) + bool(one.undriven), -one.mobility))
    names_of = jacobian.names
    spare = dependent(jacobian.rows(found[judged]))
    return Mobility(
        gruebler(mechanism), here[0], max(one.mobility for one in found), coordinates - here[0],
        tuple(names_of[k] for k in spare), tuple(tuple(names_of[k] for k in own) for own in spare.values()),
        judged.undriven, names, judged.overdriven, here[1] < jacobian.ranks(found[judged])[1],
        tuple(sorted(found, key=lambda one: (one is not judged, -one.mobility))),
    )  # fmt: skip


def check_driven(mechanism: Mechanism, found: Mobility) -> None:
    """Raise StructureError if the actuators do not match the mobility."""
    count, one = len(found.actuators), len(found.overdriven) == 1
    loose = f"nothing drives nodes {', '.join(found.undriven)}"
    refuse(
        (count and found.mobility == 0,
         f"{mechanism.name} is a structure (mobility 0): actuator{'s' * (count != 1)} {', '.join(found.actuators)}"
         " cannot move it; remove a member or the actuator"),
        (found.overdriven,
         f"over-driven: {count} actuator{'s' * (count != 1)} on a mechanism of mobility {found.mobility};"
         f" {', '.join(found.overdriven)} {'is' if one else 'are'} redundant (the same freedom is already driven):"
         f" remove {'it' if one else 'them'}{f'; {loose}' if found.undriven else ''}"),
        (found.undriven,
         f"{loose}: mobility {found.mobility}, {count or 'no'} actuator{'s' * (count > 1)}; fix nodes in `ground`, or"
         f" add an actuator for each freedom{_cure(mechanism, found)}"),
        error=StructureError,
    )  # fmt: skip


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


@derived
def drawn_mobility(mechanism: Mechanism) -> Mobility | None:
    """Return the mobility near the drawn position; None if no assembled position is found there."""
    found = []
    for one in (machine.mechanism for machine in mechanism.machines):
        z = assembled(one)
        if z is None:
            return None
        found.append(mobility(one, z, enough=True))
    return of_machines(found)


def assembled(mechanism: Mechanism) -> ComplexArray | None:
    """Return an assembled position (nodes,) near the drawn one, with any inputs; None if none is found.

    Gauss-Newton starts from the drawn position, then from increasing random perturbations of it.
    """
    near, inputs = mechanism.nearby, mechanism.drawn_inputs
    jacobian = constraint_jacobian(near)
    generator = np.random.default_rng(0)
    for k in range(STARTS):
        start = near.drawn.copy()
        noise = generator.standard_normal((2, len(jacobian.free))) * jacobian.size * k / STARTS
        start[jacobian.free] += noise[0] + 1j * noise[1]
        z, error = jacobian.nearest(start, jacobian.goal)
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
