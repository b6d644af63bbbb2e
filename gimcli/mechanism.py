"""A mechanism as solved: immutable, integer ids, complex coordinates.

Positions are complex numbers x + iy in the *normal frame*: the file's coordinates minus
`origin`, divided by `scale` (a power of two, so that scaling is exact and the mechanism
is about 1 in size). Angles are in rad. Everything to the right of this module works in
the normal frame and never sees the file's units.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from gimcli.dynamic_data import AppliedLoad, DampingForce, Friction, Inertia, Release, SpringForce

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]

FRAME = 0
"""Index of the member that stands still: the ground, or the held member of a floating mechanism."""


MOST_TURNS = 1e4
"""Turns, or sizes of the mechanism, that an input may reach: every one is followed."""


class InputLaw(Protocol):
    """The value of an actuator over the normalised time 0..1 (rad, or length in the normal frame)."""

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value (`order` 0) or its derivative by the normalised time."""
        ...

    def stops(self) -> FloatArray:
        """Return the times at which the law may stop or turn back; between them it runs one way."""
        ...


@dataclass(frozen=True)
class ConstantLaw:
    """The law of an input that stands still, and of what is only read."""

    value: float = 0.0

    def __call__(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Return the value, or zeros."""
        return np.full(np.shape(time), 0.0 if order else self.value)

    def stops(self) -> FloatArray:
        """Return no time."""
        return np.empty(0)


@dataclass(frozen=True, eq=False)
class Member:
    """A rigid link or n-ary element; member 0 is the frame."""

    name: str
    nodes: tuple[int, ...]
    shape: ComplexArray = field(repr=False)  # (len(nodes),) places in the member's own frame

    def local(self, node: int) -> complex:
        """Return the place of a node in the member's own frame."""
        return complex(self.shape[self.nodes.index(node)])

    @cached_property
    def ends(self) -> tuple[int, int, complex]:
        """The first node, the one farthest from it, and the vector between them in the member's own frame."""
        far = int(np.argmax(np.abs(self.shape - self.shape[0])))
        return self.nodes[0], self.nodes[far], complex(self.shape[far] - self.shape[0])

    def reach(self, a: int, b: int) -> complex:
        """Return the way from node a to node b in the member's own frame."""
        return self.local(b) - self.local(a)


SPAN, ANGLE, HEIGHT, CLOSURE = range(4)
"""Kinds of constraints; what a pair, an actuator or a gauge is about is one of the first three, never a CLOSURE."""


@dataclass(frozen=True)
class PairRow:
    """One constraint of a pair, or what an actuator sets or a gauge reads; directions are unit complex numbers.

    - SPAN: the distance of the two `nodes`.
    - HEIGHT: how far the node is from `point` along `normal`, both in the frame of a member, the guide. The height of
      a node on a guide is 0, with `normal` across the line; that of a travel is along the guide.
    - ANGLE: the angle from the direction `reference` of the second member to `arm` of the first, each in its member's
      own frame, about the node if it has one. The frame's +x direction is FRAME with direction 1.
    """

    name: str
    kind: int
    nodes: tuple[int, ...]
    members: tuple[int, ...] = ()  # none, the guide, or the arm's and the reference's
    point: complex = 0.0j
    normal: complex = 1.0j
    arm: complex = 1.0 + 0.0j
    reference: complex = 1.0 + 0.0j
    pair: str = ""  # the pair that it is of: a true prismatic pair (no relative rotation) has two heights

    @property
    def node(self) -> int:
        """The first of its nodes: over the guide, or the vertex."""
        return self.nodes[0]

    @property
    def guide(self) -> int:
        """The last of its members: that which carries the line, or the reference; the frame for a distance."""
        return self.members[-1] if self.members else FRAME

    def height(self, place: complex) -> float:
        """Return how far the line is over a place of the guide, in its own frame."""
        return (self.normal.conjugate() * (self.point - place)).real

    @property
    def along(self) -> complex:
        """The direction of the line that a node stays on."""
        return -1j * self.normal

    @property
    def rotary(self) -> bool:
        """Tell whether it is about an angle, not a length."""
        return self.kind == ANGLE


@dataclass(frozen=True)
class Input(PairRow):
    """What an actuator sets, by its law; or what a gauge reads."""

    law: InputLaw = field(default=ConstantLaw(), repr=False)
    drawn: float = 0.0  # value in the drawn position


@dataclass(frozen=True)
class Point:
    """A point carried by a member; it never enters the solution."""

    name: str
    member: int
    local: complex


@dataclass(frozen=True)
class Dynamics:
    """All that acts on a mechanism."""

    metre: float | None = 1.0  # m per unit of the normal frame; None: the file's length has no physical unit
    inertias: tuple[Inertia, ...] = ()
    gravity: complex = 0.0j  # m/s2
    loads: tuple[AppliedLoad, ...] = ()
    springs: tuple[SpringForce, ...] = ()
    dampers: tuple[DampingForce, ...] = ()
    frictions: tuple[Friction, ...] = ()
    releases: tuple[Release, ...] = ()

    @property
    def empty(self) -> bool:
        """Tell whether nothing has mass and nothing acts."""
        parts: tuple[Any, ...] = (self.inertias, self.loads, self.springs, self.dampers, self.frictions)
        return not any(parts)


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Everything that the analyses know of a model file."""

    name: str
    nodes: tuple[str, ...]
    drawn: ComplexArray = field(repr=False)  # (len(nodes),) drawn position, normal frame
    members: tuple[Member, ...]
    pairs: tuple[PairRow, ...]
    actuators: tuple[Input, ...]
    points: tuple[Point, ...]
    traced: tuple[str, ...]  # names of nodes and points, in the order of the columns
    size: float  # largest dimension, normal frame (about 1)
    scale: float  # file's length unit per unit of the normal frame
    origin: complex  # file's coordinates of the normal frame's origin
    length_unit: str = "m"  # "unit": no physical unit
    angle_unit: str = "deg"  # or "rad"
    duration: float = 1.0  # s, for the normalised time 0..1
    floating: bool = False  # no node is grounded: member 0 is a held member of the file
    dynamics: Dynamics = field(default=Dynamics(), repr=False)
    gauges: tuple[Input, ...] = field(default=(), repr=False)  # what springs and dampers read; nothing drives them
    files: tuple[Path, ...] = field(default=(), repr=False, compare=False)  # what it was read from: never written over

    @cached_property
    def slides(self) -> tuple[PairRow, ...]:
        """The nodes on guides."""
        return tuple(row for row in self.pairs if row.kind == HEIGHT)

    @cached_property
    def shortest(self) -> float:
        """Smallest distance of a member's first node from its others: what relative errors refer to."""
        spans = [abs(z - m.shape[0]) for m in self.members[1:] for z in m.shape[1:]]
        return float(min(spans, default=self.size))

    @property
    def drawn_inputs(self) -> FloatArray:
        """The inputs (actuators,) as drawn."""
        return np.array([a.drawn for a in self.actuators], dtype=float)

    @property
    def start_inputs(self) -> FloatArray:
        """The inputs (actuators,) at the start of all laws."""
        return np.array([float(a.law(np.zeros(1))[0]) for a in self.actuators])

    def to_file(self, z: ComplexArray) -> ComplexArray:
        """Return positions in the file's coordinates and unit."""
        return z * self.scale + self.origin

    def unit_of(self, value: Input) -> str:
        """Return the file's unit of an actuator's or a gauge's value."""
        return self.angle_unit if value.rotary else self.length_unit

    def value_to_file(self, actuator: int, value: FloatArray) -> FloatArray:
        """Return values of an actuator in the file's unit (deg or rad, or length)."""
        if self.actuators[actuator].rotary:
            return np.degrees(value) if self.angle_unit == "deg" else value
        return value * self.scale

    def inputs_to_file(self, inputs: FloatArray) -> dict[str, float]:
        """Return values of all actuators (actuators,) by their names in the file's units."""
        return {a.name: float(self.value_to_file(k, inputs[k : k + 1])[0]) for k, a in enumerate(self.actuators)}

    def value_from_file(self, actuator: int, value: float) -> float:
        """Return a value given in the file's unit in rad or in the normal frame's length."""
        if self.actuators[actuator].rotary:
            return float(np.radians(value)) if self.angle_unit == "deg" else value
        return value / self.scale
