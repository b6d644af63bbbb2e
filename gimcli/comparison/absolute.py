"""Absolute coordinates: x, y and angle of every moving body; each pair and driver gives equations.

Source: Fraczek & Wojtyra, lecture notes on multibody methods; Nikravesh 1988, chapter 4.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from gimcli.comparison.pairs import Bodies, BodyPair, Stop
from gimcli.kernels import coordinates as kernels
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.positions.newton import Run


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
        self, inputs: FloatArray, start: ComplexArray, stop: Stop, run: Run
    ) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """Solve inputs (actuators, rows) from a position (nodes,); return z, iterations and 1 for converged rows."""
        rows, room = inputs.shape[1], kernels.room(self.equations, self.unknowns)
        pose, iterations, good = frame_poses(rows, self.bodies.count), np.zeros(rows), np.zeros(rows)
        run(kernels.follow_bodies)(
            self.start(start), np.ascontiguousarray(inputs.T), *self.arrays, room, self.weights(stop.length),
            stop.tolerance, stop.iterations, pose, iterations, good,
        )  # fmt: skip
        z = self.bodies.positions(pose[:, :, 0] + 1j * pose[:, :, 1], pose[:, :, 3] + 1j * pose[:, :, 4])
        return z, iterations, good

    def jacobian(self, z: ComplexArray) -> FloatArray:
        """Return the Jacobian (equations, unknowns) at positions z (nodes,)."""
        pose, room = frame_poses(1, self.bodies.count), kernels.room(self.equations, self.unknowns)
        kernels.gradients(self.start(z), np.zeros(len(self.mechanism.actuators)), *self.arrays, room, pose[0])
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
