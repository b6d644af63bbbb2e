"""A mechanism as rigid bodies, with pairs and drivers between two of them.

Body 0 is the frame. The bodies have the numbers of the members; a node without a member is a further body that does
not turn. A node in k members gives k - 1 revolute pairs, each with the first of these members.

In absolute coordinates the unknowns are x, y and angle of every moving body; each pair and driver gives equations.
Source: Fraczek & Wojtyra, lecture notes on multibody methods; Nikravesh 1988, chapter 4.
"""

from __future__ import annotations

import cmath
from abc import ABC, abstractmethod
from collections import Counter
from dataclasses import dataclass

import numpy as np

from gimcli.kernels import bodies as kernels, coordinates
from gimcli.mechanism import SPAN, ComplexArray, FloatArray, IntArray, Mechanism, PairRow
from gimcli.positions.newton import Run
from gimcli.structure.joints import REVOLUTE, bodies_at, joints, sliding_pairs
from gimcli.structure.kinematic_nodes import loose_nodes
from gimcli.structure.residual import pose
from gimcli.structure.steps import NONE

PARTS = {
    kernels.COINCIDENT: ("x", "y"), kernels.ON_LINE: ("line",), kernels.ANGLE: ("angle",),
    kernels.DISTANCE: ("distance",),
}  # fmt: skip
"""The scalar equations of each kind of pair."""


@dataclass(frozen=True)
class BodyPair:
    """One pair or driver between bodies a and b; points and directions in the coordinate systems of the bodies.

    ON_LINE: point za of body a is on a line of body b through zb; `normal` is normal to the line, or is
    the direction in which a travel is measured. ANGLE: the angle from b to a, minus `constant` [rad].
    """

    kind: int
    a: int
    b: int
    za: complex = 0.0j
    zb: complex = 0.0j
    normal: complex = 0.0j
    constant: float = 0.0
    actuator: int = NONE
    name: str = ""  # of the pair in the model file; the two slides of a true prismatic pair have the same name

    @property
    def rows(self) -> int:
        """Number of scalar equations."""
        return len(self.parts)

    @property
    def parts(self) -> tuple[str, ...]:
        """What each scalar equation is."""
        return PARTS[self.kind]

    @property
    def slides(self) -> bool:
        """Return whether it is a sliding pair, not a driver."""
        return self.kind == kernels.ON_LINE and self.actuator == NONE


