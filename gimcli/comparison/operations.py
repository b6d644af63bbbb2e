"""Operations of a sweep and of an iteration: the count of Petuya et al. 2004, and the actual number.

The paper counts 12 operations per moving node and sweep (two distances with six operations each), and 9 E^3 per
iteration of Newton-Raphson on E moving links (a third of (3 E)^3 for the elimination).
The actual number counts each addition, subtraction, multiplication, division, square root, sine and cosine;
comparisons, signs and absolute values are not counted. It includes every part of a sweep or iteration: for sweeps
the errors of the stopping test; for Newton-Raphson the equations, the Jacobian, the elimination (2 n^3 / 3, or
Householder reflections if there are redundant equations) and the solution.
"""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.comparison.bodies import AbsoluteCoordinates, BodyPair
from gimcli.comparison.coordinates import JointCoordinates, NaturalCoordinates
from gimcli.gim.sequence import known_nodes
from gimcli.kernels import bodies, points
from gimcli.mechanism import ANGLE, CLOSURE, FRAME, HEIGHT, SPAN, Mechanism
from gimcli.structure.kinematic_nodes import free_nodes
from gimcli.structure.restrictions import Move
from gimcli.structure.steps import NONE, Constraint, Coupled, Dyad, Orient, Place, Plan, Tilt, Vector

MULTIPLY = 6
"""Operations of a product of two complex numbers."""

TURN = MULTIPLY + 1
"""Operations of the rotation of a complex number by an input, in either sense."""

GUARD = 12
"""Operations for the error, the quality and the branch of one closed form."""


@dataclass(frozen=True)
class Cost:
    """Operations of one position: a constant part, and a part for each sweep or iteration."""

    unknowns: tuple[int, ...]  # of each system that is solved; for sweeps the coordinates that are moved
    position: float  # operations independent of the sweeps or iterations
    iterations: tuple[float, ...]  # operations of one sweep or iteration, of each system
    paper: float  # operations of one sweep or iteration as the paper counts them

    def operations(self, count: float) -> float:
        """Return the operations of a position with `count` sweeps or iterations.

        Path following reports the sum over all systems; an equal share is assumed for each system.
        """
        mean = sum(self.iterations) / len(self.iterations) if self.iterations else 0.0
        return self.position + count * mean


# -- counts of the paper ---------------------------------------------------------------------------


def moving_nodes(mechanism: Mechanism) -> int:
    """Return the number of nodes that sweeps move: free nodes that the inputs alone do not determine."""
    return len(set(free_nodes(mechanism)) - known_nodes(mechanism)[0])


def paper_sweep(mechanism: Mechanism) -> float:
    """Return 12 times the number of moving nodes. Source: Petuya et al. 2004, table 1."""
    return 12.0 * moving_nodes(mechanism)


def paper_iteration(mechanism: Mechanism) -> float:
    """Return 9 E^3 for E moving links. Source: Petuya et al. 2004, table 1."""
    return 9.0 * (len(mechanism.members) - 1 - FRAME) ** 3


# -- linear algebra -------------------------------------------------------------------------------


def elimination(m: int, n: int) -> float:
    """Return the operations to factor a full m x n matrix. Source: Golub & Van Loan, 3.2, 5.2."""
    return 2.0 * n**3 / 3.0 if m <= n else 2.0 * n**2 * (m - n / 3.0)


def substitution(m: int, n: int) -> float:
    """Return the operations to solve with the factors of a full m x n matrix."""
    return 2.0 * n**2 if m <= n else 4.0 * m * n - n**2


# -- sweeps ---------------------------------------------------------------------------------------


def sweep_cost(mechanism: Mechanism, moves: tuple[Move, ...]) -> Cost:
    """Return the operations of sweeps: each move, and then the error of its restriction."""
    check = float(sum(_check(m) for m in moves))
    sweep = float(sum(_move(m) for m in moves)) + check
    unknowns = 2 * len({m.node for m in moves})
    return Cost((unknowns,), check, (sweep,), paper_sweep(mechanism))


def _value(move: Move) -> int:
    return 2 if move.restriction.value.actuator != NONE else 0


def _move(move: Move) -> int:
    """Return the operations of one move in `gimcli.kernels.sweep.impose`."""
    r = move.restriction
    if r.kind == SPAN or r.vector is None:
        return 12 + _value(move)
    if r.kind == ANGLE:
        arm = move.node not in (r.p, r.q)
        return _vector(r.vector) + 15 + (2 + MULTIPLY if arm else 0)
    if move.node == r.p:
        return _vector(r.vector) + 17 + _value(move)
    return _vector(r.vector) + (23 if move.node == r.vector.u else 21) + _value(move)


def _check(move: Move) -> int:
    """Return the operations of one error in `gimcli.kernels.sweep.error_of`."""
    r = move.restriction
    if r.kind == SPAN or r.vector is None:
        return 8 + _value(move)
    return _vector(r.vector) + (19 if r.kind == ANGLE else 12) + _value(move)


# -- closed forms, and Newton-Raphson on base nodes --------------------------------------------------


def plan_cost(mechanism: Mechanism, plan: Plan, parts: int = 1) -> Cost:
    """Return the operations of a plan per step: closed forms and factors in each of `parts` rows, and iterations."""
    closed = sum(_closed(step) for step in plan.steps if not isinstance(step, Coupled))
    groups = plan.coupled
    factors = sum(group_factors(g) for g in groups)  # computed once per row if rows are some degrees apart
    position = parts * (2.0 * len(mechanism.actuators) + closed + factors)
    unknowns = tuple(2 * len(g.base) for g in groups)
    return Cost(unknowns, position, tuple(group_iteration(g) for g in groups), paper_iteration(mechanism))


