"""What a plan consists of: vectors, constraints, loci and the steps that place nodes, as data.

A vector is a member's direction carried along: z (V - U) e^(+-i theta). Places, guide normals
and offsets are all such vectors, so that a position is linear in the nodes placed before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gimcli.mechanism import CLOSURE, FloatArray

NONE = -1


@dataclass(frozen=True)
class Vector:
    """z times a base direction, turned by an actuator's angle.

    The base is V - U for nodes `u` and `v`, else the direction in `register`, else 1.
    """

    z: complex
    u: int = NONE
    v: int = NONE
    register: int = NONE
    actuator: int = NONE
    turn: int = 1  # +1 or -1: sense in which the actuator's angle is applied

    def times(self, factor: complex) -> Vector:
        """Return the vector scaled and turned by a constant."""
        return Vector(self.z * factor, self.u, self.v, self.register, self.actuator, self.turn)

    def driven(self, factor: complex, actuator: int, turn: int) -> Vector | None:
        """Return the vector turned by an actuator too; None if it already is turned by one."""
        if self.actuator != NONE:
            return None
        return Vector(self.z * factor, self.u, self.v, self.register, actuator, turn)

    @property
    def nodes(self) -> tuple[int, ...]:
        """Nodes that the vector is read from."""
        return (self.u, self.v) if self.u != NONE else ()


@dataclass(frozen=True)
class Value:
    """constant + gain * input of an actuator."""

    constant: float
    actuator: int = NONE
    gain: float = 1.0

    def plus(self, constant: float) -> Value:
        """Return the value and a constant more."""
        return Value(self.constant + constant, self.actuator, self.gain)

    def at(self, inputs: FloatArray) -> FloatArray | float:
        """Return the value for inputs of shape (actuators, rows)."""
        if self.actuator == NONE:
            return self.constant
        return np.asarray(self.constant + self.gain * inputs[self.actuator])


@dataclass(frozen=True)
class Constraint:
    """One constraint between nodes, as every solver imposes it; the name is that of what it is of.

    SPAN: the distance of p and q is the value. HEIGHT: vector . (p - q) is the value, with a unit vector.
    ANGLE: p is on the ray from q along the vector. CLOSURE: p is q plus the vector, two equations.
    """

    name: str
    kind: int
    p: int
    q: int
    value: Value
    vector: Vector | None = None

    @cached_property
    def nodes(self) -> tuple[int, ...]:
        """All nodes that it ties."""
        return tuple(dict.fromkeys((self.q, self.p, *(self.vector.nodes if self.vector else ()))))

    @property
    def rows(self) -> int:
        """Number of scalar equations."""
        return 2 if self.kind == CLOSURE else 1

    @property
    def driven(self) -> bool:
        """Tell whether an actuator's law enters."""
        return self.value.actuator != NONE or (self.vector is not None and self.vector.actuator != NONE)


@dataclass(frozen=True, eq=False)
class Circle:
    """Distance `radius` from node `centre` shifted by `offset`."""

    constraint: str
    centre: int
    radius: Value
    offset: Vector | None = None

    @property
    def nodes(self) -> tuple[int, ...]:
        """Nodes that stand still."""
        return (self.centre,)


@dataclass(frozen=True, eq=False)
class Line:
    """normal . (p - anchor - offset) = distance."""

    constraint: str
    anchor: int
    normal: Vector
    distance: Value
    offset: Vector | None = None

    @property
    def nodes(self) -> tuple[int, ...]:
        """Nodes that stand still."""
        return (self.anchor, *self.normal.nodes)


Locus = Circle | Line


@dataclass(frozen=True, eq=False)
class Place:
    """Carry a node along: node = anchor + vector."""

    node: int
    anchor: int
    vector: Vector
    constraint: str


@dataclass(frozen=True, eq=False)
class Orient:
    """Keep a direction in a register: register = vector."""

    register: int
    vector: Vector
    constraint: str


@dataclass(frozen=True, eq=False)
class Tilt:
    """Turn a line through two placed nodes: register = direction u of B - A = u (tau + i e)."""

    register: int
    a: int
    b: int
    distance: float
    along: Vector  # the line's direction by two nodes of its member: the side that a guess is drawn on
    branch: int
    constraint: str


@dataclass(frozen=True, eq=False)
class Dyad:
    """Place a node where two loci meet; `branch` counts the steps that have two solutions."""

    node: int
    first: Locus
    second: Locus
    branch: int


@dataclass(frozen=True, eq=False)
class Coupled:
    """A strongly coupled Assur group: base nodes found together, other nodes carried along."""

    base: tuple[int, ...]
    places: tuple[Place, ...]
    equations: tuple[Constraint, ...]
    members: tuple[int, ...]

    @property
    def nodes(self) -> tuple[int, ...]:
        """All nodes that the group places."""
        return self.base + tuple(p.node for p in self.places)

    @property
    def surplus(self) -> int:
        """Equations beyond the unknowns."""
        return sum(e.rows for e in self.equations) - 2 * len(self.base)


Step = Place | Orient | Tilt | Dyad | Coupled


@dataclass(frozen=True, eq=False)
class Plan:
    """Steps in the order of solution; every free node is placed by exactly one of them."""

    steps: tuple[Step, ...]
    registers: int
    branches: int
    surplus: int  # constraints beyond the free coordinates

    @property
    def coupled(self) -> tuple[Coupled, ...]:
        """The strongly coupled groups."""
        return tuple(s for s in self.steps if isinstance(s, Coupled))
