"""A mechanism in the form that the solvers use: immutable, with integer ids and complex coordinates.

Positions are complex numbers x + iy in the *normal frame*: (file coordinates - `origin`) / `scale`. `scale` is a power
of two, so that scaling is exact; the size of the mechanism is then about 1. Angles are in rad. All solvers and
analyses work in the normal frame; only input and output use the units of the file.

Terms: an *actuator* drives a length, a height or an angle by a law. A *gauge* measures such a quantity and does not
drive it: springs and dampers act on what gauges measure. Both are objects of the class `Input`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gimcli.calculus.numbers import nominal, scalar
from gimcli.canonical import first_greatest
from gimcli.errors import UsageError
from gimcli.input_laws import ConstantLaw, InputLaw

if TYPE_CHECKING:
    from gimcli.coupling_data import GearPair
    from gimcli.dynamic_data import AppliedLoad, DampingForce, Friction, Inertia, Release, RotorInertia, SpringForce

ComplexArray = NDArray[np.complex128]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

FRAME = 0
"""Index of the fixed member: the ground, or the member chosen as frame of a floating mechanism."""

MOST_TURNS = 1e4
"""Greatest input of a law, in turns or in sizes of the mechanism: a motion passes through all turns one by one."""


@dataclass(frozen=True, eq=False)
class Member:
    """A rigid link or n-ary element; member 0 is the frame."""

    name: str
    nodes: tuple[int, ...]
    shape: ComplexArray = field(repr=False)  # (len(nodes),) coordinates in the member's own frame
    remote: frozenset[int] = frozenset()  # far nodes that only mark the direction of a guide; the last nodes

    @cached_property
    def extent(self) -> float:
        """The greatest distance between two of its nodes, without the remote ones."""
        near = self.shape[: len(self.nodes) - len(self.remote)]
        return float(nominal(np.max(np.abs(near[:, None] - near), initial=0.0)))

    def local(self, node: int) -> complex:
        """Return the coordinates of a node in the member's own frame."""
        return scalar(self.shape[self.nodes.index(node)])  # type: ignore[no-any-return]  # or recorded

    @cached_property
    def near(self) -> int:
        """Number of the nodes that are not remote, which are the first ones; at least 2."""
        return max(2, len(self.nodes) - len(self.remote))

    @cached_property
    def base(self) -> int:
        """Index of the node farthest from the first one, among the first `near` nodes."""
        spans = [nominal(abs(z - self.shape[0])) for z in self.shape[: self.near]]
        return first_greatest(np.array(spans, dtype=float))

    @cached_property
    def ends(self) -> tuple[int, int, complex]:
        """The first node, that of `base`, and the vector between them in the member's own frame."""
        return self.nodes[0], self.nodes[self.base], scalar(self.shape[self.base] - self.shape[0])

    @cached_property
    def stretch(self) -> float:
        """Length of the base, as a power of two, if its second node is remote, else 1."""
        span = abs(self.ends[2]) if self.remote & set(self.ends[:2]) else 1.0
        return float(2.0 ** round(math.log2(nominal(span))))

    @cached_property
    def nearby(self) -> Member:
        """The member, with a near node instead of a remote one at the end of its base."""
        shape = self.shape.copy()
        shape[self.base] = shape[0] + (shape[self.base] - shape[0]) / self.stretch
        return replace(self, shape=shape, remote=self.carried) if self.stretch != 1.0 else self

    @cached_property
    def carried(self) -> frozenset[int]:
        """The remote nodes that are not in the base: their positions follow from it."""
        return self.remote - set(self.ends[:2])

    def reach(self, a: int, b: int) -> complex:
        """Return the vector from node a to node b in the member's own frame."""
        return self.local(b) - self.local(a)


SPAN, ANGLE, HEIGHT, CLOSURE = range(4)
"""Kinds of constraints. Pairs, actuators and gauges are of the first three kinds; only a plan contains CLOSUREs."""