class Bodies:
    """Bodies of a mechanism, the nodes in each body, and the pairs between bodies."""

    def __init__(self, mechanism: Mechanism, drivers: bool = True) -> None:
        """Derive the bodies and pairs; `drivers`: with those of the actuators."""
        self.mechanism = mechanism
        self.loose = loose_nodes(mechanism)
        self.count = len(mechanism.members) + len(self.loose)
        self.bodies_of = bodies_at(mechanism)
        rows = [
            *((row, NONE) for row in mechanism.pairs),
            *((a, k) for k, a in enumerate(mechanism.actuators) if drivers),
        ]
        self.pairs = [*self._revolutes(), *(self._row(*row) for row in rows)]

    def name(self, body: int) -> str:
        """Return the name of a body: that of its member or node."""
        members = self.mechanism.members
        return members[body].name if self.turns(body) else self.mechanism.nodes[self.loose[body - len(members)]]

    def equations(self, pairs: list[BodyPair]) -> list[str]:
        """Return the name of each scalar equation of some pairs: pair, bodies and part."""
        names = [f"{p.name} {self.name(p.a)}-{self.name(p.b)} {part}" for p in pairs for part in p.parts]
        count = Counter[str]()
        for k, one in enumerate(names):
            count[one] += 1
            names[k] = one if count[one] == 1 else f"{one} {count[one]}"
        return names

    def turns(self, body: int) -> bool:
        """Return whether a body has an angle; a body that is a single node has none."""
        return body < len(self.mechanism.members)

    def local(self, body: int, node: int) -> complex:
        """Return the position of a node in the coordinate system of a body."""
        return self.mechanism.members[body].local(node) if self.turns(body) else 0.0j

    def poses(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return origins and e^(i phi) of the bodies (bodies,) at a position z (nodes,)."""
        found = [pose(self.mechanism, k, z[:, None]) for k in range(len(self.mechanism.members))]
        origins = [complex(o[0]) for o, _ in found] + [complex(z[n]) for n in self.loose]
        return np.array(origins), np.array([complex(e[0]) for _, e in found] + [1.0 + 0.0j] * len(self.loose))

    def positions(self, poses: ComplexArray, turns: ComplexArray) -> ComplexArray:
        """Return the positions (nodes, rows) of nodes from origins and e^(i phi), each (rows, bodies)."""
        first = [bodies[0] for bodies in self.bodies_of]
        local = np.array([self.local(body, node) for node, body in enumerate(first)])
        return np.asarray((poses[:, first] + turns[:, first] * local).T)

    def arrays(self, pairs: list[BodyPair]) -> tuple[np.ndarray, np.ndarray]:
        """Return pairs as the arrays pi, pz of the kernels."""
        heads = [(p.kind, p.a, p.b, p.actuator) for p in pairs]
        parts = [(p.za.real, p.za.imag, p.zb.real, p.zb.imag, p.normal.real, p.normal.imag, p.constant) for p in pairs]
        return np.array(heads, dtype=np.int64).reshape(-1, 4), np.array(parts, dtype=float).reshape(-1, 7)

    def _body_of(self, node: int, other: int = NONE) -> int:
        return next(b for b in self.bodies_of[node] if b != other)

    def _revolutes(self) -> list[BodyPair]:
        hinges = [joint for joint in joints(self.mechanism) if joint.kind == REVOLUTE]
        return [
            BodyPair(kernels.COINCIDENT, k, first, self.local(k, one.node), self.local(first, one.node), name=one.name)
            for one in hinges for first in one.bodies[:1] for k in one.bodies[1:]
        ]  # fmt: skip

    def _row(self, row: PairRow, actuator: int) -> BodyPair:
        """Return the pair between two bodies for a row of a pair, or of an actuator given by its number."""
        if row.rotary:
            turn = cmath.phase(row.reference) - cmath.phase(row.arm)
            return BodyPair(kernels.ANGLE, row.members[0], row.guide, constant=turn, actuator=actuator, name=row.pair)
        if row.kind == SPAN:
            p, q = row.nodes
            first = self._body_of(p)
            second = next((b for b in self.bodies_of[q] if b != first), self.bodies_of[q][0])
            at = self.local(second, q), self.local(first, p)
            return BodyPair(kernels.DISTANCE, second, first, *at, actuator=actuator, name=row.pair)
        sliding = (pair.bodies[1] for pair in sliding_pairs(self.mechanism) if pair.name == row.pair)
        body = next(sliding, self._body_of(row.node, row.guide))
        at = self.local(body, row.node), row.point
        return BodyPair(kernels.ON_LINE, body, row.guide, *at, row.normal, actuator=actuator, name=row.pair)


class BodyCoordinates(ABC):
    """Coordinates of rigid bodies; some pairs between them are the equations."""

    unknowns: int
    layout: IntArray  # bi of the kernel
    equated: list[BodyPair]  # the pairs that are equations
    joints = np.zeros((0, 9), dtype=np.int64), np.zeros((0, 10)), np.zeros(0, dtype=np.int64)
    """Joints of a tree as ji, jz and above of the kernel: by default there are none."""

    def __init__(self, mechanism: Mechanism, drivers: bool = True) -> None:
        self.mechanism, self.bodies = mechanism, Bodies(mechanism, drivers)

    @abstractmethod
    def weights(self, length: float) -> FloatArray:
        """Return the weights (unknowns,) of the corrections in the stopping test: 1 / `length` for lengths."""

    @abstractmethod
    def start(self, z: ComplexArray) -> FloatArray:
        """Return the unknowns at a position z (nodes,)."""

    @property
    def equations(self) -> int:
        """Number of equations."""
        return sum(pair.rows for pair in self.equated)

    @property
    def arrays(self) -> tuple[IntArray, IntArray, FloatArray, IntArray, FloatArray, IntArray]:
        """The layout of the unknowns, the equations and the joints in the arrays of the kernels."""
        return self.layout, *self.bodies.arrays(self.equated), *self.joints

    def follow(
        self, inputs: FloatArray, start: ComplexArray, tolerance: float, length: float, most: int, run: Run
    ) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """Solve inputs (actuators, rows) from a position (nodes,); return z, iterations and 1 for converged rows.

        A row ends when no correction exceeds `tolerance` (angles in rad, lengths relative to `length`), or after `most`
        iterations.
        """
        rows, room = inputs.shape[1], coordinates.room(self.equations, self.unknowns)
        pose, iterations, good = frame_poses(rows, self.bodies.count), np.zeros(rows), np.zeros(rows)
        run(coordinates.follow_bodies)(
            self.start(start), np.ascontiguousarray(inputs.T), *self.arrays, room, self.weights(length), tolerance,
            most, pose, iterations, good,
        )  # fmt: skip
        z = self.bodies.positions(pose[:, :, 0] + 1j * pose[:, :, 1], pose[:, :, 3] + 1j * pose[:, :, 4])
        return z, iterations, good

    def jacobian(self, z: ComplexArray) -> FloatArray:
        """Return the Jacobian (equations, unknowns) at positions z (nodes,)."""
        pose, room = frame_poses(1, self.bodies.count), coordinates.room(self.equations, self.unknowns)
        coordinates.gradients(self.start(z), np.zeros(len(self.mechanism.actuators)), *self.arrays, room, pose[0])
        return room.j


class AbsoluteCoordinates(BodyCoordinates):
    """A mechanism in absolute coordinates: three unknowns per body, two for a body that is a point."""

    def __init__(self, mechanism: Mechanism, drivers: bool = True) -> None:
        super().__init__(mechanism, drivers)
        sizes = [0] + [3 if self.bodies.turns(b) else 2 for b in range(1, self.bodies.count)]
        columns = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        self.layout = np.array([columns, [s == 3 for s in sizes]], dtype=np.int64).T.copy()
        self.unknowns, self.equated = sum(sizes), self.bodies.pairs

    @property
    def names(self) -> list[tuple[str, bool]]:
        """The unknowns, and whether each is an angle."""
        bodies = ((self.bodies.name(b), turns) for b, (_, turns) in enumerate(self.layout.tolist()) if b)
        parts = ("x", "y", "angle")
        return [(f"{name}.{part}", part == "angle") for name, turns in bodies for part in parts[: 2 + turns]]

    def weights(self, length: float) -> FloatArray:
        """Return the weights (unknowns,) of the corrections: 1 / `length` for coordinates, 1 for angles [rad]."""
        parts = [[1.0 / length] * 2 + [1.0] * int(turns) for _, turns in self.layout[1:]]
        return np.array([w for part in parts for w in part], dtype=float)

    def start(self, z: ComplexArray) -> FloatArray:
        """Return the unknowns at a position z (nodes,)."""
        origins, turns = self.bodies.poses(z)
        q = np.zeros(self.unknowns)
        for (column, turning), o, e in zip(self.layout[1:], origins[1:], turns[1:], strict=True):
            q[column : column + 2 + turning] = [o.real, o.imag, np.angle(e)][: 2 + turning]
        return q


def frame_poses(rows: int, bodies: int) -> FloatArray:
    """Return an array for poses (rows, bodies, 5): x, y, angle, cosine, sine of each body; cosines are 1."""
    pose = np.zeros((rows, bodies, 5))
    pose[:, :, 3] = 1.0
    return pose
