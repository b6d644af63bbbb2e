"""The data of a plan: vectors, constraints, loci and the steps that place nodes.

A vector is fixed to a member: z (V - U) e^(+-i theta), with nodes U, V of the member, a constant z and the angle theta
of an actuator. Carried nodes, guide normals and offsets are such vectors, so that the position of a carried node is
linear in the nodes placed before it.

A *register* is a numbered variable for a direction (a complex number of modulus 1) that a step computes and later
vectors use instead of V - U.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.mechanism import CLOSURE, FloatArray

NONE = -1


@dataclass(frozen=True)
class Vector:
    """z times a base vector, rotated by the angle of an actuator if there is one.

    The base is V - U for nodes `u` and `v`, else the direction in `register`, else 1. NONE: not used.
    """

    z: complex
    u: int = NONE
    v: int = NONE
    register: int = NONE
    actuator: int = NONE
    turn: int = 1  # +1 or -1: sense in which the actuator's angle is applied

    def times(self, factor: complex) -> Vector:
        """Return the vector multiplied by a complex constant."""
        return Vector(self.z * factor, self.u, self.v, self.register, self.actuator, self.turn)

    def driven(self, factor: complex, actuator: int, turn: int) -> Vector | None:
        """Return the vector times `factor`, rotated by an actuator; None if an actuator already rotates it."""
        if self.actuator != NONE:
            return None
        return Vector(self.z * factor, self.u, self.v, self.register, actuator, turn)

    @property
    def nodes(self) -> tuple[int, ...]:
        """Nodes on which the vector depends."""
        return (self.u, self.v) if self.u != NONE else ()


@dataclass(frozen=True)
class Value:
    """constant + gain * input of an actuator, or the constant alone."""

    constant: float
    actuator: int = NONE
    gain: float = 1.0

    def plus(self, constant: float) -> Value:
        """Return the value increased by a constant."""
        return Value(self.constant + constant, self.actuator, self.gain)

    def at(self, inputs: FloatArray) -> FloatArray | float:
        """Return the values (rows,), or the constant, for inputs (actuators, rows)."""
        if self.actuator == NONE:
            return self.constant
        return np.asarray(self.constant + self.gain * inputs[self.actuator])


@dataclass(frozen=True)
class Constraint:
    """One constraint between nodes, as every solver imposes it; `name` is that of its member, pair or actuator.

    SPAN: the distance of p and q is the value. HEIGHT: vector . (p - q) is the value, with a unit vector.
    ANGLE: p is on the ray from q along the vector. CLOSURE: p is q plus the vector (two equations). With an offset, p
    minus the offset takes the place of p.
    """

    name: str
    kind: int
    p: int
    q: int
    value: Value
    vector: Vector | None = None
    offset: Vector | None = None  # of loci only

    @cached_property
    def nodes(self) -> tuple[int, ...]:
        """All nodes of the constraint."""
        return tuple(dict.fromkeys((self.q, self.p, *(self.vector.nodes if self.vector else ()))))

    @property
    def rows(self) -> int:
        """Number of scalar equations."""
        return 2 if self.kind == CLOSURE else 1

    @property
    def driven(self) -> bool:
        """Whether the constraint depends on an input."""
        return self.value.actuator != NONE or (self.vector is not None and self.vector.actuator != NONE)


@dataclass(frozen=True, eq=False)
class Place:
    """Place a node that a member carries: node = anchor + vector."""

    node: int
    anchor: int
    vector: Vector


@dataclass(frozen=True, eq=False)
class Orient:
    """Store a direction in a register: register = vector."""

    register: int
    vector: Vector


@dataclass(frozen=True, eq=False)
class Tilt:
    """Determine the direction of a guide from a node A of the guide and a node B that slides on it.

    The direction u (stored in the register) satisfies B - A = u (tau + i e): e, the given distance of the line from A,
    and tau = +-sqrt(|B - A|^2 - e^2), the distance along the line. The sign of tau is the branch.
    """

    register: int
    a: int
    b: int
    distance: float  # e, normal frame
    along: Vector  # the line's direction from two nodes of its member; at the initial guess it selects the sign of tau
    branch: int


@dataclass(frozen=True, eq=False)
class Dyad:
    """Place a node at an intersection of two loci: circles (SPAN) or lines (HEIGHT), whose p it is.

    `branch` is the number of this step among the steps with two solutions; NONE for two lines, which have one.
    """

    node: int
    first: Constraint
    second: Constraint
    branch: int


@dataclass(frozen=True, eq=False)
class Coupled:
    """A strongly coupled Assur group: its base nodes are solved simultaneously, its other nodes are carried."""

    base: tuple[int, ...]  # nodes whose coordinates are the unknowns
    places: tuple[Place, ...]  # of the carried nodes
    equations: tuple[Constraint, ...]
    members: tuple[int, ...]

    @property
    def nodes(self) -> tuple[int, ...]:
        """All nodes that the group places."""
        return self.base + tuple(p.node for p in self.places)

    @property
    def surplus(self) -> int:
        """Number of equations minus number of unknowns."""
        return sum(e.rows for e in self.equations) - 2 * len(self.base)


Step = Place | Orient | Tilt | Dyad | Coupled


@dataclass(frozen=True, eq=False)
class Plan:
    """Steps in the order of solution; every free node is placed by exactly one of them."""

    steps: tuple[Step, ...]
    registers: int  # number of registers
    branches: int  # number of steps with two solutions
    surplus: int  # constraints minus free coordinates

    @property
    def coupled(self) -> tuple[Coupled, ...]:
        """The strongly coupled groups."""
        return tuple(s for s in self.steps if isinstance(s, Coupled))
