"""Absolute coordinates: x, y and angle of every moving body; each pair and driver gives equations.

Source: Fraczek & Wojtyra, lecture notes on multibody methods; Nikravesh 1988, chapter 4.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from gimcli.comparison.pairs import Bodies, BodyPair, Stop
from gimcli.kernels import coordinates as kernels
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.positions.newton import Run

NO_JOINTS = np.zeros((0, 9), dtype=np.int64), np.zeros((0, 10)), np.zeros(0, dtype=np.int64)
"""Empty ji, jz and above of the kernel: absolute coordinates use no tree of joints."""


class BodyCoordinates(Protocol):
    """Coordinates of rigid bodies; the pairs between them are the equations."""

    bodies: Bodies
    unknowns: int
    equations: int

    def weights(self, length: float) -> FloatArray:
        """Return the weights (unknowns,) of the corrections in the stopping test."""

    def start(self, z: ComplexArray) -> FloatArray:
        """Return the unknowns at a position z (nodes,)."""


class AbsoluteCoordinates:
    """A mechanism in absolute coordinates: three unknowns per body, two for a body that is a point."""

    def __init__(self, mechanism: Mechanism, drivers: bool = True) -> None:
        self.mechanism, self.bodies = mechanism, Bodies(mechanism, drivers)
        sizes = [0] + [3 if self.bodies.turns(b) else 2 for b in range(1, self.bodies.count)]
        columns = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        self.layout = np.array([columns, [s == 3 for s in sizes]], dtype=np.int64).T.copy()  # bi of the kernel
        self.unknowns = sum(sizes)
        self.equations = sum(p.rows for p in self.bodies.pairs)

    @property
    def names(self) -> list[tuple[str, bool]]:
        """The unknowns, and whether each is an angle."""
        bodies = ((self.bodies.name(b), turns) for b, (_, turns) in enumerate(self.layout.tolist()) if b)
        parts = ("x", "y", "angle")
        return [(f"{name}.{part}", part == "angle") for name, turns in bodies for part in parts[: 2 + turns]]

    def jacobian(self, z: ComplexArray) -> tuple[list[BodyPair], FloatArray]:
        """Return the pairs that are equations, and their Jacobian at positions z (nodes,)."""
        return self.bodies.pairs, jacobian(self, z, self.layout, self.bodies.pairs, NO_JOINTS)

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

    def follow(
        self, inputs: FloatArray, start: ComplexArray, stop: Stop, run: Run
    ) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """Solve inputs (actuators, rows) from a position (nodes,); return z, iterations and 1 for converged rows."""
        return follow_bodies(self, inputs, start, stop, run, self.layout, self.bodies.pairs, NO_JOINTS)


def follow_bodies(
    system: BodyCoordinates, inputs: FloatArray, start: ComplexArray, stop: Stop, run: Run,
    layout: IntArray, pairs: list[BodyPair], joints: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> tuple[ComplexArray, FloatArray, FloatArray]:  # fmt: skip
    """Solve a motion with `pairs` as equations and `joints` (ji, jz, above of the kernel) as tree; see `follow`."""
    bodies, rows = system.bodies, inputs.shape[1]
    pose, iterations, good = frame_poses(rows, bodies.count), np.zeros(rows), np.zeros(rows)
    run(kernels.follow_bodies)(
        system.start(start), np.ascontiguousarray(inputs.T), layout, *bodies.arrays(pairs), *joints,
        kernels.room(system.equations, system.unknowns), system.weights(stop.length), stop.tolerance,
        stop.iterations, pose, iterations, good,
    )  # fmt: skip
    z = bodies.positions(pose[:, :, 0] + 1j * pose[:, :, 1], pose[:, :, 3] + 1j * pose[:, :, 4])
    return z, iterations, good


def jacobian(
    system: BodyCoordinates, z: ComplexArray, layout: IntArray, pairs: list[BodyPair],
    joints: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> FloatArray:  # fmt: skip
    """Return the Jacobian (equations, unknowns) at positions z (nodes,); arguments as of `follow_bodies`."""
    pose, room = frame_poses(1, system.bodies.count), kernels.room(system.equations, system.unknowns)
    values = np.zeros(len(system.bodies.mechanism.actuators))
    kernels.gradients(system.start(z), values, layout, *system.bodies.arrays(pairs), *joints, room, pose[0])
    return room.j


def frame_poses(rows: int, bodies: int) -> FloatArray:
    """Return an array for poses (rows, bodies, 5): x, y, angle, cosine, sine of each body; cosines are 1."""
    pose = np.zeros((rows, bodies, 5))
    pose[:, :, 3] = 1.0
    return pose
