"""A mechanism as solved: immutable, integer ids, complex coordinates.

Positions are complex numbers x + iy in the *normal frame*: the file's coordinates minus
`origin`, divided by `scale` (a power of two, so that scaling is exact and the mechanism
is about 1 in size). Angles are in rad. Everything to the right of this module works in
the normal frame and never sees the file's units.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
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


@dataclass(frozen=True)
class Member:
    """A rigid link or n-ary element; member 0 is the frame."""

    name: str
    nodes: tuple[int, ...]
    shape: ComplexArray = field(repr=False)  # (len(nodes),) places in the member's own frame

    def local(self, node: int) -> complex:
        """Return the place of a node in the member's own frame."""
        return complex(self.shape[self.nodes.index(node)])


@dataclass(frozen=True)
class Slide:
    """One node that stays on a line carried by a member.

    The line runs through `point` along `direction` (unit), both in the frame of `member`.
    A true prismatic pair (no relative rotation) is two slides with the same `pair`.
    """

    name: str
    pair: str
    node: int
    member: int
    point: complex
    direction: complex


class Drive(Enum):
    """What an actuator drives."""

    ROTARY = "rotary"
    DISTANCE = "distance"
    TRAVEL = "travel"


@dataclass(frozen=True)
class Input:
    """An input; which fields mean something depends on `drive`.

    - ROTARY: the angle, about node `a`, from `reference_direction` in `reference_member`
      to `arm_direction` in `arm_member` (unit complex numbers in the members' own frames).
      The frame's +x direction is `reference_member` FRAME with direction 1.
    - DISTANCE: the distance of nodes `a` and `b`.
    - TRAVEL: the travel of node `a` along the line through `point` with `direction` (unit),
      both in the frame of `reference_member`.
    """

    name: str
    drive: Drive
    law: InputLaw = field(repr=False)
    drawn: float  # value in the drawn position
    a: int
    b: int = -1
    arm_member: int = -1
    reference_member: int = FRAME
    arm_direction: complex = 1.0 + 0.0j
    reference_direction: complex = 1.0 + 0.0j
    point: complex = 0.0j
    direction: complex = 1.0 + 0.0j

    @property
    def rotary(self) -> bool:
        """Tell whether the value is an angle, not a length."""
        return self.drive is Drive.ROTARY


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


@dataclass(frozen=True)
class Mechanism:
    """Everything that the analyses know of a model file."""

    name: str
    nodes: tuple[str, ...]
    drawn: ComplexArray = field(repr=False)  # (len(nodes),) drawn position, normal frame
    members: tuple[Member, ...]
    slides: tuple[Slide, ...]
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

    def value_from_file(self, actuator: int, value: float) -> float:
        """Return a value given in the file's unit in rad or in the normal frame's length."""
        if self.actuators[actuator].rotary:
            return float(np.radians(value)) if self.angle_unit == "deg" else value
        return value / self.scale
