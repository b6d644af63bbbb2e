"""What a sweep and an iteration cost: as Petuya et al. 2004 count it, and as it is.

The paper counts 12 operations a moving node and sweep (two distances, six operations each) against
9 E^3 an iteration of Newton-Raphson on E moving links (a third of (3 E)^3 for the elimination).
Here an operation is an addition, subtraction, multiplication, division, square root, sine or
cosine; comparisons, signs and absolute values are free. Everything that one sweep or iteration does
is counted: with sweeps the errors by which they end, with Newton-Raphson the equations, the
Jacobian, the elimination (2 n^3 / 3, or reflections where equations are surplus) and the solution.
"""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.comparison.absolute import AbsoluteCoordinates
from gimcli.comparison.joint import JointCoordinates
from gimcli.comparison.natural import NaturalCoordinates
from gimcli.comparison.pairs import BodyPair
from gimcli.gim.sequence import known_nodes
from gimcli.kernels import bodies, points
from gimcli.mechanism import ANGLE, CLOSURE, FRAME, HEIGHT, SPAN, Mechanism
from gimcli.structure.kinematic_nodes import free_nodes
from gimcli.structure.restrictions import Move
from gimcli.structure.steps import NONE, Circle, Constraint, Coupled, Dyad, Line, Orient, Place, Plan, Tilt, Vector

MULTIPLY = 6
"""A product of two complex numbers."""

TURN = MULTIPLY + 1
"""A complex number turned by an input, either way."""

GUARD = 12
"""Error, quality and branch of one closed form."""


@dataclass(frozen=True)
class Cost:
    """What one position costs: a part of its own, and a part for every sweep or iteration."""

    unknowns: tuple[int, ...]  # of every system that is solved; of a sweep, the coordinates moved
    position: float
    iterations: tuple[float, ...]  # of every system, for one sweep or iteration
    paper: float  # as the paper counts one sweep or iteration

    def operations(self, count: float) -> float:
        """Return the operations of a position with this many sweeps or iterations.

        They are counted over all systems together, as path following tells them: each takes its even part.
        """
        mean = sum(self.iterations) / len(self.iterations) if self.iterations else 0.0
        return self.position + count * mean


# -- the paper's counts ---------------------------------------------------------------------------


def moving_nodes(mechanism: Mechanism) -> int:
    """Count the nodes that sweeps move: neither on the frame nor carried by an input, nor merely carried."""
    return len(set(free_nodes(mechanism)) - known_nodes(mechanism)[0])


def paper_sweep(mechanism: Mechanism) -> float:
    """Return 12 nnod. Source: Petuya et al. 2004, table 1."""
    return 12.0 * moving_nodes(mechanism)


def paper_iteration(mechanism: Mechanism) -> float:
    """Return 9 E^3, E the moving links. Source: Petuya et al. 2004, table 1."""
    return 9.0 * (len(mechanism.members) - 1 - FRAME) ** 3


# -- linear algebra -------------------------------------------------------------------------------


def elimination(m: int, n: int) -> float:
    """Return what factoring a full table of m equations in n unknowns takes. Source: Golub & Van Loan, 3.2, 5.2."""
    return 2.0 * n**3 / 3.0 if m <= n else 2.0 * n**2 * (m - n / 3.0)


def substitution(m: int, n: int) -> float:
    """Return what a solution with the factors takes."""
    return 2.0 * n**2 if m <= n else 4.0 * m * n - n**2


# -- sweeps ---------------------------------------------------------------------------------------


def sweep_cost(mechanism: Mechanism, moves: tuple[Move, ...]) -> Cost:
    """Return what sweeping costs: every move, and the error of its restriction afterwards."""
    check = float(sum(_check(m) for m in moves))
    sweep = float(sum(_move(m) for m in moves)) + check
    unknowns = 2 * len({m.node for m in moves})
    return Cost((unknowns,), check, (sweep,), paper_sweep(mechanism))


def _value(move: Move) -> int:
    return 2 if move.restriction.value.actuator != NONE else 0


def _direction(vector: Vector) -> int:
    turned = TURN if vector.actuator != NONE else 0
    return turned + (2 + MULTIPLY if vector.u != NONE else 0)


def _move(move: Move) -> int:
    """Count one move as `gimcli.kernels.sweep.impose` makes it."""
    r = move.restriction
    if r.kind == SPAN or r.vector is None:
        return 12 + _value(move)
    if r.kind == ANGLE:
        arm = move.node not in (r.p, r.q)
        return _direction(r.vector) + 15 + (2 + MULTIPLY if arm else 0)
    if move.node == r.p:
        return _direction(r.vector) + 17 + _value(move)
    return _direction(r.vector) + (23 if move.node == r.vector.u else 21) + _value(move)


