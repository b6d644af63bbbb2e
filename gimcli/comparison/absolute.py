"""Absolute coordinates: x, y and angle of every moving body; all pairs and drivers are equations.

Source: Fraczek & Wojtyra, lecture notes on multibody methods; Nikravesh 1988, chapter 4.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from gimcli.comparison.pairs import Bodies, BodyPair
from gimcli.comparison.stop import Stop
from gimcli.kernels import coordinates as kernels
from gimcli.mechanism import ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.positions.newton import Run

NO_JOINTS = np.zeros((0, 9), dtype=np.int64), np.zeros((0, 10)), np.zeros(0, dtype=np.int64)


class BodyCoordinates(Protocol):
    """Coordinates of bodies, with pairs as equations."""

    bodies: Bodies
    unknowns: int
    equations: int

    def weights(self, length: float) -> FloatArray:
        """Return what a correction of each unknown (unknowns,) is worth."""
        ...

    def start(self, z: ComplexArray) -> FloatArray:
        """Return the unknowns at a position z (nodes,)."""
        ...


class AbsoluteCoordinates:
    """A mechanism in absolute coordinates: three unknowns a body, two where it is a mere point."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.bodies = mechanism, Bodies(mechanism)
        sizes = [0] + [3 if self.bodies.turns(b) else 2 for b in range(1, self.bodies.count)]
        columns = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        self.layout = np.array([columns, [s == 3 for s in sizes]], dtype=np.int64).T.copy()  # bi of the kernel
        self.unknowns = sum(sizes)
        self.equations = sum(p.rows for p in self.bodies.pairs)

    def weights(self, length: float) -> FloatArray:
        """Return what a correction of each unknown (unknowns,) is worth: lengths by `length`, angles by 1."""
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
        """Follow inputs (actuators, rows) from a position (nodes,); return z, iterations and 1 where it settled."""
        return follow_bodies(self, inputs, start, stop, run, self.layout, self.bodies.pairs, NO_JOINTS)


def follow_bodies(
    system: BodyCoordinates, inputs: FloatArray, start: ComplexArray, stop: Stop, run: Run,
    layout: IntArray, pairs: list[BodyPair], joints: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> tuple[ComplexArray, FloatArray, FloatArray]:  # fmt: skip
    """Follow inputs by pairs between bodies and joints (ji, jz and above of the kernel); as `follow`."""
    bodies, rows = system.bodies, inputs.shape[1]
    pose, iterations, good = frame_poses(rows, bodies.count), np.zeros(rows), np.zeros(rows)
    run(kernels.follow_bodies)(
        system.start(start), np.ascontiguousarray(inputs.T), layout, *bodies.arrays(pairs), *joints,
        kernels.room(system.equations, system.unknowns), system.weights(stop.length), stop.tolerance,
        stop.iterations, pose, iterations, good,
    )  # fmt: skip
    return read_positions(bodies, pose), iterations, good


def frame_poses(rows: int, bodies: int) -> FloatArray:
    """Return room for poses (rows, bodies, 5), the frame's filled in."""
    pose = np.zeros((rows, bodies, 5))
    pose[:, :, 3] = 1.0
    return pose


def read_positions(bodies: Bodies, pose: FloatArray) -> ComplexArray:
    """Return nodes (nodes, rows) from poses (rows, bodies, 5)."""
    return bodies.positions(pose[:, :, 0] + 1j * pose[:, :, 1], pose[:, :, 3] + 1j * pose[:, :, 4])