@dataclass(frozen=True)
class PairRow:
    """A geometric quantity: a constraint of a pair, or the quantity that an actuator drives or a gauge measures.

    Directions are complex numbers of modulus 1.

    - SPAN: the distance between the two `nodes`.
    - HEIGHT: the distance of the node from `point` along `normal`, both in the frame of one member, the guide. For a
      node that slides on the guide, `normal` is perpendicular to the line and the height is 0. For the travel of a
      slider, `normal` is parallel to the line.
    - ANGLE: the angle from the direction `reference` of the second member to the direction `arm` of the first, each in
      the own frame of its member. The node, if there is one, is the pivot. FRAME with direction 1 is the +x axis.
    """

    name: str
    kind: int
    nodes: tuple[int, ...]
    members: tuple[int, ...] = ()  # SPAN: none; HEIGHT: the guide; ANGLE: the members of arm and reference
    point: complex = 0.0j
    normal: complex = 1.0j
    arm: complex = 1.0 + 0.0j
    reference: complex = 1.0 + 0.0j
    pair: str = ""  # name of its pair; a true prismatic pair (no relative rotation) consists of two heights

    @property
    def node(self) -> int:
        """The first node: the node on the guide (HEIGHT), or the pivot (ANGLE)."""
        return self.nodes[0]

    @property
    def guide(self) -> int:
        """The last member: the one with the line (HEIGHT), or the reference (ANGLE); the frame for a SPAN."""
        return self.members[-1] if self.members else FRAME

    def height(self, place: complex) -> float:
        """Return the signed distance, along `normal`, from a position in the guide's own frame to the line."""
        return (self.normal.conjugate() * (self.point - place)).real

    @property
    def along(self) -> complex:
        """The direction of the line on which the node slides."""
        return -1j * self.normal

    @property
    def rotary(self) -> bool:
        """Whether the quantity is an angle; otherwise it is a length."""
        return self.kind == ANGLE


@dataclass(frozen=True)
class Input(PairRow):
    """The quantity that an actuator drives by its law, or that a gauge measures for a spring or a damper."""

    law: InputLaw = field(default=ConstantLaw(), repr=False)
    drawn: float = 0.0  # value at the drawn position (the coordinates of the file)


@dataclass(frozen=True)
class Coupling:
    """An actuator whose input is a linear function of others: phase + sum of ratio times input.

    The input may also follow quantities that no actuator drives, such as the angle of a rocker with a gear; they are
    read from the position.
    """

    follower: int  # number of the actuator
    terms: tuple[tuple[int, float], ...]  # (actuator, ratio); these actuators follow no others
    phase: float = 0.0  # rad, or length in the normal frame
    geared: bool = False  # the gears impose it; else the actuator of the file that follows
    reads: tuple[tuple[Input, float], ...] = ()  # (angle or travel that is read, ratio)


@dataclass(frozen=True)
class Point:
    """A point fixed to a member; its position follows from the member, so the solvers do not need it."""

    name: str
    member: int
    local: complex  # coordinates in the member's own frame


@dataclass(frozen=True)
class Dynamics:
    """The masses of a mechanism and everything that exerts forces on it."""

    metre: float | None = 1.0  # length of one unit of the normal frame in m; None: the file has no physical length unit
    inertias: tuple[Inertia, ...] = ()
    gravity: complex = 0.0j  # m/s^2
    loads: tuple[AppliedLoad, ...] = ()
    springs: tuple[SpringForce, ...] = ()
    dampers: tuple[DampingForce, ...] = ()
    frictions: tuple[Friction, ...] = ()
    releases: tuple[Release, ...] = ()  # of actuators in a simulation: driven by its law, or free (released)
    rotors: tuple[RotorInertia, ...] = ()

    @property
    def empty(self) -> bool:
        """Whether there are no masses, rotors, loads, springs, dampers or friction."""
        forces = (*self.loads, *self.springs, *self.dampers, *self.frictions)
        return not (forces or self.inertias or self.rotors)


class Machine(NamedTuple):
    """A part of a mechanism that moves independently of the others; they share the ground and the time."""

    name: str  # its inputs, such as "rocker" or "dx+dy"; its nodes if it has no input
    mechanism: Mechanism  # as if it were alone in the file, in a normal frame of its own
    nodes: tuple[int, ...]  # of the whole mechanism, in the order of its own
    actuators: tuple[int, ...]  # of the whole mechanism, in the order of its own