def _check(move: Move) -> int:
    """Count one error as `gimcli.kernels.sweep.error_of` takes it."""
    r = move.restriction
    if r.kind == SPAN or r.vector is None:
        return 8 + _value(move)
    return _direction(r.vector) + (19 if r.kind == ANGLE else 12) + _value(move)


# -- closed forms and the library's Newton-Raphson ---------------------------------------------------


def plan_cost(mechanism: Mechanism, plan: Plan, parts: int = 1) -> Cost:
    """Return what a plan costs a row, solved in some parts: closed forms each time, and iterations."""
    closed = sum(_closed(step) for step in plan.steps if not isinstance(step, Coupled))
    groups = plan.coupled
    factors = sum(group_factors(g) for g in groups)  # renewed once a row, where rows are some degrees apart
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
    lines = sum(isinstance(locus, Line) for locus in loci)
    return sum(_locus(locus) for locus in loci) + (47, 29, 25)[lines] + GUARD


def _locus(locus: Circle | Line) -> int:
    value = locus.radius if isinstance(locus, Circle) else locus.distance
    count = 2 if value.actuator != NONE else 0
    count += _vector(locus.offset) + 2 if locus.offset is not None else 0
    return count + (_vector(locus.normal) if isinstance(locus, Line) else 0)


def _vector(vector: Vector | None) -> int:
    if vector is None:
        return 0
    base = 2 + MULTIPLY if vector.u != NONE else MULTIPLY * (vector.register != NONE)
    return base + (TURN if vector.actuator != NONE else 0)


def group_factors(group: Coupled) -> float:
    """Count what `gimcli.kernels.newton.factor` takes: the Jacobian and its elimination."""
    n, m = 2 * len(group.base), sum(e.rows for e in group.equations)
    return sum(_gradient(e, len(group.base)) for e in group.equations) + elimination(m, n)


def group_iteration(group: Coupled) -> float:
    """Count one correction of `gimcli.kernels.newton.newton`, with the factors that there are."""
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


def coordinates_cost(system: object) -> Cost:
    """Return what a position costs in joint, absolute or natural coordinates."""
    assert isinstance(system, JointCoordinates | AbsoluteCoordinates | NaturalCoordinates)
    if isinstance(system, NaturalCoordinates):
        position, rows = 2.0 * len(system.mechanism.actuators), _natural_rows(system)
    elif isinstance(system, JointCoordinates):
        position = _tree(system)
        rows = position + sum(_pair(p) for p in system.cut) + _chains(system)
    else:
        position = 2.0 * sum(system.bodies.turns(b) for b in range(1, system.bodies.count))
        rows = position + sum(_pair(p) for p in system.bodies.pairs)
    n, m = system.unknowns, system.equations
    iteration = rows + elimination(m, n) + substitution(m, n) + 2.0 * n
    return Cost((n,), position, (iteration,), paper_iteration(system.mechanism))


def _pair(pair: BodyPair) -> int:
    """Count one pair as `gimcli.kernels.bodies.pair_rows` writes it."""
    own = {bodies.COINCIDENT: 18, bodies.ON_LINE: 38, bodies.ANGLE: 5, bodies.DISTANCE: 32}[pair.kind]
    return own + (pair.actuator != NONE)


def _tree(system: JointCoordinates) -> float:
    """Count placing the bodies, as `gimcli.kernels.bodies.place_tree` does it."""
    count = 0
    for joint in system.joints:
        values = (joint.angle, joint.travel) if joint.kind == bodies.HINGE else (joint.angle,)
        count += sum(2 * (motion.actuator != NONE) + motion.variable for motion in values)
        count += {bodies.HINGE: 41, bodies.RAM: 31, bodies.FREE: 25}[joint.kind]
    return float(count)


def _chains(system: JointCoordinates) -> int:
    """Count collecting the partial derivatives along the chains: 7 operations a turn, 4 a shift."""
    above = {joint.child: joint for joint in system.joints}
    count = 0
    for pair in system.cut:
        for body in (pair.a, pair.b):
            while body != FRAME:
                joint = above[body]
                turns = int(joint.angle.variable)
                count += pair.rows * (7 * turns + 4 * (joint.variables - turns))
                body = joint.parent
    return count


def _natural_rows(system: NaturalCoordinates) -> float:
    """Count the equations and gradients as `gimcli.kernels.points.point_rows` writes them."""
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
