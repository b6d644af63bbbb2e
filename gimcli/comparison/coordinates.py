"""Joint coordinates: a spanning tree of bodies; the pairs that are not in the tree are the equations.

Each freedom of a joint in the tree is a variable, except those driven by an input. The tree starts at the frame;
the joint with the fewest variables is added first and, among equals, the one nearest to the frame. A linear actuator
can be a joint of the tree; its direction is then the variable.
Source: Fraczek & Wojtyra, lecture notes on multibody methods; Garcia de Jalon & Bayo 1994, section 2.1.

Natural coordinates: x and y of the points at which members are joined, and no angles.

A member gives the distance of its two points that are farthest apart, and two linear equations for each further
point. Source: Garcia de Jalon & Bayo, Kinematic and Dynamic Simulation of Multibody Systems, 1994,
chapter 2.
"""

from __future__ import annotations

import cmath
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np

from gimcli.comparison.bodies import BodyCoordinates, BodyPair
from gimcli.kernels import bodies as pairs, coordinates as kernels
from gimcli.kernels.points import DISTANCE, LINE, RIGID
from gimcli.mechanism import ANGLE, CLOSURE, FRAME, SPAN, ComplexArray, FloatArray, Mechanism
from gimcli.positions.newton import Run
from gimcli.structure.equations import constraints
from gimcli.structure.kinematic_nodes import carry, free_nodes, kinematic_nodes
from gimcli.structure.steps import NONE, Constraint, Vector
from gimcli.structure.terms import coordinates

PARALLEL = 1e-12
"""A linear actuator drives a sliding pair if the sine of the angle between their directions is below this."""


@dataclass(frozen=True)
class JointFreedom:
    """The angle [rad] or travel [normal frame] of a joint: a constant, plus a variable or an input."""

    constant: float = 0.0
    variable: bool = True
    actuator: int = NONE  # number of the input, if one drives it
    sense: int = 1  # factor of the input, +1 or -1


FIXED = JointFreedom(variable=False)


@dataclass(frozen=True)
class TreeJoint:
    """A joint between a body and its parent in the tree: angle and travel, points and directions in both bodies."""

    kind: int
    parent: int
    child: int
    za: complex = 0.0j  # point in the parent
    da: complex = 0.0j  # direction of the travel, if fixed in the parent
    zb: complex = 0.0j  # point in the child
    db: complex = 0.0j  # direction of the travel, if fixed in the child
    angle: JointFreedom = FIXED
    travel: JointFreedom = FIXED
    imposed: tuple[int, ...] = ()  # numbers of the pairs that the joint imposes

    @property
    def variables(self) -> int:
        """Number of free coordinates of the joint."""
        own = 2 if self.kind == pairs.FREE else int(self.travel.variable)
        return own + int(self.angle.variable)