@dataclass(frozen=True, eq=False, repr=False)
class Mechanism:
    """A compiled model file: the data that all analyses use."""

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
    duration: float = 1.0  # s; the normalised time 1
    floating: bool = False  # no node is fixed to the ground: member 0 is a member of the file, taken as frame
    dynamics: Dynamics = field(default=Dynamics(), repr=False)
    gauges: tuple[Input, ...] = field(default=(), repr=False)  # quantities that springs and dampers measure
    couplings: tuple[Coupling, ...] = ()  # of actuators that follow others
    gears: tuple[GearPair, ...] = ()
    quantities: Mapping[str, str] = field(default_factory=dict, repr=False)  # expressions of the file, by name
    files: tuple[Path, ...] = field(default=(), repr=False, compare=False)  # its source files, never overwritten
    path: Path | None = field(default=None, repr=False, compare=False)  # of the model file, the first of `files`
    left_out: tuple[str, ...] = field(default=(), repr=False, compare=False)  # of another program's file: sentences
    complete: Callable[[Mechanism], Mechanism] | None = field(default=None, repr=False, compare=False)
    """Function that gives a changed mechanism the laws of inputs that follow its linkage; None: it has none."""
    written: Any = field(default=None, repr=False, compare=False)  # as written: gimcli.model.read.Written

    def __repr__(self) -> str:
        counts = (
            (len(self.nodes), "node"),
            (len(self.members) - 1, "moving member"),
            (len(self.actuators), "actuator"),
        )
        return f"Mechanism {self.name!r}: " + ", ".join(f"{n} {word}{'s' * (n != 1)}" for n, word in counts)

    def __eq__(self, other: object) -> bool:
        """Return whether both say the same: numbers, names, formulas and tables; comments and paths do not count."""
        if self is other or not isinstance(other, Mechanism):
            return self is other
        return self._contents() == other._contents()

    def __hash__(self) -> int:
        return hash((self.name, self.nodes, self.drawn.tobytes()))

    def _contents(self) -> list[bytes]:
        from gimcli.contents import contents

        said = replace(self, files=(), path=None, left_out=(), complete=None, written=None)
        return [*contents(said), *contents(self.written and self.written.model)]

    @cached_property
    def machines(self) -> tuple[Machine, ...]:
        """The independent machines; one, the mechanism itself, if there are not several."""
        return (self.as_machine,) if self.written is None else self.written.machines(self, structures=True)

    @cached_property
    def driven_machines(self) -> tuple[Machine, ...]:
        """The machines with inputs; parts that no input moves belong to the first one."""
        return self.machines if len(self.machines) == 1 else self.written.machines(self, structures=False)

    @cached_property
    def loaded_machines(self) -> tuple[Machine, ...]:
        """Those with masses and forces; springs, dampers, and loads over an input, join machines."""
        return self.machines if len(self.machines) == 1 else self.written.machines(self, True, loaded=True)

    @property
    def as_machine(self) -> Machine:
        """The mechanism as one machine."""
        inputs = "+".join(self.actuators[k].name for k in self.drivers)
        moving = sorted(name for k, name in enumerate(self.nodes) if k not in self.members[FRAME].nodes)
        return Machine(
            inputs or ", ".join(moving), self, tuple(range(len(self.nodes))), tuple(range(len(self.actuators)))
        )

    @cached_property
    def slides(self) -> tuple[PairRow, ...]:
        """The heights of nodes on guides: one for a pin in a slot, two for a true prismatic pair."""
        return tuple(row for row in self.pairs if row.kind == HEIGHT)

    @cached_property
    def remote(self) -> frozenset[int]:
        """The remote nodes: they do not change any result but their own positions."""
        return frozenset().union(*(member.remote for member in self.members))

    @cached_property
    def close(self) -> tuple[int, ...]:
        """The nodes that are not remote."""
        return tuple(k for k in range(len(self.nodes)) if k not in self.remote)

    @cached_property
    def carried(self) -> dict[int, tuple[int, int, complex]]:
        """For each carried remote node, the ends u, v of its member and the factor of u + factor (v - u)."""
        moving = ((member, *member.ends) for member in self.members[FRAME + 1 :])
        return {n: (u, v, member.reach(u, n) / span) for member, u, v, span in moving for n in member.carried}

    @cached_property
    def nearby(self) -> Mechanism:
        """The mechanism, with a node near the machine instead of each remote one that is the end of a member."""
        if not self._stretched:
            return self
        members = tuple(member.nearby for member in self.members)
        return replace(self, members=members, drawn=self.near(self.drawn))

    @cached_property
    def _stretched(self) -> tuple[Member, ...]:
        return tuple(member for member in self.members[FRAME + 1 :] if member.stretch != 1.0)

    def near(self, z: ComplexArray) -> ComplexArray:
        """Return positions or rates (nodes, ...) of `nearby` from those of the mechanism."""
        return self._stretch(z, -1)

    def whole(self, z: ComplexArray, axis: int = 0) -> ComplexArray:
        """Return positions or rates of the mechanism from those of `nearby`; nodes are along `axis`."""
        if not self.carried and not self._stretched:
            return z
        z = self._stretch(np.moveaxis(z, axis, 0).copy(), 1)
        for node, (u, v, factor) in self.carried.items():
            z[node] = z[u] + factor * (z[v] - z[u])
        return np.moveaxis(z, 0, axis)

    def apart(self, z: ComplexArray, other: ComplexArray) -> FloatArray:
        """Return the distances (nodes, ...) of two positions; of remote nodes, those of nodes near the machine or 0."""
        found = np.abs(self.near(z) - self.near(other))
        found[list(self.carried)] = 0.0
        return found

    def _stretch(self, z: ComplexArray, sense: int) -> ComplexArray:
        for member in self._stretched:
            u, v, _ = member.ends
            z = z.copy()
            z[v] = z[u] + (z[v] - z[u]) * member.stretch**sense
        return z

    @cached_property
    def centre(self) -> complex:
        """The mean of the fixed nodes that are not remote, normal frame."""
        fixed = self.members[FRAME]
        return complex(np.mean([z for n, z in zip(fixed.nodes, fixed.shape, strict=True) if n not in fixed.remote]))

    @cached_property
    def shortest(self) -> float:
        """The shortest distance between a member's first node and its others: relative errors refer to it."""
        spans = [abs(z - m.shape[0]) for m in self.members[1:] for z in m.shape[1:]]
        return float(nominal(min(spans, default=self.size)))

    @cached_property
    def drivers(self) -> tuple[int, ...]:
        """Numbers of the actuators that do not follow others: their inputs are independent."""
        followers = {coupling.follower for coupling in self.couplings}
        return tuple(k for k in range(len(self.actuators)) if k not in followers)

    @cached_property
    def geared(self) -> frozenset[int]:
        """Numbers of the followers that gears move, without an actuator of their own."""
        return frozenset(coupling.follower for coupling in self.couplings if coupling.geared)

    @cached_property
    def following(self) -> FloatArray:
        """The derivatives (actuators, drivers) of all inputs by those of the drivers."""
        table = np.eye(len(self.actuators))
        for coupling in self.couplings:
            table[coupling.follower] = 0.0
            for actuator, ratio in coupling.terms:
                table[coupling.follower, actuator] = ratio
        return table[:, list(self.drivers)]

    def coupled(self, inputs: FloatArray) -> FloatArray:
        """Return inputs (actuators, ...) in which the followers have the values that those of the drivers give."""
        found = np.array(inputs, dtype=float)
        for coupling in self.couplings:
            found[coupling.follower] = coupling.phase + sum(ratio * found[k] for k, ratio in coupling.terms)
        return found

    @property
    def drawn_inputs(self) -> FloatArray:
        """The inputs (actuators,) at the drawn position."""
        return np.array([a.drawn for a in self.actuators], dtype=float)

    @property
    def start_inputs(self) -> FloatArray:
        """The inputs (actuators,) at time 0 of the laws."""
        return np.array([float(a.law(np.zeros(1))[0]) for a in self.actuators])

    def with_(self, changes: Mapping[str, float | str]) -> Mechanism:
        """Return the mechanism with other dimensions, for example `m.with_({"crank.length": 42, "a": "2*b"})`.

        The same as an edit of these numbers in the model file, which is not changed. An assembly chosen with
        `assembled` is kept. Calls can be chained.

        Args:
            changes: numbers (file's units), or formulas as text, by the names of dimensions: parameters,
                `crank.length`, `B.x`, `motor.to` and the like.

        Returns:
            The mechanism.

        Raises:
            UsageError: an unknown name, or a value that is not a number.
            ModelError: the model does not allow these values.
        """
        if self.written is None:
            raise UsageError("the mechanism was not read from a model, so that its dimensions have no names")
        changed: Mechanism = self.written.changed(self, changes)
        return changed if self.complete is None else self.complete(changed)

    def to_file(self, z: ComplexArray) -> ComplexArray:
        """Convert positions from the normal frame to the file's coordinates and length unit."""
        return z * self.scale + self.origin

    def unit_of(self, value: Input) -> str:
        """Return the file's unit for the value of an actuator or a gauge."""
        return self.angle_unit if value.rotary else self.length_unit

    def value_to_file(self, actuator: int, value: FloatArray) -> FloatArray:
        """Convert values of an actuator (rad, or normal length) to the file's unit (deg or rad, or length)."""
        if self.actuators[actuator].rotary:
            return np.degrees(value) if self.angle_unit == "deg" else value
        return value * self.scale

    def inputs_to_file(self, inputs: FloatArray) -> dict[str, float]:
        """Return the inputs (actuators,) by actuator name, in the file's units."""
        return {a.name: float(self.value_to_file(k, inputs[k : k + 1])[0]) for k, a in enumerate(self.actuators)}

    def value_from_file(self, actuator: int, value: float) -> float:
        """Convert a value of an actuator from the file's unit to rad or to a length in the normal frame."""
        if self.actuators[actuator].rotary:
            return float(np.radians(value)) if self.angle_unit == "deg" else value
        return value / self.scale