def _closed(step: object) -> int:
    if isinstance(step, Place):
        return _vector(step.vector) + 2
    if isinstance(step, Orient):
        return _vector(step.vector)
    if isinstance(step, Tilt):
        return 2 + 23 + GUARD
    assert isinstance(step, Dyad)
    loci = (step.first, step.second)
    lines = sum(locus.kind == HEIGHT for locus in loci)
    return sum(_locus(locus) for locus in loci) + (47, 29, 25)[lines] + GUARD


def _locus(locus: Constraint) -> int:
    count = 2 if locus.value.actuator != NONE else 0
    count += _vector(locus.offset) + 2 if locus.offset is not None else 0
    return count + _vector(locus.vector)


def _vector(vector: Vector | None) -> int:
    if vector is None:
        return 0
    base = 2 + MULTIPLY if vector.u != NONE else MULTIPLY * (vector.register != NONE)
    return base + (TURN if vector.actuator != NONE else 0)


def group_factors(group: Coupled) -> float:
    """Return the operations of `gimcli.kernels.newton.factor`: the Jacobian and its elimination."""
    n, m = 2 * len(group.base), sum(e.rows for e in group.equations)
    return sum(_gradient(e, len(group.base)) for e in group.equations) + elimination(m, n)


def group_iteration(group: Coupled) -> float:
    """Return the operations of one correction in `gimcli.kernels.newton.newton` with factors already computed."""
    n, m = 2 * len(group.base), sum(e.rows for e in group.equations)
    carry = sum(_vector(p.vector) + 2 for p in group.places)
    return carry + sum(_equation(e) for e in group.equations) + substitution(m, n) + 2.5 * n


def _equation(e: Constraint) -> int:
    value = 2 if e.value.actuator != NONE else 0
    own = {SPAN: 9, HEIGHT: 6, CLOSURE: 4}[e.kind]
    return own + value + _vector(e.vector)


def _gradient(e: Constraint, base: int) -> int:
    vector = 0 if e.vector is None else _vector(e.vector) + (TURN if e.vector.actuator != NONE else 0)
    value = 2 if e.value.actuator != NONE else 0
    carried = 2 + MULTIPLY if e.vector is not None and e.vector.u != NONE else 0
    own = {SPAN: 8, HEIGHT: 14, CLOSURE: 4}[e.kind]
    return 2 + value + vector + base * (2 + carried + own)


# -- the reference coordinates ------------------------------------------------------------------------


def coordinates_cost(system: JointCoordinates | AbsoluteCoordinates | NaturalCoordinates) -> Cost:
    """Return the operations of a position in joint, absolute or natural coordinates."""
    if isinstance(system, NaturalCoordinates):
        position, rows = 2.0 * len(system.mechanism.actuators), _natural_rows(system)
    else:
        if isinstance(system, JointCoordinates):
            position, chains = _tree(system), _chains(system)
        else:
            position, chains = 2.0 * sum(map(system.bodies.turns, range(1, system.bodies.count))), 0
        rows = position + sum(_pair(p) for p in system.equated) + chains
    n, m = system.unknowns, system.equations
    iteration = rows + elimination(m, n) + substitution(m, n) + 2.0 * n
    return Cost((n,), position, (iteration,), paper_iteration(system.mechanism))


def _pair(pair: BodyPair) -> int:
    """Return the operations of one pair in `gimcli.kernels.bodies.pair_rows`."""
    own = {bodies.COINCIDENT: 18, bodies.ON_LINE: 38, bodies.ANGLE: 5, bodies.DISTANCE: 32}[pair.kind]
    return own + (pair.actuator != NONE)


def _tree(system: JointCoordinates) -> float:
    """Return the operations of `gimcli.kernels.bodies.place_tree`."""
    count = 0
    for joint in system.tree:
        values = (joint.angle, joint.travel) if joint.kind == bodies.HINGE else (joint.angle,)
        count += sum(2 * (motion.actuator != NONE) + motion.variable for motion in values)
        count += {bodies.HINGE: 41, bodies.RAM: 31, bodies.FREE: 25}[joint.kind]
    return float(count)


def _chains(system: JointCoordinates) -> int:
    """Return the operations to sum the partial derivatives along the tree: 7 per rotation, 4 per translation."""
    above = {joint.child: joint for joint in system.tree}
    count = 0
    for pair in system.equated:
        for body in (pair.a, pair.b):
            while body != FRAME:
                joint = above[body]
                turns = int(joint.angle.variable)
                count += pair.rows * (7 * turns + 4 * (joint.variables - turns))
                body = joint.parent
    return count


def _natural_rows(system: NaturalCoordinates) -> float:
    """Return the operations of the equations and gradients in `gimcli.kernels.points.point_rows`."""
    count = 0
    for kind, p, q, u, v, value, turning, _ in system.heads:
        ends = [int(system.columns[n] != NONE) for n in (p, q)]
        base = [int(u != NONE and system.columns[n] != NONE) for n in (u, v)]
        direction = (TURN if turning != NONE else 0) + (2 + MULTIPLY if u != NONE else 0)
        own = {points.DISTANCE: 9, points.RIGID: 4, points.LINE: 6}[kind] + (value != NONE)
        each = 2 * (sum(ends) + sum(base))
        lever = MULTIPLY if kind == points.LINE and u != NONE else 0
        count += own + lever + each * (2 if kind == points.RIGID else 1)
        count += direction if kind != points.DISTANCE else 0
    return float(count)
