"""Gears in body coordinates: all multipliers, and tooth forces as pairs of forces along the line of action.

An independent formulation. A body has x and y of its centre of mass and an angle; body 0 is the frame. Pins are
equations between points of two bodies. A gear is an equation between angles, but its reaction is not its multiplier: it
is a force on one wheel and the opposite on the other, at the pitch point, along the line of action of the flanks that
touch. SI units.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass
class ToothedPair:
    """Wheels i and j turn about points a and b of body c; internal: one of them is a ring."""

    i: int
    j: int
    c: int
    a: complex
    b: complex
    radii: tuple[float, float]
    internal: bool = False
    angle: float = np.radians(20.0)

    @property
    def ratio(self):
        return (1.0 if self.internal else -1.0) * self.radii[0] / self.radii[1]


@dataclass
class GearedBodies:
    masses: list  # (mass, inertia) of bodies 1 ...
    pins: list  # (i, point of i, j, point of j), of the bodies' own frames
    gears: list
    gravity: complex = -9.81j
    torques: dict = field(default_factory=dict)  # by body

    def __post_init__(self):
        self.size = 3 * len(self.masses)
        self.inertia = np.array([x for mass, own in self.masses for x in (mass, mass, own)], dtype=float)

    def place(self, q, k, local):
        return local if k == 0 else q[3 * k - 3] + 1j * q[3 * k - 2] + np.exp(1j * q[3 * k - 1]) * local

    def push(self, q, k, at, force):
        """Return the generalised force of a force on body k at a place."""
        found = np.zeros(self.size)
        if k:
            arm = at - (q[3 * k - 3] + 1j * q[3 * k - 2])
            found[3 * k - 3 : 3 * k] = force.real, force.imag, (np.conj(arm) * force).imag
        return found

    def rows(self, q, v):
        """Return the gradients of all equations, pins first, and the terms of second order with their accelerations."""
        table, bias = [], []
        for i, a, j, b in self.pins:
            for axis in (1.0, 1j):
                table.append(self.push(q, j, self.place(q, j, b), axis) - self.push(q, i, self.place(q, i, a), axis))
            turning = 0.0j
            for k, local, sense in ((j, b, 1.0), (i, a, -1.0)):
                if k:
                    turning -= sense * v[3 * k - 1] ** 2 * np.exp(1j * q[3 * k - 1]) * local
            bias += [turning.real, turning.imag]
        for gear in self.gears:
            row = np.zeros(self.size + 1)  # the angle of the frame is the last one
            row[3 * gear.j - 1] += 1.0
            row[3 * gear.i - 1] -= gear.ratio
            row[3 * gear.c - 1] += gear.ratio - 1.0
            table.append(row[:-1])
            bias.append(0.0)
        return np.array(table), np.array(bias)

    def tooth(self, q, gear, side):
        """Return the generalised force of 1 N between the flanks; `side` is the sense of its couple on wheel j."""
        one, two = self.place(q, gear.c, gear.a), self.place(q, gear.c, gear.b)
        along = (two - one) / abs(two - one)
        first_inside = gear.internal and gear.radii[1] > gear.radii[0]
        pitch = one + (-1.0 if first_inside else 1.0) * gear.radii[0] * along
        normal = (two - pitch) / abs(two - pitch)  # from the pitch point to the centre of wheel j
        away = -normal if first_inside else normal  # the ring is pushed the other way
        line = np.cos(gear.angle) * side * -1j * normal + np.sin(gear.angle) * away
        return self.push(q, gear.j, pitch, line) - self.push(q, gear.i, pitch, line)

    def applied(self, q):
        found = np.zeros(self.size)
        for k, (mass, _) in enumerate(self.masses, 1):
            found += self.push(q, k, self.place(q, k, 0.0), mass * self.gravity)
        for k, torque in self.torques.items():
            found[3 * k - 1] += torque
        return found

    def forces(self, q, v, gain, driven):
        """Return pin forces (pins,) on the second bodies, tooth forces and the torque on body `driven`."""
        table, _ = self.rows(q, v)
        drive = np.zeros(self.size)
        drive[3 * driven - 1] = 1.0
        sides = np.ones(len(self.gears))
        for _ in range(4):
            teeth = [self.tooth(q, gear, side) for gear, side in zip(self.gears, sides, strict=True)]
            matrix = np.array([*table[: 2 * len(self.pins)], *teeth, drive]).T
            found = np.linalg.solve(matrix, self.inertia * gain - self.applied(q))
            tooth = found[2 * len(self.pins) : -1]
            if np.all(tooth >= 0.0):
                break
            sides = np.where(tooth < 0.0, -sides, sides)
        return found[0 : 2 * len(self.pins) : 2] + 1j * found[1 : 2 * len(self.pins) : 2], tooth * sides, found[-1]

    def accelerations(self, q, v):
        """Return the accelerations of the released bodies."""
        table, bias = self.rows(q, v)
        teeth = [self.tooth(q, gear, side) for gear in self.gears for side in (1.0,)]
        own, count = self.size, len(table)
        matrix = np.zeros((own + count, own + count))
        matrix[:own, :own], matrix[own:, :own] = np.diag(self.inertia), table
        matrix[:own, own:] = -np.array([*table[: 2 * len(self.pins)], *teeth]).T
        return np.linalg.solve(matrix, np.concatenate([self.applied(q), -bias]))[:own]