class JointCoordinates(BodyCoordinates):
    """A mechanism in joint coordinates."""

    def __init__(self, mechanism: Mechanism, drivers: bool = True) -> None:
        super().__init__(mechanism, drivers)
        self.layout = np.zeros((self.bodies.count, 2), dtype=np.int64)
        self.tree = self._tree()
        imposed = {number for joint in self.tree for number in joint.imposed}
        self.equated = [p for k, p in enumerate(self.bodies.pairs) if k not in imposed]
        self.unknowns, self.joints = sum(j.variables for j in self.tree), self._arrays()

    @property
    def names(self) -> list[tuple[str, bool]]:
        """The unknowns, and whether each is an angle."""
        names: list[tuple[str, bool]] = []
        for joint in self.tree:
            at = " ".join(dict.fromkeys(self.bodies.pairs[k].name for k in joint.imposed))
            name = f"{self.bodies.name(joint.child)} at {at}" if at else self.bodies.name(joint.child)
            names += [(f"{name}.angle", True)] * joint.angle.variable
            shifts = joint.variables - joint.angle.variable
            names += [(f"{name}.{part}", False) for part in (("x", "y") if shifts == 2 else ("travel",) * shifts)]
        return names

    # -- the tree ---------------------------------------------------------------------------

    def _tree(self) -> list[TreeJoint]:
        depth, joints = {FRAME: 0}, []
        while len(depth) < self.bodies.count:
            found = [j for j in self._joints() if j.parent in depth and j.child not in depth]
            if not found:
                single = next(b for b in range(self.bodies.count) if b not in depth)
                angle = JointFreedom() if self.bodies.turns(single) else FIXED
                found = [TreeJoint(pairs.FREE, FRAME, single, angle=angle, travel=JointFreedom())]
            joint = min(found, key=lambda j: (j.variables, depth[j.parent]))
            depth[joint.child] = depth[joint.parent] + 1
            joints.append(joint)
        return joints

    def _joints(self) -> Iterator[TreeJoint]:
        """Yield each pair as a joint of the tree, once for each choice of the parent."""
        for number, pair in enumerate(self.bodies.pairs):
            ends = (pair.a, pair.za), (pair.b, pair.zb)
            for (parent, za), (child, zb) in permutations(ends):
                joint = TreeJoint(pairs.HINGE, parent, child, za=za, zb=zb, imposed=(number,))
                if pair.kind == pairs.COINCIDENT:
                    yield self._with_angle(joint)
                elif pair.slides:
                    yield self._sliding(joint, pair)
                elif pair.kind == pairs.DISTANCE:
                    ram = replace(joint, kind=pairs.RAM, travel=JointFreedom(actuator=pair.actuator))
                    yield self._with_angle(ram)

    def _with_angle(self, joint: TreeJoint) -> TreeJoint:
        """Return the joint with its angle free, driven by the rotary input between its bodies, or fixed for a point."""
        if not self.bodies.turns(joint.child):
            return joint
        for number, pair in enumerate(self.bodies.pairs):
            if pair.kind == pairs.ANGLE and {pair.a, pair.b} == {joint.parent, joint.child}:
                sense = 1 if pair.a == joint.child else -1
                angle = JointFreedom(sense * pair.constant, False, pair.actuator, sense)
                return replace(joint, angle=angle, imposed=(*joint.imposed, number))
        return replace(joint, angle=JointFreedom())

    def _sliding(self, joint: TreeJoint, pair: BodyPair) -> TreeJoint:
        """Return a pin in a slot, or a true prismatic pair if the pair has two slides."""
        along, ahead = pair.normal / 1j, joint.child == pair.a
        joint = replace(joint, da=along) if ahead else replace(joint, db=along)
        others = [k for k, other in enumerate(self.bodies.pairs) if other.slides and other.name == pair.name]
        second = next((k for k in others if k not in joint.imposed), None)
        if second is None:
            return self._with_travel(self._with_angle(joint), pair)
        turn = self._prismatic_turn(pair, self.bodies.pairs[second])
        angle = JointFreedom(turn if ahead else -turn, variable=False)
        return self._with_travel(replace(joint, angle=angle, imposed=(*joint.imposed, second)), pair)

    def _prismatic_turn(self, first: BodyPair, second: BodyPair) -> float:
        """Return the constant angle [rad] from the guide to the sliding body, in the drawn sense."""
        _, turns = self.bodies.poses(self.mechanism.drawn)
        span = second.za - first.za
        along = first.normal / 1j * turns[first.b]
        sense = 1.0 if (along.conjugate() * span * turns[first.a]).real >= 0.0 else -1.0
        return cmath.phase(sense * first.normal / 1j / span)

    def _with_travel(self, joint: TreeJoint, pair: BodyPair) -> TreeJoint:
        """Return the joint with its travel free, or driven by the input of the same line."""
        along = pair.normal / 1j
        for number, other in enumerate(self.bodies.pairs):
            same = other.kind == pairs.ON_LINE and not other.slides and (other.a, other.b) == (pair.a, pair.b)
            if same and other.za == pair.za and abs((other.normal.conjugate() * along).imag) < PARALLEL:
                sense = 1 if (other.normal.conjugate() * along).real > 0.0 else -1
                offset = (other.normal.conjugate() * (pair.zb - other.zb)).real
                travel = JointFreedom(-sense * offset, False, other.actuator, sense)
                return replace(joint, travel=travel, imposed=(*joint.imposed, number))
        return replace(joint, travel=JointFreedom())

    # -- arrays -------------------------------------------------------------------------------

    def _arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the joints as ji, jz and above of the kernel."""
        heads, parts, column = [], [], 0
        above = np.full(self.bodies.count, NONE, dtype=np.int64)
        for number, j in enumerate(self.tree):
            angle = column if j.angle.variable else NONE
            travel = column + int(j.angle.variable) if j.travel.variable else NONE
            column += j.variables
            above[j.child] = number
            heads.append(
                (j.parent, j.child, j.kind, angle, j.angle.actuator, j.angle.sense, travel, j.travel.actuator,
                 j.travel.sense)
            )  # fmt: skip
            points = [part for z in (j.za, j.da, j.zb, j.db) for part in (z.real, z.imag)]
            parts.append((*points, j.angle.constant, j.travel.constant))
        return np.array(heads, dtype=np.int64).reshape(-1, 9), np.array(parts).reshape(-1, 10), above

    def weights(self, length: float) -> FloatArray:
        """Return the weights (unknowns,) of the corrections: 1 / `length` for travels, 1 for angles [rad]."""
        weights: list[float] = []
        for joint in self.tree:
            weights += [1.0] * joint.angle.variable
            shifts = joint.variables - joint.angle.variable
            weights += [1.0 if joint.kind == pairs.RAM else 1.0 / length] * shifts
        return np.array(weights, dtype=float)

    def start(self, z: ComplexArray) -> FloatArray:
        """Return the variables at a position z (nodes,)."""
        origins, turns = self.bodies.poses(z)
        q: list[float] = []
        for j in self.tree:
            if j.angle.variable:
                q.append(float(np.angle(turns[j.child] / turns[j.parent])))
            tip = (origins[j.child] + turns[j.child] * j.zb - origins[j.parent]) / turns[j.parent] - j.za
            if j.kind == pairs.FREE:
                q += [float(tip.real), float(tip.imag)]
            elif j.kind == pairs.RAM:
                q.append(float(np.angle(tip)))
            elif j.travel.variable:
                along = j.da if j.da != 0 else -j.db * turns[j.child] / turns[j.parent]
                q.append(float((np.conj(along) * tip).real))
        return np.array(q, dtype=float)


class NaturalCoordinates:
    """A mechanism in natural coordinates: two unknowns per moving point."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.free = list(free_nodes(mechanism))
        points = [self._ordered(k, nodes) for k, nodes in enumerate(kinematic_nodes(mechanism))]
        rows = list(constraints(mechanism, points))
        self.heads = np.array([_head(row) for row in rows], dtype=np.int64).reshape(-1, 8)
        self.factors = np.array([_factors(row) for row in rows], dtype=float).reshape(-1, 3)
        self.columns = np.full(len(mechanism.nodes), NONE, dtype=np.int64)
        self.columns[self.free] = 2 * np.arange(len(self.free))
        self.unknowns = 2 * len(self.free)
        self.equations = int(sum(2 if head[0] == RIGID else 1 for head in self.heads))

    def start(self, z: ComplexArray) -> FloatArray:
        """Return the unknowns at a position z (nodes,)."""
        return coordinates(z[self.free])

    def follow(
        self, inputs: FloatArray, start: ComplexArray, tolerance: float, length: float, most: int, run: Run
    ) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """Solve inputs (actuators, rows) from a position (nodes,), as `BodyCoordinates.follow`."""
        rows = inputs.shape[1]
        x, y = (np.tile(part, (rows, 1)) for part in (start.real, start.imag))
        iterations, good = np.zeros(rows), np.zeros(rows)
        weights = np.full(self.unknowns, 1.0 / length)
        values = np.ascontiguousarray(inputs.T)
        run(kernels.follow_points)(
            self.start(start), values, np.cos(values), np.sin(values), self.heads, self.factors, self.columns,
            kernels.room(self.equations, self.unknowns), weights, tolerance, most, x, y, iterations,
            good,
        )  # fmt: skip
        return carry(self.mechanism, (x + 1j * y).T), iterations, good

    def _ordered(self, index: int, nodes: Sequence[int]) -> list[int]:
        """Return nodes of a member, the two that are farthest apart first."""
        member = self.mechanism.members[index]
        base = max(combinations(nodes, 2), key=lambda pair: abs(member.reach(*pair)), default=())
        return [*base, *(node for node in nodes if node not in base)]


def _head(c: Constraint) -> tuple[int, ...]:
    """Return the integers of an equation in the kernel; an angle is a line too."""
    vector = c.vector or Vector(0.0j)
    kind = {SPAN: DISTANCE, CLOSURE: RIGID}.get(c.kind, LINE)
    return kind, c.p, c.q, vector.u, vector.v, c.value.actuator, vector.actuator, vector.turn


def _factors(c: Constraint) -> tuple[float, ...]:
    """Return the floats of an equation in the kernel."""
    z = (c.vector or Vector(0.0j)).z * (1j if c.kind == ANGLE else 1.0)
    return z.real, z.imag, c.value.constant
